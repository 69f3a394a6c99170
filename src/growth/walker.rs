//! One walker after the other, from launch to joining (Sumner 2001, chapter 6).

use std::ops::Range;

use glam::DVec3;

use super::launch::{AreaSampler, LaunchRing};
use super::step::random_step;
use super::{Boundary, Counts, GrowthModel, Halt, Parameters, Steps, Stickiness, Surroundings};
use crate::cluster::{Cluster, Element, ElementIndex, GridIndex};
use crate::rng::{Purpose, Stream};
use crate::substrate::{Substrate, SurfacePoint};
use crate::walk::{Connectivity, End, trace};

/// Diffusion-limited aggregation with curvature-based sticking.
pub struct WalkerModel<'a, I = GridIndex> {
    substrate: &'a Substrate,
    parameters: Parameters,
    law: Stickiness,
    index: I,
    launcher: Launcher,
    scratch: Connectivity,
    counts: Counts,
}

/// R_e counts as at least this many radii: that of a single seed is 0.
const LEAST_EXTENT: f64 = 4.0;

/// The launch sphere is at least this many radii outside R_e.
const LEAST_GAP: f64 = 4.0;

/// Places tried in a row before the surface counts as full.
const MOST_TRIES: u32 = 20_000;

/// More than round-off can add to a sum of distances.
const SLACK: f64 = 1.0 + 1e-9;

/// Steps between two looks at whether to stop.
const STEPS_PER_LOOK: u64 = 4096;

impl<'a, I: ElementIndex> WalkerModel<'a, I> {
    /// A model of its own index, for a cluster that is still empty.
    pub fn new(substrate: &'a Substrate, parameters: Parameters) -> Self {
        let [low, high] = substrate.units().bounding_box();
        let diagonal = substrate.units().length_to_local(low.distance(high));
        Self {
            law: Stickiness::new(&parameters),
            index: I::new(parameters.radius, parameters.curvature_radius, diagonal),
            launcher: Launcher::default(),
            scratch: Connectivity::new(),
            counts: Counts::default(),
            substrate,
            parameters,
        }
    }

    fn around<'b>(&'b self, cluster: &'b Cluster) -> Surroundings<'b, I> {
        Surroundings {
            substrate: self.substrate,
            parameters: &self.parameters,
            cluster,
            index: &self.index,
        }
    }
}

impl<I: ElementIndex> GrowthModel for WalkerModel<'_, I> {
    fn born(&mut self, cluster: &Cluster) {
        if let Some(last) = cluster.elements().last() {
            self.index.insert(last.position);
            self.launcher
                .update(self.substrate, &self.parameters, cluster);
        }
    }

    fn next(&mut self, cluster: &Cluster, cancelled: &dyn Fn() -> bool) -> Result<Element, Halt> {
        let mut scratch = std::mem::take(&mut self.scratch);
        let mut counts = std::mem::take(&mut self.counts);
        let mut walk = Walk {
            around: self.around(cluster),
            law: &self.law,
            launcher: &self.launcher,
            scratch: &mut scratch,
            counts: &mut counts,
            cancelled,
        };
        let result = walk.until_one_sticks();
        (self.scratch, self.counts) = (scratch, counts);
        result
    }

    fn counts(&self) -> &Counts {
        &self.counts
    }
}

/// Where walkers start at present, and how far they may go.
#[derive(Default)]
struct Launcher {
    components: Vec<Range<u32>>,
    centre: DVec3,
    radius: f64,
    ring: LaunchRing,
    area: Option<AreaSampler>,
}

impl Launcher {
    /// Takes in the youngest element.
    fn update(&mut self, substrate: &Substrate, parameters: &Parameters, cluster: &Cluster) {
        let Some(last) = cluster.elements().last() else {
            return;
        };
        let component = &substrate.component_of(last.at.triangle).triangles;
        let is_new = !self.components.contains(component);
        if is_new {
            self.components.push(component.clone());
            self.area = None;
        }
        let extent = cluster.extent();
        let radius = launch_radius(parameters, extent.effective_radius());
        let drift = self.centre.distance(extent.centroid()) + (radius - self.radius).abs();
        let gap = self.radius - extent.effective_radius();
        if is_new || drift > gap / 16.0 {
            (self.centre, self.radius) = (extent.centroid(), radius);
            self.ring = LaunchRing::new(substrate, &self.components, self.centre, radius);
            if self.ring.length() == 0.0 && self.area.is_none() {
                let triangles = self.components.iter().flat_map(Clone::clone);
                self.area = Some(AreaSampler::new(substrate, triangles));
            }
        }
    }

    /// Whether the launch sphere encloses all that carries lichen.
    fn encloses(&self) -> bool {
        self.ring.length() == 0.0
    }
}

fn floored_extent(parameters: &Parameters, effective_radius: f64) -> f64 {
    effective_radius.max(LEAST_EXTENT * parameters.radius)
}

fn launch_radius(parameters: &Parameters, effective_radius: f64) -> f64 {
    let scaled = parameters.launch * floored_extent(parameters, effective_radius);
    scaled.max(effective_radius + LEAST_GAP * parameters.radius)
}

/// A walker on its way, and what it needs for that.
struct Walk<'b, I> {
    around: Surroundings<'b, I>,
    law: &'b Stickiness,
    launcher: &'b Launcher,
    scratch: &'b mut Connectivity,
    counts: &'b mut Counts,
    cancelled: &'b dyn Fn() -> bool,
}

