//! `thallus export` as a user meets it: axes, units, what each format holds, and how it fails.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;
use thallus::cluster::{Ease, Presence};
use thallus::export::{Elements, Placement, SCENE_FORMATS, Scene, SceneFormat, UpAxis, What};
use thallus::morphometry::measure;

/// A cube of one metre, y-up; its first triangle has the corner (1, 1, 1) first.
const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n\
                    f 8 7 5 6\nf 4 2 1 3\nf 8 6 2 4\nf 7 3 1 5\nf 8 4 3 7\nf 6 5 1 2\n";

struct Desk(TempDir);

impl Desk {
    /// One element at the cube's corner in `one`, two hundred on the cube in `many`.
    fn new() -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        fs::write(desk.path("cube.obj"), CUBE).unwrap();
        desk.done("grow cube.obj -o one --elements 1 --radius 0.05 --at 1,1,1 --preview 16");
        desk.done("grow cube.obj -o many --elements 200 --radius 0.01 --at 1,0.97,1 --preview 16");
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn run(&self, words: &str) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_thallus"));
        command
            .args(words.split_whitespace())
            .current_dir(self.0.path());
        command.output().unwrap()
    }

    /// Runs what must succeed; gives what it said to stderr.
    fn done(&self, words: &str) -> String {
        let output = self.run(words);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{words}: {said}");
        said
    }

    fn fails(&self, words: &str, code: i32, parts: &[&str]) {
        let output = self.run(words);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{words}: {said}");
        for part in parts {
            assert!(said.contains(part), "{words}\n'{part}' not in: {said}");
        }
        assert_eq!(said.lines().count(), 1, "{said}");
    }

    /// Exports the one element and gives the file.
    fn one(&self, file: &str, flags: &str) -> Vec<u8> {
        self.done(&format!("export one -o {file} --force {flags}"));
        fs::read(self.path(file)).unwrap()
    }

    /// The same as text.
    fn text(&self, file: &str, flags: &str) -> String {
        String::from_utf8(self.one(file, flags)).unwrap()
    }
}

/// What stands between two words, as numbers.
fn numbers(text: &str, before: &str, after: &str) -> Vec<f64> {
    let rest = text
        .split(before)
        .nth(1)
        .unwrap_or_else(|| panic!("no {before}"));
    let inside = rest.split(after).next().unwrap();
    let words = inside.split(|c: char| !(c.is_ascii_digit() || "+-.e".contains(c)));
    words.filter_map(|w| w.parse().ok()).collect()
}

/// The first vertex of a binary PLY of floats.
fn first_vertex(ply: &[u8]) -> Vec<f64> {
    let end = ply.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let float = |i: usize| f32::from_le_bytes(ply[end + 4 * i..][..4].try_into().unwrap());
    (0..3).map(|i| f64::from(float(i))).collect()
}

fn gltf_position(text: &str, which: &str) -> Vec<f64> {
    let root: serde_json::Value = serde_json::from_str(text).unwrap();
    let position = root["meshes"][0]["primitives"][0]["attributes"]["POSITION"].as_u64();
    let corner = &root["accessors"][position.unwrap() as usize][which];
    corner
        .as_array()
        .unwrap()
        .iter()
        .map(|x| x.as_f64().unwrap())
        .collect()
}

fn near(found: &[f64], expected: [f64; 3]) {
    let close = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-5 * b.abs().max(1.0);
    let all = found.len() == 3 && found.iter().zip(&expected).all(close);
    assert!(all, "{found:?} where {expected:?} is expected");
}

