//! Where walkers start (Sumner 2001, 6.3.1).
//!
//! The sphere of radius k_launch · R_e about the centroid cuts the surface in circular arcs, and a
//! walker starts at a point uniform by arc length. Sumner cuts the triangles' edges only; here
//! every triangle's plane is cut exactly, so a sphere smaller than one triangle has its circle too.
//! Where the sphere cuts nothing it encloses the component: walkers then start uniformly by area
//! on what the lichen leaves free.
//!
//! Several components, of which the thesis has nothing: each walker draws a place by area on all that carry
//! lichen. Where the sphere cuts the component of that place, it starts on the arcs there; where the sphere
//! encloses it, at the place, and it draws another where lichen is in the way.
//!
//! Departure: the arcs are worked out anew only when the centroid and the launch radius together
//! have moved by 1/16 of the gap between the lichen and the arcs. When that happens depends on the
//! births alone, so a run that is rebuilt from its elements has the same arcs.

use std::f64::consts::TAU;
use std::ops::Range;

use glam::{DVec2, DVec3};

use crate::rng::Stream;
use crate::substrate::{Substrate, SurfacePoint};
use crate::walk::TrianglePlane;

/// The arcs in which a sphere cuts the surface.
#[derive(Clone, Debug, Default)]
pub struct LaunchRing {
    arcs: Vec<Arc>,
    /// Length of all arcs up to and with each one.
    lengths: Vec<f64>,
}

/// An arc of a circle in a triangle's chart.
#[derive(Clone, Copy, Debug)]
struct Arc {
    triangle: u32,
    centre: DVec2,
    radius: f64,
    from: f64,
    sweep: f64,
}

impl LaunchRing {
    /// Cuts the triangles of some ranges, which do not overlap, with a sphere.
    pub fn new(
        substrate: &Substrate,
        components: &[Range<u32>],
        centre: DVec3,
        radius: f64,
    ) -> Self {
        let mut all = Self::default();
        for ring in Self::of_each(substrate, components, centre, radius) {
            let before = all.length();
            all.arcs.extend(ring.arcs);
            all.lengths.extend(ring.lengths.iter().map(|l| before + l));
        }
        all
    }

    /// One for each of some ranges, which do not overlap.
    pub(super) fn of_each(
        substrate: &Substrate,
        components: &[Range<u32>],
        centre: DVec3,
        radius: f64,
    ) -> Vec<Self> {
        let mut rings = vec![Self::default(); components.len()];
        let mut order: Vec<usize> = (0..components.len()).collect();
        order.sort_unstable_by_key(|&i| components[i].start);
        let (Some(&first), Some(&last)) = (order.first(), order.last()) else {
            return rings;
        };
        // All at once: each look goes through the boxes of the whole mesh.
        let span = components[first].start..components[last].end;
        for triangle in substrate.triangles_near_sphere(centre, radius, &span) {
            let place = order.partition_point(|&i| components[i].end <= triangle);
            let component = order[place];
            if components[component].contains(&triangle) {
                rings[component].cut(substrate, triangle, centre, radius);
            }
        }
        rings
    }

    /// Length of all arcs.
    pub fn length(&self) -> f64 {
        self.lengths.last().copied().unwrap_or(0.0)
    }

    /// A point uniform by arc length; none when nothing was cut.
    pub fn sample(&self, substrate: &Substrate, stream: &mut Stream) -> Option<SurfacePoint> {
        let target = stream.uniform() * self.length();
        let i = self
            .lengths
            .partition_point(|&l| l <= target)
            .min(self.arcs.len().checked_sub(1)?);
        let arc = &self.arcs[i];
        let start = if i == 0 { 0.0 } else { self.lengths[i - 1] };
        let angle = arc.from + arc.sweep * ((target - start) / (self.lengths[i] - start));
        let plane = TrianglePlane::new(substrate, arc.triangle);
        Some(plane.surface_point(arc.at(angle)))
    }

    fn cut(&mut self, substrate: &Substrate, triangle: u32, centre: DVec3, radius: f64) {
        let plane = TrianglePlane::new(substrate, triangle);
        let (foot, height_sq) = plane.project(centre);
        let circle_sq = radius * radius - height_sq;
        if circle_sq <= 0.0 {
            return;
        }
        let arc = Arc {
            triangle,
            centre: foot,
            radius: circle_sq.sqrt(),
            from: 0.0,
            sweep: TAU,
        };
        let mut angles = arc.crossings(plane.corners());
        if angles.is_empty() {
            angles.push(0.0);
        }
        angles.sort_by(f64::total_cmp);
        for (i, &from) in angles.iter().enumerate() {
            let to = if i + 1 < angles.len() {
                angles[i + 1]
            } else {
                angles[0] + TAU
            };
            self.add_if_inside(
                plane.corners(),
                Arc {
                    from,
                    sweep: to - from,
                    ..arc
                },
            );
        }
    }

    fn add_if_inside(&mut self, corners: &[DVec2; 3], arc: Arc) {
        let middle = arc.at(arc.from + 0.5 * arc.sweep);
        let inside = |k: usize| {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            (b - a).perp_dot(middle - a) > 0.0
        };
        if arc.sweep > 0.0 && (0..3).all(inside) {
            self.lengths.push(self.length() + arc.radius * arc.sweep);
            self.arcs.push(arc);
        }
    }
}

impl Arc {
    fn at(&self, angle: f64) -> DVec2 {
        let (sin, cos) = libm::sincos(angle);
        self.centre + DVec2::new(cos, sin) * self.radius
    }

