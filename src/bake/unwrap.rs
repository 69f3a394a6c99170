//! Charts of their own, for a mesh whose file lays it out so that maps cannot use it, or not at all.
//!
//! A library cuts, flattens and packs them: regions grown up to creases and to 70° from their mean normal, least
//! squares conformal maps (Lévy et al., *Least Squares Conformal Maps for Automatic Texture Atlas Generation*, 2002)
//! evened out as rigidly as possible (Liu et al., *A Local/Global Approach to Mesh Parameterization*, 2008), cut again
//! where these fold or stretch, and packed by their shapes. It is built without its direct solver, whose results depend
//! on the machine's vectors: so the layout is the same on every machine and any number of threads.

use std::collections::HashSet;

use uvunwrap::{Atlas, Density, Error, MeshInput, Options, OutputMesh, Packing};

use super::cut;
use super::frame::order;
use super::shown::Shown;
use super::{BakeError, Settings};

/// For each of the substrate's triangles the texture coordinates of its corners, in the substrate's order; none where
/// it is not shown. As a file's, they count from the upper left.
pub(super) type Charts = Vec<Option<[[f64; 2]; 3]>>;

/// With more charts than this, or pieces of surface, each of which is a chart at least, they are packed by their outlines
/// alone: by their shapes it takes tens of times as long.
const MANY: usize = 256;

/// Share of the image that charts fill, from which on nothing is gained by less between them; and by how much more they
/// must fill to be worth it.
const ENOUGH: f32 = 0.25;
const WORTH_IT: f32 = 1.2;

/// Lays out what is shown, all of it in one image.
///
/// # Errors
/// [`BakeError::Crowded`] when there are so many charts that they do not fit into one.
pub(super) fn unwrap(shown: &Shown, settings: &Settings) -> Result<Charts, BakeError> {
    let substrate = shown.substrate;
    let narrow = |place: &glam::DVec3| place.as_vec3().to_array();
    let positions: Vec<[f32; 3]> = substrate.vertices().iter().map(narrow).collect();
    let faces: Vec<u32> = shown.triangles().collect();
    let corners = |&t: &u32| sides(shown, t).map(|k| substrate.triangles()[t as usize][k]);
    let indices: Vec<u32> = faces.iter().flat_map(corners).collect();
    let mesh = MeshInput::new(&positions, &indices);
    let atlas = atlas(&mesh, shown, settings)?;
    let [laid_out] = &atlas.meshes[..] else {
        unreachable!("one mesh was given");
    };
    let mut charts = vec![None; substrate.triangles().len()];
    for (&t, vertices) in faces.iter().zip(laid_out.indices.as_chunks().0) {
        charts[t as usize] = Some(in_image(
            (&atlas, laid_out),
            settings,
            sides(shown, t),
            vertices,
        ));
    }
    Ok(charts)
}

/// With the charts that are as long as the image cut across, as long as that makes all of them larger.
fn atlas(mesh: &MeshInput, shown: &Shown, settings: &Settings) -> Result<Atlas, BakeError> {
    let (mut best, mut options) = spaced(mesh, shown, settings)?;
    let size = settings.size;
    while let Some(seams) = cut::seams(&best, size, mesh.indices) {
        if best.chart_count as usize > MANY {
            options.packing = Packing::Fast;
        }
        let seams = Some(&seams[..]);
        let atlas = uvunwrap::generate(&[MeshInput { seams, ..*mesh }], &options)
            .map(Some)
            .or_else(crowded)?;
        let gain = f64::from(WORTH_IT) * cut::share(&best, size);
        match atlas.filter(|atlas| atlas.page_count == 1 && cut::share(atlas, size) > gain) {
            Some(larger) => best = larger,
            None => break,
        }
    }
    Ok(best)
}

/// With as much between charts as the image's size asks for, or where that leaves little for them, with less; and the
/// options that say so.
fn spaced(
    mesh: &MeshInput,
    shown: &Shown,
    settings: &Settings,
) -> Result<(Atlas, Options), BakeError> {
    let mut options = Options::default();
    let mut best: Option<(Atlas, Options)> = None;
    options.density = Density::Auto {
        page_size: settings.size,
    };
    options.packing = packing(shown);
    let widest = (settings.size / 256).clamp(2, 8).min(settings.gutter);
    for padding in [widest, widest.div_ceil(4), 1] {
        options.padding = padding;
        let atlas = uvunwrap::generate(std::slice::from_ref(mesh), &options)
            .map(Some)
            .or_else(crowded)?;
        if atlas
            .as_ref()
            .is_some_and(|atlas| atlas.chart_count as usize > MANY)
        {
            options.packing = Packing::Fast;
        }
        let Some(atlas) = atlas.filter(|atlas| atlas.page_count == 1) else {
            continue;
        };
        let used = best.as_ref().map_or(0.0, |(best, _)| best.utilization);
        if atlas.utilization > WORTH_IT * used {
            best = Some((atlas, options));
        }
        let is_enough = |(best, _): &(Atlas, Options)| best.utilization >= ENOUGH;
        if best.as_ref().is_some_and(is_enough) || padding == 1 {
            break;
        }
    }
    best.ok_or(BakeError::Crowded)
}

/// The corners of a triangle counter-clockwise from outside: so no chart is a mirror image.
fn sides(shown: &Shown, triangle: u32) -> [usize; 3] {
    order(shown.substrate.winding().side(triangle) < 0.0)
}

/// The corners of a triangle in the image, which charts may not fill: the library counts rows from below, of those in
/// use.
fn in_image(
    (atlas, mesh): (&Atlas, &OutputMesh),
    settings: &Settings,
    sides: [usize; 3],
    vertices: &[u32; 3],
) -> [[f64; 2]; 3] {
    let size = f64::from(settings.size);
    let share = [atlas.width, atlas.height].map(|texels| f64::from(texels) / size);
    let mut corners = [[0.0; 2]; 3];
    for (side, &vertex) in sides.into_iter().zip(vertices) {
        let [u, v] = mesh.vertices[vertex as usize].uv.map(f64::from);
        corners[side] = [u * share[0], 1.0 - v * share[1]];
    }
    corners
}

fn packing(shown: &Shown) -> Packing {
    let piece = |t: u32| shown.substrate.component_of(t).triangles.start;
    let pieces: HashSet<u32> = shown.triangles().map(piece).collect();
    match pieces.len() > MANY {
        true => Packing::Fast,
        false => Packing::Shape,
    }
}

/// Nothing, where charts and what is between them do not fit into one image.
fn crowded(error: Error) -> Result<Option<Atlas>, BakeError> {
    match error {
        Error::ChartTooLarge { .. } | Error::AtlasTooLarge { .. } => Ok(None),
        other => Err(BakeError::Unwrap(other.to_string())),
    }
}