/// The corner (1, 1, 1) of a y-up cube is (1, −1, 1) where z is up.
#[test]
fn the_corner_of_a_cube_is_where_each_format_has_it() {
    let desk = Desk::new();
    let (y_up, z_up) = ([1.0, 1.0, 1.0], [1.0, -1.0, 1.0]);
    near(&first_vertex(&desk.one("a.ply", "")), z_up);
    near(&first_vertex(&desk.one("a.ply", "--up y")), y_up);
    near(&numbers(&desk.text("a.obj", ""), "\nv", " 0.")[..3], y_up);
    near(
        &numbers(&desk.text("a.obj", "--up z"), "\nv", " 0.")[..3],
        z_up,
    );
    near(&numbers(&desk.text("a.csv", ""), "\n", ",0.")[..3], y_up);
    near(
        &numbers(&desk.text("a.csv", "--up z"), "\n", ",0.")[..3],
        z_up,
    );
    near(&gltf_position(&desk.text("a.gltf", ""), "min"), y_up);
    // The last row of the matrix; left-handed.
    let matrix = numbers(&desk.text("a.inc", ""), "\n  matrix <", ">");
    near(&matrix[9..], [1.0, 1.0, -1.0]);
    let usd = desk.text("a.usda", "");
    near(&numbers(&usd, "point3f[] points = [", "]"), y_up);
    assert!(usd.contains("upAxis = \"Y\"") && usd.contains("metersPerUnit = 1\n"));
    let usd = desk.text("a.usda", "--up z");
    near(&numbers(&usd, "point3f[] points = [", "]"), z_up);
    assert!(usd.contains("upAxis = \"Z\""));
    near(&first_vertex(&desk.one("a.ply", "--mesh-up z")), y_up);
    near(
        &gltf_position(&desk.text("a.gltf", "--mesh-up z"), "min"),
        [1.0, 1.0, -1.0],
    );
}

/// Numbers of the mesh file are in every table.
#[test]
fn tables_name_the_triangles_of_the_mesh_file() {
    let desk = Desk::new();
    desk.done("export many -o a.ply");
    desk.done("export many -o a.csv");
    let ply = thallus::export::read_elements(&desk.path("a.ply")).unwrap();
    let csv = fs::read_to_string(desk.path("a.csv")).unwrap();
    let mut lines = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let names = lines.next().unwrap();
    let column = names.iter().position(|n| *n == "source_triangle").unwrap();
    let expected: Vec<u32> = lines.map(|cells| cells[column].parse().unwrap()).collect();
    assert!(expected.iter().any(|&t| t != expected[0]));
    assert_eq!(ply.source_triangle, Some(expected));
}

#[test]
fn units_and_scale_reach_every_length() {
    let desk = Desk::new();
    let gltf = desk.text("a.gltf", "--unit cm");
    near(&gltf_position(&gltf, "min"), [0.01, 0.01, 0.01]);
    let terrain = desk.text("terrain.gltf", "--unit km");
    near(&gltf_position(&terrain, "min"), [1000.0; 3]);
    let usd = desk.text("a.usda", "--unit cm --scale 3");
    near(&numbers(&usd, "point3f[] points = [", "]"), [3.0; 3]);
    assert!(usd.contains("metersPerUnit = 0.01\n"));
    assert!((numbers(&usd, "float[] widths = [", "]")[0] - 0.3).abs() < 1e-6);
    near(
        &first_vertex(&desk.one("a.ply", "--scale 2")),
        [2.0, -2.0, 2.0],
    );
    let csv = |flags: &str| {
        desk.done(&format!("export many -o m.csv --force {flags}"));
        fs::read_to_string(desk.path("m.csv")).unwrap()
    };
    let (plain, doubled) = (csv(""), csv("--scale 2"));
    let header: Vec<&str> = plain.lines().next().unwrap().split(',').collect();
    for (a, b) in plain.lines().zip(doubled.lines()).skip(1) {
        let cells = a.split(',').zip(b.split(',')).zip(&header);
        for ((a, b), name) in cells {
            let (a, b): (f64, f64) = (a.parse().unwrap(), b.parse().unwrap());
            let length = ["x", "y", "z", "radius", "rim_distance", "branch_radius"].contains(name);
            let factor = if length && a != -1.0 || *name == "x" {
                2.0
            } else {
                1.0
            };
            assert!((b - factor * a).abs() < 1e-6, "{name}: {a} {b}");
        }
    }
}

/// The third axis of an orientation is the normal, whichever way is up.
#[test]
fn orientations_turn_with_the_axes() {
    let desk = Desk::new();
    for up in ["y", "z"] {
        desk.done(&format!("export many -o m.csv --force --up {up}"));
        let text = fs::read_to_string(desk.path("m.csv")).unwrap();
        let names: Vec<&str> = text.lines().next().unwrap().split(',').collect();
        for line in text.lines().skip(1) {
            let cells: Vec<f64> = line.split(',').map(|c| c.parse().unwrap()).collect();
            let get = |name| cells[names.iter().position(|n| *n == name).unwrap()];
            let q = ["orient_x", "orient_y", "orient_z", "orient_w"].map(get);
            let normal = glam::DQuat::from_array(q) * glam::DVec3::Z;
            near(&normal.to_array(), ["nx", "ny", "nz"].map(get));
        }
    }
}

