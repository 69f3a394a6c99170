//! `thallus bake` as it is called.

#[path = "common/desk.rs"]
mod desk;

use std::fs;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use desk::{Desk, assert_refused_in_a_line, names, said};
use thallus::export::read_elements;
use thallus::substrate::load_textured;

/// A box whose sides are charts in a row of six.
fn cube() -> String {
    let mut text = String::new();
    for i in 0..8 {
        let [x, y, z] = [i & 1, i >> 1 & 1, i >> 2].map(f64::from);
        text += &format!("v {x} {y} {z}\n");
    }
    for k in 0..6 {
        let (left, right) = (f64::from(k) / 6.0 + 0.01, f64::from(k + 1) / 6.0 - 0.01);
        text += &format!("vt {left} 0.4\nvt {right} 0.4\nvt {right} 0.55\nvt {left} 0.55\n");
    }
    let faces = [
        [1, 3, 4, 2],
        [5, 6, 8, 7],
        [1, 2, 6, 5],
        [3, 7, 8, 4],
        [1, 5, 7, 3],
        [2, 4, 8, 6],
    ];
    for (k, [a, b, c, d]) in faces.into_iter().enumerate() {
        let [s, t, u, v] = [1, 2, 3, 4].map(|i| 4 * k + i);
        text += &format!("f {a}/{s} {b}/{t} {c}/{u} {d}/{v}\n");
    }
    text
}

fn desk() -> Desk {
    let desk = Desk::new();
    fs::write(desk.path("cube.obj"), cube()).unwrap();
    desk.done("cube.obj --radius 2% --elements 60 -o out");
    desk
}

fn bake(desk: &Desk, words: &str) -> Output {
    desk.call("bake", words).output().unwrap()
}

fn made(desk: &Desk, words: &str) -> String {
    let output = bake(desk, words);
    assert!(output.status.success(), "{words}: {}", said(&output));
    assert_eq!(said(&output), "", "{words}");
    String::from_utf8(output.stdout).unwrap()
}

fn refused(desk: &Desk, words: &str, code: i32, parts: &[&str]) {
    assert_refused_in_a_line(&bake(desk, words), code, parts);
}

const MAPS: [&str; 8] = [
    "base_color",
    "birth",
    "color",
    "height",
    "mask",
    "normal",
    "occlusion",
    "orm",
];

/// Programs in which z is up turn a mesh when they write a format in which y is.
#[test]
fn a_mesh_that_a_program_has_turned_is_baked() {
    let desk = desk();
    let turned = |line: &str| match line
        .strip_prefix("v ")
        .map(|v| v.split(' ').collect::<Vec<_>>())
    {
        Some(v) => format!("v {} {} {}\n", v[0], v[2], v[1].replace('1', "-1")),
        None => format!("{line}\n"),
    };
    let other: String = cube().lines().map(turned).collect();
    fs::write(desk.path("turned.obj"), other).unwrap();
    made(&desk, "out -o as-grown --size 128");
    made(&desk, "out -o turned --size 128 --mesh turned.obj --quiet");
    for map in ["mask", "height", "birth"] {
        let [a, b] = ["as-grown", "turned"].map(|folder| desk.read(&format!("{folder}/{map}.png")));
        assert_eq!(a, b, "{map}");
    }
    for (command, words) in [
        ("render", "--also out --size 64x48 -o t.png"),
        ("skin", "-o t.ply"),
        ("export", "-o t.csv"),
        ("animate", "--what points --frames 2 -o t.usda"),
        ("analyze", "--colony 0"),
    ] {
        let words = format!("out {words} --mesh turned.obj");
        let output = desk.call(command, &words).output().unwrap();
        assert!(output.status.success(), "{command}: {}", said(&output));
        let note = "turned.obj is turned against what this grew on";
        assert!(said(&output).contains(note), "{command}: {}", said(&output));
    }
    let table = String::from_utf8(desk.read("t.csv")).unwrap();
    let first: Vec<f64> = table
        .lines()
        .nth(1)
        .unwrap()
        .split(',')
        .take(6)
        .map(|number| number.parse().unwrap())
        .collect();
    let grown = read_elements(&desk.path("out/elements.ply")).unwrap();
    let [x, y, z] = grown.positions[0];
    let [nx, ny, nz] = grown.normals[0].map(f64::from);
    let apart =
        std::iter::zip(first, [x, z, -y, nx, nz, -ny]).map(|(a, b): (f64, f64)| (a - b).abs());
    assert!(apart.fold(0.0, f64::max) < 1e-6, "turned as the mesh is");
    let wider = |line: &str| match line.starts_with("v ") {
        true => line.replace('1', "1.5") + "\n",
        false => format!("{line}\n"),
    };
    let wider: String = cube().lines().map(wider).collect();
    fs::write(desk.path("wider.obj"), wider).unwrap();
    refused(
        &desk,
        "out -o wider --mesh wider.obj",
        1,
        &["wider.obj", "not on this mesh"],
    );
}

