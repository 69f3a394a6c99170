//! Collapses in passes, over one part of the mesh.

use glam::DVec3;

use super::checks::{self, MOST_ABOUT, Star, larger};
use super::quadric::Quadric;
use super::surface::{Kind, Surface};

/// The part of a squared length that is added to a squared error: of collapses that cost nothing,
/// short ones come first, which makes rounder triangles.
const SHORT: f64 = 1e-5;

/// A pass takes the cheapest one in so many of its candidates: 30 leave no smaller errors, 1 leaves
/// a fifth more.
const SHARE: usize = 3;

/// More candidates than this are taken in the order of their numbers: the cheapest first would be
/// another place in memory each time.
const MANY: usize = 1 << 14;

/// A pass that collapses less than one in so many of its candidates is followed by one of all.
const POOR: usize = 16;

/// Of a part's triangles one in so many is left at least, for its rim stays as it is.
const LEAST_SHARE: usize = 12;

/// A squared error in 32 bits that sort alike.
type Rank = u32;

/// Nothing ranks lower.
const LEAST: Rank = 0;

/// A vertex has nowhere to go.
const NONE: Rank = Rank::MAX;

/// A vertex has not been looked at since what is around it changed.
const UNKNOWN: Rank = Rank::MAX - 1;

/// A vertex by its rank first: numbers that sort as the pairs do, so that the least is found without a branch.
fn ranked(rank: Rank, vertex: u32) -> u64 {
    u64::from(rank) << 32 | u64::from(vertex)
}

/// Takes the least of those that are [`ranked`]. Few are taken, so to sort them all takes longer.
fn take_cheapest(ranked: &mut Vec<u64>) -> Option<u32> {
    let (at, _) = ranked.iter().enumerate().min_by_key(|(_, one)| **one)?;
    Some(ranked.swap_remove(at) as u32)
}

/// A vertex that looks where to go.
struct Mover {
    from: DVec3,
    planes: Quadric,
    most_error_sq: f64,
}

impl Mover {
    /// The place in the order of moving to `to`; none when that strays too far.
    fn rank(&self, to: DVec3) -> Rank {
        let step = to - self.from;
        let error_sq = self.planes.error_sq(step);
        let cost = error_sq + SHORT * step.length_squared();
        if error_sq <= self.most_error_sq {
            (cost.to_bits() >> 32) as Rank
        } else {
            NONE
        }
    }
}

/// What is known of a vertex.
#[derive(Clone, Copy)]
pub(super) struct Vertex {
    /// The planes that it stands for, about itself.
    pub(super) planes: Quadric,
    /// How far those that went into it have strayed at most.
    pub(super) strayed: f64,
    pub(super) kind: Kind,
    /// Whether it stays, and nothing moves onto it: other triangles are about it too.
    pub(super) stays: bool,
}

impl Vertex {
    pub(super) fn new(kind: Kind, planes: Quadric) -> Self {
        Self {
            planes,
            strayed: 0.0,
            kind,
            stays: false,
        }
    }
}

/// Where to stop, and how to get there.
#[derive(Clone, Copy)]
pub(in super::super) struct Limits {
    /// How far vertices may stray, a length.
    pub(in super::super) most_error: f64,
    /// The fewest triangles to leave.
    pub(in super::super) least_triangles: usize,
    /// Whether all that may go goes as soon as it may, in the order of memory and not the cheapest first: for
    /// errors so small that all are as cheap.
    pub(in super::super) at_once: bool,
}

impl Limits {
    /// Those of a part of the whole.
    pub(super) fn of_part(self, triangles: usize, all: usize) -> Self {
        if triangles == all {
            return self;
        }
        let share = self.least_triangles.min(all) as u64 * triangles as u64;
        Self {
            least_triangles: (share.div_ceil(all as u64) as usize).max(triangles / LEAST_SHARE),
            ..self
        }
    }
}

/// What is left of a part, by the numbers of the whole, and what is not.
pub(super) struct Part {
    pub(super) triangles: Vec<[u32; 3]>,
    /// For each, its number in the part's list.
    pub(super) source: Vec<u32>,
    /// Vertices that are still there.
    pub(super) left: Vec<(u32, Vertex)>,
    /// Vertices that have gone, each with the one that it went onto.
    pub(super) gone: Vec<[u32; 2]>,
    /// Whether the triangles about each inner vertex all run the same way round.
    pub(super) run_alike: bool,
}

