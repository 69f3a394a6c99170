//! Mean squared distance to a set of planes (Garland & Heckbert 1997, section 4).

use std::ops::AddAssign;

use glam::DVec3;

/// Weighted planes; asked for the sum of the squared distances from a point to them.
///
/// Points are counted from a centre that the owner knows, a vertex of the mesh: far from the
/// origin the sums would cancel. The sum at x is x·Ax + 2 b·x + c.
#[derive(Clone, Copy, Default)]
pub(super) struct Quadric {
    /// A's diagonal.
    diagonal: DVec3,
    /// A's yz, zx and xy.
    mixed: DVec3,
    b: DVec3,
    c: f64,
    weight: f64,
}

/// The square of a length by which a normal cannot be divided.
const NO_LENGTH_SQ: f64 = 1e-300;

impl Quadric {
    /// Adds a plane through the centre, from a normal and the square of how long that is; nothing where that is next to
    /// nothing.
    pub(super) fn add_plane(&mut self, normal: DVec3, length_sq: f64, weight: f64) {
        if length_sq > NO_LENGTH_SQ {
            let DVec3 { x, y, z } = normal;
            let share = weight / length_sq;
            self.diagonal += normal * normal * share;
            self.mixed += DVec3::new(y * z, z * x, x * y) * share;
            self.weight += weight;
        }
    }

    /// The same planes with weights that sum to one.
    pub(super) fn mean(&self) -> Self {
        let share = 1.0 / self.weight;
        Self {
            diagonal: self.diagonal * share,
            mixed: self.mixed * share,
            b: self.b * share,
            c: self.c * share,
            weight: 1.0,
        }
    }

    /// Sum of the squared distances of a point to the planes.
    pub(super) fn error_sq(&self, x: DVec3) -> f64 {
        let sum = (self.a_times(x) + 2.0 * self.b).dot(x) + self.c;
        // Round-off may leave less than zero; f64::max may return either of two zeros.
        if sum > 0.0 { sum } else { 0.0 }
    }

    /// The same planes, counted from another centre.
    pub(super) fn about(mut self, centre: DVec3) -> Self {
        let a_centre = self.a_times(centre);
        self.c += (a_centre + 2.0 * self.b).dot(centre);
        self.b += a_centre;
        self
    }

    fn a_times(&self, x: DVec3) -> DVec3 {
        let m = self.mixed;
        let across = DVec3::new(
            m.z * x.y + m.y * x.z,
            m.z * x.x + m.x * x.z,
            m.y * x.x + m.x * x.y,
        );
        self.diagonal * x + across
    }
}

impl AddAssign for Quadric {
    fn add_assign(&mut self, other: Self) {
        self.diagonal += other.diagonal;
        self.mixed += other.mixed;
        self.b += other.b;
        self.c += other.c;
        self.weight += other.weight;
    }
}