#[test]
fn every_map_and_the_mesh_are_written_and_said() {
    let desk = desk();
    let json = made(&desk, "out -o png --size 128 --json");
    let report: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(report["elements"], 60);
    let mut expected: Vec<String> = MAPS.map(|m| format!("{m}.png")).to_vec();
    expected.extend(["lichened.glb".to_owned(), "maps.json".to_owned()]);
    expected.sort();
    assert_eq!(names(&desk.path("png")), expected);
    made(
        &desk,
        "out -o exr --size 128 --format exr --quiet --threads 1",
    );
    let sidecar = |folder: &str| -> serde_json::Value {
        serde_json::from_slice(&desk.read(&format!("{folder}/maps.json"))).unwrap()
    };
    let height = |folder: &str| {
        let sidecar = sidecar(folder);
        let maps = sidecar["maps"].as_array().unwrap().clone();
        let map = maps
            .into_iter()
            .find(|m| m["file"].as_str().unwrap().starts_with("height"));
        map.unwrap()
    };
    assert_eq!(height("png")["one"], sidecar("png")["highest_meters"]);
    assert_eq!(height("exr")["one"], 1.0);
    assert!(sidecar("png")["highest_meters"].as_f64().unwrap() > 0.02);
    let glb = desk.read("png/lichened.glb");
    let text = String::from_utf8_lossy(&glb);
    assert_eq!(
        text.matches("\"name\":\"cube\"").count(),
        3,
        "node, mesh and material"
    );
    for map in ["base_color", "normal", "orm"] {
        assert!(text.contains(&format!("\"name\":\"cube_{map}\"")), "{map}");
    }
    // The mesh wears PNG whatever the maps are.
    assert!(desk.read("png/lichened.glb") == desk.read("exr/lichened.glb"));
    made(&desk, "out -o dx --size 128 --normal directx --quiet");
    assert!(desk.read("png/normal.png") != desk.read("dx/normal.png"));
    assert!(desk.read("png/lichened.glb") == desk.read("dx/lichened.glb"));
    made(&desk, "out -o cm --size 128 --unit cm --quiet");
    let in_cm = sidecar("cm")["highest_meters"].as_f64().unwrap();
    let in_m = sidecar("png")["highest_meters"].as_f64().unwrap();
    assert!((in_cm * 100.0 / in_m - 1.0).abs() < 1e-9);
}

#[test]
fn several_lichens_are_in_the_same_maps() {
    let desk = desk();
    desk.done("cube.obj --radius 3% --elements 30 --seed 2 -o larger");
    made(&desk, "out -o one --size 128 --quiet");
    let json = made(
        &desk,
        "out --also larger,xanthoria -o two --size 128 --json",
    );
    let report: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!([&report["elements"], &report["lichens"]], [90, 2]);
    let highest = |folder: &str| {
        let sidecar = desk.read(&format!("{folder}/maps.json"));
        let sidecar: serde_json::Value = serde_json::from_slice(&sidecar).unwrap();
        sidecar["highest_meters"].as_f64().unwrap()
    };
    assert!(highest("two") > highest("one"));
    for map in ["mask", "base_color"] {
        let [one, two] = ["one", "two"].map(|folder| desk.read(&format!("{folder}/{map}.png")));
        assert_ne!(one, two, "{map}");
    }
    let text = made(&desk, "out --also larger -o again --size 128");
    assert!(text.contains("90 elements of 2 lichens"), "{text}");
    desk.done("rock.obj --radius 2% --elements 9 -o elsewhere");
    let wrong = [
        ("gone", 1, ["--also gone", "there is no such file"]),
        (
            "elsewhere",
            1,
            ["--also elsewhere", "another mesh than the first"],
        ),
        ("larger,puce", 2, ["puce", "--also larger,puce"]),
        (",xanthoria", 2, ["--also ,xanthoria", "no folder is named"]),
    ];
    for (also, code, parts) in wrong {
        refused(&desk, &format!("out --also {also} -o x"), code, &parts);
    }
    assert!(!desk.path("x").exists());
}

