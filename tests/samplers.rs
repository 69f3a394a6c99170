//! Every sampler against its law, by chi-square at a false-alarm rate of 1e-3 a test.
//!
//! With N samples in k bins, shares that are off by a fraction ε in half of the bins raise the
//! statistic by N ε²: at N = 40,000 and k = 32 a test refuses 3.5 % about nine times in ten.
#![allow(clippy::print_stdout, clippy::print_stderr)] // measurements, for whoever asks to see them

#[path = "common/chi_square.rs"]
mod chi_square;
mod common;
#[path = "common/shapes.rs"]
mod shapes;

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use chi_square::{assert_fits, bin, gamma_q, homogeneity, p_value};
use glam::{DVec2, DVec3};
use shapes::*;
use thallus::growth::{Arrival, LaunchRing, Lune, RandomStep, SeedPlace, random_step};
use thallus::rng::{Purpose, Stream};
use thallus::substrate::Substrate;
use thallus::walk::SurfacePoint;

const SAMPLES: usize = 40_000;

#[test]
fn chi_square_knows_its_quantiles_and_refuses_a_bias() {
    // Abramowitz & Stegun, table 26.8.
    for (dof, quantile, tail) in [
        (1.0, 3.841_459, 0.05),
        (10.0, 18.307_04, 0.05),
        (10.0, 29.588_30, 0.001),
        (100.0, 149.449_3, 0.001),
        (4.0, 0.710_723, 0.95),
    ] {
        let q = gamma_q(0.5 * dof, 0.5 * quantile);
        assert!((q - tail).abs() < 1e-6, "{dof}: {q}");
    }
    let mut stream = stream(30);
    let mut counts = [0; 32];
    for _ in 0..SAMPLES {
        let u = stream.uniform();
        // Density 1 ± 5 %.
        counts[bin(u - 0.025 * (u - u * u) * 4.0, 32)] += 1;
    }
    assert!(p_value(&counts, &[1.0; 32]) < chi_square::FALSE_ALARM);
}

/// An axis that is no symmetry of anything here, to count angles about.
fn angle_about(centre: DVec3, p: DVec3) -> f64 {
    let axis = DVec3::new(1.0, 2.0, 3.0).normalize();
    let (x, y) = axis.any_orthonormal_pair();
    let d = p - centre;
    d.dot(y).atan2(d.dot(x)).rem_euclid(TAU) / TAU
}

/// Length of a sphere's cut through triangles, in bins of angle: by splitting the triangles until
/// they are small and cutting each one's edges.
fn brute_force(
    mesh: &Substrate,
    range: &Range<u32>,
    centre: DVec3,
    radius: f64,
    bins: usize,
) -> Vec<f64> {
    let mut lengths = vec![0.0; bins];
    let mut todo: Vec<[DVec3; 3]> = range.clone().map(|t| mesh.corners(t)).collect();
    while let Some([a, b, c]) = todo.pop() {
        let size = (b - a).length().max((c - b).length()).max((a - c).length());
        let middle = (a + b + c) / 3.0;
        if (middle.distance(centre) - radius).abs() > size {
            continue;
        }
        if size > radius / 500.0 {
            let [d, e, f] = [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0];
            todo.extend([[a, d, f], [b, e, d], [c, f, e], [d, e, f]]);
            continue;
        }
        let cuts: Vec<DVec3> = [(a, b), (b, c), (c, a)]
            .into_iter()
            .filter_map(|(p, q)| {
                let (f, g) = (p.distance(centre) - radius, q.distance(centre) - radius);
                ((f < 0.0) != (g < 0.0)).then(|| p.lerp(q, f / (f - g)))
            })
            .collect();
        if let [p, q] = cuts[..] {
            lengths[bin(angle_about(centre, (p + q) / 2.0), bins)] += p.distance(q);
        }
    }
    lengths
}

fn ring(mesh: &Substrate, centre: DVec3, radius: f64) -> LaunchRing {
    let components: Vec<Range<u32>> = mesh
        .components()
        .iter()
        .map(|c| c.triangles.clone())
        .collect();
    LaunchRing::new(mesh, &components, centre, radius)
}

