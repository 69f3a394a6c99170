//! Pictures one after the other as an animated GIF, which repeats for ever.
//!
//! All have one palette, so that what stands still stays the same, and each holds only what has changed since the
//! one before.

use std::io::{self, Write};

use color_quant::NeuQuant;
use gif::{AnyExtension, Encoder, EncodingError, Extension, Frame, Repeat};

use super::Image;
use super::image::SOFTWARE;
use crate::color::{from_oklab, to_byte, to_oklab};

/// The colours of an animated GIF.
pub struct GifPalette(NeuQuant);

impl std::fmt::Debug for GifPalette {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("GifPalette").finish_non_exhaustive()
    }
}

/// Colours of a palette: one less than a byte can name, which stands for what has not changed.
const COLORS: usize = 255;
const UNCHANGED: u8 = COLORS as u8;

/// Pixels that change, and a third of those that do not, that a palette is chosen by.
const SAMPLE: usize = 1 << 14;

/// How thoroughly: all of these pixels are taken.
const SPEED: i32 = 1;

impl GifPalette {
    /// The palette for a film that begins and ends with these pictures of one size. What changes between them has about
    /// a quarter of the colours, however small it is.
    ///
    /// # Panics
    /// When their sizes differ.
    pub fn new(first: &Image, last: &Image) -> Self {
        let size = |image: &Image| [image.width, image.height];
        assert_eq!(size(first), size(last), "one size");
        let (mut changing, mut still) = (Vec::new(), Vec::new());
        for (a, b) in std::iter::zip(pixels(first), pixels(last)) {
            match a == b {
                true => still.push(*a),
                false => changing.extend([*a, *b]),
            }
        }
        let samples = spread(&still, 3 * SAMPLE).chain(spread(&changing, SAMPLE));
        let samples: Vec<u8> = samples.flat_map(to_scale).collect();
        Self(NeuQuant::new(SPEED, COLORS, &samples))
    }

    /// The number of the colour that is nearest.
    fn nearest(&self, color: [u8; 3]) -> u8 {
        self.0.index_of(&to_scale(color)) as u8
    }

    /// sRGB.
    fn colors(&self) -> impl Iterator<Item = u8> {
        let scaled = self.0.color_map_rgba();
        let color = |scaled: &[u8; 4]| from_scale(*scaled).map(to_byte);
        let colors: Vec<_> = scaled.as_chunks().0.iter().map(color).collect();
        colors.into_iter().flatten()
    }
}

/// Of lightness and of the other two numbers of Oklab, times 255: in sRGB, stone takes all shades of grey, and
/// none are left for its slight hues.
const SCALE: [f32; 3] = [1.0, 1.6, 1.6];

/// Where a colour without hue lies.
const GREY: f32 = 128.0;

/// An sRGB colour as distances are measured, and opaque.
fn to_scale(color: [u8; 3]) -> [u8; 4] {
    let [l, a, b] = std::array::from_fn(|k| 255.0 * SCALE[k] * to_oklab(color)[k]);
    [l, GREY + a, GREY + b, 255.0].map(|x: f32| x.round() as u8)
}

/// Linear light.
fn from_scale([l, a, b, _]: [u8; 4]) -> [f32; 3] {
    let scaled = [f32::from(l), f32::from(a) - GREY, f32::from(b) - GREY];
    from_oklab([0, 1, 2].map(|k| scaled[k] / (255.0 * SCALE[k])))
}

fn pixels(image: &Image) -> &[[u8; 3]] {
    image.rgb.as_chunks().0
}

/// So many of a list, evenly; several times the same where there are fewer, none where there are none.
fn spread(colors: &[[u8; 3]], many: usize) -> impl Iterator<Item = [u8; 3]> {
    let many = if colors.is_empty() { 0 } else { many };
    (0..many).map(move |i| colors[i * colors.len() / many])
}

/// An animated GIF that is being written.
pub struct GifWriter<W: Write> {
    encoder: Encoder<W>,
    size: [u16; 2],
    fps: f64,
    frames: u32,
}

