//! Lichen on named parts of a mesh: `--mask object:…` and `material:…`, what `check` lists, and `bake --only`.

mod common;
#[path = "common/desk.rs"]
mod desk;
#[path = "common/png.rs"]
mod png;

use std::fs;
use std::ops::Range;

use desk::{Desk, said};
use png::image;
use serde_json::{Value, json};
use thallus::export::read_elements;
use thallus::substrate::{Material, Texture, Texturing, load_textured};

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

/// What `check` says that maps of a mesh would be.
fn maps(desk: &Desk, mesh: &str) -> (Value, String) {
    let output = desk
        .call("check", &format!("{mesh} --json"))
        .output()
        .unwrap();
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    let output = desk.call("check", mesh).output().unwrap();
    (
        answer["maps"].clone(),
        said(&output) + &String::from_utf8_lossy(&output.stdout),
    )
}

#[test]
fn check_says_which_flags_give_each_place_texels_of_its_own() {
    let desk = desk();
    let (found, told) = maps(&desk, "parts.obj");
    assert_eq!(found["flags"], "--each object");
    assert_eq!(
        (&found["images"], &found["overlapping"]),
        (&3.into(), &0.0.into())
    );
    assert!(
        found["overlapping_without"].as_f64().unwrap() > 0.5,
        "{found}"
    );
    assert!(
        told.contains("maps          bake with --each object: no place shares texels with another, where without that"),
        "{told}"
    );
    let (found, told) = maps(&desk, "rock.obj");
    assert!(found.is_null() && !told.contains("  maps "), "{told}");
    // What repeats its image has no maps; one of two sets of coordinates may be without overlaps.
    let floor = "v 0 0 0\nv 0 0 1\nv 1 0 1\nvt 0 0\nvt 0 7\nvt 7 7\nf 1/1 2/2 3/3\n";
    fs::write(desk.path("floor.obj"), floor).unwrap();
    let (found, told) = maps(&desk, "floor.obj");
    assert!(found.is_null(), "{found}");
    assert!(
        told.contains("maps          none: triangle 0 is 7.00 images wide"),
        "{told}"
    );
    // Of one material a part repeats its image; by objects none does.
    let square = |x: u32| {
        let right = x + 1;
        format!(
            "v {x} 0 0\nv {x} 0 1\nv {right} 0 1\nv {right} 0 0\nf -4/1 -3/2 -2/3\nf -4/1 -2/3 -1/4\n"
        )
    };
    let corners = "vt 0 1\nvt 0 0\nvt 1 0\nvt 1 1\n";
    let many: String = (0..40)
        .map(|k| format!("o leaf{k}\nusemtl Leaf\n{}", square(2 * k + 2)))
        .collect();
    let branch = format!("{corners}o bark\nusemtl Bark\n{}{many}", square(0));
    fs::write(desk.path("branch.obj"), branch).unwrap();
    let (found, told) = maps(&desk, "branch.obj");
    assert_eq!(
        (&found["flags"], &found["parts_unfit"]),
        (&"--each object".into(), &0.into())
    );
    assert!(!told.contains("can have none"), "{told}");
    put_two_sets(&desk, "two.gltf");
    let (found, _) = maps(&desk, "two.gltf");
    assert_eq!(
        (&found["flags"], &found["overlapping"]),
        (&"--uv-set 1".into(), &0.0.into())
    );
}

