//! A walker's random step (Sumner 2001, 6.8).

use glam::DVec2;

use crate::rng::Stream;

/// A step in a uniform direction of length d = s + r·√u − r, for the bound s ≥ r on its length.
///
/// At s = r it is uniform in the disc of radius r. With s = max(D, r), for a walker D away from
/// contact, only steps from nearer than r end inside contact: over a smooth edge of contact 0.28 r
/// inside on average, and 0.27 r where all steps are small.
#[inline]
pub fn random_step(stream: &mut Stream, bound: f64, radius: f64) -> DVec2 {
    let v = stream.in_unit_disc();
    v * (radius + (bound - radius) / v.length())
}
