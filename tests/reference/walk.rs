//! Straight lines on the surface, by unfolding one triangle after the other.

use super::mesh::{Edge, Mesh, Place};
use glam::DVec2;

/// A line that crosses more triangles than this is a bug, not a long walk.
const MOST_CROSSINGS: usize = 1_000_000;

/// Crossings keep this share of an edge's length away from its ends: a line that hits a vertex exactly passes beside
/// it, always on the same side.
const NUDGE: f64 = 1e-9;

/// The part of a line inside one triangle, in that triangle's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    pub(crate) triangle: usize,
    pub(crate) from: DVec2,
    /// Unit vector.
    pub(crate) direction: DVec2,
    pub(crate) length: f64,
}

impl Piece {
    /// The place `t` along the piece.
    pub(crate) fn place(&self, t: f64) -> Place {
        Place {
            triangle: self.triangle,
            at: self.from + self.direction * t,
        }
    }
}

/// Where the line of these pieces ends.
pub(crate) fn end(pieces: &[Piece]) -> Place {
    let last = pieces.last().expect("a line has a piece");
    last.place(last.length)
}

/// The straight line of `length` from `start` along the unit vector `direction` of the start's frame. Edges without a
/// neighbour reflect it.
pub(crate) fn trace(mesh: &Mesh, start: Place, direction: DVec2, length: f64) -> Vec<Piece> {
    let mut pieces = Vec::new();
    let (mut place, mut direction, mut left) = (start, direction, length);
    let mut entered = None;
    for _ in 0..MOST_CROSSINGS {
        let exit = first_exit(mesh, place, direction, entered);
        let run = exit.map_or(left, |(_, run)| run.min(left));
        pieces.push(Piece {
            triangle: place.triangle,
            from: place.at,
            direction,
            length: run,
        });
        match exit {
            Some((k, run)) if run < left => {
                left -= run;
                let at = place.at + direction * run;
                let inside = cross(mesh, Place { at, ..place }, k, direction);
                (place, direction, entered) = (inside.0, inside.1, Some(inside.2));
            }
            _ => return pieces,
        }
    }
    panic!("a line of length {length} from {start:?} never ended");
}

/// The edge through which the line leaves the triangle and how far away that is.
fn first_exit(
    mesh: &Mesh,
    place: Place,
    direction: DVec2,
    entered: Option<usize>,
) -> Option<(usize, f64)> {
    let edges = &mesh.triangles[place.triangle].edges;
    let run = |k: usize| {
        let speed = -direction.dot(edges[k].inward);
        (speed > 0.0).then(|| (k, (edges[k].height(place.at) / speed).max(0.0)))
    };
    let exits = (0..3).filter(|&k| entered != Some(k)).filter_map(run);
    exits.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The rigid motion across edge `k`: the same place and direction in the neighbour's frame, and the edge by which the
/// neighbour was entered. At a boundary the direction is mirrored instead.
fn cross(mesh: &Mesh, place: Place, k: usize, direction: DVec2) -> (Place, DVec2, usize) {
    let edge = &mesh.triangles[place.triangle].edges[k];
    let (triangle, entry) = edge.across.unwrap_or((place.triangle, k));
    let other = &mesh.triangles[triangle].edges[entry];
    let at = on_edge(edge, other, place.at);
    let turned =
        other.along * direction.dot(edge.along) - other.inward * direction.dot(edge.inward);
    (Place { triangle, at }, turned.normalize(), entry)
}

/// The point of `edge` nearest to `at`, expressed in the frame of the same edge's other triangle.
pub(crate) fn on_edge(edge: &Edge, other: &Edge, at: DVec2) -> DVec2 {
    let nudge = NUDGE * edge.length;
    let s = (at - edge.base)
        .dot(edge.along)
        .clamp(nudge, edge.length - nudge);
    other.base + other.along * s
}
