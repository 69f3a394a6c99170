//! `thallus analyze` as it is called.

#[path = "common/desk.rs"]
mod desk;

use std::collections::BTreeSet;
use std::fs;
use std::process::Output;

use desk::{Desk, assert_refused_in_a_line, fields, names, said};
use serde_json::Value;
use thallus::analysis::{SCALARS, plot_names};

/// Plain DLA, which is large enough for every fit.
const GROWN: &str = "rock.obj --radius 0.04% --gain 0 --bias 1 --join touch --elements 6000 -o out";

fn analyze(desk: &Desk, words: &str) -> Output {
    desk.call("analyze", words).output().unwrap()
}

fn answered(desk: &Desk, words: &str) -> String {
    let output = analyze(desk, words);
    assert!(output.status.success(), "{words}: {}", said(&output));
    String::from_utf8(output.stdout).unwrap()
}

fn json(desk: &Desk, words: &str) -> Value {
    serde_json::from_str(&answered(desk, &format!("{words} --json"))).unwrap()
}

fn refused(desk: &Desk, words: &str, code: i32, parts: &[&str]) {
    assert_refused_in_a_line(&analyze(desk, words), code, parts);
}

fn desk() -> Desk {
    let desk = Desk::new();
    desk.done(GROWN);
    desk
}

/// What the page says of them, in full.
fn documented() -> BTreeSet<String> {
    let page = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/analysis.md");
    let page = fs::read_to_string(page).unwrap();
    let section = page.split_once("### The JSON").unwrap().1;
    let section = section.split("\n### ").next().unwrap();
    let rows = section.lines().filter_map(|line| line.strip_prefix("| `"));
    let names = rows.flat_map(|row| row.split(" | ").next().unwrap().split(", "));
    let mut all = BTreeSet::new();
    for name in names.map(|name| name.trim_matches('`')) {
        let parts: &[&str] = match name {
            "branch_width" | "lobe_width" | "branching.angle" => {
                &[".count", ".mean", ".deviation", ".percentiles"]
            }
            "front.growth" => &[
                ".points",
                ".local_slopes",
                ".range",
                ".fit.slope",
                ".fit.error",
                ".fit.prefactor",
                ".fit.points",
            ],
            _ => &[""],
        };
        all.extend(parts.iter().map(|part| format!("{name}{part}")));
    }
    all
}

/// Squares of such lengths are no numbers, and ladders up to them did not end.
/// Squares of such lengths are no numbers: measures panicked, and plots were drawn for ever.
#[test]
fn lengths_beyond_all_measure_are_refused() {
    let desk = Desk::new();
    let properties = "x y z nx ny nz radius parent colony triangle u v probability";
    let table = |radius: &str, x: &str| {
        let declared = properties.split(' ').map(|name| match name {
            "parent" | "colony" | "triangle" => format!("property int {name}\n"),
            _ => format!("property double {name}\n"),
        });
        let declared: String = declared.collect();
        let rows = format!(
            "0 0 0 0 0 1 {radius} -1 0 0 0.3 0.3 1\n{x} 0 0 0 0 1 {radius} 0 0 0 0.3 0.3 1\n"
        );
        format!("ply\nformat ascii 1.0\nelement vertex 2\n{declared}end_header\n{rows}")
    };
    let radius = "radius must be a positive number, and from 1e-150 to 1e150";
    for (table, problem) in [
        (table("1", "1e200"), "element 1: position is beyond 1e150"),
        (table("1", "-1e155"), "element 1: position is beyond 1e150"),
        (table("1e308", "2"), radius),
        (table("1e-310", "2"), radius),
    ] {
        fs::write(desk.path("odd.ply"), table).unwrap();
        let parts = ["odd.ply: contents", problem, "take another unit"];
        refused(&desk, "odd.ply --quiet --plots plots", 1, &parts);
        let exported = desk.call("export odd.ply -o odd.csv --quiet", "").output();
        assert_refused_in_a_line(&exported.unwrap(), 1, &parts);
    }
    fs::write(desk.path("odd.ply"), table("1", "2")).unwrap();
    answered(&desk, "odd.ply --quiet --plots plots");
}