/// A part on its way.
pub(super) struct Simplifier<'a> {
    surface: Surface<'a>,
    limits: Limits,
    run_alike: bool,
    vertices: Vec<Vertex>,
    onto: Vec<u32>,
    /// The vertices that had not gone when candidates were last looked for.
    alive: Vec<u32>,
    /// The lowest rank at which a vertex may go somewhere and has not been refused.
    next: Vec<Rank>,
    /// Vertices that a collapse of this pass has changed.
    changed: Vec<bool>,
    candidates: Vec<(Rank, u32)>,
    /// True when something collapsed since refusals were last forgotten.
    moved: bool,
    take_all: bool,
    star: Star,
    target: Star,
    /// Where a vertex may go, as [`ranked`].
    targets: Vec<u64>,
    apexes: Vec<[u32; 2]>,
    moved_normals: Vec<DVec3>,
}

impl<'a> Simplifier<'a> {
    /// `run_alike` says whether the triangles about each inner vertex all run the same way round.
    pub(super) fn new(
        surface: Surface<'a>,
        vertices: Vec<Vertex>,
        run_alike: bool,
        limits: Limits,
    ) -> Self {
        Self {
            onto: (0..vertices.len() as u32).collect(),
            alive: (0..vertices.len() as u32).collect(),
            next: vec![UNKNOWN; vertices.len()],
            changed: vec![false; vertices.len()],
            surface,
            limits,
            run_alike,
            vertices,
            candidates: Vec::new(),
            moved: false,
            take_all: false,
            star: Star::default(),
            target: Star::default(),
            targets: Vec::new(),
            apexes: Vec::new(),
            moved_normals: Vec::new(),
        }
    }

    /// Collapses the cheapest; false when nothing is left to do.
    pub(super) fn pass(&mut self) -> bool {
        self.surface.renew();
        self.changed.fill(false);
        self.find_candidates();
        if self.candidates.is_empty() {
            // A refusal may rest on what has changed since, two edges away.
            self.next.fill(UNKNOWN);
            return std::mem::take(&mut self.moved);
        }
        let (limit, before) = (self.cheapest_first(), self.surface.live());
        for i in 0..self.candidates.len() {
            if self.surface.live() < self.limits.least_triangles.saturating_add(2) {
                return false;
            }
            self.try_vertex(self.candidates[i].1, limit);
        }
        let collapsed = before - self.surface.live();
        self.moved |= collapsed > 0;
        self.take_all = collapsed * POOR < self.candidates.len();
        true
    }

    /// Lists the vertices that have somewhere to go, with the rank of the cheapest way.
    fn find_candidates(&mut self) {
        self.candidates.clear();
        self.alive.retain(|&v| self.onto[v as usize] == v);
        for &v in &self.alive {
            if self.next[v as usize] == UNKNOWN {
                self.next[v as usize] = self.cheapest(v);
            }
            match self.next[v as usize] {
                NONE => {}
                rank => self.candidates.push((rank, v)),
            }
        }
    }

    /// The rank of the cheapest way for a vertex to go, or the least where all go in any order.
    fn cheapest(&self, v: u32) -> Rank {
        if self.limits.at_once && self.kind(v) != Kind::Fixed {
            return LEAST;
        }
        let mover = self.mover(v);
        let rank = |w: u32| match self.vertices[w as usize].stays {
            true => NONE,
            false => mover.rank(self.surface.place(w)),
        };
        match self.kind(v) {
            Kind::Inner if self.run_alike => {
                let neighbours = self.surface.fan(v).map(|[first, _]| first);
                neighbours.map(rank).fold(NONE, Rank::min)
            }
            Kind::Inner => {
                let neighbours = self.surface.fan(v).flatten();
                neighbours.map(rank).fold(NONE, Rank::min)
            }
            Kind::Border => {
                let mut star = Star::default();
                star.read(&self.surface, v, false);
                let along = star.neighbours().filter(|n| n.1 == 1);
                along.map(|(w, _)| rank(w)).fold(NONE, Rank::min)
            }
            Kind::Fixed => NONE,
        }
    }

    /// How the triangles about a vertex join; fixed too where it stays for another reason.
    fn kind(&self, v: u32) -> Kind {
        let vertex = &self.vertices[v as usize];
        if vertex.stays {
            Kind::Fixed
        } else {
            vertex.kind
        }
    }

    /// Whether the triangles about a vertex are known to be a ring that all runs the same way round.
    fn is_ring(&self, v: u32) -> bool {
        self.run_alike && self.vertices[v as usize].kind == Kind::Inner
    }

    fn mover(&self, v: u32) -> Mover {
        Mover {
            from: self.surface.place(v),
            planes: self.vertices[v as usize].planes.mean(),
            most_error_sq: self.limits.most_error * self.limits.most_error,
        }
    }