#[cfg(unix)]
#[test]
fn interrupted_it_leaves_nothing() {
    let desk = desk();
    let mut command = desk.call("bake", "out -o maps --size 4096 --samples 8");
    let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
    for _ in 0..300 {
        std::thread::sleep(Duration::from_millis(10));
        if desk.path("maps").exists() {
            break;
        }
    }
    let id = child.id().to_string();
    let kill = Command::new("kill").args(["-INT", &id]).status();
    assert!(kill.unwrap().success(), "it ended before");
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(names(desk.0.path()), ["cube.obj", "out", "rock.obj"]);
}

#[test]
fn what_is_there_is_overwritten_only_when_asked() {
    let desk = desk();
    made(&desk, "out -o maps --size 64 --quiet");
    refused(&desk, "out -o maps --size 64", 1, &["maps", "--force"]);
    made(&desk, "out -o maps --size 64 --quiet --force");
    // Maps in the other format would be taken for those of this lichen.
    fs::write(desk.path("maps/mine.exr"), "mine").unwrap();
    made(&desk, "out -o maps --size 64 --quiet --force --format exr");
    let there = names(&desk.path("maps"));
    assert!(
        there.iter().all(|name| !name.ends_with(".png")),
        "{there:?}"
    );
    assert!(there.contains(&"mine.exr".to_owned()), "{there:?}");
    made(&desk, "out -o maps --size 64 --quiet --force");
    assert_eq!(names(&desk.path("maps")).len(), there.len());
    let before = names(&desk.path("out"));
    refused(&desk, "out -o out --size 64", 1, &["--force"]);
    assert_eq!(names(&desk.path("out")), before);
}

/// Its texture, its mask and the base colour that it is given.
#[test]
fn what_it_is_read_from_is_not_overwritten() {
    let desk = desk();
    made(&desk, "out -o maps --size 64 --quiet");
    let image = desk.read("maps/color.png");
    let images = ["dressed/base_color.png", "masks/mask.png", "bases/orm.png"];
    for file in images {
        fs::create_dir(desk.path(file).parent().unwrap()).unwrap();
        fs::write(desk.path(file), &image).unwrap();
    }
    let library = "newmtl m\nmap_Kd base_color.png\n";
    fs::write(desk.path("dressed/a.mtl"), library).unwrap();
    let dressed = format!("mtllib a.mtl\nusemtl m\n{}", cube());
    fs::write(desk.path("dressed/cube.obj"), dressed).unwrap();
    desk.done("dressed/cube.obj --radius 2% --elements 60 -o on --mask masks/mask.png");
    for (words, file) in [
        ("on -o dressed", images[0]),
        ("on -o masks", images[1]),
        ("on -o bases --base bases/orm.png", images[2]),
    ] {
        let words = format!("{words} --size 64 --quiet --force");
        refused(&desk, &words, 2, &[&format!("{file} is read for this")]);
        let words = format!("on -o {file} --ground {file} --size 64x48 --force");
        let output = desk.call("render", &words).output().unwrap();
        assert_refused_in_a_line(&output, 2, &["is what the lichen is read from"]);
        assert_eq!(desk.read(file), image, "{file}");
    }
    let mut output = desk.call(
        "render on -o dressed/base_color.png --size 64x48",
        "--force",
    );
    let output = output.output().unwrap();
    assert_refused_in_a_line(&output, 2, &["is what the lichen is read from"]);
}

