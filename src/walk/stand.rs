//! Where a walker stands, ready for its next step.

use glam::{DVec2, DVec3};

use super::trace::{Absorbing, End, Reflecting, trace_out};
use crate::substrate::{Chart, Substrate, SurfacePoint};

/// A place in a triangle's chart and in space.
///
/// It is a [`SurfacePoint`] in the form that a walk needs: most steps near the lichen stay in one
/// triangle, and then cost a few multiplications.
#[derive(Clone, Copy, Debug)]
pub struct Stand {
    /// The triangle.
    pub triangle: u32,
    /// The place in the triangle's chart.
    pub at: DVec2,
    /// The place in space, local units.
    pub position: DVec3,
}

/// Where a step led.
#[derive(Clone, Copy, Debug)]
pub struct Moved {
    /// The place.
    pub to: Stand,
    /// Why it ended there.
    pub end: End,
    /// Edges crossed.
    pub crossings: u32,
}

impl Stand {
    /// Stands at a point of the surface.
    ///
    /// # Panics
    /// When the substrate has no such triangle.
    #[inline(always)]
    pub fn new(substrate: &Substrate, point: &SurfacePoint) -> Self {
        let [a, b, c] = substrate.charts()[point.triangle as usize].corners();
        let [w0, w1, w2] = point.weights();
        Self::lifted(substrate, point.triangle, a * w0 + b * w1 + c * w2)
    }

    #[inline]
    fn lifted(substrate: &Substrate, triangle: u32, at: DVec2) -> Self {
        Self {
            triangle,
            at,
            position: substrate.frames()[triangle as usize].lift(at),
        }
    }

    /// The point of the surface.
    pub fn surface_point(&self, substrate: &Substrate) -> SurfacePoint {
        let chart: &Chart = &substrate.charts()[self.triangle as usize];
        let [a, b, c] = chart.corners().map(|corner| corner - self.at);
        let weights = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
        SurfacePoint::from_weights(self.triangle, weights)
    }

    /// A straight step, a vector in the triangle's chart.
    #[inline(always)]
    pub fn step(self, substrate: &Substrate, step: DVec2, absorb: bool) -> Moved {
        let there = self.at + step;
        if substrate.charts()[self.triangle as usize].contains(there) {
            return Moved {
                to: Self::lifted(substrate, self.triangle, there),
                end: End::Distance,
                crossings: 0,
            };
        }
        Self::step_across(substrate, self.triangle, self.at, step, absorb)
    }

    #[inline(never)]
    fn step_across(
        substrate: &Substrate,
        triangle: u32,
        at: DVec2,
        step: DVec2,
        absorb: bool,
    ) -> Moved {
        let traced = match absorb {
            true => trace_out(substrate, triangle, at, step, &mut Absorbing),
            false => trace_out(substrate, triangle, at, step, &mut Reflecting),
        };
        let triangle = traced.place.half_edge / 3;
        let at = traced
            .place
            .in_chart(&substrate.charts()[triangle as usize]);
        Moved {
            to: Self::lifted(substrate, triangle, at),
            end: traced.end,
            crossings: traced.crossings,
        }
    }
}
