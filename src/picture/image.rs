//! A finished picture.

use crate::color::{to_byte, to_linear};

/// Pixels in rows from the top, three bytes each, sRGB.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Image {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// 3 × `width` × `height` bytes.
    pub rgb: Vec<u8>,
    /// How much of each pixel is covered, `width` × `height` bytes, where the background is
    /// transparent.
    pub alpha: Option<Vec<u8>>,
}

/// Pixels of the largest picture that is packed tightly: larger files than needed by a fifth are a
/// fair price for a twentieth of the time.
const TIGHT: u64 = 1 << 20;

/// Which program a file is of.
pub(super) const SOFTWARE: &str = concat!("thallus ", env!("CARGO_PKG_VERSION"));

impl Image {
    /// The picture as a PNG file of 8 bits a channel, marked as sRGB.
    ///
    /// # Panics
    /// If the public fields were changed so that they disagree, or a side is zero.
    pub fn to_png(&self) -> Vec<u8> {
        self.encoded(None)
    }

    pub(super) fn encoded(&self, text: Option<[&str; 2]>) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.encode(&mut bytes, text)
            .expect("three bytes for each of at least one pixel");
        bytes
    }

    /// An empty sheet of a colour.
    pub(super) fn sheet(width: u32, height: u32, color: [u8; 3]) -> Self {
        Self {
            width,
            height,
            rgb: color.repeat(width as usize * height as usize),
            alpha: None,
        }
    }

    /// The picture at this width, in proportion, on nothing: each pixel is the mean light of those
    /// that it covers. A width that is not smaller changes nothing; 0 counts as 1.
    ///
    /// # Panics
    /// When there are fewer bytes than `width` and `height` say.
    #[must_use]
    pub fn shrunk(&self, width: u32) -> Self {
        let width = width.max(1);
        if width >= self.width {
            return self.clone();
        }
        let height = height_at(width, [self.width, self.height]);
        let row = |y: u32| (0..width).flat_map(move |x| self.mean(x, y, [width, height]));
        Self {
            width,
            height,
            rgb: (0..height).flat_map(row).collect(),
            alpha: None,
        }
    }

    /// Mean light of the pixels below one of a picture of this size.
    fn mean(&self, x: u32, y: u32, size: [u32; 2]) -> [u8; 3] {
        let span = |at: u32, of: u32, all: u32| {
            let first = u64::from(at) * u64::from(all) / u64::from(of);
            let last = (u64::from(at + 1) * u64::from(all)).div_ceil(u64::from(of));
            first as usize..last as usize
        };
        let (columns, rows) = (span(x, size[0], self.width), span(y, size[1], self.height));
        let count = (columns.len() * rows.len()) as f32;
        let mut sum = [0.0; 3];
        for row in rows {
            for column in columns.clone() {
                let i = 3 * (row * self.width as usize + column);
                (0..3).for_each(|k| sum[k] += to_linear(self.rgb[i + k]));
            }
        }
        sum.map(|light| to_byte(light / count))
    }

    /// Lays another picture over this one, its upper left corner here.
    pub(super) fn paste(&mut self, other: &Self, x: u32, y: u32) {
        for (row, line) in other.rgb.chunks_exact(3 * other.width as usize).enumerate() {
            let start = 3 * ((y as usize + row) * self.width as usize + x as usize);
            self.rgb[start..start + line.len()].copy_from_slice(line);
        }
    }

    /// The picture as a JPEG file, `quality` from 1 to 100. Transparency is lost.
    ///
    /// # Panics
    /// When a side is zero or longer than 65535 pixels, or there are fewer than three bytes for each pixel.
    pub fn to_jpeg(&self, quality: u8) -> Vec<u8> {
        let mut bytes = Vec::new();
        let [width, height] = [self.width, self.height].map(u16::try_from);
        let (width, height) = (width.expect("JPEG's width"), height.expect("JPEG's height"));
        jpeg_encoder::Encoder::new(&mut bytes, quality)
            .encode(&self.rgb, width, height, jpeg_encoder::ColorType::Rgb)
            .expect("three bytes for each of at least one pixel");
        bytes
    }

    /// Lays a colour over a pixel, as far as it covers it, 0 to 1; nothing outside the picture.
    pub(super) fn blend(&mut self, x: i64, y: i64, color: [u8; 3], share: f32) {
        let inside =
            (0..i64::from(self.width)).contains(&x) && (0..i64::from(self.height)).contains(&y);
        if !inside {
            return;
        }
        let i = y as usize * self.width as usize + x as usize;
        let share = share.clamp(0.0, 1.0);
        let below = self.alpha.as_ref().map_or(1.0, |a| f32::from(a[i]) / 255.0) * (1.0 - share);
        let covered = share + below;
        for (old, new) in self.rgb[3 * i..3 * i + 3].iter_mut().zip(color) {
            let mixed = f32::from(*old) * below + f32::from(new) * share;
            *old = (mixed / covered.max(1e-6) + 0.5) as u8;
        }
        if let Some(alpha) = &mut self.alpha {
            alpha[i] = (255.0 * covered + 0.5) as u8;
        }
    }

    /// Lays a rectangle (left, top, right, bottom; pixels) over the picture, in the colour for each
    /// place across. Pixels that it covers in part are covered in part; one with a side that is no number covers none.
    pub(super) fn fill(
        &mut self,
        [left, top, right, bottom]: [f32; 4],
        share: f32,
        color: impl Fn(f32) -> [u8; 3],
    ) {
        let within = |low: f32, high: f32, at: i64| {
            let at = at as f32;
            (high.min(at + 1.0) - low.max(at)).clamp(0.0, 1.0)
        };
        if [left, top, right, bottom].iter().any(|side| side.is_nan()) {
            return;
        }
        let pixels = |low: f32, high: f32, side: u32| {
            low.floor().max(0.0) as i64..(high.ceil() as i64).min(side.into())
        };
        for y in pixels(top, bottom, self.height) {
            for x in pixels(left, right, self.width) {
                let covered = within(top, bottom, y) * within(left, right, x);
                self.blend(x, y, color(x as f32 + 0.5), share * covered);
            }
        }
    }

    fn encode(
        &self,
        bytes: &mut Vec<u8>,
        text: Option<[&str; 2]>,
    ) -> Result<(), png::EncodingError> {
        let mut encoder = png::Encoder::new(bytes, self.width, self.height);
        encoder.set_color(match self.alpha {
            None => png::ColorType::Rgb,
            Some(_) => png::ColorType::Rgba,
        });
        if u64::from(self.width) * u64::from(self.height) > TIGHT {
            encoder.set_compression(png::Compression::Fast);
        }
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.add_text_chunk("Software".to_owned(), SOFTWARE.to_owned())?;
        if let Some([keyword, text]) = text {
            encoder.add_text_chunk(keyword.to_owned(), text.to_owned())?;
        }
        let mut writer = encoder.write_header()?;
        match &self.alpha {
            None => writer.write_image_data(&self.rgb)?,
            Some(alpha) => writer.write_image_data(&with_alpha(&self.rgb, alpha))?,
        }
        writer.finish()
    }
}