#[test]
fn every_field_of_the_json_is_documented_and_no_other() {
    let mut found = BTreeSet::new();
    let mut said = json(&desk(), "out");
    // These are in a table of their own.
    said["scalars"].take();
    fields(&said, "", &mut found);
    assert_eq!(found, documented());
}

#[test]
fn json_has_every_scalar_and_what_it_was_read_from() {
    let desk = desk();
    let found = json(&desk, "out");
    let scalars = found["scalars"].as_object().unwrap();
    assert_eq!(scalars.len(), SCALARS.len());
    for scalar in SCALARS {
        assert!(scalars.contains_key(scalar.name), "{}", scalar.name);
    }
    assert_eq!(scalars["elements"], 6000.0);
    let dimensions = found["dimensions"].as_array().unwrap();
    assert_eq!(dimensions.len(), 10);
    for dimension in dimensions {
        let scaling = &dimension["scaling"];
        let [points, slopes] =
            ["points", "local_slopes"].map(|k| scaling[k].as_array().unwrap().len());
        assert!(points >= 5 && slopes == points - 2, "{dimension}");
        let [from, to] = [0, 1].map(|k| scaling["range"][k].as_f64().unwrap());
        assert!(from < to);
        let value = dimension["dimension"].as_f64().unwrap();
        assert!((1.0..2.4).contains(&value), "{dimension}");
    }
    let profile = found["front"]["profile"].as_array().unwrap();
    assert_eq!(profile.len(), 32);
    for share in profile.iter().map(|ring| ring[1].as_f64().unwrap()) {
        assert!(share > 0.0 && share < 1.0, "{share} of a ring");
    }
    let radius = found["radius"].as_f64().unwrap();
    let report = desk.report("out");
    assert!(
        (found["effective_radius"].as_f64().unwrap()
            / report["effective_radius"].as_f64().unwrap()
            - 1.0)
            .abs()
            < 1e-4
    );
    let covered = found["covered_area"].as_f64().unwrap();
    assert!((covered / (6000.0 * std::f64::consts::PI * radius * radius) - 1.0).abs() < 1e-9);
}

#[test]
fn text_says_every_scalar_and_dimension() {
    let desk = desk();
    let text = answered(&desk, "out");
    for scalar in SCALARS.iter().filter(|s| !s.name.contains("dimension_")) {
        assert!(
            text.contains(scalar.name) && text.contains(scalar.meaning),
            "{text}"
        );
    }
    for method in ["mass-radius", "gyration", "sandbox", "correlation"] {
        let lines = text.matches(&format!("\n  {method} ")).count();
        assert_eq!(lines, 2, "{text}");
    }
    assert_eq!(text.matches("along the surface").count(), 4, "{text}");
    assert_eq!(
        answered(&desk, "out/elements.ply"),
        text.replace("out:", "out/elements.ply:")
    );
}

#[test]
fn without_its_mesh_a_lichen_is_measured_through_space() {
    let desk = desk();
    fs::copy(desk.path("out/elements.ply"), desk.path("alone.ply")).unwrap();
    let output = analyze(&desk, "alone.ply --json");
    assert!(output.status.success() && said(&output).contains("give the mesh with --mesh"));
    let alone: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(alone["dimensions"].as_array().unwrap().len(), 6);
    assert!(alone["scalars"]["surface_dimension_sandbox"].is_null());
    assert_eq!(alone["front"]["profile"], serde_json::json!([]));
    let quiet = analyze(&desk, "alone.ply --json --quiet");
    assert!(quiet.stderr.is_empty() && quiet.stdout == output.stdout);
    let with = json(&desk, "alone.ply --mesh rock.obj");
    assert_eq!(with, json(&desk, "out"));
    let without = json(&desk, "out --surface-centres 0");
    assert_eq!(without["dimensions"].as_array().unwrap().len(), 6);
}

#[test]
fn any_number_of_threads_says_the_same() {
    let desk = desk();
    let said = |threads: u32| answered(&desk, &format!("out --json --threads {threads}"));
    assert!(said(1) == said(2) && said(1) == said(5));
}

