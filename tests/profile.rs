//! The density profile and its ground on surfaces of which the areas are known.
#![allow(clippy::print_stdout)] // measurements, for whoever asks to see them

mod common;
#[path = "common/shapes.rs"]
mod shapes;

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use shapes::{Prism, outwards, packing};
use thallus::analysis::{Centres, Metric, SurfaceMetric, analyze};
use thallus::morphometry::{Sample, smooth_normals};
use thallus::substrate::Substrate;

fn assert_near(found: f64, expected: f64, within: f64) {
    assert!(
        (found - expected).abs() <= within,
        "{found}, not {expected}"
    );
}

/// The profile of elements at these positions of a mesh, and the radius that all rings reach to.
fn profile_on(mesh: &Substrate, radius: f64, positions: &[DVec3]) -> Vec<[f64; 2]> {
    let local = |p: &DVec3| mesh.units().to_local(p.to_array());
    let places: Vec<_> = positions.iter().map(|p| mesh.nearest(local(p)).0).collect();
    let positions: Vec<_> = positions.iter().map(|p| p.to_array()).collect();
    let normals = smooth_normals(mesh, &places);
    let normals: Vec<_> = normals.iter().map(|n| n.as_vec3().to_array()).collect();
    let parents: Vec<_> = (-1..positions.len() as i32 - 1).collect();
    let sample = Sample {
        radius,
        positions: &positions,
        normals: &normals,
        parents: &parents,
    };
    let few = Centres {
        space: 1,
        surface: 0,
    };
    let metric = SurfaceMetric::new(mesh, &places);
    let found = analyze(&sample, Some(&metric), few);
    found.expect("elements").front.profile
}

/// The share that elements with one to this much area cover, all rings but the last, beyond which the
/// elements at its edge stand out.
fn assert_even(profile: &[[f64; 2]], expected: f64, within: f64) {
    assert_eq!(profile.len(), 32);
    for [distance, share] in &profile[..31] {
        println!("{distance:.4} {share:.4}, {expected:.4}");
    }
    for [_, share] in &profile[..31] {
        assert_near(*share, expected, within);
    }
}

/// Areas of 32 rings about a place, as shares of what a closed form has within each distance.
fn assert_ground(mesh: &Substrate, at: DVec3, reach: f64, within: impl Fn(f64) -> f64) {
    let place = mesh.nearest(mesh.units().to_local(at.to_array())).0;
    let width = reach / 32.0;
    let places = [place];
    let metric = SurfaceMetric::new(mesh, &places);
    let areas = metric.ring_areas(0, width, 32).unwrap();
    for (k, area) in areas.into_iter().enumerate() {
        let expected = within((k + 1) as f64 * width) - within(k as f64 * width);
        println!("{k} {:.4}", area / expected);
        assert_near(area / expected, 1.0, 0.01);
    }
}

#[test]
fn rings_of_ground_have_the_areas_of_the_closed_forms() {
    let disc = |d: f64| PI * d * d;
    assert_ground(&common::plane(3.0), DVec3::new(0.2, 0.0, 0.1), 1.2, disc);
    let cap = |d: f64| TAU * (1.0 - d.cos());
    assert_ground(&common::sphere(64), DVec3::Y, 0.9 * PI, cap);
    let prism = Prism {
        sides: 24,
        height: 14.0,
    };
    let half = 12.0 * prism.width();
    let strip = |d: f64| {
        let x = half.min(d);
        2.0 * (x * (d * d - x * x).sqrt() + d * d * (x / d.max(1e-9)).asin())
    };
    let middle = prism.roll(0.3 * prism.width(), 7.0);
    assert_ground(&prism.mesh(20), middle, 6.5, strip);
}

/// Packed discs cover π/√12 of the plane in every ring, and counted whole in flat rings, as once was
/// done, they come to the same but for what sticks out.
#[test]
fn on_a_plane_the_profile_is_that_of_flat_rings() {
    let packed = outwards(packing(140).filter(|p| p.length() < 240.0).collect());
    let lifted: Vec<_> = packed.iter().map(|p| DVec3::new(p.x, 0.0, p.y)).collect();
    let profile = profile_on(&common::plane(800.0), 1.0, &lifted);
    assert_even(&profile, PI / 12f64.sqrt(), 0.02);
    let width = packed[packed.len() - 1].length() / 32.0;
    for (k, [middle, share]) in profile.iter().enumerate().take(31).skip(3) {
        let [inner, outer] = [k, k + 1].map(|k| k as f64 * width);
        let inside = |p: &&DVec2| (inner..outer).contains(&p.length());
        let count = packed.iter().filter(inside).count() as f64;
        assert_near(*middle, 0.5 * (inner + outer), 1e-6 * outer);
        assert_near(*share, count / (outer * outer - inner * inner), 0.08);
    }
}

/// Elements with equal areas about each: a spiral on the whole sphere, of which those within a cap, or
/// all of the sphere, are grown over.
#[test]
fn on_a_sphere_the_profile_is_the_share_that_is_covered() {
    let (n, share) = (40_000, 0.6);
    let golden = PI * (3.0 - 5f64.sqrt());
    let place = |i: i32| {
        let y = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(n);
        let (sin, cos) = (golden * f64::from(i)).sin_cos();
        let flat = (1.0 - y * y).sqrt();
        DVec3::new(flat * cos, y, flat * sin)
    };
    let radius = (4.0 * share / f64::from(n)).sqrt();
    let mesh = common::sphere(32);
    for farthest in [1.0, 2.0, PI] {
        let places = (0..n).map(place).filter(|p| p.y.acos() < farthest);
        let places: Vec<_> = std::iter::once(DVec3::Y).chain(places.skip(1)).collect();
        assert_even(&profile_on(&mesh, radius, &places), share, 0.02);
    }
}

/// A square lattice on a prism that is rolled up, grown so far around that rings meet behind.
#[test]
fn on_a_prism_the_profile_is_the_share_that_is_covered() {
    let prism = Prism {
        sides: 24,
        height: 14.0,
    };
    let girth = 24.0 * prism.width();
    let (columns, share) = (120, 0.6);
    let step = girth / f64::from(columns);
    let flat = |i: i32, j: i32| DVec2::new(f64::from(i) * step, f64::from(j) * step);
    let half = columns / 2;
    let lattice = (-half..half).flat_map(|i| (-half * 2..=half * 2).map(move |j| flat(i, j)));
    let near = outwards(lattice.filter(|p| p.length() < 1.8 * PI).collect());
    let roll = |p: &DVec2| prism.roll(p.x + 0.3 * prism.width(), p.y + 7.0);
    let places: Vec<_> = near.iter().map(roll).collect();
    let radius = step * (share / PI).sqrt();
    assert_even(&profile_on(&prism.mesh(20), radius, &places), share, 0.02);
}
