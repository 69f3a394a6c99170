//! Images of UDIM tiles, which OBJ's libraries name all at once: `rock.<UDIM>.png` is `rock.1001.png` in the square of
//! u and v from 0 to 1, one more in each further one to the right, and ten more in each one above.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::PathBuf;

use crate::substrate::division::Tile;
use crate::substrate::{Texture, Texturing, Wrap};

use super::counted;
use super::mtl::{Images, Slot, note};

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

/// Where a name first has `<UDIM>`, in whatever case: that stands for the number of a tile.
pub fn udim_mark(name: &[u8]) -> Option<Range<usize>> {
    let is_mark = |found: &[u8]| found.eq_ignore_ascii_case(MARK);
    let at = name.windows(MARK.len()).position(is_mark)?;
    Some(at..at + MARK.len())
}

impl Tiled {
    /// The name of a tile's image.
    fn name_of(&self, tile: u32) -> Vec<u8> {
        let end = self.name.len();
        let mark = udim_mark(&self.name).unwrap_or(end..end);
        let around = [&self.name[..mark.start], &self.name[mark.end..]];
        around.join(tile.to_string().as_bytes())
    }
}

/// Gives each tile of a material with such textures, as far as triangles are there, a material with its images. What
/// cannot be read is a note.
pub(super) fn lay_out(all: &[Tiled], images: &mut Images, out: &mut Texturing) {
    let mut textures: BTreeMap<usize, Vec<&Tiled>> = BTreeMap::new();
    for tiled in all {
        textures.entry(tiled.material).or_default().push(tiled);
    }
    let of = |(triangle, material): (usize, &Option<u32>)| {
        let material = (*material)? as usize;
        let uvs = out.uvs.get(triangle)?.as_ref();
        let uvs = uvs.filter(|_| textures.contains_key(&material))?;
        Some((triangle, (material, Tile::of(uvs))))
    };
    let mut by_tile: BTreeMap<(usize, Tile), Vec<usize>> = BTreeMap::new();
    let mut beyond = 0;
    let tiles = if all.is_empty() {
        &[]
    } else {
        &out.material_of[..]
    };
    for (triangle, (material, tile)) in tiles.iter().enumerate().filter_map(of) {
        match tile.number() {
            Some(_) => by_tile.entry((material, tile)).or_default().push(triangle),
            None => beyond += 1,
        }
    }
    if beyond > 0 {
        let triangles = counted(beyond, "triangle is", "triangles are");
        note(
            format!(
                "{triangles} in no tile of UDIM's, which has ten columns and counts rows from below"
            ),
            out,
        );
    }
    for ((material, tile), triangles) in by_tile {
        let number = out.materials.len();
        out.materials.push(out.materials[material].clone());
        textures[&material]
            .iter()
            .for_each(|tiled| put(tiled, tile, number, (&mut *images, &mut *out)));
        for triangle in triangles {
            out.material_of[triangle] = Some(number as u32);
        }
    }
}

/// Gives a tile's material its image.
fn put(tiled: &Tiled, tile: Tile, material: usize, (images, out): (&mut Images, &mut Texturing)) {
    let name = tile.number().map(|number| tiled.name_of(number));
    let image = name.and_then(|name| images.read((&tiled.folder, &name), out));
    let [column, row] = tile.place();
    if let Some(image) = image {
        let texture = Texture {
            image,
            is_in_second: false,
            strength: tiled.strength,
            // v counts from above.
            transform: [[1.0, 0.0, -column as f64], [0.0, 1.0, row as f64]],
            wrap: [Wrap::Clamp; 2],
        };
        images.put(tiled.slot, texture, material, out);
    }
}
