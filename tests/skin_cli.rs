//! `thallus skin` as it is called.

#[path = "common/desk.rs"]
mod desk;

use std::fs;
use std::path::Path;
use std::process::Output;

use desk::{Desk, assert_refused_in_a_line, names, said};
use thallus::substrate::Substrate;

const GROWN: &str = "rock.obj --radius 0.4% --elements 400 -o out";

fn skin(desk: &Desk, words: &str) -> Output {
    desk.call("skin", words).output().unwrap()
}

fn made(desk: &Desk, words: &str) -> String {
    let output = skin(desk, words);
    assert!(output.status.success(), "{words}: {}", said(&output));
    String::from_utf8(output.stdout).unwrap()
}

fn refused(desk: &Desk, words: &str, code: i32, parts: &[&str]) {
    assert_refused_in_a_line(&skin(desk, words), code, parts);
}

fn desk() -> Desk {
    let desk = Desk::new();
    desk.done(GROWN);
    desk
}

/// Puts one of the program's own meshes on a desk.
fn put_mesh(desk: &Desk, name: &str) {
    let mesh = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("meshes")
        .join(name);
    fs::copy(mesh, desk.path(name)).unwrap();
}

/// Triangles and corners that the mesh has for our own loader.
fn loaded(path: &Path) -> (usize, usize, usize) {
    let substrate = Substrate::load(path).unwrap();
    let report = substrate.report();
    (
        report.triangles,
        report.boundary_edges,
        report.non_manifold_edges,
    )
}

#[test]
fn every_format_holds_the_same_closed_mesh() {
    let desk = desk();
    let mut found = Vec::new();
    for extension in ["glb", "ply", "obj"] {
        let answer = made(&desk, &format!("out -o a.{extension} --json"));
        let report: serde_json::Value = serde_json::from_str(&answer).unwrap();
        let file = &report["files"][0];
        let path = desk.path(&format!("a.{extension}"));
        assert_eq!(file["bytes"], path.metadata().unwrap().len());
        assert_eq!(report["elements"], 400);
        assert!(report["seconds"]["skin"].as_f64().unwrap() > 0.0);
        let (triangles, open, wild) = loaded(&path);
        assert_eq!((open, wild), (0, 0), "{extension}");
        assert_eq!(file["triangles"], triangles, "{extension}");
        found.push((triangles, file["vertices"].clone()));
    }
    assert!(found.windows(2).all(|pair| pair[0] == pair[1]), "{found:?}");
}

#[test]
fn glb_has_attributes_and_linear_colours() {
    let desk = desk();
    made(&desk, "out -o a.glb --colormap 0:#800000 --quiet");
    let bytes = desk.read("a.glb");
    let file = gltf::Gltf::from_slice_without_validation(&bytes).unwrap();
    let primitive = file.meshes().next().unwrap().primitives().next().unwrap();
    let blob = file.blob.clone().unwrap();
    let reader = primitive.reader(|_| Some(&blob));
    let positions: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
    let bounds = primitive.bounding_box();
    for k in 0..3 {
        let values = || positions.iter().map(|p| p[k]);
        assert_eq!(values().fold(f32::INFINITY, f32::min), bounds.min[k]);
        assert_eq!(values().fold(f32::NEG_INFINITY, f32::max), bounds.max[k]);
    }
    // 0x80 in sRGB is 0.2159 of the light.
    for [r, g, b, a] in reader.read_colors(0).unwrap().into_rgba_f32() {
        assert!((r - 0.2159).abs() < 0.004 && g + b < 0.004 && a == 1.0);
    }
    let count = reader.read_indices().unwrap().into_u32().max().unwrap() as usize + 1;
    assert_eq!(count, positions.len());
    let text = String::from_utf8_lossy(&bytes);
    for name in ["_BIRTH", "_DENSITY", "_RIM_DISTANCE", "_COLONY"] {
        assert!(text.contains(name), "{name}");
    }
}