/// Two squares beside each other, which share the first set of coordinates, and not the second.
fn put_two_sets(desk: &Desk, name: &str) {
    let square = |x: f32| {
        [
            [x, 0.0, 0.0],
            [x, 0.0, 1.0],
            [x + 1.0, 0.0, 1.0],
            [x + 1.0, 0.0, 0.0],
        ]
    };
    let corners: Vec<[f32; 3]> = [square(0.0), square(2.0)].concat();
    let first = corners
        .iter()
        .map(|[x, _, z]| [(x % 2.0).min(1.0) * 0.9, z * 0.9]);
    let second = corners.iter().map(|[x, _, z]| [x / 3.0, *z]);
    let uvs: Vec<[f32; 2]> = first.chain(second).collect();
    let numbers = corners.as_flattened().iter().chain(uvs.as_flattened());
    let mut bytes: Vec<u8> = numbers.flat_map(|x| x.to_le_bytes()).collect();
    let indices = [0u16, 4].map(|k| [k, k + 1, k + 2, k, k + 2, k + 3]);
    bytes.extend(indices.as_flattened().iter().flat_map(|i| i.to_le_bytes()));
    fs::write(desk.path("two.bin"), bytes).unwrap();
    let view = |offset, length| json!({"buffer": 0, "byteOffset": offset, "byteLength": length});
    let accessor = |view, component, count, kind| json!({"bufferView": view, "componentType": component, "count": count, "type": kind});
    let document = json!({
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "meshes": [{"primitives": [{
            "attributes": {"POSITION": 0, "TEXCOORD_0": 1, "TEXCOORD_1": 2}, "indices": 3,
        }]}],
        "accessors": [
            accessor(0, 5126, 8, "VEC3"), accessor(1, 5126, 8, "VEC2"), accessor(2, 5126, 8, "VEC2"),
            accessor(3, 5123, 12, "SCALAR"),
        ],
        "bufferViews": [view(0, 96), view(96, 64), view(160, 64), view(224, 24)],
        "buffers": [{"uri": "two.bin", "byteLength": 248}],
    });
    fs::write(desk.path(name), document.to_string()).unwrap();
}

#[test]
fn a_mask_may_be_laid_out_in_the_second_set_of_uvs() {
    let desk = desk();
    put_two_sets(&desk, "two.gltf");
    // In the second set the first square has u up to a third, and in the first both squares have it up to 0.9.
    fs::write(
        desk.path("left.png"),
        image(|u, _| f64::from(u8::from(u < 0.34))),
    )
    .unwrap();
    let words = "two.gltf --radius 0.01 --elements 300 --at random --colonies 8";
    let farthest = |folder: &str| {
        let elements = read_elements(&desk.path(folder).join("elements.ply")).unwrap();
        let along = elements.positions.iter().map(|p| p[0]);
        along.fold(0.0, f64::max)
    };
    let told = desk.done(&format!("{words} --mask left.png -o first"));
    assert!(told.contains("uv1:left.png is one in the second"), "{told}");
    assert!(farthest("first") > 2.0);
    let told = desk.done(&format!("{words} --mask uv1:left.png -o second"));
    assert!(!told.contains("two sets"), "{told}");
    assert!(farthest("second") < 1.01);
    desk.done("--recipe second -o again");
    desk.assert_same("again", "second");
    desk.done_on(
        2,
        &format!("{words} --elements 120 --mask uv1:left.png -o part")
            .replace("--elements 300 ", ""),
    );
    desk.done("--resume part --elements 300");
    desk.assert_same_elements("part", "second");
    // The same image in the other set is another mask.
    desk.fails(
        "--resume part --elements 310 --mask left.png",
        1,
        &["left.png", "is not the mask"],
    );
    desk.fails(
        "rock.obj --mask uv1:left.png -o none",
        1,
        &["uv1:left.png", "this one has none"],
    );
    desk.fails(
        "rock.obj --mask uv1:gone.png -o none",
        1,
        &["gone.png", "reading the mask failed"],
    );
}

#[test]
fn bake_proposes_flags_that_serve() {
    let desk = desk();
    put_two_sets(&desk, "two.gltf");
    desk.done("two.gltf --radius 0.01 --elements 100 --at random -o two");
    let bake = |words: &str| said(&desk.call("bake", words).output().unwrap());
    let told = bake("two -o first --size 64");
    assert!(
        told.contains("with --uv-set 1 no place of it shares texels"),
        "{told}"
    );
    let told = bake("two -o second --size 64 --uv-set 1");
    assert!(!told.contains("overlap"), "{told}");
    // One image for all tiles is repeated, and they are none of UDIM's.
    fs::write(desk.path("plaster.png"), image(|u, _| u)).unwrap();
    fs::write(
        desk.path("tiled.mtl"),
        "newmtl Plaster\nmap_Kd plaster.png\n",
    )
    .unwrap();
    let square = |x: u32| {
        let line = |[s, t]: [u32; 2]| format!("v {} 0 {t}\nvt {} {t}\n", x + s, x + s);
        let corners: String = [[0, 0], [0, 1], [1, 1], [1, 0]].map(line).concat();
        corners + "f -4/-4 -3/-3 -2/-2\nf -4/-4 -2/-2 -1/-1\n"
    };
    let squares: String = (0..3).map(square).collect();
    fs::write(
        desk.path("tiled.obj"),
        format!("mtllib tiled.mtl\nusemtl Plaster\n{squares}"),
    )
    .unwrap();
    desk.done("tiled.obj --radius 0.01 --elements 100 --at random -o tiled");
    let told = bake("tiled -o none --size 64");
    assert!(
        told.contains("a second set of UVs") && !told.contains("--each tile"),
        "{told}"
    );
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
        said(&none).contains("no UVs to lay maps out in"),
        "{}",
        said(&none)
    );
    assert!(none.status.code() == Some(1) && !desk.path("none").exists());
}

