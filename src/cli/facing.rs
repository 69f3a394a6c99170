//! Warnings about the side that faces look to: lichen stands on that.

use std::f64::consts::PI;

use glam::DVec3;
use thallus::substrate::{Component, Substrate};

use super::number::{place, plural};

/// Pieces that are looked at: of a mesh in crumbs the largest.
const MOST_PIECES: usize = 1000;

/// A closed piece holds less than this share of what a ball of its area does only where it is as good as flat.
const FLAT: f64 = 1e-6;

/// An open one that holds more than this share, and whose openings are less than that share of its area, is a shell
/// with a side that is inside.
const DEEP: f64 = 0.1;
const MOST_OPEN: f64 = 0.6;

/// Share of its area that a piece is wide, seen from below, if it looks down.
const DOWN: f64 = 0.5;

/// Share of the mesh's area that a piece has whose outlook matters: of loose cards one looks down for each that looks
/// up.
const MUCH: f64 = 0.2;

const CURE: &str =
    "turn them (in Blender: Edit Mode, Mesh, Normals, Recalculate Outside) and export it again";

/// Where the faces of one piece look, local units.
struct Facing {
    /// What lies behind them, the openings being closed from the middle of their edges.
    volume: f64,
    /// The sum of their normals, each times its area.
    outlook: DVec3,
    /// Area of what closes the openings.
    open: f64,
}

impl Facing {
    fn of(substrate: &Substrate, piece: &Component) -> Self {
        let ends = |h: u32| {
            let corners = substrate.corners(h / 3);
            let k = h as usize % 3;
            [corners[k], corners[(k + 1) % 3]]
        };
        let report = substrate.report();
        let half_edges = match report.boundary_edges + report.non_manifold_edges {
            0 => 0..0,
            _ => 3 * piece.triangles.start..3 * piece.triangles.end,
        };
        let is_open = |h: &u32| substrate.twin(*h).half_edge() == *h;
        let rim: Vec<[DVec3; 2]> = half_edges.filter(is_open).map(ends).collect();
        let middle = middle(&rim).unwrap_or_else(|| substrate.corners(piece.triangles.start)[0]);
        let mut found = Self {
            volume: 0.0,
            outlook: DVec3::ZERO,
            open: 0.0,
        };
        for t in piece.triangles.clone() {
            let [a, b, c] = substrate.corners(t);
            let outlook = substrate.area_vector(t);
            let centre = (a + b + c) / 3.0;
            found.volume += outlook.dot(centre - middle) / 3.0;
            found.outlook += outlook;
        }
        let closing = rim.iter().map(|[a, b]| (a - middle).cross(b - middle));
        found.open = closing.map(|cross| cross.length() / 2.0).sum();
        found
    }

    /// Whether the faces look to what is inside of them.
    fn is_inwards(&self, piece: &Component) -> bool {
        let ball = piece.area.powf(1.5) / (6.0 * PI.sqrt());
        let least = match self.open > 0.0 {
            true => DEEP,
            false => FLAT,
        };
        self.open < MOST_OPEN * piece.area && self.volume < -least * ball
    }
}

/// The mean of these lines, each by its length.
fn middle(lines: &[[DVec3; 2]]) -> Option<DVec3> {
    let weighted = lines.iter().map(|[a, b]| {
        let length = a.distance(*b);
        (length * a.midpoint(*b), length)
    });
    let sum = |(p, length): (DVec3, f64), (q, more)| (p + q, length + more);
    let (sum, length) = weighted.fold((DVec3::ZERO, 0.0), sum);
    (length > 0.0).then(|| sum / length)
}

/// What is wrong with the side that the largest piece's faces look to, and with that of the others.
pub(super) fn warnings(substrate: &Substrate) -> [Option<String>; 2] {
    [of_largest(substrate), of_others(substrate)]
}

fn of_largest(substrate: &Substrate) -> Option<String> {
    let piece = substrate.components().first()?;
    let facing = Facing::of(substrate, piece);
    let down = -facing.outlook.dot(substrate.up_axis().direction());
    if facing.is_inwards(piece) {
        return Some(match facing.open > 0.0 {
            true => format!(
                "as far as it is closed its faces look inwards, so lichen would stand inside it; unless it is a room or \
                 a hollow, {CURE}"
            ),
            false => format!(
                "its faces look inwards, so lichen would stand inside it, where no picture shows it; {CURE}"
            ),
        });
    }
    let all: f64 = substrate.components().iter().map(|piece| piece.area).sum();
    let is_much = piece.area > MUCH * all;
    (is_much && facing.open > 0.0 && down > DOWN * piece.area).then(|| {
        "its faces look down, so lichen would hang below it; turn them (in Blender: Edit Mode, Mesh, Normals, Flip) and \
         export it again, unless it is a ceiling"
            .to_owned()
    })
}

/// Of closed pieces that are in the box of a larger one nothing is said: they may be hollows, which are wound inwards
/// rightly.
fn of_others(substrate: &Substrate) -> Option<String> {
    let all = substrate.components();
    let all = &all[..all.len().min(MOST_PIECES)];
    let is_within = |piece: &Component, of: &Component| {
        let [[low, high], [lowest, highest]] = [piece.bounds, of.bounds];
        low.cmpge(lowest).all() && high.cmple(highest).all()
    };
    let turned = |&n: &usize| {
        let facing = Facing::of(substrate, &all[n]);
        facing.open == 0.0
            && facing.is_inwards(&all[n])
            && !all[..n].iter().any(|larger| is_within(&all[n], larger))
    };
    let turned: Vec<usize> = (1..all.len()).filter(turned).collect();
    let [low, high] = all[*turned.first()?].bounds;
    let pieces = plural(turned.len(), "smaller piece", "smaller pieces");
    let near = place(substrate.units().to_file(low.midpoint(high)).to_array());
    Some(format!(
        "the faces of {pieces} look inwards (near {near}), so lichen there would stand inside; {CURE}"
    ))
}