/// Corners of the box about a skin that was written as glTF.
fn gltf_box(desk: &Desk, file: &str) -> [[f32; 3]; 2] {
    let file = gltf::Gltf::from_slice_without_validation(&desk.read(file)).unwrap();
    let moved = file.nodes().next().unwrap().transform().matrix();
    assert_eq!(moved[1][1], 1.0, "the data are turned, and no node");
    let primitive = file.meshes().next().unwrap().primitives().next().unwrap();
    let bounds = primitive.bounding_box();
    [bounds.min, bounds.max]
}

/// Corners of the box about a skin that was written as OBJ.
fn obj_box(desk: &Desk, file: &str) -> [[f32; 3]; 2] {
    let text = String::from_utf8(desk.read(file)).unwrap();
    let vertices = text.lines().filter_map(|line| line.strip_prefix("v "));
    let numbers = |line: &str| -> Vec<f32> {
        let words = line.split(' ').map(|word| word.parse().unwrap());
        words.take(3).collect()
    };
    let empty = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    vertices.map(numbers).fold(empty, |[low, high], p| {
        let low = [0, 1, 2].map(|k| low[k].min(p[k]));
        [low, [0, 1, 2].map(|k| high[k].max(p[k]))]
    })
}

#[test]
fn axes_and_units_are_those_of_the_format_or_as_asked() {
    let desk = desk();
    put_mesh(&desk, "slab.stl");
    desk.done("slab.stl --radius 0.5% --elements 100 -o slab");
    for run in ["slab", "out"] {
        let boxed = |flags: &str| {
            made(&desk, &format!("{run} -o a.obj --force --quiet {flags}"));
            obj_box(&desk, "a.obj")
        };
        let [y_up, z_up] = ["", "--up z"].map(boxed);
        let [[x0, y0, z0], [x1, y1, z1]] = y_up;
        assert_eq!(z_up, [[x0, -z1, y0], [x1, -z0, y1]]);
        let scaled = boxed("--scale 2");
        assert_eq!(scaled, y_up.map(|corner| corner.map(|x| 2.0 * x)));
        made(&desk, &format!("{run} -o a.glb --force --quiet"));
        assert_eq!(gltf_box(&desk, "a.glb"), y_up);
        made(&desk, &format!("{run} -o a.glb --force --quiet --unit mm"));
        let metres = gltf_box(&desk, "a.glb");
        assert!(
            (metres[1][0] - 0.001 * x1).abs() < 1e-6,
            "{metres:?} {y_up:?}"
        );
    }
    // The plate lies in the xy plane of its file, which is z-up, and USD keeps to the file.
    made(&desk, "slab -o slab.usda --quiet --unit cm");
    let text = String::from_utf8(desk.read("slab.usda")).unwrap();
    assert!(text.contains("upAxis = \"Z\"") && text.contains("metersPerUnit = 0.01\n"));
    refused(&desk, "slab -o z.glb --up z", 2, &[".glb", "--up"]);
}

#[test]
fn usd_holds_the_mesh_and_its_attributes() {
    let desk = desk();
    let answer = made(&desk, "out -o a.usda --json");
    let report: serde_json::Value = serde_json::from_str(&answer).unwrap();
    made(&desk, "out -o a.usd --quiet");
    assert_eq!(desk.read("a.usd"), desk.read("a.usda"));
    let text = String::from_utf8(desk.read("a.usda")).unwrap();
    let count = |name: &str| {
        let line = text
            .lines()
            .find(|line| line.contains(&format!("{name} = [")));
        let line = line.unwrap_or_else(|| panic!("no {name}"));
        let values = line.split_once(" = [").unwrap().1;
        match values.matches('(').count() - usize::from(line.contains("interpolation")) {
            0 => values.split(']').next().unwrap().split(", ").count() as u64,
            tuples => tuples as u64,
        }
    };
    let file = &report["files"][0];
    assert_eq!(count("faceVertexCounts"), file["triangles"]);
    assert_eq!(
        count("faceVertexIndices"),
        3 * file["triangles"].as_u64().unwrap()
    );
    for name in [
        "points",
        "normals",
        "displayColor",
        "birth",
        "density",
        "rim_distance",
        "colony",
    ] {
        assert_eq!(count(name), file["vertices"], "{name}");
    }
}

