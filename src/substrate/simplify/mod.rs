//! Fewer triangles for nearly the same surface.
//!
//! Vertices move onto neighbours, those first that stray least from the planes of the triangles
//! that they stood for: Garland & Heckbert, *Surface Simplification Using Quadric Error Metrics*
//! (1997), with half-edge collapses only, so that the vertices left are some of the given ones.
//! We depart from the paper in three ways.
//!
//! - Not from a heap but in passes, in the manner of meshoptimizer: each takes the cheapest vertices,
//!   in order of cost where they are few, and leaves alone until the next pass what a collapse has
//!   changed.
//! - A collapse costs the mean, weighted by area, of the squared distances to the planes that the
//!   *moving* vertex stands for; so a spike on a large plane is not averaged away.
//! - The error allowed limits that, and besides the sum of steps: each vertex knows how far the
//!   vertices that went into it have strayed at most, and a collapse adds the distance from the
//!   vertex that goes to the triangles that it leaves behind. Vertices nearby are pulled along
//!   unaccounted: measured over the whole, given vertices lie within twice the error.
//!
//! What is kept: the pieces, their Euler characteristic and borders (the link condition), vertices
//! at edges of more than two triangles, and the sense of every triangle; no sliver, no sharp fold
//! and no crowd of triangles about one vertex comes to be. Border vertices move along the border,
//! and vertices on an edge sharper than 100° along that.
//! What is not: two sheets may come to cross each other where they lie closer than twice the error.
//!
//! The result decides walks: it is the same to the last bit on every machine.

mod checks;
mod quadric;
mod surface;
#[cfg(test)]
mod tests;

use glam::DVec3;
use rayon::prelude::*;

use checks::{MOST_ABOUT, Star, larger};
use quadric::Quadric;
use surface::{Kind, Surface};

/// Weight of the planes that stand on the border, against triangles of that side.
const BORDER: f64 = 4.0;

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

/// A simplified mesh.
pub(super) struct Simplified {
    /// Corners are numbers of the given vertices.
    pub(super) triangles: Vec<[u32; 3]>,
    /// For each, the number of the given triangle that it comes from.
    pub(super) source: Vec<u32>,
    /// For each given vertex, the one that it went into: itself where it stayed.
    pub(super) onto: Vec<u32>,
    /// How far vertices have strayed at most; not more than the error allowed.
    pub(super) error: f64,
}

/// Collapses edges until the next would stray farther than `most_error`, a length, or leave fewer
/// than `least_triangles`.
///
/// Triangles that repeat a corner, or have one that is not there, are left out.
pub(super) fn simplify(
    vertices: &[DVec3],
    triangles: &[[u32; 3]],
    most_error: f64,
    least_triangles: usize,
) -> Simplified {
    let mut simplifier = Simplifier::new(vertices, triangles, most_error, least_triangles);
    while simplifier.pass() {}
    simplifier.finish()
}

/// A squared error in 32 bits that sort alike.
type Rank = u32;

/// A vertex has nowhere to go.
const NONE: Rank = Rank::MAX;

/// A vertex has not been looked at since what is around it changed.
const UNKNOWN: Rank = Rank::MAX - 1;

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

struct Simplifier<'a> {
    surface: Surface<'a>,
    most_error: f64,
    least_triangles: usize,
    kinds: Vec<Kind>,
    /// Whether the triangles about each inner vertex all run the same way round, so that each of its
    /// neighbours is the first in one of them. Collapses leave that so.
    run_alike: bool,
    /// About their vertices.
    quadrics: Vec<Quadric>,
    /// How far those that went into a vertex have strayed at most.
    strayed: Vec<f64>,
    onto: Vec<u32>,
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
    targets: Vec<(Rank, u32)>,
    apexes: Vec<[u32; 2]>,
}

impl<'a> Simplifier<'a> {
    fn new(
        vertices: &'a [DVec3],
        triangles: &[[u32; 3]],
        most_error: f64,
        least_triangles: usize,
    ) -> Self {
        let surface = Surface::new(vertices, triangles);
        let numbers = 0..vertices.len() as u32;
        let kinds: Vec<Kind> = numbers
            .clone()
            .into_par_iter()
            .map(|v| surface.kind(v, MOST_ABOUT))
            .collect();
        let turned = |v: u32| kinds[v as usize] == Kind::Inner && !surface.run_alike_about(v);
        Self {
            run_alike: !numbers.clone().into_par_iter().any(turned),
            quadrics: numbers
                .clone()
                .into_par_iter()
                .map(|v| quadric(&surface, v, kinds[v as usize]))
                .collect(),
            kinds,
            surface,
            most_error: larger(0.0, most_error),
            least_triangles,
            strayed: vec![0.0; vertices.len()],
            onto: numbers.collect(),
            next: vec![UNKNOWN; vertices.len()],
            changed: vec![false; vertices.len()],
            candidates: Vec::new(),
            moved: false,
            take_all: false,
            star: Star::default(),
            target: Star::default(),
            targets: Vec::new(),
            apexes: Vec::new(),
        }
    }

