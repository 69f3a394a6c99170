//! A walker's random step (Sumner 2001, 6.8).

use glam::DVec2;

use crate::rng::Stream;

/// What is random in a step: a place in the unit disc.
#[derive(Clone, Copy, Debug)]
pub struct RandomStep {
    place: DVec2,
    inverse: f64,
}

impl RandomStep {
    /// Uniform by area.
    #[inline]
    pub fn draw(stream: &mut Stream) -> Self {
        let place = stream.in_unit_disc();
        Self {
            place,
            inverse: 1.0 / place.length(),
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
        self.place * (radius + (bound - radius) * self.inverse)
    }

    /// A step in a uniform direction.
    #[inline]
    pub fn of_length(&self, length: f64) -> DVec2 {
        self.place * (self.inverse * length)
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
