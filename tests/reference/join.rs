//! Joining (Sumner 6.4): back to the first touch, then about the touched element to a second one.

use super::cluster::{Cluster, Within};
use super::mesh::{Edge, Mesh, Place, Triangle};
use super::walk::{Piece, end, on_edge};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// An arc about an element that crosses more edges than this goes nowhere.
const MOST_CROSSINGS: usize = 10_000;

/// Angles this close below a full turn are round-off behind the present place.
const BEHIND: f64 = 1e-9;

/// A place nearer than 2r(1 − this) to any element overlaps it.
const OVERLAP: f64 = 1e-9;

/// First place along the line that just touches an element, and that element.
pub(crate) fn first_touch(cluster: &Cluster, pieces: &[Piece]) -> (Place, usize) {
    let length: f64 = pieces.iter().map(|piece| piece.length).sum();
    let last = end(pieces);
    let (goal, reach) = (cluster.mesh.lift(last), 2.0 * cluster.radius + length);
    for piece in pieces {
        let candidates = cluster.near(piece.triangle, goal, reach, Within::Contact);
        let touches = candidates
            .into_iter()
            .filter_map(|e| Some((e, touch_along(cluster, piece, e)?)));
        if let Some((element, t)) = touches.min_by(|a, b| a.1.total_cmp(&b.1)) {
            return (piece.place(t), element);
        }
    }
    (last, nearest_overlapped(cluster, last))
}

/// How far along the piece the disc first touches element `e`: the root of |p + t·d − c| = 2r.
fn touch_along(cluster: &Cluster, piece: &Piece, e: usize) -> Option<f64> {
    let triangle = &cluster.mesh.triangles[piece.triangle];
    let offset = triangle.lift(piece.from) - cluster.positions[e];
    let excess = offset.length_squared() - 4.0 * cluster.radius * cluster.radius;
    if excess < 0.0 {
        return Some(0.0);
    }
    let approach = -offset.dot(triangle.lift_direction(piece.direction));
    let square = approach * approach - excess;
    if approach <= 0.0 || square < 0.0 {
        return None;
    }
    let t = excess / (approach + square.sqrt());
    (t <= piece.length).then_some(t)
}

/// For a contact that round-off hides from the exact solution: the overlapped element nearest to `place`.
fn nearest_overlapped(cluster: &Cluster, place: Place) -> usize {
    let p = cluster.mesh.lift(place);
    let distance = |e: usize| cluster.positions[e].distance_squared(p);
    let overlapped = cluster.overlapped(place, 2.0 * cluster.radius).into_iter();
    let nearest = overlapped.min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
    nearest.expect("the step ended in contact")
}

/// Where a disc that touches `pivot` at `touch` comes to rest: at the nearer of the second contacts either way round,
/// or none if there is no second contact that overlaps nothing.
pub(crate) fn pack(cluster: &Cluster, touch: Place, pivot: usize) -> Option<Place> {
    let ways = [1.0, -1.0].map(|way| rotate(cluster, touch, pivot, way));
    let rests = ways.into_iter().flatten();
    let (rest, _) = rests.min_by(|a, b| a.1.total_cmp(&b.1))?;
    let smallest = 2.0 * cluster.radius * (1.0 - OVERLAP);
    cluster
        .overlapped(rest, smallest)
        .is_empty()
        .then_some(rest)
}

/// The circle at distance 2r about the pivot in one triangle's plane, and the present place on it.
struct Circle<'a> {
    triangle: &'a Triangle,
    centre: DVec2,
    radius: f64,
    angle: f64,
    /// 1 for counter-clockwise in the triangle's frame, −1 for clockwise.
    way: f64,
}

/// What ends the arc in one triangle.
#[derive(Clone, Copy, Debug)]
enum Event {
    Exit(usize),
    Contact,
    FullTurn,
}

impl<'a> Circle<'a> {
    fn new(mesh: &'a Mesh, pivot: DVec3, distance: f64, place: Place, way: f64) -> Option<Self> {
        let triangle = &mesh.triangles[place.triangle];
        let (centre, height) = triangle.project(pivot);
        let square = distance * distance - height * height;
        (square > 0.0).then(|| Self {
            triangle,
            centre,
            radius: square.sqrt(),
            angle: (place.at - centre).to_angle(),
            way,
        })
    }

    fn at(&self, angle: f64) -> DVec2 {
        self.centre + DVec2::from_angle(angle) * self.radius
    }

