//! Another lichen on the same surface, which leaves no room where its elements are.

use std::cell::Cell;

use glam::DVec3;

use super::bvh::{Bvh, box_distance_sq};
use super::order::along_curve;

/// The elements of another lichen, local units.
pub(super) struct Neighbour {
    /// Where they are, along a curve.
    places: Vec<DVec3>,
    radius: f64,
    tree: Bvh,
}

impl Neighbour {
    pub(super) fn new(places: &[DVec3], radius: f64) -> Self {
        let bounds = places.iter().fold(
            [DVec3::INFINITY, DVec3::NEG_INFINITY],
            |[low, high], place| [low.min(*place), high.max(*place)],
        );
        let order = along_curve(bounds, places.len(), |i| places[i]);
        let places: Vec<DVec3> = order.iter().map(|&i| places[i as usize]).collect();
        Self {
            tree: Bvh::of_places(&places),
            places,
            radius,
        }
    }

    /// Whether an element of this radius would overlap none of them here.
    pub(super) fn leaves_room(&self, here: DVec3, radius: f64) -> bool {
        let apart = self.radius + radius;
        let apart_sq = apart * apart;
        let is_free = Cell::new(true);
        self.tree.visit(
            |about| is_free.get() && box_distance_sq(about, here) < apart_sq,
            |i| {
                if self.places[i as usize].distance_squared(here) < apart_sq {
                    is_free.set(false);
                }
            },
        );
        is_free.get()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    /// Of places in a box, in a plane, all in one place and just one, against a look at each.
    #[test]
    fn room_is_where_no_element_is_near() {
        let mut stream = Stream::new(3, Purpose::Walker, 0);
        let mut place = |spread: DVec3| {
            let numbers = [(); 3].map(|()| stream.uniform() - 0.5);
            spread * DVec3::from(numbers)
        };
        let spreads = [DVec3::ONE, DVec3::new(1.0, 1.0, 0.0), DVec3::ZERO];
        for (spread, count) in [(0, 700), (1, 700), (2, 50), (0, 1)] {
            let places: Vec<DVec3> = (0..count).map(|_| place(spreads[spread])).collect();
            let lichen = Neighbour::new(&places, 0.03);
            let mut free = [0, 0];
            for radius in [0.001, 0.03, 0.2] {
                for _ in 0..300 {
                    let here = place(DVec3::splat(1.2));
                    let is_near = |other: &DVec3| other.distance(here) < 0.03 + radius;
                    let is_free = !places.iter().any(is_near);
                    assert_eq!(lichen.leaves_room(here, radius), is_free);
                    free[usize::from(is_free)] += 1;
                }
            }
            assert!(free.iter().all(|&n| n > 5), "{free:?}");
        }
    }
}
