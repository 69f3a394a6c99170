//! One answer on any number of threads.

mod common;
#[path = "common/finer.rs"]
mod finer;
#[path = "common/scarce.rs"]
mod scarce;

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use thallus::cluster::{Cluster, Element};
use thallus::growth::{Boundary, Counts, GrowthModel, Halt, Join, Law, SeedPlace, WalkerModel};
use thallus::run::{
    Begun, Execution, Growth, Progress, Recipe, Run, StopRule, Stopped, grow, watch,
};
use thallus::substrate::Substrate;

/// By as many threads of the operating system: where these are more than the machine has cores, it is as loaded
/// as can be, and any of them may be left waiting at any moment.
fn grown(
    substrate: &Substrate,
    recipe: &Recipe,
    (threads, uses_all_threads): (usize, bool),
) -> (Cluster, Counts, u64) {
    let execution = Execution {
        threads,
        uses_all_threads,
        ..Execution::default()
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let growth = pool
        .expect("threads")
        .install(|| grow(substrate, recipe, &execution, &mut ()))
        .expect("grows");
    if uses_all_threads && threads > 1 {
        assert_eq!(growth.parallel.walks, growth.counts.walkers);
        assert_eq!(growth.parallel.threads, threads);
    }
    (growth.cluster, growth.counts, growth.parallel.conflicts)
}

const ONE: (usize, bool) = (1, true);

/// Element for element and count for count; the number of walkers that walked again.
fn check(name: &str, substrate: &Substrate, recipe: &Recipe) -> u64 {
    let (one, counts, none) = grown(substrate, recipe, ONE);
    assert_eq!(none, 0);
    let mut conflicts = 0;
    // The last goes from one number to another as it runs.
    for threads in [
        (2, true),
        (3, true),
        (4, true),
        (8, true),
        (16, true),
        (4, false),
    ] {
        let (many, their_counts, again) = grown(substrate, recipe, threads);
        let differs = one
            .elements()
            .iter()
            .zip(many.elements())
            .position(|(a, b)| a != b);
        assert_eq!(differs, None, "{name}: {threads:?}, first difference");
        assert_eq!(one.len(), many.len(), "{name}: {threads:?}");
        assert_eq!(counts, their_counts, "{name}: {threads:?}");
        conflicts += again;
    }
    conflicts
}

#[test]
fn packed_lichen_is_the_same_on_any_number_of_threads() {
    let rock = common::rock(24);
    let recipe = common::recipe(rock.auto_radius(), 6000);
    let conflicts = check("rock", &rock, &recipe);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    assert!(conflicts > 0 || cores == 1, "none in another's way");
    let plane = common::plane(2.0);
    let recipe = common::recipe(plane.auto_radius(), 4000);
    assert_eq!(recipe.join, Join::Pack);
    check("plane, with open edges", &plane, &recipe);
}

/// Births that are found ahead are told of one by one, as if they had just been found.
#[test]
fn observers_are_told_the_same_of_each_birth() {
    let rock = common::rock(24);
    let recipe = common::recipe(rock.auto_radius(), 3000);
    let [one, many] = [1, 4].map(|threads| {
        let execution = Execution {
            threads,
            uses_all_threads: true,
            ..Execution::default()
        };
        let mut told = Vec::new();
        let mut observer = watch(|element: &Element, progress: &Progress| {
            told.push((*element, progress.clone()));
            ControlFlow::Continue(())
        });
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads")
            .install(|| grow(&rock, &recipe, &execution, &mut observer))
            .expect("grows");
        told
    });
    assert_eq!(one.len(), 3000);
    let differs = one.iter().zip(&many).position(|(a, b)| a != b);
    assert_eq!((differs, many.len()), (None, 3000));
}

/// Walking stops wherever the index has no room, with walkers on their way that have not seen the last element.
#[test]
fn lichen_is_the_same_where_the_index_has_no_room_time_and_again() {
    let rock = common::rock(24);
    let recipe = common::recipe(rock.auto_radius(), 2500);
    let (one, _, _) = grown(&rock, &recipe, ONE);
    for threads in [2, 3, 8] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let many = pool.expect("threads").install(|| {
            let parameters = recipe.parameters(&rock);
            let model = WalkerModel::<scarce::Scarce>::with_index(&rock, parameters);
            let (mut model, mut cluster) = (model.on_threads(threads), Cluster::new(one.radius()));
            cluster.push(one.elements()[0]);
            model.born(&cluster);
            while cluster.len() < one.len() {
                cluster.push(model.next(&cluster, &|| false).expect("a birth"));
                model.born(&cluster);
            }
            cluster
        });
        let both = one.elements().iter().zip(many.elements());
        let differs = both.into_iter().position(|(a, b)| a != b);
        assert_eq!(differs, None, "{threads} threads, first difference");
    }
}

