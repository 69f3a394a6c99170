//! Walkers without lichen, against closed forms of diffusion on curved surfaces.
//!
//! A walker steps as the engine's does ([`random_step`], [`trace`], the bound max(D, r) for a
//! distance D through space to what absorbs it, contact judged at the end of a step), but what
//! absorbs it is a set given in closed form.
//!
//! *Discretisation.* A walker is absorbed somewhat inside the set: on average by 0.27 r with small
//! steps and 0.28 r with large ones (the mean overshoot of the one-dimensional walk, simulated;
//! 50,000 and 150,000 walks, ± 0.001). Closed forms are taken with the sets shrunk by that much;
//! what is left is of second order in r and below 0.1 r.
//!
//! *Statistics.* Shares and means must agree within 4 standard errors (6e-5 a comparison by
//! chance, and seeds are fixed), histograms by chi-square at 1e-3.
#![allow(clippy::print_stdout, clippy::print_stderr)] // measurements, for whoever asks to see them

#[path = "common/chi_square.rs"]
mod chi_square;

mod common;
#[path = "common/shapes.rs"]
mod shapes;

use std::f64::consts::{PI, TAU};

use chi_square::{assert_fits, bin};
use glam::DVec3;
use rayon::prelude::*;
use shapes::*;
use thallus::growth::{Steps, random_step};
use thallus::rng::Stream;
use thallus::substrate::{Substrate, SurfacePoint};
use thallus::walk::trace;

/// How walkers walk. Lengths are in the mesh's own units.
#[derive(Clone, Copy)]
struct Walk {
    radius: f64,
    steps: Steps,
    /// Bound on steps besides, from the place.
    most: Bound,
}

/// A bound on a step, from the place.
type Bound = fn(DVec3) -> f64;

fn unbounded(_: DVec3) -> f64 {
    f64::INFINITY
}

impl Walk {
    fn new(steps: Steps, radius: f64) -> Self {
        Self {
            radius,
            steps,
            most: unbounded,
        }
    }

    /// How far inside an absorbing set walkers end on average.
    fn overshoot(&self) -> f64 {
        let share = match self.steps {
            Steps::Small => 0.27,
            Steps::Large | Steps::Exact => 0.28,
        };
        share * self.radius
    }

    /// Walks until the distance to the absorbing set is not positive; returns where.
    fn until_absorbed(
        &self,
        mesh: &Substrate,
        mut at: SurfacePoint,
        distance: impl Fn(DVec3) -> f64,
        stream: &mut Stream,
    ) -> SurfacePoint {
        let units = mesh.units();
        loop {
            let p = units.to_file(mesh.position(&at));
            let far = distance(p);
            if far <= 0.0 {
                return at;
            }
            let bound = match self.steps {
                Steps::Small => self.radius,
                Steps::Large | Steps::Exact => far.min((self.most)(p)).max(self.radius),
            };
            let [bound, radius] = [bound, self.radius].map(|l| units.length_to_local(l));
            at = trace(mesh, &at, random_step(stream, bound, radius), false).point;
        }
    }
}

/// Runs n walkers, each with a stream of its own.
fn each<T: Send>(n: u64, test: u64, walker: impl Fn(&mut Stream) -> T + Sync) -> Vec<T> {
    (0..n)
        .into_par_iter()
        .map(|i| walker(&mut stream((test << 24) + i)))
        .collect()
}

/// # Panics
/// When a mean of n values with this variance is off by more than 4 standard errors.
fn assert_mean(what: &str, mean: f64, expected: f64, variance: f64, n: u64) {
    let error = (variance / n as f64).sqrt();
    let off = (mean - expected) / error;
    println!("{what}: {mean:.5}, expected {expected:.5} ± {error:.5} ({off:+.1} σ)");
    assert!(
        off.abs() < 4.0,
        "{what}: {mean} is not {expected} ± {error}"
    );
}

/// Chance that a walker on the unit sphere at this colatitude meets the cap beyond `south` before
/// the one within `north`.
fn southern_share(at: f64, north: f64, south: f64) -> f64 {
    let height = |theta: f64| (theta / 2.0).tan().ln();
    (height(at) - height(north)) / (height(south) - height(north))
}

