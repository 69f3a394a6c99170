//! The growth loop (Sumner 6): launch, step, kill, contact, stick, join.

use super::cluster::{Cluster, Within};
use super::join::{first_touch, pack};
use super::launch::{Arc, cut, on_arcs, on_free_area};
use super::mesh::{Mesh, Place};
use super::walk::{Piece, end, trace};
use super::{Counters, Element, Params, Run};
use glam::{DVec2, DVec3};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use std::f64::consts::{PI, TAU};

/// A run that needs more steps than this is stuck.
const MOST_STEPS: u64 = 20_000_000_000;

/// When a run ends: at this many elements or this effective radius, whichever comes first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stop {
    pub(crate) elements: usize,
    pub(crate) reach: f64,
}

impl Stop {
    pub(crate) fn at_elements(elements: usize) -> Self {
        Self {
            elements,
            reach: f64::INFINITY,
        }
    }

    pub(crate) fn at_reach(reach: f64) -> Self {
        Self {
            elements: usize::MAX,
            reach,
        }
    }
}

/// Grows one cluster; it may end early when the surface is full.
pub(crate) fn grow(
    vertices: &[[f64; 3]],
    triangles: &[[u32; 3]],
    params: &Params,
    stop: Stop,
) -> Run {
    let mesh = Mesh::new(vertices, triangles);
    let mut growth = Growth::new(&mesh, params);
    while growth.elements.len() < stop.elements && growth.cluster.reach < stop.reach {
        let Some(launch) = growth.launch() else { break };
        if let Some(contact) = growth.walk(launch) {
            growth.join(&contact);
        }
    }
    Run {
        elements: growth.elements,
        counters: growth.counters,
    }
}

/// A step that ended in contact and stuck with this probability.
struct Contact {
    pieces: Vec<Piece>,
    probability: f64,
}

/// Where a walker starts and beyond which distance from the centroid it is dropped.
struct Launch {
    start: Place,
    kill: f64,
}

struct Growth<'a> {
    params: &'a Params,
    component: Vec<usize>,
    cluster: Cluster<'a>,
    elements: Vec<Element>,
    counters: Counters,
    rng: ChaCha8Rng,
    /// The launch sphere's arcs for the present cluster.
    arcs: Vec<Arc>,
}

impl<'a> Growth<'a> {
    fn new(mesh: &'a Mesh, params: &'a Params) -> Self {
        let seed = mesh.nearest(DVec3::from_array(params.at));
        let mut growth = Self {
            params,
            component: mesh.component(seed.triangle),
            cluster: Cluster::new(mesh, params),
            elements: Vec::new(),
            counters: Counters::default(),
            rng: ChaCha8Rng::seed_from_u64(params.seed),
            arcs: Vec::new(),
        };
        growth.push(seed, None, 1.0);
        growth
    }

    fn push(&mut self, place: Place, parent: Option<usize>, probability: f64) {
        self.cluster.push(place);
        self.elements.push(Element {
            position: self.cluster.mesh.lift(place).to_array(),
            triangle: place.triangle,
            parent,
            probability,
        });
        let r = self.params.radius;
        let reach = self.cluster.reach;
        let sphere = (self.params.launch * reach.max(4.0 * r)).max(reach + 4.0 * r);
        self.arcs = cut(
            self.cluster.mesh,
            &self.component,
            self.cluster.centroid,
            sphere,
        );
    }

    /// Launch: uniform on the arcs, or uniform on the free surface when the sphere encloses the component; none when
    /// the surface is full.
    fn launch(&mut self) -> Option<Launch> {
        self.counters.walkers += 1;
        if self.arcs.is_empty() {
            let start = on_free_area(&self.cluster, &self.component, &mut self.rng)?;
            let kill = f64::INFINITY;
            return Some(Launch { start, kill });
        }
        let start = on_arcs(&self.arcs, &mut self.rng);
        let kill = self.params.kill * self.cluster.reach.max(4.0 * self.params.radius);
        Some(Launch { start, kill })
    }

    /// Walks until the walker sticks (its last step) or is killed (none).
    fn walk(&mut self, launch: Launch) -> Option<Contact> {
        let mesh = self.cluster.mesh;
        let mut place = launch.start;
        loop {
            let pieces = self.step(place);
            let next = end(&pieces);
            let p = mesh.lift(next);
            if !self
                .cluster
                .overlapped(next, 2.0 * self.params.radius)
                .is_empty()
            {
                self.counters.contacts += 1;
                let probability = self.sticking(next, p);
                if self.rng.random::<f64>() < probability {
                    return Some(Contact {
                        pieces,
                        probability,
                    });
                }
                self.counters.refusals += 1;
                continue;
            }
            if p.distance(self.cluster.centroid) > launch.kill {
                self.counters.killed += 1;
                return None;
            }
            place = next;
        }
    }

    /// One step (6.8): d = s + r·√u − r in a uniform direction.
    fn step(&mut self, place: Place) -> Vec<Piece> {
        self.counters.steps += 1;
        assert!(self.counters.steps < MOST_STEPS, "the walk does not end");
        let r = self.params.radius;
        let s = self.step_size(self.cluster.mesh.lift(place));
        let length = s + r * self.rng.random::<f64>().sqrt() - r;
        let direction = DVec2::from_angle(self.rng.random::<f64>() * TAU);
        trace(self.cluster.mesh, place, direction, length)
    }

    /// s = max(s₁, s₂, r): s₁ from the effective radius, s₂ from the nearest element, both less the margin.
    fn step_size(&self, p: DVec3) -> f64 {
        let r = self.params.radius;
        if !self.params.large_steps {
            return r;
        }
        let margin = self.params.margin * r;
        let s1 = p.distance(self.cluster.centroid) - self.cluster.reach - margin;
        let s2 = self.cluster.nearest_distance(p) - margin;
        s1.max(s2).max(r)
    }

    /// P = clamp(Aκ + B, P_min, 1) with κ from the elements within L.
    fn sticking(&self, place: Place, p: DVec3) -> f64 {
        let Params {
            radius: r,
            curvature_radius: l,
            ..
        } = *self.params;
        let n = self
            .cluster
            .near(place.triangle, p, l, Within::Density)
            .len() as f64;
        let dense = PI * l * l / (4.0 * 3.0_f64.sqrt() * r * r);
        let curvature = (n - dense) / dense;
        (self.params.gain * curvature + self.params.bias).clamp(self.params.min_stick, 1.0)
    }

    fn join(&mut self, contact: &Contact) {
        let (touch, pivot) = first_touch(&self.cluster, &contact.pieces);
        let rest = if self.params.pack {
            let packed = pack(&self.cluster, touch, pivot);
            self.counters.unpacked += u64::from(packed.is_none());
            packed.unwrap_or(touch)
        } else {
            touch
        };
        self.push(rest, Some(pivot), contact.probability);
    }
}
