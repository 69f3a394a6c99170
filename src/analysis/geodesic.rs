//! Exact distances along the surface.
//!
//! Straight ways from a source, unfolded over the triangles, are carried as windows: the part of an
//! edge that they come through, and where the source lies in the plane of the triangle that they
//! come into (J. Chen and Y. Han, *Shortest paths on a polyhedron*, 1990). Of the windows that see a
//! corner, only the nearest goes on to both sides of it, and a window goes no farther when a vertex
//! offers a shorter way to all that it leads to (S.-Q. Xin and G.-J. Wang, *Improving Chen and Han's
//! algorithm on the discrete geodesic problem*, 2009). Ways bend only at vertices with more than a
//! full turn about them and at those of the border, which become sources themselves.
//!
//! The result is exact on the mesh, but for round-off. What the mesh lacks of the surface that it
//! stands for is in it too: see `docs/analysis.md`.
//!
//! Departure: at a vertex where several sheets meet, ways lead from one sheet to the other.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;
use std::f64::consts::TAU;
use std::sync::{Mutex, PoisonError};

use glam::DVec2;

use super::ground;
use super::mass::Metric;
use crate::substrate::{HalfEdge, Substrate, SurfacePoint};

/// Distances along the surface between places of a mesh, in the units of its file; infinite
/// between pieces that do not hang together.
pub struct SurfaceMetric<'a> {
    substrate: &'a Substrate,
    places: &'a [SurfacePoint],
    /// Of every half-edge.
    lengths: Vec<f64>,
    /// Vertices at which shortest ways may bend.
    bends: Vec<bool>,
    /// Where in `residents` those of each triangle begin.
    offsets: Vec<u32>,
    residents: Vec<u32>,
    /// What searches that are over leave to the next ones, as new.
    seen: Mutex<Vec<Seen>>,
}

impl std::fmt::Debug for SurfaceMetric<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SurfaceMetric").finish_non_exhaustive()
    }
}

/// Ways that come into a triangle through one of its edges. The frame has the start of the
/// half-edge at the origin, its end on the positive x axis, and the triangle above.
#[derive(Clone, Copy, Debug)]
struct Window {
    /// Of the triangle that the ways come into.
    half_edge: HalfEdge,
    /// The part of the edge that they come through.
    part: [f64; 2],
    /// Where they come from; below the axis.
    source: DVec2,
    /// How far the source is from the first one.
    before: f64,
}

impl Window {
    /// Length of the way to a place of the triangle or the edge.
    fn distance(&self, p: DVec2) -> f64 {
        self.before + self.source.distance(p)
    }

    fn least_distance(&self) -> f64 {
        let x = self.source.x.clamp(self.part[0], self.part[1]);
        self.distance(DVec2::new(x, 0.0))
    }

    /// Where the way to a place above the edge crosses the edge.
    fn entry(&self, p: DVec2) -> f64 {
        let s = self.source;
        s.x + (p.x - s.x) * s.y / (s.y - p.y)
    }

    /// Share of the way from p to q at which the way through the edge at x crosses it.
    fn exit(&self, x: f64, p: DVec2, q: DVec2) -> f64 {
        let way = DVec2::new(x, 0.0) - self.source;
        let share = way.perp_dot(self.source - p) / way.perp_dot(q - p);
        if share.is_nan() {
            0.0
        } else {
            share.clamp(0.0, 1.0)
        }
    }
}

/// How far from an edge a source is taken to be at least, in lengths of the edge: the crossings of
/// ways from nearer are lost in round-off. Distances may change by as much.
const LEAST_HEIGHT: f64 = 1e-8;

/// How far beside a window a place is still seen by it, in lengths of the edge: more than windows
/// that should meet may be apart. Distances change by its square.
const SLACK: f64 = 1e-6;

