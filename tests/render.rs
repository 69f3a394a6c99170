//! Pictures: laws of light on scenes that can be worked out, and `thallus render` as it is called.

#[path = "common/desk.rs"]
mod desk;
#[path = "render/light.rs"]
mod light;

use std::fs;
use std::io::Cursor;
use std::process::Output;

use desk::{Desk, assert_refused_in_a_line, names, said};
use thallus::picture::{
    Background, Camera, Coat, Detail, Disc, Finish, Ground, Image, Painted, Scene, Settings, Sight,
    Stone, Structure, World, render,
};

const GROWN: &str = "rock.obj --radius 0.6% --elements 250 -o out";

/// A picture small enough for tests.
const SMALL: &str = "--size 96x72 --samples 4";

fn run(desk: &Desk, words: &str) -> Output {
    desk.call("render", words).output().unwrap()
}

fn made(desk: &Desk, words: &str) -> serde_json::Value {
    let output = run(desk, &format!("{words} --json --force"));
    assert!(output.status.success(), "{words}: {}", said(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn refused(desk: &Desk, words: &str, code: i32, parts: &[&str]) {
    assert_refused_in_a_line(&run(desk, words), code, parts);
}

fn desk() -> Desk {
    let desk = Desk::new();
    desk.done(GROWN);
    desk
}

/// Width, height, bytes a pixel, and the pixels.
fn decoded(desk: &Desk, name: &str) -> (u32, u32, usize, Vec<u8>) {
    let mut reader = png::Decoder::new(Cursor::new(desk.read(name)))
        .read_info()
        .unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    (info.width, info.height, info.color_type.samples(), bytes)
}

#[test]
fn threads_change_no_byte() {
    let desk = desk();
    for what in ["skin", "points"] {
        for threads in [1, 2, 5] {
            let words = format!("out -o {threads}.png {SMALL} --what {what} --threads {threads}");
            made(&desk, &words);
        }
        let one = desk.read("1.png");
        assert!(
            one == desk.read("2.png") && one == desk.read("5.png"),
            "{what}"
        );
    }
}

/// Apothecia lie above the places that they are built about: drawn as if they lay in them, those of a thick skin were
/// torn, and a quarter larger.
#[test]
fn apothecia_of_thick_skins_are_as_wide_as_those_of_thin_ones() {
    let desk = Desk::new();
    let plane = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes/plane.obj");
    fs::copy(plane, desk.path("plane.obj")).unwrap();
    desk.done("plane.obj --elements 3000 --radius 0.4% --preset crustose -o out");
    let brown = |thickness: &str| {
        let look = format!("--colormap lecanora --thickness {thickness} --camera top --zoom 2");
        made(
            &desk,
            &format!("out -o {thickness}.png --size 240x240 --samples 4 {look}"),
        );
        let (_, _, samples, bytes) = decoded(&desk, &format!("{thickness}.png"));
        let is_brown =
            |pixel: &&[u8]| pixel[0] > 20 && 5 * u32::from(pixel[0]) > 8 * u32::from(pixel[2]);
        bytes.chunks(samples).filter(is_brown).count() as f64
    };
    let share = brown("8r") / brown("1.5r");
    assert!((share - 1.0).abs() < 0.15, "{share}");
}

#[test]
fn the_camera_that_is_told_takes_the_same_picture() {
    let desk = desk();
    let report = made(
        &desk,
        &format!("out -o a.png {SMALL} --camera 30,50 --zoom 1.5"),
    );
    assert_eq!(
        (&report["width"], &report["height"]),
        (&96.into(), &72.into())
    );
    assert_eq!(report["elements"], 250);
    fs::write(desk.path("camera.json"), report["camera"].to_string()).unwrap();
    made(&desk, &format!("out -o b.png {SMALL} --camera camera.json"));
    fs::write(desk.path("report.json"), report.to_string()).unwrap();
    made(&desk, &format!("out -o e.png {SMALL} --camera report.json"));
    assert!(desk.read("e.png") == desk.read("b.png"));
    let [a, b] = ["a.png", "b.png"].map(|name| decoded(&desk, name).3);
    let apart = a
        .iter()
        .zip(&b)
        .map(|(&a, &b)| f64::from(a.abs_diff(b)))
        .sum::<f64>();
    assert!(apart / (a.len() as f64) < 3.0, "{}", apart / a.len() as f64);
    made(&desk, &format!("out -o c.png {SMALL} --camera 210,50"));
    assert!(decoded(&desk, "c.png").3 != a);
    let past = r#"{"eye":[0,5,0],"target":[0,9,0.1]}"#;
    let cases = [
        (past, "the camera looks past it"),
        ("200,-60", "the mesh hides it"),
        ("auto", ""),
        ("30,50", ""),
    ];
    for (camera, why) in cases {
        let words = format!("out -o d.png {SMALL} --force --camera {camera}");
        let said = said(&run(&desk, &words));
        assert!(said.contains(why), "{camera}: {said}");
        assert_eq!(
            said.contains("no lichen"),
            !why.is_empty(),
            "{camera}: {said}"
        );
    }
}

/// A picture straight down on an element, whose colour is then in the middle.
fn middle_over(desk: &Desk, element: usize, flags: &str) -> [u8; 3] {
    let elements = thallus::export::read_elements(&desk.path("out/elements.ply")).unwrap();
    let (p, n) = (elements.positions[element], elements.normals[element]);
    let eye = [0, 1, 2].map(|k| p[k] + 40.0 * elements.radius * f64::from(n[k]));
    let camera = serde_json::json!({"eye": eye, "target": p, "opening": 0.2}).to_string();
    fs::write(desk.path("camera.json"), camera).unwrap();
    let words = "out -o z.png --size 9x9 --samples 64 --background #000000 --camera camera.json";
    made(desk, &format!("{words} {flags}"));
    let (_, _, _, bytes) = decoded(desk, "z.png");
    let at = 3 * (4 * 9 + 4);
    [bytes[at], bytes[at + 1], bytes[at + 2]]
}

/// Which of red and blue it is.
fn is_red([r, _, b]: [u8; 3]) -> bool {
    assert!(r.abs_diff(b) > 20, "{r} {b}");
    r > b
}

#[test]
fn colours_by_a_quantity_are_those_of_the_elements() {
    let desk = desk();
    let elements = thallus::export::read_elements(&desk.path("out/elements.ply")).unwrap();
    let probability = &elements.probability;
    let extreme = |sign: f32| {
        let by =
            |&a: &usize, &b: &usize| (sign * probability[a]).total_cmp(&(sign * probability[b]));
        // The seed did not stick to anything.
        (1..250).min_by(by).unwrap()
    };
    let steps = "--colormap 0:#ff0000,0.499:#ff0000,0.501:#0000ff,1:#0000ff";
    for what in ["points", "skin --resolution 0.3r"] {
        let over = |element, by: &str| {
            let flags = format!("--what {what} --by {by} {steps}");
            is_red(middle_over(&desk, element, &flags))
        };
        assert!(over(0, "birth") && !over(249, "birth"), "{what}");
        let (least, greatest) = (extreme(1.0), extreme(-1.0));
        assert!(over(least, "probability"), "{what}");
        assert!(!over(greatest, "probability"), "{what}");
        assert!(!over(0, "birth --range -10,0"), "{what}");
    }
}

#[test]
fn legends_change_their_corner_only() {
    let desk = desk();
    let view = "--size 500x400 --samples 1";
    for by in [
        "birth",
        "density",
        "rim",
        "probability",
        "order",
        "depth",
        "colony",
    ] {
        made(
            &desk,
            &format!("out -o a.png {view} --what points --by {by}"),
        );
        made(
            &desk,
            &format!("out -o b.png {view} --what points --by {by} --legend --unit μm"),
        );
        let [a, b] = ["a.png", "b.png"].map(|name| decoded(&desk, name).3);
        let differs = |x: usize, y: usize| {
            (0..3).any(|k| a[3 * (500 * y + x) + k] != b[3 * (500 * y + x) + k])
        };
        let changed: Vec<_> = (0..500 * 400)
            .filter(|i| differs(i % 500, i / 500))
            .collect();
        assert!(changed.len() > 3000, "{by}");
        assert!(
            changed.iter().all(|i| i % 500 < 250 && i / 500 > 200),
            "{by}"
        );
    }
}

/// Between them it is bare: the picture shows one of them.
#[test]
fn a_zoomed_picture_of_lichens_far_apart_shows_one() {
    let desk = Desk::new();
    let plane = "v 0 0 0\nv 10 0 0\nv 10 0 10\nv 0 0 10\nf 1 3 2\nf 1 4 3\n";
    fs::write(desk.path("plane.obj"), plane).unwrap();
    for (name, at) in [("one", "2,0,2"), ("two", "8,0,8")] {
        desk.done(&format!(
            "plane.obj --radius 0.2% --elements 60 --at {at} -o {name}"
        ));
    }
    for words in ["one --also two", "two --also one"] {
        let output = run(
            &desk,
            &format!("{words} -o {}.png {SMALL} --zoom 8 --force", &words[..3]),
        );
        assert!(output.status.success());
        assert_eq!(said(&output), "", "{words}");
        let words = format!("{words} -o {}.png {SMALL} --zoom 8", &words[..3]);
        let camera = made(&desk, &words)["camera"].clone();
        let [eye, target] = ["eye", "target"].map(|name| {
            let at = |axis: usize| camera[name][axis].as_f64().unwrap();
            [at(0), at(1), at(2)]
        });
        // Where the middle of the picture meets the plane.
        let share = eye[1] / (eye[1] - target[1]);
        let met = |axis: usize| eye[axis] + share * (target[axis] - eye[axis]);
        let is_near = |at: f64| (met(0) - at).abs() < 0.5 && (met(2) - at).abs() < 0.5;
        assert!(is_near(2.0) || is_near(8.0), "{words}: {camera}");
    }
}

#[test]
fn several_lichens_share_a_picture() {
    let desk = desk();
    desk.done("rock.obj --radius 0.6% --elements 150 --seed 5 --at 0.5,0.3,0.2 -o under");
    let report = made(
        &desk,
        &format!("out -o a.png {SMALL} --also under,xanthoria"),
    );
    assert_eq!(report["elements"], 400);
    desk.done("rock.obj --radius 0.9% --elements 60 --seed 5 -o large");
    for what in ["skin", "points"] {
        let picture = |words: &str| {
            made(&desk, &format!("{words} -o c.png {SMALL} --what {what}"));
            desk.read("c.png")
        };
        let alone = picture("out --colormap xanthoria");
        assert!(picture("out --also out,xanthoria") == alone, "{what}");
        let over = picture("out --colormap parmelia --also large,xanthoria");
        let under = picture("large --colormap xanthoria --also out,parmelia");
        assert!(over != under, "{what}");
    }
    made(
        &desk,
        &format!("out -o b.png {SMALL} --background transparent"),
    );
    assert_eq!(decoded(&desk, "b.png").2, 4);
}

/// A square of side 1 in OBJ, with UVs and a library of materials.
const TEXTURED: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 0 -1\nv 0 0 -1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
    usemtl rock\nf 1/1 2/2 3/3 4/4\n";

/// A PNG of two texels, one beside the other.
fn two_texels(left: [u8; 3], right: [u8; 3]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().unwrap();
    writer
        .write_image_data([left, right].as_flattened())
        .unwrap();
    drop(writer);
    bytes
}

const RED: [u8; 3] = [200, 0, 0];
const GREEN: [u8; 3] = [0, 200, 0];
const BLUE: [u8; 3] = [0, 0, 200];

/// Which of red, green and blue there is most of a quarter from the left and from the right; none if it is about grey.
/// The picture is of the unit square from above.
fn channels(desk: &Desk, words: &str) -> [Option<usize>; 2] {
    let camera = r#"{"eye":[0.5,3,-0.5],"target":[0.5,0,-0.5],"up":[0,0,-1],"opening":20}"#;
    fs::write(desk.path("above.json"), camera).unwrap();
    made(
        desk,
        &format!("{words} -o c.png --size 64x64 --background #000000 --camera above.json"),
    );
    let (_, _, _, bytes) = decoded(desk, "c.png");
    [16, 48].map(|x| {
        let at = 3 * (64 * 20 + x);
        let pixel = &bytes[at..at + 3];
        let most = (0..3).max_by_key(|&k| pixel[k]).unwrap();
        let others = [1, 2].map(|k| u32::from(pixel[(most + k) % 3]));
        (3 * u32::from(pixel[most]) > 4 * others[0].max(others[1])).then_some(most)
    })
}

#[test]
fn a_mesh_is_drawn_by_its_own_file() {
    let desk = Desk::new();
    fs::write(desk.path("a.obj"), TEXTURED).unwrap();
    fs::write(
        desk.path("a.mtl"),
        "newmtl rock\nKd 0 0 0\nmap_Kd two.png\n",
    )
    .unwrap();
    fs::write(desk.path("two.png"), two_texels(RED, GREEN)).unwrap();
    fs::write(desk.path("other.png"), two_texels(GREEN, BLUE)).unwrap();
    desk.done("a.obj --radius 0.2% --elements 20 -o a");
    let (red, green, blue) = (Some(0), Some(1), Some(2));
    for (ground, expected) in [
        ("", [red, green]),
        ("--ground mesh", [red, green]),
        ("--ground other.png", [green, blue]),
        ("--ground stone", [None; 2]),
        ("--ground #0000ff", [blue; 2]),
    ] {
        for what in ["skin", "points"] {
            let found = channels(&desk, &format!("a {ground} --what {what}"));
            assert_eq!(found, expected, "{ground} {what}");
        }
    }
    // What is not there is told, and drawn as stone.
    fs::remove_file(desk.path("two.png")).unwrap();
    assert_eq!(channels(&desk, "a"), [None; 2]);
    assert!(said(&run(&desk, "a -o d.png")).contains("two.png"));

    let painted = "v 0 0 0 .5 0 0\nv 1 0 0 0 .5 0\nv 1 0 -1 0 .5 0\nv 0 0 -1 .5 0 0\nf 1 2 3 4\n";
    fs::write(desk.path("b.obj"), painted).unwrap();
    desk.done("b.obj --radius 0.2% --elements 20 -o b");
    assert_eq!(channels(&desk, "b"), [red, green]);
    assert_eq!(channels(&desk, "b --ground bark"), [None; 2]);
    // Of one colour it is drawn as that only if somebody asks.
    fs::write(desk.path("b.obj"), painted.replace(".5", "0")).unwrap();
    assert_eq!(channels(&desk, "b"), [None; 2]);
    let bytes = desk.read("c.png");
    channels(&desk, "b --ground mesh");
    assert!(desk.read("c.png") != bytes);
    fs::write(desk.path("b.obj"), painted).unwrap();
    let gif = "b -o b.gif --frames 2 --width 32";
    let animated = |words: &str| {
        let output = desk
            .call("animate --force --quiet", &format!("{gif} {words}"))
            .output();
        assert!(output.unwrap().status.success(), "{words}");
        desk.read("b.gif")
    };
    assert!(
        animated("") == animated("--ground mesh") && animated("") != animated("--ground stone")
    );
    refused(
        &desk,
        "b -o e.png --ground other.png",
        1,
        &["b.obj", "UVs", "other.png"],
    );
    refused(&desk, "b -o e.png --ground gone.png", 1, &["gone.png"]);
    refused(
        &desk,
        "b -o e.png --ground grey",
        2,
        &["--ground", "stone or bark", "mesh", "PNG"],
    );

    let plain = "v 0 0 0\nv 1 0 0\nv 1 0 -1\nf 1 2 3\n";
    fs::write(desk.path("plain.obj"), plain).unwrap();
    desk.done("plain.obj --radius 0.2% --elements 20 -o plain");
    refused(
        &desk,
        "plain -o e.png --ground mesh",
        1,
        &["plain.obj", "no colours", "--ground"],
    );
}

/// A fault in what only looks depend on keeps nobody from a picture.
#[test]
fn broken_texture_coordinates_are_told_and_drawn_as_stone() {
    let desk = Desk::new();
    let bytes: Vec<u8> = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]
        .as_flattened()
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    fs::write(desk.path("a.bin"), bytes).unwrap();
    let gltf = r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":36,"uri":"a.bin"}],
        "bufferViews":[{"buffer":0,"byteLength":36}],
        "accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":3},
                     {"bufferView":0,"componentType":5126,"type":"VEC2","count":2}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1}}]}],"nodes":[{"mesh":0}]}"#;
    fs::write(desk.path("a.gltf"), gltf).unwrap();
    desk.done("a.gltf --radius 0.2% --elements 20 -o a");
    let output = run(&desk, &format!("a -o a.png {SMALL}"));
    assert!(output.status.success(), "{}", said(&output));
    assert!(said(&output).contains("TEXCOORD_0"), "{}", said(&output));
    refused(
        &desk,
        "a -o b.png --ground mesh",
        1,
        &["a.gltf", "TEXCOORD_0"],
    );
}

