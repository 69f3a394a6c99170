//! `--mask` and `--slope`, as typed.

mod common;
#[path = "common/desk.rs"]
mod desk;
#[path = "common/png.rs"]
mod png;

use std::fs;

use desk::{Desk, assert_refused, assert_refused_in_a_line, said};
use png::{TEXELS, image};
use serde_json::json;
use thallus::export::{Elements, read_elements};

/// A desk with a square of side 1 in the plane y = 0, whose image is x by z, and a mask: white where x is from 0.1 to
/// 0.5.
fn desk() -> Desk {
    let desk = Desk::new();
    let square = "v 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nvt 0 1\nvt 0 0\nvt 1 0\nvt 1 1\n\
                  f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";
    fs::write(desk.path("square.obj"), square).unwrap();
    let left = |u: f64, _| f64::from((0.1..0.5).contains(&u));
    fs::write(desk.path("left.png"), image(left)).unwrap();
    desk
}

const SQUARE: &str = "square.obj --radius 0.004 --elements 600";

fn elements(desk: &Desk, folder: &str) -> Elements {
    read_elements(&desk.path(folder).join("elements.ply")).unwrap()
}

fn recipe(desk: &Desk, folder: &str) -> toml::Table {
    let text = String::from_utf8(desk.read(&format!("{folder}/recipe.toml"))).unwrap();
    text.parse().unwrap()
}

#[test]
fn masks_and_slopes_are_kept_to_and_kept_in_the_recipe() {
    let desk = desk();
    desk.done(&format!("{SQUARE} --mask left.png --at random -o left"));
    let elements = elements(&desk, "left");
    assert_eq!(elements.len(), 600);
    // Texels beside white ones are grey in part.
    let texel = 1.0 / f64::from(TEXELS);
    let white = 0.1 - texel..0.5 + texel;
    assert!(elements.positions.iter().all(|p| white.contains(&p[0])));
    let recipe = recipe(&desk, "left");
    assert_eq!(recipe["mask"].as_str(), Some("left.png"));
    assert_eq!(recipe["mask-hash"].as_str().map(str::len), Some(64));
    let share = desk.report("left")["habitat_share"].as_f64().unwrap();
    assert!((share - 0.4).abs() < 0.02, "{share}");
    let told = desk.done("square.obj --radius 0.001 --elements 20 --mask left.png -o top");
    assert!(
        told.contains("note: at top: ") && told.contains(" away, "),
        "{told}"
    );
    desk.done("rock.obj --radius 0.2% --elements 300 --slope 20,70 --at random -o steep");
    let text = String::from_utf8(desk.read("steep/recipe.toml")).unwrap();
    assert!(text.contains("slope = [20.0, 70.0]"), "{text}");
    desk.done("--recipe steep/recipe.toml -o steep-again");
    desk.assert_same("steep-again", "steep");
    desk.done("--recipe steep --slope 0,180 --mask none --at top -o anywhere");
    desk.done("rock.obj --radius 0.2% --elements 300 -o bare");
    assert_eq!(
        desk.read("anywhere/elements.ply"),
        desk.read("bare/elements.ply")
    );
}

