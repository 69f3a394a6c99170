//! The one way to say where something is on the substrate.

/// A place on the surface: a triangle, and barycentric weights in its own plane.
///
/// The point is (1 − u − v)·P₀ + u·P₁ + v·P₂ for corners P₀, P₁, P₂ of the triangle as the
/// substrate numbers them; u, v and 1 − u − v lie in [0, 1] up to round-off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The triangle's number in the substrate. Tables and files have another, the
    /// [canonical one](super::Substrate::canonical_triangle); [`Substrate::from_canonical`] goes back.
    ///
    /// [`Substrate::from_canonical`]: super::Substrate::from_canonical
    pub triangle: u32,
    /// Weight of the second corner.
    pub u: f64,
    /// Weight of the third corner.
    pub v: f64,
}

impl SurfacePoint {
    /// The centroid of a triangle.
    pub fn centroid(triangle: u32) -> Self {
        Self {
            triangle,
            u: 1.0 / 3.0,
            v: 1.0 / 3.0,
        }
    }

    /// From the weights of the three corners, which are clamped to the triangle.
    pub fn from_weights(triangle: u32, weights: [f64; 3]) -> Self {
        let [w0, w1, w2] = weights.map(|w| w.max(0.0));
        let sum = w0 + w1 + w2;
        Self {
            triangle,
            u: w1 / sum,
            v: w2 / sum,
        }
    }

    /// The weights of the three corners.
    pub fn weights(&self) -> [f64; 3] {
        [1.0 - self.u - self.v, self.u, self.v]
    }
}
