//! Images on a surface: PNG and JPEG to texels.

use std::io::Cursor;

use glam::Vec3;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use crate::color::to_linear;

/// How an image goes on beyond its borders, along its rows or its columns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// It begins anew.
    #[default]
    Repeat,
    /// It begins anew the other way round.
    Mirror,
    /// As it is at the border.
    Clamp,
}

/// Texels of 8 bits a channel, rows from the top.
#[derive(Clone)]
pub(crate) struct Image {
    width: usize,
    height: usize,
    rgb: Vec<[u8; 3]>,
    /// For each texel how little is seen through it, if anything is anywhere.
    alpha: Option<Vec<u8>>,
}

impl std::fmt::Debug for Image {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { width, height, .. } = self;
        write!(f, "Image({width} x {height})")
    }
}

/// What an image is decoded for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Wanted {
    Colors,
    Mask,
    Opacity,
}

/// Texels of the largest image that is read.
const MOST_TEXELS: usize = 1 << 28;

impl Image {
    pub(crate) fn decode(bytes: &[u8]) -> Result<Self, String> {
        Self::decode_as(bytes, Wanted::Colors)
    }

    /// The same of an image that must be whole, and is black where it is transparent.
    pub(crate) fn decode_mask(bytes: &[u8]) -> Result<Self, String> {
        Self::decode_as(bytes, Wanted::Mask)
    }

    /// The same without its colours, of which nothing is to be asked.
    pub(crate) fn decode_opacity(bytes: &[u8]) -> Result<Self, String> {
        Self::decode_as(bytes, Wanted::Opacity)
    }

    fn decode_as(bytes: &[u8], wanted: Wanted) -> Result<Self, String> {
        match bytes {
            [0x89, b'P', b'N', b'G', ..] => png(bytes, wanted),
            [0xff, 0xd8, ..] => jpeg(bytes, wanted),
            _ => Err("it is neither PNG nor JPEG; save it as one of them".into()),
        }
    }

    /// The least number of a texel.
    pub(crate) fn least(&self) -> f32 {
        let least = self.rgb.as_flattened().iter().min();
        f32::from(least.copied().unwrap_or(0)) / 255.0
    }

    /// Texels along the longer side.
    pub(crate) fn longer_side(&self) -> usize {
        self.width.max(self.height)
    }

    /// The mean of all texels as numbers from 0 to 1.
    pub(crate) fn mean(&self) -> Vec3 {
        let sum = self.rgb.iter().fold([0u64; 3], |sum, texel| {
            [0, 1, 2].map(|k| sum[k] + u64::from(texel[k]))
        });
        Vec3::from(sum.map(|x| x as f32)) / (255.0 * self.rgb.len() as f32)
    }

    /// The least opacity of a texel.
    pub(crate) fn least_opacity(&self) -> f32 {
        let least = self.alpha.iter().flatten().min();
        f32::from(least.copied().unwrap_or(255)) / 255.0
    }

    /// Linear light at a place from (0, 0), the upper left corner, to (1, 1), and repeated beyond.
    pub(crate) fn color(&self, uv: [f64; 2]) -> Vec3 {
        self.bilinear(uv, |rgb| Vec3::from_array(rgb.map(to_linear)))
    }

    /// The same as numbers from 0 to 1.
    pub(crate) fn values(&self, uv: [f64; 2]) -> Vec3 {
        self.bilinear(uv, |rgb| {
            Vec3::from_array(rgb.map(|byte| f32::from(byte) / 255.0))
        })
    }

    /// A place where [`color`](Self::color) and [`values`](Self::values), which repeat the image, say what it is there
    /// when it goes on otherwise. Between its outermost texels and what they go on with nothing changes.
    pub(crate) fn wrapped(&self, place: [f64; 2], wrap: [Wrap; 2]) -> [f64; 2] {
        let along = |(x, size, wrap): (f64, usize, Wrap)| {
            let within = match wrap {
                Wrap::Repeat => return x,
                Wrap::Clamp => x,
                Wrap::Mirror => 1.0 - (x.rem_euclid(2.0) - 1.0).abs(),
            };
            let half = 0.5 / size as f64;
            within.clamp(half, 1.0 - half)
        };
        let ([u, v], [across, down]) = (place, wrap);
        [(u, self.width, across), (v, self.height, down)].map(along)
    }

