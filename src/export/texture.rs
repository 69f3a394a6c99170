//! Square images of numbers as PNG and OpenEXR, for textures.

use std::io::{self, Write};

use flate2::Compression;
use flate2::write::ZlibEncoder;
use rayon::prelude::*;

use crate::color::encode;

/// A square image, known texel by texel.
#[derive(Clone, Copy)]
pub struct Texture<'a> {
    /// Texels in a row, and rows.
    pub size: usize,
    /// 1 for grey, 3 for red, green and blue, 4 with alpha.
    pub channels: usize,
    /// Whether it is a colour to look at: sRGB in PNG, linear light in EXR. Other numbers are written
    /// as they are.
    pub is_color: bool,
    /// The numbers at a column and a row, from the upper left: linear light for colours, and as many as there are
    /// channels.
    pub value: &'a (dyn Fn(usize, usize) -> [f32; 4] + Sync),
}

impl std::fmt::Debug for Texture<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Texture").finish_non_exhaustive()
    }
}

/// Rows that are computed together.
const BAND: usize = 64;

impl Texture<'_> {
    /// Writes it as PNG of 8 or 16 bits a channel; numbers are clamped to 0 to 1.
    ///
    /// # Errors
    /// Those of `out`.
    ///
    /// # Panics
    /// When `bits` is neither 8 nor 16, or `channels` neither 1, 3 nor 4.
    pub fn write_png(&self, bits: u8, out: &mut dyn Write) -> io::Result<()> {
        let mut encoder = png::Encoder::new(out, self.size as u32, self.size as u32);
        encoder.set_color(match self.channels {
            1 => png::ColorType::Grayscale,
            3 => png::ColorType::Rgb,
            4 => png::ColorType::Rgba,
            n => panic!("{n} channels"),
        });
        encoder.set_depth(match bits {
            8 => png::BitDepth::Eight,
            16 => png::BitDepth::Sixteen,
            n => panic!("{n} bits"),
        });
        encoder.set_compression(png::Compression::Fast);
        if self.is_color {
            encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        }
        let program = concat!("thallus ", env!("CARGO_PKG_VERSION"));
        encoder.add_text_chunk("Software".to_owned(), program.to_owned())?;
        let mut writer = encoder.write_header()?;
        let mut stream = writer.stream_writer()?;
        self.bands(|values| stream.write_all(&self.quantized(values, bits)))?;
        stream.finish()?;
        Ok(writer.finish()?)
    }

    /// Gives the numbers of a few rows at a time, from the top.
    fn bands(&self, mut each: impl FnMut(&[f32]) -> io::Result<()>) -> io::Result<()> {
        for top in (0..self.size).step_by(BAND) {
            let rows = (top..self.size.min(top + BAND)).into_par_iter();
            let row = |y: usize| {
                let texel = |x: usize| (self.value)(x, y);
                let texels = (0..self.size).map(texel);
                texels
                    .flat_map(|t| t.into_iter().take(self.channels))
                    .collect::<Vec<f32>>()
            };
            let rows: Vec<Vec<f32>> = rows.map(row).collect();
            each(&rows.concat())?;
        }
        Ok(())
    }

    fn quantized(&self, values: &[f32], bits: u8) -> Vec<u8> {
        let shown = |(i, &x): (usize, &f32)| match self.is_color && i % self.channels < 3 {
            true => encode(x),
            false => x.clamp(0.0, 1.0),
        };
        let values = values.par_iter().enumerate().map(shown);
        match bits {
            8 => values.map(|x| (x * 255.0 + 0.5) as u8).collect(),
            _ => values
                .flat_map_iter(|x| ((x * 65535.0 + 0.5) as u16).to_be_bytes())
                .collect(),
        }
    }

    /// Writes it as OpenEXR (*Technical Introduction to OpenEXR* and *OpenEXR File Layout*), scan
    /// lines with ZIP compression: 32-bit floats where `is_exact`, else 16-bit ones, in which what is not from 0 to
    /// 65504 becomes the nearer of these.
    ///
    /// # Errors
    /// Those of `out`.
    ///
    /// # Panics
    /// When `channels` is neither 1, 3 nor 4.
    pub fn write_exr(&self, is_exact: bool, out: &mut dyn Write) -> io::Result<()> {
        let blocks = self.exr_blocks(is_exact)?;
        let head = self.exr_head(is_exact);
        out.write_all(&head)?;
        let mut at = (head.len() + 8 * blocks.len()) as u64;
        for block in &blocks {
            out.write_all(&at.to_le_bytes())?;
            at += 8 + block.len() as u64;
        }
        for (i, block) in blocks.iter().enumerate() {
            out.write_all(&((i * EXR_ROWS) as i32).to_le_bytes())?;
            out.write_all(&(block.len() as i32).to_le_bytes())?;
            out.write_all(block)?;
        }
        Ok(())
    }

    fn exr_head(&self, is_exact: bool) -> Vec<u8> {
        let mut head = vec![0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
        let mut attribute = |name: &str, kind: &str, value: &[u8]| {
            head.extend([name.as_bytes(), b"\0", kind.as_bytes(), b"\0"].concat());
            head.extend((value.len() as i32).to_le_bytes());
            head.extend(value);
        };
        let mut channels = Vec::new();
        for name in self.exr_channels() {
            channels.extend([*name, 0]);
            channels.extend((if is_exact { 2_i32 } else { 1 }).to_le_bytes());
            channels.extend([0; 4]); // linear, and reserved
            channels.extend([1_i32, 1].map(i32::to_le_bytes).as_flattened());
        }
        channels.push(0);
        let last = self.size as i32 - 1;
        let window = [0, 0, last, last].map(i32::to_le_bytes);
        attribute("channels", "chlist", &channels);
        attribute("compression", "compression", &[3]); // ZIP, blocks of 16 rows
        attribute("dataWindow", "box2i", window.as_flattened());
        attribute("displayWindow", "box2i", window.as_flattened());
        attribute("lineOrder", "lineOrder", &[0]);
        attribute("pixelAspectRatio", "float", &1_f32.to_le_bytes());
        attribute("screenWindowCenter", "v2f", &[0; 8]);
        attribute("screenWindowWidth", "float", &1_f32.to_le_bytes());
        head.push(0);
        head
    }

    /// Names, in the order in which files have them: that of the alphabet.
    fn exr_channels(&self) -> &'static [u8] {
        match self.channels {
            1 => b"Y",
            3 => b"BGR",
            4 => b"ABGR",
            n => panic!("{n} channels"),
        }
    }

    fn exr_blocks(&self, is_exact: bool) -> io::Result<Vec<Vec<u8>>> {
        let tops = (0..self.size.div_ceil(EXR_ROWS)).into_par_iter();
        let block = |i: usize| {
            let rows = i * EXR_ROWS..self.size.min((i + 1) * EXR_ROWS);
            let raw: Vec<u8> = rows.flat_map(|y| self.exr_row(y, is_exact)).collect();
            let packed = zip(&raw)?;
            // What does not become smaller is stored as it is.
            Ok(if packed.len() < raw.len() {
                packed
            } else {
                raw
            })
        };
        tops.map(block).collect()
    }

    /// A row, channel after channel.
    fn exr_row(&self, y: usize, is_exact: bool) -> Vec<u8> {
        let texels: Vec<[f32; 4]> = (0..self.size).map(|x| (self.value)(x, y)).collect();
        let mut row = Vec::new();
        for channel in (0..self.channels).rev() {
            for texel in &texels {
                match is_exact {
                    true => row.extend(texel[channel].to_le_bytes()),
                    false => row.extend(half(texel[channel]).to_le_bytes()),
                }
            }
        }
        row
    }
}

