//! Pictures whose files say what they were made from, so that they need not be made again.

use std::io::Cursor;

use super::Image;

/// The keyword of the text in a PNG file.
const KEYWORD: &str = "Made-From";

impl Image {
    /// The picture as [`Image::to_png`] has it, with a mark: ASCII, such as a hash of all that decides
    /// its pixels.
    ///
    /// # Panics
    /// As [`Image::to_png`], or when the mark is not Latin-1.
    pub fn to_marked_png(&self, mark: &str) -> Vec<u8> {
        self.encoded(Some([KEYWORD, mark]))
    }

    /// The opaque picture in a file of [`Image::to_marked_png`] that has this mark; none in any other
    /// file, nor in one that is damaged.
    pub fn of_marked_png(png: &[u8], mark: &str) -> Option<Self> {
        let mut reader = png::Decoder::new(Cursor::new(png)).read_info().ok()?;
        let texts = &reader.info().uncompressed_latin1_text;
        let is_marked = texts.iter().any(|t| t.keyword == KEYWORD && t.text == mark);
        let mut rgb = vec![0; reader.output_buffer_size().filter(|_| is_marked)?];
        let info = reader.next_frame(&mut rgb).ok()?;
        reader.finish().ok()?;
        let is_rgb =
            (info.color_type, info.bit_depth) == (png::ColorType::Rgb, png::BitDepth::Eight);
        is_rgb.then_some(Self {
            width: info.width,
            height: info.height,
            rgb,
            alpha: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_whole_file_with_the_mark_is_the_picture() {
        let mut image = Image::sheet(7, 5, [200, 10, 90]);
        image.rgb[30] = 3;
        let png = image.to_marked_png("0123ab");
        assert_eq!(Image::of_marked_png(&png, "0123ab"), Some(image.clone()));
        assert_eq!(Image::of_marked_png(&png, "0123ac"), None);
        assert_eq!(Image::of_marked_png(&image.to_png(), ""), None);
        for cut in 0..png.len() {
            assert_eq!(Image::of_marked_png(&png[..cut], "0123ab"), None, "{cut}");
        }
        let mut damaged = png.clone();
        for at in 0..png.len() {
            damaged[at] ^= 1;
            let found = Image::of_marked_png(&damaged, "0123ab");
            assert!(found.is_none_or(|found| found == image), "{at}");
            damaged[at] ^= 1;
        }
    }
}
