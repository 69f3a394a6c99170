//! Pictures one after the other as an animated GIF, which repeats for ever.

use std::io::{self, Write};

use gif::{Encoder, EncodingError, Frame, Repeat};

use super::Image;

/// An animated GIF that is being written. Each picture has a palette of its own.
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

/// How thoroughly colours are chosen: 1 takes every pixel, 30 one in thirty.
const SPEED: i32 = 10;

impl<W: Write> GifWriter<W> {
    /// Of pictures of this width and height, at so many a second, as near as hundredths of a second
    /// come to it; at [`FASTEST_GIF`] where more are asked for.
    ///
    /// # Errors
    /// `InvalidInput` when a side is 0 or beyond 65,535; those of `out`.
    pub fn new(out: W, width: u32, height: u32, fps: f64) -> io::Result<Self> {
        let side = |n: u32| u16::try_from(n).ok().filter(|n| *n > 0);
        let (Some(w), Some(h)) = (side(width), side(height)) else {
            let problem = "a GIF is 1 to 65535 pixels wide and high";
            return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
        };
        let mut encoder = Encoder::new(out, w, h, &[]).map_err(from_encoding)?;
        encoder
            .set_repeat(Repeat::Infinite)
            .map_err(from_encoding)?;
        Ok(Self {
            encoder,
            size: [w, h],
            fps: fps.min(FASTEST_GIF),
            frames: 0,
        })
    }

    /// The next picture.
    ///
    /// # Errors
    /// Those of the output.
    ///
    /// # Panics
    /// When it has another size.
    pub fn add(&mut self, image: &Image) -> io::Result<()> {
        self.add_packed(GifPicture::new(image))
    }

    /// The next picture, which is packed already.
    ///
    /// # Errors
    /// Those of the output.
    ///
    /// # Panics
    /// When it has another size.
    pub fn add_packed(&mut self, GifPicture(mut frame): GifPicture) -> io::Result<()> {
        assert_eq!([frame.width, frame.height], self.size, "one size");
        // Hundredths that are lost to one frame go to the next.
        let at = |frame: u32| (100.0 * f64::from(frame) / self.fps).round();
        frame.delay = (at(self.frames + 1) - at(self.frames)) as u16;
        self.frames += 1;
        let written = self.encoder.write_lzw_pre_encoded_frame(&frame);
        written.map_err(from_encoding)
    }
}

/// A picture of an animated GIF, its colours chosen and packed: nearly all of the work, which several
/// threads may do for several pictures.
pub struct GifPicture(Frame<'static>);

impl std::fmt::Debug for GifPicture {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("GifPicture")
            .field(&[self.0.width, self.0.height])
            .finish()
    }
}

impl GifPicture {
    /// Packs a picture.
    ///
    /// # Panics
    /// When a side is beyond 65,535, or the public fields of the picture disagree.
    pub fn new(image: &Image) -> Self {
        let [width, height] =
            [image.width, image.height].map(|side| u16::try_from(side).expect("a side of a GIF"));
        let mut frame = Frame::from_rgb_speed(width, height, &image.rgb, SPEED);
        frame.make_lzw_pre_encoded();
        Self(frame)
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

    #[test]
    fn no_picture_is_too_short_for_browsers() {
        for fps in [10.0, 24.0, 45.0, 49.9, 50.0, 60.0, 1000.0] {
            let mut bytes = Vec::new();
            let mut writer = GifWriter::new(&mut bytes, 2, 2, fps).unwrap();
            for _ in 0..20 {
                writer.add(&Image::sheet(2, 2, [200; 3])).unwrap();
            }
            drop(writer);
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