#[test]
fn a_run_with_a_mask_is_repeated_and_gone_on_with() {
    let desk = desk();
    desk.done(&format!("{SQUARE} --mask left.png -o whole"));
    desk.done_on(3, &format!("{SQUARE} --mask left.png -o threads"));
    desk.assert_same("threads", "whole");
    desk.done("square.obj --radius 0.004 --elements 250 --mask left.png -o part");
    desk.done("--resume part --elements 600");
    desk.assert_same("part", "whole");
    // From another folder, by the mask beside the recipe's.
    fs::create_dir(desk.path("away")).unwrap();
    let mut away = desk.call(
        "grow --preview 32",
        "--recipe ../whole/recipe.toml -o ../again",
    );
    let output = away.current_dir(desk.path("away")).output().unwrap();
    assert!(output.status.success(), "{}", said(&output));
    desk.assert_same("again", "whole");
    // Moved.
    desk.done("square.obj --radius 0.004 --elements 250 --mask left.png -o moved");
    fs::rename(desk.path("left.png"), desk.path("there.png")).unwrap();
    desk.fails(
        "--resume moved --elements 600",
        1,
        &["left.png", "reading the mask failed"],
    );
    desk.done("--resume moved --elements 600 --mask there.png");
    assert_eq!(
        desk.read("moved/elements.ply"),
        desk.read("whole/elements.ply")
    );
    // Changed.
    fs::write(desk.path("left.png"), image(|_, _| 1.0)).unwrap();
    desk.fails(
        "--recipe whole -o changed",
        1,
        &["left.png is not the mask", "--mask"],
    );
    desk.fails(
        "--resume part --elements 700",
        1,
        &["left.png is not the mask"],
    );
    desk.fails(
        "--resume part --elements 700 --mask left.png",
        1,
        &["left.png is not the mask", "--mask"],
    );
    desk.done("square.obj --radius 0.004 --elements 20 -o bare");
    desk.done("--resume bare --elements 30 --mask none");
    for (mask, run, says) in [
        ("none", "part", "the run has a mask"),
        ("left.png", "bare", "the run has no mask"),
    ] {
        desk.fails(&format!("--resume {run} --mask {mask}"), 2, &[says]);
    }
    desk.done("--recipe whole --mask left.png -o changed");
}

/// A second lichen beside a first one and on the left; the first is then changed.
#[test]
fn lichens_grow_beside_those_of_other_runs() {
    let desk = desk();
    desk.done("square.obj --radius 0.006 --elements 300 --at 0.4,0,0.5 -o first");
    let layers = "--mask first --mask left.png";
    desk.done(&format!("{SQUARE} {layers} --at 0.2,0,0.45 -o second"));
    let [first, second] = ["first", "second"].map(|folder| elements(&desk, folder));
    assert_eq!(second.len(), 600);
    let apart = |p: &[f64; 3], q: &[f64; 3]| (p[0] - q[0]).hypot(p[2] - q[2]);
    let nearest = second
        .positions
        .iter()
        .flat_map(|p| first.positions.iter().map(move |q| apart(p, q)))
        .fold(f64::MAX, f64::min);
    assert!(nearest > 0.01 - 1e-8 && nearest < 0.02, "{nearest}");
    assert!(
        second
            .positions
            .iter()
            .all(|p| (0.09..0.51).contains(&p[0]))
    );
    let layers: Vec<_> = recipe(&desk, "second")["mask"].as_array().unwrap().clone();
    assert_eq!(layers, ["first", "left.png"].map(toml::Value::from));
    desk.done("--recipe second -o again");
    desk.assert_same("again", "second");
    desk.done("--recipe second --elements 250 -o part");
    desk.done("--resume part --elements 600");
    desk.assert_same("part", "second");
    // In another order, and not over what it grew beside.
    desk.done("--recipe second --elements 250 -o other");
    desk.done("--resume other --elements 600 --mask left.png --mask first");
    desk.assert_same_elements("other", "second");
    desk.fails(
        "square.obj -o first --mask first --force",
        2,
        &["--mask first is what the run itself writes"],
    );
    let picture = |name: &str| {
        let words = format!("second --also first -o {name}.png --size 32x32 --samples 1");
        let output = desk.call("render", &words).output().unwrap();
        assert!(output.status.success(), "{}", said(&output));
        said(&output)
    };
    assert!(!picture("before").contains("grew beside"));
    desk.done("square.obj --radius 0.006 --elements 900 --at 0.3,0,0.45 -o first --force");
    let told = picture("after");
    assert!(told.contains("second grew beside first"), "{told}");
    assert!(told.contains("--recipe second --mask first"), "{told}");
    // An image in the folder of a run is not that run.
    fs::copy(desk.path("left.png"), desk.path("first/left.png")).unwrap();
    desk.done(&format!(
        "{SQUARE} --mask first/left.png --at 0.3,0,0.45 -o over"
    ));
    let render = "over --also first -o over.png --size 32x32 --samples 1";
    let told = said(&desk.call("render", render).output().unwrap());
    assert!(!told.contains("grew beside"), "{told}");
    desk.fails(
        "--recipe second -o changed",
        1,
        &["error: first is not the mask"],
    );
}

