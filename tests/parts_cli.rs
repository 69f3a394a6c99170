//! Lichen on named parts of a mesh: `--mask object:…` and `material:…`, what `check` lists, and `bake --only`.

mod common;
#[path = "common/desk.rs"]
mod desk;

use std::fs;
use std::ops::Range;

use desk::{Desk, said};
use serde_json::Value;
use thallus::export::read_elements;

/// Three squares of side 1 beside one another in the plane y = 0, each with the whole image to itself.
fn desk() -> Desk {
    let desk = Desk::new();
    let square = |x: u32| {
        let right = x + 1;
        format!(
            "v {x} 0 0\nv {x} 0 1\nv {right} 0 1\nv {right} 0 0\nf -4/1 -3/2 -2/3\nf -4/1 -2/3 -1/4\n"
        )
    };
    let corners = "vt 0 1\nvt 0 0\nvt 1 0\nvt 1 1\n";
    let [left, middle, right] = [0, 1, 2].map(square);
    let parts = format!(
        "{corners}o Big Wall\nusemtl Brick\n{left}o Rock.001\ng odd all\nusemtl Granite\n{middle}o Rock.002\nusemtl Brick\n{right}"
    );
    fs::write(desk.path("parts.obj"), parts).unwrap();
    desk
}

/// How far along x a lichen over such a mask comes.
fn extent(desk: &Desk, mask: &str) -> Range<f64> {
    let folder = mask.replace([':', '*', '!', ',', '.'], "-");
    let words = "parts.obj --radius 0.01 --elements 300 --at random --colonies 6";
    desk.done(&format!("{words} --mask {mask} -o {folder}"));
    let elements = read_elements(&desk.path(&folder).join("elements.ply")).unwrap();
    let along = || elements.positions.iter().map(|p| p[0]);
    along().fold(f64::INFINITY, f64::min)..along().fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn lichen_keeps_to_named_parts() {
    let desk = desk();
    let is_within = |mask: &str, within: Range<f64>| {
        let found = extent(&desk, mask);
        let is_there = found.start >= within.start - 1e-6 && found.end <= within.end + 1e-6;
        assert!(is_there, "{mask}: {found:?}");
        assert!(
            found.end - found.start > 0.3 * (within.end - within.start),
            "{mask}: {found:?}"
        );
    };
    is_within("material:Granite", 1.0..2.0);
    is_within("object:!Rock*", 0.0..1.0);
    is_within("object:Rock.*", 1.0..3.0);
    is_within("object:odd", 1.0..3.0);
    let both = extent(&desk, "material:Brick");
    assert!(both.start < 1.0 && both.end > 2.0, "{both:?}");
}

#[test]
fn a_run_on_a_part_is_repeated_and_gone_on_with() {
    let desk = desk();
    let words = "parts.obj --radius 0.01 --at random --mask material:Granite --mask object:Rock*";
    desk.done(&format!("{words} --elements 400 -o whole"));
    desk.done_on(2, &format!("{words} --elements 150 -o part"));
    desk.done("--resume part --elements 400");
    desk.assert_same("part", "whole");
    desk.done("--recipe whole -o again");
    desk.assert_same("again", "whole");
    fs::create_dir(desk.path("else")).unwrap();
    let text = String::from_utf8(desk.read("parts.obj")).unwrap();
    fs::write(
        desk.path("else/parts.obj"),
        text.replace("Granite", "Basalt"),
    )
    .unwrap();
    let other = "--recipe whole --elements 20 -o other else/parts.obj";
    desk.fails(other, 1, &["no material called 'Granite'", "Brick, Basalt"]);
}

#[test]
fn names_that_are_not_there_are_refused() {
    let desk = desk();
    let fails = |mask: &str, code, parts: &[&str]| {
        desk.fails(&format!("parts.obj --mask {mask} -o none"), code, parts);
        assert!(!desk.path("none").exists());
    };
    fails(
        "material:Granit",
        1,
        &["parts.obj", "'Granit'", "Brick, Granite"],
    );
    fails(
        "object:Rock",
        1,
        &["no object called 'Rock'", "Big Wall, Rock.001, Rock.002"],
    );
    fails("object:", 2, &["--mask 'object:' chooses no triangles"]);
    fails("material:!Brick,Granite", 1, &["leaves no triangle"]);
    desk.fails(
        "rock.obj --mask material:Bark -o none",
        1,
        &["rock.obj", "no materials"],
    );
}

#[test]
fn check_lists_objects_and_materials() {
    let desk = desk();
    let output = desk.call("check", "parts.obj").output().unwrap();
    let told = String::from_utf8(output.stdout).unwrap();
    assert!(
        told.contains("3, by triangles: Big Wall (2), Rock.001 (2), Rock.002 (2)"),
        "{told}"
    );
    assert!(
        told.contains("2, by triangles: Brick (4), Granite (2)"),
        "{told}"
    );
    let output = desk.call("check", "parts.obj --json").output().unwrap();
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(answer["materials"][1]["name"], "Granite");
    assert_eq!(answer["objects"][0]["triangles"], 2);
}

/// The positions in a GLB of one mesh along x, least and greatest.
fn along_x(glb: &[u8]) -> [f64; 2] {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let json: Value = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    let place = json["meshes"][0]["primitives"][0]["attributes"]["POSITION"].as_u64();
    let accessor = &json["accessors"][place.unwrap() as usize];
    ["min", "max"].map(|end| accessor[end][0].as_f64().unwrap())
}

#[test]
fn maps_are_made_of_one_part() {
    let desk = desk();
    desk.done("parts.obj --radius 0.01 --elements 900 --at random --colonies 9 -o all");
    let whole = desk.call("bake", "all -o maps --size 64").output().unwrap();
    assert!(
        said(&whole).contains("--only material:NAME"),
        "{}",
        said(&whole)
    );
    let words = "all -o one --size 64 --only material:Granite";
    let part = desk.call("bake", words).output().unwrap();
    assert!(
        part.status.success() && !said(&part).contains("warning"),
        "{}",
        said(&part)
    );
    assert_eq!(along_x(&desk.read("maps/lichened.glb")), [0.0, 3.0]);
    assert_eq!(along_x(&desk.read("one/lichened.glb")), [1.0, 2.0]);
    let masks = ["maps", "one"].map(|folder| desk.read(&format!("{folder}/mask.png")));
    assert!(masks[0] != masks[1], "the first square's lichen is in both");
    let none = desk
        .call("bake", "all -o none --only material:Bark")
        .output()
        .unwrap();
    assert_eq!(none.status.code(), Some(1));
    assert!(said(&none).contains("Brick, Granite"), "{}", said(&none));
}

/// A square as Blender exports one with a colour attribute that its material does not show: white in the first set of
/// colours, and painted in the second, white where x is 1.
fn put_painted(desk: &Desk, first: f32, second: [f32; 4]) {
    let positions = [[0f32, 0., 0.], [0., 0., 1.], [1., 0., 1.], [1., 0., 0.]];
    let mut bytes: Vec<u8> = positions
        .as_flattened()
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    for brightness in [[first; 4], second].as_flattened() {
        bytes.extend([*brightness; 3].iter().flat_map(|x| x.to_le_bytes()));
    }
    bytes.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
    fs::write(desk.path("square.bin"), &bytes).unwrap();
    let view = |offset: usize, length: usize| {
        format!("{{\"buffer\":0,\"byteOffset\":{offset},\"byteLength\":{length}}}")
    };
    let views = [(0, 48), (48, 48), (96, 48), (144, 12)]
        .map(|(at, length)| view(at, length))
        .join(",");
    let vectors = |view: usize| {
        format!("{{\"bufferView\":{view},\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"}}")
    };
    let text = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"buffers\":[{{\"uri\":\"square.bin\",\"byteLength\":{}}}],\
         \"bufferViews\":[{views}],\"accessors\":[{},{},{},\
         {{\"bufferView\":3,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}}],\
         \"materials\":[{{\"name\":\"Bark\"}}],\
         \"meshes\":[{{\"name\":\"Plane\",\"primitives\":[{{\"attributes\":{{\"POSITION\":0,\"COLOR_0\":1,\"COLOR_1\":2}},\
         \"indices\":3,\"material\":0}}]}}],\"nodes\":[{{\"mesh\":0,\"name\":\"Trunk\"}}],\"scenes\":[{{\"nodes\":[0]}}],\"scene\":0}}",
        bytes.len(),
        vectors(0),
        vectors(1),
        vectors(2)
    );
    fs::write(desk.path("square.gltf"), text).unwrap();
}