#[test]
fn wrong_requests_are_refused() {
    let desk = desk();
    refused(&desk, "out -o x --size 9000", 2, &["9000", "8192"]);
    refused(&desk, "out -o x --size -1", 2, &["--size"]);
    refused(&desk, "out -o x --gutter 1", 2, &["gutter", "2 to 64"]);
    refused(&desk, "out -o x --samples 9", 2, &["samples"]);
    refused(&desk, "out -o x --format jpg", 2, &["png", "exr"]);
    refused(&desk, "out -o x --thickness 99r", 2, &["thickness"]);
    refused(&desk, "out -o x --base #12", 2, &["--base"]);
    refused(
        &desk,
        "out -o x --base grey",
        2,
        &["--base", "stone or bark", "mesh"],
    );
    refused(&desk, "out -o x --base gone.png", 1, &["gone.png"]);
    refused(&desk, "out -o x --base cube.obj", 1, &["PNG"]);
    refused(&desk, "gone -o x", 1, &["gone"]);
    refused(
        &desk,
        "out -o maps.glb",
        2,
        &["maps.glb", "a folder of several files"],
    );
    assert!(!desk.path("maps.glb").exists());
    made(&desk, "out -o maps.glb/ --size 64 --quiet");
    assert!(!desk.path("x").exists());
}

/// Every triangle has a place in the image, and the file's own UVs are the second set.
#[test]
fn meshes_are_unwrapped() {
    let desk = desk();
    desk.done("rock.obj --radius 2% --elements 9 -o bare");
    fs::write(desk.path("grey.png"), grey()).unwrap();
    refused(
        &desk,
        "bare -o x --unwrap --base grey.png",
        1,
        &[
            "rock.obj",
            "no UVs of its own to lay grey.png",
            "--base stone",
        ],
    );
    for other in ["--uv-set 1", "--each tile"] {
        let words = format!("bare -o x --unwrap {other}");
        refused(&desk, &words, 2, &["--unwrap", other]);
    }
    let square = |k: u32| {
        let corners = [[0, 0], [0, 1], [1, 1], [1, 0]];
        let line = |[s, t]: [u32; 2]| format!("v {} {} {t}\n", 3 * k + s, k % 7);
        corners.map(line).concat() + "f -4 -3 -2 -1\n"
    };
    let dust: String = (0..300).map(square).collect();
    fs::write(desk.path("dust.obj"), dust).unwrap();
    desk.done("dust.obj --radius 0.1 --elements 9 -o dust");
    refused(&desk, "dust -o x --unwrap --size 16", 1, &["--size 32"]);
    assert!(!desk.path("x").exists());
    let told = made(&desk, "bare -o maps --size 128 --unwrap");
    assert!(told.contains("9 elements in 8 maps of 128 x 128"), "{told}");
    let (rock, worn) = load_textured(&desk.path("maps/lichened.glb")).unwrap();
    assert_eq!(rock.soup.triangles.len(), worn.uvs.len());
    let corners = worn.uvs.iter().map(|uvs| uvs.unwrap());
    let inside = |x: &f64| (0.0..=1.0).contains(x);
    assert!(corners.flatten().flatten().all(|x| inside(&x)));
    assert_eq!(worn.second_uvs, []);
    made(&desk, "out -o cube --size 64 --unwrap --base grey.png");
    let (_, worn) = load_textured(&desk.path("cube/lichened.glb")).unwrap();
    let (_, own) = load_textured(&desk.path("cube.obj")).unwrap();
    let sorted = |uvs: &[Option<[[f64; 2]; 3]>]| {
        let rounded = |uv: &[f64; 2]| uv.map(|x| (x * 1e5).round() as i64);
        let mut all: Vec<_> = uvs.iter().flatten().flatten().map(rounded).collect();
        all.sort_unstable();
        all
    };
    assert_eq!(sorted(&worn.second_uvs), sorted(&own.uvs));
    let color = worn.materials[0].base_color_texture.unwrap();
    assert!(worn.images[color.image] == desk.read("cube/base_color.png"));
}

/// One texel.
fn grey() -> Vec<u8> {
    let mut image = Vec::new();
    let mut encoder = png::Encoder::new(&mut image, 1, 1);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&[120; 3]).unwrap();
    drop(writer);
    image
}

