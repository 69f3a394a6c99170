//! Maps to files.

use std::io::{self, Write};

use rayon::prelude::*;

use super::{Baked, Map, MapKind};
use crate::export::{MapImages, SurfaceLook, Texture, TexturedMaterial};
use crate::substrate::Alpha;

/// A file format of maps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MapFile {
    /// 8 or 16 bits a channel, as each map says.
    #[default]
    Png,
    /// OpenEXR: floats, colours in linear light, heights in metres.
    Exr,
}

/// Which way green points in a normal map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Green {
    /// To the top of the image: OpenGL, glTF.
    #[default]
    Up,
    /// To its bottom: DirectX.
    Down,
}

/// How maps are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapFormat {
    /// The format of the files.
    pub file: MapFile,
    /// Of the normal map.
    pub green: Green,
    /// Metres that a unit of the mesh's file becomes: of heights.
    pub meters_per_unit: f64,
}

/// PNG of a mesh in metres, green up.
impl Default for MapFormat {
    fn default() -> Self {
        Self {
            file: MapFile::Png,
            green: Green::Up,
            meters_per_unit: 1.0,
        }
    }
}

/// What the numbers in a map's file mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meaning {
    /// What 0 means.
    pub zero: f64,
    /// What the highest number of a PNG file means, and 1 in EXR.
    pub one: f64,
    /// In words.
    pub unit: &'static str,
    /// `sRGB`, `linear sRGB`, or `data` of what is no colour.
    pub color_space: &'static str,
}

impl MapFile {
    /// How names of its files end, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Exr => "exr",
        }
    }
}

impl Baked<'_> {
    /// Writes a map as a file of this format; the same on any number of threads. The base colour has a channel more
    /// where something is seen through the mesh: its [opacity](Self::opacity).
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_map(&self, map: &Map, format: &MapFormat, out: &mut dyn Write) -> io::Result<()> {
        let down = map.kind == MapKind::Normal && format.green == Green::Down;
        let factor = self.factor(map, format);
        let is_seen_through = map.kind == MapKind::BaseColor && self.alpha() != Alpha::Opaque;
        let value = |x: usize, y: usize| {
            let [r, g, b] = self.value(map, x, y).map(|v| v * factor);
            let alpha = if is_seen_through {
                self.opacity(x, y)
            } else {
                1.0
            };
            [r, if down { 1.0 - g } else { g }, b, alpha]
        };
        let texture = Texture {
            size: self.size(),
            channels: map.channels + usize::from(is_seen_through),
            is_color: map.is_color,
            value: &value,
        };
        match format.file {
            MapFile::Png => texture.write_png(map.png_bits, out),
            MapFile::Exr => texture.write_exr(map.is_exact, out),
        }
    }

    /// What the numbers mean in a file of this format.
    pub fn meaning(&self, map: &Map, format: &MapFormat) -> Meaning {
        let is_exr = format.file == MapFile::Exr;
        let (zero, one, unit) = match map.kind {
            MapKind::Height if is_exr => (0.0, 1.0, "m"),
            MapKind::Height => (0.0, self.highest() * format.meters_per_unit, "m"),
            MapKind::Normal => (-1.0, 1.0, "component of a unit vector"),
            _ => (0.0, 1.0, "share"),
        };
        Meaning {
            zero,
            one,
            unit,
            color_space: match (map.is_color, is_exr) {
                (true, false) => "sRGB",
                (true, true) => "linear sRGB",
                (false, _) => "data",
            },
        }
    }

    /// Heights are in metres in EXR, which has numbers beyond 1.
    fn factor(&self, map: &Map, format: &MapFormat) -> f32 {
        match (format.file, map.kind) {
            (MapFile::Exr, MapKind::Height) => (self.highest() * format.meters_per_unit) as f32,
            _ => 1.0,
        }
    }

    /// As a material of glTF: PNG of 8 bits, green up. Of maps that have been written as PNG, those of 8 bits are taken
    /// as they are.
    ///
    /// # Errors
    /// None but those of the encoder.
    pub fn material(
        &self,
        name: &str,
        written: &[(MapKind, Vec<u8>)],
    ) -> io::Result<TexturedMaterial> {
        let worn = [MapKind::BaseColor, MapKind::Normal, MapKind::Orm].into_par_iter();
        let png = |kind: MapKind| {
            let known = written.iter().find(|(of, _)| *of == kind);
            if let Some((_, file)) = known.filter(|_| Map::of(kind).png_bits == 8) {
                return Ok(file.clone());
            }
            let map = Map {
                png_bits: 8,
                ..*Map::of(kind)
            };
            let mut file = Vec::new();
            self.write_map(&map, &MapFormat::default(), &mut file)?;
            Ok(file)
        };
        let files: io::Result<Vec<Vec<u8>>> = worn.map(png).collect();
        let [base_color, normal, orm] = files?.try_into().unwrap_or_default();
        Ok(TexturedMaterial {
            name: name.to_owned(),
            look: SurfaceLook::Maps(MapImages {
                affixes: Default::default(),
                base_color,
                normal,
                orm,
            }),
            alpha: self.alpha(),
            is_double_sided: self.is_double_sided(),
        })
    }
}