#[test]
fn touching_lichen_is_the_same_on_any_number_of_threads() {
    let plane = common::plane(2.0);
    let mut recipe = common::recipe(plane.auto_radius(), 6000);
    (recipe.join, recipe.gain, recipe.bias) = (Join::Touch, 0.0, 1.0);
    check("plane", &plane, &recipe);
    recipe.boundary = Boundary::Absorb;
    recipe.kill = 3.0;
    check("plane that absorbs", &plane, &recipe);
    let rock = common::rock(24);
    let mut recipe = common::recipe(rock.auto_radius(), 4000);
    recipe.join = Join::Touch;
    check("rock, which is closed", &rock, &recipe);
}

/// On a fine mesh, which soon has a coarser copy, with elements as large as triangles, until the lichen is
/// all round it.
#[test]
fn lichen_all_round_is_the_same_on_any_number_of_threads() {
    let sphere = common::sphere(52);
    let mut recipe = common::recipe(sphere.units().diagonal() / 120.0, 2500);
    recipe.at = vec![SeedPlace::Center];
    check("sphere", &sphere, &recipe);
    let (_, counts, _) = grown(&sphere, &recipe, ONE);
    let triangles = sphere.triangles().len() as u64;
    assert!(triangles > 20_000 && counts.crossings > 8 * triangles);
    recipe.bias = 0.1;
    check("sphere, B = 0.1", &sphere, &recipe);
}

/// Under the lichen on the other face of a plate thinner than an element, walkers are near what
/// they cannot touch. They must cross below it in few steps, and the same ones on all threads.
#[test]
fn lichen_on_one_face_of_a_plate_is_the_same_and_soon_crossed_under() {
    let slab = common::slab(24, 1.0, 0.001);
    let mut recipe = common::recipe(0.002, 2500);
    recipe.at = vec![SeedPlace::Point([0.0, 1.0, 0.0])];
    check("slab", &slab, &recipe);
    let (cluster, counts, _) = grown(&slab, &recipe, ONE);
    let front = |e: &thallus::cluster::Element| slab.units().to_file(e.position).y > 0.0;
    assert!(cluster.elements().iter().all(front), "the rim is far away");
    let steps = counts.steps / counts.walkers;
    // 278 here. Steps of a radius all the way do not come to an end in a minute.
    assert!(steps < 600, "{steps} steps a walker");
}

/// Brownian walkers ask for elements where others step blindly, and are thrown back elsewhere.
#[test]
fn lichen_of_brownian_motion_is_the_same_on_any_number_of_threads() {
    let (rock, plane, slab) = (
        common::rock(24),
        common::plane(2.0),
        common::slab(24, 1.0, 0.001),
    );
    let brownian = |radius: f64, elements: u64| Recipe {
        law: Law::Brownian,
        ..common::recipe(radius, elements)
    };
    check("rock", &rock, &brownian(rock.auto_radius(), 4000));
    let mut recipe = brownian(plane.auto_radius(), 4000);
    (recipe.join, recipe.gain, recipe.bias) = (Join::Touch, 0.0, 1.0);
    check("plane", &plane, &recipe);
    let mut recipe = brownian(0.002, 2500);
    recipe.at = vec![SeedPlace::Point([0.0, 1.0, 0.0])];
    check("slab", &slab, &recipe);
    let (_, counts, _) = grown(&slab, &recipe, ONE);
    let steps = counts.steps / counts.walkers;
    assert!(steps < 600, "{steps} steps a walker");
}

/// A strip far narrower than an element: no walker comes along it as far as the seed.
#[test]
fn lichen_that_open_edges_leave_no_walker_ends_at_the_same_one_on_any_number_of_threads() {
    let corners = vec![
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 0.0, 1e-5],
        [0.0, 0.0, 1e-5],
    ];
    let strip = common::substrate(corners, vec![[0, 2, 1], [0, 3, 2]]);
    let mut recipe = common::recipe(1e-3, 100);
    recipe.boundary = Boundary::Absorb;
    let [one, two] = [1, 2].map(|threads| {
        let execution = Execution {
            threads,
            ..Execution::default()
        };
        grow(&strip, &recipe, &execution, &mut ()).expect("a seed")
    });
    assert_eq!((one.stopped, one.cluster.len()), (Stopped::Starved, 1));
    assert_eq!(one.counts.absorbed, 10_000_000);
    assert_eq!((two.stopped, &two.counts), (one.stopped, &one.counts));
}

/// A loop of one's own, in which every search for an element is cancelled after a few looks and then begun again.
fn cancelled_now_and_then(substrate: &Substrate, recipe: &Recipe, threads: usize) -> Vec<Element> {
    let model = WalkerModel::new(substrate, recipe.parameters(substrate));
    let mut model = model.on_threads(threads);
    let mut cluster = Cluster::new(recipe.parameters(substrate).radius);
    let seeds = recipe.seeds(substrate).expect("a place");
    cluster.push(Element::seed(substrate, seeds[0]));
    model.born(&cluster);
    let StopRule::Elements(wanted) = recipe.stop else {
        panic!("{:?}", recipe.stop)
    };
    let mut times = 0;
    while (cluster.len() as u64) < wanted {
        let asked = AtomicU64::new(0);
        let cancelled = || asked.fetch_add(1, Ordering::Relaxed) >= 3;
        let next = model.next(&cluster, &cancelled).or_else(|halt| {
            assert_eq!(halt, Halt::Cancelled);
            times += 1;
            model.next(&cluster, &|| false)
        });
        cluster.push(next.expect("nobody cancels"));
        model.born(&cluster);
    }
    assert!(10 * times > cluster.len(), "cancelled {times} times");
    cluster.into_elements()
}

