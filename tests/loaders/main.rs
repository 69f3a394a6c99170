//! Each loader's features on small files, and each of its errors with the place and the cure.

mod files;
mod gltf;
mod gltf_compression;
mod gltf_doc;
mod gltf_errors;
mod gltf_morphs;
mod gltf_skins;
mod looks;
mod obj;
mod ply;
mod polygons;
mod stl;

use std::fs;
use std::path::{Path, PathBuf};

use proptest::prelude::*;
use tempfile::TempDir;
use thallus::substrate::{
    Format, LoadFault, Soup, Substrate, load_soup, load_textured, parse_soup, parse_textured,
};

fn parsed(bytes: impl AsRef<[u8]>, format: Format) -> Soup {
    let loaded = parse_soup(bytes.as_ref(), format, None);
    loaded.unwrap_or_else(|error| panic!("{error}")).soup
}

/// The message of a refusal; every one must end in a cure.
fn refused(bytes: impl AsRef<[u8]>, format: Format) -> String {
    match parse_soup(bytes.as_ref(), format, None) {
        Ok(loaded) => panic!("loaded {} triangles", loaded.soup.triangles.len()),
        Err(error) => error.to_string(),
    }
}

#[track_caller]
fn assert_says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "{part:?} is not in {message:?}");
    }
}

fn corners(soup: &Soup) -> Vec<[[f64; 3]; 3]> {
    let place = |t: &[u32; 3]| t.map(|i| soup.positions[i as usize]);
    soup.triangles.iter().map(place).collect()
}

/// Twice the vector area of a triangle.
fn turn([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    let u: [f64; 3] = std::array::from_fn(|k| b[k] - a[k]);
    let v: [f64; 3] = std::array::from_fn(|k| c[k] - a[k]);
    [
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    ]
}

fn area(triangle: [[f64; 3]; 3]) -> f64 {
    0.5 * turn(triangle).iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn total_area(soup: &Soup) -> f64 {
    corners(soup).into_iter().map(area).sum()
}

/// Six times the signed volume: positive where triangles wind counter-clockwise from outside.
fn volume(soup: &Soup) -> f64 {
    let term = |t: [[f64; 3]; 3]| -> f64 {
        let [a, b, c] = t;
        (0..3)
            .map(|k| {
                let (l, m) = ((k + 1) % 3, (k + 2) % 3);
                a[k] * (b[l] * c[m] - b[m] * c[l])
            })
            .sum()
    };
    corners(soup).into_iter().map(term).sum()
}

fn bounds(soup: &Soup) -> ([f64; 3], [f64; 3]) {
    let used = || {
        soup.triangles
            .iter()
            .flatten()
            .map(|&i| soup.positions[i as usize])
    };
    let fold = |from: f64, pick: fn(f64, f64) -> f64| {
        std::array::from_fn(|axis| used().map(|p| p[axis]).fold(from, pick))
    };
    (
        fold(f64::INFINITY, f64::min),
        fold(f64::NEG_INFINITY, f64::max),
    )
}