    /// Sorts the share of the candidates that this pass takes, forgets the others, and returns the
    /// highest rank taken.
    fn cheapest_first(&mut self) -> Rank {
        if self.limits.at_once {
            return UNKNOWN - 1;
        }
        let last = self.candidates.len() - 1;
        let share = if self.take_all { last } else { last / SHARE };
        let limit = self.candidates.select_nth_unstable(share).1.0;
        self.candidates.truncate(share + 1);
        if self.candidates.len() > MANY {
            self.candidates.sort_unstable_by_key(|c| c.1);
        } else {
            self.candidates.sort_unstable();
        }
        limit
    }

    /// Moves a vertex the cheapest way that is allowed, if that ranks no higher than the limit.
    fn try_vertex(&mut self, v: u32, limit: Rank) {
        if self.changed[v as usize] {
            return;
        }
        self.star.read(&self.surface, v, self.is_ring(v));
        let next = self.find_targets(v, limit);
        if !self.targets.is_empty() {
            self.star.find_normals(&self.surface);
        }
        let mut waits = false;
        while let Some(w) = take_cheapest(&mut self.targets) {
            if self.changed[w as usize] {
                waits = true;
            } else if let Some(strayed) = self.try_target(v, w) {
                return self.collapse(v, w, strayed);
            }
        }
        if !waits {
            self.next[v as usize] = next;
        }
    }

    /// Lists where a vertex may go at a rank up to the limit, unless that was refused before; returns the lowest
    /// rank beyond.
    fn find_targets(&mut self, v: u32, limit: Rank) -> Rank {
        let mover = self.mover(v);
        let is_inner = self.kind(v) == Kind::Inner;
        let refused_below = match self.next[v as usize] {
            UNKNOWN => LEAST,
            known => known,
        };
        let mut next = NONE;
        self.targets.clear();
        let may_go =
            |n: &(u32, usize)| (is_inner || n.1 == 1) && !self.vertices[n.0 as usize].stays;
        for (w, _) in self.star.neighbours().filter(may_go) {
            match mover.rank(self.surface.place(w)) {
                rank if rank > limit => next = next.min(rank),
                rank if rank >= refused_below => self.targets.push(ranked(rank, w)),
                _ => {}
            }
        }
        next
    }

    /// How far vertices will have strayed when v moves onto w, if it may.
    fn try_target(&mut self, v: u32, w: u32) -> Option<f64> {
        let moved = &mut self.moved_normals;
        if self.surface.crowd(w) > MOST_ABOUT
            || !checks::keeps_triangles(&self.surface, &self.star, w, moved)
        {
            return None;
        }
        let kind = self.kind(v);
        let left = checks::distance_left(&self.surface, &self.star, w);
        let strayed = self.vertices[v as usize].strayed + left;
        // Most of what is refused is refused for this, and then the target need not be looked at.
        let is_near = strayed <= self.limits.most_error;
        if !is_near {
            return None;
        }
        self.target.read(&self.surface, w, self.is_ring(w));
        let (surface, star, target) = (&self.surface, &self.star, &self.target);
        let (moved, apexes) = (&self.moved_normals, &mut self.apexes);
        let may = checks::keeps_topology(star, target, kind)
            && checks::keeps_crowd_small(star, target)
            && checks::keeps_sharp_edge(surface, star, w, apexes)
            && checks::keeps_folds_open(surface, star, target, moved, apexes);
        may.then_some(strayed)
    }

    fn collapse(&mut self, v: u32, w: u32, strayed: f64) {
        for (neighbour, _) in self.star.neighbours().chain(self.target.neighbours()) {
            self.next[neighbour as usize] = UNKNOWN;
        }
        let step = self.surface.place(w) - self.surface.place(v);
        let planes = self.vertices[v as usize].planes.about(step);
        let target = &mut self.vertices[w as usize];
        target.planes += planes;
        target.strayed = larger(target.strayed, strayed);
        self.onto[v as usize] = w;
        self.changed[v as usize] = true;
        self.changed[w as usize] = true;
        self.surface.collapse(v, w);
    }

    /// What has come of the part whose vertices have these numbers in the whole.
    pub(super) fn finish(self, numbers: &[u32]) -> Part {
        let number = |v: u32| numbers[v as usize];
        let (mut left, mut gone) = (Vec::new(), Vec::new());
        for ((v, onto), vertex) in (0..).zip(self.onto).zip(self.vertices) {
            if onto == v {
                left.push((number(v), vertex));
            } else {
                gone.push([v, onto].map(number));
            }
        }
        let (triangles, source) = self.surface.into_triangles();
        Part {
            triangles: triangles.into_iter().map(|t| t.map(number)).collect(),
            source,
            left,
            gone,
            run_alike: self.run_alike,
        }
    }
}
