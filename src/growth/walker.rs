//! One walker, from launch to joining (Sumner 2001, chapter 6).

use glam::DVec3;

use super::far::{Far, Level, outset};
use super::flight::{Asked, Track, Underfoot, Way};
use super::launch::{AreaSampler, LaunchRing};
use super::launcher::Launcher;
use super::near::Met;
use super::patience::Patience;
use super::step::{RandomStep, StepBounds};
use super::stick::{Answer, Crowd};
use super::surroundings::Ground;
use super::{Habitat, Halt, Parameters, Stickiness, Surroundings};
use crate::cluster::{Element, ElementIndex, Look};
use crate::rng::{Purpose, Stream};
use crate::substrate::{Substrate, SurfacePoint};
use crate::walk::{Ball, Connectivity, Footing, Stand};

/// Places tried in a row before the surface counts as full.
pub(super) const MOST_TRIES: usize = 20_000;

/// Places that are read ahead together, after as many have been tried one by one.
const TOGETHER: usize = 8;

/// Steps between two looks at whether to stop; also those between two places to which a walker can
/// be taken back.
pub(super) const STEPS_PER_LOOK: u64 = 16;

/// Cost of a search for what is on a walker's sheet, in steps, besides what its triangles cost.
const LOOKING: f64 = 8.0;

/// Triangles looked at in the time of a step.
const LOOKED_AT: f64 = 2.0;

/// Radii of the largest ball that is searched for that, but for a factor of two.
const MOST_BALL: f64 = 32.0;

/// Triangles in a ball that are enough.
const MOST_REACHED: usize = 2000;

/// Radii about a contact within which elements decide where it is joined: it is moved by at most 5,
/// and what it may touch then is within 2 of there, or within 4 of what it turned about.
const JOINING: f64 = 8.0;

/// Times that a walker is refused for want of a place that overlaps nothing before it may overlap what it touches: on a
/// face as small as an element there may be no other.
const MOST_UNJOINED: u32 = 100;

/// A walker on its way, and what it needs for that.
pub(super) struct Walk<'b, I: ElementIndex> {
    pub(super) around: Surroundings<'b, I>,
    pub(super) law: &'b Stickiness,
    pub(super) launcher: &'b Launcher,
    pub(super) far: Option<&'b Far>,
    pub(super) habitat: Habitat<'b>,
    pub(super) scratch: &'b mut Connectivity,
    /// The same for a copy of the surface.
    pub(super) on_copy: &'b mut Connectivity,
    pub(super) crowd: Crowd,
    pub(super) bounds: StepBounds,
    pub(super) track: &'b mut Track<I>,
    /// Whether others may be born before this walker's element is: see [`Track`].
    pub(super) others_walk: bool,
    pub(super) interrupts: Interrupts<'b>,
}

/// Reasons to stop in the middle of a walk.
#[derive(Clone, Copy)]
pub(super) struct Interrupts<'b> {
    /// For good.
    pub(super) cancelled: &'b (dyn Fn() -> bool + Sync),
    /// For now: to go on later.
    pub(super) paused: &'b (dyn Fn() -> bool + Sync),
}

/// What comes of a walker near enough to an element.
pub(super) enum Meeting {
    /// The element is on another sheet.
    Elsewhere,
    Refused,
    Sticks(f64),
}

/// What becomes of one walker.
#[derive(Clone, Copy)]
pub(super) enum Fate {
    Joined(Element),
    Lost,
    Halted(Halt),
}

/// Why a walker goes no further.
pub(super) enum Stop {
    End(Fate),
    /// It goes on later.
    Pause,
}