/// The folder that is called from has another one of that name.
#[test]
fn of_several_layers_of_a_name_the_right_one_is_found() {
    let desk = desk();
    fs::create_dir(desk.path("a")).unwrap();
    fs::copy(desk.path("square.obj"), desk.path("a/square.obj")).unwrap();
    fs::copy(desk.path("left.png"), desk.path("a/left.png")).unwrap();
    let in_a = |words: &str| {
        let mut command = desk.call("grow --preview 32", words);
        let output = command.current_dir(desk.path("a")).output().unwrap();
        assert!(output.status.success(), "{}", said(&output));
    };
    in_a("square.obj --radius 0.006 --elements 100 --at 0.4,0,0.5 -o first");
    in_a(
        "square.obj --radius 0.004 --elements 100 --mask first --mask left.png --at random -o second",
    );
    desk.done("square.obj --radius 0.006 --elements 50 --at 0.4,0,0.5 -o first");
    fs::write(desk.path("left.png"), image(|_, _| 1.0)).unwrap();
    desk.done("--recipe a/second -o again");
    desk.assert_same_elements("again", "a/second");
    desk.fails(
        "--resume again --elements 120 --mask a/left.png",
        1,
        &["a/left.png: these are 1 of the 2 masks"],
    );
}

#[test]
fn what_is_no_lichen_to_grow_beside_is_refused() {
    let desk = desk();
    fs::create_dir(desk.path("folder")).unwrap();
    desk.done("rock.obj --elements 20 -o rock");
    for (flags, code, says) in [
        (
            "--mask folder",
            1,
            ["--mask: ", "the folder that thallus grow made"],
        ),
        ("--mask rock", 1, ["--mask: rock", "mesh"]),
        (
            "--mask left.png --mask none",
            2,
            ["--mask none", "leave out"],
        ),
    ] {
        desk.fails(&format!("square.obj {flags} -o refused"), code, &says);
        assert!(!desk.path("refused").exists(), "{flags}");
    }
}

/// A square of side 1 that a box stands in, which covers a quarter of it.
#[test]
fn lichen_inside_other_pieces_is_told_of_and_kept_out() {
    let desk = desk();
    let corner = |k: u32| [k & 1, k >> 1 & 1, k >> 2 & 1].map(|bit| f64::from(bit) * 0.5 + 0.25);
    let corners = (0..8).map(corner);
    let line = |[x, y, z]: [f64; 3]| format!("v {x} {} {z}\n", y - 0.4);
    let faces = "f 7 8 6 5\nf 10 9 5 6\nf 11 12 8 7\nf 9 11 7 5\nf 12 10 6 8\nf 9 10 12 11\n";
    let square = "v 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nf 1 2 3 4\n";
    let text = square.to_owned() + &corners.map(line).collect::<String>() + faces;
    fs::write(desk.path("stand.obj"), text).unwrap();
    let words = "stand.obj --radius 0.005 --at 0.2,0,0.2 --elements 4000";
    let told = desk.done(&format!("{words} -o open"));
    assert!(
        told.contains("inside other pieces of the mesh") && told.contains("--mask exposed"),
        "{told}"
    );
    desk.done(&format!("{words} --mask exposed -o exposed"));
    let is_inside = |p: &&[f64; 3]| [p[0], p[2]].iter().all(|x| (x - 0.5).abs() < 0.249);
    let inside = |folder: &str| {
        elements(&desk, folder)
            .positions
            .iter()
            .filter(is_inside)
            .count()
    };
    assert!(inside("open") > 100 && inside("exposed") == 0);
    assert_eq!(recipe(&desk, "exposed")["mask"].as_str(), Some("exposed"));
    desk.done("--recipe exposed -o again");
    desk.assert_same("again", "exposed");
    let told = desk.done("rock.obj --elements 20 --mask exposed -o one");
    assert!(told.contains("white everywhere"), "{told}");
}