/// What becomes of one walker.
enum Fate {
    Joined(Element),
    Lost,
    Halted(Halt),
}

impl<I: ElementIndex> Walk<'_, I> {
    fn until_one_sticks(&mut self) -> Result<Element, Halt> {
        loop {
            let number = self.counts.walkers;
            self.counts.walkers += 1;
            let mut stream = Stream::new(self.around.parameters.seed, Purpose::Walker, number);
            let Some(start) = self.launch(&mut stream) else {
                return Err(Halt::NoFreeSurface);
            };
            match self.walk(start, &mut stream) {
                Fate::Joined(element) => return Ok(element),
                Fate::Halted(halt) => return Err(halt),
                Fate::Lost if (self.cancelled)() => return Err(Halt::Cancelled),
                Fate::Lost => {}
            }
        }
    }

    /// 1. Launch: on the arcs, or anywhere free where the sphere encloses the component.
    fn launch(&mut self, stream: &mut Stream) -> Option<SurfacePoint> {
        let Some(area) = self
            .launcher
            .area
            .as_ref()
            .filter(|_| self.launcher.encloses())
        else {
            return self.launcher.ring.sample(self.around.substrate, stream);
        };
        (0..MOST_TRIES).map(|_| area.sample(stream)).find(|at| {
            let p = self.around.substrate.position(at);
            !self.around.in_contact(self.scratch, at, p)
        })
    }

    fn walk(&mut self, mut at: SurfacePoint, stream: &mut Stream) -> Fate {
        let parameters = self.around.parameters;
        let absorb = parameters.boundary == Boundary::Absorb;
        let mut position = self.around.substrate.position(&at);
        let extent = self.around.cluster.extent();
        let farthest = position.distance(extent.centroid()) + extent.effective_radius();
        let mut nearest = self
            .around
            .index
            .nearest_distance(position, SLACK * farthest);
        let Some(mut bound) = self.step_bound(position, nearest) else {
            return self.kill();
        };
        loop {
            // 2. Step: uniform in the disc, d = s + r·√u − r (Sumner 6.8).
            let step = random_step(stream, bound, parameters.radius);
            let traced = trace(self.around.substrate, &at, step, absorb);
            self.counts.steps += 1;
            self.counts.crossings += u64::from(traced.crossings);
            if self.counts.steps.is_multiple_of(STEPS_PER_LOOK) && (self.cancelled)() {
                return Fate::Halted(Halt::Cancelled);
            }
            if traced.end == End::Boundary {
                self.counts.absorbed += 1;
                return Fate::Lost;
            }
            // 4. Contact: stick, or go back to the last position and walk on.
            let there = self.around.substrate.position(&traced.point);
            let at_most = SLACK * (nearest + step.length());
            let next = self.around.index.nearest_distance(there, at_most);
            let near = next < self.around.contact_distance();
            if near && self.around.in_contact(self.scratch, &traced.point, there) {
                self.counts.contacts += 1;
                let chance = stream.uniform();
                let place = (&traced.point, there);
                if let Some(p) = self.around.sticks(self.scratch, self.law, place, chance) {
                    return self.join(&at, step, p);
                }
                self.counts.refusals += 1;
                continue;
            }
            (at, position, nearest) = (traced.point, there, next);
            match self.step_bound(position, nearest) {
                Some(next) => bound = next,
                None => return self.kill(),
            }
        }
    }

    /// The bound s = max(D − 2r, r) on the next step, or none beyond the kill radius; D is the
    /// distance to the nearest element. The cluster lies inside R_e, so this s₂ includes s₁.
    ///
    /// Departure: Sumner 6.3 goes as far as D − r, so that a long step may end r inside contact.
    /// A walker refused there is thrown back far, which makes another law of every bound: on the
    /// plane at B = 0.5 it takes a third off the contacts and adds half to the elements within a
    /// given reach. Here a long step ends where it may just touch, contacts come from steps in the
    /// disc of radius r alone, and long steps change nothing but the time it takes.
    fn step_bound(&self, p: DVec3, nearest: f64) -> Option<f64> {
        let Parameters {
            radius,
            kill,
            steps,
            ..
        } = *self.around.parameters;
        let extent = self.around.cluster.extent();
        let from_centroid = p.distance(extent.centroid());
        let floored = floored_extent(self.around.parameters, extent.effective_radius());
        let limit = (kill * floored).max(self.launcher.radius + LEAST_GAP * radius);
        if from_centroid > limit && !self.launcher.encloses() {
            return None;
        }
        if steps == Steps::Small {
            return Some(radius);
        }
        Some((nearest - self.around.contact_distance()).max(radius))
    }

    /// 3. Kill: dropped, and the next one is launched.
    fn kill(&mut self) -> Fate {
        self.counts.killed += 1;
        Fate::Lost
    }

    /// 5. Join.
    fn join(&mut self, at: &SurfacePoint, step: glam::DVec2, probability: f64) -> Fate {
        let joined = self.around.join(self.scratch, at, step);
        self.counts.packed += u64::from(joined.packed);
        let colony = self.around.cluster.elements()[joined.touched as usize].colony;
        Fate::Joined(Element {
            at: joined.at,
            position: self.around.substrate.position(&joined.at),
            parent: joined.touched,
            colony,
            probability,
        })
    }
}
