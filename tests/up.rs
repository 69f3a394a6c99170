//! A mesh whose file does not keep to the convention of its format: what is up is said once, and
//! everything goes by it.

#[path = "common/desk.rs"]
mod desk;

use std::fs;
use std::path::Path;

use desk::{Desk, PROMISED};
use thallus::export::read_elements;
use thallus::growth::SeedPlace;
use thallus::run::{GrowError, Settings, SettingsError, grow};
use thallus::substrate::{Soup, Substrate, UpAxis};

/// A rock in an OBJ file, y-up as the format has it, and the same as programs with z up leave it.
fn two_rocks() -> Desk {
    let desk = Desk::new();
    let text = String::from_utf8(desk.read("rock.obj")).unwrap();
    let turned = text.lines().map(|line| {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.as_slice() {
            ["v", x, y, z] => match z.strip_prefix('-') {
                Some(z) => format!("v {x} {z} {y}\n"),
                None => format!("v {x} -{z} {y}\n"),
            },
            _ => format!("{line}\n"),
        }
    });
    fs::write(desk.path("scan.obj"), turned.collect::<String>()).unwrap();
    desk
}

fn seed_of(desk: &Desk, file: &str) -> [f64; 3] {
    read_elements(&desk.path(file)).unwrap().positions[0]
}

fn assert_near(found: [f64; 3], expected: [f64; 3]) {
    let apart = |(a, b): (f64, f64)| (a - b).abs() < 1e-6;
    let near = found.into_iter().zip(expected).all(apart);
    assert!(near, "{found:?} where {expected:?} is expected");
}

/// As the turned file has it.
fn turned([x, y, z]: [f64; 3]) -> [f64; 3] {
    [x, -z, y]
}

fn json(desk: &Desk, words: &str) -> serde_json::Value {
    let output = desk
        .call("render --size 16x16 --samples 1 --json --force", words)
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    serde_json::from_slice(&output.stdout).unwrap()
}

fn eye(desk: &Desk, words: &str) -> [f64; 3] {
    let report = json(desk, words);
    serde_json::from_value(report["camera"]["eye"].clone()).unwrap()
}

#[test]
fn the_top_of_a_mesh_is_where_its_up_axis_says() {
    let desk = two_rocks();
    for place in ["top", "highest"] {
        let words = format!("--elements 1 --at {place} --force");
        desk.done(&format!("rock.obj {words} -o upright"));
        desk.done(&format!("scan.obj {words} -o lying"));
        desk.done(&format!("scan.obj {words} --mesh-up z -o said"));
        let expected = turned(seed_of(&desk, "upright/elements.ply"));
        assert_near(seed_of(&desk, "said/elements.ply"), expected);
        let lying = seed_of(&desk, "lying/elements.ply");
        assert!(
            (lying[2] - expected[2]).abs() > 0.1,
            "{lying:?} {expected:?}"
        );
    }
}

#[test]
fn everything_after_growth_knows_it_from_the_recipe() {
    let desk = two_rocks();
    desk.done("rock.obj --elements 1 -o upright");
    desk.done("scan.obj --elements 1 --mesh-up z -o said");
    let recipe = String::from_utf8(desk.read("said/recipe.toml")).unwrap();
    assert!(recipe.contains("\nmesh-up = \"z\" "), "{recipe}");
    let usual = String::from_utf8(desk.read("upright/recipe.toml")).unwrap();
    assert!(!usual.contains("mesh-up"), "{usual}");
    let expected = turned(eye(&desk, "upright -o a.png --camera 30,20"));
    assert_near(eye(&desk, "said -o a.png --camera 30,20"), expected);
    for name in ["upright", "said"] {
        let words = format!("{name} -o {name}.ply --up z");
        assert!(desk.call("export", &words).status().unwrap().success());
    }
    let exported = |name: &str| read_elements(&desk.path(name)).unwrap().positions[0];
    assert_near(exported("said.ply"), exported("upright.ply"));
}

#[test]
fn a_run_that_was_not_told_is_pictured_as_asked() {
    let desk = two_rocks();
    desk.done("rock.obj --elements 1 -o upright");
    let [x, y, z] = turned(seed_of(&desk, "upright/elements.ply"));
    desk.done(&format!("scan.obj --elements 1 --at {x},{y},{z} -o lying"));
    let view = "-o a.png --camera 30,20 --what points";
    let expected = turned(eye(&desk, &format!("upright {view}")));
    assert_near(eye(&desk, &format!("lying {view} --mesh-up z")), expected);
    let unsaid = eye(&desk, &format!("lying {view}"));
    assert!(
        (unsaid[1] - expected[1]).abs() > 0.05,
        "{unsaid:?} {expected:?}"
    );
}