/// The ring's length and its samples against the brute force; returns the length.
fn check_ring(what: &str, mesh: &Substrate, centre: DVec3, radius: f64) -> f64 {
    const BINS: usize = 32;
    let whole = 0..mesh.triangles().len() as u32;
    let expected = brute_force(mesh, &whole, centre, radius, BINS);
    let ring = ring(mesh, centre, radius);
    let length: f64 = expected.iter().sum();
    println!(
        "{what}: length {} and by brute force {length}",
        ring.length()
    );
    assert!((ring.length() / length - 1.0).abs() < 1e-4, "{what}");
    let (mut stream, mut counts) = (stream(31), [0; BINS]);
    for _ in 0..SAMPLES {
        let at = ring.sample(mesh, &mut stream).expect("a point");
        let p = mesh.position(&at);
        assert!((p.distance(centre) - radius).abs() < 1e-12, "{what}: {p}");
        counts[bin(angle_about(centre, p), BINS)] += 1;
    }
    assert_fits(what, &counts, &expected);
    ring.length()
}

#[test]
fn launch_is_uniform_on_a_plane() {
    let mesh = common::plane(4.0);
    let scale = mesh.units().length_to_local(1.0);
    // Inside one triangle, across the diagonal, and out over the rim.
    let inside = DVec3::new(0.3, 0.0, -0.35) * scale;
    let whole = check_ring("circle in one triangle", &mesh, inside, 0.2 * scale);
    assert!((whole / (TAU * 0.2 * scale) - 1.0).abs() < 1e-12);
    let whole = check_ring("circle in two", &mesh, inside, 1.0 * scale);
    assert!((whole / (TAU * scale) - 1.0).abs() < 1e-12);
    check_ring("circle over the rim", &mesh, inside, 2.1 * scale);
    // A sphere about a point beside the surface cuts it in a smaller circle.
    let off = inside + DVec3::Y * 0.8 * scale;
    let whole = check_ring("sphere beside the plane", &mesh, off, 1.0 * scale);
    assert!((whole / (TAU * 0.6 * scale) - 1.0).abs() < 1e-12);
}

/// Three quarter circles about a cube's corner; and unequal arcs on several faces.
#[test]
fn launch_is_uniform_on_a_cubes_faces() {
    for n in [1, 5] {
        let mesh = cube(n);
        let scale = mesh.units().length_to_local(1.0);
        let corner = DVec3::ONE * scale;
        let three = check_ring("about a cube's corner", &mesh, corner, 0.7 * scale);
        assert!((three / (1.5 * PI * 0.7 * scale) - 1.0).abs() < 1e-12);
        let near = DVec3::new(1.0, 0.8, 0.45) * scale;
        check_ring("near a cube's corner", &mesh, near, 0.9 * scale);
    }
}

#[test]
fn launch_is_uniform_on_a_sphere_and_a_rock() {
    let mesh = common::sphere(24);
    let pole = mesh.vertices()[0];
    check_ring("on a sphere", &mesh, pole, 0.8 * pole.length());
    let mesh = common::rock(12);
    let place = mesh.position(&SurfacePoint::centroid(77));
    check_ring("on a rock", &mesh, place, 0.4);
    check_ring("a ring smaller than its triangle", &mesh, place, 0.01);
}

#[test]
fn launch_is_nowhere_when_the_sphere_encloses_all() {
    let mesh = common::rock(8);
    let ring = ring(&mesh, DVec3::ZERO, 2.0);
    assert_eq!(ring.length(), 0.0);
    assert!(ring.sample(&mesh, &mut stream(32)).is_none());
}

/// Circles about lattice points through lattice points: every crossing is at a vertex or a
/// tangent to an edge, where round-off could lose or double one.
#[test]
fn launch_circles_through_vertices_are_whole() {
    let mesh = rectangle(&even(20.0, 20), &even(20.0, 20), Some(stream(33)));
    let scale = mesh.units().length_to_local(1.0);
    for centre in [[10.0, 10.0], [10.5, 10.0], [10.5, 10.5], [9.25, 10.75]] {
        let [x, y] = centre;
        let place = mesh.units().to_local([x, y, 0.0]);
        for i in 0..21 {
            for j in 0..21 {
                let radius = (f64::from(i) - x).hypot(f64::from(j) - y);
                if !(1e-3..=9.0).contains(&radius) {
                    continue;
                }
                let length = ring(&mesh, place, radius * scale).length() / scale;
                let error = (length / (TAU * radius) - 1.0).abs();
                assert!(
                    error < 1e-6,
                    "about {centre:?} through ({i}, {j}): {error:e}"
                );
            }
        }
    }
}

/// Only the components that are named count.
#[test]
fn launch_keeps_to_the_components_with_lichen() {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for (i, height) in [0.0, 0.1].into_iter().enumerate() {
        let at = |x: usize, z: usize| DVec3::new(x as f64, height, z as f64);
        let (more, faces) = patch(1 + i, 1 + i, at, None);
        let first = positions.len() as u32;
        positions.extend(more);
        triangles.extend(faces.iter().map(|t| t.map(|k| first + k)));
    }
    let mesh = common::substrate(positions, triangles);
    let small = &mesh.components()[1];
    let ring = LaunchRing::new(
        &mesh,
        std::slice::from_ref(&small.triangles),
        DVec3::ZERO,
        0.1,
    );
    let mut stream = stream(34);
    for _ in 0..1000 {
        let at = ring.sample(&mesh, &mut stream).expect("a point");
        assert!(small.triangles.contains(&at.triangle));
    }
}

