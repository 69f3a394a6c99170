//! `thallus check` as a user meets it.

use std::fs;

#[path = "common/shell.rs"]
mod shell;

use shell::{Desk, PLANE, sheet};

#[test]
fn check_answers_in_json() {
    let desk = Desk::new();
    desk.put(
        "two.obj",
        format!(
            "{}\nv 50 0 0\nv 51 0 0\nv 50 0 1\nf 5 6 7\n",
            PLANE.trim_end()
        ),
    );
    let answer: serde_json::Value =
        serde_json::from_str(&desk.done("check two.obj --json").out).unwrap();
    let mut keys: Vec<_> = answer
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .collect();
    keys.sort_unstable();
    let mut expected = KEYS.to_vec();
    expected.sort_unstable();
    assert_eq!(keys, expected);
    assert_eq!(answer["triangles_read"], 3);
    assert_eq!(answer["components"].as_array().unwrap().len(), 2);
    assert_eq!(answer["components"][0]["area"], 100.0);
    assert_eq!(answer["boundary_edges"], 7);
    assert_eq!(answer["fit"], true);
    assert_eq!(
        (&answer["up"], &answer["uv_triangles"]),
        (&"y".into(), &0.into())
    );
    let warnings = answer["warnings"].to_string();
    assert!(
        warnings.contains("2 separate pieces: lichen cannot cross between them"),
        "{warnings}"
    );
    assert!(warnings.contains("7 open edges"), "{warnings}");
    let diagonal = (51f64 * 51.0 + 100.0).sqrt();
    assert!((answer["auto_radius"].as_f64().unwrap() - diagonal / 2000.0).abs() < 1e-12);
}

/// Its lichen would stand inside.
#[test]
fn a_stone_whose_faces_look_inwards_is_told() {
    let desk = Desk::new();
    let rock = rock();
    let without_last = |text: String| text.rsplit_once("f ").unwrap().0.to_owned();
    desk.put("turned.obj", turned(&rock));
    desk.put("open.obj", without_last(rock.clone()));
    desk.put("turned_open.obj", without_last(turned(&rock)));
    desk.put("rock.obj", rock);
    let inwards = "its faces look inwards";
    for (file, is_told) in [
        ("rock.obj", false),
        ("turned.obj", true),
        ("open.obj", false),
        ("turned_open.obj", true),
    ] {
        let said = desk.done(&format!("check {file}")).out;
        assert_eq!(said.contains(inwards), is_told, "{file}: {said}");
    }
    let grown = desk.done("grow turned.obj --elements 20 -o out");
    assert!(grown.err.contains(inwards), "{}", grown.err);
}

fn rock() -> String {
    let rock = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes/rock.obj");
    std::fs::read_to_string(rock).unwrap()
}

/// The same mesh, the other way round.
fn turned(obj: &str) -> String {
    let turned = |line: &str| match line.split_whitespace().collect::<Vec<_>>()[..] {
        ["f", a, b, c] => format!("f {a} {c} {b}\n"),
        _ => format!("{line}\n"),
    };
    obj.lines().map(turned).collect()
}

/// The rock and a tetrahedron of half its size, this far away along x.
fn with_tetrahedron(is_turned: bool, x: f64) -> String {
    let mut text = rock();
    let vertices = text.lines().filter(|line| line.starts_with("v ")).count();
    for [dx, y, z] in [
        [0.0, 0.0, 0.0],
        [0.5, 0.0, 0.0],
        [0.0, 0.5, 0.0],
        [0.0, 0.0, 0.5],
    ] {
        text += &format!("v {} {y} {z}\n", x + dx);
    }
    for [a, b, c] in [[1, 3, 2], [1, 2, 4], [2, 3, 4], [1, 4, 3]] {
        let [b, c] = if is_turned { [c, b] } else { [b, c] };
        text += &format!("f {} {} {}\n", vertices + a, vertices + b, vertices + c);
    }
    text
}