impl<'a> SurfaceMetric<'a> {
    /// Distances between these places of a mesh.
    ///
    /// # Panics
    /// When one is in a triangle that the mesh does not have.
    pub fn new(substrate: &'a Substrate, places: &'a [SurfacePoint]) -> Self {
        let vertex = |v: u32| substrate.vertices()[v as usize];
        let edges = |t: &[u32; 3]| [0, 1, 2].map(|k| vertex(t[k]).distance(vertex(t[(k + 1) % 3])));
        let vertices = 0..substrate.vertices().len() as u32;
        let mut offsets = vec![0u32; substrate.triangles().len() + 1];
        for place in places {
            offsets[place.triangle as usize + 1] += 1;
        }
        (1..offsets.len()).for_each(|t| offsets[t] += offsets[t - 1]);
        let mut residents: Vec<u32> = (0..places.len() as u32).collect();
        residents.sort_by_key(|&i| places[i as usize].triangle);
        Self {
            substrate,
            places,
            lengths: substrate.triangles().iter().flat_map(edges).collect(),
            bends: vertices.map(|v| bends(substrate, v)).collect(),
            offsets,
            residents,
            seen: Mutex::default(),
        }
    }

    /// For a new search. The mesh may be much larger than what it comes to see.
    fn take_seen(&self) -> Seen {
        let left = self
            .seen
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .pop();
        left.unwrap_or_else(|| Seen::new(self.bends.len(), self.lengths.len()))
    }

    fn give_back(&self, mut seen: Seen) {
        seen.forget();
        let mut left = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        left.push(seen);
    }

    /// Places in a triangle.
    fn residents(&self, triangle: u32) -> &[u32] {
        let [from, to] = [0, 1].map(|k| self.offsets[triangle as usize + k] as usize);
        &self.residents[from..to]
    }

    /// The third corner in the frame of a half-edge.
    fn apex(&self, half_edge: HalfEdge) -> DVec2 {
        let crossing = &self.substrate.crossings()[half_edge as usize];
        DVec2::new(crossing.along, crossing.height) * self.lengths[half_edge as usize]
    }

    /// A place of its triangle in the frame of a half-edge.
    fn in_frame(&self, half_edge: HalfEdge, place: &SurfacePoint) -> DVec2 {
        let (weights, k) = (place.weights(), half_edge as usize % 3);
        let base = DVec2::new(self.lengths[half_edge as usize], 0.0);
        base * weights[(k + 1) % 3] + self.apex(half_edge) * weights[(k + 2) % 3]
    }

    /// The vertex that a half-edge leaves.
    fn start(&self, half_edge: HalfEdge) -> usize {
        self.substrate.triangles()[half_edge as usize / 3][half_edge as usize % 3] as usize
    }

    /// The window of the triangle across a half-edge, for ways that leave through it from a source
    /// in its frame, above the axis. None at the border.
    fn across(
        &self,
        half_edge: HalfEdge,
        part: [f64; 2],
        source: DVec2,
        before: f64,
    ) -> Option<Window> {
        let twin = self.substrate.twin(half_edge);
        let length = self.lengths[half_edge as usize];
        let below = -source.y.max(length * LEAST_HEIGHT);
        let (source, part) = match twin.is_flipped() {
            true => (DVec2::new(source.x, below), part),
            false => {
                let [from, to] = part;
                let source = DVec2::new(length - source.x, below);
                (source, [length - to, length - from])
            }
        };
        (twin.half_edge() != half_edge).then_some(Window {
            half_edge: twin.half_edge(),
            part,
            source,
            before,
        })
    }
}

/// Whether the triangles at a vertex make more than a full turn, or do not close.
fn bends(substrate: &Substrate, vertex: u32) -> bool {
    const ROUND_OFF: f64 = 1e-9;
    let corners = substrate.half_edges_at(vertex);
    let border = |h: &HalfEdge| {
        [*h, previous(*h)]
            .into_iter()
            .any(|h| substrate.twin(h).half_edge() == h)
    };
    let angle = |&h: &HalfEdge| {
        let corners = substrate.corners(h / 3);
        let [a, b, c] = [0, 1, 2].map(|k| corners[(h as usize + k) % 3]);
        let (e, f) = (b - a, c - a);
        libm::atan2(e.cross(f).length(), e.dot(f))
    };
    corners.iter().any(border) || corners.iter().map(angle).sum::<f64>() > TAU + ROUND_OFF
}

