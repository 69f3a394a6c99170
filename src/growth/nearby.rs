//! Elements that were found about a place, for what is asked next about smaller balls near there.

use glam::DVec3;

use super::Surroundings;
use crate::cluster::ElementIndex;
use crate::walk::Ball;

/// The elements in a ball. Nothing may be born while it is used.
#[derive(Default)]
pub(super) struct Nearby {
    ball: Option<Ball>,
    /// Their ids and places.
    all: Vec<(u32, DVec3)>,
}

/// There mostly are no more of them.
const USUAL: usize = 96;

/// What rounding may add to distances, as a share.
const ROUNDED: f64 = 1e-9;

impl Nearby {
    /// Begins anew: all in this ball are going to be added.
    pub(super) fn begin(&mut self, ball: Ball) {
        self.ball = Some(ball);
        self.all.clear();
        self.all.reserve(USUAL);
    }

    #[inline]
    pub(super) fn add(&mut self, id: u32, place: DVec3) {
        self.all.push((id, place));
    }

    /// Whether all within a radius of a place are among them.
    fn holds(&self, p: DVec3, radius: f64) -> bool {
        let reach = |ball: &Ball| ball.radius * (1.0 - ROUNDED) - radius;
        self.ball.as_ref().is_some_and(|ball| {
            let reach = reach(ball);
            reach >= 0.0 && p.distance_squared(ball.centre) <= reach * reach
        })
    }
}

impl<I: ElementIndex> Surroundings<'_, I> {
    /// Visits every element with its centre nearer than `radius` to a place, as [`within`](Self::within) does, but
    /// those that were found before where they are all.
    pub(super) fn within_found(
        &self,
        nearby: &Nearby,
        (p, radius): (DVec3, f64),
        mut visit: impl FnMut(u32, DVec3),
    ) {
        if !nearby.holds(p, radius) {
            return self.within(p, radius, &mut |id, element| visit(id, element.position));
        }
        for &(id, place) in &nearby.all {
            if place.distance_squared(p) < radius * radius {
                visit(id, place);
            }
        }
    }
}
