//! The picture of a run, and what it shares with other pictures.

use std::iter::zip;

use thallus::cluster::{Cluster, Element};
use thallus::morphometry::smooth_normals;
use thallus::picture::{
    Camera, Disc, Ground, Scene, Settings, Stage, Stone, World, age_color, render_unless,
};
use thallus::substrate::{Substrate, SurfacePoint};

use super::cutout::{Cutout, finish};
use super::failure::Failure;
use super::memory;

/// Rays through a pixel, at most: a look at a run should take less time than the run.
const SAMPLES: u32 = 4;

/// The substrate with its lichen coloured by age, as PNG of this width and three quarters of it
/// in height. None if it is told to stop meanwhile.
pub(crate) fn preview(
    (substrate, cutout): (&Substrate, Option<&Cutout>),
    cluster: &Cluster,
    width: u32,
    stopped: &(dyn Fn() -> bool + Sync),
) -> Option<Vec<u8>> {
    let stone = stone_unchecked(substrate);
    let discs = by_age(substrate, cluster);
    let world = World::new(&Scene {
        discs: &discs,
        finish: finish(cutout),
        ..bare(substrate, &stone)
    });
    let settings = Settings {
        width,
        height: width * 3 / 4,
        samples: SAMPLES,
        ..Settings::default()
    };
    let aspect = width as f32 / settings.height.max(1) as f32;
    let camera = Camera::best_view(&world, aspect);
    Some(render_unless(&world, &camera, &settings, stopped)?.to_png())
}

/// The substrate as pictures take it, if there is memory for it.
pub(super) fn stone(substrate: &Substrate) -> Result<Stone, Failure> {
    memory::check_pictured(substrate)?;
    Ok(stone_unchecked(substrate))
}

/// The same for whoever has asked for the memory before.
pub(super) fn stone_unchecked(substrate: &Substrate) -> Stone {
    let vertices = substrate.vertices().iter();
    let vertices: Vec<_> = vertices.map(|v| v.as_vec3().to_array()).collect();
    Stone::new(&vertices, substrate.triangles())
}

/// The substrate without lichen.
pub(super) fn bare<'a>(substrate: &Substrate, stone: &'a Stone) -> Scene<'a> {
    Scene::bare(stone, substrate.up().as_vec3().to_array())
}

/// The same, drawn as something, on the stage of a grown lichen.
pub(super) fn staged<'a>(
    substrate: &Substrate,
    stone: &'a Stone,
    ground: Ground,
    grown: &[Disc],
) -> Scene<'a> {
    let bare = bare(substrate, stone);
    Scene {
        ground,
        stage: Some(Stage::of(stone, grown, bare.up)),
        ..bare
    }
}

/// The elements, coloured by age.
pub(super) fn by_age(substrate: &Substrate, cluster: &Cluster) -> Vec<Disc> {
    let last = cluster.len().saturating_sub(1).max(1) as f32;
    let ages = (0..cluster.len()).map(|birth| age_color(birth as f32 / last));
    granules(substrate, cluster, ages)
}

/// Packs each picture, or whatever is made, while the next is made, on another thread if there is one. What
/// came before an error is still packed.
pub(super) fn packed<I: Send + Sync, T: Send, E: Send>(
    mut pictures: impl Iterator<Item = Result<I, E>> + Send,
    mut pack: impl FnMut(&I) -> T + Send,
) -> impl Iterator<Item = Result<T, E>> {
    let mut made = pictures.next();
    std::iter::from_fn(move || {
        let picture = match made.take()? {
            Ok(picture) => picture,
            Err(error) => return Some(Err(error)),
        };
        let (packed, next) = rayon::join(|| pack(&picture), || pictures.next());
        made = next;
        Some(Ok(packed))
    })
}

/// How much larger than elements granules are drawn, so that neighbours close.
const OVERLAP: f32 = 1.15;

/// The elements, in their colours.
pub(super) fn granules(
    substrate: &Substrate,
    cluster: &Cluster,
    colors: impl IntoIterator<Item = [u8; 3]>,
) -> Vec<Disc> {
    let places: Vec<SurfacePoint> = cluster.elements().iter().map(|e| e.at).collect();
    let normals = smooth_normals(substrate, &places);
    let disc = |((e, normal), color): ((&Element, glam::DVec3), [u8; 3])| Disc {
        center: e.position.as_vec3().to_array(),
        normal: normal.as_vec3().to_array(),
        radius: OVERLAP * cluster.radius() as f32,
        color,
    };
    zip(zip(cluster.elements(), normals), colors)
        .map(disc)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_is_packed_in_order_up_to_an_error() {
        let made = |wrong: i32| (0..9).map(move |i| if i == wrong { Err(i) } else { Ok(i) });
        let packed = |wrong| packed(made(wrong), |i| 10 * i).collect::<Vec<_>>();
        assert!(packed(9).into_iter().eq((0..9).map(|i| Ok(10 * i))));
        assert_eq!(packed(2), [Ok(0), Ok(10), Err(2)]);
        assert_eq!(packed(0), [Err(0)]);
    }
}