#[test]
fn plots_are_whole_files_that_are_not_overwritten() {
    let desk = desk();
    let text = answered(&desk, "out --plots plots --surface-centres 10");
    assert!(text.contains("sandbox"), "{text}");
    let mut expected: Vec<_> = plot_names().map(str::to_owned).collect();
    expected.sort();
    assert_eq!(names(&desk.path("plots")), expected);
    for name in expected.iter().filter(|name| name.ends_with(".png")) {
        let svg = String::from_utf8(desk.read(&format!("plots/{}", name.replace(".png", ".svg"))));
        let svg = svg.unwrap();
        let png = pixels(&desk.read(&format!("plots/{name}")));
        for color in colors(&svg) {
            assert!(png.contains(&color), "{name} lacks {color:?}");
        }
        assert!(
            svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"),
            "{name}"
        );
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}");
    }
    refused(&desk, "out --plots plots", 1, &["plots", "--force"]);
    let plots = || ["plots/growth.svg", "plots/growth.png"].map(|name| desk.read(name));
    let before = plots();
    answered(
        &desk,
        "out --plots plots --force --surface-centres 10 --threads 1",
    );
    assert!(before == plots());
}

/// The opaque colours that a drawing has.
fn colors(svg: &str) -> BTreeSet<[u8; 3]> {
    let opaque = svg.lines().filter(|line| line.contains("opacity=\"1\""));
    let quoted = opaque.flat_map(|line| line.split('"'));
    let colors = quoted.filter_map(|word| {
        let number = u32::from_str_radix(word.strip_prefix('#')?, 16).ok()?;
        let [_, red, green, blue] = number.to_be_bytes();
        Some([red, green, blue])
    });
    colors.collect()
}

/// The colours of the pixels of a picture.
fn pixels(png: &[u8]) -> BTreeSet<[u8; 3]> {
    let decoder = png::Decoder::new(std::io::Cursor::new(png));
    let mut reader = decoder.read_info().unwrap();
    let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut rgb).unwrap();
    assert!(info.width >= 1600 && info.height >= 1000);
    rgb.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect()
}

#[test]
fn a_lichen_of_one_element_is_no_failure() {
    let desk = Desk::new();
    desk.done("rock.obj --elements 1 -o one");
    let found = json(&desk, "one --plots plots");
    assert_eq!(found["scalars"]["elements"], 1.0);
    assert!(found["scalars"]["dimension_sandbox"].is_null());
    assert!(answered(&desk, "one").contains("too small a lichen to fit"));
}

#[test]
fn what_cannot_be_measured_is_refused_in_one_line() {
    let desk = desk();
    refused(&desk, "nowhere", 1, &["nowhere"]);
    refused(&desk, "rock.obj", 1, &["rock.obj"]);
    fs::create_dir_all(desk.path("begun/cells")).unwrap();
    fs::create_dir(desk.path("sweep")).unwrap();
    fs::write(desk.path("sweep/grid.toml"), "seeds = 2\n").unwrap();
    for folder in ["begun", "sweep"] {
        let is_sweep = format!("{folder} is the folder of a sweep");
        let cures = ["/cells/CELL/seed-N", "/results.csv"].map(|cure| format!("{folder}{cure}"));
        refused(&desk, folder, 1, &[&is_sweep, &cures[0], &cures[1]]);
    }
    refused(&desk, "out --mesh gone.obj", 1, &["gone.obj"]);
    refused(&desk, "out --centres 0", 2, &["--centres"]);
    refused(&desk, "out --surface-centres -1", 2, &["--surface-centres"]);
    let plane = "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 3 2\n";
    fs::write(desk.path("plane.obj"), plane).unwrap();
    refused(
        &desk,
        "out --mesh plane.obj",
        1,
        &["plane.obj", "not on this mesh"],
    );
    fs::remove_file(desk.path("rock.obj")).unwrap();
    let output = analyze(&desk, "out");
    assert!(output.status.success() && said(&output).contains("--mesh"));
}