impl<W: Write> std::fmt::Debug for GifWriter<W> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("GifWriter")
            .field("size", &self.size)
            .field("fps", &self.fps)
            .field("frames", &self.frames)
            .finish_non_exhaustive()
    }
}

/// The most pictures a second. Browsers show one for two hundredths of a second at least, and take less
/// for ten.
pub const FASTEST_GIF: f64 = 50.0;

impl<W: Write> GifWriter<W> {
    /// Begins a GIF of pictures of this width and height in the colours of a palette, at so many a second, as near as
    /// hundredths of a second come to it; at [`FASTEST_GIF`] where more are asked for.
    ///
    /// # Errors
    /// `InvalidInput` when a side is 0 or beyond 65,535, or when `fps` is not a positive number; those of `out`.
    pub fn new(
        out: W,
        [width, height]: [u32; 2],
        fps: f64,
        palette: &GifPalette,
    ) -> io::Result<Self> {
        let side = |n: u32| u16::try_from(n).ok().filter(|n| *n > 0);
        let (Some(w), Some(h)) = (side(width), side(height)) else {
            let problem = "a GIF is 1 to 65535 pixels wide and high";
            return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
        };
        if fps.is_nan() || fps <= 0.0 {
            let problem = "pictures a second are a positive number";
            return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
        }
        let colors: Vec<u8> = palette.colors().chain([0; 3]).collect();
        let mut encoder = Encoder::new(out, w, h, &colors).map_err(from_encoding)?;
        encoder
            .set_repeat(Repeat::Infinite)
            .map_err(from_encoding)?;
        let comment = AnyExtension::from(Extension::Comment);
        let said = encoder.write_raw_extension(comment, &[SOFTWARE.as_bytes()]);
        said.map_err(from_encoding)?;
        Ok(Self {
            encoder,
            size: [w, h],
            fps: fps.min(FASTEST_GIF),
            frames: 0,
        })
    }

    /// The next picture, from a [`GifPacker`] of the same palette.
    ///
    /// # Errors
    /// Those of the output.
    ///
    /// # Panics
    /// When it has another size.
    pub fn add(&mut self, GifPicture { mut frame, size }: GifPicture) -> io::Result<()> {
        assert_eq!(size, self.size, "one size");
        // Hundredths that are lost to one frame go to the next.
        let at = |frame: u32| (100.0 * f64::from(frame) / self.fps).round();
        frame.delay = (at(self.frames + 1) - at(self.frames)) as u16;
        self.frames += 1;
        let written = self.encoder.write_lzw_pre_encoded_frame(&frame);
        written.map_err(from_encoding)
    }
}

/// A picture of an animated GIF, its colours found and packed: nearly all of the work.
pub struct GifPicture {
    frame: Frame<'static>,
    /// Of the whole picture.
    size: [u16; 2],
}

impl std::fmt::Debug for GifPicture {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("GifPicture").field(&self.size).finish()
    }
}

/// Packs the pictures of an animated GIF, one after the other.
#[derive(Debug)]
pub struct GifPacker<'a> {
    palette: &'a GifPalette,
    /// The last picture, and the numbers of its colours.
    shown: Option<(Image, Vec<u8>)>,
}

impl<'a> GifPacker<'a> {
    /// Packs pictures in the colours of a palette.
    pub fn new(palette: &'a GifPalette) -> Self {
        Self {
            palette,
            shown: None,
        }
    }

    /// Packs the next picture.
    ///
    /// # Panics
    /// When a side is beyond 65,535, when the picture has not the size of the one before, or when its public fields
    /// disagree.
    pub fn pack(&mut self, image: &Image) -> GifPicture {
        let [width, height] =
            [image.width, image.height].map(|side| u16::try_from(side).expect("a side of a GIF"));
        let colors = self.colors(image);
        let before = self.shown.take().map(|(_, colors)| colors);
        let mut frame = frame(&colors, before.as_deref(), width.into());
        frame.make_lzw_pre_encoded();
        self.shown = Some((image.clone(), colors));
        GifPicture {
            frame,
            size: [width, height],
        }
    }

