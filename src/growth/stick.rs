//! Curvature-based sticking (Sumner 2001, 5.2 and 6.2; Vicsek 1984).
//!
//! The front's curvature at a walker is estimated from n, the number of elements with their centre
//! within L of its centre: κ = (n − N_L)/N_L, where N_L = πL²/(4√3 r²) is what a densely packed
//! half disc holds. It sticks with P_s = clamp(A·κ + B, P_min, 1).
//!
//! The thesis prints κ with the opposite sign in 6.4; its own section 5.2 has this one.

use glam::DVec3;

use super::flight::Asked;
use super::nearby::Nearby;
use super::surroundings::Ground;
use super::{Parameters, Surroundings};
use crate::cluster::ElementIndex;
use crate::walk::{Ball, Connectivity, Place};

/// The sticking law with its constants worked out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stickiness {
    half_disc: f64,
    gain: f64,
    bias: f64,
    least: f64,
}

impl Stickiness {
    /// The sticking law for these parameters.
    pub fn new(p: &Parameters) -> Self {
        let ratio = p.curvature_radius / p.radius;
        let half_disc = std::f64::consts::PI * ratio * ratio / (4.0 * 3f64.sqrt());
        Self {
            half_disc,
            // Where all stick nobody has to be counted.
            gain: if p.min_stick < 1.0 { p.gain } else { 0.0 },
            bias: p.bias,
            least: p.min_stick,
        }
    }

    /// Whether n makes a difference.
    pub(super) fn counts(&self) -> bool {
        self.gain != 0.0
    }

    /// Curvature κ of a front that has n elements within L.
    pub fn curvature(&self, n: usize) -> f64 {
        (n as f64 - self.half_disc) / self.half_disc
    }

    /// Sticking probability P_s with n elements within L.
    pub fn probability(&self, n: usize) -> f64 {
        (self.gain * self.curvature(n) + self.bias)
            .max(self.least)
            .min(1.0)
    }

    /// The smallest n at which a walker with this chance sticks, for a gain above 0; no more than
    /// there can be elements.
    fn least_to_stick(&self, chance: f64) -> usize {
        if chance < self.least {
            return 0;
        }
        let kappa = (chance - self.bias) / self.gain;
        let n = (kappa + 1.0) * self.half_disc;
        if n >= f64::from(u32::MAX) {
            return u32::MAX as usize;
        }
        // Rounding may have it one off.
        let mut n = n.max(0.0) as usize;
        while chance >= self.probability(n) {
            n += 1;
        }
        while n > 0 && chance < self.probability(n - 1) {
            n -= 1;
        }
        n
    }
}

/// Whether a walker sticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Answer {
    /// It does, and this was P_s.
    Sticks(f64),
    /// It does not, by the elements in this ball.
    Refused(Asked),
}

/// What one walker knows of the n about it. Nothing may be born while it is used.
#[derive(Default)]
pub(super) struct Crowd {
    counted: Option<Counted>,
    /// The elements about where it was last asked for n itself.
    pub(super) nearby: Nearby,
}

/// A count that is at least n for whoever is no farther than [`ROAMING`] from its centre.
#[derive(Clone, Copy)]
struct Counted {
    centre: DVec3,
    most: usize,
}

/// In radii. A refused walker meets lichen near there time and again: at B = 0.1 three contacts of four
/// are within this of an earlier one, and five refusals of six are settled by that.
const ROAMING: f64 = 2.0;

/// What rounding may add to it.
const ROUNDED: f64 = 1e-9;

/// The radius of the widest ball in which [`Surroundings::sticks`] counts elements.
pub(super) fn widest_count(p: &Parameters) -> f64 {
    p.curvature_radius + (ROAMING + ROUNDED) * p.radius
}