#[test]
fn colours_come_from_names_stops_and_files() {
    let desk = desk();
    let bytes = |words: &str| {
        made(&desk, &format!("out -o c.ply --force --quiet {words}"));
        desk.read("c.ply")
    };
    let stops = bytes(
        "--colormap 0:#102030,1:#a0b0c0 --age-darken 0.5 --prothallus 4r,#111111 \
         --areoles 7r,#222222",
    );
    let file = "stops = [[0.0, \"#102030\"], [1, \"#a0b0c0\"]]\nage-darken = 0.5\n\
                prothallus = \"4r,#111111\"\nareoles = \"7r,#222222\"\n";
    fs::write(desk.path("own.toml"), file).unwrap();
    assert!(bytes("--colormap own.toml") == stops);
    for without in ["prothallus", "areoles"] {
        assert!(bytes(&format!("--colormap own.toml --{without} none")) != stops);
    }
    let table = |lines: &str| {
        let apothecia = "[apothecia]\nwidth = \"5r\"\ncolor = \"#333333\"\n";
        fs::write(desk.path("own.toml"), format!("{file}{apothecia}{lines}")).unwrap();
        bytes("--colormap own.toml")
    };
    let bearing = table("from = \"1r\"\n");
    assert!(bearing != stops);
    assert!(bytes("--colormap own.toml --apothecia none") == stops);
    assert!(bytes("--colormap own.toml --apothecia 5r,#333333") == bearing);
    assert!(table("from = \"1r\"\nspacing = \"6r\"\nmargin = 0.25\n") == bearing);
    for other in [
        "from = \"5r\"",
        "from = \"1r\"\nspacing = \"9r\"",
        "from = \"1r\"\nmargin = 0.5",
    ] {
        assert!(table(other) != bearing, "{other}");
    }
    let maps: Vec<_> = thallus::skin::PALETTE.iter().collect();
    let painted: Vec<_> = maps
        .iter()
        .map(|m| bytes(&format!("--colormap {}", m.name)))
        .collect();
    for (i, a) in painted.iter().enumerate() {
        assert!(painted[..i].iter().all(|b| a != b), "{}", maps[i].name);
    }
    assert!(bytes("") == painted[0]);
}

/// The mesh lies in a folder above the recipe, where nobody is now.
#[test]
fn the_mesh_is_found_from_elsewhere() {
    let desk = desk();
    fs::create_dir(desk.path("elsewhere")).unwrap();
    let mut command = desk.call("skin", "../out -o a.ply --quiet");
    let status = command.current_dir(desk.path("elsewhere")).status();
    assert!(status.unwrap().success());
    made(&desk, "out -o a.ply --quiet");
    assert!(desk.read("elsewhere/a.ply") == desk.read("a.ply"));
}

/// Engines know levels of detail by what their objects are called.
#[test]
fn levels_of_detail_have_names() {
    let desk = desk();
    let has = |file: &str, name: &str| {
        let text = desk.read(file);
        text.windows(name.len()).any(|part| part == name.as_bytes())
    };
    for (format, before, after) in [("obj", "o ", "\n"), ("glb", "\"name\":\"", "\"")] {
        made(&desk, &format!("out -o n.{format} --lod 2"));
        made(&desk, &format!("out -o one.{format}"));
        for level in 0..2 {
            let name = format!("{before}lichen_LOD{level}{after}");
            assert!(has(&format!("n_lod{level}.{format}"), &name), "{name}");
        }
        assert!(has(
            &format!("one.{format}"),
            &format!("{before}lichen{after}")
        ));
    }
}

#[test]
fn levels_of_detail_halve() {
    let desk = desk();
    let answer = made(&desk, "out -o d.ply --lod 3 --decimate 0.8 --json");
    let report: serde_json::Value = serde_json::from_str(&answer).unwrap();
    let counts: Vec<f64> = report["files"]
        .as_array()
        .unwrap()
        .iter()
        .map(|f| f["triangles"].as_f64().unwrap())
        .collect();
    assert_eq!(counts.len(), 3);
    for pair in counts.windows(2) {
        assert!((pair[1] / pair[0] - 0.5).abs() < 0.05, "{counts:?}");
    }
    for level in 0..3 {
        let (_, open, wild) = loaded(&desk.path(&format!("d_lod{level}.ply")));
        assert_eq!((open, wild), (0, 0));
    }
    assert!(!desk.path("d.ply").exists());
    let told = desk
        .call("skin", "out -o d.ply --lod 2 --force")
        .output()
        .unwrap();
    assert!(
        String::from_utf8_lossy(&told.stderr).contains("d_lod2.ply: a level of an earlier skin")
    );
    let told = desk
        .call("skin", "out -o d.ply --lod 3 --force")
        .output()
        .unwrap();
    assert!(!String::from_utf8_lossy(&told.stderr).contains("earlier"));
}

