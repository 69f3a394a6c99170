//! Whether a place is inside another piece of a mesh, by the triangles on lines through it.

use glam::{DVec2, DVec3};

use super::{Component, Pieces, Substrate, SurfacePoint};

/// Directions in which it is tested, both ways, whether a place is inside: parallel to no edge or face that people
/// model.
const LINES: [DVec3; 3] = [
    DVec3::new(0.36, 0.48, 0.8),
    DVec3::new(-0.64, 0.6, -0.48),
    DVec3::new(0.8, -0.36, 0.48),
];

/// A sheet that is not closed is on one side of a place, three ways of the six.
const LEAST_WAYS: usize = 4;

impl Substrate {
    /// Whether a place is inside a solid that a piece of the mesh is, other than that of a triangle, as
    /// [`Solids::hide`](crate::growth::Solids::hide) says.
    pub(crate) fn is_inside_another(&self, than: u32, place: DVec3) -> bool {
        let near = self.piece_tree().map(|pieces| pieces.near(place));
        near.into_iter().flatten().any(|number| {
            let piece = &self.components()[number as usize];
            let [low, high] = piece.bounds;
            let is_within = place.cmpge(low).all() && place.cmple(high).all();
            let is_own = piece.triangles.contains(&than);
            is_within && !is_own && self.ways_out(piece, place) >= LEAST_WAYS
        })
    }

    /// Whether so far above a place of the surface, local units, it is inside another piece.
    pub(crate) fn is_buried(&self, at: &SurfacePoint, height: f64) -> bool {
        if self.piece_tree().is_none() {
            return false;
        }
        let outwards = self.normal(at.triangle) * self.winding().side(at.triangle);
        self.is_inside_another(at.triangle, self.position(at) + height * outwards)
    }

    /// None where there is but one. It is made on several threads: outside of the cell, which a thread that waits for
    /// the others may come to again.
    pub(crate) fn piece_tree(&self) -> Option<&Pieces> {
        if let Some(found) = self.piece_tree.get() {
            return found.as_ref();
        }
        let all = self.components();
        let found = (all.len() > 1).then(|| Pieces::new(all));
        self.piece_tree.get_or_init(|| found).as_ref()
    }

    /// Along how many ways a piece is left once more often than it is entered.
    fn ways_out(&self, piece: &Component, place: DVec3) -> usize {
        let along = |line: DVec3| {
            let near = self.triangles_near_line(place, line, &piece.triangles);
            let mut surplus = [0, 0];
            for t in near {
                if let Some((height, _)) = self.plumb(t, place, line) {
                    let is_ahead = height > place.dot(line);
                    let leaves = (self.normal(t).dot(line) > 0.0) == is_ahead;
                    surplus[usize::from(is_ahead)] += if leaves { 1 } else { -1 };
                }
            }
            surplus.iter().filter(|surplus| **surplus > 0).count()
        };
        LINES.into_iter().map(along).sum()
    }

    /// Height at which a line along `up` through a point meets a triangle, and where.
    pub(crate) fn plumb(
        &self,
        triangle: u32,
        through: DVec3,
        up: DVec3,
    ) -> Option<(f64, SurfacePoint)> {
        let across = up.any_orthonormal_pair();
        let flat = |p: DVec3| DVec2::new((p - through).dot(across.0), (p - through).dot(across.1));
        let corners = self.corners(triangle);
        let [a, b, c] = corners.map(flat);
        let weights = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
        let sum: f64 = weights.iter().sum();
        let inside = sum != 0.0 && weights.iter().all(|w| w * sum >= 0.0);
        let at = SurfacePoint::from_weights(triangle, weights.map(|w| w / sum));
        inside.then(|| (self.position(&at).dot(up), at))
    }
}