const PAINTED: &str = "square.gltf --radius 0.004 --elements 300 --at random --mask vertex-colors";

#[test]
fn of_two_sets_of_colours_the_painted_one_is_the_mask() {
    let desk = Desk::new();
    put_painted(&desk, 1.0, [0.0, 0.0, 1.0, 1.0]);
    let told = desk.done(&format!("{PAINTED} -o painted"));
    assert!(told.contains("COLOR_1"), "{told}");
    let elements = read_elements(&desk.path("painted/elements.ply")).unwrap();
    assert!(elements.positions.iter().all(|p| p[0] > 1.0 / 16.0 - 1e-6));
    let share = desk.report("painted")["habitat_share"].as_f64().unwrap();
    assert!((0.92..0.95).contains(&share), "{share}");
    put_painted(&desk, 1.0, [1.0; 4]);
    let told = desk.done(&format!("{PAINTED} -o white"));
    assert!(told.contains("white everywhere"), "{told}");
    put_painted(&desk, 0.5, [0.0, 0.0, 1.0, 1.0]);
    desk.done(&format!("{PAINTED} -o first"));
    let share = desk.report("first")["habitat_share"].as_f64().unwrap();
    assert!(share > 0.99, "{share}");
}

#[test]
fn parts_of_gltf_are_named_by_node_mesh_and_material() {
    let desk = Desk::new();
    put_painted(&desk, 1.0, [1.0; 4]);
    for name in ["object:Trunk", "object:Plane", "material:Bark"] {
        let told = desk.done(&format!(
            "square.gltf --elements 20 --mask {name} -o {}",
            name.replace(':', "-")
        ));
        assert!(told.contains("white everywhere"), "{told}");
    }
    let text = String::from_utf8(desk.read("square.gltf")).unwrap();
    fs::write(desk.path("odd.gltf"), text.replace("\"Trunk\"", "7")).unwrap();
    let told = desk.done("odd.gltf --elements 20 --mask material:Bark -o odd");
    assert!(told.contains("white everywhere"), "{told}");
    desk.fails(
        "square.gltf --mask object:Stem -o none",
        1,
        &["called 'Stem': it has Trunk"],
    );
}

#[test]
fn a_grey_mask_at_the_vertices_is_not_the_rocks_colour() {
    let desk = Desk::new();
    put_painted(&desk, 0.2, [0.0; 4]);
    desk.done("square.gltf --radius 0.004 --elements 300 -o plain");
    desk.done(&format!("{PAINTED} -o masked"));
    let render = |from: &str| {
        let words = format!("{from} -o {from}.png --size 64x48");
        said(&desk.call("render", &words).output().unwrap())
    };
    assert!(!render("plain").contains("not shown as those"));
    let told = render("masked");
    assert!(told.contains("not shown as those"), "{told}");
    let maps = desk
        .call("bake", "masked -o maps --size 64")
        .output()
        .unwrap();
    assert!(said(&maps).contains("no UVs"), "{}", said(&maps));
}