/// Each hole of the finest skin needs its triangles: it came down to 190, and the advice did not help.
#[test]
fn as_few_triangles_as_a_coarser_skin_can_have_are_had() {
    let desk = Desk::new();
    desk.done("rock.obj --preset foliose --radius 0.4% --elements 1500 -o out");
    let made = |words: &str| {
        let output = skin(&desk, words);
        assert!(output.status.success(), "{}", said(&output));
        String::from_utf8(output.stderr).unwrap()
    };
    let told = made("out -o a.ply --decimate 100 --threads 1");
    assert!(told.contains("of a coarser skin (--resolution "), "{told}");
    assert!(!told.contains("warning"), "{told}");
    let (triangles, open, wild) = loaded(&desk.path("a.ply"));
    assert!(triangles <= 110 && (open, wild) == (0, 0), "{triangles}");
    made("out -o b.ply --decimate 100 --threads 2");
    assert!(desk.read("a.ply") == desk.read("b.ply"));
    let told = made("out -o c.ply --decimate 4");
    assert!(
        told.contains("4 were asked for") && told.contains("ask for more"),
        "{told}"
    );
    assert!(!told.contains("note"), "{told}");
    assert_eq!(loaded(&desk.path("c.ply")).1, 0);
}

/// What a closed mesh holds, in cubes of its unit.
fn held(path: &Path) -> f64 {
    let soup = thallus::substrate::load_soup(path).unwrap().soup;
    let corner = |v: u32| glam::DVec3::from(soup.positions[v as usize]);
    let six_times = |t: &[u32; 3]| {
        let [a, b, c] = t.map(corner);
        a.cross(b).dot(c)
    };
    soup.triangles.iter().map(six_times).sum::<f64>() / 6.0
}

/// On bumps wide triangles are lifted until they lie on none: the skin came to hold more than twice as much.
#[test]
fn decimated_skins_do_not_swell() {
    let desk = Desk::new();
    put_mesh(&desk, "boulder.glb");
    desk.done("boulder.glb --elements 5000 -o out");
    made(&desk, "out -o whole.ply");
    let whole = held(&desk.path("whole.ply"));
    let decimated = |goal: usize| {
        let output = skin(&desk, &format!("out -o {goal}.ply --decimate {goal}"));
        assert!(output.status.success(), "{}", said(&output));
        let file = desk.path(&format!("{goal}.ply"));
        let share = held(&file) / whole;
        assert!((0.8..1.51).contains(&share), "{goal}: {share}");
        (loaded(&file).0, said(&output))
    };
    assert_eq!(decimated(600).0, 600);
    let (left, told) = decimated(200);
    assert!((220..600).contains(&left), "{left}");
    assert!(told.contains("200 were asked for"), "{told}");
}

/// Lifting alone adds to what thin skins hold, on flat meshes too.
#[test]
fn thin_skins_are_decimated_too() {
    let desk = Desk::new();
    put_mesh(&desk, "plane.obj");
    for mesh in ["plane", "rock"] {
        desk.done(&format!(
            "{mesh}.obj --preset dla --radius 0.4% --elements 600 -o {mesh}"
        ));
        made(
            &desk,
            &format!("{mesh} -o {mesh}.ply --thickness 0.3r --lod 3"),
        );
        let levels = [0, 1, 2].map(|level| loaded(&desk.path(&format!("{mesh}_lod{level}.ply"))).0);
        let halves = [levels[0], levels[0] / 2, levels[0] / 4];
        let is_half = |(made, half): (&usize, usize)| made.abs_diff(half) * 10 <= half;
        assert!(levels.iter().zip(halves).all(is_half), "{levels:?}");
    }
}