const EVERY: [(&str, &[&str]); 3] = [
    (
        "points",
        &[
            "ply", "glb", "gltf", "usda", "usd", "obj", "inc", "csv", "npy", "npz", "parquet",
        ],
    ),
    ("instances", &["glb", "gltf", "usda", "usd", "inc"]),
    (
        "curves",
        &["ply", "glb", "gltf", "usda", "usd", "obj", "inc"],
    ),
];

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let desk = Desk::new();
    for (what, extensions) in EVERY {
        for extension in extensions {
            let export = |threads: &str, name: &str| {
                let mut command = Command::new(env!("CARGO_BIN_EXE_thallus"));
                let file = format!("{name}.{extension}");
                command
                    .args(["export", "many", "--what", what, "--force", "-o", &file])
                    .env("RAYON_NUM_THREADS", threads)
                    .current_dir(desk.0.path());
                assert!(command.output().unwrap().status.success(), "{what} {file}");
                fs::read(desk.path(&file)).unwrap()
            };
            assert_eq!(export("1", "a"), export("5", "b"), "{what} {extension}");
        }
    }
}

#[test]
fn what_cannot_be_is_said_with_its_cure() {
    let desk = Desk::new();
    desk.fails(
        "export many -o a.csv --what curves",
        2,
        &[".csv", "curves", ".usda"],
    );
    desk.fails(
        "export many -o a.obj --what instances",
        2,
        &[".obj", "instances", ".glb"],
    );
    desk.fails("export many -o a.glb --up z", 2, &[".glb", "y-up", "--up"]);
    desk.fails(
        "export many -o a.inc --up z",
        2,
        &[".inc", "POV-Ray", "Lichen"],
    );
    desk.fails("export many -o a.usda --scale 0", 2, &["--scale", "1e-12"]);
    desk.fails("export many -o a.usda --scale nan", 2, &["--scale"]);
    desk.fails("export many -o a.usda --unit parsec", 2, &["parsec"]);
    desk.fails("export many -o a.usda --up x", 2, &["--up"]);
    desk.fails(
        "export one -o a.usda --what curves",
        1,
        &["a.usda", "no branches"],
    );
    desk.fails("export many -o a.usda --mesh none.obj", 1, &["none.obj"]);
    fs::write(
        desk.path("other.obj"),
        CUBE.replace("v 1 1 1\n", "v 1 1.3 1\n"),
    )
    .unwrap();
    desk.fails(
        "export many -o a.usda --mesh other.obj",
        1,
        &["other.obj", "element", "away from it", "grew on"],
    );
    fs::write(
        desk.path("small.obj"),
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    )
    .unwrap();
    desk.fails(
        "export many -o a.usda --mesh small.obj",
        1,
        &["small.obj", "element", "away from it"],
    );
    let ply = fs::read(desk.path("one/elements.ply")).unwrap();
    let end = ply.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let header = String::from_utf8_lossy(&ply[..end]).replace("vertex 1\n", "vertex 0\n");
    fs::write(desk.path("empty.ply"), header).unwrap();
    desk.fails(
        "export empty.ply -o a.usda",
        1,
        &["empty.ply", "no elements"],
    );
    assert!(!desk.path("a.usda").exists());
}

/// Without the mesh a lichen is exported all the same, with what can be known.
#[test]
fn a_lost_mesh_is_told_and_no_hindrance() {
    let desk = Desk::new();
    fs::rename(desk.path("cube.obj"), desk.path("moved.obj")).unwrap();
    let said = desk.done("export many -o a.usda");
    assert!(
        said.contains("cube.obj") && said.contains("--mesh"),
        "{said}"
    );
    let said = desk.done("export many -o a.usda --mesh moved.obj --force");
    assert!(said.is_empty(), "{said}");
    fs::copy(desk.path("many/elements.ply"), desk.path("alone.ply")).unwrap();
    desk.done("export alone.ply -o a.csv");
    let needs_up = Command::new(env!("CARGO_BIN_EXE_thallus"))
        .args(["export", "alone.ply", "-o", "b.glb"])
        .current_dir(desk.0.path())
        .output()
        .unwrap();
    assert_eq!(needs_up.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&needs_up.stderr).contains("--mesh-up"));
    desk.done("export alone.ply -o b.glb --mesh-up y");
}

