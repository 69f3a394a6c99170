//! A walker's random step (Sumner 2001, 6.8).

use glam::DVec2;

use crate::rng::Stream;

/// A step in a uniform direction of length d = s + r·√u − r, for the bound s ≥ r on its length.
///
/// At s = r it is uniform in the disc of radius r. With s = D + r, for a walker D away from
/// contact, it ends at most r inside contact; over a smooth edge of contact it ends 0.46 r inside
/// on average, and small steps 0.27 r.
pub fn random_step(stream: &mut Stream, bound: f64, radius: f64) -> DVec2 {
    let v = stream.in_unit_disc();
    let share = v.length();
    v * ((bound - radius + radius * share) / share)
}
