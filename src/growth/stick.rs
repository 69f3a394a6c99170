//! Curvature-based sticking (Sumner 2001, 5.2 and 6.2; Vicsek 1984).
//!
//! The front's curvature at a walker is estimated from n, the number of elements with their centre
//! within L of its centre: κ = (n − N_L)/N_L, where N_L = πL²/(4√3 r²) is what a densely packed
//! half disc holds. It sticks with P_s = clamp(A·κ + B, P_min, 1).
//!
//! The thesis prints κ with the opposite sign in 6.4; its own section 5.2 has this one (DESIGN
//! section 4).

use glam::DVec3;

use super::{Parameters, Surroundings};
use crate::cluster::ElementIndex;
use crate::walk::Connectivity;

/// The sticking law with its constants worked out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stickiness {
    half_disc: f64,
    gain: f64,
    bias: f64,
    least: f64,
}

impl Stickiness {
    /// For these parameters.
    pub fn new(p: &Parameters) -> Self {
        let ratio = p.curvature_radius / p.radius;
        let half_disc = std::f64::consts::PI * ratio * ratio / (4.0 * 3f64.sqrt());
        Self {
            half_disc,
            gain: p.gain,
            bias: p.bias,
            least: p.min_stick,
        }
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

    fn answer(&self, n: usize, chance: f64, spare: usize) -> Answer {
        match self.probability(n) {
            probability if chance < probability => Answer::Sticks(probability),
            _ => Answer::Refused { spare },
        }
    }
}

/// Whether a walker sticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answer {
    /// It does, and this was P_s.
    Sticks(f64),
    /// It does not.
    Refused {
        /// How many more elements within L would leave it so; there may be more still.
        spare: usize,
    },
}

impl<I: ElementIndex> Surroundings<'_, I> {
    /// Whether a walker in contact sticks, with `chance` drawn uniformly from [0, 1).
    ///
    /// Elements of other sheets can only raise n, so most refusals are settled by counting
    /// without asking which sheet each one is on.
    pub fn sticks(
        &self,
        scratch: &mut Connectivity,
        law: &Stickiness,
        (triangle, p): (u32, DVec3),
        chance: f64,
    ) -> Answer {
        if law.gain == 0.0 {
            return law.answer(0, chance, usize::MAX);
        }
        if law.gain > 0.0 {
            let enough = law.least_to_stick(chance);
            let reach = self.parameters.curvature_radius;
            let elements = self.cluster.elements();
            let most = self.index.at_most(elements, p, reach, enough);
            if most < enough {
                let spare = enough - 1 - most;
                return Answer::Refused { spare };
            }
        }
        law.answer(self.count(scratch, (triangle, p)), chance, 0)
    }

    /// n: elements of the same sheet with their centre within L of a place.
    ///
    /// The sheet is what the surface joins to the place inside the ball of radius L + r.
    pub fn count(&self, scratch: &mut Connectivity, (triangle, p): (u32, DVec3)) -> usize {
        let reach = self.parameters.curvature_radius;
        let ball = reach + self.parameters.radius;
        let mut searched = false;
        let mut n = 0;
        self.within(p, reach, &mut |_, element| {
            let other = element.at.triangle;
            if other != triangle && !searched {
                scratch.reach(self.substrate, triangle, p, ball);
                searched = true;
            }
            n += usize::from(other == triangle || scratch.has_reached(other));
        });
        n
    }
}