    /// How little is seen through it at a place, as [`color`](Self::color) takes it: 1 for nothing.
    pub(crate) fn opacity(&self, uv: [f64; 2]) -> f32 {
        self.alpha.as_ref().map_or(1.0, |alpha| {
            let opacity = |texel: usize| Vec3::splat(f32::from(alpha[texel]) / 255.0);
            self.between(uv, opacity).x
        })
    }

    fn bilinear(&self, uv: [f64; 2], of: impl Fn([u8; 3]) -> Vec3) -> Vec3 {
        self.between(uv, |texel| of(self.rgb[texel]))
    }

    /// What is between texels.
    fn between(&self, [u, v]: [f64; 2], of: impl Fn(usize) -> Vec3) -> Vec3 {
        // What is too large to be told from one image to the next is anywhere.
        let within = |x: f64| {
            if x.is_finite() {
                x.rem_euclid(1.0)
            } else {
                0.0
            }
        };
        let (x, y) = (
            within(u) * self.width as f64 - 0.5,
            within(v) * self.height as f64 - 0.5,
        );
        let (left, top) = (x.floor(), y.floor());
        let at = |dx: i64, dy: i64| {
            let column = (left as i64)
                .saturating_add(dx)
                .rem_euclid(self.width as i64);
            let row = (top as i64)
                .saturating_add(dy)
                .rem_euclid(self.height as i64);
            of(row as usize * self.width + column as usize)
        };
        let (across, down) = ((x - left) as f32, (y - top) as f32);
        let upper = at(0, 0).lerp(at(1, 0), across);
        upper.lerp(at(0, 1).lerp(at(1, 1), across), down)
    }
}

/// Pixels along a side of a JPEG image, at most.
const MOST_WIDE: usize = u16::MAX as usize;

fn damaged() -> String {
    "it is damaged, or of a kind that is not read; save it anew, as plain PNG or JPEG".to_owned()
}

fn check_size([width, height]: [usize; 2]) -> Result<(), String> {
    match width.checked_mul(height) {
        Some(texels) if texels <= MOST_TEXELS => Ok(()),
        _ => Err(format!(
            "it has {width} x {height} texels, and {MOST_TEXELS} is the most; make it smaller"
        )),
    }
}

fn png(bytes: &[u8], wanted: Wanted) -> Result<Image, String> {
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(|_| damaged())?;
    let (width, height) = reader.info().size();
    check_size([width, height].map(|side| side as usize))?;
    let length = reader.output_buffer_size().ok_or_else(damaged)?;
    let mut raw = vec![0; length];
    let info = reader.next_frame(&mut raw).map_err(|_| damaged())?;
    let channels = info.color_type.samples();
    let [width, height] = [info.width, info.height].map(|side| side as usize);
    if width * height == 0 || info.buffer_size() != width * height * channels {
        return Err(damaged());
    }
    let over_black = |x: u8, alpha: u8| match wanted {
        Wanted::Mask => (u16::from(x) * u16::from(alpha) / 255) as u8,
        _ => x,
    };
    let texel = |texel: &[u8]| match *texel {
        [r, g, b, alpha] => [r, g, b].map(|x| over_black(x, alpha)),
        [grey, alpha] => [over_black(grey, alpha); 3],
        [r, g, b, ..] => [r, g, b],
        [grey, ..] => [grey; 3],
        [] => [0; 3],
    };
    let texels = || raw[..info.buffer_size()].chunks_exact(channels);
    let alpha = |texel: &[u8]| texel.get(channels - 1).copied().unwrap_or(255);
    let is_seen_through = channels.is_multiple_of(2) && texels().any(|texel| alpha(texel) < 255);
    Ok(Image {
        width,
        height,
        rgb: match wanted {
            Wanted::Opacity => Vec::new(),
            _ => texels().map(texel).collect(),
        },
        alpha: is_seen_through.then(|| texels().map(alpha).collect()),
    })
}

/// Whether what a JPEG shows goes on to its end, after which there may be anything: the data of its last scan, in which
/// neither of these marks can be.
fn is_whole(jpeg: &[u8]) -> bool {
    let [scan, end] = [b"\xff\xda", b"\xff\xd9"].map(|mark| memchr::memmem::rfind(jpeg, mark));
    scan < end
}