/// A square of side 1 in the plane y = 0 as glTF, whose material is cut out of an image: what is left of x = 0.5 is
/// there.
fn write_leaf(desk: &Desk, name: &str, alpha_mode: &str) {
    let corners: [[f32; 3]; 4] = [
        [0.0, 0.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 1.0],
        [1.0, 0.0, 0.0],
    ];
    let uvs = corners.map(|[x, _, z]| [x, z]);
    let numbers = corners.as_flattened().iter().chain(uvs.as_flattened());
    let mut bytes: Vec<u8> = numbers.flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
    fs::write(desk.path("leaf.bin"), bytes).unwrap();
    let texels = [[60, 160, 60, 255], [60, 160, 60, 0]].repeat(2);
    let mut image = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut image, 2, 2);
    encoder.set_color(::png::ColorType::Rgba);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(texels.as_flattened()).unwrap();
    writer.finish().unwrap();
    fs::write(desk.path("leaf.png"), image).unwrap();
    let view = |offset, length| json!({"buffer": 0, "byteOffset": offset, "byteLength": length});
    let accessor = |view, component, count, kind| json!({"bufferView": view, "componentType": component, "count": count, "type": kind});
    let mut positions = accessor(0, 5126, 4, "VEC3");
    positions["min"] = json!([0, 0, 0]);
    positions["max"] = json!([1, 0, 1]);
    let document = json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{
            "attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0,
        }]}],
        "materials": [{
            "alphaMode": alpha_mode,
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
        }],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"wrapS": 33071, "wrapT": 33071}],
        "images": [{"uri": "leaf.png"}],
        "accessors": [positions, accessor(1, 5126, 4, "VEC2"), accessor(2, 5123, 6, "SCALAR")],
        "bufferViews": [view(0, 48), view(48, 32), view(80, 12)],
        "buffers": [{"uri": "leaf.bin", "byteLength": 92}],
    });
    fs::write(desk.path(name), document.to_string()).unwrap();
}

#[test]
fn lichen_on_what_is_cut_out_is_told_of_and_kept_out() {
    let desk = desk();
    write_leaf(&desk, "leaf.gltf", "MASK");
    write_leaf(&desk, "card.gltf", "OPAQUE");
    let words = |mesh: &str| format!("{mesh} --radius 0.004 --elements 600 --at 0.45,0,0.5");
    const TOLD: &str = "50 % of the surface is cut out of images or transparent, and lichen grows there too: --mask opaque";
    let told = desk.done(&format!("{} -o open", words("leaf.gltf")));
    assert!(told.contains(TOLD), "{told}");
    let checked = desk.call("check", "leaf.gltf").output().unwrap();
    assert!(String::from_utf8_lossy(&checked.stdout).contains(TOLD));
    let told = desk.done(&format!("{} -o card", words("card.gltf")));
    assert!(!told.contains("cut out"), "{told}");
    // The same lichen, but the card is larger than the leaf.
    desk.assert_same_elements("open", "card");
    assert_ne!(desk.read("open/preview.png"), desk.read("card/preview.png"));

    let told = desk.done(&format!("{} --mask opaque -o opaque", words("leaf.gltf")));
    assert!(!told.contains("cut out"), "{told}");
    let rightmost = |folder: &str| {
        let positions = elements(&desk, folder).positions;
        positions.iter().map(|p| p[0]).fold(0.0, f64::max)
    };
    assert!(rightmost("open") > 0.52 && rightmost("opaque") <= 0.501);
    assert_eq!(recipe(&desk, "opaque")["mask"].as_str(), Some("opaque"));
    desk.done("--recipe opaque -o again");
    desk.assert_same("again", "opaque");
    let told = desk.done(&format!("{} --mask opaque -o white", words("card.gltf")));
    assert!(told.contains("white everywhere"), "{told}");
    // What is not known is told, and is no mask.
    let leaf = desk.read("leaf.png");
    fs::write(desk.path("leaf.png"), &leaf[..leaf.len() / 2]).unwrap();
    const UNKNOWN: &str =
        "it cannot be told where it is cut out of images: image 0 of the mesh: it is damaged";
    let told = desk.done(&format!("{} -o unknown", words("leaf.gltf")));
    assert!(told.contains(UNKNOWN), "{told}");
    let checked = desk.call("check", "leaf.gltf").output().unwrap();
    assert!(String::from_utf8_lossy(&checked.stdout).contains(UNKNOWN));
    let checked = desk.call("check", "card.gltf").output().unwrap();
    let told = String::from_utf8_lossy(&checked.stdout);
    assert!(told.contains("image 0 of the mesh is passed over: it is damaged"));
}

