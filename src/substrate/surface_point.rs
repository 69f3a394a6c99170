//! The one way to say where something is on the substrate.

/// A place on the surface: a triangle, and barycentric weights in its own plane.
///
/// The point is (1 − u − v)·P₀ + u·P₁ + v·P₂ for corners P₀, P₁, P₂ of the triangle as the
/// substrate numbers them; u, v and 1 − u − v lie in [0, 1] up to round-off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The triangle's number in the substrate. Tables and files have another, the
    /// [canonical one](super::Substrate::canonical_triangle); [`Substrate::triangle_of_canonical`] goes back.
    ///
    /// [`Substrate::triangle_of_canonical`]: super::Substrate::triangle_of_canonical
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

    /// From the weights of the three corners, which are clamped to the triangle: the centroid where none is positive,
    /// infinite ones above all others.
    pub fn from_weights(triangle: u32, weights: [f64; 3]) -> Self {
        let [w0, w1, w2] = weights.map(|w| w.max(0.0));
        let sum = w0 + w1 + w2;
        if !(sum > 0.0 && sum < f64::INFINITY) {
            return Self::from_odd_weights(triangle, [w0, w1, w2]);
        }
        Self {
            triangle,
            u: w1 / sum,
            v: w2 / sum,
        }
    }

    /// From weights whose sum is 0 or no number.
    #[cold]
    fn from_odd_weights(triangle: u32, weights: [f64; 3]) -> Self {
        let largest = weights.into_iter().fold(0.0, f64::max);
        let beside_largest = |w: f64| match largest.is_infinite() {
            true => f64::from(w == largest),
            false => w / largest,
        };
        match largest > 0.0 {
            true => Self::from_weights(triangle, weights.map(beside_largest)),
            false => Self::centroid(triangle),
        }
    }

    /// The weights of the three corners.
    pub fn weights(&self) -> [f64; 3] {
        [1.0 - self.u - self.v, self.u, self.v]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_weights_are_of_a_place_in_the_triangle() {
        let (most, far, none) = (f64::MAX, f64::INFINITY, f64::NAN);
        let third = 1.0 / 3.0;
        for (weights, [u, v]) in [
            ([0.0, 2.0, 2.0], [0.5, 0.5]),
            ([-1.0, 1.0, 3.0], [0.25, 0.75]),
            ([none, 1.0, 3.0], [0.25, 0.75]),
            ([0.0; 3], [third; 2]),
            ([-1.0, none, -far], [third; 2]),
            ([most; 3], [third; 2]),
            ([most, 0.0, most], [0.0, 0.5]),
            ([1.0, far, 1.0], [1.0, 0.0]),
            ([1.0, far, far], [0.5, 0.5]),
        ] {
            let found = SurfacePoint::from_weights(0, weights);
            let off = (found.u - u).abs().max((found.v - v).abs());
            assert!(off < 1e-15, "{weights:?}: {found:?}");
        }
    }
}
