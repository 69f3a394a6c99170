//! Sumner's growth on a triangle mesh, written out literally and slowly.
//!
//! This is the yardstick for the engine: it shares no code with the crate, looks nothing up that it can compute, and
//! keeps the steps of Sumner 2001, chapter 6, in his order. Both errata of the design page are applied: nearby sets
//! reach q + 2r and are decided by a triangle's nearest point; the curvature is κ = (n − N_L)/N_L.
//!
//! Departures: arcs are cut in every triangle instead of in the edges only; packing follows exact circular arcs instead
//! of small rotations. [`Search::Cells`] answers the same neighbour questions from a box grid, for clusters that lists
//! on two huge triangles would make quadratic; a test holds the two to equal clusters.
//!
//! Measured: with refusals the thesis's large steps (`margin` 1) are not the law of its small ones. They arrive deeper
//! inside contact and are thrown back farther, so fewer contacts are tried a visit: at L = 10r, B = 0.5 and 500
//! elements
//! 12.3 ± 0.3 contacts an element and R_g = 17.98 ± 0.04 r, against 14.2 ± 0.3 and 18.28 ± 0.03 r with small steps. A
//! `margin` of 2 gives 14.5 ± 0.3 and 18.27 ± 0.04 r. Where every contact sticks the two agree.
//!
//! It does not guarantee: sheets on triangles much larger than an element. The nearby set belongs to a whole triangle,
//! so both faces of a thin plate made of a dozen triangles are near each other. Compare sheets on fine meshes only.
#![allow(
    dead_code,
    reason = "each test crate that includes this module uses another part of it"
)]

pub(crate) mod cluster;
pub(crate) mod grow;
pub(crate) mod join;
pub(crate) mod launch;
pub(crate) mod mesh;
pub(crate) mod nearby;
pub(crate) mod shapes;
pub(crate) mod stats;
pub(crate) mod walk;

pub(crate) use grow::{Stop, grow};

/// Everything that decides a reference run but the mesh. Lengths are in the mesh's units.
#[derive(Clone, Debug)]
pub(crate) struct Params {
    /// Radius r of an element.
    pub(crate) radius: f64,
    /// Radius L of the disc in which the local density is counted.
    pub(crate) curvature_radius: f64,
    /// Sticking probability B at a flat front.
    pub(crate) bias: f64,
    /// Gain A on the curvature.
    pub(crate) gain: f64,
    /// Lowest sticking probability.
    pub(crate) min_stick: f64,
    /// Launch radius over max(R_e, 4r).
    pub(crate) launch: f64,
    /// Kill radius over max(R_e, 4r).
    pub(crate) kill: f64,
    /// Rotate to a second contact; otherwise stay at the first.
    pub(crate) pack: bool,
    /// Steps as long as the free space allows; otherwise never longer than r.
    pub(crate) large_steps: bool,
    /// How far, in units of r, a step ends short of the nearest centre at least: s₁ = |x − c| − R_e − margin·r and
    /// s₂ = D − margin·r. 1 is the thesis's (a step may end r inside contact), 2 ends at the touch, as small steps do
    /// but for their last one.
    pub(crate) margin: f64,
    /// Seed of the one random stream.
    pub(crate) seed: u64,
    /// The seed element is the surface point nearest to this place.
    pub(crate) at: [f64; 3],
    /// How neighbours are looked up; changes the cost, never the result.
    pub(crate) search: Search,
}

impl Params {
    /// Sumner's defaults for elements of radius `radius`: L = 10r, B = 0.5, A = 1, pack, large steps.
    pub(crate) fn new(radius: f64, seed: u64) -> Self {
        Self {
            radius,
            curvature_radius: 10.0 * radius,
            bias: 0.5,
            gain: 1.0,
            min_stick: 0.01,
            launch: 1.5,
            kill: 10.0,
            pack: true,
            large_steps: true,
            margin: 1.0,
            seed,
            at: [0.0; 3],
            search: Search::Lists,
        }
    }

    /// Plain off-lattice DLA: every contact sticks where it happens.
    pub(crate) fn plain_dla(radius: f64, seed: u64) -> Self {
        Self {
            bias: 1.0,
            gain: 0.0,
            pack: false,
            ..Self::new(radius, seed)
        }
    }
}

/// How the elements near a place are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Search {
    /// Sumner's: the element lists of the nearby triangles; nearest element by brute force.
    Lists,
    /// Boxes of elements, filtered by the same nearby sets.
    Cells,
}

/// One element, in birth order.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Element {
    /// Centre in space.
    pub(crate) position: [f64; 3],
    /// Triangle that carries the centre.
    pub(crate) triangle: usize,
    /// Element that the walker stuck to; none for the seed.
    pub(crate) parent: Option<usize>,
    /// Sticking probability when it stuck; 1 for the seed.
    pub(crate) probability: f64,
}

/// What the walkers did.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Counters {
    /// Walkers launched.
    pub(crate) walkers: u64,
    /// Walkers dropped beyond the kill radius.
    pub(crate) killed: u64,
    /// Steps taken, the one into contact included.
    pub(crate) steps: u64,
    /// Steps that ended in contact.
    pub(crate) contacts: u64,
    /// Contacts that did not stick.
    pub(crate) refusals: u64,
    /// Joined elements that kept their first contact although packing was asked for.
    pub(crate) unpacked: u64,
}

/// A finished run.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Run {
    /// The cluster, in birth order.
    pub(crate) elements: Vec<Element>,
    /// What it took.
    pub(crate) counters: Counters,
}

impl Run {
    /// The centres, in birth order.
    pub(crate) fn positions(&self) -> Vec<[f64; 3]> {
        self.elements.iter().map(|e| e.position).collect()
    }
}