/// The same of OBJ, whose library says it, in a folder that has the mask's name.
#[test]
fn leaves_of_obj_are_kept_free_too() {
    let desk = desk();
    write_leaf(&desk, "leaf.gltf", "MASK");
    let library = "newmtl Leaf\nmap_Kd -clamp on leaf.png\nmap_d leaf.png\n";
    fs::write(desk.path("leaf.mtl"), library).unwrap();
    let square = String::from_utf8(desk.read("square.obj")).unwrap();
    fs::write(
        desk.path("leaf.obj"),
        format!("mtllib leaf.mtl\nusemtl Leaf\n{square}"),
    )
    .unwrap();
    let words = "leaf.obj --radius 0.004 --elements 600 --at 0.45,0,0.5";
    const TOLD: &str = "50 % of the surface is cut out";
    let checked = desk.call("check", "leaf.obj").output().unwrap();
    assert!(String::from_utf8_lossy(&checked.stdout).contains(TOLD));
    let told = desk.done(&format!("{words} -o open"));
    assert!(told.contains(TOLD), "{told}");
    let told = desk.done(&format!("{words} --mask opaque -o opaque"));
    assert!(!told.contains("white everywhere"), "{told}");
    let positions = elements(&desk, "opaque").positions;
    assert!(positions.iter().all(|p| p[0] < 0.501));
}

/// Seen from above, the leaf covers half of what its card covers, and lichen covers what it covers.
#[test]
fn pictures_show_what_is_cut_out_as_cut_out() {
    let desk = desk();
    let covered = |mesh: &str, mode: &str, ground: &str| {
        write_leaf(&desk, mesh, mode);
        let run = format!("{mode}-{}", ground.len());
        desk.done(&format!(
            "{mesh} --radius 0.004 --elements 5 --at 0.2,0,0.5 -o {run}"
        ));
        let camera = r#"{"eye":[0.5,3,0.5],"target":[0.5,0,0.5],"up":[0,0,-1],"opening":40}"#;
        let flags = "--size 96x96 --background transparent --what points --samples 64";
        let words = format!("{run} -o {run}.png --camera {camera} {flags} --ground {ground}");
        let output = desk.call("render", &words).output().unwrap();
        assert!(output.status.success(), "{}", said(&output));
        let file =
            std::io::BufReader::new(fs::File::open(desk.path(&format!("{run}.png"))).unwrap());
        let mut reader = ::png::Decoder::new(file).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        let alpha = pixels.as_chunks::<4>().0.iter().map(|p| f64::from(p[3]));
        alpha.sum::<f64>() / 255.0
    };
    let card = covered("card.gltf", "OPAQUE", "mesh");
    for (mode, ground) in [
        ("MASK", "mesh"),
        ("MASK", "stone"),
        ("MASK", "leaf.png"),
        ("BLEND", "mesh"),
    ] {
        let share = covered("leaf.gltf", mode, ground) / card;
        assert!((share - 0.5).abs() < 0.02, "{mode} {ground}: {share}");
    }
}