/// Two caps, of colatitude 0.5 and 0.8 from the other pole. With n walkers a share that is off by
/// 2/√n (0.010 for 40,000) is found; a walk that took chords for arcs, or lost its direction at
/// edges, would be off by more than that.
#[test]
fn a_sphere_with_two_caps() {
    let (north, south) = (0.5, PI - 0.8);
    let mesh = common::sphere(64);
    let cases = [(Steps::Small, 0.04, 10_000), (Steps::Large, 0.004, 40_000)];
    for (case, (steps, radius, n)) in cases.into_iter().enumerate() {
        let walk = Walk::new(steps, radius);
        for (i, colatitude) in [0.7f64, 1.2, 1.9].into_iter().enumerate() {
            // Through space; the caps' points nearest to a place are on their rims.
            let distance = |p: DVec3| {
                let theta = (p.y / p.length()).acos();
                2.0 * (0.5 * (theta - north).min(south - theta)).sin()
            };
            let ends = each(n, (100 + 10 * case + i) as u64, |stream| {
                let around = direction(stream) * colatitude.sin();
                let start = DVec3::new(around.x, colatitude.cos(), around.y);
                let (at, _) = mesh.nearest(mesh.units().to_local(start.to_array()));
                let end = walk.until_absorbed(&mesh, at, distance, stream);
                mesh.units().to_file(mesh.position(&end)).y < 0.0
            });
            let share = ends.iter().filter(|&&south| south).count() as f64 / n as f64;
            let inside = walk.overshoot();
            let expected = southern_share(colatitude, north - inside, south + inside);
            let what = format!("sphere, {steps:?} steps from {colatitude}");
            assert_mean(&what, share, expected, expected * (1.0 - expected), n);
        }
    }
}

/// Where walkers hit a circle about the apex of a cone (or about a point of the plane: angle 2π)
/// that start at angle 0. z ↦ z^(2π/angle) lays the cone over the plane; in that angle φ' the law
/// has the moments E cos nφ' = m_n.
struct HittingLaw {
    /// m_1, m_2, …
    moments: Vec<f64>,
}

impl HittingLaw {
    /// From a start at `ratio` times the circle's radius. For a start outside, with a circle that
    /// reflects at `rim` times the radius, or infinity.
    fn new(angle: f64, ratio: f64, rim: f64) -> Self {
        let moment = |n: i32| {
            let power = f64::from(n) * TAU / angle;
            if ratio < 1.0 {
                return ratio.powf(power);
            }
            let back = (ratio / (rim * rim)).powf(power);
            (ratio.powf(-power) + back) / (1.0 + rim.powf(-2.0 * power))
        };
        Self {
            moments: (1..400).map(moment).collect(),
        }
    }

    /// Probabilities of n equal bins of φ'/2π from 0 to 1.
    fn bins(&self, n: usize) -> Vec<f64> {
        let cumulative = |share: f64| {
            let term = |(i, m): (usize, &f64)| {
                let k = (i + 1) as f64;
                m * (TAU * k * share).sin() / (k * PI)
            };
            share + self.moments.iter().enumerate().map(term).sum::<f64>()
        };
        (0..n)
            .map(|i| cumulative((i + 1) as f64 / n as f64) - cumulative(i as f64 / n as f64))
            .collect()
    }

    /// Compares shares of the whole turn: two moments, and the histogram.
    fn check(&self, what: &str, turns: &[f64]) {
        let n = turns.len() as u64;
        for k in [1, 2] {
            let mean = moment(turns, k);
            let expected = self.moments[k - 1];
            // Var cos = (1 + m_2k) / 2 − m_k².
            let variance = 0.5 + 0.5 * self.moments[2 * k - 1] - expected * expected;
            assert_mean(&format!("{what}, mode {k}"), mean, expected, variance, n);
        }
        assert_fits(what, &histogram(turns), &self.bins(24));
    }
}

fn histogram(turns: &[f64]) -> [u64; 24] {
    let mut counts = [0; 24];
    turns.iter().for_each(|&t| counts[bin(t, 24)] += 1);
    counts
}

/// E cos kφ'.
fn moment(turns: &[f64], k: usize) -> f64 {
    let sum: f64 = turns.iter().map(|t| (TAU * k as f64 * t).cos()).sum();
    sum / turns.len() as f64
}

