//! Lichen on named parts of a mesh: `--mask object:…` and `material:…`, what `check` lists, and `bake --only`.

mod common;
#[path = "common/desk.rs"]
mod desk;
#[path = "parts_cli/kept.rs"]
mod kept;
#[path = "parts_cli/layouts.rs"]
mod layouts;
#[path = "common/png.rs"]
mod png;

use std::fs;
use std::ops::Range;

use desk::{Desk, said};
use png::image;
use serde_json::{Value, json};
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

/// A view of glTF's only buffer.
fn view(offset: usize, length: usize) -> Value {
    json!({"buffer": 0, "byteOffset": offset, "byteLength": length})
}

fn accessor(view: usize, component: u32, count: usize, kind: &str) -> Value {
    json!({"bufferView": view, "componentType": component, "count": count, "type": kind})
}

/// What a GLB says.
fn said_in(glb: &[u8]) -> Value {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&glb[20..20 + length]).unwrap()
}

/// The positions in the meshes of a GLB along x, least and greatest.
fn along_x(glb: &[u8]) -> [f64; 2] {
    let json = said_in(glb);
    let meshes = json["meshes"].as_array().unwrap().iter();
    let primitives = meshes.flat_map(|mesh| mesh["primitives"].as_array().unwrap());
    let ends = primitives.map(|primitive| {
        let place = primitive["attributes"]["POSITION"].as_u64().unwrap();
        ["min", "max"].map(|end| json["accessors"][place as usize][end][0].as_f64().unwrap())
    });
    ends.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
        .unwrap()
}

/// The names of a GLB's things of one kind.
fn names(glb: &Value, kind: &str) -> Vec<String> {
    let all = glb[kind].as_array().unwrap().iter();
    all.map(|thing| thing["name"].as_str().unwrap().to_owned())
        .collect()
}

