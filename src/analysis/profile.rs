//! The density profile: how much of the ground about its seed a lichen covers.
//!
//! It is what the curve of mass–radius (T. A. Witten and L. M. Sander, 1981, 1983) gains with the
//! distance, over what the ground gains. On a curved surface a ring has neither the area of a flat one
//! nor, through space, a place of its own: so its radius and its ground are those along the surface.

use std::f64::consts::PI;

use super::mass::Metric;

/// Rings of the profile.
const RINGS: usize = 32;

/// Middle of each ring about the first element, and the share of its ground that discs of this radius
/// cover. Nothing of a metric that knows no ground, or of a lichen without extent.
pub(super) fn profile(radius: f64, metric: &dyn Metric) -> Vec<[f64; 2]> {
    let distances = metric.distances(0, f64::INFINITY);
    let reached = distances.iter().copied().filter(|d| d.is_finite());
    let width = reached.fold(0.0, f64::max) / RINGS as f64;
    let ground = match width > 0.0 {
        true => metric.ring_areas(0, width, RINGS),
        false => None,
    };
    let edges: Vec<_> = (0..=RINGS).map(|k| k as f64 * width).collect();
    let within = edges.iter().map(|&edge| covered(&distances, radius, edge));
    let within: Vec<f64> = within.collect();
    let ring = |(k, area): (usize, f64)| {
        let share = (within[k + 1] - within[k]) / area;
        (area > 0.0).then_some([0.5 * (edges[k] + edges[k + 1]), share])
    };
    let rings = ground.into_iter().flatten().enumerate();
    rings.filter_map(ring).collect()
}

/// Area of the parts of discs about elements at these distances that lie within `edge`.
fn covered(distances: &[f64], radius: f64, edge: f64) -> f64 {
    let part = |&d: &f64| disc_within(d, radius, edge);
    distances.iter().map(part).sum()
}

/// Area that a disc at a distance from the middle has in common with a disc about the middle.
///
/// Both are taken as flat, which a surface is over the few elements that this matters for. To count
/// whole elements by their centres will not do: of packed ones, which stand in rings themselves,
/// narrow rings would be more than full by turns.
fn disc_within(distance: f64, radius: f64, edge: f64) -> f64 {
    let (d, r, e) = (distance, radius, edge);
    if d >= r + e {
        return 0.0;
    }
    if d <= (r - e).abs() {
        return PI * r.min(e) * r.min(e);
    }
    let sector = |a: f64, b: f64| {
        let cosine = (d * d + a * a - b * b) / (2.0 * d * a);
        a * a * libm::acos(cosine.clamp(-1.0, 1.0))
    };
    let kite = (r + e - d) * (d + r - e) * (d - r + e) * (d + r + e);
    sector(r, e) + sector(e, r) - 0.5 * kite.max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::Space;

    #[test]
    fn discs_have_in_common_what_a_fine_grid_says() {
        let step = 1.0 / 512.0;
        for (d, r, e) in [
            (1.5, 1.0, 1.0),
            (0.4, 1.0, 1.0),
            (2.0, 1.0, 2.2),
            (1.2, 0.5, 1.4),
            (0.2, 1.0, 0.3),
            (0.1, 0.3, 2.0),
            (3.0, 1.0, 1.5),
        ] {
            let at = |k: i32| (f64::from(k) + 0.5) * step;
            let places = (-600..600).flat_map(|i| (-600..600).map(move |j| (at(i), at(j))));
            let both = places.filter(|&(x, y)| x.hypot(y) < r && (x + d).hypot(y) < e);
            let expected = both.count() as f64 * step * step;
            let found = disc_within(d, r, e);
            assert!((found - expected).abs() < 2e-3, "{found}, not {expected}");
        }
    }

    #[test]
    fn there_is_none_where_no_ground_is_known_or_all_is_in_one_place() {
        struct Plain;
        impl Metric for Plain {
            fn distances(&self, _: usize, _: f64) -> Vec<f64> {
                vec![0.0]
            }
            fn ring_areas(&self, _: usize, _: f64, _: usize) -> Option<Vec<f64>> {
                Some(vec![1.0])
            }
        }
        let positions = [[0.0; 3], [2.0, 0.0, 0.0]];
        assert!(profile(1.0, &Space::new(&positions)).is_empty());
        assert!(profile(1.0, &Plain).is_empty());
    }
}