    /// Direction of motion at `angle`.
    fn heading(&self, angle: f64) -> DVec2 {
        DVec2::from_angle(angle).perp() * self.way
    }

    /// Angle to turn from the present place to `angle`, in [0, 2π).
    fn turn_to(&self, angle: f64) -> f64 {
        let turn = (self.way * (angle - self.angle)).rem_euclid(TAU);
        if turn > TAU - BEHIND { 0.0 } else { turn }
    }

    /// Turn to where the circle leaves the triangle by `edge`.
    fn exit(&self, edge: &Edge) -> Option<f64> {
        let (s, height) = (
            (self.centre - edge.base).dot(edge.along),
            edge.height(self.centre),
        );
        let square = self.radius * self.radius - height * height;
        let half = (square > 0.0).then(|| square.sqrt())?;
        let leaves = |root: f64| {
            let angle = (edge.base + edge.along * root - self.centre).to_angle();
            let out = self.heading(angle).dot(edge.inward) < 0.0;
            (out && (0.0..=edge.length).contains(&root)).then(|| self.turn_to(angle))
        };
        let exits = [s - half, s + half].into_iter().filter_map(leaves);
        exits.min_by(f64::total_cmp)
    }

    /// Turn to where a disc on the circle comes within `distance` of the centre `p`.
    fn contact(&self, p: DVec3, distance: f64) -> Option<f64> {
        let (foot, height) = self.triangle.project(p);
        let other = distance * distance - height * height;
        let apart = foot.distance(self.centre);
        // Circles of radii R (ours) and ρ at distance a meet at cos θ = (R² + a² − ρ²) / 2Ra from the line of centres.
        let cosine =
            (self.radius * self.radius + apart * apart - other) / (2.0 * self.radius * apart);
        let angle = (cosine.abs() < 1.0).then(|| cosine.acos())?;
        Some(self.turn_to((foot - self.centre).to_angle() - self.way * angle))
    }
}

/// Moves round the pivot until a second element is touched: the place and the arc length, or none if a full turn or a
/// boundary comes first.
fn rotate(cluster: &Cluster, touch: Place, pivot: usize, way: f64) -> Option<(Place, f64)> {
    let (mesh, distance) = (cluster.mesh, 2.0 * cluster.radius);
    let (mut place, mut way, mut travelled) = (touch, way, 0.0);
    for crossings in 0..MOST_CROSSINGS {
        let circle = Circle::new(mesh, cluster.positions[pivot], distance, place, way)?;
        let back = (crossings > 0 && place.triangle == touch.triangle).then_some(touch);
        let (turn, event) = next_event(cluster, &circle, place, pivot, back)?;
        travelled += circle.radius * turn;
        let angle = circle.angle + way * turn;
        let at = circle.at(angle);
        match event {
            Event::FullTurn => return None,
            Event::Contact => return Some((Place { at, ..place }, travelled)),
            Event::Exit(k) => {
                let edge = &circle.triangle.edges[k];
                let (triangle, entry) = edge.across?;
                let other = &mesh.triangles[triangle].edges[entry];
                // Two triangles on the same side of their edge have opposite windings: the turn is mirrored.
                let mirrored = edge.on_left() == other.on_left();
                place = Place {
                    triangle,
                    at: on_edge(edge, other, at),
                };
                way = if mirrored { -way } else { way };
            }
        }
    }
    None
}

fn next_event(
    cluster: &Cluster,
    circle: &Circle,
    place: Place,
    pivot: usize,
    back: Option<Place>,
) -> Option<(f64, Event)> {
    let distance = 2.0 * cluster.radius;
    let around = cluster.near(
        place.triangle,
        cluster.positions[pivot],
        2.1 * distance,
        Within::Contact,
    );
    let others = around.into_iter().filter(|&e| e != pivot);
    let contacts = others.filter_map(|e| circle.contact(cluster.positions[e], distance));
    let exits =
        (0..3).filter_map(|k| Some((circle.exit(&circle.triangle.edges[k])?, Event::Exit(k))));
    let turns = back.map(|p| {
        (
            circle.turn_to((p.at - circle.centre).to_angle()),
            Event::FullTurn,
        )
    });
    let events = contacts
        .map(|turn| (turn, Event::Contact))
        .chain(exits)
        .chain(turns);
    events.min_by(|a, b| a.0.total_cmp(&b.0))
}