impl<I: ElementIndex> Surroundings<'_, I> {
    /// Whether a walker in contact sticks, with `chance` drawn uniformly from [0, 1).
    ///
    /// Elements of other sheets can only raise n, and so can a wider ball: so most refusals are settled
    /// by what was counted for an earlier one, or without asking which sheet each element is on.
    pub(super) fn sticks(
        &self,
        (ground, scratch, crowd): (&Ground<'_>, &mut Connectivity, &mut Crowd),
        law: &Stickiness,
        (triangle, p): (u32, DVec3),
        chance: f64,
    ) -> Answer {
        let mut asked = Asked {
            centre: p,
            radius: self.parameters.curvature_radius,
            spare: 0,
        };
        if law.gain > 0.0 {
            let enough = law.least_to_stick(chance);
            let Counted { centre, most } = self.counted_near(p, crowd);
            if most < enough {
                let (radius, spare) = (widest_count(self.parameters), enough - 1 - most);
                return Answer::Refused(Asked {
                    centre,
                    radius,
                    spare,
                });
            }
            let most = self.count_bound(p, asked.radius, enough);
            if most < enough {
                asked.spare = enough - 1 - most;
                return Answer::Refused(asked);
            }
        }
        let n = if law.counts() {
            self.count_on(ground, scratch, &mut crowd.nearby, (triangle, p))
        } else {
            asked.spare = usize::MAX;
            0
        };
        match law.probability(n) {
            probability if chance < probability => Answer::Sticks(probability),
            _ => Answer::Refused(asked),
        }
    }

    /// An earlier count that is at least n, or one about this place.
    fn counted_near(&self, p: DVec3, crowd: &mut Crowd) -> Counted {
        let roaming = ROAMING * self.parameters.radius;
        let serves = |c: &Counted| c.centre.distance_squared(p) <= roaming * roaming;
        if let Some(counted) = crowd.counted.filter(serves) {
            return counted;
        }
        let most = self.count_bound(p, widest_count(self.parameters), 0);
        *crowd.counted.insert(Counted { centre: p, most })
    }

    fn count_bound(&self, p: DVec3, radius: f64, enough: usize) -> usize {
        self.index.count_bound(&self.elements, p, radius, enough)
    }

    /// n: elements of the same sheet with their centre within L of a place.
    ///
    /// The sheet is what the surface joins to the place inside the ball of radius L + r.
    pub fn count(&self, scratch: &mut Connectivity, place: Place) -> usize {
        self.count_on(&self.mesh(), scratch, &mut Nearby::default(), place)
    }

    fn count_on(
        &self,
        ground: &Ground<'_>,
        scratch: &mut Connectivity,
        nearby: &mut Nearby,
        (triangle, p): Place,
    ) -> usize {
        let reach = self.parameters.curvature_radius;
        let ball = Ball {
            centre: p,
            radius: reach + self.parameters.radius,
        };
        let mut others = std::mem::take(&mut scratch.others);
        others.clear();
        let mut n = 0;
        nearby.begin(Ball {
            centre: p,
            radius: reach,
        });
        self.within(p, reach, &mut |id, element| {
            nearby.add(id, element.position);
            match ground.place(element) {
                (other, _) if other == triangle => n += 1,
                place => others.push(place),
            }
        });
        if !others.is_empty() {
            let asked = ((triangle, p), &mut others[..]);
            n += scratch.count_joined(ground.surface, asked, &ball);
        }
        scratch.others = others;
        n
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::path::Path;

    use super::*;
    use crate::cluster::{Cluster, Element, SparseIndex};
    use crate::growth::launch::AreaSampler;
    use crate::growth::{Boundary, Join, Law, Steps};
    use crate::rng::{Purpose, Stream};
    use crate::substrate::{Substrate, SurfacePoint};

    pub(in crate::growth) fn parameters(radius: f64) -> Parameters {
        Parameters {
            radius,
            curvature_radius: 10.0 * radius,
            bias: 0.1,
            gain: 1.0,
            min_stick: 0.01,
            launch: 1.5,
            kill: 10.0,
            join: Join::Pack,
            law: Law::Thesis,
            steps: Steps::Large,
            boundary: Boundary::Reflect,
            slope: None,
            seed: 1,
        }
    }

    /// So many elements anywhere on a surface.
    pub(in crate::growth) fn scattered(
        substrate: &Substrate,
        parameters: &Parameters,
        elements: usize,
    ) -> (Cluster, SparseIndex) {
        scattered_where(substrate, parameters, elements, |_| true)
    }

    /// So many elements on a part of a surface.
    pub(in crate::growth) fn scattered_where(
        substrate: &Substrate,
        parameters: &Parameters,
        elements: usize,
        is_there: impl Fn(DVec3) -> bool,
    ) -> (Cluster, SparseIndex) {
        let mut cluster = Cluster::new(parameters.radius);
        let wide = Some(widest_count(parameters));
        let mut index = SparseIndex::new(parameters.radius, wide, substrate.bounds());
        let area = AreaSampler::new(substrate, 0..substrate.triangles().len() as u32);
        let mut stream = Stream::new(3, Purpose::Walker, 0);
        let places = std::iter::repeat_with(|| area.sample(&mut stream));
        let there = |at: &SurfacePoint| is_there(substrate.position(at));
        for at in places.filter(there).take(elements) {
            cluster.push(Element::seed(substrate, at));
            index.add(&(&cluster).into());
        }
        (cluster, index)
    }

    /// 9,000 elements anywhere on the rock, a 250th of its diagonal in radius.
    pub(in crate::growth) fn on_rock(check: impl FnOnce(&Surroundings<SparseIndex>, &[Element])) {
        let substrate = Substrate::load(Path::new("meshes/rock.obj")).expect("a mesh");
        let parameters = parameters(substrate.units().local_diagonal() / 250.0);
        let (cluster, index) = scattered(&substrate, &parameters, 9_000);
        let around = Surroundings {
            substrate: &substrate,
            parameters: &parameters,
            elements: (&cluster).into(),
            index: &index,
        };
        check(&around, cluster.elements());
    }

    #[test]
    fn what_was_counted_near_answers_as_counting_does() {
        on_rock(counts_near_answer_as_counting_does);
    }

    fn counts_near_answer_as_counting_does(
        around: &Surroundings<SparseIndex>,
        elements: &[Element],
    ) {
        let (substrate, parameters) = (around.substrate, around.parameters);
        let law = Stickiness::new(parameters);
        let mut scratch = Connectivity::new();
        let mut stream = Stream::new(4, Purpose::Walker, 0);
        let (mut stuck, mut remembered) = (0, 0);
        for first in elements.iter().step_by(80) {
            let (mut place, mut crowd) = (first.at, Crowd::default());
            for _ in 0..40 {
                let step = stream.in_unit_disc() * parameters.radius;
                place = crate::walk::trace(substrate, &place, step, false).point;
                let here = (place.triangle, substrate.position(&place));
                let chance = stream.uniform();
                let probability = law.probability(around.count(&mut scratch, here));
                match around.sticks(
                    (&around.mesh(), &mut scratch, &mut crowd),
                    &law,
                    here,
                    chance,
                ) {
                    Answer::Sticks(said) => {
                        assert_eq!((said, chance < said), (probability, true));
                        stuck += 1;
                    }
                    Answer::Refused(asked) => {
                        assert!(chance >= probability);
                        assert_spares(around, &law, (here.1, chance), asked);
                        remembered += usize::from(asked.centre != here.1);
                    }
                }
            }
        }
        assert!(stuck > 500 && remembered > 1000, "{stuck}, {remembered}");
    }

    #[test]
    fn nobody_is_counted_where_all_stick() {
        let sure = |min_stick: f64| {
            Stickiness::new(&Parameters {
                min_stick,
                ..parameters(1.0)
            })
        };
        assert!(sure(0.999).counts() && !sure(1.0).counts());
        assert!((0..200).all(|n| sure(1.0).probability(n) == 1.0));
    }

    /// What refused holds n, and would have refused with all that were to spare.
    fn assert_spares(
        around: &Surroundings<SparseIndex>,
        law: &Stickiness,
        (p, chance): (DVec3, f64),
        asked: Asked,
    ) {
        let reach = around.parameters.curvature_radius;
        assert!(asked.centre.distance(p) + reach <= asked.radius);
        let mut n = 0;
        around.within(asked.centre, asked.radius, &mut |_, _| n += 1);
        if asked.spare > 0 {
            assert!(chance >= law.probability(n + asked.spare));
        }
    }
}