/// Rows of a picture of this size at another width, in proportion.
fn height_at(width: u32, [old, height]: [u32; 2]) -> u32 {
    let rows = u64::from(height) * u64::from(width) / u64::from(old);
    u32::try_from(rows).unwrap_or(u32::MAX).max(1)
}

fn with_alpha(rgb: &[u8], alpha: &[u8]) -> Vec<u8> {
    let pixels = rgb.chunks_exact(3).zip(alpha);
    pixels.flat_map(|(p, &a)| [p[0], p[1], p[2], a]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectangles_end_with_the_picture() {
        let blank = Image::sheet(4, 4, [0; 3]);
        let filled = |rectangle: [f32; 4]| {
            let mut image = blank.clone();
            image.fill(rectangle, 1.0, |_| [9; 3]);
            image
        };
        let all = Image::sheet(4, 4, [9; 3]);
        let (far, none) = (f32::INFINITY, f32::NAN);
        assert_eq!(filled([-1e30, -far, 1e30, far]), all);
        assert_eq!(filled([-1.0, -1.0, 5.0, 4.0]), all);
        assert_eq!(filled([none, 0.0, 4.0, 4.0]), blank);
        assert_eq!(filled([far, 0.0, far, 4.0]), blank);
    }

    #[test]
    fn files_name_the_program() {
        let png = Image::sheet(2, 2, [9; 3]).to_png();
        let read = png::Decoder::new(std::io::Cursor::new(png)).read_info();
        let read = read.unwrap();
        let texts = &read.info().uncompressed_latin1_text;
        let told = texts.iter().map(|t| [t.keyword.as_str(), t.text.as_str()]);
        assert!(told.eq([["Software", SOFTWARE]]));
    }

    #[test]
    fn shrinking_keeps_the_light() {
        let mut image = Image::sheet(6, 4, [200, 10, 90]);
        assert_eq!(image.shrunk(3), Image::sheet(3, 2, [200, 10, 90]));
        assert_eq!(image.shrunk(6), image);
        assert_eq!(image.shrunk(4).height, 2);
        // More pixels than 32 bits count.
        assert_eq!(height_at(100_000, [200_000, 300_000]), 150_000);
        // Half black, half white: half of the light, which is 188 of 255.
        image.rgb = [[0; 3], [255; 3]].concat().repeat(12);
        assert_eq!(image.shrunk(3).rgb, [188; 18]);
    }
}