/// A place that is in contact with nothing, uniform by area; none where so many are not that the surface
/// counts as full.
///
/// When little is free, nearly all the time is waiting for what is known of one place after another. So
/// after a few it is read for several together; the places are the same, and so is the stream at the end.
fn free_place<I: ElementIndex>(
    around: &Surroundings<'_, I>,
    scratch: &mut Connectivity,
    area: &AreaSampler,
    is_free_anyway: impl Fn(u32) -> bool,
    stream: &mut Stream,
) -> Option<SurfacePoint> {
    let position = |at: &SurfacePoint| around.substrate.position(at);
    let mut is_free = |at: &SurfacePoint| {
        is_free_anyway(at.triangle) || !around.in_contact(scratch, (at.triangle, position(at)))
    };
    let mut first = (0..TOGETHER).map(|_| area.sample(stream));
    if let Some(found) = first.find(&mut is_free) {
        return Some(found);
    }
    (1..MOST_TRIES / TOGETHER).find_map(|_| {
        let some: [_; TOGETHER] = std::array::from_fn(|_| (area.sample(stream), stream.clone()));
        for (at, _) in &some {
            around.index.read_ahead(&around.elements, position(at));
        }
        let (found, then) = some.into_iter().find(|(at, _)| is_free(at))?;
        *stream = then;
        Some(found)
    })
}

impl<'b, I: ElementIndex> Walk<'b, I> {
    /// The walker with this number, launched.
    pub(super) fn set_out(&mut self, number: u64) -> Result<Way, Fate> {
        let known = self.around.elements.len();
        self.track.begin(self.around.index, known, self.others_walk);
        let mut stream = Stream::new(self.around.parameters.seed, Purpose::Walker, number);
        let Some((level, here)) = self.launch_on_habitat(&mut stream) else {
            return Err(Fate::Halted(Halt::NoFreeSurface));
        };
        let Some(look) = self.look(here.position) else {
            return Err(self.kill());
        };
        let bound = self.bounds.of(&look);
        let random = RandomStep::draw(&mut stream);
        let surface = self.surface(level);
        let mut way = Way {
            here,
            level,
            underfoot: Underfoot::new((level, here.triangle), surface),
            bound,
            random,
            patience: Patience::default(),
            thrown_back: false,
            kept: 0,
            unjoined: 0,
            stream,
        };
        if let Some(far) = self.far {
            self.lift(far, &mut way);
        }
        Ok(way)
    }

