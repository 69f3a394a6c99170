//! Sheets: which parts of the surface belong together near a point (Sumner 2001, 6.3.2; `docs/architecture.md`).
//!
//! Distances between centres are taken through space, so on a thin fin one face would feel the
//! other. Two places are on the same sheet within a ball when the surface joins them inside it.
//!
//! The thesis keeps a list of nearby triangles for each triangle. A list answers for the whole
//! triangle at once, and on triangles larger than the ball that is too coarse: every list about a
//! face of a plate made of twelve triangles reaches its rim, and so the other face. Here the
//! question is asked for the ball in hand, by a search over edges and vertices that touch it. It
//! costs nothing to prepare or store, whatever the size of the triangles, and where triangles are
//! large it looks at one or two. Where they are small a line from place to place mostly answers it:
//! what is joined by a line inside the ball is joined, and where a line fails the ball is searched.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::section::{Ball, Place, leads};
use crate::ahead::fetch;
use crate::substrate::{HalfEdge, Substrate, segment_distance_sq};

/// Triangles for each place that are searched on all sides before lines are followed.
const FEW: usize = 1;

/// What lies about a triangle is asked for when so many others come before it.
const AHEAD: usize = 4;

/// Places, of those joined before, of which the nearest is the one to make for.
const LAST: usize = 32;

/// Scratch space for searches over triangles: stored by whoever searches, never part of a result.
#[derive(Default)]
pub struct Connectivity {
    /// The search that last reached each triangle.
    stamp: Vec<u32>,
    /// The search that last went to all about each vertex.
    spread: Vec<u32>,
    search: u32,
    /// How many of those reached it has spread from.
    next: usize,
    reached: Vec<u32>,
    path: Vec<u32>,
    /// Those reached from which it has not spread, by how far they are from where it is to come to.
    nearest: BinaryHeap<Reverse<(u32, u32)>>,
    /// For whoever asks about many places at once: room to list them.
    pub(crate) others: Vec<Place>,
}

impl std::fmt::Debug for Connectivity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Connectivity").finish_non_exhaustive()
    }
}

impl Connectivity {
    /// Scratch for no substrate in particular; it grows to the first one that it is used on.
    pub fn new() -> Self {
        Self::default()
    }

    /// True when the surface joins two places inside a ball.
    pub fn joined(&mut self, substrate: &Substrate, places: [Place; 2], ball: &Ball) -> bool {
        self.joins(substrate, places, ball, face_alike)
    }

    /// Whether the surface joins two places inside a ball, as [`joined`](Self::joined) has it: sooner found where it
    /// mostly does, and later where it mostly does not.
    pub fn likely_joined(
        &mut self,
        substrate: &Substrate,
        places: [Place; 2],
        ball: &Ball,
    ) -> bool {
        self.joins(substrate, places, ball, |_, _| true)
    }

    fn joins(
        &mut self,
        substrate: &Substrate,
        [from, to]: [Place; 2],
        ball: &Ball,
        is_likely: fn(&Substrate, [u32; 2]) -> bool,
    ) -> bool {
        if from.0 == to.0 || is_across(substrate, from.0, to.0, ball) {
            return true;
        }
        self.begin(substrate, from.0);
        if !self.flood(substrate, ball, FEW, &[to]) {
            self.follow(substrate, from, ball, &mut [to]);
            match is_likely(substrate, [from.0, to.0]) {
                true => self.make_for(substrate, ball, to),
                false => _ = self.flood(substrate, ball, usize::MAX, &[to]),
            }
        }
        self.has_reached(to.0)
    }

    /// Searches all that the surface joins to a triangle inside a ball; ask with
    /// [`has_reached`](Self::has_reached).
    pub fn reach(&mut self, substrate: &Substrate, from: u32, ball: &Ball) {
        self.begin(substrate, from);
        self.flood(substrate, ball, usize::MAX, &[]);
    }