/// Eight rings of equal area by eight sectors.
fn disc_bin(p: DVec2) -> usize {
    let turn = p.y.atan2(p.x).rem_euclid(TAU) / TAU;
    8 * bin(p.length_squared(), 8) + bin(turn, 8)
}

#[test]
fn small_steps_are_uniform_in_the_disc() {
    let (mut stream, mut disc, mut steps) = (stream(35), [0; 64], [0; 64]);
    for _ in 0..SAMPLES {
        disc[disc_bin(stream.in_unit_disc())] += 1;
        let step = random_step(&mut stream, 0.3, 0.3) / 0.3;
        assert!(step.length() <= 1.0 + 1e-15);
        steps[disc_bin(step)] += 1;
    }
    assert_fits("unit disc", &disc, &[1.0; 64]);
    assert_fits("steps with s = r", &steps, &[1.0; 64]);
}

/// d = s − r + r√u: ((d − s + r) / r)² is uniform, whatever the direction.
#[test]
fn large_steps_follow_their_law() {
    for (bound, radius) in [(1.5, 1.0), (20.0, 1.0), (3.0, 0.001)] {
        let (mut stream, mut counts) = (stream(36), [0; 64]);
        for _ in 0..SAMPLES {
            let step = random_step(&mut stream, bound, radius);
            let share = (step.length() - bound + radius) / radius;
            assert!((-1e-9..=1.0 + 1e-9).contains(&share), "{share}");
            counts[disc_bin(step.normalize() * share.clamp(0.0, 1.0))] += 1;
        }
        assert_fits(
            &format!("steps with s = {bound}, r = {radius}"),
            &counts,
            &[1.0; 64],
        );
    }
}

/// Where Brownian motion first leaves a disc beside a circle, told by walking on spheres
/// (Muller 1956) until a millionth of a unit from either.
fn walk_on_spheres(centre: DVec2, contact: f64, free: f64, stream: &mut Stream) -> Arrival {
    let mut p = DVec2::ZERO;
    loop {
        let (to_free, to_contact) = (free - p.length(), p.distance(centre) - contact);
        if to_contact.min(to_free) < 1e-6 {
            let meets = to_contact < to_free;
            return if meets {
                Arrival::Contact(p)
            } else {
                Arrival::Free(p)
            };
        }
        p += stream.in_unit_disc().normalize() * to_contact.min(to_free);
    }
}

/// Arrivals by side and direction.
fn arrivals(mut arrive: impl FnMut() -> Arrival) -> Vec<u64> {
    let mut counts = vec![0; 48];
    for _ in 0..SAMPLES {
        let (side, at) = match arrive() {
            Arrival::Contact(at) => (0, at),
            Arrival::Free(at) => (24, at),
        };
        counts[side + bin(libm::atan2(at.y, at.x).rem_euclid(TAU) / TAU, 24)] += 1;
    }
    counts
}

#[test]
fn brownian_motion_beside_a_circle_arrives_as_by_many_small_steps() {
    let lunes = [
        (DVec2::new(2.5, 0.0), 2.0, 1.5),
        (DVec2::new(-1.2, 1.7), 2.0, 1.0),
        (DVec2::new(0.0, -3.9), 2.0, 3.9),
        (DVec2::new(1.5, 2.0), 2.0, 0.55),
        (DVec2::new(0.3, 0.41), 0.5, 0.4),
    ];
    for (i, (centre, contact, free)) in lunes.into_iter().enumerate() {
        let lune = Lune::new(centre, contact, free).expect("a lune");
        let mut stream = stream(40 + i as u64);
        let exact = arrivals(|| {
            let arrival = lune.first_arrival(RandomStep::draw(&mut stream).cauchy());
            let (Arrival::Contact(at) | Arrival::Free(at)) = arrival;
            let on_contact = (at.distance(centre) - contact).abs() < 1e-9;
            let on_free = (at.length() - free).abs() < 1e-9;
            assert!(if let Arrival::Contact(_) = arrival {
                on_contact
            } else {
                on_free
            });
            arrival
        });
        let walked = arrivals(|| walk_on_spheres(centre, contact, free, &mut stream));
        let p = homogeneity(&exact, &walked);
        assert!(
            p > chi_square::FALSE_ALARM,
            "{centre}, {contact}, {free}: p = {p}"
        );
    }
}