fn next(half_edge: HalfEdge) -> HalfEdge {
    half_edge / 3 * 3 + (half_edge + 1) % 3
}

fn previous(half_edge: HalfEdge) -> HalfEdge {
    half_edge / 3 * 3 + (half_edge + 2) % 3
}

/// Events from one look at the farthest place to the next.
const LOOK_UP: u64 = 4096;

impl Metric for SurfaceMetric<'_> {
    fn distances(&self, from: usize, limit: f64) -> Vec<f64> {
        let units = self.substrate.units();
        let mut search = Search::new(self, units.length_to_local(limit));
        search.begin(&self.places[from]);
        search.run();
        search.found[from] = 0.0;
        self.give_back(search.seen);
        let found = search.found.into_iter();
        found.map(|d| units.length_to_file(d)).collect()
    }

    fn ring_areas(&self, from: usize, width: f64, rings: usize) -> Option<Vec<f64>> {
        let centre = self.places[from];
        ground::ring_areas(self.substrate, centre, width, rings)
    }
}

/// Something that is to happen at a distance from the source.
struct Event {
    distance: f64,
    /// Counts events, so that those at one distance have an order.
    number: u64,
    what: What,
}

enum What {
    Window(Window),
    /// A vertex at which ways may bend.
    Vertex(u32),
}

impl PartialEq for Event {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Event {}

impl PartialOrd for Event {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Event {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_distance = self.distance.total_cmp(&other.distance);
        by_distance.then(self.number.cmp(&other.number))
    }
}

/// What is known of the ways from one source to vertices and edges; local units.
struct Seen {
    /// Least distance of each vertex so far.
    vertices: Vec<f64>,
    /// Of the nearest window of each half-edge that sees the third corner: the distance of that
    /// corner, and where the way to it crosses the half-edge.
    apexes: Vec<[f64; 2]>,
    /// Those of which anything is known.
    known_vertices: Vec<usize>,
    known_apexes: Vec<HalfEdge>,
}

impl Seen {
    fn new(vertices: usize, half_edges: usize) -> Self {
        Self {
            vertices: vec![f64::INFINITY; vertices],
            apexes: vec![[f64::INFINITY; 2]; half_edges],
            known_vertices: Vec::new(),
            known_apexes: Vec::new(),
        }
    }

    /// Keeps a way to a vertex, if it is shorter than those before.
    fn reach(&mut self, vertex: usize, distance: f64) -> bool {
        let least = &mut self.vertices[vertex];
        if *least == f64::INFINITY && distance < *least {
            self.known_vertices.push(vertex);
        }
        let is_shorter = distance < *least;
        *least = least.min(distance);
        is_shorter
    }

    /// Keeps the nearest window of a half-edge.
    fn see(&mut self, half_edge: HalfEdge, apex: [f64; 2]) {
        let [before, _] = std::mem::replace(&mut self.apexes[half_edge as usize], apex);
        if before == f64::INFINITY {
            self.known_apexes.push(half_edge);
        }
    }

    /// As new.
    fn forget(&mut self) {
        for vertex in self.known_vertices.drain(..) {
            self.vertices[vertex] = f64::INFINITY;
        }
        for half_edge in self.known_apexes.drain(..) {
            self.apexes[half_edge as usize] = [f64::INFINITY; 2];
        }
    }
}

/// What is known of the ways from one source; local units.
struct Search<'a> {
    metric: &'a SurfaceMetric<'a>,
    limit: f64,
    seen: Seen,
    /// Least distance of each place so far.
    found: Vec<f64>,
    queue: BinaryHeap<Reverse<Event>>,
    events: u64,
}

impl<'a> Search<'a> {
    fn new(metric: &'a SurfaceMetric<'a>, limit: f64) -> Self {
        Self {
            metric,
            limit,
            seen: metric.take_seen(),
            found: vec![f64::INFINITY; metric.places.len()],
            queue: BinaryHeap::new(),
            events: 0,
        }
    }