/// A coarser skin that has no more triangles than are asked for is as it is.
#[test]
fn coarser_skins_are_taken_whole() {
    let desk = Desk::new();
    desk.done("rock.obj --preset fruticose --radius 0.4% --elements 1500 -o out");
    let left = [2000, 2500, 3000, 3500].map(|goal| {
        made(
            &desk,
            &format!("out -o {goal}.ply --thickness 0.3r --decimate {goal}"),
        );
        loaded(&desk.path(&format!("{goal}.ply"))).0
    });
    assert!(left.is_sorted(), "{left:?}");
    assert!(left[3] <= 3850, "{left:?}");
}

#[test]
fn threads_and_ways_to_name_the_elements_change_no_byte() {
    let desk = desk();
    made(&desk, "out -o 1.ply --threads 1 --quiet");
    made(&desk, "out/elements.ply -o 2.ply --threads 2 --quiet");
    fs::copy(desk.path("out/elements.ply"), desk.path("alone.ply")).unwrap();
    made(
        &desk,
        "alone.ply --mesh rock.obj -o 3.ply --threads 3 --quiet",
    );
    assert!(desk.read("1.ply") == desk.read("2.ply") && desk.read("1.ply") == desk.read("3.ply"));
}

#[test]
fn pictures_have_triangles_as_fine_as_they_show() {
    let desk = desk();
    let triangles = |words: &str| {
        let words = format!("out -o a.png --samples 1 --json --force {words}");
        let output = desk.call("render", &words).output().unwrap();
        assert!(output.status.success(), "{words}: {}", said(&output));
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        report["skin_triangles"].as_u64().unwrap()
    };
    let front = "--size 160x120 --camera 0,30";
    let usual = triangles(&format!("{front} --resolution 2r"));
    assert_eq!(triangles(front), usual);
    let near = triangles(&format!("{front} --zoom 3"));
    let nearest = triangles(&format!("{front} --zoom 500"));
    assert!(usual < near && near < nearest, "{usual} {near} {nearest}");
    assert_eq!(nearest, triangles(&format!("{front} --resolution 0.7r")));
    assert_eq!(
        usual,
        triangles(&format!("{front} --zoom 3 --resolution 2r"))
    );
    assert_eq!(triangles(&format!("{front} --what points")), 0);
}

/// 0.05 times a radius and over it again is a little less than 0.05 for one radius in nine, this one among them.
#[test]
fn the_ends_of_ranges_are_allowed() {
    let desk = Desk::new();
    put_mesh(&desk, "slab.stl");
    desk.done("slab.stl --elements 60 -o slab");
    for flag in ["--thickness 0.05r", "--thickness 20r", "--falloff 0.8r"] {
        made(
            &desk,
            &format!("slab -o a.ply --force --resolution 1r {flag}"),
        );
    }
}

