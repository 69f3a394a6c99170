//! Where a walker stands, ready for its next step.

use glam::{DVec2, DVec3};

use super::trace::{Absorbing, End, Reflecting, trace_out};
use crate::substrate::{Facet, Substrate, SurfacePoint, Unscaled};

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

/// Where a walker stands, and its triangle's facet: for who goes on from there at once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Footing {
    pub(crate) stand: Stand,
    pub(crate) facet: Facet,
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

impl Footing {
    /// At a place in a facet's chart.
    #[inline(always)]
    pub(crate) fn new(facet: Facet, at: DVec2) -> Self {
        let stand = Stand::at(&facet, at);
        Self { stand, facet }
    }

    /// At a place on a triangle as it lies flat.
    #[inline(always)]
    pub(crate) fn on(triangle: &Unscaled, at: DVec2) -> Self {
        let facet = triangle.scaled();
        let stand = Stand {
            triangle: facet.triangle,
            at: at * facet.chart.base,
            position: triangle.lift(at),
        };
        Self { stand, facet }
    }

    #[inline(always)]
    pub(crate) fn of(stand: Stand, substrate: &Substrate) -> Self {
        let facet = substrate.facet(stand.triangle);
        Self { stand, facet }
    }

    /// After a straight step, a vector in its chart; open edges reflect it.
    #[inline(always)]
    pub(crate) fn after(&self, substrate: &Substrate, step: DVec2) -> Self {
        let mut facet = self.facet;
        let moved = self.stand.step_from(substrate, &mut facet, step, false);
        Self {
            stand: moved.to,
            facet,
        }
    }
}

impl Stand {
    /// Stands at a point of the surface.
    ///
    /// # Panics
    /// When the substrate has no such triangle.
    #[inline(always)]
    pub fn new(substrate: &Substrate, point: &SurfacePoint) -> Self {
        let facet = substrate.facet(point.triangle);
        Self::at(&facet, facet.chart.place(point.weights()))
    }

    /// Stands at a place in a facet's chart.
    #[inline(always)]
    fn at(facet: &Facet, at: DVec2) -> Self {
        Self {
            triangle: facet.triangle,
            at,
            position: facet.frame.lift(at),
        }
    }

    /// The point of the surface.
    pub fn surface_point(&self, substrate: &Substrate) -> SurfacePoint {
        let chart = substrate.facet(self.triangle).chart;
        let [a, b, c] = chart.corners().map(|corner| corner - self.at);
        let weights = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
        SurfacePoint::from_weights(self.triangle, weights)
    }

    /// A straight step, a vector in the triangle's chart.
    #[inline(always)]
    pub fn step(self, substrate: &Substrate, step: DVec2, absorb: bool) -> Moved {
        let mut facet = substrate.facet(self.triangle);
        self.step_from(substrate, &mut facet, step, absorb)
    }

    /// The same for whoever has the facet of the triangle on this substrate at hand, and then has that of the triangle
    /// where it led.
    #[inline(always)]
    pub(crate) fn step_from(
        self,
        substrate: &Substrate,
        facet: &mut Facet,
        step: DVec2,
        absorb: bool,
    ) -> Moved {
        debug_assert_eq!(facet.triangle, self.triangle);
        let there = self.at + step;
        if facet.chart.contains(there) {
            return Moved {
                to: Self::at(facet, there),
                end: End::Distance,
                crossings: 0,
            };
        }
        Self::step_across(substrate, facet, (self.triangle, self.at), step, absorb)
    }

    #[inline(never)]
    fn step_across(
        substrate: &Substrate,
        facet: &mut Facet,
        (triangle, at): (u32, DVec2),
        step: DVec2,
        absorb: bool,
    ) -> Moved {
        let from = (triangle, &facet.chart, at);
        let traced = match absorb {
            true => trace_out(substrate, from, step, &mut Absorbing),
            false => trace_out(substrate, from, step, &mut Reflecting),
        };
        let triangle = traced.place.half_edge / 3;
        let unscaled = substrate.unscaled(triangle);
        let at = traced.place.on(&unscaled);
        let there = Footing::on(&unscaled, at);
        *facet = there.facet;
        Moved {
            to: there.stand,
            end: traced.end,
            crossings: traced.crossings,
        }
    }
}
