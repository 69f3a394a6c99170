//! Where lichen may grow: by a mask, and by the slope.

mod common;
#[path = "habitat/exposed.rs"]
mod exposed;
#[path = "habitat/opaque.rs"]
mod opaque;
#[path = "common/png.rs"]
mod png;

use std::f64::consts::PI;

use png::{TEXELS, image};
use thallus::glam::DVec3;
use thallus::growth::{Habitat, Join, Law, PlaceError, SeedPlace, Slope};
use thallus::rng::{Purpose, Stream};
use thallus::run::{
    Begun, Execution, GrowError, Growth, MaskId, Recipe, Run, StopRule, Stopped, grow,
};
use thallus::substrate::{Mask, MaskError, Soup, Substrate, SurfacePoint, Texturing};

/// A square of side 1 in the plane y = 0, of 2 cells² triangles; u is x and v is z, from 0 to 1.
fn square(cells: u32) -> (Substrate, Texturing) {
    let at = |i: u32| f64::from(i) / f64::from(cells);
    let mut positions = Vec::new();
    for i in 0..=cells {
        positions.extend((0..=cells).map(|j| [at(i), 0.0, at(j)]));
    }
    let mut triangles = Vec::new();
    for corner in (0..cells).flat_map(|i| (0..cells).map(move |j| i * (cells + 1) + j)) {
        let [a, b, c, d] = [corner, corner + 1, corner + cells + 2, corner + cells + 1];
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    let uvs: Vec<[f32; 2]> = positions
        .iter()
        .map(|p| [p[0] as f32, p[2] as f32])
        .collect();
    let texturing = Texturing::from_vertices(&triangles, &uvs);
    (common::substrate(positions, triangles), texturing)
}

/// Ground of so many cells of side 1 along a side, with up +Y and a height over each corner.
fn ground(cells: u32, mut height: impl FnMut(f64, f64) -> f64) -> Substrate {
    let (flat, _) = square(cells);
    let mut raised = |p: &DVec3| {
        let [x, _, z] = flat
            .units()
            .to_file(*p)
            .to_array()
            .map(|x| x * f64::from(cells));
        [x, height(x, z), z]
    };
    let positions = flat.vertices().iter().map(&mut raised).collect();
    common::substrate(positions, flat.triangles().to_vec())
}

/// Such a square with a mask.
fn masked(cells: u32, brightness: impl Fn(f64, f64) -> f64) -> Substrate {
    let (substrate, texturing) = square(cells);
    let mask = Mask::from_image(&substrate, &texturing, &image(brightness)).expect("a mask");
    substrate.with_mask(Some(mask))
}

fn disc(radius: f64) -> impl Fn(f64, f64) -> f64 {
    move |u, v| f64::from((u - 0.5).hypot(v - 0.5) < radius)
}

/// A substrate on which another lichen has grown, which is a layer of its mask.
fn beside_one(substrate: Substrate, seed: [f64; 3], radius: f64) -> Substrate {
    let recipe = Recipe {
        at: vec![SeedPlace::Point(seed)],
        ..recipe(&substrate, radius, 1000)
    };
    let other = grown(&substrate, &recipe).cluster;
    let positions: Vec<_> = other.elements().iter().map(|e| e.position).collect();
    let beside = Mask::beside(&substrate, &positions, other.radius());
    let mask = match substrate.mask().cloned() {
        Some(mask) => mask.and(beside),
        None => beside,
    };
    substrate.with_mask(Some(mask))
}

/// A recipe for a substrate with whatever mask it has.
fn recipe(substrate: &Substrate, radius: f64, elements: u64) -> Recipe {
    let id = |mask: &Mask| MaskId {
        layers: vec!["mask.png".to_owned()],
        hashes: mask.hashes().into_iter().map(str::to_owned).collect(),
    };
    Recipe {
        mask: substrate.mask().map(id),
        ..common::recipe(radius, elements)
    }
}

fn grown(substrate: &Substrate, recipe: &Recipe) -> Growth {
    grow(substrate, recipe, &Execution::default(), &mut ()).expect("grows")
}

fn places(substrate: &Substrate, growth: &Growth) -> Vec<DVec3> {
    let elements = growth.cluster.elements().iter();
    elements
        .map(|e| substrate.units().to_file(e.position))
        .collect()
}

#[test]
fn nothing_grows_on_black_and_what_is_white_fills() {
    for cells in [1, 160] {
        let substrate = masked(cells, disc(0.2));
        let recipe = recipe(&substrate, 0.004, 20_000);
        let growth = grown(&substrate, &recipe);
        let habitat = recipe.habitat(&substrate);
        let elements = growth.cluster.elements();
        assert!(elements.iter().all(|e| habitat.at(&e.at) > 0.0), "{cells}");
        // Texels at the rim are grey.
        let all = places(&substrate, &growth);
        let out = |p: &&DVec3| (p.x - 0.5).hypot(p.z - 0.5) > 0.2 + 1.0 / f64::from(TEXELS);
        assert_eq!(all.iter().filter(out).count(), 0, "{cells}");
        assert!(
            matches!(growth.stopped, Stopped::Hemmed | Stopped::Full),
            "{:?}",
            growth.stopped
        );
        let share = all.len() as f64 * PI * 0.004f64.powi(2) / (PI * 0.04);
        assert!(share > 0.7, "{cells}: {share} covered");
    }
}

/// Where either layer is black nothing grows, and greys are multiplied, in whatever order.
#[test]
fn layers_of_a_mask_are_multiplied() {
    let [left, low] = [
        |u: f64, _| 0.5 * f64::from(u < 0.5),
        |_, v: f64| 0.8 * f64::from(v < 0.5),
    ]
    .map(|brightness: fn(f64, f64) -> f64| {
        let (substrate, texturing) = square(1);
        Mask::from_image(&substrate, &texturing, &image(brightness)).expect("a mask")
    });
    let both = left.clone().and(low.clone());
    assert_eq!(both.hashes(), low.clone().and(left.clone()).hashes());
    assert_eq!(both.hashes().len(), 2);
    let substrate = masked(1, |_, _| 1.0);
    for (x, z) in [(0.25, 0.25), (0.25, 0.75), (0.75, 0.25), (0.75, 0.75)] {
        let at = substrate.nearest(substrate.units().to_local([x, 0.0, z])).0;
        assert_eq!(both.at(&at), left.at(&at) * low.at(&at), "{x} {z}");
        assert_eq!(both.at(&at) > 0.0, x < 0.5 && z < 0.5);
    }
}

/// White is as without a mask, to the bit, also where there is black far away: unless 64 walkers in a row are lost,
/// which with this seed they are not.
#[test]
fn a_white_mask_changes_nothing() {
    for (cells, white) in [(1, 1.0), (160, 0.95)] {
        let (bare, _) = square(cells);
        let corner = |u: f64, v: f64| f64::from(u.max(v) > 0.01) * white;
        let substrate = masked(cells, corner);
        let recipe = |substrate: &Substrate| Recipe {
            seed: 2,
            ..recipe(substrate, 0.002, 6000)
        };
        let with = grown(&substrate, &recipe(&substrate));
        let without = grown(&bare, &recipe(&bare));
        assert!(with.cluster.elements() == without.cluster.elements());
        assert_eq!(with.counts, without.counts);
    }
}

/// Where all stick with probability P without it, a grey of g refuses 1 / (g P) − 1 times for each element: n of them
/// as often as a negative binomial says, of standard deviation √(n (1 − g P)) / (g P). Beyond 4 of these it is once in
/// 16,000.
#[test]
fn grey_is_a_factor_on_the_chance_to_stick() {
    for (texel, bias) in [(51, 1.0), (128, 1.0), (204, 1.0), (102, 0.5)] {
        let grey = f64::from(texel) / 255.0;
        let substrate = masked(1, |_, _| grey);
        let recipe = Recipe {
            gain: 0.0,
            bias,
            join: Join::Touch,
            ..recipe(&substrate, 0.002, 4000)
        };
        let growth = grown(&substrate, &recipe);
        let n = growth.counts.contacts - growth.counts.refusals;
        assert_eq!(n, 3999);
        let (n, chance) = (n as f64, grey * bias);
        let deviation = (n * (1.0 - chance)).sqrt() / chance;
        let off = (growth.counts.refusals as f64 - n * (1.0 / chance - 1.0)) / deviation;
        assert!(off.abs() < 4.0, "{texel}: {off}");
        let stuck = growth.cluster.elements()[1..].iter();
        let off = stuck
            .map(|e| (e.probability - chance).abs())
            .fold(0.0, f64::max);
        assert!(off < 1e-6, "{texel}: {off}");
    }
}

/// Rows of an image are from the top, where v is 0, and nothing of the lowest is seen above it.
#[test]
fn images_are_the_right_way_up() {
    let substrate = masked(1, |_, v| f64::from(v < 0.25));
    let recipe = Recipe {
        at: vec![SeedPlace::Random],
        ..recipe(&substrate, 0.004, 1500)
    };
    let all = places(&substrate, &grown(&substrate, &recipe));
    let highest = all.iter().map(|p| p.z).fold(0.0, f64::max);
    assert!((0.2..0.255).contains(&highest), "{highest}");
    let place = |z| {
        substrate
            .nearest(substrate.units().to_local([0.5, 0.0, z]))
            .0
    };
    let habitat = recipe.habitat(&substrate);
    assert_eq!([0.0001, 0.9999].map(|z| habitat.at(&place(z))), [1.0, 0.0]);
}

/// A patch that is less than a thousandth of a mesh of two triangles, with others beside it.
#[test]
fn small_patches_fill_on_large_triangles_too() {
    let patches = |u: f64, v: f64| {
        let within = |x: f64| ((8.0 * x).fract() - 0.5).abs() < 0.08;
        f64::from(within(u) && within(v))
    };
    let sizes = [1, 160].map(|cells| {
        let substrate = masked(cells, patches);
        let recipe = Recipe {
            at: vec![SeedPlace::Point([0.5625, 0.0, 0.5625])],
            ..recipe(&substrate, 0.0005, 20_000)
        };
        let growth = grown(&substrate, &recipe);
        assert!(growth.stopped != Stopped::Elements, "{cells}");
        let patch = recipe.habitat(&substrate).share([0].into_iter()) / 64.0;
        growth.cluster.len() as f64 * PI * 0.0005f64.powi(2) / patch
    });
    assert!(
        sizes.iter().all(|share| (0.6..0.85).contains(share)),
        "{sizes:?}"
    );
}

/// No element of a lichen is nearer to one of another than their radii together, on a slab of a thickness less than
/// that and on a rock; and it grows up to it. Radii as much smaller and larger.
#[test]
fn lichens_grow_beside_others_and_not_over_them() {
    for radius in [0.002, 0.004, 0.01] {
        for (mesh, seed, away) in [
            (
                common::slab(8, 1.0, 0.005),
                [0.0, 0.0025, 0.0],
                [0.18, 0.0025, 0.05],
            ),
            (common::rock(60), [0.0, 1.0, 0.0], [0.15, 1.0, 0.15]),
        ] {
            let substrate = beside_one(mesh, seed, 0.004);
            let alone = Recipe {
                at: vec![SeedPlace::Point(away)],
                ..recipe(&substrate, radius, 3000)
            };
            let growth = grown(&substrate, &alone);
            assert_eq!(growth.stopped, Stopped::Elements, "{radius}");
            let mask = substrate.mask().expect("a mask");
            let radius = growth.cluster.radius();
            let free = |share: f64| {
                let all = growth.cluster.elements().iter();
                all.filter(|e| mask.leaves_room(e.position, share * radius))
                    .count()
            };
            assert_eq!(free(1.0), 3000);
            assert!(free(4.0) < 3000, "{radius}: it grows nowhere near");
        }
    }
}

/// What is left between two lichens is pinholes that few walkers come to: growth ends for want of places, without much
/// more walking than the elements took.
#[test]
fn what_another_leaves_fills_up_and_ends() {
    let substrate = beside_one(common::rock(60), [0.0, 1.0, 0.0], 0.02);
    let all = Recipe {
        stop: StopRule::Cover(1.0),
        at: vec![SeedPlace::Center],
        ..recipe(&substrate, 0.02, 1)
    };
    let growth = grown(&substrate, &all);
    assert!(matches!(growth.stopped, Stopped::Hemmed | Stopped::Full));
    // 490, where walkers were given up sixteen times as late 31,000.
    let steps = growth.counts.steps as f64 / growth.cluster.len() as f64;
    assert!(steps < 3000.0, "{steps}");
}

/// A line one and a half elements wide: what would be packed beside it stays where it touched.
#[test]
fn narrow_lines_are_followed() {
    let substrate = masked(1, |_, v| f64::from((v - 0.5).abs() < 0.006));
    let recipe = recipe(&substrate, 0.004, 2000);
    let all = places(&substrate, &grown(&substrate, &recipe));
    let [low, high] = [f64::min, f64::max].map(|f| all.iter().map(|p| p.x).fold(0.5, f));
    assert!(high - low > 0.8, "{low} to {high}: {}", all.len());
}

/// Walls are among the slopes up to 90 degrees and from them.
#[test]
fn the_limits_of_a_slope_are_of_it() {
    let slab = common::slab(4, 1.0, 0.5);
    let at = |p: [f64; 3]| slab.nearest(slab.units().to_local(p)).0;
    let (top, wall, below) = (
        at([0.0, 0.3, 0.0]),
        at([0.6, 0.0, 0.0]),
        at([0.0, -0.3, 0.0]),
    );
    for (least, most, expected) in [
        (0.0, 90.0, [1.0, 1.0, 0.0]),
        (90.0, 180.0, [0.0, 1.0, 1.0]),
        (30.0, 60.0, [0.0; 3]),
        (0.0, 180.0, [1.0; 3]),
    ] {
        let habitat = Habitat::new(&slab, Slope::new(least, most), 1e-3);
        assert_eq!([&top, &wall, &below].map(|at| habitat.at(at)), expected);
    }
}

#[test]
fn the_darkest_greys_are_black_and_the_lightest_white() {
    let factor = |brightness: f64| {
        let substrate = masked(1, |_, _| brightness);
        let at = substrate.nearest(DVec3::ZERO).0;
        Habitat::new(&substrate, None, 1e-3).at(&at)
    };
    assert_eq!([0.0, 0.06].map(factor), [0.0; 2]);
    assert_eq!([0.95, 1.0].map(factor), [1.0; 2]);
    assert!((factor(0.5) - 128.0 / 255.0).abs() < 1e-6);
}

/// A border across the middle of a square is to the lichen about as the open edge of half the square is, which
/// reflects: means over seeds of how many elements are within 20 radii of it. Walkers that would leave stay where they
/// are, which brings a tenth fewer there (of 96 seeds 366 ± 4 and 411 ± 5).
#[test]
fn a_border_is_as_an_open_edge() {
    const R: f64 = 0.004;
    let half = common::substrate(
        vec![[0.0; 3], [0.0, 0.0, 1.0], [0.5, 0.0, 1.0], [0.5, 0.0, 0.0]],
        vec![[0, 1, 2], [0, 2, 3]],
    );
    let substrate = masked(1, |u, _| f64::from(u < 0.5));
    let near = |substrate: &Substrate| {
        let counts = (1..=24).map(|seed| {
            let recipe = Recipe {
                seed,
                at: vec![SeedPlace::Point([0.4, 0.0, 0.5])],
                ..recipe(substrate, R, 2500)
            };
            let all = places(substrate, &grown(substrate, &recipe));
            all.iter().filter(|p| p.x > 0.5 - 20.0 * R).count() as f64
        });
        let counts: Vec<f64> = counts.collect();
        let n = counts.len() as f64;
        let mean = counts.iter().sum::<f64>() / n;
        let variance = counts.iter().map(|c| (c - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (mean, variance / n)
    };
    let ((with, a), (without, b)) = (near(&substrate), near(&half));
    let (ratio, error) = (with / without, (a + b).sqrt() / without);
    assert!(
        (ratio - 0.89).abs() < 4.0 * error,
        "{with} and {without}: {ratio} ± {error}"
    );
    assert!(error < 0.04, "{error}");
    assert!(with > 200.0, "{with}");
}

#[test]
fn the_same_bytes_on_any_number_of_threads_and_from_any_cut() {
    let patches = |u: f64, v: f64| {
        let wave = (23.0 * u).sin() * (19.0 * v + 1.0).cos() + 0.6 * (61.0 * u + 3.0 * v).sin();
        (0.5 + 2.0 * wave).clamp(0.0, 1.0)
    };
    let patched = masked(1, patches);
    let [disc, fine] = [1, 160].map(|cells| masked(cells, disc(0.12)));
    let rock = common::rock(60);
    let beside = beside_one(masked(1, patches), [0.5, 0.0, 0.45], 0.003);
    for (substrate, law, elements) in [
        (&beside, Law::Thesis, 3000),
        (&beside, Law::Brownian, 1000),
        (&patched, Law::Thesis, 5000),
        (&patched, Law::Brownian, 2000),
        (&disc, Law::Thesis, 3000),
        (&fine, Law::Thesis, 3000),
        (&rock, Law::Thesis, 4000),
    ] {
        let recipe = Recipe {
            law,
            slope: Slope::new(0.0, 55.0),
            at: vec![SeedPlace::Random],
            ..recipe(substrate, 0.002, elements)
        };
        let alone = grown(substrate, &recipe);
        let habitat = recipe.habitat(substrate);
        let all = alone.cluster.elements();
        assert!(
            all.iter().all(|e| habitat.at(&e.at) > 0.0),
            "{law:?} {elements}"
        );
        for threads in [2, 3, 8] {
            let execution = Execution {
                threads,
                uses_all_threads: true,
                ..Execution::default()
            };
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let together = pool
                .expect("threads")
                .install(|| grow(substrate, &recipe, &execution, &mut ()))
                .expect("grows");
            assert!(
                together.cluster.elements() == alone.cluster.elements(),
                "{threads}"
            );
            assert_eq!(together.counts, alone.counts, "{threads}");
            assert_eq!(together.stopped, alone.stopped, "{threads}");
        }
        for share in [0.3, 0.8, 0.98] {
            let part = Recipe {
                stop: StopRule::Elements((share * alone.cluster.len() as f64) as u64),
                ..recipe.clone()
            };
            let begun = grown(substrate, &part).begun();
            let run = Run::new(substrate, &recipe, begun).expect("goes on");
            let whole = run.grow(&Execution::default(), &mut ());
            assert!(
                whole.cluster.elements() == alone.cluster.elements(),
                "{share}"
            );
            assert_eq!(whole.stopped, alone.stopped, "{share}");
        }
    }
}

/// On a sphere the slope of the smooth surface is the angle from the pole.
#[test]
fn slopes_are_those_of_the_smooth_surface() {
    let sphere = common::sphere(40);
    for [least, most] in [[0.0, 50.0], [30.0, 90.0], [120.0, 180.0]] {
        let recipe = Recipe {
            slope: Slope::new(least, most),
            ..recipe(&sphere, 0.01, 4000)
        };
        let growth = grown(&sphere, &recipe);
        for p in places(&sphere, &growth) {
            let angle = (p.y / p.length()).acos().to_degrees();
            assert!((least - 0.2..most + 0.2).contains(&angle), "{angle}");
        }
        let share = recipe.habitat(&sphere).share([0].into_iter());
        let cap = |angle: f64| (1.0 - angle.to_radians().cos()) / 2.0;
        let off = share - (cap(most) - cap(least));
        assert!(off.abs() < 0.015, "{least} to {most}: {share}");
    }
}

/// Ground that rises by 30 degrees, in steps of two cells or with noise of a sixth of a cell, as terrain and scans have
/// it: it is as steep as it is on the whole.
#[test]
fn slopes_know_nothing_of_steps_and_noise() {
    let rise = 30f64.to_radians().tan();
    let mut stream = Stream::new(1, Purpose::Walker, 0);
    let mut noise = || stream.uniform() - 0.5;
    let stepped = ground(200, |x, _| (x * rise / 2.0).round() * 2.0);
    let noisy = ground(200, |x, _| x * rise + 0.6 * noise());
    for ground in [stepped, noisy] {
        let share = |least, most| {
            let habitat = Habitat::new(&ground, Slope::new(least, most), 1e-3);
            habitat.share([0].into_iter())
        };
        let of_slopes = [share(0.0, 45.0), share(0.0, 15.0), share(20.0, 40.0)];
        assert!(
            of_slopes[0] > 0.97 && of_slopes[1] < 0.03 && of_slopes[2] > 0.9,
            "{of_slopes:?}"
        );
    }
}

/// A box whose top is two triangles and whose walls are cut fine: the walls stay walls up to the edge.
#[test]
fn slopes_of_fine_faces_are_not_those_of_large_ones_beside_them() {
    const CELLS: u32 = 150;
    let at = |k: u32| f64::from(k) / f64::from(CELLS);
    let mut positions = vec![
        [0.0, 1.0, 0.0],
        [0.0, 1.0, 1.0],
        [1.0, 1.0, 1.0],
        [1.0, 1.0, 0.0],
    ];
    let mut triangles = vec![[0, 1, 2], [0, 2, 3]];
    for i in 0..=CELLS {
        positions.extend((0..=CELLS).map(|j| [at(i), 1.0 - at(j), 1.0]));
    }
    for corner in (0..CELLS).flat_map(|i| (0..CELLS).map(move |j| 4 + i * (CELLS + 1) + j)) {
        let [a, b, c, d] = [corner, corner + 1, corner + CELLS + 2, corner + CELLS + 1];
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    let corner = common::substrate(positions, triangles);
    let habitat = Habitat::new(&corner, Slope::new(0.0, 60.0), 1e-3);
    let at = |y: f64, z: f64| {
        let place = corner.units().to_local([0.4, y, z]);
        habitat.at(&corner.nearest(place).0)
    };
    assert_eq!([at(1.0, 0.9), at(1.0, 0.999)], [1.0; 2]);
    assert_eq!([at(0.995, 1.0), at(0.99, 1.0), at(0.5, 1.0)], [0.0; 3]);
}

/// Where nothing may grow at the top a seed goes to where there is room for a lichen, not to a crumb that is nearer.
#[test]
fn seeds_that_are_moved_have_room() {
    let crumb_and_disc = |u: f64, v: f64| {
        let is_in = |x: f64, radius: f64| (u - x).hypot(v - 0.5) < radius;
        f64::from(is_in(0.45, 0.012) || is_in(0.2, 0.15))
    };
    let substrate = masked(1, crumb_and_disc);
    let seed = |radius: f64| {
        let at = recipe(&substrate, radius, 10)
            .seeds(&substrate)
            .expect("a place")[0];
        substrate.units().to_file(substrate.position(&at)).x
    };
    assert!(seed(0.002) < 0.35, "{}", seed(0.002));
    // None has room for this one.
    assert!(seed(0.02) > 0.4, "{}", seed(0.02));
}

/// Chi-square of 4 degrees of freedom is beyond 23.5 once in 10,000.
#[test]
fn random_seeds_are_as_frequent_as_it_is_bright() {
    let substrate = masked(1, |u, _| (5.0 * u).floor() / 4.0);
    let habitat = Habitat::new(&substrate, None, 1e-3);
    let seeds = SeedPlace::locate_all(&vec![SeedPlace::Random; 4000], &habitat, 7, 1e-7);
    let mut counts = [0.0; 5];
    for at in seeds.expect("room") {
        let x = substrate.units().to_file(substrate.position(&at)).x;
        // Texels in between are of no fifth.
        let fifth = (5.0 * x).floor();
        let inside = ((5.0 * x).fract() - 0.5).abs() < 0.45;
        counts[fifth as usize] += f64::from(inside);
    }
    assert_eq!(counts[0], 0.0, "black");
    let all: f64 = counts.iter().sum();
    let expected = |i: usize| all * i as f64 / 10.0;
    let off = (1..5).map(|i| (counts[i] - expected(i)).powi(2) / expected(i));
    assert!(off.clone().sum::<f64>() < 23.5, "{counts:?}");
}

/// So dark that chance lets something grow on one of three thousand places: most seeds found none.
#[test]
fn seeds_find_places_where_it_is_dark() {
    let (substrate, texturing) = square(1);
    let grey = Mask::from_image(&substrate, &texturing, &image(|_, _| 0.07)).expect("a mask");
    let thrice = grey.clone().and(grey.clone()).and(grey);
    let substrate = substrate.with_mask(Some(thrice));
    let habitat = Habitat::new(&substrate, None, 1e-3);
    let seeds = SeedPlace::locate_all(&vec![SeedPlace::Random; 20], &habitat, 3, 1e-7);
    assert_eq!(seeds.expect("room").len(), 20);
}

#[test]
fn seeds_go_where_something_may_grow() {
    // An image goes on at its borders: white there would be at both.
    let substrate = masked(1, |u, _| f64::from((0.1..0.25).contains(&u)));
    let seeds = |place: SeedPlace| {
        let recipe = Recipe {
            at: vec![place],
            ..recipe(&substrate, 0.002, 10)
        };
        recipe.seeds(&substrate)
    };
    for place in [SeedPlace::Top, SeedPlace::Center, SeedPlace::Highest] {
        let at = seeds(place.clone()).expect("a place")[0];
        let x = substrate.units().to_file(substrate.position(&at)).x;
        assert!(x < 0.255, "{place:?}: {x}");
    }
    let top = seeds(SeedPlace::Top).expect("a place")[0];
    let top = substrate.units().to_file(substrate.position(&top));
    assert!(top.distance(DVec3::new(0.25, 0.0, 0.5)) < 0.03, "{top}");
    let barren = seeds(SeedPlace::Point([0.75, 0.0, 0.5]));
    let Err(PlaceError::Barren {
        nearest: Some([x, ..]),
        ..
    }) = barren
    else {
        panic!("{barren:?}");
    };
    assert!((0.22..0.255).contains(&x), "{x}");
    let black = masked(1, |_, _| 0.0);
    for place in [SeedPlace::Top, SeedPlace::Random] {
        let recipe = Recipe {
            at: vec![place],
            ..recipe(&black, 0.002, 10)
        };
        assert_eq!(recipe.seeds(&black), Err(PlaceError::NoHabitat));
    }
}

#[test]
fn a_cover_is_of_what_may_be_covered() {
    let substrate = masked(1, disc(0.2));
    let recipe = Recipe {
        stop: StopRule::Cover(0.4),
        ..recipe(&substrate, 0.002, 1)
    };
    let growth = grown(&substrate, &recipe);
    assert_eq!(growth.stopped, Stopped::Cover);
    let each = 0.002f64.powi(2) / 0.2f64.powi(2);
    let covered = each * growth.cluster.len() as f64;
    assert!((0.38..0.42).contains(&covered), "{covered}");
}

/// Against a share by four million places; 0.07 is three standard deviations of what 2,000 suited ones tell.
#[test]
fn small_habitats_are_measured_too() {
    let mut stream = Stream::new(5, Purpose::Walker, 0);
    for radius in [0.02, 0.03, 0.05] {
        let substrate = masked(1, disc(radius));
        let habitat = Habitat::new(&substrate, None, 1e-4);
        let is_suited = |k: &u32| {
            let (across, up) = (stream.uniform().sqrt(), stream.uniform());
            let (triangle, u, v) = (k % 2, (1.0 - up) * across, up * across);
            habitat.at(&SurfacePoint { triangle, u, v }) > 0.0
        };
        let expected = (0..4_000_000).filter(is_suited).count() as f64 / 4e6;
        let share = habitat.share([0].into_iter());
        assert!((share / expected - 1.0).abs() < 0.07, "{share} {expected}");
    }
}

#[test]
fn masks_are_told_from_one_another() {
    let (bare, texturing) = square(1);
    let [left, right] = [(0.0, 0.5), (0.5, 1.0)]
        .map(|(low, high)| masked(1, move |u, _| f64::from((low..high).contains(&u))));
    let of_left = recipe(&left, 0.002, 10);
    for other in [&bare, &right] {
        let run = Run::new(other, &of_left, Begun::default());
        assert!(matches!(run, Err(GrowError::Mask)), "{run:?}");
    }
    assert!(Run::new(&left, &of_left, Begun::default()).is_ok());
    let no_uvs = Mask::from_image(&bare, &Texturing::default(), &image(|_, _| 1.0));
    assert_eq!(no_uvs.err(), Some(MaskError::NoUvs));
    let no_tile = Mask::from_tiles(&bare, &texturing, &[(1002, image(|_, _| 1.0))].into());
    assert_eq!(no_tile.err(), Some(MaskError::NoTile));
    let nowhere = Mask::from_tiles(&bare, &Texturing::default(), &[].into());
    assert_eq!(nowhere.err(), Some(MaskError::NoUvs));
    let no_image = Mask::from_image(&bare, &texturing, b"P5 1 1 255 0");
    assert!(matches!(no_image, Err(MaskError::Image(_))));
    let no_colors = Mask::from_colors(&bare, &texturing);
    assert_eq!(no_colors.err(), Some(MaskError::NoColors));
}

#[test]
fn colours_of_vertices_are_a_mask() {
    let soup = Soup {
        positions: vec![[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        notes: Vec::new(),
    };
    let substrate = Substrate::from_soup(soup).expect("a mesh");
    // Brightness rises with x.
    let texturing = Texturing {
        colors: vec![
            Some([[0.0; 3], [0.0; 3], [1.0; 3]]),
            Some([[0.0; 3], [1.0; 3], [1.0; 3]]),
        ],
        ..Texturing::default()
    };
    let mask = Mask::from_colors(&substrate, &texturing).expect("colours");
    assert_eq!(mask.unpainted(), 0);
    let half_painted = Texturing {
        colors: vec![None, texturing.colors[1]],
        ..Texturing::default()
    };
    let other = Mask::from_colors(&substrate, &half_painted).expect("colours");
    assert_eq!(other.unpainted(), 1);
    assert_ne!(mask.hashes(), other.hashes());
    for x in [0.01, 0.3, 0.5, 0.9, 0.99] {
        let p = substrate.units().to_local([x, 0.0, 0.4]);
        let found = mask.at(&substrate.nearest(p).0);
        let expected = match x {
            x if x < 1.0 / 16.0 => 0.0,
            x if x > 15.0 / 16.0 => 1.0,
            x => x,
        };
        assert!((found - expected).abs() < 1e-6, "{x}: {found}");
    }
}