/// A square and a triangle beside it, whose side the square's corners halve.
const BESIDE: [[f64; 3]; 6] = [
    [0.0, 0.0, 0.0],
    [2.0, 0.0, 0.0],
    [1.0, 0.0, 1.0],
    [1.0, 0.0, 0.0],
    [0.0, 0.0, -1.0],
    [2.0, 0.0, -1.0],
];

fn put_beside(desk: &Desk, name: &str, triangles: &[[usize; 3]]) {
    let vertices = BESIDE.map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    let face = |t: &[usize; 3]| format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
    let faces: String = triangles.iter().map(face).collect();
    fs::write(desk.path(name), vertices.concat() + &faces).unwrap();
}

/// Checks that the elements of a table are where it says they are in the triangles of a file; how many have other
/// weights in those that were made of these.
fn divided_in(desk: &Desk, csv: &str, triangles: &[[usize; 3]]) -> usize {
    let csv = fs::read_to_string(desk.path(csv)).unwrap();
    let mut lines = csv.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let is_divided = |line: &str| {
        let row: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        let get = |name| row[names.iter().position(|n| *n == name).unwrap()];
        let triangle = triangles[get("source_triangle") as usize];
        let [a, b, c] = triangle.map(|corner| glam::DVec3::from(BESIDE[corner]));
        let (u, v) = (get("source_u"), get("source_v"));
        let there = a * (1.0 - u - v) + b * u + c * v;
        let here = glam::dvec3(get("x"), get("y"), get("z"));
        assert!(there.distance(here) < 1e-6, "{line}");
        (get("u") - u).abs() > 1e-3
    };
    lines.filter(|line| is_divided(line)).count()
}

#[test]
fn elements_are_found_in_the_triangles_of_the_file() {
    let desk = Desk::new();
    let square = [[0, 3, 4], [3, 1, 5], [4, 3, 5]];
    let whole = [&[[0, 2, 1]], &square[..]].concat();
    put_beside(&desk, "side.obj", &whole);
    desk.done("grow side.obj -o side --elements 800 --radius 0.02 --preview 16 --quiet");
    desk.done("export side -o side.csv");
    let divided = divided_in(&desk, "side.csv", &whole);
    assert!(divided > 50, "{divided}");
    // Triangulated anew, so that what the run's table counts is no longer there.
    let halves = [&square[..], &[[0, 2, 3], [3, 2, 1]]].concat();
    put_beside(&desk, "halves.obj", &halves);
    desk.done("export side -o halves.csv --mesh halves.obj --quiet");
    assert_eq!(divided_in(&desk, "halves.csv", &halves), 0);
}

/// Far from its origin a lichen keeps its shape: float32 positions are from an origin nearby.
#[test]
fn far_lichens_keep_their_shape() {
    let desk = Desk::new();
    let far: String = CUBE
        .lines()
        .map(|line| match line.strip_prefix("v ") {
            Some(v) => {
                let v: Vec<f64> = v.split(' ').map(|x| x.parse().unwrap()).collect();
                format!("v {} {} {}\n", v[0] + 5e5, v[1] + 4e6, v[2] - 3e5)
            }
            None => format!("{line}\n"),
        })
        .collect();
    fs::write(desk.path("far.obj"), far).unwrap();
    desk.done("grow far.obj -o far --elements 1 --radius 0.05 --at 500001,4000001,-299999 --preview 16 --quiet");
    desk.done("export far -o far.usda");
    let usd = fs::read_to_string(desk.path("far.usda")).unwrap();
    let origin = numbers(&usd, "xformOp:translate = (", ")");
    let local = numbers(&usd, "point3f[] points = [", "]");
    for (k, expected) in [500001.0, 4000001.0, -299999.0].into_iter().enumerate() {
        assert!((origin[k] + local[k] - expected).abs() < 1e-3);
        assert!(local[k].abs() < 10.0);
    }
}

/// A chain of three elements of this radius, measured.
fn scene(radius: f64) -> Scene {
    let along = |i: i32| [f64::from(2 * i) * radius, 0.0, 0.0];
    let elements = Elements {
        radius,
        positions: (0..3).map(along).collect(),
        normals: vec![[0.0, 1.0, 0.0]; 3],
        parent: vec![-1, 0, 1],
        colony: vec![0; 3],
        triangle: vec![0; 3],
        uv: vec![[0.0; 2]; 3],
        probability: vec![1.0; 3],
        ..Elements::default()
    };
    let measured = measure(&elements.sample(), 10.0 * radius);
    Scene::new(elements, measured, &Placement::unchanged(UpAxis::Y), 1.0)
}