    /// Searches until all places that are wanted are found, or no more are; puts them in order. Ask with
    /// [`has_reached`](Self::has_reached), for their triangles only.
    pub fn find(&mut self, substrate: &Substrate, from: Place, ball: &Ball, wanted: &mut [Place]) {
        self.begin(substrate, from.0);
        if wanted.is_empty() || self.flood(substrate, ball, FEW * wanted.len(), wanted) {
            return;
        }
        self.follow(substrate, from, ball, wanted);
        self.flood(substrate, ball, usize::MAX, wanted);
    }

    /// Spreads where it is nearest to a place, until that is found or the ball is searched. Where it is found it has
    /// mostly been to a small part of the ball, but to search all takes longer in this order.
    #[inline(never)]
    fn make_for(&mut self, substrate: &Substrate, ball: &Ball, to: Place) {
        let away = |t: u32| {
            let [a, b, c] = substrate.corners(t);
            (3.0 * to.1 - (a + b + c)).length_squared() as f32
        };
        let mut known = self.next;
        self.nearest.clear();
        while !self.has_reached(to.0) {
            for &t in &self.reached[known..] {
                // Of what is not negative, bits are in order.
                self.nearest.push(Reverse((away(t).to_bits(), t)));
            }
            known = self.reached.len();
            let Some(Reverse((_, t))) = self.nearest.pop() else {
                return;
            };
            self.spread(substrate, t, ball);
        }
    }

    /// How many of some places the surface joins to another inside a ball. Puts them in order.
    pub fn count_joined(
        &mut self,
        substrate: &Substrate,
        (from, others): (Place, &mut [Place]),
        ball: &Ball,
    ) -> usize {
        self.find(substrate, from, ball, others);
        others.iter().filter(|o| self.has_reached(o.0)).count()
    }

    /// Whether the last search came to a triangle.
    pub fn has_reached(&self, triangle: u32) -> bool {
        self.stamp[triangle as usize] == self.search
    }

    /// The triangles that the last search came to, in the order of the search.
    pub fn reached(&self) -> &[u32] {
        &self.reached
    }

    fn begin(&mut self, substrate: &Substrate, from: u32) {
        let sizes = [substrate.triangles().len(), substrate.vertices().len()];
        if [self.stamp.len(), self.spread.len()] != sizes || self.search == u32::MAX {
            [self.stamp, self.spread] = sizes.map(|n| vec![0; n]);
            self.search = 0;
        }
        self.search += 1;
        self.next = 0;
        self.reached.clear();
        self.mark(substrate, from);
    }

    /// Spreads on all sides until all that are wanted are found or the ball is searched, which is
    /// true, or so many triangles are reached.
    fn flood(&mut self, substrate: &Substrate, ball: &Ball, most: usize, wanted: &[Place]) -> bool {
        let mut found = 0;
        while self.next < self.reached.len() {
            if !wanted.is_empty() {
                let more = wanted[found..].iter();
                found += more.take_while(|w| self.has_reached(w.0)).count();
                if found == wanted.len() {
                    return true;
                }
            }
            if self.reached.len() > most {
                return false;
            }
            let t = self.reached[self.next];
            self.fetch(substrate, self.next + AHEAD);
            self.next += 1;
            self.spread(substrate, t, ball);
        }
        true
    }

    /// Asks for what a later spread will need, whose triangle has been asked for.
    fn fetch(&self, substrate: &Substrate, later: usize) {
        let Some(&triangle) = self.reached.get(later) else {
            return;
        };
        for v in substrate.triangles()[triangle as usize] {
            fetch(substrate.vertices().get(v as usize));
            fetch(self.spread.get(v as usize));
            substrate.fetch_half_edges_at(v);
        }
    }

    /// Follows lines from places to those that are found, the nearest ones first.
    fn follow(&mut self, substrate: &Substrate, from: Place, ball: &Ball, wanted: &mut [Place]) {
        let away = |w: &Place| w.1.distance_squared(from.1);
        wanted.sort_unstable_by(|a, b| away(a).total_cmp(&away(b)));
        let mut path = std::mem::take(&mut self.path);
        for (i, &place) in wanted.iter().enumerate() {
            if self.has_reached(place.0) {
                continue;
            }
            let before = &wanted[i.saturating_sub(LAST)..i];
            let to = self.nearest_of(before, place).unwrap_or(from);
            let there = |t| self.has_reached(t);
            // Where a line fails all has to be searched.
            if !leads(substrate, [place, to], ball, there, &mut path) {
                break;
            }
            path.iter().for_each(|t| self.mark(substrate, *t));
        }
        self.path = path;
    }

