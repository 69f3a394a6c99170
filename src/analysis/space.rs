//! Distances straight through space, many at a time.

use glam::DVec3;

use super::mass::{Metric, Rings};
use crate::substrate::along_curve;

/// Straight through space.
///
/// Elements are kept along a curve that fills space, and every eight in a row, eight times eight and
/// so on have a ball about them. What lies in one ring as a whole is counted as a whole.
pub struct Space<'a> {
    positions: &'a [[f64; 3]],
    /// Along the curve.
    places: Vec<DVec3>,
    /// About 8, 64, 512 … of them.
    balls: Vec<Vec<Ball>>,
}

impl std::fmt::Debug for Space<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Space").finish_non_exhaustive()
    }
}

struct Ball {
    centre: DVec3,
    radius: f64,
}

/// Balls in a ball.
const FAN: usize = 8;

/// Far above the round-off of a distance, in shares of it.
const SLACK: f64 = 1e-12;

impl<'a> Space<'a> {
    /// Between these places.
    pub fn new(positions: &'a [[f64; 3]]) -> Self {
        let places = in_order(positions);
        let sizes = std::iter::successors(Some(FAN), |size| Some(size * FAN));
        // Up to one that holds all.
        let needed = sizes.take_while(|&size| size <= FAN * places.len());
        let balls = needed.map(|size| places.chunks(size).map(Ball::about).collect());
        Self {
            positions,
            balls: balls.collect(),
            places,
        }
    }

    /// Counts the elements in a ball by their distance from a place.
    fn count(&self, [level, ball]: [usize; 2], from: DVec3, rings: &mut Rings<'_>) {
        let size = FAN.pow(level as u32 + 1);
        let all = ball * size..self.places.len().min((ball + 1) * size);
        let [nearest, farthest] = self.balls[level][ball].distances(from);
        if rings.add(nearest, farthest, all.len() as u64) {
            return;
        }
        if level == 0 {
            for place in &self.places[all] {
                let distance = place.distance(from);
                rings.add(distance, distance, 1);
            }
            return;
        }
        let smaller = FAN * ball..self.balls[level - 1].len().min(FAN * (ball + 1));
        smaller.for_each(|ball| self.count([level - 1, ball], from, rings));
    }
}

impl Metric for Space<'_> {
    fn distances(&self, from: usize, _: f64) -> Vec<f64> {
        let from = DVec3::from(self.positions[from]);
        let distance = |&p: &[f64; 3]| DVec3::from(p).distance(from);
        self.positions.iter().map(distance).collect()
    }

    fn within(&self, from: usize, radii: &[f64]) -> Vec<u64> {
        let mut rings = Rings::new(radii);
        if let Some(level) = self.balls.len().checked_sub(1) {
            self.count([level, 0], self.positions[from].into(), &mut rings);
        }
        rings.within()
    }
}

impl Ball {
    fn about(places: &[DVec3]) -> Self {
        let [low, high] = bounds(places.iter().copied());
        let centre = 0.5 * (low + high);
        let from_centre = places.iter().map(|p| p.distance(centre));
        Self {
            centre,
            radius: from_centre.fold(0.0, f64::max),
        }
    }

    /// Bounds on the distances from a place to what is in the ball.
    fn distances(&self, from: DVec3) -> [f64; 2] {
        let middle = self.centre.distance(from);
        let slack = SLACK * (middle + self.radius);
        let nearest = (middle - self.radius - slack).max(0.0);
        [nearest, middle + self.radius + slack]
    }
}

/// Places along a curve that fills space: those near each other mostly are near in that order too.
pub(super) fn in_order(positions: &[[f64; 3]]) -> Vec<DVec3> {
    let place = |i: usize| DVec3::from(positions[i]);
    let bounds = bounds((0..positions.len()).map(place));
    let order = along_curve(bounds, positions.len(), place);
    order.into_iter().map(|i| place(i as usize)).collect()
}

fn bounds(places: impl Iterator<Item = DVec3>) -> [DVec3; 2] {
    places.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| {
        [low.min(p), high.max(p)]
    })
}

#[cfg(test)]
mod tests {
    use super::super::mass::ladder;
    use super::*;

    /// Scattered, in a row, in one place, and on a lattice whose distances are the radii.
    fn crowds() -> [Vec<[f64; 3]>; 4] {
        let at = |i: u32| {
            let t = f64::from(i);
            [(t * 0.7).sin(), (t * 1.3).cos(), 0.1 * (t * 0.37).sin()]
        };
        let lattice = |i: u32| [f64::from(i % 40) * 0.1, f64::from(i / 40) * 0.1, 0.0];
        [
            (0..1500).map(at).collect(),
            (0..700).map(|i| [f64::from(i) * 0.01, 0.0, 0.0]).collect(),
            vec![[7.0; 3]; 130],
            (0..1600).map(lattice).collect(),
        ]
    }

    #[test]
    fn counts_are_those_of_all_distances() {
        struct OneByOne<'a>(Space<'a>);
        impl Metric for OneByOne<'_> {
            fn distances(&self, from: usize, limit: f64) -> Vec<f64> {
                self.0.distances(from, limit)
            }
        }
        for crowd in crowds() {
            for n in [1, 7, 8, 9, 64, 65, crowd.len()] {
                let crowd = &crowd[..n.min(crowd.len())];
                let (space, plain) = (Space::new(crowd), OneByOne(Space::new(crowd)));
                for from in (0..crowd.len()).step_by(31) {
                    for radii in [ladder(0.05, 3.0), vec![0.1, 0.2, 0.3, 1.0], Vec::new()] {
                        let counts = space.within(from, &radii);
                        assert_eq!(counts, plain.within(from, &radii), "{from} of {n}");
                    }
                }
            }
        }
    }
}