#[test]
fn runs_repeat_and_go_on_with_their_up_axis() {
    let desk = two_rocks();
    desk.done("scan.obj --elements 300 --mesh-up z -o whole");
    desk.done("--recipe whole/recipe.toml -o again");
    desk.done("scan.obj --elements 100 --mesh-up z -o part");
    desk.done("--resume part --elements 300");
    for file in PROMISED {
        let whole = desk.read(&format!("whole/{file}"));
        assert!(whole == desk.read(&format!("again/{file}")), "{file}");
        assert!(whole == desk.read(&format!("part/{file}")), "{file}");
    }
    desk.fails(
        "--resume part --mesh-up y --elements 400",
        2,
        &["--mesh-up", "--resume"],
    );
}

#[test]
fn a_sweep_grows_where_the_up_axis_says() {
    let desk = two_rocks();
    desk.done("scan.obj --elements 50 --mesh-up z -o said");
    let words = "scan.obj --mesh-up z --B 0.5,0.9 --elements 50 --size 16x16 -o grid";
    assert!(
        desk.call("sweep --quiet --threads 1", words)
            .status()
            .unwrap()
            .success()
    );
    let cell = "grid/cells/B=0.5/seed-1/elements.ply";
    assert!(desk.read(cell) == desk.read("said/elements.ply"));
    let mut again = desk.call("sweep --quiet --threads 1", "grid/grid.toml -o again");
    assert!(again.status().unwrap().success());
    assert!(desk.read(cell) == desk.read("again/cells/B=0.5/seed-1/elements.ply"));
}

#[test]
fn a_substrate_that_was_told_otherwise_is_refused() {
    let rock = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes/rock.obj");
    let load = || Substrate::load(&rock).unwrap();
    let said = Settings {
        mesh_up: Some(UpAxis::Z),
        ..Settings::default()
    };
    let refused = said.clone().resolve(&load(), "rock.obj");
    assert_eq!(refused, Err(SettingsError::OtherUp { said: UpAxis::Z }));
    let told = load().with_up(Some(UpAxis::Z));
    let recipe = said.resolve(&told, "rock.obj").unwrap();
    assert_eq!(recipe.mesh_up, Some(UpAxis::Z));
    let unsaid = Settings::default().resolve(&told, "rock.obj").unwrap();
    assert_eq!(unsaid, recipe);
    let grown = grow(&load(), &recipe, &Default::default(), &mut ());
    assert!(matches!(grown, Err(GrowError::Up)));
    // What the format has anyway need not be said.
    let usual = Settings {
        mesh_up: Some(UpAxis::Y),
        ..Settings::default()
    };
    assert_eq!(usual.resolve(&load(), "rock.obj").unwrap().mesh_up, None);
}

/// A square ring of height 0.2 with a hole in its middle, y up.
fn ring() -> Soup {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let mut soup = Soup::default();
    for (height, half) in [(0.0, 1.0), (0.0, 0.6), (0.2, 1.0), (0.2, 0.6)] {
        let place = |[x, z]: [f64; 2]| [half * x, height, half * z];
        soup.positions.extend(corners.map(place));
    }
    for k in 0..4 {
        let next = (k + 1) % 4;
        let at = |ring: u32, k: u32| 4 * ring + k;
        for [first, second] in [[2, 3], [1, 0], [0, 2], [3, 1]] {
            let [a, b] = [at(first, k), at(first, next)];
            let [c, d] = [at(second, next), at(second, k)];
            soup.triangles.extend([[a, d, c], [a, c, b]]);
        }
    }
    soup
}

/// Not on the wall of the hole, which is nearest to the middle.
#[test]
fn the_top_of_a_ring_looks_up() {
    let substrate = Substrate::from_soup(ring()).unwrap();
    let top = SeedPlace::Top.locate(&substrate, 1, 0).unwrap();
    let place = substrate.units().to_file(substrate.position(&top));
    assert!((place.y - 0.2).abs() < 1e-9, "{place}");
    assert!(substrate.normal(top.triangle).y > 0.999);
}
