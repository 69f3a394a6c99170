//! Sheets: which parts of the surface belong together near a point (DESIGN section 2).
//!
//! Distances between centres are taken through space, so on a thin fin one face would feel the
//! other. Two places are on the same sheet within a ball when the surface joins them inside it.
//!
//! The thesis keeps a list of nearby triangles for each triangle. A list answers for the whole
//! triangle at once, and on triangles larger than the ball that is too coarse: every list about a
//! face of a plate made of twelve triangles reaches its rim, and so the other face. Here the
//! question is asked for the ball in hand, by a search over edges and vertices that touch it. It
//! costs nothing to prepare or store, whatever the size of the triangles, and where triangles are
//! large it looks at one or two.

use glam::DVec3;

use crate::substrate::{HalfEdge, Substrate, segment_distance_sq};

/// Scratch space for searches over triangles: stored by whoever searches, never part of a result.
#[derive(Default)]
pub struct Connectivity {
    /// The search that last reached each triangle.
    stamp: Vec<u32>,
    /// The search that last went to all about each vertex.
    spread: Vec<u32>,
    search: u32,
    reached: Vec<u32>,
    /// For whoever asks about many triangles at once: room to list them.
    pub(crate) others: Vec<u32>,
}

impl Connectivity {
    /// Scratch for no substrate in particular; it grows to the first one that it is used on.
    pub fn new() -> Self {
        Self::default()
    }

    /// True when the surface joins two triangles inside a ball.
    pub fn joined(
        &mut self,
        substrate: &Substrate,
        [from, to]: [u32; 2],
        centre: DVec3,
        radius: f64,
    ) -> bool {
        from == to || {
            self.search(substrate, from, centre, radius, Some(&[to]));
            self.has_reached(to)
        }
    }

    /// Searches all that the surface joins to a triangle inside a ball; ask with
    /// [`has_reached`](Self::has_reached).
    pub fn reach(&mut self, substrate: &Substrate, from: u32, centre: DVec3, radius: f64) {
        self.search(substrate, from, centre, radius, None);
    }

    /// How many of some triangles the surface joins to another inside a ball.
    pub fn count_joined(
        &mut self,
        substrate: &Substrate,
        (from, others): (u32, &[u32]),
        centre: DVec3,
        radius: f64,
    ) -> usize {
        self.search(substrate, from, centre, radius, Some(others));
        others.iter().filter(|t| self.has_reached(**t)).count()
    }

    /// Whether the last search came to a triangle.
    pub fn has_reached(&self, triangle: u32) -> bool {
        self.stamp[triangle as usize] == self.search
    }

    /// The triangles that the last search came to, in the order of the search.
    pub fn reached(&self) -> &[u32] {
        &self.reached
    }

    /// Goes on until all that are wanted are found, or no more are.
    fn search(
        &mut self,
        substrate: &Substrate,
        from: u32,
        centre: DVec3,
        radius: f64,
        wanted: Option<&[u32]>,
    ) {
        self.begin(substrate);
        self.mark(from);
        let (mut next, mut found) = (0, 0);
        while next < self.reached.len() {
            if let Some(wanted) = wanted {
                found += wanted[found..]
                    .iter()
                    .take_while(|t| self.has_reached(**t))
                    .count();
                if found == wanted.len() {
                    return;
                }
            }
            let t = self.reached[next];
            next += 1;
            self.spread(substrate, t, centre, radius * radius);
        }
    }

    fn begin(&mut self, substrate: &Substrate) {
        let sizes = [substrate.triangles().len(), substrate.vertices().len()];
        if [self.stamp.len(), self.spread.len()] != sizes || self.search == u32::MAX {
            [self.stamp, self.spread] = sizes.map(|n| vec![0; n]);
            self.search = 0;
        }
        self.search += 1;
        self.reached.clear();
    }

    fn mark(&mut self, triangle: u32) {
        let stamp = &mut self.stamp[triangle as usize];
        if *stamp != self.search {
            *stamp = self.search;
            self.reached.push(triangle);
        }
    }

    /// Marks what lies about the vertices in the ball, and across other edges that touch it.
    fn spread(&mut self, substrate: &Substrate, t: u32, centre: DVec3, limit: f64) {
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
        for k in 0..3 {
            let (this, next) = (k, (k + 1) % 3);
            let touches = || segment_distance_sq(centre, corners[this], corners[next]) <= limit;
            if !inside[this] && !inside[next] && touches() {
                let twin = substrate.twin(3 * t + k as HalfEdge);
                self.mark(twin.half_edge() / 3);
            }
        }
    }

    /// Marks the triangles about a vertex.
    fn spread_about(&mut self, substrate: &Substrate, vertex: u32) {
        self.spread[vertex as usize] = self.search;
        let leaving = substrate.half_edges_at(vertex);
        leaving.iter().for_each(|h| self.mark(h / 3));
    }
}
