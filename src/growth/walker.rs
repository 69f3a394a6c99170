//! One walker after the other, from launch to joining (Sumner 2001, chapter 6).

use std::ops::Range;

use glam::DVec3;

use super::launch::{AreaSampler, LaunchRing};
use super::step::random_step;
use super::{Boundary, Counts, GrowthModel, Halt, Parameters, Steps, Stickiness, Surroundings};
use crate::cluster::{Cluster, Element, ElementIndex, Look, SparseIndex};
use crate::rng::{Purpose, Stream};
use crate::substrate::{Substrate, SurfacePoint};
use crate::walk::{Connectivity, End, Stand};

/// Diffusion-limited aggregation with curvature-based sticking.
pub struct WalkerModel<'a, I: ElementIndex = SparseIndex> {
    substrate: &'a Substrate,
    parameters: Parameters,
    law: Stickiness,
    index: I,
    launcher: Launcher,
    scratch: Connectivity,
    notes: I::Notes,
    counts: Counts,
}

/// R_e counts as at least this many radii: that of a single seed is 0.
const LEAST_EXTENT: f64 = 4.0;

/// The launch sphere is at least this many radii outside R_e.
const LEAST_GAP: f64 = 4.0;

/// Places tried in a row before the surface counts as full.
const MOST_TRIES: u32 = 20_000;

/// A bound from the launcher's sphere serves when it is this share of the sphere's radius.
const FAR_OUTSIDE: f64 = 0.2;

/// Steps between two looks at whether to stop.
const STEPS_PER_LOOK: u64 = 4096;

impl<'a, I: ElementIndex> WalkerModel<'a, I> {
    /// A model of its own index, for a cluster that is still empty.
    pub fn new(substrate: &'a Substrate, parameters: Parameters) -> Self {
        let wide = parameters.curvature_radius;
        Self {
            law: Stickiness::new(&parameters),
            index: I::new(parameters.radius, wide, substrate.bounds()),
            launcher: Launcher::default(),
            scratch: Connectivity::new(),
            notes: I::Notes::default(),
            counts: Counts::default(),
            substrate,
            parameters,
        }
    }
}

impl<I: ElementIndex> GrowthModel for WalkerModel<'_, I> {
    fn born(&mut self, cluster: &Cluster) {
        if let Some(last) = cluster.elements().last() {
            self.index.adopt(&mut self.notes);
            self.index.insert(last.position);
            self.launcher
                .update(self.substrate, &self.parameters, cluster);
        }
    }

    fn next(&mut self, cluster: &Cluster, cancelled: &dyn Fn() -> bool) -> Result<Element, Halt> {
        let mut walk = Walk {
            around: Surroundings {
                substrate: self.substrate,
                parameters: &self.parameters,
                cluster,
                index: &self.index,
            },
            law: &self.law,
            launcher: &self.launcher,
            scratch: &mut self.scratch,
            notes: &mut self.notes,
            counts: &mut self.counts,
            cancelled,
        };
        walk.until_one_sticks()
    }

    fn counts(&self) -> &Counts {
        &self.counts
    }

    fn resume(&mut self, counts: Counts) {
        self.counts = counts;
    }
}

/// Where walkers start at present, and how far they may go.
#[derive(Default)]
struct Launcher {
    components: Vec<Range<u32>>,
    centre: DVec3,
    radius: f64,
    /// All elements are within this distance of the centre.
    reach: f64,
    /// Walkers farther from the centre are dropped.
    kill: f64,
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
        let reach = extent.effective_radius() + self.centre.distance(extent.centroid());
        if is_new || drift > gap / 16.0 || reach > self.reach {
            self.set_out(parameters, cluster);
            self.ring = LaunchRing::new(substrate, &self.components, self.centre, radius);
            if self.ring.length() == 0.0 && self.area.is_none() {
                let triangles = self.components.iter().flat_map(Clone::clone);
                self.area = Some(AreaSampler::new(substrate, triangles));
            }
        }
    }

    /// Takes the spheres from the cluster as it is now.
    fn set_out(&mut self, parameters: &Parameters, cluster: &Cluster) {
        let extent = cluster.extent();
        let effective = extent.effective_radius();
        self.centre = extent.centroid();
        self.radius = launch_radius(parameters, effective);
        self.reach = effective + (self.radius - effective) / 8.0;
        let kill = parameters.kill * floored_extent(parameters, effective);
        self.kill = kill.max(self.radius + LEAST_GAP * parameters.radius);
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
struct Walk<'b, I: ElementIndex> {
    around: Surroundings<'b, I>,
    law: &'b Stickiness,
    launcher: &'b Launcher,
    scratch: &'b mut Connectivity,
    notes: &'b mut I::Notes,
    counts: &'b mut Counts,
    cancelled: &'b dyn Fn() -> bool,
}