#[test]
fn what_is_no_mask_is_refused_in_a_line() {
    let desk = desk();
    fs::write(desk.path("black.png"), image(|_, _| 0.0)).unwrap();
    fs::write(desk.path("text.png"), "white").unwrap();
    let mut jpeg = Vec::new();
    let encoder = jpeg_encoder::Encoder::new(&mut jpeg, 90);
    let grey = vec![200; 256 * 256];
    let encoded = encoder.encode(&grey, 256, 256, jpeg_encoder::ColorType::Luma);
    encoded.unwrap();
    fs::write(desk.path("whole.jpg"), &jpeg).unwrap();
    fs::write(desk.path("torn.jpg"), &jpeg[..jpeg.len() / 2]).unwrap();
    desk.done("square.obj --radius 0.004 --elements 20 --mask whole.jpg -o jpeg");
    for (words, code, parts) in [
        (
            "square.obj --mask torn.jpg",
            1,
            ["torn.jpg: the mask cannot be read", ""],
        ),
        (
            "square.obj --mask Vertex-Colours",
            1,
            ["did you mean vertex-colors?", ""],
        ),
        (
            "square.obj --mask none.png",
            1,
            ["none.png: reading the mask failed", ""],
        ),
        (
            "square.obj --mask left.png,left.png",
            1,
            ["left.png,left.png: ", "each with a --mask of its own"],
        ),
        (
            "square.obj --mask UV0:left.png",
            1,
            ["UV0:left.png: ", "the second is uv1:"],
        ),
        (
            "square.obj --mask uv1:vertex-colors",
            2,
            ["--mask uv1:vertex-colors: uv1: stands before an image", ""],
        ),
        (
            "square.obj --mask uv1:",
            2,
            ["--mask uv1:: uv1: stands before an image", ""],
        ),
        (
            "square.obj --mask text.png",
            1,
            ["text.png: ", "neither PNG nor JPEG"],
        ),
        ("rock.obj --mask left.png", 1, ["left.png: ", "UVs"]),
        (
            "rock.obj --mask vertex-colors",
            1,
            ["rock.obj: ", "colours"],
        ),
        (
            "square.obj --mask black.png",
            2,
            ["--mask black.png: nothing may grow anywhere", "black"],
        ),
        (
            "square.obj --slope 90,180",
            2,
            ["--slope 90.0,180.0: nothing may grow anywhere", ""],
        ),
        (
            "square.obj --mask left.png --at 0.9,0,0.5",
            2,
            ["at 0.9,0.0,0.5", "something may at 0.5"],
        ),
    ] {
        let words = format!("{words} --quiet -o refused");
        assert_refused_in_a_line(&desk.command(&words).output().unwrap(), code, &parts);
        assert!(!desk.path("refused").exists(), "{words}");
    }
    let both = "square.obj --mask left.png --mask black.png -o refused";
    desk.fails(both, 2, &["only where all masks let it"]);
    desk.fails("square.obj --slope 60,30", 2, &["'60,30' is not a slope"]);
    fs::write(
        desk.path("r.toml"),
        "mesh = \"square.obj\"\nslope = [60, 30]\n",
    )
    .unwrap();
    desk.fails(
        "--recipe r.toml",
        2,
        &["r.toml", "line 2: slope", "'60,30' is not a slope"],
    );
}