    /// Angles at which the whole circle crosses a triangle's edges. Near a vertex or a tangent
    /// there may be others too: they cut the circle where nothing is lost by it.
    fn crossings(&self, corners: &[DVec2; 3]) -> Vec<f64> {
        let mut angles = Vec::with_capacity(6);
        let radius_sq = self.radius * self.radius;
        for k in 0..3 {
            let (a, e) = (corners[k] - self.centre, corners[(k + 1) % 3] - corners[k]);
            let foot = -a.dot(e) / e.length_squared();
            let miss_sq = (a + e * foot).length_squared();
            let touches = (miss_sq - radius_sq).abs() <= SLACK * radius_sq;
            let tangent = if touches { foot } else { f64::NAN };
            let [near, far] = circle_crossings(a, e, radius_sq);
            for s in [near, far, tangent] {
                if (-SLACK..=1.0 + SLACK).contains(&s) {
                    let p = a + e * s;
                    angles.push(libm::atan2(p.y, p.x));
                }
            }
        }
        angles
    }
}

/// Share of an edge, or of a radius squared, by which round-off could hide a crossing: a circle
/// through a vertex would cross neither of the edges there, and an arc would be lost.
const SLACK: f64 = 1e-9;

/// The s for which |a + s·e|² = radius², ascending; both NaN where the line misses the circle.
pub(super) fn circle_crossings(a: DVec2, e: DVec2, radius_sq: f64) -> [f64; 2] {
    let (ee, ae) = (e.length_squared(), a.dot(e));
    // The foot of the centre on the line, then half the chord: no cancellation far from the centre.
    let inverse = 1.0 / ee;
    let miss_sq = a.perp_dot(e) * a.perp_dot(e) * inverse;
    let half = ((radius_sq - miss_sq) * inverse).sqrt();
    let middle = -ae * inverse;
    [middle - half, middle + half]
}

/// Chooses among triangles by area.
#[derive(Clone, Debug, Default)]
pub(super) struct AreaSampler {
    triangles: Vec<u32>,
    /// Area of all triangles up to and with each one.
    areas: Vec<f64>,
    /// Equal shares of the whole for each unit of area: as many as there are triangles.
    shares: f64,
    /// How many of those areas are in the shares before each.
    before: Vec<u32>,
}

impl AreaSampler {
    /// Among all of a mesh.
    pub(super) fn of_all(substrate: &Substrate) -> Self {
        Self::new(substrate, 0..substrate.triangles().len() as u32)
    }

    pub(super) fn new(substrate: &Substrate, triangles: impl Iterator<Item = u32>) -> Self {
        Self::by_areas(triangles.map(|t| (t, substrate.area(t))))
    }

    /// Of triangles that count as much as these areas.
    pub(super) fn by_areas(triangles: impl Iterator<Item = (u32, f64)>) -> Self {
        let mut sampler = Self::default();
        let mut total = 0.0;
        for (t, area) in triangles {
            total += area;
            sampler.triangles.push(t);
            sampler.areas.push(total);
        }
        sampler.shares = sampler.areas.len() as f64 / total;
        for i in 0..sampler.areas.len() {
            let share = sampler.share(sampler.areas[i]);
            sampler
                .before
                .resize(sampler.before.len().max(share + 1), i as u32);
        }
        sampler.before.push(sampler.areas.len() as u32);
        sampler
    }

    /// Which share of the whole an area ends in.
    fn share(&self, area: f64) -> usize {
        (area * self.shares) as usize
    }

    /// How many areas are no larger than this, which is no larger than the whole.
    ///
    /// A larger area is in no earlier share, so only those of one share have to be asked: in a table of a
    /// million a search waits for memory at every turn.
    fn no_larger(&self, area: f64) -> usize {
        let share = self.share(area);
        let [first, end] = [self.before[share] as usize, self.before[share + 1] as usize];
        first + self.areas[first..end].partition_point(|&a| a <= area)
    }

    /// A point uniform by area.
    pub(super) fn sample(&self, stream: &mut Stream) -> SurfacePoint {
        let triangle = self.triangle(stream);
        Self::in_triangle(triangle.unwrap_or(0), stream)
    }

    /// A triangle by area, if there is any.
    pub(super) fn triangle(&self, stream: &mut Stream) -> Option<u32> {
        let target = stream.uniform() * self.areas.last()?;
        let i = self.no_larger(target).min(self.triangles.len() - 1);
        Some(self.triangles[i])
    }

    /// A point uniform by area in a triangle.
    pub(super) fn in_triangle(triangle: u32, stream: &mut Stream) -> SurfacePoint {
        let (u, v) = (stream.uniform(), stream.uniform());
        let (u, v) = if u + v > 1.0 {
            (1.0 - u, 1.0 - v)
        } else {
            (u, v)
        };
        SurfacePoint { triangle, u, v }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::rng::Purpose;

    #[test]
    fn areas_are_found_as_by_looking_at_all() {
        for mesh in ["meshes/rock.obj", "meshes/slab.stl", "meshes/plane.obj"] {
            let substrate = Substrate::load(Path::new(mesh)).expect("a mesh");
            let area = AreaSampler::of_all(&substrate);
            let whole = *area.areas.last().expect("a triangle");
            let mut stream = Stream::new(1, Purpose::Walker, 0);
            let anywhere = (0..20_000).map(|_| stream.uniform() * whole);
            let there = area.areas.iter().copied();
            let beside = |a: f64| [a.next_down(), a, a.next_up().min(whole)];
            for a in anywhere.chain(there.flat_map(beside)).chain([0.0, whole]) {
                let expected = area.areas.iter().filter(|&&b| b <= a).count();
                assert_eq!(area.no_larger(a), expected, "{mesh}: {a} of {whole}");
            }
        }
    }
}