/// Whether who is cancelled grows this lichen too.
fn check_cancelled(substrate: &Substrate, recipe: &Recipe, whole: &Cluster) {
    for threads in [1, 2, 5] {
        let again = cancelled_now_and_then(substrate, recipe, threads);
        assert!(again == whole.elements(), "{threads} threads");
    }
}

/// Births decide when a copy of the surface is made. With these seeds the edge from which on there is to be one is
/// crossed by a walker that dies, and the search then cancelled.
#[test]
fn who_is_cancelled_goes_on_to_the_same_copy() {
    let rock = finer::finer(&common::rock(12), 3);
    for seed in [2, 88] {
        let recipe = Recipe {
            seed,
            ..common::recipe(3.0 * rock.auto_radius(), 120)
        };
        let (whole, counts, _) = grown(&rock, &recipe, ONE);
        let needed = rock.triangles().len() as u64;
        assert!(counts.crossings > needed, "no copy: {counts:?}");
        check_cancelled(&rock, &recipe, &whole);
    }
}

#[test]
fn who_is_cancelled_goes_on_as_if_nothing_had_been() {
    let rock = common::rock(24);
    let recipe = common::recipe(rock.auto_radius(), 1500);
    let (whole, ..) = grown(&rock, &recipe, ONE);
    check_cancelled(&rock, &recipe, &whole);
}

/// A run on some threads of a pool, with an observer that is told how many elements there are.
fn watched(
    (rock, recipe, begun): (&Substrate, &Recipe, Begun),
    [threads, pool]: [usize; 2],
    mut seen: impl FnMut(u64, &Execution) -> ControlFlow<()> + Send,
) -> Growth {
    let execution = Execution {
        threads,
        uses_all_threads: true,
        ..Execution::default()
    };
    let mut observer = watch(|_, progress| seen(progress.elements, &execution));
    let run = Run::new(rock, recipe, begun).expect("begins");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(pool).build();
    let pool = pool.expect("threads");
    pool.install(|| run.grow(&execution, &mut observer))
}

/// Births that were found ahead and that the observer was not told of are none.
#[test]
fn a_run_ends_with_the_element_that_its_observer_was_told_of_last() {
    let rock = common::rock(24);
    let recipe = common::recipe(rock.auto_radius(), 1500);
    let (whole, ..) = grown(&rock, &recipe, ONE);
    let from = watched((&rock, &recipe, Begun::default()), [1, 1], |n, _| match n {
        600 => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    });
    let from = from.begun();
    let ends = (601..=700).step_by(3).enumerate();
    for (i, end) in ends.chain([(0, 1500), (6, 1500)]) {
        // No thread at all counts as one, and a pool may be smaller.
        let threads = [[3, 3], [4, 4], [2, 2], [0, 1], [1, 1], [4, 1]][i % 6];
        let (cancels, is_slow) = (i / 6 % 2 == 1, i / 12 % 2 == 1);
        let mut last = 0;
        let part = watched((&rock, &recipe, from.clone()), threads, |n, execution| {
            assert_eq!(n, std::mem::replace(&mut last, n).max(600) + 1);
            match (n == end, cancels) {
                (true, false) => return ControlFlow::Break(()),
                (true, true) => execution.cancel.store(true, Ordering::Relaxed),
                // So that the flight beside it has ended.
                (false, _) if is_slow => std::thread::sleep(Duration::from_micros(20)),
                (false, _) => {}
            }
            ControlFlow::Continue(())
        });
        let case = format!("{end} on {threads:?}");
        let why = match (end, cancels) {
            (1500, _) => Stopped::Elements,
            (_, false) => Stopped::Observer,
            (_, true) => Stopped::Cancelled,
        };
        assert_eq!((part.stopped, last), (why, end), "{case}");
        assert!(
            part.cluster.elements() == &whole.elements()[..end as usize],
            "{case}"
        );
        assert_eq!(part.counts, part.counts_at_birth, "{case}");
        let rest = watched((&rock, &recipe, part.begun()), [1, 1], |_, _| {
            ControlFlow::Continue(())
        });
        assert!(rest.cluster.elements() == whole.elements(), "{case}");
    }
}

#[test]
fn a_panic_of_an_observer_is_one_of_the_run() {
    let rock = common::rock(24);
    let recipe = common::recipe(rock.auto_radius(), 1500);
    for end in [5, 700, 703] {
        let fails = || {
            watched((&rock, &recipe, Begun::default()), [3, 3], |n, _| {
                assert!(n < end, "as it should");
                ControlFlow::Continue(())
            })
        };
        assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(fails)).is_err());
    }
}