/// Rows of a block that is compressed with ZIP.
const EXR_ROWS: usize = 16;

/// Even bytes before odd ones, each as its difference from the one before, deflated (`ImfZip.cpp`).
fn zip(raw: &[u8]) -> io::Result<Vec<u8>> {
    let halves = raw.iter().step_by(2).chain(raw.iter().skip(1).step_by(2));
    let mut before = 0;
    let difference = |(i, &byte): (usize, &u8)| {
        let d = byte.wrapping_sub(before).wrapping_add(128);
        before = byte;
        if i == 0 { byte } else { d }
    };
    let differences: Vec<u8> = halves.enumerate().map(difference).collect();
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(4));
    encoder.write_all(&differences)?;
    encoder.finish()
}

/// The nearest 16-bit float of a number from 0 to 65504, ties to even.
fn half(x: f32) -> u16 {
    const LEAST_NORMAL: f32 = 6.103_515_6e-5;
    let x = x.clamp(0.0, 65504.0);
    if x < LEAST_NORMAL {
        // Steps of 2^−24.
        return (x * 16_777_216.0).round_ties_even() as u16;
    }
    let bits = x.to_bits();
    let rounded = bits + 0x0fff + (bits >> 13 & 1);
    ((rounded >> 13) - (112 << 10)) as u16
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use super::*;

    fn from_half(h: u16) -> f64 {
        let (exponent, mantissa) = (i32::from(h >> 10), f64::from(h & 1023));
        match exponent {
            0 => mantissa * 2_f64.powi(-24),
            e => (1.0 + mantissa / 1024.0) * 2_f64.powi(e - 15),
        }
    }

    #[test]
    fn halves_are_the_nearest() {
        for h in 0..31 << 10 {
            let (here, next) = (from_half(h), from_half(h + 1));
            assert_eq!(half(here as f32), h);
            let below = (here + 0.49 * (next - here)) as f32;
            if h < (31 << 10) - 1 {
                assert_eq!(half(below), h, "{below}");
                assert_eq!(half((here + 0.51 * (next - here)) as f32), h + 1);
            }
        }
        assert_eq!(half(-1.0), 0);
    }

    /// What the file layout says of a block, the other way round.
    fn unzip(packed: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut decoder = flate2::read::ZlibDecoder::new(packed);
        decoder.read_to_end(&mut bytes).unwrap();
        for i in 1..bytes.len() {
            bytes[i] = bytes[i].wrapping_add(bytes[i - 1]).wrapping_sub(128);
        }
        let half = bytes.len().div_ceil(2);
        (0..bytes.len())
            .map(|i| bytes[i / 2 + (i % 2) * half])
            .collect()
    }

    #[test]
    fn zipped_blocks_come_back() {
        for n in [1, 2, 3, 100, 4097] {
            let raw: Vec<u8> = (0..n).map(|i: u32| (i * i / 7) as u8).collect();
            assert_eq!(unzip(&zip(&raw).unwrap()), raw);
        }
    }

    #[test]
    fn a_png_says_its_numbers() {
        let value = |x: usize, y: usize| [x as f32 / 39.0, y as f32 / 39.0, 0.5, 1.0];
        let texture = Texture {
            size: 40,
            channels: 3,
            is_color: false,
            value: &value,
        };
        let mut file = Vec::new();
        texture.write_png(16, &mut file).unwrap();
        let decoder = png::Decoder::new(std::io::Cursor::new(file));
        let mut reader = decoder.read_info().unwrap();
        let mut raw = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut raw).unwrap();
        let at = |x: usize, y: usize, k: usize| {
            let i = 2 * (3 * (40 * y + x) + k);
            f32::from(u16::from_be_bytes([raw[i], raw[i + 1]])) / 65535.0
        };
        for (x, y) in [(0, 0), (39, 0), (0, 39), (17, 5)] {
            for k in 0..3 {
                assert!((at(x, y, k) - value(x, y)[k]).abs() < 1e-5);
            }
        }
    }
}