/// But not of hollows.
#[test]
fn a_smaller_piece_whose_faces_look_inwards_is_told() {
    let desk = Desk::new();
    let said = |text: String| {
        desk.put("a.obj", text);
        desk.done("check a.obj").out
    };
    let told = "the faces of 1 smaller piece look inwards (near (9.25, 0.25, 0.25))";
    let beside = said(with_tetrahedron(true, 9.0));
    assert!(beside.contains(told), "{beside}");
    for [is_turned, x] in [[0.0, 9.0], [1.0, 0.0], [0.0, 0.0]] {
        let said = said(with_tetrahedron(is_turned > 0.5, x));
        assert!(said.contains("2 separate pieces"), "{said}");
        assert!(!said.contains("look inwards"), "{said}");
    }
}

/// As terrain may whose triangles are wound the wrong way.
#[test]
fn open_ground_whose_faces_look_down_is_told() {
    let desk = Desk::new();
    let ground = "v 0 0 0\nv 1 0.3 0\nv 1 0 1\nv 0 0.2 1\nf 1 3 2\nf 1 4 3\n";
    desk.put("up.obj", ground);
    desk.put("down.obj", turned(ground));
    for (file, is_told) in [("up.obj", false), ("down.obj", true)] {
        let said = desk.done(&format!("check {file}")).out;
        assert_eq!(said.contains("its faces look down"), is_told, "{said}");
    }
}

/// A radius that a run refuses is no cure.
#[test]
fn vertices_far_off_are_told_with_a_radius_only_where_a_run_takes_it() {
    let desk = Desk::new();
    let rock = rock();
    let first = rock.lines().find(|line| line.starts_with("v ")).unwrap();
    for (far, is_named) in [(1e2, true), (1e4, false)] {
        desk.put("a.obj", rock.replacen(first, &format!("v {far} 0 0"), 1));
        let said = desk.done("check a.obj").out;
        assert!(
            said.contains("a few vertices lie far off; remove them"),
            "{said}"
        );
        let radius = said.split("or give --radius ").nth(1);
        assert_eq!(radius.is_some(), is_named, "{said}");
        let Some(radius) = radius.and_then(|rest| rest.split_whitespace().next()) else {
            continue;
        };
        desk.done(&format!("grow a.obj --radius {radius} --elements 2 -o out"));
    }
}

const KEYS: [&str; 21] = [
    "triangles_read",
    "triangles",
    "vertices",
    "components",
    "boundary_edges",
    "non_manifold_edges",
    "winding_conflicts",
    "degenerate_triangles",
    "duplicate_triangles",
    "area",
    "bounding_box",
    "edge_length",
    "auto_radius",
    "up",
    "uv_triangles",
    "maps",
    "objects",
    "materials",
    "repairs",
    "warnings",
    "fit",
];

