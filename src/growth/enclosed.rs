//! Places inside the launch sphere.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::launch::AreaSampler;
use crate::rng::Stream;
use crate::substrate::{Substrate, SurfacePoint};
use crate::walk::TrianglePlane;

/// Draws places uniform by area among those of some triangles that are inside a sphere.
///
/// Of each triangle, or of the disc in which the sphere cuts its plane, the smaller one is drawn from; what is not in
/// both is drawn again. So a triangle much larger than the sphere costs no more than a small one.
pub(super) struct Enclosed {
    area: AreaSampler,
    centre: DVec3,
    radius: f64,
}

impl Enclosed {
    pub(super) fn new(
        substrate: &Substrate,
        (centre, radius): (DVec3, f64),
        triangles: impl Iterator<Item = u32>,
    ) -> Self {
        let inside = |t: u32| {
            let disc = disc(substrate, t, centre, radius).map_or(0.0, |(_, r)| PI * r * r);
            (t, disc.min(substrate.area(t)))
        };
        let parts = triangles.map(inside).filter(|(_, area)| *area > 0.0);
        Self {
            area: AreaSampler::by_areas(parts),
            centre,
            radius,
        }
    }

    /// A place, or none where it has to be drawn again.
    pub(super) fn sample(
        &self,
        substrate: &Substrate,
        stream: &mut Stream,
    ) -> Option<SurfacePoint> {
        let triangle = self.area.triangle(stream)?;
        let (foot, radius) = disc(substrate, triangle, self.centre, self.radius)?;
        if substrate.area(triangle) <= PI * radius * radius {
            let at = AreaSampler::in_triangle(triangle, stream);
            let from_centre = substrate.position(&at).distance(self.centre);
            return (from_centre <= self.radius).then_some(at);
        }
        let there: DVec2 = foot + radius * stream.in_unit_disc();
        let is_inside = substrate.facet(triangle).chart.contains(there);
        is_inside.then(|| TrianglePlane::new(substrate, triangle).surface_point(there))
    }
}

/// Middle and radius of the disc in which a sphere cuts a triangle's plane, if it does.
fn disc(substrate: &Substrate, triangle: u32, centre: DVec3, radius: f64) -> Option<(DVec2, f64)> {
    let (foot, height_sq) = TrianglePlane::new(substrate, triangle).project(centre);
    let radius_sq = radius * radius - height_sq;
    (radius_sq > 0.0).then(|| (foot, radius_sq.sqrt()))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::rng::Purpose;

    /// About the middle of a plane of two triangles, far larger and not much larger than the sphere: all places are
    /// inside, and as many in each of four rings of one area and each quarter; chi-square of 15 degrees of freedom is
    /// beyond 44.3 once in 10,000.
    #[test]
    fn places_are_uniform_inside_the_sphere() {
        let plane = Substrate::load(Path::new("meshes/plane.obj")).expect("a mesh");
        let width = plane.units().length_to_local(2000.0);
        let up = plane.up();
        for (radius, aside) in [(1e-4, 0.0), (0.05, 0.01), (0.45, 0.0)] {
            let (radius, centre) = (radius * width, aside * width * up);
            let enclosed = Enclosed::new(&plane, (centre, radius), 0..2);
            let flat = (radius * radius - centre.length_squared()).sqrt();
            let mut stream = Stream::new(1, Purpose::Walker, 0);
            let mut counts = [0.0; 16];
            let mut drawn = 0;
            while drawn < 8000 {
                let Some(at) = enclosed.sample(&plane, &mut stream) else {
                    continue;
                };
                let p = plane.position(&at);
                let share = (p - p.dot(up) * up).length_squared() / (flat * flat);
                assert!(share <= 1.0 + 1e-9, "{share}");
                let (u, v) = up.any_orthonormal_pair();
                let quarter = usize::from(p.dot(u) > 0.0) + 2 * usize::from(p.dot(v) > 0.0);
                counts[((4.0 * share) as usize).min(3) * 4 + quarter] += 1.0;
                drawn += 1;
            }
            let off = counts.map(|n: f64| (n - 500.0) * (n - 500.0) / 500.0);
            assert!(off.iter().sum::<f64>() < 44.3, "{radius}: {counts:?}");
        }
    }
}
