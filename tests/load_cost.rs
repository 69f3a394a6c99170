//! What loading costs: time and peak memory a triangle, on a mesh of a million triangles, to read
//! the file and to have a substrate ready to walk on.
//!
//! It prints and judges nothing: how long a thing takes is not a matter of right and wrong.
//! Measured by hand, on Linux, which tells the peak (docs/performance.md has the results):
//! `cargo test --test load_cost -- --ignored --nocapture --test-threads 1`.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use thallus::substrate::{Substrate, load_soup};

/// Squares on a side: half a million squares.
const SIDE: u32 = 708;

/// A hilly sheet: positions and triangles.
fn sheet() -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let row = SIDE + 1;
    let height = |x: u32, y: u32| ((x * 31 + y * 17) % 97) as f32 * 0.013;
    let positions = (0..row * row)
        .map(|i| (i % row, i / row))
        .map(|(x, y)| [x as f32 * 0.37, y as f32 * 0.37, height(x, y)])
        .collect();
    let triangles = (0..SIDE * SIDE)
        .map(|i| i / SIDE * row + i % SIDE)
        .flat_map(|a| [[a, a + 1, a + row], [a + 1, a + row + 1, a + row]])
        .collect();
    (positions, triangles)
}

fn obj() -> Vec<u8> {
    let (positions, triangles) = sheet();
    let mut text = String::new();
    for [x, y, z] in &positions {
        writeln!(
            text,
            "v {x:.6} {y:.6} {z:.6}\nvn 0.0000 0.0000 1.0000\nvt {x:.4} {y:.4}"
        )
        .unwrap();
    }
    for t in &triangles {
        let [a, b, c] = t.map(|i| i + 1);
        writeln!(text, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}").unwrap();
    }
    text.into_bytes()
}

fn binary_stl() -> Vec<u8> {
    let (positions, triangles) = sheet();
    let mut bytes = vec![0; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in &triangles {
        bytes.extend([0; 12]);
        for corner in triangle {
            bytes.extend(
                positions[*corner as usize]
                    .iter()
                    .flat_map(|x| x.to_le_bytes()),
            );
        }
        bytes.extend([0; 2]);
    }
    bytes
}

fn ascii_stl() -> Vec<u8> {
    let (positions, triangles) = sheet();
    let mut text = "solid sheet\n".to_string();
    for triangle in &triangles {
        text += "  facet normal 0.000000e+00 0.000000e+00 1.000000e+00\n    outer loop\n";
        for corner in triangle {
            let [x, y, z] = positions[*corner as usize];
            writeln!(text, "      vertex {x:.6e} {y:.6e} {z:.6e}").unwrap();
        }
        text += "    endloop\n  endfacet\n";
    }
    text += "endsolid sheet\n";
    text.into_bytes()
}

fn ply_header(encoding: &str, vertices: usize, faces: usize) -> String {
    format!(
        "ply\nformat {encoding} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n\
         property float z\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
}

fn binary_ply() -> Vec<u8> {
    let (positions, triangles) = sheet();
    let header = ply_header("binary_little_endian", positions.len(), triangles.len());
    let mut bytes = header.into_bytes();
    bytes.extend(positions.iter().flatten().flat_map(|x| x.to_le_bytes()));
    for triangle in &triangles {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|i| i.to_le_bytes()));
    }
    bytes
}

fn ascii_ply() -> Vec<u8> {
    let (positions, triangles) = sheet();
    let mut text = ply_header("ascii", positions.len(), triangles.len());
    for [x, y, z] in &positions {
        writeln!(text, "{x:.6} {y:.6} {z:.6}").unwrap();
    }
    for [a, b, c] in &triangles {
        writeln!(text, "3 {a} {b} {c}").unwrap();
    }
    text.into_bytes()
}

