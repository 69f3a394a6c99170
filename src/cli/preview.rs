//! The picture of a run.

use thallus::cluster::{Cluster, Element};
use thallus::picture::{Camera, Disc, Scene, Settings, age_color, render};
use thallus::substrate::Substrate;

/// The substrate with its lichen coloured by age, as PNG of this width and three quarters of it
/// in height.
pub(crate) fn preview(substrate: &Substrate, cluster: &Cluster, width: u32) -> Vec<u8> {
    let vertices = vertices(substrate);
    let discs = discs(substrate, cluster);
    let scene = Scene {
        vertices: &vertices,
        triangles: substrate.triangles(),
        discs: &discs,
        up: substrate.up().as_vec3().to_array(),
    };
    let settings = Settings {
        width,
        height: width * 3 / 4,
        ..Settings::default()
    };
    let aspect = settings.width as f32 / settings.height as f32;
    render(&scene, &Camera::best_view(&scene, aspect), &settings).to_png()
}

/// The mesh's vertices as pictures want them.
pub(super) fn vertices(substrate: &Substrate) -> Vec<[f32; 3]> {
    let vertices = substrate.vertices().iter();
    vertices.map(|v| v.as_vec3().to_array()).collect()
}

/// A disc an element, coloured by age.
pub(super) fn discs(substrate: &Substrate, cluster: &Cluster) -> Vec<Disc> {
    let last = cluster.len().saturating_sub(1).max(1) as f32;
    let disc = |(birth, e): (usize, &Element)| Disc {
        center: e.position.as_vec3().to_array(),
        normal: substrate.normal(e.at.triangle).as_vec3().to_array(),
        radius: cluster.radius() as f32,
        color: age_color(birth as f32 / last),
    };
    cluster.elements().iter().enumerate().map(disc).collect()
}
