//! Several lichens that grow at once.

mod common;
#[path = "common/desk.rs"]
mod desk;

use desk::{Desk, said};
use thallus::cluster::{Element, NO_PARENT};
use thallus::growth::{Join, SeedPlace};
use thallus::run::{Begun, Execution, GrowError, Growth, Recipe, Run, StopRule, Stopped, grow};
use thallus::substrate::Substrate;

fn grown(substrate: &Substrate, recipe: &Recipe) -> Growth {
    grow(substrate, recipe, &Execution::default(), &mut ()).expect("grows")
}

fn on_threads(substrate: &Substrate, recipe: &Recipe, threads: usize) -> Growth {
    let execution = Execution {
        threads,
        uses_all_threads: true,
        ..Execution::default()
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let grown = || grow(substrate, recipe, &execution, &mut ());
    pool.expect("threads").install(grown).expect("grows")
}

/// Elements of each colony.
fn sizes(growth: &Growth, colonies: usize) -> Vec<usize> {
    let mut sizes = vec![0; colonies];
    for element in growth.cluster.elements() {
        sizes[element.colony as usize] += 1;
    }
    sizes
}

fn at(x: f64, z: f64) -> SeedPlace {
    SeedPlace::Point([x, 0.0, z])
}

/// Two squares of side 1 in the plane y = 0, side by side but apart.
fn two_squares() -> Substrate {
    let square = |x: f64| [[x, 0.0], [x + 1.0, 0.0], [x + 1.0, 1.0], [x, 1.0]];
    let corners = [square(-1.5), square(0.5)].concat();
    let positions = corners.into_iter().map(|[x, z]| [x, 0.0, z]).collect();
    let triangles = vec![[0, 2, 1], [0, 3, 2], [4, 6, 5], [4, 7, 6]];
    common::substrate(positions, triangles)
}

#[test]
fn each_begins_with_its_seed_and_descends_from_it() {
    let rock = common::rock(24);
    let mut recipe = common::recipe(rock.auto_radius(), 6000);
    recipe.at.resize(12, SeedPlace::Random);
    let growth = grown(&rock, &recipe);
    let elements = growth.cluster.elements();
    let seeds = recipe.seeds(&rock).expect("places");
    for (colony, seed) in (0..).zip(&seeds) {
        let expected = Element {
            colony,
            ..Element::seed(&rock, *seed)
        };
        assert_eq!(elements[colony as usize], expected);
    }
    let radius = growth.cluster.radius();
    for (age, element) in elements.iter().enumerate().skip(seeds.len()) {
        assert!((element.parent as usize) < age && element.parent != NO_PARENT);
        let parent = &elements[element.parent as usize];
        assert_eq!(parent.colony, element.colony);
        assert!(parent.position.distance(element.position) < 2.001 * radius);
    }
    assert!(
        sizes(&growth, 12).iter().all(|n| *n > 100),
        "{:?}",
        sizes(&growth, 12)
    );
}

/// Also where one of them meets another.
#[test]
fn packed_ones_leave_no_pair_that_overlaps() {
    let plane = common::plane(1.0);
    let mut recipe = common::recipe(0.004, 4000);
    recipe.at.resize(20, SeedPlace::Random);
    let growth = grown(&plane, &recipe);
    let elements = growth.cluster.elements();
    let closest = 2.0 * growth.cluster.radius() * (1.0 - 1e-6);
    let mut others_touch = 0;
    for (age, a) in elements.iter().enumerate() {
        for b in &elements[..age] {
            let distance = a.position.distance(b.position);
            assert!(distance >= closest, "{distance}");
            others_touch += usize::from(a.colony != b.colony && distance < 1.001 * closest);
        }
    }
    assert!(
        others_touch > 10,
        "{others_touch} contacts of others prove nothing"
    );
}

/// Cut off after any number of elements, seeds among them, and on any number of threads.
/// On a plate thinner than an element each grows on its face; both would fit on one.
#[test]
fn two_faces_of_a_plate_have_a_colony_each() {
    let plate = common::slab(8, 1.0, 0.002);
    let recipe = Recipe {
        at: [0.001, -0.001]
            .map(|y| SeedPlace::Point([0.1, y, 0.1]))
            .to_vec(),
        ..common::recipe(0.004, 2000)
    };
    let growth = grown(&plate, &recipe);
    assert!(
        sizes(&growth, 2).iter().all(|n| *n > 700),
        "{:?}",
        sizes(&growth, 2)
    );
    for element in growth.cluster.elements() {
        let is_above = plate.normal(element.at.triangle).y > 0.0;
        assert_eq!(is_above, element.colony == 0);
    }
}

#[test]
fn a_run_that_goes_on_and_one_on_more_threads_are_the_same() {
    let rock = common::rock(24);
    let mut recipe = common::recipe(rock.auto_radius(), 1500);
    recipe.at.resize(5, SeedPlace::Random);
    let whole = grown(&rock, &recipe);
    for cut in [0, 1, 3, 4, 5, 6, 700] {
        let begun = match cut {
            0 => Begun::default(),
            _ => {
                let stop = StopRule::Elements(cut.max(5));
                let mut begun = grown(
                    &rock,
                    &Recipe {
                        stop,
                        ..recipe.clone()
                    },
                )
                .begun();
                begun.elements.truncate(cut as usize);
                begun
            }
        };
        let run = Run::new(&rock, &recipe, begun).expect("goes on");
        let again = run.grow(&Execution::default(), &mut ());
        assert_eq!(again.cluster.elements(), whole.cluster.elements(), "{cut}");
        assert_eq!(again.counts, whole.counts, "{cut}");
    }
    for threads in [2, 3, 8] {
        let many = on_threads(&rock, &recipe, threads);
        assert_eq!(
            many.cluster.elements(),
            whole.cluster.elements(),
            "{threads}"
        );
        assert_eq!(many.counts, whole.counts, "{threads}");
    }
}

/// By symmetry neither has the better chance, whichever began first. The mean of 60 shares is more than four
/// standard errors from a half once in 16,000 times.
#[test]
fn two_on_a_plane_grow_alike() {
    let plane = common::plane(8.0);
    let share = |seed: u64| {
        let mut recipe = common::recipe(0.01, 600);
        (recipe.seed, recipe.at) = (seed, vec![at(-0.5, 0.0), at(0.5, 0.0)]);
        sizes(&grown(&plane, &recipe), 2)[0] as f64 / 600.0
    };
    let shares: Vec<f64> = (1..=60).map(share).collect();
    let mean = shares.iter().sum::<f64>() / 60.0;
    let variance = shares.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 59.0;
    let off = (mean - 0.5) / (variance / 60.0).sqrt();
    assert!(off.abs() < 4.0, "{mean}: {off} standard errors");
    assert!(
        variance > 1e-4,
        "shares of {variance} are not those of chance"
    );
}

/// A large square and, above it, a small one that the launch sphere soon encloses.
fn ground_and_shelf() -> Substrate {
    let square =
        |half: f64, y: f64| [[-half, y], [half, y]].map(|[x, y]| [[x, y, -half], [x, y, half]]);
    let positions = [square(5.0, 0.0), square(0.2, 0.3)]
        .as_flattened()
        .as_flattened()
        .to_vec();
    let triangles = vec![[0, 1, 2], [1, 3, 2], [4, 5, 6], [5, 7, 6]];
    common::substrate(positions, triangles)
}

/// Walkers come to pieces by their area, be these enclosed by the launch sphere or cut.
#[test]
fn a_small_piece_beside_a_large_one_gets_its_share_of_walkers() {
    let mesh = ground_and_shelf();
    let mut recipe = common::recipe(0.004, 4000);
    recipe.at = vec![at(3.0, 0.0), SeedPlace::Point([0.0, 0.3, 0.0])];
    let growth = grown(&mesh, &recipe);
    let [ground, shelf] = sizes(&growth, 2)[..] else {
        panic!("two colonies")
    };
    // 100 to 0.16 by area, and what is lost beyond the kill sphere on the ground.
    assert!(
        (3..400).contains(&shelf) && ground > 3000,
        "{ground} {shelf}"
    );
    for threads in [2, 3] {
        assert_eq!(
            on_threads(&mesh, &recipe, threads).cluster.elements(),
            growth.cluster.elements()
        );
    }
}

/// Each has walkers of its own, until no room is left anywhere.
#[test]
fn pieces_with_a_colony_each_fill_up_all() {
    let squares = two_squares();
    let mut recipe = common::recipe(0.04, 100_000);
    recipe.at = vec![at(-1.0, 0.5), at(1.0, 0.5)];
    let growth = grown(&squares, &recipe);
    assert_eq!(growth.stopped, Stopped::Full);
    let alone = |place: SeedPlace| {
        let at = vec![place];
        grown(
            &squares,
            &Recipe {
                at,
                ..recipe.clone()
            },
        )
        .cluster
        .len()
    };
    let sizes = sizes(&growth, 2);
    for (size, alone) in sizes
        .iter()
        .zip([alone(at(-1.0, 0.5)), alone(at(1.0, 0.5))])
    {
        let ratio = *size as f64 / alone as f64;
        assert!((0.93..1.07).contains(&ratio), "{sizes:?}, alone {alone}");
    }
}

#[test]
fn a_reach_is_that_of_the_largest_and_a_cover_of_all() {
    let squares = two_squares();
    let mut recipe = common::recipe(0.005, 1);
    recipe.at = vec![at(-1.0, 0.5), at(1.0, 0.5)];
    recipe.stop = StopRule::Reach(0.2);
    let growth = grown(&squares, &recipe);
    assert_eq!(growth.stopped, Stopped::Reach);
    let elements = growth.cluster.elements();
    let from_seed = |e: &Element| {
        let seed = &elements[e.colony as usize];
        squares
            .units()
            .length_to_file(e.position.distance(seed.position))
    };
    let (last, before) = elements.split_last().expect("elements");
    assert!(from_seed(last) >= 0.2);
    assert!(before.iter().all(|e| from_seed(e) < 0.2));

    recipe.stop = StopRule::Cover(0.1);
    let growth = grown(&squares, &recipe);
    let discs = std::f64::consts::PI * 0.005 * 0.005;
    let expected = (0.1 * 2.0 / discs).ceil() as usize;
    assert_eq!(growth.cluster.len(), expected, "of both squares");
}

#[test]
fn what_cannot_begin_is_refused() {
    let plane = common::plane(1.0);
    let mut recipe = common::recipe(0.01, 100);
    let refused = |recipe: &Recipe| {
        let refused = grow(&plane, recipe, &Execution::default(), &mut ());
        refused.expect_err("refused")
    };
    recipe.at = vec![at(0.0, 0.0), at(0.3, 0.0), at(0.301, 0.0)];
    let message = refused(&recipe).to_string();
    assert!(message.contains("colonies 1 and 2"), "{message}");
    recipe.at = vec![];
    assert!(matches!(refused(&recipe), GrowError::Recipe(_)));
    recipe.at = vec![SeedPlace::Random; 101];
    assert!(matches!(refused(&recipe), GrowError::Recipe(_)));
    (recipe.at, recipe.join) = (vec![at(0.0, 0.0), at(0.02, 0.0)], Join::Touch);
    assert_eq!(grown(&plane, &recipe).cluster.len(), 100, "side by side");
}

/// By the command: written down, grown again, extended, and measured one by one.
#[test]
fn the_command_grows_and_measures_them() {
    let desk = Desk::new();
    // Enough for each colony to have a front, which takes a hundred.
    let places = "rock.obj --at top --at=0.5,1,0.5 --colonies 4 --seed 7";
    desk.done(&format!("{places} --elements 800 -o whole"));
    let recipe = String::from_utf8(desk.read("whole/recipe.toml")).expect("text");
    let written = "\nat = [\"top\", [0.5, 1.0, 0.5]]";
    assert!(
        recipe.contains(written) && recipe.contains("\ncolonies = 4 "),
        "{recipe}"
    );
    assert_eq!(desk.report("whole")["colonies"], 4);
    desk.done("--recipe whole/recipe.toml -o again");
    desk.assert_same("again", "whole");
    desk.done(&format!("{places} --elements 600 -o out"));
    desk.done("--resume out --elements 800");
    desk.assert_same("out", "whole");
    desk.fails(
        "rock.obj --at top --at top -o none",
        2,
        &["--at: ", "colonies 0 and 1"],
    );

    let analyzed = |words: &str| {
        let output = desk.call("analyze whole", words).output().expect("runs");
        assert!(output.status.success(), "{}", said(&output));
        output
    };
    let all = said(&analyzed(""));
    assert!(
        all.contains("these are 4 colonies, measured as one lichen"),
        "{all}"
    );
    let front = |words: &str| {
        let output = analyzed(words);
        let answer: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        ["front_radius", "front_width", "roughness"].map(|name| answer["scalars"][name].is_f64())
    };
    assert_eq!(
        [front("--json"), front("--json --colony 0")],
        [[false; 3], [true; 3]]
    );
    let sizes = (0..4).map(|colony| {
        let alone = analyzed(&format!("--colony {colony} --json"));
        let answer: serde_json::Value = serde_json::from_slice(&alone.stdout).expect("JSON");
        assert_eq!(said(&alone), "");
        assert_eq!(answer["colony"], colony);
        answer["scalars"]["elements"].as_f64().expect("elements")
    });
    assert_eq!(sizes.sum::<f64>(), 800.0);
    let none = desk
        .call("analyze whole", "--colony 4")
        .output()
        .expect("runs");
    assert_eq!(none.status.code(), Some(2));
    assert!(said(&none).contains("no element is of colony 4; give one from 0 to 3"));
}