/// A file of points or curves as text.
fn written(scene: &Scene, what: What, extension: &str) -> String {
    let format = SceneFormat::of(Path::new(&format!("a.{extension}")), what).unwrap();
    let mut out = Vec::new();
    format.write(what, scene, &|_| [9; 3], &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

/// Elements that fade in are small in numbered files as they are in films.
#[test]
fn points_of_a_moment_have_their_influence_as_size() {
    let half = Presence {
        time: 2.0,
        window: 2.0,
        ease: Ease::Linear,
    };
    let moment = scene(0.5).at(&half, 1);
    let usd = written(&moment, What::Points, "usda");
    let list = |name: &str| numbers(&usd, &format!("{name} = ["), "]");
    let influence = list("float[] primvars:influence");
    assert_eq!(influence, [1.0, 1.0, 0.5]);
    assert_eq!(list("float[] widths"), influence);
    assert_eq!(list("float[] primvars:pscale"), [0.5, 0.5, 0.25]);
    let pov = written(&moment, What::Points, "inc");
    let spheres = pov.lines().filter(|line| line.contains("sphere {"));
    let radii: Vec<f64> = spheres
        .map(|line| numbers(line, ">, ", " pigment")[0])
        .collect();
    assert_eq!(radii, influence);
}

/// Houdini makes curves as wide as `pscale` says, and others as `widths` do.
#[test]
fn curves_are_as_wide_for_houdini_as_for_others() {
    let usd = written(&scene(0.5), What::Curves, "usda");
    let list = |name: &str| numbers(&usd, &format!("float[] {name} = ["), "]");
    let widths = list("widths");
    assert!(widths.is_sorted_by(|a, b| a > b), "{widths:?}");
    let radii: Vec<f64> = widths.iter().map(|width| width / 2.0).collect();
    assert_eq!(list("primvars:pscale"), radii);
    assert_eq!(list("primvars:branch_radius"), radii);
}

/// MeshLab and Blender 3.4 read a line as far as its second vertex.
#[test]
fn branches_in_obj_are_lines_of_two() {
    let obj = written(&scene(0.5), What::Curves, "obj");
    let lines: Vec<&str> = obj.lines().filter(|line| line.starts_with("l ")).collect();
    assert_eq!(lines, ["l 1 2", "l 2 3"]);
}

fn every_file() -> impl Iterator<Item = (What, &'static SceneFormat)> {
    let all = [What::Points, What::Instances, What::Curves];
    all.into_iter().flat_map(|what| {
        let holds = move |f: &&SceneFormat| f.holds(what);
        SCENE_FORMATS.iter().filter(holds).map(move |f| (what, f))
    })
}

/// Accepts a number of bytes, then is full.
struct Full(usize);

impl Write for Full {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match bytes.len().min(self.0) {
            0 => Err(io::ErrorKind::StorageFull.into()),
            taken => {
                self.0 -= taken;
                Ok(taken)
            }
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_full_disk_is_reported_by_every_format() {
    let (scene, color) = (scene(0.5), |_: f32| [9; 3]);
    for (what, format) in every_file() {
        let mut whole = Vec::new();
        format.write(what, &scene, &color, &mut whole).unwrap();
        for room in (0..whole.len()).step_by(97) {
            let error = format
                .write(what, &scene, &color, &mut Full(room))
                .unwrap_err();
            assert_eq!(
                error.kind(),
                io::ErrorKind::StorageFull,
                "{what} {}",
                format.extension
            );
        }
    }
}

#[test]
fn lengths_that_float32_cannot_say_are_refused() {
    let color = |_: f32| [9; 3];
    for radius in [1e-60, 1e40] {
        for (what, format) in every_file() {
            let mut out = Vec::new();
            let error = format
                .write(what, &scene(radius), &color, &mut out)
                .unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::InvalidInput);
            assert!(error.to_string().contains("--scale") && out.is_empty());
        }
    }
}

#[test]
fn unsound_elements_are_not_written() {
    let color = |_: f32| [9; 3];
    let mut unsound = scene(0.5);
    unsound.elements.normals[1][0] = f32::NAN;
    for (what, format) in every_file() {
        let mut out = Vec::new();
        let error = format.write(what, &unsound, &color, &mut out).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::InvalidData);
        assert!(out.is_empty());
    }
}