    /// What it walks on.
    #[inline(always)]
    pub(super) fn surface(&self, level: Level) -> &'b Substrate {
        match self.far {
            Some(far) => far.surface(level, self.around.substrate),
            None => self.around.substrate,
        }
    }

    /// 1. Launch: on the arcs, or anywhere free where the sphere encloses the component.
    pub(super) fn launch(&mut self, stream: &mut Stream) -> Option<(Level, Stand)> {
        let (substrate, launcher) = (self.around.substrate, self.launcher);
        let Some(area) = launcher.by_area() else {
            return self.launch_on(launcher.rings().next()?, stream);
        };
        let is_cut = |triangle| launcher.ring_of(triangle).is_some();
        let Some(start) = free_place(&self.around, self.scratch, area, is_cut, stream) else {
            return self.launch_on(launcher.rings().next()?, stream);
        };
        if let Some(ring) = launcher.ring_of(start.triangle) {
            return self.launch_on(ring, stream);
        }
        let here = Stand::new(substrate, &start);
        self.asked(here.position, self.around.contact_distance(), 0);
        Some((0, here))
    }

    fn launch_on(&self, ring: &LaunchRing, stream: &mut Stream) -> Option<(Level, Stand)> {
        let (level, surface) = outset(self.far, self.around.substrate);
        let start = ring.sample(surface, stream)?;
        Some((level, Stand::new(surface, &start)))
    }

    /// Notes that the elements within a ball decided something, and how many more would have made
    /// no difference.
    pub(super) fn asked(&mut self, centre: DVec3, radius: f64, spare: usize) {
        if self.others_walk {
            let asked = Asked {
                centre,
                radius,
                spare,
            };
            self.track.asked.push(asked);
        }
    }

    /// Goes to a place.
    pub(super) fn go(&mut self, now: &mut Way, there: Stand) {
        match self.far {
            Some(far) if now.bound > far.stays_to(now.level) => self.arrive(far, now, there),
            _ => now.here = there,
        }
    }

    /// Goes to a place, which may be on a copy of the surface, and to the copy that the bound is for.
    #[inline(never)]
    fn arrive(&mut self, far: &Far, now: &mut Way, there: Stand) {
        let from = std::mem::replace(&mut now.here, there);
        now.bound -= far.deviation(now.level, there.triangle);
        if now.bound > far.most(now.level) {
            self.lift(far, now);
        } else if now.bound < far.least(now.level) && !self.land(far, now) {
            now.here = from;
            now.bound = far.least(now.level);
        }
    }

    /// To the coarsest copy of the surface that the bound is for.
    #[inline(never)]
    fn lift(&mut self, far: &Far, now: &mut Way) {
        while now.bound > far.most(now.level) {
            let Some(Footing { stand, facet }) = far.lifted(now.level, &now.here) else {
                return;
            };
            let aside = stand.position.distance(now.here.position);
            let gained = far.deviation(now.level, now.here.triangle);
            let lost = aside + far.deviation(now.level + 1, stand.triangle);
            let bound = now.bound + gained - lost;
            // Where a copy strays far from the surface it would have to land at once.
            if bound < far.least(now.level + 1) {
                return;
            }
            (now.here, now.bound, now.level) = (stand, bound, now.level + 1);
            now.underfoot = Underfoot::of(now.level, facet);
        }
    }

    /// From a copy back to a finer surface, unless that leads into an element: the copy is nowhere so
    /// far from the surface, but places that stand for each other may be.
    #[inline(never)]
    fn land(&mut self, far: &Far, now: &mut Way) -> bool {
        let (mut level, mut bound) = (now.level, now.bound);
        let surface = self.surface(level);
        now.underfoot.be((level, now.here.triangle), surface);
        let mut here = Footing {
            stand: now.here,
            facet: now.underfoot.facet,
        };
        while bound < far.least(level) {
            let finer = far.landed(level, self.around.substrate, &here);
            let Some(landed) = finer else { return false };
            let look = self.look_about(landed.stand.position);
            if look.touching {
                return false;
            }
            (here, level) = (landed, level - 1);
            bound = self.bounds.of(&look) - far.deviation(level, here.stand.triangle);
        }
        (now.here, now.level, now.bound) = (here.stand, level, bound);
        now.underfoot = Underfoot::of(level, here.facet);
        true
    }

    /// Whether to stop here. Otherwise the walker can be taken back to here.
    pub(super) fn stopped(&mut self, now: &Way) -> Option<Stop> {
        if (self.interrupts.cancelled)() {
            return Some(Stop::End(Fate::Halted(Halt::Cancelled)));
        }
        if self.is_tired() {
            return Some(Stop::End(Fate::Lost));
        }
        if self.others_walk {
            if self.track.is_full() {
                return Some(Stop::Pause);
            }
            self.track.remember(self.around.index, now);
        }
        (self.interrupts.paused)().then_some(Stop::Pause)
    }

    /// How far it is to the lichen at least; none beyond the kill radius.
    #[inline]
    pub(super) fn look(&mut self, p: DVec3) -> Option<Look> {
        if p.distance_squared(self.launcher.centre) > self.launcher.outside_sq {
            return self.look_from_outside(p.x, p.y, p.z);
        }
        Some(self.look_about(p))
    }

    #[inline(always)]
    pub(super) fn look_about(&mut self, p: DVec3) -> Look {
        let Surroundings {
            elements, index, ..
        } = &self.around;
        index.look(elements, p, &mut self.track.notes)
    }

    /// The same for a walker well outside the sphere that holds the lichen. Its place comes in registers, and so need
    /// not be in memory for those that are inside.
    #[inline(never)]
    fn look_from_outside(&mut self, x: f64, y: f64, z: f64) -> Option<Look> {
        let p = DVec3 { x, y, z };
        let from_centre = p.distance(self.launcher.centre);
        if from_centre > self.launcher.kill && !self.launcher.encloses() {
            return None;
        }
        let by_sphere = from_centre - self.launcher.reach;
        let by_index = match self.launcher.asks_index(from_centre) {
            true => self.look_about(p).clear,
            false => 0.0,
        };
        Some(Look {
            clear: by_sphere.max(by_index),
            touching: false,
        })
    }

    /// What becomes of a walker that an element is near enough to touch. Sheets are asked of the surface or of a copy.
    #[inline(always)]
    pub(super) fn meet(
        &mut self,
        copy: Option<Ground<'_>>,
        there: &Stand,
        stream: &mut Stream,
    ) -> Meeting {
        let place = (there.triangle, there.position);
        let factor = self.factor(copy.is_some(), there);
        let (ground, scratch) = match &copy {
            Some(copy) => (copy, &mut *self.on_copy),
            None => (&self.around.mesh(), &mut *self.scratch),
        };
        let notes = &mut self.track.notes;
        if !self.around.touches_on((ground, scratch), place, notes) {
            return Meeting::Elsewhere;
        }
        self.track.counts.contacts += 1;
        // It sticks with P_s times the factor.
        let chance = stream.uniform() / factor;
        if factor == 0.0 || chance >= 1.0 {
            self.track.counts.refusals += 1;
            return Meeting::Refused;
        }
        let counting = (ground, scratch, &mut self.crowd);
        let answer = self.around.sticks(counting, self.law, place, chance);
        let Parameters {
            radius,
            curvature_radius,
            ..
        } = *self.around.parameters;
        match answer {
            Answer::Sticks(probability) => {
                let wide = curvature_radius.max(JOINING * radius);
                self.asked(there.position, wide, 0);
                Meeting::Sticks(probability * factor)
            }
            Answer::Refused(Asked {
                centre,
                radius,
                spare,
            }) => {
                self.asked(centre, radius, spare);
                self.track.counts.refusals += 1;
                Meeting::Refused
            }
        }
    }

    /// Goes to a place, by a bound on its own sheet alone where that is worth having, and it is not asked for again
    /// soon where not. On a copy nothing is asked of sheets, and what holds for the walker's own alone does not
    /// lift it.
    #[cold]
    pub(super) fn find_sheet(&mut self, now: &mut Way, there: Stand) {
        if Patience::is_wide(now.bound, self.around.parameters.radius) {
            now.patience = Patience::OUT_OF_THE_NARROWS;
            return self.go(now, there);
        }
        let landed = match self.far.filter(|_| now.level > 0) {
            None => Some(there),
            Some(far) => self.landed_clear(far, now.level, &there),
        };
        match landed.map(|on_mesh| (on_mesh, self.wide_bound(&on_mesh, now.bound))) {
            Some((on_mesh, Ok(bound))) => {
                (now.here, now.level, now.bound) = (on_mesh, 0, bound);
                return;
            }
            Some((_, Err(pause))) => now.patience = Patience::paused(pause),
            None => now.patience = Patience::default(),
        }
        self.go(now, there);
    }

    /// The bound on a step by the walker's own sheet alone, if that saves more steps than it takes time: one k times
    /// as long stands for k² of them. If not, how long not to ask again, as narrow steps are counted.
    fn wide_bound(&mut self, here: &Stand, bound: f64) -> Result<f64, i32> {
        let bound = bound.max(self.around.parameters.radius);
        let wide = self.clear_on_sheet(here) - self.around.contact_distance();
        let looked_at = self.scratch.reached().len();
        let longer = wide.max(0.0) / bound;
        match longer * longer > LOOKING + looked_at as f64 / LOOKED_AT {
            true => Ok(wide),
            false => Err(i32::try_from(looked_at as u64 / STEPS_PER_LOOK).unwrap_or(i32::MAX)),
        }
    }

    /// How far it is to the lichen on the walker's own sheet, at least.
    ///
    /// Under lichen on the other face of a thin plate a walker is near elements that it can never
    /// touch, and would cross below them in steps of a radius. What it can touch within a ball is
    /// what the surface joins to it inside a slightly larger one; so what only a ball twice as large
    /// joins to it, round a rim, cannot be touched within the first.
    pub(super) fn clear_on_sheet(&mut self, here: &Stand) -> f64 {
        let radius = self.around.parameters.radius;
        let (mut free, mut ball) = (0.0, 8.0 * radius);
        loop {
            let nearest = self.nearest_on_sheet(here, ball).max(free);
            let full = self.scratch.reached().len() > MOST_REACHED;
            if nearest < ball || full || ball > MOST_BALL * radius {
                self.asked(here.position, ball, 0);
                return nearest;
            }
            (free, ball) = (ball, 2.0 * ball);
        }
    }

    /// The distance to the nearest element on the same sheet inside a ball, or the ball's radius.
    fn nearest_on_sheet(&mut self, here: &Stand, ball: f64) -> f64 {
        let around = &self.around;
        let larger = Ball {
            centre: here.position,
            radius: ball + around.parameters.radius,
        };
        self.scratch.reach(around.substrate, here.triangle, &larger);
        let is_reached = |triangle| self.scratch.has_reached(triangle);
        if !around.elements.are_on(self.scratch.reached(), is_reached) {
            return ball;
        }
        let mut nearest = ball;
        around.within(here.position, ball, &mut |_, element| {
            if self.scratch.has_reached(element.at.triangle) {
                nearest = nearest.min(element.position.distance(here.position));
            }
        });
        nearest
    }

    /// 3. Kill: dropped, and the next one is launched.
    pub(super) fn kill(&mut self) -> Fate {
        self.track.counts.killed += 1;
        Fate::Lost
    }

    /// 5. Join.
    pub(super) fn join(&mut self, now: &mut Way, step: glam::DVec2, probability: f64) -> Met {
        let from = now.here.surface_point(self.around.substrate);
        self.join_from(now, (&from, step), probability)
    }

    /// The same from a place on the surface. Where nothing may grow it is refused after all, and so where only
    /// round-off had it touch, and where it would overlap what it touches.
    pub(super) fn join_from(
        &mut self,
        now: &mut Way,
        (from, step): (&SurfacePoint, glam::DVec2),
        probability: f64,
    ) -> Met {
        let habitat = self.habitat;
        let suits = |at: &SurfacePoint| habitat.is_everywhere() || habitat.at(at) > 0.0;
        let may_overlap = now.unjoined >= MOST_UNJOINED;
        let scratch = (&mut *self.scratch, &self.crowd.nearby);
        let joined = self
            .around
            .join_where(scratch, (from, step), may_overlap, suits);
        let Some(joined) = joined.filter(|joined| suits(&joined.at)) else {
            now.unjoined += 1;
            self.track.counts.refusals += 1;
            return Met::Refused;
        };
        self.track.counts.packed += u64::from(joined.packed);
        let colony = self.around.element(joined.touched).colony;
        Met::End(Fate::Joined(Element {
            at: joined.at,
            position: self.around.substrate.position(&joined.at),
            parent: joined.touched,
            colony,
            probability,
        }))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::stick::tests::{parameters, scattered, scattered_where};
    use super::*;
    use crate::cluster::{Cluster, SparseIndex};
    use crate::substrate::Substrate;

    /// So many elements about the top of the bounding box.
    fn patch(
        substrate: &Substrate,
        parameters: &Parameters,
        elements: usize,
    ) -> (Cluster, SparseIndex) {
        let [low, high] = substrate.bounds();
        let (top, reach) = (low.midpoint(high).with_z(high.z), 0.25 * low.distance(high));
        scattered_where(substrate, parameters, elements, |p| p.distance(top) < reach)
    }

    #[test]
    fn outside_the_sphere_bounds_are_bounds_and_better_than_the_sphere_alone() {
        let substrate = Substrate::load(Path::new("meshes/rock.obj")).expect("a mesh");
        let parameters = parameters(substrate.units().local_diagonal() / 1000.0);
        let (cluster, index) = patch(&substrate, &parameters, 2000);
        let mut launcher = Launcher::default();
        let youngest = cluster.elements().last().expect("elements");
        launcher.update((&substrate, &parameters), cluster.extent(), youngest);
        let mut walk = Walk {
            around: Surroundings {
                substrate: &substrate,
                parameters: &parameters,
                elements: (&cluster).into(),
                index: &index,
            },
            law: &Stickiness::new(&parameters),
            launcher: &launcher,
            far: None,
            habitat: Habitat::new(&substrate, None, 1e-3),
            scratch: &mut Connectivity::new(),
            on_copy: &mut Connectivity::new(),
            crowd: Crowd::default(),
            bounds: StepBounds::new(&parameters),
            track: &mut Track::default(),
            others_walk: false,
            interrupts: Interrupts {
                cancelled: &|| false,
                paused: &|| false,
            },
        };
        walk.track.begin(&index, cluster.len(), false);
        let area = AreaSampler::of_all(&substrate);
        let mut stream = Stream::new(6, Purpose::Walker, 0);
        let (mut outside, mut better) = (0, 0);
        for _ in 0..4000 {
            let p = substrate.position(&area.sample(&mut stream));
            let Some(look) = walk.look(p) else { continue };
            let all = cluster.elements().iter();
            let nearest = all.fold(f64::INFINITY, |least, e| least.min(e.position.distance(p)));
            assert!(look.clear <= nearest, "{p}: {} of {nearest}", look.clear);
            if p.distance_squared(launcher.centre) > launcher.outside_sq {
                let by_sphere = p.distance(launcher.centre) - launcher.reach;
                assert!(look.clear >= by_sphere && !look.touching);
                outside += 1;
                better += usize::from(look.clear > 1.25 * by_sphere);
            }
        }
        assert!(
            outside > 500 && 3 * better > outside,
            "{better} of {outside}"
        );
    }

    #[test]
    fn where_steps_cross_no_edges_the_sphere_is_enough() {
        let substrate = Substrate::load(Path::new("meshes/plane.obj")).expect("a mesh");
        let diagonal = substrate.units().local_diagonal();
        let parameters = parameters(diagonal / 1000.0);
        let (cluster, _) = patch(&substrate, &parameters, 200);
        let mut launcher = Launcher::default();
        let youngest = cluster.elements().last().expect("elements");
        launcher.update((&substrate, &parameters), cluster.extent(), youngest);
        assert!(launcher.reach < 0.3 * diagonal);
        let far = |i: u32| diagonal * f64::from(i) / 1000.0;
        assert!((0..1000).all(|i| !launcher.asks_index(far(i))));
    }

    #[test]
    fn places_tried_together_are_those_tried_one_by_one() {
        let substrate = Substrate::load(Path::new("meshes/rock.obj")).expect("a mesh");
        let parameters = parameters(substrate.units().local_diagonal() / 66.0);
        let area = AreaSampler::of_all(&substrate);
        // Discs of contact, twice as wide, cover the rock four times over and leave e⁻⁴ of it free.
        let triangles = 0..substrate.triangles().len() as u32;
        let all: f64 = triangles.map(|t| substrate.area(t)).sum();
        let each = std::f64::consts::PI * parameters.radius * parameters.radius;
        let (cluster, index) = scattered(&substrate, &parameters, (all / each) as usize);
        let around = Surroundings {
            substrate: &substrate,
            parameters: &parameters,
            elements: (&cluster).into(),
            index: &index,
        };
        let (mut scratch, mut late) = (Connectivity::new(), 0);
        for number in 0..200 {
            let mut stream = Stream::new(1, Purpose::Walker, number);
            let mut one_by_one = stream.clone();
            let mut tries = 0;
            let expected = loop {
                let at = area.sample(&mut one_by_one);
                tries += 1;
                let place = (at.triangle, substrate.position(&at));
                if !around.in_contact(&mut scratch, place) {
                    break at;
                }
            };
            let found = free_place(&around, &mut scratch, &area, |_| false, &mut stream);
            assert_eq!(found, Some(expected), "{number}");
            assert_eq!(stream.uniform(), one_by_one.uniform(), "{number}");
            late += usize::from(tries > 2 * TOGETHER);
        }
        assert!(late > 50, "{late}");
    }
}
