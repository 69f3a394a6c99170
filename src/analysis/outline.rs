//! The outline of a lichen: how long it is, and how much it holds.

use std::f64::consts::{PI, TAU};

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
    /// 4π·area/length² (Cox 1927): 1 for a disc, less for anything else. None without an edge.
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

/// Directions in which a cell is measured. They start elsewhere at each element, so that the
/// errors of a lattice do not add up.
const DIRECTIONS: usize = 32;

/// Area of the part of an element's disc that is nearer to it than to any other.
fn cell(neighbours: &Neighbours, of: usize) -> f64 {
    let normal = neighbours.normal(of).as_dvec3();
    let (x, y) = normal.normalize_or(DVec3::Z).any_orthonormal_pair();
    let mut ways = Vec::new();
    neighbours.visit(of, |_, way, distance| {
        if distance > 0.0 {
            ways.push((DVec2::new(way.dot(x), way.dot(y)), way.length_squared()));
        }
    });
    let directions = directions(of);
    let mut reach = [0.5 * neighbours.within(); DIRECTIONS];
    for (way, square) in ways {
        for (reach, direction) in reach.iter_mut().zip(&directions) {
            let along = way.dot(*direction);
            let bisector = square / (2.0 * along);
            let is_nearer = along > 0.0 && bisector < *reach;
            *reach = if is_nearer { bisector } else { *reach };
        }
    }
    let squares = reach.iter().map(|reach| reach * reach);
    squares.sum::<f64>() * PI / DIRECTIONS as f64
}

fn directions(of: usize) -> [DVec2; DIRECTIONS] {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let turn = (of as f64 * GOLDEN).fract();
    std::array::from_fn(|k| {
        let (y, x) = libm::sincos(TAU * (k as f64 + turn) / DIRECTIONS as f64);
        DVec2::new(x, y)
    })
}