    fn put(&mut self, distance: f64, what: What) {
        if distance <= self.limit {
            self.events += 1;
            self.queue.push(Reverse(Event {
                distance,
                number: self.events,
                what,
            }));
        }
    }

    fn put_window(&mut self, window: Option<Window>) {
        if let Some(window) = window {
            self.put(window.least_distance(), What::Window(window));
        }
    }

    /// A way to a vertex.
    fn reach(&mut self, vertex: usize, distance: f64) {
        if self.seen.reach(vertex, distance) && self.metric.bends[vertex] {
            self.put(distance, What::Vertex(vertex as u32));
        }
    }

    /// A way to a place.
    fn meet(&mut self, place: u32, distance: f64) {
        let found = &mut self.found[place as usize];
        *found = found.min(distance);
    }

    /// Goes on until no way is left that could be shorter than those found.
    fn run(&mut self) {
        let mut looked_up = 0;
        while let Some(Reverse(event)) = self.queue.pop() {
            if event.distance > self.limit {
                return;
            }
            if self.events > looked_up + LOOK_UP {
                looked_up = self.events;
                self.lower_limit();
            }
            match event.what {
                What::Window(window) => self.enter(&window),
                What::Vertex(v) if event.distance == self.seen.vertices[v as usize] => self.turn(v),
                What::Vertex(_) => {}
            }
        }
    }

    /// No way is of use that is longer than those found to all places.
    fn lower_limit(&mut self) {
        let farthest = self.found.iter().copied().fold(0.0, f64::max);
        self.limit = self.limit.min(farthest);
    }

    /// Straight ways within the source's triangle, and out of it.
    fn begin(&mut self, source: &SurfacePoint) {
        let metric = self.metric;
        let position = metric.substrate.position(source);
        for &place in metric.residents(source.triangle) {
            let there = metric.substrate.position(&metric.places[place as usize]);
            self.meet(place, position.distance(there));
        }
        for half_edge in [0, 1, 2].map(|k| 3 * source.triangle + k) {
            let source = metric.in_frame(half_edge, source);
            let length = metric.lengths[half_edge as usize];
            self.reach(metric.start(half_edge), source.length());
            if source.length() <= LEAST_HEIGHT * length {
                self.turn_at(metric.start(half_edge) as u32, 0.0);
            }
            self.put_window(metric.across(half_edge, [0.0, length], source, 0.0));
        }
    }

    /// A vertex becomes a source.
    fn turn(&mut self, vertex: u32) {
        self.turn_at(vertex, self.seen.vertices[vertex as usize]);
    }

    fn turn_at(&mut self, vertex: u32, before: f64) {
        let metric = self.metric;
        for &half_edge in metric.substrate.half_edges_at(vertex) {
            for &place in metric.residents(half_edge / 3) {
                let there = metric.in_frame(half_edge, &metric.places[place as usize]);
                self.meet(place, before + there.length());
            }
            let [along, back] = [half_edge, previous(half_edge)];
            self.reach(
                metric.start(next(half_edge)),
                before + metric.lengths[along as usize],
            );
            self.reach(metric.start(back), before + metric.lengths[back as usize]);
            let opposite = next(half_edge);
            let part = [0.0, metric.lengths[opposite as usize]];
            let source = metric.apex(opposite);
            self.put_window(metric.across(opposite, part, source, before));
        }
    }

    /// Follows the ways of a window over its triangle.
    fn enter(&mut self, window: &Window) {
        let (metric, half_edge) = (self.metric, window.half_edge);
        if self.is_beaten(window) {
            return;
        }
        let slack = SLACK * metric.lengths[half_edge as usize];
        for &place in metric.residents(half_edge / 3) {
            let there = metric.in_frame(half_edge, &metric.places[place as usize]);
            let x = window.entry(there);
            if x >= window.part[0] - slack && x <= window.part[1] + slack {
                self.meet(place, window.distance(there));
            }
        }
        let (left, right) = self.split(window);
        if let Some(part) = left {
            self.leave_by_left(window, part);
        }
        if let Some(part) = right {
            self.leave_by_right(window, part);
        }
    }