    /// The numbers of a picture's colours: those of the one before where nothing has changed.
    fn colors(&self, image: &Image) -> Vec<u8> {
        let nearest = |color: &[u8; 3]| self.palette.nearest(*color);
        let Some((before, colors)) = &self.shown else {
            return pixels(image).iter().map(nearest).collect();
        };
        assert_eq!(before.rgb.len(), image.rgb.len(), "one size");
        let both = std::iter::zip(pixels(before), pixels(image));
        let both = std::iter::zip(both, colors);
        let color = |((was, is), color): ((_, _), &u8)| match was == is {
            true => *color,
            false => nearest(is),
        };
        both.map(color).collect()
    }
}

/// The least rectangle with all that has changed; a pixel where nothing has.
fn frame(colors: &[u8], before: Option<&[u8]>, width: usize) -> Frame<'static> {
    let has_changed = |i: usize| before.is_none_or(|before| before[i] != colors[i]);
    let changed = (0..colors.len()).filter(|&i| has_changed(i));
    let spans = changed.fold([colors.len(), 0, colors.len(), 0], |[l, r, t, b], i| {
        let (x, y) = (i % width, i / width);
        [l.min(x), r.max(x + 1), t.min(y), b.max(y + 1)]
    });
    let [left, right, top, bottom] = match spans {
        [_, 0, ..] => [0, 1, 0, 1],
        spans => spans,
    };
    let color = |i: usize| {
        let color = has_changed(i).then(|| colors[i]);
        color.unwrap_or(UNCHANGED)
    };
    let rows = (top..bottom).flat_map(|y| (left..right).map(move |x| y * width + x));
    Frame {
        left: left as u16,
        top: top as u16,
        width: (right - left) as u16,
        height: (bottom - top) as u16,
        transparent: Some(UNCHANGED),
        buffer: rows.map(color).collect(),
        ..Frame::default()
    }
}