#[test]
fn what_is_wrong_is_said_in_one_line() {
    let desk = desk();
    for (words, code, parts) in [
        ("out -o a.jpg", 2, &["a.jpg", ".png"][..]),
        ("nowhere -o a.png", 1, &["nowhere"]),
        ("out -o a.png --size 0x5", 2, &["--size", "1600x1200"]),
        ("out -o a.png --camera 5", 2, &["--camera", "30,45"]),
        ("out -o a.png --camera 5,95", 2, &["elevation"]),
        ("out -o a.png --camera no.json", 1, &["no.json"]),
        ("out -o a.png --camera {}", 2, &["--camera", "eye"]),
        (
            "out -o a.png --background blue",
            2,
            &["--background", "transparent"],
        ),
        (
            "out -o a.png --legend --unit mm²",
            2,
            &["--unit", "'²'", "mm^2"],
        ),
        ("out -o a.png --by size", 2, &["--by", "density"]),
        ("out -o a.png --by birth --range 2,1", 2, &["--range"]),
        (
            "out -o a.png --by colony --range 0,1",
            2,
            &["--by colony", "--range"],
        ),
        ("out -o a.png --range 1,2", 2, &["--by"]),
        (
            "out -o a.png --by birth --colormap lichn",
            2,
            &["--colormap", "lichn"],
        ),
        ("out -o a.png --also nowhere", 1, &["nowhere"]),
        ("out -o a.png --also out,lichn", 2, &["lichn"]),
        ("out -o a.png --also out --by birth", 2, &["--also", "--by"]),
        (
            "out -o a.png --what points --falloff 3r",
            2,
            &["--falloff is for skins", "--what points"],
        ),
        ("out -o a.png --thickness 0", 2, &["thickness"]),
        (
            "out -o a.png --thickness auto",
            2,
            &["--thickness", "only the radius"],
        ),
        (
            "out -o a.png --areoles auto",
            2,
            &["--areoles", "only the radius"],
        ),
        (
            "out -o a.png --colormap foliose",
            2,
            &[
                "there is no colour map 'foliose'",
                "grow MESH --preset foliose",
            ],
        ),
        ("out -o a.png --zoom 0", 2, &["--zoom"]),
        ("out -o a.png --samples 0", 2, &["--samples"]),
    ] {
        refused(&desk, words, code, parts);
    }
    assert!(!names(desk.0.path()).contains(&"a.png".to_owned()));
    fs::write(desk.path("a.png"), "mine").unwrap();
    refused(&desk, "out -o a.png", 1, &["a.png", "--force"]);
    assert_eq!(desk.read("a.png"), b"mine");
}