/// Two squares of two materials, each with its texture, moved and clamped, in the second of two sets of UVs, and colours
/// at the corners; lichen is on the first.
#[test]
fn a_part_without_lichen_keeps_what_it_wears() {
    let desk = Desk::new();
    put_two_looks(&desk, "two.gltf");
    desk.done("two.gltf --radius 0.01 --elements 60 --at 0.5,0,0.5 -o two");
    let bake = |words: &str| {
        let output = desk.call("bake", words).output().unwrap();
        assert!(output.status.success(), "{}", said(&output));
        (output.stdout.clone(), said(&output))
    };
    let (_, told) = bake("two -o maps --size 64 --each material");
    assert!(
        told.contains("'Moss' has no maps: in lichened.glb they wear what the mesh's file says"),
        "{told}"
    );
    assert!(desk.path("maps/Stone_mask.png").exists() && !desk.path("maps/Moss_mask.png").exists());
    let (answer, _) = bake("two -o json --size 64 --each material --json");
    let answer: Value = serde_json::from_slice(&answer).unwrap();
    assert_eq!(answer["parts_without_maps"], json!(["Moss"]));
    let (loaded, made) = load_textured(&desk.path("maps/lichened.glb")).unwrap();
    let (_, before) = load_textured(&desk.path("two.gltf")).unwrap();
    assert_eq!((loaded.soup.triangles.len(), &made.notes[..]), (4, &[][..]));
    // Materials come in the order in which they are written: those with maps first.
    let [_, kept] = &made.materials[..] else {
        panic!("{:?}", made.materials)
    };
    let [_, own] = &before.materials[..] else {
        panic!("{:?}", before.materials)
    };
    let image = |texturing: &Texturing, texture: Option<Texture>| {
        texturing.images[texture.unwrap().image].clone()
    };
    let bare = |material: &Material| {
        let texture = |texture: Option<Texture>| texture.map(|t| Texture { image: 0, ..t });
        Material {
            base_color_texture: texture(material.base_color_texture),
            normal_texture: texture(material.normal_texture),
            ..material.clone()
        }
    };
    let close = |a: [[f64; 3]; 2], b: [[f64; 3]; 2]| {
        let mut pairs = a.as_flattened().iter().zip(b.as_flattened());
        assert!(pairs.all(|(a, b)| (a - b).abs() < 1e-9), "{a:?} {b:?}");
    };
    let (found, expected) = (bare(kept), bare(own));
    let moved = |material: &Material| material.base_color_texture.unwrap().transform;
    close(moved(&found), moved(&expected));
    let straight = |mut material: Material| {
        let texture = material.base_color_texture.as_mut();
        texture.unwrap().transform = [[0.0; 3]; 2];
        material
    };
    assert_eq!(straight(found), straight(expected));
    assert_eq!(
        image(&made, kept.base_color_texture),
        image(&before, own.base_color_texture)
    );
    assert_eq!(
        image(&made, kept.normal_texture),
        image(&before, own.normal_texture)
    );
    // The second square's triangles are the last of both files, in whatever order.
    let corners = |texturing: &Texturing| {
        let of = |t: usize| {
            (
                texturing.uvs[t],
                texturing.second_uvs[t],
                texturing.colors[t],
            )
        };
        let mut all: Vec<String> = [2, 3].map(|t| format!("{:?}", of(t))).to_vec();
        all.sort();
        all
    };
    assert_eq!(corners(&made), corners(&before));
    // What is said to be in the file is in it: a part that lies where another does is not.
    let twice = std::fs::read_to_string(desk.path("two.gltf")).unwrap();
    let twice = twice.replace(r#""byteOffset":12"#, r#""byteOffset":0"#);
    fs::write(desk.path("twice.gltf"), twice).unwrap();
    desk.done("twice.gltf --radius 0.01 --elements 60 --at 0.5,0,0.5 -o twice");
    let (_, told) = bake("twice -o twice-maps --size 64 --each material");
    assert!(
        told.contains("'Moss' lies where other parts do") && !told.contains("has no maps"),
        "{told}"
    );
    let none = desk
        .call("bake", "twice -o none --only material:Moss")
        .output()
        .unwrap();
    assert!(
        none.status.code() == Some(1) && said(&none).contains("lies where other parts"),
        "{}",
        said(&none)
    );
    // With another base all parts have maps.
    bake("two -o stone --size 64 --each material --base stone");
    assert!(desk.path("stone/Moss_mask.png").exists());
}

fn put_two_looks(desk: &Desk, name: &str) {
    let square = |x: f32| {
        [
            [x, 0.0, 0.0],
            [x, 0.0, 1.0],
            [x + 1.0, 0.0, 1.0],
            [x + 1.0, 0.0, 0.0],
        ]
    };
    let corners: Vec<[f32; 3]> = [square(0.0), square(2.0)].concat();
    let first = corners.iter().map(|[x, _, z]| [x / 3.0, *z]);
    let second = corners
        .iter()
        .map(|[x, _, z]| [(x % 2.0).min(1.0), 1.0 - z]);
    let uvs: Vec<[f32; 2]> = first.chain(second).collect();
    let colors = corners.iter().map(|[x, _, z]| [x / 3.0, *z, 0.5]);
    let colors: Vec<[f32; 3]> = colors.collect();
    let numbers = corners.as_flattened().iter().chain(uvs.as_flattened());
    let numbers = numbers.chain(colors.as_flattened());
    let mut bytes: Vec<u8> = numbers.flat_map(|x| x.to_le_bytes()).collect();
    let indices = [0u16, 4].map(|k| [k, k + 1, k + 2, k, k + 2, k + 3]);
    bytes.extend(indices.as_flattened().iter().flat_map(|i| i.to_le_bytes()));
    fs::write(desk.path("looks.bin"), &bytes).unwrap();
    fs::write(desk.path("grey.png"), image(|u, v| u * v)).unwrap();
    fs::write(desk.path("up.png"), image(|u, _| 0.5 + 0.1 * u)).unwrap();
    let view = |offset, length| json!({"buffer": 0, "byteOffset": offset, "byteLength": length});
    let accessor = |view, component, count, kind| json!({"bufferView": view, "componentType": component, "count": count, "type": kind});
    let primitive = |indices, material| {
        json!({
            "attributes": {"POSITION": 0, "TEXCOORD_0": 1, "TEXCOORD_1": 2, "COLOR_0": 3},
            "indices": indices, "material": material,
        })
    };
    let mut halves = [
        accessor(4, 5123, 6, "SCALAR"),
        accessor(4, 5123, 6, "SCALAR"),
    ];
    halves[1]["byteOffset"] = 12.into();
    let [low, high] = halves;
    let document = json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_texture_transform"],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "meshes": [{"primitives": [primitive(4, 0), primitive(5, 1)]}],
        "materials": [
            {"name": "Stone", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}},
            {
                "name": "Moss",
                "pbrMetallicRoughness": {
                    "baseColorFactor": [0.5, 0.75, 0.25, 0.5],
                    "metallicFactor": 0.25,
                    "roughnessFactor": 0.5,
                    "baseColorTexture": {"index": 0, "texCoord": 1, "extensions": {"KHR_texture_transform": {
                        "offset": [0.25, -0.5], "rotation": 0.7, "scale": [2.0, -3.0],
                    }}},
                },
                "normalTexture": {"index": 1, "scale": 0.5},
                "alphaMode": "MASK",
                "alphaCutoff": 0.25,
                "doubleSided": true,
            },
        ],
        "textures": [{"source": 0, "sampler": 0}, {"source": 1}],
        "samplers": [{"wrapS": 33071, "wrapT": 33648}],
        "images": [{"uri": "grey.png"}, {"uri": "up.png"}],
        "accessors": [
            accessor(0, 5126, 8, "VEC3"), accessor(1, 5126, 8, "VEC2"), accessor(2, 5126, 8, "VEC2"),
            accessor(3, 5126, 8, "VEC3"), low, high,
        ],
        "bufferViews": [view(0, 96), view(96, 64), view(160, 64), view(224, 96), view(320, 24)],
        "buffers": [{"uri": "looks.bin", "byteLength": 344}],
    });
    fs::write(desk.path(name), document.to_string()).unwrap();
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