fn jpeg(bytes: &[u8], wanted: Wanted) -> Result<Image, String> {
    // Without the processor's own instructions, whose rounding may differ.
    let options = DecoderOptions::new_safe()
        .jpeg_set_out_colorspace(ColorSpace::RGB)
        .set_max_width(MOST_WIDE)
        .set_max_height(MOST_WIDE)
        .set_strict_mode(wanted == Wanted::Mask || !is_whole(bytes));
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(|_| damaged())?;
    let (width, height) = decoder.dimensions().ok_or_else(damaged)?;
    check_size([width, height])?;
    let raw = decoder.decode().map_err(|_| damaged())?;
    let rgb = raw.as_chunks().0;
    if rgb.is_empty() || rgb.len() != width * height {
        return Err(damaged());
    }
    Ok(Image {
        width,
        height,
        rgb: match wanted {
            Wanted::Opacity => Vec::new(),
            _ => rgb.to_vec(),
        },
        alpha: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of four texels of 0 to 3, at a place in their row, when they go on as this says.
    fn red(u: f64, wrap: Wrap) -> f32 {
        let image = Image {
            width: 4,
            height: 1,
            rgb: [0, 85, 170, 255].map(|grey| [grey; 3]).to_vec(),
            alpha: None,
        };
        let place = image.wrapped([u, 0.5], [wrap, Wrap::Repeat]);
        (3.0 * image.values(place).x * 16.0).round() / 16.0
    }

    #[test]
    fn images_go_on_beyond_their_borders() {
        for (u, repeated, mirrored, clamped) in [
            (0.125, 0.0, 0.0, 0.0),
            (0.25, 0.5, 0.5, 0.5),
            (0.0, 1.5, 0.0, 0.0),
            (1.0, 1.5, 3.0, 3.0),
            (1.125, 0.0, 3.0, 3.0),
            (1.375, 1.0, 2.0, 3.0),
            (2.125, 0.0, 0.0, 3.0),
            (-0.375, 2.0, 1.0, 0.0),
            (-1.125, 3.0, 3.0, 0.0),
        ] {
            let found = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp].map(|wrap| red(u, wrap));
            assert_eq!(found, [repeated, mirrored, clamped], "{u}");
        }
    }

    #[test]
    fn a_jpeg_that_is_cut_short_is_refused_and_one_with_more_behind_it_read() {
        let mut whole = Vec::new();
        let grey: Vec<u8> = (0..64 * 64).map(|i| (i % 251) as u8).collect();
        let encoder = jpeg_encoder::Encoder::new(&mut whole, 90);
        let encoded = encoder.encode(&grey, 64, 64, jpeg_encoder::ColorType::Luma);
        encoded.expect("an image");
        let with_more = [whole.as_slice(), b"\0\0 of a camera"].concat();
        let most = whole.len();
        for wanted in [Wanted::Colors, Wanted::Opacity] {
            for sound in [&whole, &with_more] {
                assert!(Image::decode_as(sound, wanted).is_ok());
            }
            for cut in [most / 4, most / 2, most - 100] {
                assert!(
                    Image::decode_as(&whole[..cut], wanted).is_err(),
                    "{cut} of {most}"
                );
            }
        }
    }

    #[test]
    fn masks_are_black_where_they_are_transparent() {
        let mut bytes = Vec::new();
        let mut encoder = ::png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(::png::ColorType::GrayscaleAlpha);
        let mut writer = encoder.write_header().expect("a header");
        writer
            .write_image_data(&[255, 0, 200, 128])
            .expect("texels");
        writer.finish().expect("an image");
        let texels = |image: Result<Image, String>| image.expect("an image").rgb;
        assert_eq!(texels(Image::decode(&bytes)), [[255; 3], [200; 3]]);
        assert_eq!(texels(Image::decode_mask(&bytes)), [[0; 3], [100; 3]]);
        let opacity = Image::decode_opacity(&bytes).expect("an image");
        assert_eq!(opacity.alpha, Some(vec![0, 128]));
        assert!(opacity.rgb.is_empty() && opacity.least_opacity() == 0.0);
    }
}
