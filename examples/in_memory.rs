//! A mesh, its lichen, skin, textures and picture in memory, as a game or an engine has them: no file is read or
//! written.
//!
//!     cargo run --release --example in_memory
#![allow(clippy::print_stdout, clippy::print_stderr)] // printing is what it is for

use std::error::Error;
use std::process::ExitCode;

use thallus::bake::{self, Baker, Base, Look, Map, MapFormat};
use thallus::export::TriMesh;
use thallus::growth::SeedPlace;
use thallus::picture::{self, Camera, Image, Painted, Scene, Stone, World, render};
use thallus::run::{Execution, Length, Settings, StopSetting, grow};
use thallus::skin::{Paint, Shape, skin};
use thallus::substrate::{Soup, Substrate, Texturing};

/// Squares along a side of the tile.
const N: u32 = 32;

/// Vertices, texture coordinates and indices of a wavy tile.
fn tile() -> (Vec<[f32; 3]>, Vec<[f32; 2]>, Vec<u32>) {
    let (mut vertices, mut uvs, mut indices) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..(N + 1) * (N + 1) {
        let [u, v] = [i % (N + 1), i / (N + 1)].map(|k| k as f32 / N as f32);
        vertices.push([u, 0.05 * (6.0 * u).sin() * (5.0 * v).cos(), v]);
        uvs.push([u, v]);
    }
    for i in 0..N * N {
        let a = i / N * (N + 1) + i % N;
        let b = a + N + 1;
        indices.extend([a, b, a + 1, a + 1, b, b + 1]);
    }
    (vertices, uvs, indices)
}

/// A texture as it goes into a pack.
struct Encoded {
    name: &'static str,
    png: Vec<u8>,
}

/// Textures of the tile with the lichen on it.
fn textures(
    substrate: &Substrate,
    texturing: &Texturing,
    look: Look<'_>,
) -> Result<Vec<Encoded>, Box<dyn Error>> {
    let size = bake::Settings {
        size: 256,
        ..bake::Settings::default()
    };
    let baker = Baker::new(substrate, texturing, &[look], &Base::Mesh, &size)?;
    let baked = baker.whole()?;
    let mut textures = Vec::new();
    for name in ["base_color", "normal", "orm"] {
        let map = Map::named(name).ok_or("no such map")?;
        let mut png = Vec::new();
        baked.write_map(map, &MapFormat::default(), &mut png)?;
        textures.push(Encoded { name, png });
    }
    Ok(textures)
}

/// A picture of the skin on the tile, in the units of the tile's vertices.
fn picture(stone: &Stone, skin: &TriMesh, radius: f64) -> Image {
    let positions: Vec<_> = skin.positions.iter().map(|p| p.map(|x| x as f32)).collect();
    let skins = [Painted {
        positions: &positions,
        normals: &skin.normals,
        colors: &skin.colors,
        triangles: &skin.triangles,
        grain: radius as f32,
        structure: None,
    }];
    let world = World::new(&Scene {
        skins: &skins,
        ..Scene::bare(stone, [0.0, 1.0, 0.0])
    });
    let size = picture::Settings {
        width: 320,
        height: 240,
        ..picture::Settings::default()
    };
    render(&world, &Camera::best_view(&world, 320.0 / 240.0), &size)
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

pub(crate) fn run() -> Result<(), Box<dyn Error>> {
    let (vertices, uvs, indices) = tile();
    let soup = Soup::from_buffers(&vertices, &indices);
    let texturing = Texturing::from_vertices(&soup.triangles, &uvs);
    let stone = Stone::new(&vertices, &soup.triangles);
    let substrate = Substrate::from_soup(soup)?;

    let settings = Settings {
        radius: Some(Length::Units(0.008)),
        at: Some(vec![SeedPlace::Center]),
        stop: Some(StopSetting::Elements(1500)),
        ..Settings::default()
    };
    let recipe = settings.resolve(&substrate, "a tile")?;
    let cluster = grow(&substrate, &recipe, &Execution::default(), &mut ())?.cluster;

    let (shape, paint) = (Shape::default(), Paint::default());
    let mesh = skin(&substrate, &cluster, &shape, &paint)?;
    let [vertices, triangles] = [mesh.positions.len(), mesh.triangles.len()];
    println!("a skin of {vertices} vertices and {triangles} triangles");
    let look = Look {
        cluster: &cluster,
        shape: &shape,
        paint: &paint,
    };
    for Encoded { name, png } in textures(&substrate, &texturing, look)? {
        println!("{name}: a PNG of {} bytes", png.len());
    }
    let image = picture(&stone, &mesh, recipe.radius);
    println!("a picture of {} bytes", image.rgb.len());
    Ok(())
}