#[test]
fn a_circle_that_does_not_cut_into_the_disc_makes_no_lune() {
    for (distance, contact, free) in [(2.5, 2.0, 0.4), (1.9, 2.0, 1.0), (2.5, 2.0, 2.6)] {
        assert!(Lune::new(DVec2::new(distance, 0.0), contact, free).is_none());
    }
}

/// Triangles very unlike in area.
fn uneven() -> Substrate {
    let xs: Vec<f64> = (0..=9).map(|i| 1.7f64.powi(i) - 1.0).collect();
    let at = |i: usize, j: usize| DVec3::new(xs[i], xs[j].sqrt(), (xs[i] * 0.1).sin());
    let (positions, triangles) = patch(9, 9, at, Some(stream(37)));
    common::substrate(positions, triangles)
}

/// Where a point is in its triangle, in 16 congruent parts.
fn part(at: &SurfacePoint) -> usize {
    let (u, v) = (4.0 * at.u, 4.0 * at.v);
    let upper = (u.fract() + v.fract() > 1.0) as usize;
    let (i, j) = (u as usize, v as usize);
    // Row j has 4 − j triangles that stand and 3 − j that hang.
    (0..j).map(|j| 7 - 2 * j).sum::<usize>() + 2 * i + upper
}

/// Over colonies under one seed, and over seeds.
#[test]
fn area_seeding_is_uniform_by_area() {
    let mesh = uneven();
    let areas: Vec<f64> = (0..mesh.triangles().len() as u32)
        .map(|t| mesh.area(t))
        .collect();
    for over_seeds in [false, true] {
        let (mut triangles, mut parts) = (vec![0; areas.len()], [0; 16]);
        for i in 0..SAMPLES as u64 {
            let (seed, colony) = if over_seeds { (i, 0) } else { (9, i) };
            let at = SeedPlace::Random
                .locate(&mesh, seed, colony)
                .expect("a place");
            triangles[at.triangle as usize] += 1;
            parts[part(&at)] += 1;
        }
        assert_fits("triangles by area", &triangles, &areas);
        assert_fits("inside the triangle", &parts, &[1.0; 16]);
    }
}

fn first_bits(seed: u64, purpose: Purpose, index: u64) -> [u64; 4] {
    let mut stream = Stream::new(seed, purpose, index);
    [(); 4].map(|()| (stream.uniform() * (1u64 << 53) as f64) as u64)
}

#[test]
fn one_address_is_one_stream_and_two_are_two() {
    let mut seen = std::collections::HashSet::new();
    let far = [0, 1, 2, 1 << 32, (1 << 32) + 1, u64::MAX];
    for seed in far {
        for purpose in [Purpose::Walker, Purpose::SeedPlace] {
            for index in far {
                let numbers = first_bits(seed, purpose, index);
                assert_eq!(numbers, first_bits(seed, purpose, index));
                for number in numbers {
                    assert!(seen.insert(number), "{seed} {purpose:?} {index}");
                }
            }
        }
    }
}

/// Walkers' numbers are independent of the next walker's, and of the next seed's.
#[test]
fn neighbouring_streams_are_independent() {
    let first = |seed, index| Stream::new(seed, Purpose::Walker, index).uniform();
    let (mut walkers, mut seeds) = ([0; 64], [0; 64]);
    for i in 0..SAMPLES as u64 {
        walkers[8 * bin(first(1, i), 8) + bin(first(1, i + 1), 8)] += 1;
        seeds[8 * bin(first(i, 1), 8) + bin(first(i + 1, 1), 8)] += 1;
    }
    assert_fits("pairs of walkers", &walkers, &[1.0; 64]);
    assert_fits("pairs of seeds", &seeds, &[1.0; 64]);
}

/// xoshiro256++ and SplitMix64 by an independent program. The numbers are a promise: other ones would
/// change every lichen that was ever grown.
#[test]
fn the_first_numbers_of_a_stream_are_these() {
    assert_eq!(
        first_bits(0, Purpose::Walker, 0),
        [
            1883307781089392,
            7188220419571868,
            4861153777324130,
            3536731578201353
        ]
    );
    assert_eq!(
        first_bits(2001, Purpose::Walker, 17),
        [
            142974120703185,
            2700164235530991,
            2235632304536855,
            1723702351170531
        ]
    );
    assert_eq!(
        first_bits(u64::MAX, Purpose::SeedPlace, 1 << 40),
        [
            4627902911906187,
            2936914043971095,
            778393819297640,
            5941521983625730
        ]
    );
}