/// What comes of a walker near enough to an element.
enum Meeting {
    /// The element is on another sheet.
    Elsewhere,
    Refused,
    Sticks(f64),
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
            !self.around.in_contact(self.scratch, (at.triangle, p))
        })
    }

    fn walk(&mut self, start: SurfacePoint, stream: &mut Stream) -> Fate {
        let (substrate, parameters) = (self.around.substrate, self.around.parameters);
        let absorb = parameters.boundary == Boundary::Absorb;
        let mut here = Stand::new(substrate, &start);
        let Some(look) = self.look(here.position) else {
            return self.kill();
        };
        let mut bound = self.step_bound(&look);
        loop {
            // 2. Step: uniform in the disc, d = s + r·√u − r (Sumner 6.8).
            let step = random_step(stream, bound, parameters.radius);
            let moved = here.step(substrate, step, absorb);
            self.counts.steps += 1;
            self.counts.crossings += u64::from(moved.crossings);
            if self.counts.steps.is_multiple_of(STEPS_PER_LOOK) && (self.cancelled)() {
                return Fate::Halted(Halt::Cancelled);
            }
            if moved.end == End::Boundary {
                self.counts.absorbed += 1;
                return Fate::Lost;
            }
            let Some(look) = self.look(moved.to.position) else {
                return self.kill();
            };
            // 4. Contact: stick, or go back to the last position and walk on.
            if look.touching {
                match self.meet(&moved.to, stream) {
                    Meeting::Elsewhere => {}
                    Meeting::Refused => continue,
                    Meeting::Sticks(probability) => return self.join(&here, step, probability),
                }
            }
            here = moved.to;
            bound = self.step_bound(&look);
        }
    }

    /// How far it is to the lichen at least; none beyond the kill radius.
    fn look(&mut self, p: DVec3) -> Option<Look> {
        let from_centre = p.distance(self.launcher.centre);
        if from_centre > self.launcher.kill && !self.launcher.encloses() {
            return None;
        }
        let clear = from_centre - self.launcher.reach;
        let contact = self.around.contact_distance();
        if clear > (FAR_OUTSIDE * self.launcher.reach).max(contact) {
            return Some(Look {
                clear,
                touching: false,
            });
        }
        Some(self.around.index.look(p, self.notes))
    }

    /// What becomes of a walker that an element is near enough to touch.
    fn meet(&mut self, there: &Stand, stream: &mut Stream) -> Meeting {
        let place = (there.triangle, there.position);
        if !self.around.in_contact(self.scratch, place) {
            return Meeting::Elsewhere;
        }
        self.counts.contacts += 1;
        let chance = stream.uniform();
        match self.around.sticks(self.scratch, self.law, place, chance) {
            Some(probability) => Meeting::Sticks(probability),
            None => {
                self.counts.refusals += 1;
                Meeting::Refused
            }
        }
    }

    /// The bound s = max(D − 2r, r) on the next step, from any lower bound D on the distance to the
    /// nearest element.
    ///
    /// Departure: Sumner 6.3 goes as far as D − r, so that a long step may end r inside contact.
    /// A walker refused there is thrown back far, which makes another law of every bound: on the
    /// plane at B = 0.5 it takes a third off the contacts and adds half to the elements within a
    /// given reach. Here a long step ends where it may just touch, contacts come from steps in the
    /// disc of radius r alone, and long steps change nothing but the time it takes.
    fn step_bound(&self, look: &Look) -> f64 {
        let Parameters { radius, steps, .. } = *self.around.parameters;
        match steps {
            Steps::Small => radius,
            Steps::Large => (look.clear - self.around.contact_distance()).max(radius),
        }
    }

    /// 3. Kill: dropped, and the next one is launched.
    fn kill(&mut self) -> Fate {
        self.counts.killed += 1;
        Fate::Lost
    }

    /// 5. Join.
    fn join(&mut self, from: &Stand, step: glam::DVec2, probability: f64) -> Fate {
        let from = from.surface_point(self.around.substrate);
        let joined = self.around.join(self.scratch, &from, step);
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
