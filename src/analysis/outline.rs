//! The outline of a lichen: how long it is, and how much it holds.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use serde::Serialize;

use crate::morphometry::{Neighbours, exposed_angles};

/// The union of discs of half of [`LOOK`](super::LOOK) about the centres, which closes gaps narrower than
/// that. Both measures are of the tangent planes: where the surface curves within that distance they
/// are approximations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Outline {
    /// Length of its edge, that of holes included.
    pub length: f64,
    /// Its area.
    pub area: f64,
    /// 4π·area/length² (Cox 1927): 1 for a flat disc, and less for anything else that is flat. None without an edge.
    pub circularity: Option<f64>,
}

impl Outline {
    /// The discs' radius is half the neighbours' distance.
    pub(super) fn new(neighbours: &Neighbours) -> Self {
        let radius = 0.5 * neighbours.within();
        let length = radius * exposed_angles(neighbours).iter().sum::<f64>();
        let area = neighbours.map(|i| cell(neighbours, i)).iter().sum();
        let circularity = 4.0 * PI * area / (length * length);
        Self {
            length,
            area,
            circularity: (length > 0.0).then_some(circularity),
        }
    }
}

/// Area of the part of an element's disc that is nearer to it than to any other, where others are by the same
/// directions and distances as for the rim.
fn cell(neighbours: &Neighbours, of: usize) -> f64 {
    let normal = neighbours.normal(of).as_dvec3();
    let (x, y) = normal.normalize_or(DVec3::Z).any_orthonormal_pair();
    let mut cell = Cell::new(0.5 * neighbours.within());
    neighbours.visit(of, |_, way, distance| {
        if distance > 0.0 {
            let direction = DVec2::new(way.dot(x), way.dot(y)).normalize_or_zero();
            cell.cut(direction, 0.5 * way.length());
        }
    });
    cell.area()
}

/// The part of a disc about the origin that lies within a convex polygon about it.
struct Cell {
    radius: f64,
    /// Anticlockwise.
    corners: Vec<DVec2>,
    spare: Vec<DVec2>,
}

impl Cell {
    /// The whole disc.
    fn new(radius: f64) -> Self {
        let far = 2.0 * radius;
        let corners = [(far, far), (-far, far), (-far, -far), (far, -far)];
        Self {
            radius,
            corners: corners.map(DVec2::from).to_vec(),
            spare: Vec::new(),
        }
    }

    /// Leaves out the points p with p·`way` > `bound`, which is positive (Sutherland and Hodgman 1974).
    fn cut(&mut self, way: DVec2, bound: f64) {
        let beyond = |p: DVec2| p.dot(way) - bound;
        if self.corners.iter().all(|&p| beyond(p) <= 0.0) {
            return;
        }
        self.spare.clear();
        for (from, to) in edges(&self.corners) {
            let (start, end) = (beyond(from), beyond(to));
            if start <= 0.0 {
                self.spare.push(from);
            }
            if (start <= 0.0) != (end <= 0.0) {
                self.spare.push(from.lerp(to, start / (start - end)));
            }
        }
        std::mem::swap(&mut self.corners, &mut self.spare);
    }

    fn area(&self) -> f64 {
        let triangle = |(a, b)| self.triangle(a, b);
        edges(&self.corners).map(triangle).sum()
    }

    /// Area of the disc within the triangle of its middle and an edge: a triangle where the edge runs through
    /// the disc, and a sector on either side.
    fn triangle(&self, a: DVec2, b: DVec2) -> f64 {
        let square = self.radius * self.radius;
        let sector = |a: DVec2, b: DVec2| 0.5 * square * libm::atan2(a.perp_dot(b), a.dot(b));
        let edge = b - a;
        let foot = -a.dot(edge) / edge.length_squared();
        let half_sq = (square - a.lerp(b, foot).length_squared()) / edge.length_squared();
        let half = half_sq.max(0.0).sqrt();
        let (enters, leaves) = ((foot - half).max(0.0), (foot + half).min(1.0));
        if enters < leaves {
            let (p, q) = (a.lerp(b, enters), a.lerp(b, leaves));
            return sector(a, p) + 0.5 * p.perp_dot(q) + sector(q, b);
        }
        sector(a, b)
    }
}

fn edges(corners: &[DVec2]) -> impl Iterator<Item = (DVec2, DVec2)> {
    let next = corners.iter().cycle().skip(1);
    corners.iter().copied().zip(next.copied())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use rand::rngs::SmallRng;
    use rand::{RngExt, SeedableRng};

    /// By columns, in each of which the cell is an interval.
    fn in_columns(radius: f64, cuts: &[(DVec2, f64)]) -> f64 {
        let columns = 20_000;
        let wide = 2.0 * radius / f64::from(columns);
        let column = |i| {
            let x = (f64::from(i) + 0.5) * wide - radius;
            let end = (radius * radius - x * x).sqrt();
            let (mut low, mut high) = (-end, end);
            for &(way, bound) in cuts {
                let at = (bound - way.x * x) / way.y;
                match way.y > 0.0 {
                    true => high = high.min(at),
                    false => low = low.max(at),
                }
            }
            (high - low).max(0.0) * wide
        };
        (0..columns).map(column).sum()
    }

    #[test]
    fn a_cell_has_the_area_of_its_columns() {
        let mut random = SmallRng::seed_from_u64(5);
        let radius = 3.2;
        for round in 0..200 {
            let mut way = || {
                let turn = TAU * random.random::<f64>();
                let long = 0.3 + 6.0 * random.random::<f64>();
                (DVec2::from_angle(turn) * long, 0.5 * long * long)
            };
            let cuts: Vec<_> = (0..round % 9).map(|_| way()).collect();
            let mut cell = Cell::new(radius);
            for &(way, bound) in &cuts {
                cell.cut(way, bound);
            }
            let (found, expected) = (cell.area(), in_columns(radius, &cuts));
            assert!(
                (found - expected).abs() < 1e-4,
                "{cuts:?}: {found}, not {expected}"
            );
        }
    }
}
