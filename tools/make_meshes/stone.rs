//! The convex body that the rock and the boulder start from: an ellipsoid whose sides were worn flat.

use glam::DVec3;

/// A plane that cuts the stone: its direction (any length) and its distance from the centre.
pub(crate) type Face = ([f64; 3], f64);

/// A soft intersection of an ellipsoid with half-spaces: the unit ball of the p-norm of their gauges, p = 2^`hardness`.
pub(crate) struct Stone {
    half_axes: DVec3,
    faces: Vec<(DVec3, f64)>,
    hardness: u32,
}

impl Stone {
    pub(crate) fn new(half_axes: DVec3, faces: &[Face], hardness: u32) -> Self {
        let faces = faces
            .iter()
            .map(|&(n, h)| (DVec3::from_array(n).normalize(), h))
            .collect();
        Self {
            half_axes,
            faces,
            hardness,
        }
    }

    /// The distance from the centre to the surface in the unit direction `d`.
    pub(crate) fn radius(&self, d: DVec3) -> f64 {
        let ball = (d / self.half_axes).length();
        let gauges = self.faces.iter().map(|&(n, h)| (d.dot(n) / h).max(0.0));
        let sum: f64 = std::iter::once(ball)
            .chain(gauges)
            .map(|g| self.power(g))
            .sum();
        1.0 / (0..self.hardness).fold(sum, |s, _| s.sqrt())
    }

    fn power(&self, g: f64) -> f64 {
        (0..self.hardness).fold(g, |x, _| x * x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stone_is_cut_by_its_faces_and_lies_within_its_ellipsoid() {
        let stone = Stone::new(DVec3::new(2.0, 1.0, 1.0), &[([1.0, 0.0, 0.0], 0.5)], 5);
        assert!((stone.radius(DVec3::X) - 0.5).abs() < 1e-9);
        assert!((stone.radius(-DVec3::X) - 2.0).abs() < 1e-9);
        assert!((stone.radius(DVec3::Y) - 1.0).abs() < 1e-9);
    }
}