#[test]
fn check_of_an_unfit_mesh_answers_in_json_too() {
    let desk = Desk::new();
    desk.put("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    let ran = desk.run("check line.obj --json");
    assert_eq!(ran.code, 1);
    let answer: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!(answer["fit"], false);
    assert!(KEYS.iter().all(|key| answer.get(key).is_some()), "{answer}");
    assert!(answer["warnings"][0].as_str().unwrap().contains("line.obj"));
}

/// Triangles of side 1 that touch nowhere.
fn confetti(n: usize) -> String {
    let triangle = |i: usize| {
        let (x, z) = (2 * (i % 5), 2 * (i / 5));
        let corner = 3 * i + 1;
        format!(
            "v {x} 0 {z}\nv {} 0 {z}\nv {x} 0 {}\nf {corner} {} {}\n",
            x + 1,
            z + 1,
            corner + 2,
            corner + 1
        )
    };
    (0..n).map(triangle).collect()
}

/// The plane, with a speck far off that makes `auto` large: 1/2000 of the distance.
fn with_speck(distance: f64) -> String {
    format!("{PLANE}v 0 {distance} 0\nv 1 {distance} 0\nv 0 {distance} 1\nf 5 6 7\n")
}

fn answer(said: &str) -> serde_json::Value {
    serde_json::from_str(said).unwrap()
}

#[test]
fn a_surface_without_room_is_unfit() {
    let desk = Desk::new();
    desk.put("speck.obj", with_speck(20_000.0));
    desk.fails(
        "check speck.obj",
        1,
        &["unfit", "speck.obj", "give --radius"],
    );
    let ran = desk.run("check speck.obj --json");
    assert_eq!(ran.code, 1);
    let answer = answer(&ran.out);
    assert_eq!(answer["fit"], false);
    assert!(answer["auto_radius"].as_f64().unwrap() > 0.0, "{answer}");
    let warning = answer["warnings"][0].as_str().unwrap();
    assert!(warning.contains("give --radius"), "{warning}");
}

/// Loose triangles, and a plane that is full with some fifty elements, with a few, and with less than one.
#[test]
fn check_and_grow_agree_on_what_is_fit() {
    let desk = Desk::new();
    for (mesh, warned, code) in [
        (confetti(20), "merge vertices", 0),
        (with_speck(1_400.0), "room for about 51 elements", 0),
        (with_speck(8_000.0), "room for about 1 element", 0),
        (with_speck(12_000.0), "room for about 0 elements", 1),
    ] {
        desk.put("mesh.obj", mesh);
        let checked = desk.run("check mesh.obj --json");
        let answer = answer(&checked.out);
        assert!(answer["warnings"].to_string().contains(warned), "{answer}");
        assert_eq!(
            (checked.code, answer["fit"] == true),
            (code, code == 0),
            "{warned}"
        );
        let grown = desk.run("grow mesh.obj -o out --force --elements 200");
        assert_eq!(grown.code, code, "{}", grown.err);
    }
}

#[test]
fn the_radius_that_check_proposes_is_one_to_grow_with() {
    let desk = Desk::new();
    desk.put("speck.obj", with_speck(20_000.0));
    let said = desk.run("check speck.obj").err;
    let proposed = said.split("--radius ").nth(1).unwrap();
    let radius = proposed.split(',').next().unwrap();
    desk.done(&format!("grow speck.obj --radius {radius} --elements 200"));
}

#[test]
fn no_radius_is_proposed_that_would_be_refused() {
    let desk = Desk::new();
    desk.put("far.obj", with_speck(1e9));
    let said = desk.run("check far.obj").err;
    assert!(
        said.contains("remove what lies far") && !said.contains("--radius"),
        "{said}"
    );
}

#[test]
fn few_loose_triangles_are_still_a_surface() {
    let desk = Desk::new();
    desk.put("tiles.obj", confetti(10));
    desk.done("check tiles.obj");
}

#[test]
fn check_warns_in_words() {
    let desk = Desk::new();
    desk.put(
        "fine.obj",
        sheet(400, |_, _| 0.0).replace("v 10 ", "v 4000 "),
    );
    desk.put("fin.obj", format!("{PLANE}v 5 5 5\nf 1 3 5\n"));
    let far = PLANE
        .replace("v 10 ", "v 50000010 ")
        .replace("v 0 ", "v 50000000 ");
    desk.put("far.obj", far);
    let spike = |high| move |i, j| if (i, j) == (20, 20) { high } else { 0.0 };
    desk.put("stray.obj", sheet(40, spike(5000.0)));
    desk.put("spiky.obj", sheet(40, spike(50.0)));
    // Fans and tubes of which few corners come first in their triangles.
    let rim = |i: i32| {
        let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 300.0).sin_cos();
        format!("v {cos} {sin} 0\nv {cos} {sin} 60\n")
    };
    let rims: String = (0..300).map(rim).collect();
    let fan: String = (1..299)
        .map(|i| format!("f 1 {} {}\n", 2 * i + 1, 2 * i + 3))
        .collect();
    let side = |i: i32| {
        let (a, b) = (2 * i + 1, (2 * i + 2) % 600 + 1);
        format!("f {a} {b} {}\nf {a} {} {}\n", b + 1, b + 1, a + 1)
    };
    desk.put("fan.obj", format!("{rims}{fan}"));
    desk.put(
        "tube.obj",
        format!("{rims}{}", (0..300).map(side).collect::<String>()),
    );
    let strips = |width: f64| {
        let ends = |i: i32| format!("v 0 0 {z}\nv 1 0 {z}\n", z = f64::from(i) * width);
        let quad = |i: i32| format!("f {} {} {} {}\n", i, i + 1, i + 3, i + 2);
        let places: String = (0..501).map(ends).collect();
        places + &(0..500).map(|i| quad(2 * i + 1)).collect::<String>()
    };
    desk.put("strips.obj", strips(1e-5));
    desk.put("planks.obj", strips(1e-3));
    desk.put("large.obj", PLANE.replace("10", "1000000"));
    desk.put("small.obj", PLANE.replace("10", "0.0000001"));
    for (mesh, said) in [
        ("fine.obj", "consider simplifying"),
        ("strips.obj", "crosses about 95 edges"),
        (
            "fin.obj",
            "1 edge with more than two triangles (near (5, 0, 5))",
        ),
        (
            "fin.obj",
            "for them it is 2 surfaces in 1 piece, the largest with",
        ),
        ("far.obj", "from its origin"),
        (
            "stray.obj",
            "a few vertices lie far off; remove them, or give --radius",
        ),
        ("large.obj", "units across"),
        ("small.obj", "units across"),
    ] {
        let ran = desk.done(&format!("check {mesh}"));
        let words = ran.out.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains(said), "{mesh}: {words}");
    }
    let uv = |some: &str| format!("{PLANE}vt 0 0\nvt 1 0\nvt 1 1\nf {some}\n");
    desk.put("some.obj", uv("1/1 2/2 3/3"));
    desk.put("bad.obj", uv("1/1 2/2 3/9"));
    let said = |mesh: &str| desk.done(&format!("check {mesh}")).out;
    assert!(
        said("some.obj").contains("1 of 3 triangles have some"),
        "{}",
        said("some.obj")
    );
    assert!(said("fan.obj").contains("with --unwrap"));
    assert!(
        said("bad.obj").contains("with --unwrap"),
        "{}",
        said("bad.obj")
    );
    assert!(!said("planks.obj").contains("long and thin"));
    for mesh in ["spiky.obj", "fan.obj", "tube.obj"] {
        let said = desk.done(&format!("check {mesh}")).out;
        assert!(!said.contains("far off"), "{said}");
        assert!(said.contains("y, as is usual in such files"), "{said}");
    }
}

