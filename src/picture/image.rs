//! A finished picture.

/// Pixels in rows from the top, three bytes each, sRGB.
#[derive(Clone, Debug, PartialEq, Eq)]
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

impl Image {
    /// The picture as a PNG file of 8 bits a channel, marked as sRGB.
    ///
    /// # Panics
    /// If the public fields were changed so that they disagree, or a side is zero.
    pub fn to_png(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.encode(&mut bytes)
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
    /// place across. Pixels that it covers in part are covered in part.
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
        for y in top.floor() as i64..bottom.ceil() as i64 {
            for x in left.floor() as i64..right.ceil() as i64 {
                let covered = within(top, bottom, y) * within(left, right, x);
                self.blend(x, y, color(x as f32 + 0.5), share * covered);
            }
        }
    }

    fn encode(&self, bytes: &mut Vec<u8>) -> Result<(), png::EncodingError> {
        let mut encoder = png::Encoder::new(bytes, self.width, self.height);
        encoder.set_color(match self.alpha {
            None => png::ColorType::Rgb,
            Some(_) => png::ColorType::Rgba,
        });
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header()?;
        match &self.alpha {
            None => writer.write_image_data(&self.rgb)?,
            Some(alpha) => writer.write_image_data(&with_alpha(&self.rgb, alpha))?,
        }
        writer.finish()
    }
}

fn with_alpha(rgb: &[u8], alpha: &[u8]) -> Vec<u8> {
    let pixels = rgb.chunks_exact(3).zip(alpha);
    pixels.flat_map(|(p, &a)| [p[0], p[1], p[2], a]).collect()
}
