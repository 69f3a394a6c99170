//! Images of UDIM tiles, which OBJ's libraries name all at once: `rock.<UDIM>.png` is `rock.1001.png` in the square of u
//! and v from 0 to 1, one more in each further one to the right, and ten more in each one above.

use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::substrate::division::Tile;
use crate::substrate::{Texture, Texturing, Wrap};

use super::mtl::{Slot, image, note_once, put};

/// What stands for a tile's number.
const MARK: &[u8] = b"<UDIM>";

/// A texture with an image for each tile.
pub(super) struct Tiled {
    pub(super) material: usize,
    pub(super) slot: Slot,
    pub(super) strength: f32,
    /// From which its images are named.
    pub(super) folder: PathBuf,
    /// What they are called, with the mark in it.
    pub(super) name: Vec<u8>,
}

/// Where a name has the mark.
pub(super) fn mark_in(name: &[u8]) -> Option<usize> {
    let is_mark = |found: &[u8]| found.eq_ignore_ascii_case(MARK);
    name.windows(MARK.len()).position(is_mark)
}

impl Tiled {
    /// The name of a tile's image.
    fn name_of(&self, tile: u32) -> Vec<u8> {
        let at = mark_in(&self.name).unwrap_or(self.name.len());
        let after = self.name.get(at + MARK.len()..).unwrap_or_default();
        [&self.name[..at], tile.to_string().as_bytes(), after].concat()
    }
}

/// Gives each tile of a material with such textures, as far as triangles are there, a material with its images. What cannot
/// be read is a note.
pub(super) fn lay_out(all: &[Tiled], out: &mut Texturing) {
    let mut by_material: BTreeMap<usize, Vec<&Tiled>> = BTreeMap::new();
    for tiled in all {
        by_material.entry(tiled.material).or_default().push(tiled);
    }
    for (material, textures) in by_material {
        let of = |(triangle, number): (usize, &Option<u32>)| {
            let has_it = *number == Some(material as u32);
            let uvs = out.uvs.get(triangle)?.as_ref().filter(|_| has_it)?;
            Some((triangle, Tile::of(uvs)))
        };
        let tiles = { out.material_of.iter().enumerate() }.filter_map(of);
        let mut by_tile: BTreeMap<Tile, Vec<usize>> = BTreeMap::new();
        tiles.for_each(|(triangle, tile)| by_tile.entry(tile).or_default().push(triangle));
        for (tile, triangles) in by_tile {
            let number = of_tile(material, &textures, tile, out);
            for triangle in triangles {
                out.material_of[triangle] = Some(number);
            }
        }
    }
}

/// Adds a material for a tile.
fn of_tile(material: usize, textures: &[&Tiled], tile: Tile, out: &mut Texturing) -> u32 {
    let number = out.materials.len();
    out.materials.push(out.materials[material].clone());
    let [column, row] = tile.place();
    for tiled in textures {
        let read = match tile.number() {
            Some(tile) => image((&tiled.folder, &tiled.name_of(tile)), out),
            None => Err(format!(
                "UVs in column {column} and row {row} are in no tile of UDIM's, which has ten columns"
            )),
        };
        match read {
            Err(note) => note_once(note, out),
            Ok(image) => {
                let texture = Texture {
                    image,
                    is_in_second: false,
                    strength: tiled.strength,
                    // v counts from above.
                    transform: [[1.0, 0.0, -column as f64], [0.0, 1.0, row as f64]],
                    wrap: [Wrap::Clamp; 2],
                };
                put(tiled.slot, texture, number, out);
            }
        }
    }
    number as u32
}