#[test]
fn what_is_wrong_is_said_in_one_line() {
    let desk = desk();
    refused(
        &desk,
        "out -o a.stl",
        2,
        &["a.stl", "'.stl' is not a format", ".glb"],
    );
    refused(&desk, "nowhere -o a.ply", 1, &["nowhere"]);
    fs::copy(desk.path("out/elements.ply"), desk.path("alone.ply")).unwrap();
    refused(&desk, "alone.ply -o a.ply", 2, &["recipe.toml", "--mesh"]);
    fs::write(
        desk.path("other.obj"),
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    )
    .unwrap();
    refused(
        &desk,
        "out --mesh other.obj -o a.ply",
        1,
        &["other.obj", "not on this mesh"],
    );
    refused(
        &desk,
        "out -o a.ply --thickness 0",
        2,
        &["thickness", "0.05r to 20r", "without r is in mesh units"],
    );
    refused(&desk, "out -o a.ply --taper 2", 2, &["taper"]);
    refused(&desk, "out -o a.ply --resolution 0.01r", 2, &["resolution"]);
    refused(
        &desk,
        "out -o a.ply --colormap lichn",
        2,
        &["lichn", "parmelia"],
    );
    refused(&desk, "out -o a.ply --colormap no.toml", 1, &["no.toml"]);
    refused(&desk, "out -o a.ply --age-darken 7", 2, &["--age-darken"]);
    refused(&desk, "out -o a.ply --prothallus -3r", 2, &["--prothallus"]);
    // As long as the rock is wide, in mesh units: an r was forgotten.
    refused(
        &desk,
        "out -o a.ply --prothallus 6",
        2,
        &["--prothallus", "0.1r to 200r", "mesh units"],
    );
    refused(&desk, "out -o a.ply --prothallus 3r,#zz", 2, &["#zz"]);
    refused(
        &desk,
        "out -o a.ply --areoles 1r",
        2,
        &["--areoles", "3r to 1000r"],
    );
    refused(&desk, "out -o a.ply --apothecia wide", 2, &["--apothecia"]);
    refused(&desk, "out -o a.ply --decimate 1.5", 2, &["--decimate"]);
    refused(&desk, "out -o a.ply --lod 0", 2, &["--lod"]);
    refused(
        &desk,
        "out -o a.ply --unit mm",
        2,
        &[".ply", "--unit", "--scale"],
    );
    fs::write(desk.path("bad.toml"), "stops = [[0.0, \"red\"]]\n").unwrap();
    refused(
        &desk,
        "out -o a.ply --colormap bad.toml",
        2,
        &["bad.toml", "red"],
    );
    fs::write(desk.path("bad.toml"), "stops = []\ncolour = 1\n").unwrap();
    refused(
        &desk,
        "out -o a.ply --colormap bad.toml",
        2,
        &["bad.toml", "colour"],
    );
    assert!(!names(desk.0.path()).contains(&"a.ply".to_owned()));
    fs::write(desk.path("a.ply"), "mine").unwrap();
    refused(&desk, "out -o a.ply", 1, &["a.ply", "--force"]);
    assert_eq!(desk.read("a.ply"), b"mine");
    made(&desk, "out -o a.ply --force --quiet");
    // What it is read from is not written over, whatever is said.
    let read = ["out/elements.ply", "rock.obj"].map(|name| fs::read(desk.path(name)).unwrap());
    for name in ["out/elements.ply", "./rock.obj"] {
        let words = ["is what the lichen is read from"];
        refused(&desk, &format!("out -o {name} --force"), 2, &words);
    }
    let now = ["out/elements.ply", "rock.obj"].map(|name| fs::read(desk.path(name)).unwrap());
    assert!(read == now);
    assert_ne!(desk.read("a.ply"), b"mine");
}

/// Tens of thousands of elements far apart, each felt far: more than machines have. By every command that makes
/// skins.
#[cfg(target_os = "linux")]
#[test]
fn a_skin_that_does_not_fit_into_memory_is_refused_with_the_number() {
    let desk = Desk::new();
    desk.done("rock.obj --radius 0.02% --gain 0 --bias 1 --elements 150000 -o out --quiet");
    for (command, file) in [
        ("skin", "a.glb"),
        ("render", "a.png"),
        ("animate", "b.glb"),
        ("animate", "frames"),
        ("animate --draw skin", "a.gif"),
    ] {
        let words = format!("out -o {file} --resolution 0.1r --thickness 20r --falloff 8r");
        let output = desk.call(command, &words).output().unwrap();
        let said = ["triangles of skin", "GB of memory", "free", "--resolution"];
        assert_refused_in_a_line(&output, 1, &said);
        assert!(!desk.path(file).exists(), "{command}");
    }
}

#[test]
fn help_says_what_is_refused_beyond() {
    let desk = desk();
    let help = made(&desk, "--help");
    let words = help.split_whitespace().collect::<Vec<_>>().join(" ");
    for flag in ["--thickness", "--taper", "--falloff", "--resolution"] {
        let output = skin(&desk, &format!("out -o skin.ply {flag} 99"));
        let said = said(&output);
        let range = said.split("it may be ").nth(1).expect("a range");
        let range = range.split([';', '\n']).next().expect("a range");
        let of_flag = words.split(&format!("{flag} <")).nth(1).expect("its help");
        let line = of_flag.split("[default").next().expect("its help");
        assert!(
            line.contains(&format!(", {range}:")),
            "{flag}: {range}: {line}"
        );
    }
}