    /// Whether one of the edge's ends offers a way no longer to all of its part.
    fn is_beaten(&self, window: &Window) -> bool {
        let ([from, to], half_edge) = (window.part, window.half_edge);
        let length = self.metric.lengths[half_edge as usize];
        let [start, end] = [half_edge, next(half_edge)].map(|h| self.metric.start(h));
        let beaten = |vertex: usize, way: f64, x: f64| {
            let window = window.distance(DVec2::new(x, 0.0));
            self.seen.vertices[vertex] + way < window * (1.0 - f64::EPSILON)
        };
        beaten(start, to, to) || beaten(end, length - from, from)
    }

    /// The parts of the edge whose ways leave by the left and by the right side of the third
    /// corner, and that corner's distance. A window that sees it from farther than another goes on
    /// only on its own side of the other's way.
    fn split(&mut self, window: &Window) -> (Option<[f64; 2]>, Option<[f64; 2]>) {
        let ([from, to], half_edge) = (window.part, window.half_edge);
        let apex = self.metric.apex(half_edge);
        let x = window.entry(apex);
        if x >= to {
            return (Some([from, to]), None);
        }
        if x <= from {
            return (None, Some([from, to]));
        }
        let distance = window.distance(apex);
        let [nearest, entry] = self.seen.apexes[half_edge as usize];
        if distance < nearest {
            self.seen.see(half_edge, [distance, x]);
            self.reach(self.metric.start(previous(half_edge)), distance);
            return (Some([from, x]), Some([x, to]));
        }
        match x <= entry {
            true => (Some([from, x]), None),
            false => (None, Some([x, to])),
        }
    }

    /// From the third corner back to the start.
    fn leave_by_left(&mut self, window: &Window, part: [f64; 2]) {
        let metric = self.metric;
        let (side, apex) = (previous(window.half_edge), metric.apex(window.half_edge));
        let length = metric.lengths[side as usize];
        let [near, far] = part.map(|x| window.exit(x, DVec2::ZERO, apex));
        let end = DVec2::new(metric.lengths[window.half_edge as usize], 0.0);
        let vertex = metric.start(next(window.half_edge));
        if far <= near || self.cuts_off(vertex, end, apex * near, window) {
            return;
        }
        let way = apex.normalize_or(DVec2::Y);
        let source = DVec2::new(
            length - window.source.dot(way),
            way.perp_dot(window.source).abs(),
        );
        let part = [far, near].map(|share| length * (1.0 - share));
        self.put_window(metric.across(side, part, source, window.before));
    }

    /// From the end to the third corner.
    fn leave_by_right(&mut self, window: &Window, part: [f64; 2]) {
        let metric = self.metric;
        let (side, apex) = (next(window.half_edge), metric.apex(window.half_edge));
        let length = metric.lengths[side as usize];
        let end = DVec2::new(metric.lengths[window.half_edge as usize], 0.0);
        let [far, near] = part.map(|x| window.exit(x, end, apex));
        let vertex = metric.start(window.half_edge);
        let exit = end + (apex - end) * near;
        if far <= near || self.cuts_off(vertex, DVec2::ZERO, exit, window) {
            return;
        }
        let way = (apex - end).normalize_or(DVec2::Y);
        let from_end = window.source - end;
        let source = DVec2::new(from_end.dot(way), way.perp_dot(from_end).abs());
        let part = [near, far].map(|share| length * share);
        self.put_window(metric.across(side, part, source, window.before));
    }

    /// Whether the vertex of the edge that is not on the side offers a shorter way to the nearest
    /// place of the exit: to it all ways of the window have to cross that one.
    fn cuts_off(&self, vertex: usize, at: DVec2, exit: DVec2, window: &Window) -> bool {
        let way = self.seen.vertices[vertex] + at.distance(exit);
        way < window.distance(exit) * (1.0 - f64::EPSILON)
    }
}