#[test]
fn colours_of_vertices_are_masks() {
    let desk = desk();
    let vertex = |x: f64, z: f64, grey: u8| format!("{x} 0 {z} {grey} {grey} {grey}\n");
    let ply = "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n\
               property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 4\n\
               property list uchar int vertex_indices\nend_header\n";
    let vertices = [(0.0, 255), (0.5, 255), (1.0, 0)];
    let rows = vertices.map(|(x, grey)| vertex(x, 0.0, grey) + &vertex(x, 1.0, grey));
    let faces = "3 0 1 3\n3 0 3 2\n3 2 3 5\n3 2 5 4\n";
    fs::write(
        desk.path("painted.ply"),
        ply.to_owned() + &rows.concat() + faces,
    )
    .unwrap();
    desk.done(
        "painted.ply --mesh-up y --radius 0.01 --elements 700 --mask vertex-colors -o painted",
    );
    let elements = elements(&desk, "painted");
    let farthest = elements.positions.iter().map(|p| p[0]).fold(0.0, f64::max);
    assert!((0.5..0.98).contains(&farthest), "{farthest}");
    let recipe = recipe(&desk, "painted");
    assert_eq!(recipe["mask"].as_str(), Some("vertex-colors"));
    desk.done("--recipe painted -o again");
    desk.assert_same("again", "painted");
}

/// Three squares of side 1 in a row, along x, laid out just inside the tiles 1001, 1002 and 1012.
fn write_tiles(desk: &Desk) {
    let mut mesh = String::new();
    for (x, [column, row]) in [[0, 0], [1, 0], [1, 1]].into_iter().enumerate() {
        for (i, j) in [(0, 0), (0, 1), (1, 1), (1, 0)] {
            let inside = |tile: usize, k: usize| tile as f64 + 0.001 + 0.998 * k as f64;
            let [u, v] = [inside(column, i), inside(row, 1 - j)];
            mesh += &format!("v {} 0 {j}\nvt {u} {v}\n", x + i);
        }
        let [a, b, c, d] = [1, 2, 3, 4].map(|corner| 4 * x + corner);
        mesh += &format!("f {a}/{a} {b}/{b} {c}/{c}\nf {a}/{a} {c}/{c} {d}/{d}\n");
    }
    fs::write(desk.path("tiled.obj"), mesh).unwrap();
}

#[test]
fn tiles_have_masks_of_their_own() {
    let desk = desk();
    write_tiles(&desk);
    let half = |is_left: bool| move |u: f64, _| f64::from((u < 0.5) == is_left);
    fs::write(desk.path("damp.1001.png"), image(half(true))).unwrap();
    fs::write(desk.path("damp.1002.png"), image(half(false))).unwrap();
    let run =
        "tiled.obj --mask damp.<UDIM>.png --radius 0.006 --at random --colonies 9 --elements 500";
    let output = desk.command(&format!("{run} -o out")).output().unwrap();
    assert!(output.status.success(), "{}", said(&output));
    for note in [
        "damp.<UDIM>.png: there is no image for these of the mesh's tiles: 1012",
        "damp.<UDIM>.png: 2 triangles (33.33 %) have nothing to go by",
    ] {
        assert!(said(&output).contains(note), "{}", said(&output));
    }
    assert!(!said(&output).contains("squares"), "{}", said(&output));
    let [mut first, mut second] = [0, 0];
    for [x, ..] in elements(&desk, "out").positions {
        let fuzz = 0.01;
        assert!(x < 0.5 + fuzz || (1.5 - fuzz..2.0).contains(&x), "{x}");
        first += u32::from(x < 1.0);
        second += u32::from(x > 1.0);
    }
    assert!(first > 50 && second > 50, "{first} {second}");
    // From another folder, and gone on with.
    fs::create_dir(desk.path("away")).unwrap();
    let words = "--recipe ../out/recipe.toml --elements 600 -o ../more --quiet";
    let mut away = desk.call("grow --preview 32", words);
    let output = away.current_dir(desk.path("away")).output().unwrap();
    assert!(output.status.success(), "{}", said(&output));
    desk.done("--resume out --elements 600 --quiet");
    desk.assert_same_elements("out", "more");
    fs::write(desk.path("damp.1002.png"), image(|_, _| 1.0)).unwrap();
    desk.fails(
        "--resume out --elements 700",
        1,
        &["damp.<UDIM>.png is not the mask"],
    );
    let none = "tiled.obj --mask wet.<UDIM>.png -o none";
    desk.fails(
        none,
        1,
        &[
            "the tiles 1001, 1002, 1012, and none of them",
            "wet.1001.png",
        ],
    );
    let tiled = String::from_utf8(desk.read("tiled.obj")).unwrap();
    fs::write(desk.path("far.obj"), tiled.replace("vt ", "vt -")).unwrap();
    let far = "far.obj --mask damp.<UDIM>.png -o none";
    desk.fails(far, 1, &["damp.<UDIM>.png: ", "UDIM tiles"]);
    let bare = "rock.obj --mask damp.<UDIM>.png -o none";
    desk.fails(bare, 1, &["damp.<UDIM>.png: ", "UVs"]);
    let second = "tiled.obj --mask uv1:damp.<UDIM>.png -o none";
    desk.fails(second, 2, &["uv1: stands before an image, a single one"]);
}

