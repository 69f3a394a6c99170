//! A walker's way from step to step (Sumner 2001, chapter 6).

use glam::DVec2;

use super::flight::Way;
use super::near::Met;
use super::patience::Patience;
use super::step::RandomStep;
use super::walker::{Fate, Meeting, STEPS_PER_LOOK, Stop, Walk};
use super::{Boundary, Law, Steps};
use crate::cluster::{ElementIndex, Look};
use crate::walk::{End, Stand};

/// What ends a row of steps.
enum Event {
    /// It is time to ask whether to stop.
    Pause,
    /// The walk itself ends.
    End(Fate),
    /// The walker may be in contact, or where nothing may grow; it has not gone there yet.
    Arrival(Step),
    /// From here another surface or another bound may be the better one; it has not gone there yet.
    Change(Stand),
}

/// A step that has been taken.
struct Step {
    /// Where to, and how near that is to the lichen.
    to: Stand,
    look: Look,
    /// As a vector where it began.
    along: DVec2,
}

impl<I: ElementIndex> Walk<'_, I> {
    /// Goes on to the end, or until paused: then there is no fate yet.
    pub(super) fn go_on(&mut self, way: &mut Way) -> Option<Fate> {
        let parameters = self.around.parameters;
        let mut now = way.clone();
        loop {
            if self.track.counts.steps.is_multiple_of(STEPS_PER_LOOK) {
                if let Some(stop) = self.stopped(&now) {
                    *way = now;
                    return match stop {
                        Stop::End(fate) => Some(fate),
                        Stop::Pause => None,
                    };
                }
                now.patience = match parameters.steps {
                    Steps::Small => Patience::default(),
                    _ => now.patience.after(now.bound, parameters.radius),
                };
            }
            // A Brownian step may set out from beside a contact.
            let (from, event) = match parameters.law {
                Law::Brownian => {
                    let from = now.here;
                    let step = self.brownian_step(&mut now);
                    (Some(from), self.take_steps(&mut now, Some(step)))
                }
                Law::Thesis => (None, self.take_steps(&mut now, None)),
            };
            match event {
                Event::Pause => now.thrown_back = false,
                Event::End(fate) => return Some(fate),
                Event::Change(to) => self.change(&mut now, to),
                Event::Arrival(step) => {
                    if let Some(fate) = self.arrive_at(&mut now, from, &step) {
                        return Some(fate);
                    }
                }
            }
        }
    }

    /// 2. Step, again and again until something happens, or the one that is given.
    ///
    /// Uniform in the disc, d = s + r·√u − r (Sumner 6.8). What a step needs stays in registers: in memory, where it
    /// has just been written, it would be waited for. What is random in the next step is drawn while the processor
    /// waits for what the index says of this one.
    #[inline(never)]
    fn take_steps(&mut self, now: &mut Way, given: Option<DVec2>) -> Event {
        let parameters = self.around.parameters;
        let surface = self.surface(now.level);
        let absorb = parameters.boundary == Boundary::Absorb;
        let is_everywhere = self.habitat.is_everywhere();
        let stays_to = match (now.patience.is_over(), self.far) {
            (true, _) => f64::NEG_INFINITY,
            (false, Some(far)) => far.stays_to(now.level),
            (false, None) => f64::INFINITY,
        };
        let (radius, bounds) = (parameters.radius, self.bounds);
        let (mut here, mut bound, mut random) = (now.here, now.bound, now.random);
        now.underfoot.be((now.level, here.triangle), surface);
        let mut stream = now.stream.clone();
        let (mut steps, mut crossings) = (self.track.counts.steps, 0);
        let mut along = given.unwrap_or_else(|| random.within(bound, radius));
        let event = loop {
            random = RandomStep::draw(&mut stream);
            let moved = here.step_from(surface, &mut now.underfoot.facet, along, absorb);
            steps += 1;
            crossings += u64::from(moved.crossings);
            if moved.end == End::Boundary {
                self.track.counts.absorbed += 1;
                break Event::End(Fate::Lost);
            }
            let to = moved.to;
            let Some(look) = self.look(to.position) else {
                break Event::End(self.kill());
            };
            if look.touching || !is_everywhere {
                break Event::Arrival(Step { to, look, along });
            }
            bound = bounds.of(&look);
            if bound > stays_to {
                break Event::Change(to);
            }
            here = to;
            if given.is_some() || steps.is_multiple_of(STEPS_PER_LOOK) {
                break Event::Pause;
            }
            along = random.within(bound, radius);
        };
        self.track.counts.steps = steps;
        self.track.counts.crossings += crossings;
        (now.here, now.bound, now.random, now.stream) = (here, bound, random, stream);
        event
    }

    /// Goes to where a step led, and on by the surface and the bound that serve best from there.
    fn change(&mut self, now: &mut Way, to: Stand) {
        now.thrown_back = false;
        match now.patience.is_over() {
            false => self.go(now, to),
            true => self.find_sheet(now, to),
        }
    }

    /// 4. Contact: stick, or go back to the last position and walk on. A step from beside a contact began elsewhere.
    fn arrive_at(&mut self, now: &mut Way, from: Option<Stand>, step: &Step) -> Option<Fate> {
        let Step { to, look, along } = step;
        match self.keeps_to_habitat(now, (from, to), look) {
            Met::Nothing => {}
            Met::End(fate) => return Some(fate),
            _ => return None,
        }
        if look.touching {
            let met = match self.far {
                Some(far) if now.level > 0 => self.meet_on_copy(far, now, to, *along),
                _ => match self.meet(None, to, &mut now.stream) {
                    Meeting::Elsewhere => Met::Nothing,
                    Meeting::Refused => Met::Refused,
                    Meeting::Sticks(probability) => self.join(now, *along, probability),
                },
            };
            match met {
                Met::Nothing => {}
                Met::Refused => {
                    (now.patience, now.thrown_back) = (now.patience.after_contact(), true);
                    return None;
                }
                Met::OffCopy => return None,
                Met::End(fate) => return Some(fate),
            }
        }
        now.bound = self.bounds.of(look);
        self.change(now, *to);
        None
    }
}