/// Positions (of the corners themselves when `split`), normals and indices, as exporters write.
fn glb(split: bool) -> Vec<u8> {
    let (mut positions, mut triangles) = sheet();
    if split {
        positions = triangles
            .iter()
            .flatten()
            .map(|&i| positions[i as usize])
            .collect();
        triangles = (0..triangles.len() as u32)
            .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
            .collect();
    }
    let mut bin: Vec<u8> = positions
        .iter()
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let length = bin.len();
    bin.resize(2 * length, 0);
    bin.extend(triangles.iter().flatten().flat_map(|i| i.to_le_bytes()));
    let mut json = format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":{}}}],"bufferViews":[
        {{"buffer":0,"byteLength":{length}}},
        {{"buffer":0,"byteOffset":{},"byteLength":{}}}],"accessors":[
        {{"bufferView":0,"componentType":5126,"type":"VEC3","count":{}}},
        {{"bufferView":1,"componentType":5125,"type":"SCALAR","count":{}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "nodes":[{{"mesh":0,"scale":[2,2,2]}}]}}"#,
        bin.len(),
        2 * length,
        12 * triangles.len(),
        positions.len(),
        3 * triangles.len(),
    )
    .into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((28 + json.len() as u32 + bin.len() as u32).to_le_bytes());
    for (kind, data) in [(b"JSON", json), (b"BIN\0", bin)] {
        bytes.extend((data.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(data);
    }
    bytes
}

fn kilobytes(key: &str) -> f64 {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with(key)).unwrap();
    line.split_whitespace().nth(1).unwrap().parse().unwrap()
}

/// Names the file whose cost a child process measures: memory that another load freed would
/// flatter this one.
const FILE: &str = "THALLUS_COST_OF";

/// What one file costs, a triangle.
struct Cost {
    /// Microseconds to read the file.
    read: f64,
    /// Microseconds to read and prepare it.
    whole: f64,
    /// Peak of memory in bytes.
    memory: f64,
}

fn cost(path: &Path) -> Cost {
    // Writing 5 resets the peak (proc(5)).
    fs::write("/proc/self/clear_refs", "5").unwrap();
    let before = kilobytes("VmRSS");
    let begun = Instant::now();
    let loaded = load_soup(path).unwrap();
    let read = begun.elapsed().as_secs_f64();
    assert_eq!(loaded.soup.triangles.len() as u32, 2 * SIDE * SIDE);
    let substrate = Substrate::from_loaded(loaded).unwrap();
    let whole = begun.elapsed().as_secs_f64();
    let peak = kilobytes("VmHWM") - before;
    let count = f64::from(2 * SIDE * SIDE);
    assert_eq!(substrate.triangles().len() as f64, count);
    Cost {
        read: 1e6 * read / count,
        whole: 1e6 * whole / count,
        memory: 1024.0 * peak / count,
    }
}

#[test]
#[ignore = "runs in a child process of the other test"]
#[expect(clippy::print_stderr, reason = "the numbers are what it is for")]
fn cost_of_one_file() {
    let Some(path) = std::env::var_os(FILE).map(PathBuf::from) else {
        return;
    };
    let Cost {
        read,
        whole,
        memory,
    } = cost(&path);
    let name = path.file_name().unwrap().to_string_lossy();
    eprintln!("{name:12} read {read:5.2} µs, ready {whole:5.2} µs, {memory:4.0} bytes a triangle");
}

type WriteMesh = fn() -> Vec<u8>;

#[test]
#[ignore = "measures a million triangles in every format: by hand"]
fn what_loading_costs() {
    let formats: [(&str, WriteMesh); 7] = [
        ("sheet.obj", obj),
        ("binary.stl", binary_stl),
        ("ascii.stl", ascii_stl),
        ("binary.ply", binary_ply),
        ("ascii.ply", ascii_ply),
        ("welded.glb", || glb(false)),
        ("split.glb", || glb(true)),
    ];
    let folder = tempfile::tempdir().unwrap();
    for (name, write) in formats {
        let path = folder.path().join(name);
        fs::write(&path, write()).unwrap();
        let status = Command::new(std::env::current_exe().unwrap())
            .args(["--ignored", "--nocapture", "--exact", "cost_of_one_file"])
            .env(FILE, &path)
            .status()
            .unwrap();
        assert!(status.success(), "{name}");
        fs::remove_file(&path).unwrap();
    }
}