/// A triangle with places in a texture for two of its corners.
fn put_two_places(desk: &Desk) {
    let corners = [[0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let bytes: Vec<u8> = corners
        .iter()
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    fs::write(desk.path("two.bin"), bytes).unwrap();
    let json = serde_json::json!({
        "asset": {"version": "2.0"},
        "buffers": [{"uri": "two.bin", "byteLength": 36}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
            {"componentType": 5126, "count": 2, "type": "VEC2"},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    });
    desk.put("two.gltf", json.to_string());
}

#[test]
fn check_warns_of_what_textures_lack() {
    let desk = Desk::new();
    let face = "vt 0 0\nvt 1 0\nvt 1 1\nusemtl a\nf 1/1 2/2 3/3\n";
    desk.put("bare.obj", format!("mtllib a.mtl\n{PLANE}{face}"));
    desk.put("a.mtl", "newmtl a\nmap_Kd gone.png\n");
    put_two_places(&desk);
    for (mesh, lacks) in [
        ("bare.obj", "gone.png is passed over"),
        ("two.gltf", "TEXCOORD_0 has 2 places for 3 vertices"),
    ] {
        let said = answer(&desk.done(&format!("check {mesh} --json")).out);
        let warnings = said["warnings"].as_array().unwrap();
        let is_told = |w: &serde_json::Value| w.as_str().unwrap().contains(lacks);
        assert!(warnings.iter().any(is_told), "{warnings:?}");
    }
}