fn from_encoding(error: EncodingError) -> io::Error {
    match error {
        EncodingError::Io(error) => error,
        other => io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDES: [u32; 2] = [60, 40];

    /// Noise of many colours, bluish on the left and brownish on the right, and a green disc of this radius on it.
    fn picture(radius: f64) -> Image {
        let [width, height] = SIDES;
        let color = |i: u32| {
            let (x, y) = (f64::from(i % width) - 25.0, f64::from(i / width) - 18.0);
            let noise = |k: u32| (i.wrapping_mul(k) >> 26) as u8;
            let [a, b, c] = [2_654_435_761, 2_246_822_519, 3_266_489_917].map(noise);
            let hue = if x < 5.0 { [0, 3, 9] } else { [9, 5, 0] };
            let grey = [a, a / 2 + b / 2, a / 2 + c / 2];
            match x.hypot(y) < radius {
                true => [40 + i as u8 % 9, 170, 60],
                false => [0, 1, 2].map(|k| 90 + grey[k] + hue[k]),
            }
        };
        Image {
            rgb: (0..width * height).flat_map(color).collect(),
            ..Image::sheet(width, height, [0; 3])
        }
    }

    fn written(pictures: &[Image], fps: f64) -> Vec<u8> {
        let palette = GifPalette::new(&pictures[0], &pictures[pictures.len() - 1]);
        let size = [pictures[0].width, pictures[0].height];
        let (mut bytes, mut packer) = (Vec::new(), GifPacker::new(&palette));
        let mut writer = GifWriter::new(&mut bytes, size, fps, &palette).unwrap();
        for picture in pictures {
            writer.add(packer.pack(picture)).unwrap();
        }
        drop(writer);
        bytes
    }

    #[test]
    fn pictures_without_a_pace_are_refused() {
        let still = picture(5.0);
        let palette = GifPalette::new(&still, &still);
        let is_begun = |fps: f64| GifWriter::new(Vec::new(), SIDES, fps, &palette).is_ok();
        assert!(is_begun(24.0));
        assert!(![0.0, -1.0, f64::NAN].into_iter().any(is_begun));
    }

    /// What a viewer shows, frame after frame.
    fn shown(bytes: &[u8]) -> Vec<Vec<[u8; 3]>> {
        let mut gif = gif::DecodeOptions::new().read_info(bytes).unwrap();
        let width = usize::from(gif.width());
        let palette = gif.global_palette().unwrap().to_vec();
        let mut screen = vec![[0; 3]; width * usize::from(gif.height())];
        let mut all = Vec::new();
        while let Some(frame) = gif.read_next_frame().unwrap() {
            assert!(frame.palette.is_none());
            let [left, top, across] = [frame.left, frame.top, frame.width].map(usize::from);
            for (i, &color) in frame.buffer.iter().enumerate() {
                let at = (top + i / across) * width + left + i % across;
                if frame.transparent != Some(color) {
                    screen[at] = palette.as_chunks().0[usize::from(color)];
                }
            }
            all.push(screen.clone());
        }
        all
    }

    /// How far the mean colour of some pixels is off.
    fn off(shown: &[[u8; 3]], exact: &[[u8; 3]], is_asked: impl Fn(usize) -> bool) -> f64 {
        let asked: Vec<usize> = (0..exact.len()).filter(|&i| is_asked(i)).collect();
        let mean = |of: &[[u8; 3]], k: usize| {
            let sum: f64 = asked.iter().map(|&i| f64::from(of[i][k])).sum();
            sum / asked.len() as f64
        };
        let off = [0, 1, 2].map(|k| (mean(shown, k) - mean(exact, k)).abs());
        off.into_iter().fold(0.0, f64::max)
    }

    #[test]
    fn what_stands_still_stays_the_same_and_what_is_small_or_pale_has_its_colour() {
        let pictures = [0.0, 1.5, 3.0, 3.0, 2.0, 4.0].map(picture);
        let film = shown(&written(&pictures, 10.0));
        assert_eq!(film.len(), pictures.len());
        let stone = pixels(&pictures[0]);
        for (shown, picture) in film.iter().zip(&pictures) {
            let exact = pixels(picture);
            for i in (0..exact.len()).filter(|&i| exact[i] == stone[i]) {
                assert_eq!(shown[i], film[0][i]);
            }
            let is_left = |i: usize| i % 60 < 20;
            let [left, right] = [true, false].map(|side| off(shown, exact, |i| is_left(i) == side));
            assert!(left < 1.0 && right < 1.0, "{left}, {right}");
            if exact != stone {
                let disc = off(shown, exact, |i| exact[i] != stone[i]);
                assert!(disc < 6.0, "{disc}");
            }
        }
    }

    #[test]
    fn a_file_names_the_program() {
        let bytes = written(&[picture(0.0)], 10.0);
        let name = SOFTWARE.as_bytes();
        assert!(bytes.windows(name.len()).any(|part| part == name));
    }

    #[test]
    fn frames_hold_what_has_changed() {
        let bytes = written(&[0.0, 0.0, 2.5].map(picture), 10.0);
        let mut gif = gif::DecodeOptions::new().read_info(&bytes[..]).unwrap();
        let mut rectangle = || {
            let frame = gif.read_next_frame().unwrap().unwrap();
            [frame.left, frame.top, frame.width, frame.height]
        };
        assert_eq!(rectangle(), [0, 0, 60, 40]);
        assert_eq!(rectangle(), [0, 0, 1, 1]);
        assert_eq!(rectangle(), [23, 16, 5, 5]);
    }

    #[test]
    fn no_picture_is_too_short_for_browsers() {
        for fps in [10.0, 24.0, 45.0, 49.9, 50.0, 60.0, 1000.0] {
            let bytes = written(&vec![Image::sheet(2, 2, [200; 3]); 20], fps);
            let mut gif = gif::DecodeOptions::new().read_info(&bytes[..]).unwrap();
            let mut all = 0;
            while let Some(frame) = gif.read_next_frame().unwrap() {
                assert!(frame.delay >= 2, "{fps}: {}", frame.delay);
                all += frame.delay;
            }
            let expected = (2000.0 / fps.min(50.0)).round();
            assert_eq!(f64::from(all), expected, "{fps}");
        }
    }
}