    /// Collapses the cheapest; false when nothing is left to do.
    fn pass(&mut self) -> bool {
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
            if self.surface.live() < self.least_triangles.saturating_add(2) {
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
        let mut next = std::mem::take(&mut self.next);
        next.par_iter_mut().enumerate().for_each(|(v, next)| {
            if *next == UNKNOWN {
                *next = self.cheapest(v as u32);
            }
        });
        let candidates = (0..).zip(&next).filter(|(_, next)| **next != NONE);
        self.candidates.clear();
        self.candidates
            .extend(candidates.map(|(v, next)| (*next, v)));
        self.next = next;
    }

    /// The rank of the cheapest way for a vertex to go.
    fn cheapest(&self, v: u32) -> Rank {
        let mover = self.mover(v);
        let rank = |w: u32| mover.rank(self.surface.place(w));
        match self.kinds[v as usize] {
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
                star.read(&self.surface, v);
                let along = star.neighbours().filter(|n| n.1 == 1);
                along.map(|(w, _)| rank(w)).fold(NONE, Rank::min)
            }
            Kind::Fixed => NONE,
        }
    }

    fn mover(&self, v: u32) -> Mover {
        Mover {
            from: self.surface.place(v),
            planes: self.quadrics[v as usize].mean(),
            most_error_sq: self.most_error * self.most_error,
        }
    }

    /// Sorts the share of the candidates that this pass takes, forgets the others, and returns the
    /// highest rank taken.
    fn cheapest_first(&mut self) -> Rank {
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
        self.star.read(&self.surface, v);
        let next = self.find_targets(v, limit);
        let mut waits = false;
        for i in 0..self.targets.len() {
            let w = self.targets[i].1;
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

    /// Lists where a vertex may go at a rank up to the limit, the cheapest first, unless that was
    /// refused before; returns the lowest rank beyond.
    fn find_targets(&mut self, v: u32, limit: Rank) -> Rank {
        let mover = self.mover(v);
        let is_inner = self.kinds[v as usize] == Kind::Inner;
        let refused_below = match self.next[v as usize] {
            UNKNOWN => 0,
            known => known,
        };
        let mut next = NONE;
        self.targets.clear();
        for (w, _) in self.star.neighbours().filter(|n| is_inner || n.1 == 1) {
            match mover.rank(self.surface.place(w)) {
                rank if rank > limit => next = next.min(rank),
                rank if rank >= refused_below => self.targets.push((rank, w)),
                _ => {}
            }
        }
        self.targets.sort_unstable();
        next
    }

    /// How far vertices will have strayed when v moves onto w, if it may.
    fn try_target(&mut self, v: u32, w: u32) -> Option<f64> {
        if self.surface.crowd(w) > MOST_ABOUT
            || !checks::keeps_triangles(&self.surface, &self.star, w)
        {
            return None;
        }
        self.target.read(&self.surface, w);
        let (surface, star, target) = (&self.surface, &self.star, &self.target);
        let strayed = self.strayed[v as usize] + checks::distance_left(surface, star, w);
        let apexes = &mut self.apexes;
        let may = strayed <= self.most_error
            && checks::keeps_topology(star, target, self.kinds[v as usize])
            && checks::keeps_crowd_small(star, target)
            && checks::keeps_sharp_edge(surface, star, w, apexes)
            && checks::keeps_folds_open(surface, star, target, apexes);
        may.then_some(strayed)
    }

    fn collapse(&mut self, v: u32, w: u32, strayed: f64) {
        for (neighbour, _) in self.star.neighbours().chain(self.target.neighbours()) {
            self.next[neighbour as usize] = UNKNOWN;
        }
        let step = self.surface.place(w) - self.surface.place(v);
        let planes = self.quadrics[v as usize].about(step);
        self.quadrics[w as usize] += planes;
        self.strayed[w as usize] = larger(self.strayed[w as usize], strayed);
        self.onto[v as usize] = w;
        self.changed[v as usize] = true;
        self.changed[w as usize] = true;
        self.surface.collapse(v, w);
    }

    fn finish(mut self) -> Simplified {
        for v in 0..self.onto.len() {
            let mut w = self.onto[v];
            while self.onto[w as usize] != w {
                w = self.onto[w as usize];
            }
            self.onto[v] = w;
        }
        let (triangles, source) = self.surface.into_triangles();
        Simplified {
            triangles,
            source,
            onto: self.onto,
            error: self.strayed.into_iter().fold(0.0, larger),
        }
    }
}

/// The planes of the triangles about a vertex, and of the border: at right angles to its triangle.
fn quadric(surface: &Surface, v: u32, kind: Kind) -> Quadric {
    let p = surface.place(v);
    let mut sum = Quadric::default();
    for ends in surface.fan(v) {
        let [a, b] = ends.map(|end| surface.place(end) - p);
        let normal = a.cross(b);
        sum += plane(normal, normal.length());
        if kind == Kind::Border {
            for (end, side) in ends.into_iter().zip([a, b]) {
                if surface.fan(v).filter(|f| f.contains(&end)).count() == 1 {
                    sum += plane(side.cross(normal), BORDER * side.length_squared());
                }
            }
        }
    }
    sum
}

fn plane(normal: DVec3, weight: f64) -> Quadric {
    let length = normal.length();
    if length > 0.0 {
        Quadric::of_plane(normal / length, weight)
    } else {
        Quadric::default()
    }
}
