//! Meshes and recipes that tests share.
#![allow(clippy::print_stderr)] // a skipped test says so
#![allow(dead_code, reason = "each test crate uses its own part of this")]

use std::path::{Path, PathBuf};

use thallus::growth::{Boundary, Join, Law, SeedPlace, Steps};
use thallus::run::{MeshId, Recipe, StopRule};
use thallus::substrate::{Soup, Substrate};

/// A recipe with radius `r`, everything else by default.
pub(crate) fn recipe(r: f64, elements: u64) -> Recipe {
    Recipe {
        version: "test".into(),
        mesh: MeshId {
            file: "test".into(),
            hash: String::new(),
        },
        mesh_up: None,
        mask: None,
        slope: None,
        radius: r,
        curvature_radius: 10.0 * r,
        bias: 0.5,
        gain: 1.0,
        min_stick: 0.01,
        seed: 1,
        at: vec![SeedPlace::Top],
        launch: 1.5,
        kill: 10.0,
        join: Join::Pack,
        law: Law::Thesis,
        steps: Steps::Large,
        boundary: Boundary::Reflect,
        stop: StopRule::Elements(elements),
    }
}

pub(crate) fn substrate(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Substrate {
    Substrate::from_soup(Soup {
        positions,
        triangles,
        notes: Vec::new(),
    })
    .expect("a mesh")
}

/// A square of this side in the plane y = 0, of two triangles.
pub(crate) fn plane(side: f64) -> Substrate {
    let h = side / 2.0;
    let corners = vec![[-h, 0.0, -h], [h, 0.0, -h], [h, 0.0, h], [-h, 0.0, h]];
    substrate(corners, vec![[0, 2, 1], [0, 3, 2]])
}

/// A sphere of radius 1: an octahedron with edges cut into n, pushed out.
pub(crate) fn sphere(n: u32) -> Substrate {
    let (positions, triangles) = octahedron(n, |d| d.map(|x| x / norm(d)));
    substrate(positions, triangles)
}

/// A rough, bumpy rock of 8·n² triangles.
pub(crate) fn rock(n: u32) -> Substrate {
    noisy_rock(n, 0.0)
}

/// Such a rock with each vertex moved outwards or inwards by chance, up to `noise` from its middle.
pub(crate) fn noisy_rock(n: u32, noise: f64) -> Substrate {
    let chance = |u: [f64; 3]| {
        let mixed = u.map(|x| ((x * 1e6).round() * 0.618_034).fract());
        ((mixed[0] + 3.7 * mixed[1] + 7.9 * mixed[2]).sin() * 43_758.5).fract()
    };
    let bumps = |[x, y, z]: [f64; 3]| {
        0.15 * (3.0 * x + 1.0).sin() * (2.5 * y).cos()
            + 0.1 * (5.0 * z + 2.0 * x).sin()
            + 0.03 * (17.0 * x).sin() * (19.0 * y + 1.0).sin() * (23.0 * z).cos()
    };
    let shape = |d: [f64; 3]| {
        let u = d.map(|x| x / norm(d));
        let r = 1.0 + bumps(u) + noise * chance(u);
        [u[0] * r * 1.2, u[1] * r * 0.8, u[2] * r]
    };
    let (positions, triangles) = octahedron(n, shape);
    substrate(positions, triangles)
}

/// A plate about the origin, `side` in x and z and `thick` in y, each face of cells² squares.
pub(crate) fn slab(cells: u32, side: f64, thick: f64) -> Substrate {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    let mut quad = |corners: [[f64; 3]; 4]| {
        let first = positions.len() as u32;
        positions.extend(corners);
        triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    };
    let (h, y) = (side / 2.0, thick / 2.0);
    let at = |i: u32| side * f64::from(i) / f64::from(cells) - h;
    for i in 0..cells {
        let (a, b) = (at(i), at(i + 1));
        for j in 0..cells {
            let (c, d) = (at(j), at(j + 1));
            quad([[a, y, c], [a, y, d], [b, y, d], [b, y, c]]);
            quad([[a, -y, c], [b, -y, c], [b, -y, d], [a, -y, d]]);
        }
        quad([[a, y, h], [a, -y, h], [b, -y, h], [b, y, h]]);
        quad([[a, y, -h], [b, y, -h], [b, -y, -h], [a, -y, -h]]);
        quad([[h, y, a], [h, y, b], [h, -y, b], [h, -y, a]]);
        quad([[-h, y, a], [-h, -y, a], [-h, -y, b], [-h, y, b]]);
    }
    substrate(positions, triangles)
}

/// Every mesh file of the folder of shared meshes; none where that is absent.
pub(crate) fn shared_meshes() -> Vec<PathBuf> {
    let Some(root) = shared_folder() else {
        return Vec::new();
    };
    let mut folders = vec![root];
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
            if path.is_dir() {
                folders.push(path);
            } else if ["obj", "gltf", "glb", "stl", "ply"].contains(&extension) {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}

/// The folder of meshes that others made: the one that is named, or else that beside the repository, and it says so
/// where there is none. One that is named has to be there.
pub(crate) fn shared_folder() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os("THALLUS_SHARED_MESHES").map(PathBuf::from) {
        let shown = named.display();
        assert!(
            named.is_dir(),
            "THALLUS_SHARED_MESHES: no folder at {shown}"
        );
        return Some(named);
    }
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/meshes");
    if !beside.is_dir() {
        eprintln!(
            "skipped: no folder of shared meshes at {} (set THALLUS_SHARED_MESHES)",
            beside.display()
        );
    }
    beside.is_dir().then_some(beside)
}

fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// The octahedron's faces in n² triangles each, with split vertices: welding joins them.
pub(crate) fn octahedron(
    n: u32,
    shape: impl Fn([f64; 3]) -> [f64; 3],
) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for signs in 0..8u32 {
        let s = [0, 1, 2].map(|k| if signs >> k & 1 == 0 { 1.0 } else { -1.0 });
        let at = |i: u32, j: u32| {
            let b = [f64::from(n - i - j), f64::from(i), f64::from(j)];
            shape([s[0] * b[0], s[1] * b[1], s[2] * b[2]])
        };
        let mut face = |a, b, c| {
            let first = positions.len() as u32;
            positions.extend([a, b, c]);
            let flip = s[0] * s[1] * s[2] < 0.0;
            triangles.push(if flip {
                [first, first + 2, first + 1]
            } else {
                [first, first + 1, first + 2]
            });
        };
        for i in 0..n {
            for j in 0..n - i {
                face(at(i, j), at(i + 1, j), at(i, j + 1));
                if i + j + 1 < n {
                    face(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                }
            }
        }
    }
    (positions, triangles)
}
