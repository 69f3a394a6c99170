//! A walker's random step (Sumner 2001, 6.8).

use glam::DVec2;

use super::{Law, Parameters, Steps};
use crate::cluster::Look;
use crate::rng::Stream;

/// How the bound on the next step comes from what is known of the lichen: s = max(D − 2r, r), from any lower bound
/// D on the distance to the nearest element.
///
/// Where all steps are small s = r. Brownian motion does without the least bound, and sees to small steps itself.
///
/// Departure: Sumner 6.3 goes as far as D − r, so that a long step may end r inside contact.
/// A walker refused there is thrown back far, which makes another law of every bound: on the
/// plane at B = 0.5 it takes a third off the contacts and adds half to the elements within a
/// given reach. Here a long step ends where it may just touch, contacts come from steps in the
/// disc of radius r alone, and long steps change nothing but the time it takes.
#[derive(Clone, Copy, Debug)]
pub(super) struct StepBounds {
    contact: f64,
    shortest: f64,
}

impl StepBounds {
    pub(super) fn new(parameters: &Parameters) -> Self {
        let radius = parameters.radius;
        match (parameters.law, parameters.steps) {
            (Law::Brownian, _) => Self {
                contact: 2.0 * radius,
                shortest: f64::NEG_INFINITY,
            },
            (Law::Thesis, steps) => Self {
                // However far the lichen is.
                contact: match steps {
                    Steps::Small => f64::INFINITY,
                    _ => 2.0 * radius,
                },
                shortest: radius,
            },
        }
    }

    #[inline(always)]
    pub(super) fn of(&self, look: &Look) -> f64 {
        let bound = look.clear - self.contact;
        if bound > self.shortest {
            bound
        } else {
            self.shortest
        }
    }
}

/// What is random in a step: a place in the unit disc, and the direction that it is in.
#[derive(Clone, Copy, Debug)]
pub struct RandomStep {
    place: DVec2,
    direction: DVec2,
}

impl RandomStep {
    /// Uniform by area.
    #[inline]
    pub fn draw(stream: &mut Stream) -> Self {
        let place = stream.in_unit_disc();
        Self {
            place,
            direction: place * (1.0 / place.length()),
        }
    }

    /// The step in a uniform direction of length d = s + r·√u − r, for the bound s ≥ r on its
    /// length.
    ///
    /// At s = r it is uniform in the disc of radius r. With s = max(D, r), for a walker D away from
    /// contact, only steps from nearer than r end inside contact: over a smooth edge of contact
    /// 0.28 r inside on average, and 0.27 r where all steps are small.
    #[inline]
    pub fn within(&self, bound: f64, radius: f64) -> DVec2 {
        self.place * radius + self.direction * (bound - radius)
    }

    /// A step in a uniform direction.
    #[inline]
    pub fn of_length(&self, length: f64) -> DVec2 {
        self.direction * length
    }

    /// A number of the standard Cauchy distribution: the tangent of a uniform angle.
    pub fn cauchy(&self) -> f64 {
        self.place.y / self.place.x
    }
}

/// The next step of a walker: see [`RandomStep`].
#[inline]
pub fn random_step(stream: &mut Stream, bound: f64, radius: f64) -> DVec2 {
    RandomStep::draw(stream).within(bound, radius)
}

#[cfg(test)]
mod tests {
    use super::super::stick::tests::parameters;
    use super::*;

    #[test]
    fn bounds_leave_room_for_contact_and_are_never_shorter_than_a_radius() {
        let of = |law, steps, clear: f64| {
            let p = Parameters {
                law,
                steps,
                ..parameters(0.5)
            };
            let touching = false;
            StepBounds::new(&p).of(&Look { clear, touching })
        };
        let distances = [0.0, 1.0, 1.4, 1.6, 9.0];
        let bounds = |law, steps| distances.map(|clear| of(law, steps, clear));
        let large = [0.5, 0.5, 0.5, 0.6, 8.0];
        for (bound, expected) in bounds(Law::Thesis, Steps::Large).into_iter().zip(large) {
            assert!((bound - expected).abs() < 1e-12, "{bound} {expected}");
        }
        assert_eq!(
            bounds(Law::Thesis, Steps::Exact),
            bounds(Law::Thesis, Steps::Large)
        );
        assert_eq!(bounds(Law::Thesis, Steps::Small), [0.5; 5]);
        assert_eq!(
            bounds(Law::Brownian, Steps::Small),
            bounds(Law::Brownian, Steps::Large)
        );
        assert_eq!(
            bounds(Law::Brownian, Steps::Large),
            distances.map(|d| d - 1.0)
        );
    }
}