#[test]
fn an_image_that_is_the_mask_of_several_tiles_is_told_of() {
    let desk = desk();
    write_tiles(&desk);
    for (mesh, is_told) in [("square.obj", false), ("tiled.obj", true)] {
        let words = format!(
            "{mesh} --mask left.png --radius 0.004 --elements 20 --at random -o {mesh}-run"
        );
        let output = desk.command(&words).output().unwrap();
        assert!(output.status.success(), "{}", said(&output));
        let note = "left.png: the mesh's UVs reach over 3 squares";
        assert_eq!(said(&output).contains(note), is_told, "{}", said(&output));
    }
}

#[test]
fn sweeps_have_masks_and_slopes() {
    let desk = desk();
    let sweep = |words: &str| {
        let words = format!("{words} --quiet --size 32x32 --samples 1");
        desk.call("sweep", &words).output().unwrap()
    };
    let flags = "square.obj --radius 0.004 --elements 200 --mask left.png --B 0.3,0.5 -o grid";
    let output = sweep(flags);
    assert!(output.status.success(), "{}", said(&output));
    desk.done("square.obj --radius 0.004 --elements 200 --mask left.png --bias 0.3 -o alone");
    let cell = desk.read("grid/cells/B=0.3/seed-1/elements.ply");
    assert_eq!(cell, desk.read("alone/elements.ply"));
    // The same again finds all of it done; by its grid too, wherever its mask is, and not with another mask.
    fs::copy(desk.path("left.png"), desk.path("there.png")).unwrap();
    let there = flags.replace("left.png", "there.png");
    let grown = || fs::metadata(desk.path("grid/cells/B=0.3/seed-1/report.json")).unwrap();
    let before = grown().modified().unwrap();
    for words in [flags, "grid/grid.toml -o grid", &there] {
        let output = sweep(words);
        assert!(output.status.success(), "{words}: {}", said(&output));
    }
    assert_eq!(grown().modified().unwrap(), before);
    fs::remove_file(desk.path("left.png")).unwrap();
    let merged = sweep("merge grid -o merged --mask there.png");
    assert!(merged.status.success(), "{}", said(&merged));
    let refused = sweep("merge grid -o no --mask none");
    assert_refused(&refused, 2, &["--mask: the run has a mask"]);
    fs::write(desk.path("left.png"), image(|_, _| 1.0)).unwrap();
    assert_refused_in_a_line(
        &sweep("grid/grid.toml -o other"),
        1,
        &["left.png is not the mask"],
    );
    let slopes = sweep("rock.obj --elements 60 --axis slope=0,30;30,60 -o slopes");
    assert!(slopes.status.success(), "{}", said(&slopes));
    assert_refused_in_a_line(
        &sweep("square.obj --axis mask=a.png -o no"),
        2,
        &["the same masks"],
    );
}