    /// Of those that are found.
    fn nearest_of(&self, places: &[Place], to: Place) -> Option<Place> {
        let found = places.iter().filter(|place| self.has_reached(place.0));
        let away = |place: &Place| place.1.distance_squared(to.1);
        found.min_by(|a, b| away(a).total_cmp(&away(b))).copied()
    }

    fn mark(&mut self, substrate: &Substrate, triangle: u32) {
        let stamp = &mut self.stamp[triangle as usize];
        if *stamp != self.search {
            *stamp = self.search;
            self.reached.push(triangle);
            fetch(substrate.triangles().get(triangle as usize));
        }
    }

    /// Marks what lies about the vertices in the ball, and across other edges that touch it.
    #[inline(always)]
    fn spread(&mut self, substrate: &Substrate, t: u32, ball: &Ball) {
        let (centre, limit) = (ball.centre, ball.radius * ball.radius);
        let [a, b, c] = substrate.triangles()[t as usize];
        let mut is_inside = |v: u32| {
            // Those that the search has been to are, and most have been.
            self.spread[v as usize] == self.search || {
                let p = substrate.vertices()[v as usize];
                let is_inside = (p - centre).length_squared() <= limit;
                if is_inside {
                    self.spread_about(substrate, v);
                }
                is_inside
            }
        };
        let inside = [is_inside(a), is_inside(b), is_inside(c)];
        if inside == [true; 3] {
            return;
        }
        let corners = substrate.corners(t);
        let reaches = |k: usize, next: usize| {
            !inside[k]
                && !inside[next]
                && segment_distance_sq(centre, corners[k], corners[next]) <= limit
        };
        // Written out: in a loop all corners are looked up in memory, and growth on a thin plate takes a
        // twelfth longer.
        self.mark_across(substrate, 3 * t, reaches(0, 1));
        self.mark_across(substrate, 3 * t + 1, reaches(1, 2));
        self.mark_across(substrate, 3 * t + 2, reaches(2, 0));
    }

    /// Marks the triangle across a half-edge, if the ball reaches across.
    #[inline(always)]
    fn mark_across(&mut self, substrate: &Substrate, half_edge: HalfEdge, reaches: bool) {
        if reaches {
            self.mark(substrate, substrate.twin(half_edge).half_edge() / 3);
        }
    }

    /// Marks the triangles about a vertex.
    fn spread_about(&mut self, substrate: &Substrate, vertex: u32) {
        self.spread[vertex as usize] = self.search;
        let leaving = substrate.half_edges_at(vertex);
        leaving.iter().for_each(|h| self.mark(substrate, h / 3));
    }
}

/// Whether two triangles look to one side: then the surface mostly joins them, where on the two faces of a plate it
/// does not.
fn face_alike(substrate: &Substrate, triangles: [u32; 2]) -> bool {
    let [one, other] = triangles.map(|t| {
        let [a, b, c] = substrate.corners(t);
        (b - a).cross(c - a)
    });
    one.dot(other) > 0.0
}

/// Whether two triangles have an edge in common that touches a ball: then it joins them, and most that are asked
/// about are such.
#[inline(never)]
fn is_across(substrate: &Substrate, one: u32, other: u32, ball: &Ball) -> bool {
    let across = |h: &HalfEdge| substrate.twin(*h).half_edge() / 3 == other;
    (3 * one..3 * one + 3).find(across).is_some_and(|h| {
        let (corners, k) = (substrate.corners(one), (h % 3) as usize);
        let away_sq = segment_distance_sq(ball.centre, corners[k], corners[(k + 1) % 3]);
        away_sq <= ball.radius * ball.radius
    })
}