/// The second side lies so many images beside the first, and above it.
fn folded_in_tiles(right: f64, up: f64) -> String {
    let lines = cube();
    let second = "f 5/5 6/6 8/7 7/8";
    let corners = [[0.01, 0.4], [0.15, 0.4], [0.15, 0.55], [0.01, 0.55]];
    let moved = corners.map(|[u, v]| format!("vt {} {}\n", u + right, v + up));
    assert!(lines.contains(second));
    lines.replace(second, &(moved.concat() + "f 5/-4 6/-3 8/-2 7/-1"))
}

/// Programs put triangles in another order, and cut quads along the other diagonal.
#[test]
fn a_mesh_with_other_triangles_of_the_same_surface_is_baked() {
    let desk = desk();
    let cube = cube();
    let (faces, others): (Vec<&str>, Vec<&str>) =
        cube.lines().partition(|line| line.starts_with('f'));
    let turned = faces.iter().rev().map(|face| {
        let corners: Vec<&str> = face[2..].split(' ').collect();
        format!(
            "f {} {} {} {}",
            corners[1], corners[2], corners[3], corners[0]
        )
    });
    let turned: Vec<String> = turned.collect();
    fs::write(
        desk.path("other.obj"),
        others.join("\n") + "\n" + &turned.join("\n"),
    )
    .unwrap();
    made(&desk, "out -o as-grown --size 128");
    made(&desk, "out -o other --size 128 --mesh other.obj");
    let [a, b] = ["as-grown", "other"].map(|folder| desk.read(&format!("{folder}/mask.png")));
    assert_eq!(a, b);
    // So has the mesh that came of it.
    made(
        &desk,
        "out -o again --size 128 --mesh as-grown/lichened.glb",
    );
}

#[test]
fn layouts_with_faults_are_told() {
    let desk = desk();
    desk.done("rock.obj --radius 2% --elements 9 -o bare");
    refused(
        &desk,
        "bare -o x",
        1,
        &["rock.obj", "no UVs", "with --unwrap"],
    );
    assert!(!desk.path("x").exists());
    let folded = cube().replace("f 5/5 6/6 8/7 7/8", "f 5/1 6/2 8/3 7/4");
    fs::write(desk.path("folded.obj"), folded).unwrap();
    let output = bake(&desk, "out -o folded --mesh folded.obj --size 128");
    let said = said(&output);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("4 triangles overlap"), "{said}");
    let torn = cube().replace("f 5/5 6/6 8/7 7/8", "f 5 6 8 7");
    fs::write(desk.path("torn.obj"), torn).unwrap();
    let output = bake(&desk, "out -o torn --mesh torn.obj --size 128");
    let said = desk::said(&output);
    assert!(said.contains("2 of 12 triangles have no UVs"), "{said}");
    let flat = cube().replace(" 0.55", " 0.4");
    fs::write(desk.path("flat.obj"), flat).unwrap();
    let packed = cube().replace("vt 0.01 0.4", "vt 4095 0.4");
    fs::write(desk.path("packed.obj"), packed).unwrap();
    for [u, v] in [[1.0, 0.0], [0.0, 1.0], [0.0, 2.0]] {
        fs::write(desk.path("tiles.obj"), folded_in_tiles(u, v)).unwrap();
        let output = bake(&desk, "out -o tiles --mesh tiles.obj --size 128 --force");
        let said = desk::said(&output);
        assert!(said.contains("with --each tile"), "{u} {v}: {said}");
    }
    let repeats = cube().replace("vt 0.01 0.4", "vt -7 0.4");
    fs::write(desk.path("repeats.obj"), repeats).unwrap();
    for (words, parts) in [
        ("--mesh flat.obj", ["no triangle has area", "with --unwrap"]),
        ("--mesh packed.obj", ["packed", "as it was before"]),
        (
            "--mesh repeats.obj",
            ["images wide", "or: bake with --unwrap"],
        ),
        (
            "--base rock.obj",
            ["rock.obj", "the image of the base colour cannot be read"],
        ),
    ] {
        refused(&desk, &format!("out -o y {words}"), 1, &parts);
    }
}
