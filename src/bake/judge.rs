//! Whether a layout is fit for maps, found out much sooner than by baking.

use rayon::prelude::*;

use super::BakeError;
use super::layout::{Corners, MOST_IMAGES, SHARED, corners_of, doubled_area, inside, under};
use super::shown::Shown;
use crate::substrate::{Division, Substrate, Texturing};

/// What the layout of a mesh would be in maps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayoutJudgement {
    /// Images that it takes.
    pub images: usize,
    /// Share of their texels that show something.
    pub used: f64,
    /// Of these the share that stands for several places of the surface, one of which is shown.
    pub overlapping: f64,
    /// Triangles that have no area in the layout, or no UVs: lichen on them is in no map.
    pub not_shown: usize,
    /// Usual side of an image on the surface, in the mesh file's units: so many texels are along it as maps are wide.
    pub side: f64,
}

/// Texels in a row, and rows, by which a layout is judged: coarser than maps, and fine enough to meet any chart that shows.
const SIZE: usize = 512;
const TEXELS: usize = SIZE * SIZE;

/// Judges the layout of a mesh, or of those of its triangles that are chosen by their numbers in the file, in an image for
/// each part of a division, or in one. What is shared only along edges, or
/// within less than a texel of an image 512 texels wide, may not be found.
///
/// # Errors
/// Those of [baking](super::Baker::part) one of the parts.
pub fn judge(
    substrate: &Substrate,
    texturing: &Texturing,
    (division, chosen): (Option<&Division>, Option<&[bool]>),
) -> Result<LayoutJudgement, BakeError> {
    let shown = Shown {
        substrate,
        texturing,
        chosen,
    };
    let part_of = |t: u32| {
        let source = substrate.source_triangle(t) as usize;
        division.map_or(Some(0), |division| division.place_of(source))
    };
    let images = division.map_or(1, |division| division.count_in(chosen));
    let mut filled = vec![0.0; division.map_or(1, |division| division.names().len())];
    let (mut laid, mut surface, mut has_uvs) = (Vec::new(), 0.0, false);
    let mut all = 0;
    for t in shown.triangles() {
        all += 1;
        has_uvs |= shown.uvs_of(t).is_some();
        let corners = corners_of(&shown, t, SIZE as f64)?;
        if let Some((part, corners)) = part_of(t).zip(corners) {
            filled[part] += 0.5 * doubled_area(&corners).abs() / TEXELS as f64;
            surface += substrate.area(t);
            laid.push((part, corners));
        }
    }
    match filled.iter().find(|&&images| images > MOST_IMAGES) {
        Some(&images) => return Err(BakeError::Stacked { images }),
        None if laid.is_empty() && has_uvs => return Err(BakeError::FlatUvs),
        None if laid.is_empty() => return Err(BakeError::NoUvs),
        None => {}
    }
    let side = (surface / filled.iter().sum::<f64>()).sqrt();
    let not_shown = all - laid.len();
    laid.sort_by_key(|&(part, _)| part);
    let parts: Vec<&[Laid]> = laid.chunk_by(|a, b| a.0 == b.0).collect();
    let [used, overlapping] = { parts.into_par_iter().map(texels) }
        .reduce(Default::default, |a, b| [a[0] + b[0], a[1] + b[1]]);
    Ok(LayoutJudgement {
        images,
        used: used as f64 / (images * TEXELS) as f64,
        overlapping: overlapping as f64 / used.max(1) as f64,
        not_shown,
        side: substrate.units().length_to_file(side),
    })
}

/// A triangle in an image: the part that has it, and its corners.
type Laid = (usize, Corners);

/// Texels whose middles are in a triangle of a part, and those of them that are in several.
fn texels(part: &[Laid]) -> [usize; 2] {
    let texel = |(x, y): (i64, i64)| {
        let [x, y] = [x, y].map(|i| i.rem_euclid(SIZE as i64) as u32);
        y * SIZE as u32 + x
    };
    let of = |&(_, corners): &Laid| {
        let is_inside =
            move |&(x, y): &(i64, i64)| inside(&corners, [x as f64, y as f64].into()) > SHARED;
        under(corners).filter(is_inside).map(texel)
    };
    let mut all: Vec<u32> = part.iter().flat_map(of).collect();
    all.sort_unstable();
    let (mut used, mut several) = (0, 0);
    for same in all.chunk_by(|a, b| a == b) {
        used += 1;
        several += usize::from(same.len() > 1);
    }
    [used, several]
}