#[test]
fn maps_are_made_of_one_part() {
    let desk = desk();
    desk.done("parts.obj --radius 0.01 --elements 900 --at random --colonies 9 -o all");
    let whole = desk.call("bake", "all -o maps --size 64").output().unwrap();
    assert!(
        said(&whole).contains("with --each object no place"),
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
    let glb = said_in(&desk.read("maps/lichened.glb"));
    assert_eq!(names(&glb, "materials"), ["parts"], "of two names");
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

#[test]
fn each_part_has_maps_of_its_own_in_one_file() {
    let desk = desk();
    desk.done("parts.obj --radius 0.01 --elements 900 --at random --colonies 9 -o all");
    let bake = |words: &str| {
        let output = desk.call("bake", words).output().unwrap();
        assert!(output.status.success(), "{}", said(&output));
        said(&output) + &String::from_utf8(output.stdout).unwrap()
    };
    let told = bake("all -o by-object --size 64 --each object");
    assert!(
        !told.contains("overlap") && told.contains("each of 3 parts"),
        "{told}"
    );
    let glb = said_in(&desk.read("by-object/lichened.glb"));
    assert_eq!(
        names(&glb, "nodes"),
        ["parts", "Big Wall", "Rock.001", "Rock.002"]
    );
    assert_eq!(
        names(&glb, "materials"),
        ["Big Wall", "Rock.001", "Rock.002"]
    );
    assert_eq!(
        names(&glb, "images")[3..5],
        ["parts_Rock.001_base_color", "parts_Rock.001_normal"]
    );
    assert_eq!(glb["nodes"][0]["children"], serde_json::json!([1, 2, 3]));
    assert_eq!(along_x(&desk.read("by-object/lichened.glb")), [0.0, 3.0]);
    bake("all -o one --size 64 --only object:Rock.001");
    let same =
        |of_part: &str, alone: &str| assert!(desk.read(of_part) == desk.read(alone), "{of_part}");
    same("by-object/Rock.001_mask.png", "one/mask.png");
    same("by-object/Rock.001_normal.png", "one/normal.png");
    assert!(desk.read("by-object/Big_Wall_mask.png") != desk.read("one/mask.png"));

    // Two squares share the bricks' layout.
    let told = bake("all -o by-material --size 64 --each material");
    assert!(told.contains("'Brick': 4 triangles overlap"), "{told}");
    assert!(
        told.contains("with --each object --each material no place of it shares texels"),
        "{told}"
    );
    assert!(!told.contains("'Granite': "), "{told}");
    let glb = said_in(&desk.read("by-material/lichened.glb"));
    assert_eq!(
        names(&glb, "nodes"),
        ["parts", "Big Wall", "Rock.002", "Rock.001"]
    );
    assert_eq!(names(&glb, "materials"), ["Brick", "Granite"]);
    let maps: Value = serde_json::from_slice(&desk.read("by-material/maps.json")).unwrap();
    assert_eq!(maps["parts"][1]["part"], "Granite");
    assert_eq!(maps["parts"][1]["maps"][0]["file"], "Granite_mask.png");
    same("by-material/Granite_mask.png", "one/mask.png");

    // Of each object each material.
    let told = bake("all -o by-both --size 64 --each material --each object");
    assert!(!told.contains("overlap"), "{told}");
    same("by-both/Rock.001_Granite_mask.png", "one/mask.png");
    let told = bake("all -o granite --size 64 --only material:Granite --only object:Rock*");
    assert!(told.contains("elements in 8 maps"), "{told}");
    let glb = said_in(&desk.read("granite/lichened.glb"));
    assert_eq!(names(&glb, "materials"), ["Granite"]);
    assert_eq!(
        names(&glb, "nodes"),
        ["parts_material_Granite_object_Rock_"]
    );
    same("granite/mask.png", "one/mask.png");
    let none = "all -o none --size 64 --only material:Granite --only object:Big*";
    let none = desk.call("bake", none).output().unwrap();
    assert!(
        said(&none).contains("in all of 'material:Granite', 'object:Big*'"),
        "{}",
        said(&none)
    );

    // Another division leaves nothing of this one.
    bake("all -o by-material --size 64 --each object --only material:Brick --force");
    let mut left = fs::read_dir(desk.path("by-material")).unwrap();
    assert!(left.all(|file| {
        !file
            .unwrap()
            .file_name()
            .to_string_lossy()
            .starts_with("Granite")
    }));
    let mut answer = desk.call(
        "bake",
        "all -o again --size 64 --each object --only material:Brick --json",
    );
    let answer: Value = serde_json::from_slice(&answer.output().unwrap().stdout).unwrap();
    assert_eq!(answer["parts"].as_array().unwrap().len(), 2);
    assert_eq!(answer["parts"][0]["part"], "Big Wall");
    assert_eq!(answer["files"].as_array().unwrap().len(), 18);
}

/// Two squares, the second in the tile above and to the right of the first.
#[test]
fn each_tile_has_maps_of_its_own() {
    let desk = Desk::new();
    let square = |x: u32, [u, v]: [u32; 2]| {
        let corners = [[0, 0], [0, 1], [1, 1], [1, 0]];
        let line = |[s, t]: [u32; 2]| {
            let inside = |tile: u32, k: u32| f64::from(tile) + 0.1 + 0.8 * f64::from(k);
            format!("v {} 0 {t}\nvt {} {}\n", x + s, inside(u, s), inside(v, t))
        };
        let corners: String = corners.map(line).concat();
        format!("{corners}f -4/-4 -3/-3 -2/-2\nf -4/-4 -2/-2 -1/-1\n")
    };
    fs::write(
        desk.path("tiles.obj"),
        square(0, [0, 0]) + &square(1, [1, 1]),
    )
    .unwrap();
    desk.done("tiles.obj --radius 0.01 --elements 400 --at random --colonies 4 -o out");
    let whole = desk
        .call("bake", "out -o whole --size 64")
        .output()
        .unwrap();
    assert!(said(&whole).contains("--each tile"), "{}", said(&whole));
    let tiles = desk
        .call("bake", "out -o tiles --size 64 --each tile")
        .output()
        .unwrap();
    assert!(
        tiles.status.success() && !said(&tiles).contains("overlap"),
        "{}",
        said(&tiles)
    );
    let glb = said_in(&desk.read("tiles/lichened.glb"));
    assert_eq!(names(&glb, "materials"), ["1001", "1012"]);
    assert_eq!(names(&glb, "images")[0], "tiles_base_color.1001");
    // Each tile is what its square alone would be.
    let text = String::from_utf8(desk.read("tiles.obj")).unwrap();
    let parts = text.replacen("v 0 ", "o First\nv 0 ", 1).replacen(
        "v 1 0 0\nvt 1.1",
        "o Second\nv 1 0 0\nvt 1.1",
        1,
    );
    fs::write(desk.path("tiles.obj"), parts).unwrap();
    for (object, tile) in [("First", "1001"), ("Second", "1012")] {
        let words = format!("out -o {object} --size 64 --only object:{object}");
        let alone = desk.call("bake", &words).output().unwrap();
        assert!(alone.status.success(), "{}", said(&alone));
        let maps = [
            format!("tiles/mask.{tile}.png"),
            format!("{object}/mask.png"),
        ];
        assert!(desk.read(&maps[0]) == desk.read(&maps[1]), "{tile}");
    }
}

#[test]
fn a_part_without_uvs_has_no_maps_with_a_warning() {
    let desk = desk();
    let text = String::from_utf8(desk.read("parts.obj")).unwrap();
    let plate = "usemtl Plate\nv 0 -1 0\nv 0 -1 1\nv 1 -1 1\nf -3 -2 -1\n";
    fs::write(desk.path("plate.obj"), text + plate).unwrap();
    desk.done("plate.obj --radius 0.01 --elements 300 --at random -o plate");
    let done = desk
        .call("bake", "plate -o maps --size 64 --each material")
        .output()
        .unwrap();
    assert!(done.status.success(), "{}", said(&done));
    assert!(
        said(&done).contains("'Plate' has no UVs with area"),
        "{}",
        said(&done)
    );
    let glb = said_in(&desk.read("maps/lichened.glb"));
    assert_eq!(names(&glb, "materials"), ["Brick", "Granite", "Plate"]);
    assert!(!desk.path("maps/Plate_mask.png").exists());
    let words = "plate -o none --size 64 --each object --only material:Plate";
    let none = desk.call("bake", words).output().unwrap();
    assert!(
        said(&none)
            .contains("maps are to be made of 'Rock.002' only: there are no UVs to lay maps"),
        "{}",
        said(&none)
    );
    assert!(none.status.code() == Some(1) && !desk.path("none").exists());
}

/// There would be black maps.
#[test]
fn lichen_that_would_be_in_no_map_is_refused() {
    let desk = desk();
    let text = String::from_utf8(desk.read("parts.obj")).unwrap();
    let plate = "o Plate\nv 0 -1 0\nv 0 -1 1\nv 1 -1 1\nf -3 -2 -1\n";
    fs::write(desk.path("plate.obj"), text + plate).unwrap();
    desk.done("plate.obj --radius 0.01 --elements 60 --mask object:Plate -o plate");
    for words in [
        "",
        "--each object",
        "--only object:Rock*",
        "--base stone --each object",
    ] {
        let words = format!("plate -o none --size 64 {words}");
        let refused = desk.call("bake", &words).output().unwrap();
        let told = said(&refused);
        assert_eq!(refused.status.code(), Some(1), "{words}: {told}");
        assert!(told.contains("'Plate'"), "{words}: {told}");
        assert!(!desk.path("none").exists(), "{words}");
    }
    let words = "plate -o none --size 64 --only object:Rock*";
    let told = said(&desk.call("bake", words).output().unwrap());
    assert!(
        told.contains("no element of the lichen would be in a map: it is on the object 'Plate'")
            && told.contains("--mask 'object:!Plate'")
            && told.contains("lay that out with --unwrap"),
        "{told}"
    );
    let words = "plate -o none --size 64 --only object:Rock* --unwrap";
    let told = said(&desk.call("bake", words).output().unwrap());
    assert!(
        told.contains("'Plate'") && told.contains("; choose with --only what has lichen"),
        "{told}"
    );
    desk.done("plate.obj --radius 0.01 --elements 60 --mask object:Plate -o plate --force");
    // UVs without area are no place either.
    let flat = String::from_utf8(desk.read("plate.obj")).unwrap();
    let flat = flat.replace("f -3 -2 -1", "vt 0.5 0.5\nf -3/-1 -2/-1 -1/-1");
    fs::write(desk.path("flat.obj"), flat).unwrap();
    let words = "plate -o none --size 64 --mesh flat.obj";
    let refused = desk.call("bake", words).output().unwrap();
    assert_eq!(refused.status.code(), Some(1), "{}", said(&refused));
}

#[test]
fn a_part_that_cannot_be_baked_is_named_with_the_cure() {
    let desk = desk();
    let text = String::from_utf8(desk.read("parts.obj")).unwrap();
    let floor =
        "usemtl Floor\nv 0 -1 0\nv 0 -1 1\nv 1 -1 1\nvt 0 0\nvt 0 7\nvt 7 7\nf -3/-3 -2/-2 -1/-1\n";
    fs::write(desk.path("floor.obj"), text + floor).unwrap();
    desk.done("floor.obj --radius 0.01 --elements 300 --at random -o floor");
    let refused = desk
        .call("bake", "floor -o maps --size 64 --each material")
        .output()
        .unwrap();
    assert_eq!(refused.status.code(), Some(1));
    let told = said(&refused);
    assert!(
        told.contains("material 'Floor'") && told.contains("7.00 images wide"),
        "{told}"
    );
    assert!(
        told.contains("--only 'material:!Floor'") && !desk.path("maps").exists(),
        "{told}"
    );
    assert!(!told.contains("triangles overlap"), "asked first: {told}");
    let words = "floor -o maps --size 64 --each material --only material:!Floor";
    let done = desk.call("bake", words).output().unwrap();
    assert!(done.status.success(), "{}", said(&done));
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
    let alone = "\"nodes\":[{\"mesh\":0";
    let below = "\"nodes\":[{\"name\":\"Tree\",\"children\":[1]},{\"mesh\":0";
    let group = text.replacen(alone, below, 1);
    fs::write(desk.path("group.gltf"), group).unwrap();
    let told = desk.done("group.gltf --elements 20 --mask object:Tree -o group");
    assert!(told.contains("white everywhere"), "{told}");
    // A material that cannot be read takes no names with it.
    let odd = text.replace("\"Trunk\"", "7");
    let odd = odd.replace(
        "{\"name\":\"Bark\"}",
        "{\"name\":\"Bark\",\"alphaCutoff\":\"x\"}",
    );
    fs::write(desk.path("odd.gltf"), odd).unwrap();
    let told = desk.done("odd.gltf --elements 20 --mask material:Bark -o odd");
    assert!(told.contains("white everywhere"), "{told}");
    desk.fails(
        "square.gltf --mask object:Stem -o none",
        1,
        &["called 'Stem': it has Trunk"],
    );
    // A name of nothing but space is none.
    fs::write(desk.path("blank.gltf"), text.replace("\"Trunk\"", "\" \"")).unwrap();
    desk.fails(
        "blank.gltf --mask object:Stem -o none",
        1,
        &["called 'Stem': it has Plane"],
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
