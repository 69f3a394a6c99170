//! Whether a layout is fit for maps, found out much sooner than by baking.

use rayon::prelude::*;

use super::BakeError;
use super::layout::{Corners, MOST_IMAGES, SHARED, corners_of, doubled_area, inside, under};
use super::shown::Shown;
use crate::substrate::{Division, Substrate, Texturing};

/// What the layout of a mesh would be in maps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayoutJudgement {
    /// Images that it takes at most: parts without lichen need none.
    pub images: usize,
    /// Parts that there can be no maps of, for triangles repeat an image or lie on one another many times over.
    pub unfit: usize,
    /// Share of the images' texels that show something.
    pub used: f64,
    /// Of these the share that stands for several places of the surface, one of which is shown.
    pub overlapping: f64,
    /// Triangles that have no area in the layout, or no UVs: lichen on them is in no map.
    pub not_shown: usize,
    /// Usual side of an image on the surface, in the mesh file's units: so many texels are along it as maps are wide.
    pub side: f64,
}

/// Texels in a row, and rows, by which a layout is judged, of few images and of many: coarser than maps, and fine
/// enough to meet any chart that shows.
const SIZES: [usize; 2] = [512, 128];
const FEW: usize = 32;

/// Judges the layout of a mesh, or of those of its triangles that are chosen by their numbers in the file, in an image
/// for each part of a division, or in one. What is shared only along edges, or within less than a texel of an image 512
/// texels wide (128 where there are more than 32), may not be found.
///
/// # Errors
/// When there can be maps of no part: those of [baking](super::Baker::part) the first.
pub fn judge(
    substrate: &Substrate,
    texturing: &Texturing,
    (division, chosen): (Option<&Division>, Option<&[bool]>),
) -> Result<LayoutJudgement, BakeError> {
    let shown = Shown {
        substrate,
        texturing,
        chosen,
        charts: None,
    };
    let part_of = |t: u32| {
        let source = substrate.source_triangle(t) as usize;
        division.map_or(Some(0), |division| division.place_of(source))
    };
    let size = SIZES[usize::from(division.is_some_and(|all| all.names().len() > FEW))];
    let mut sheets = vec![Sheet::default(); division.map_or(1, |all| all.names().len())];
    let (mut laid, mut all, mut has_uvs) = (Vec::new(), 0, false);
    for t in shown.triangles() {
        all += 1;
        has_uvs |= shown.uvs_of(t).is_some();
        let Some(part) = part_of(t) else { continue };
        match corners_of(&shown, t, size as f64) {
            Ok(Some(corners)) => {
                sheets[part].add(&corners, substrate.area(t), size);
                laid.push((part, corners));
            }
            Ok(None) => {}
            Err(repeats) => sheets[part].fault = sheets[part].fault.take().or(Some(repeats)),
        }
    }
    sheets.iter_mut().for_each(Sheet::check);
    laid.retain(|(part, _)| sheets[*part].fault.is_none());
    if laid.is_empty() {
        let fault = sheets.into_iter().find_map(|sheet| sheet.fault);
        let none = if has_uvs {
            BakeError::FlatUvs
        } else {
            BakeError::NoUvs
        };
        return Err(fault.unwrap_or(none));
    }
    let unfit = sheets.iter().filter(|sheet| sheet.fault.is_some()).count();
    let fit = || {
        sheets
            .iter()
            .filter(|sheet| sheet.fault.is_none() && sheet.filled > 0.0)
    };
    let [filled, surface] =
        [|s: &Sheet| s.filled, |s: &Sheet| s.surface].map(|of| fit().map(of).sum::<f64>());
    let images = fit().count();
    let not_shown = all - laid.len();
    laid.sort_by_key(|&(part, _)| part);
    let parts: Vec<&[Laid]> = laid.chunk_by(|a, b| a.0 == b.0).collect();
    let [used, overlapping] = parts
        .into_par_iter()
        .map(|part| texels(part, size))
        .reduce(Default::default, |a, b| [a[0] + b[0], a[1] + b[1]]);
    Ok(LayoutJudgement {
        images,
        unfit,
        used: used as f64 / (images * size * size) as f64,
        overlapping: overlapping as f64 / used.max(1) as f64,
        not_shown,
        side: substrate.units().length_to_file((surface / filled).sqrt()),
    })
}

/// What is on an image.
#[derive(Clone, Default)]
struct Sheet {
    /// How many images its triangles would fill.
    filled: f64,
    /// Their area on the surface.
    surface: f64,
    /// Why there are no maps of it.
    fault: Option<BakeError>,
}

impl Sheet {
    fn add(&mut self, corners: &Corners, area: f64, size: usize) {
        self.filled += 0.5 * doubled_area(corners).abs() / (size * size) as f64;
        self.surface += area;
    }

    fn check(&mut self) {
        if self.filled > MOST_IMAGES {
            let images = self.filled;
            self.fault.get_or_insert(BakeError::Stacked { images });
        }
    }
}

/// A triangle in an image: the part that has it, and its corners.
type Laid = (usize, Corners);

/// Texels whose middles are in a triangle of a part, and those of them that are well inside of several.
fn texels(part: &[Laid], size: usize) -> [usize; 2] {
    let texel = |(x, y): (i64, i64)| {
        let [x, y] = [x, y].map(|i| i.rem_euclid(size as i64) as u32);
        y * size as u32 + x
    };
    let of = |&(_, corners): &Laid| {
        under(corners).filter_map(move |(x, y)| {
            let inside = inside(&corners, [x as f64, y as f64].into());
            // The last bit says whether it is well inside.
            (inside >= 0.0).then(|| texel((x, y)) << 1 | u32::from(inside > SHARED))
        })
    };
    let mut all: Vec<u32> = part.iter().flat_map(of).collect();
    all.sort_unstable();
    let (mut used, mut several) = (0, 0);
    for same in all.chunk_by(|a, b| a >> 1 == b >> 1) {
        used += 1;
        several += usize::from(same.iter().filter(|x| *x & 1 == 1).count() > 1);
    }
    [used, several]
}