/// Poisson's kernel on the plane. From outside nothing kills the walkers; the plane's own rim, at
/// 10,000 radii, sends them back from where they know no direction any more. 40,000 walkers find
/// an error of 0.015 in either moment.
#[test]
fn a_circle_on_the_plane() {
    let mesh = common::plane(20_000.0);
    let small = common::plane(4.0);
    let large = Walk::new(Steps::Large, 0.005);
    let cases = [
        ("from outside", &mesh, large, 2.0, 40_000),
        ("from far outside", &mesh, large, 30.0, 40_000),
        ("from inside", &small, large, 0.5, 40_000),
        (
            "from inside, small",
            &small,
            Walk::new(Steps::Small, 0.04),
            0.5,
            20_000,
        ),
    ];
    for (i, (what, mesh, walk, ratio, n)) in cases.into_iter().enumerate() {
        let outward = if ratio < 1.0 { 1.0 } else { -1.0 };
        let turns = each(n, 200 + i as u64, |stream| {
            let (at, _) = mesh.nearest(mesh.units().to_local([ratio, 0.0, 0.0]));
            let distance = |p: DVec3| (1.0 - p.length()) * outward;
            let end = walk.until_absorbed(mesh, at, distance, stream);
            let p = mesh.units().to_file(mesh.position(&end));
            p.z.atan2(p.x).rem_euclid(TAU) / TAU
        });
        let circle = 1.0 + outward * walk.overshoot();
        HittingLaw::new(TAU, ratio / circle, 1e4).check(what, &turns);
    }
}

/// Shares of the whole turn at which walkers hit the circle of radius 1 about a cone's apex.
fn cone_turns(cone: &Cone, walk: Walk, ratio: f64, n: u64, test: u64) -> Vec<f64> {
    let rings = if ratio < 1.0 {
        vec![0.1, 0.3, 0.7, 1.4]
    } else {
        vec![0.5, 1.2, 3.0, RIM / 2.0, RIM]
    };
    let (mesh, face_of) = cone.mesh(&rings);
    // The nearest point of the circle lies on the generator: no chord is shorter.
    let outward = if ratio < 1.0 { 1.0 } else { -1.0 };
    let distance = |p: DVec3| (1.0 - p.length()) * outward;
    let start = (0.3 * cone.face_angle(), ratio);
    each(n, test, |stream| {
        let place = cone.roll(start.1, start.0).to_array();
        let (at, _) = mesh.nearest(mesh.units().to_local(place));
        let end = walk.until_absorbed(&mesh, at, distance, stream);
        let p = mesh.units().to_file(mesh.position(&end));
        let face = face_of[mesh.source_triangle(end.triangle) as usize];
        let turn = cone.unroll(face, p).1 - start.0;
        turn.rem_euclid(cone.angle) / cone.angle
    })
}

/// Where a cone ends for walkers that start outside the circle.
const RIM: f64 = 20.0;

/// From outside no disc of steps holds the apex: large steps are exact.
#[test]
fn a_circle_about_a_cones_apex_from_outside() {
    for (i, angle) in [1.5, 4.5, 9.0].into_iter().enumerate() {
        let cone = Cone { angle, faces: 40 };
        let walk = Walk::new(Steps::Large, 0.005);
        let turns = cone_turns(&cone, walk, 1.5, 20_000, 300 + i as u64);
        let circle = 1.0 - walk.overshoot();
        // The rim is a polygon; its middle radius is near enough, at (1.5/20)^(2π/angle) squared.
        let law = HittingLaw::new(angle, 1.5 / circle, RIM / circle);
        law.check(&format!("cone of {angle} from outside"), &turns);
    }
}

/// From inside, with small steps, and with steps that end before the apex.
#[test]
fn a_circle_about_a_cones_apex_from_inside() {
    for (i, angle) in [1.5, 4.5, 9.0].into_iter().enumerate() {
        let cone = Cone { angle, faces: 40 };
        let to_apex = Walk {
            most: |p| p.length(),
            ..Walk::new(Steps::Large, 0.005)
        };
        let cases = [(Walk::new(Steps::Small, 0.03), 20_000), (to_apex, 40_000)];
        for (j, (walk, n)) in cases.into_iter().enumerate() {
            let turns = cone_turns(&cone, walk, 0.4, n, (310 + 10 * j + i) as u64);
            let law = HittingLaw::new(angle, 0.4 / (1.0 + walk.overshoot()), 0.0);
            law.check(
                &format!("cone of {angle} from inside, {:?}", walk.steps),
                &turns,
            );
        }
    }
}
