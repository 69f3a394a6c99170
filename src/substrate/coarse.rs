//! Coarser copies of a surface, for walkers that are far from anything that matters.
//!
//! A walk over a fine mesh crosses an edge at every turn, and most of them where nothing is near.
//! A copy has fewer triangles. Each triangle of the surface has one of the copy that stands for
//! it, one of those that its own corners went into: so faces of a thin plate have copies of their
//! own, and a walker that comes back from the copy is on the face that it left from. A copy may have
//! a coarser one of its own.

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::lying::{Lying, ball_about, height, middle, normal};
use super::simplify::{Limits, simplify};
use super::{Component, Facet, Substrate, caps, weld};

/// A copy to walk on where nothing is near is worth having with fewer triangles than this share of the surface's.
const WORTH: f64 = 0.25;

/// The same for one that hardly strays, to walk on everywhere.
const NEAR_WORTH: f64 = 1.0 / 16.0;

/// That is first tried on two parts of the surface, each of one in so many triangles but of no more than these.
const TRIED_SHARE: usize = 32;
const MOST_TRIED: usize = 1 << 13;

/// Of a part more is left, for its rim is.
const TRIED_WORTH: f64 = 2.0 * NEAR_WORTH;

/// The fewest triangles of a piece's copy, if the piece has as many.
const LEAST_TRIANGLES: usize = 200;

/// A copy's copy may stray this many times as far.
const COARSER: f64 = 4.0;

/// No copy may stray farther than this share of the bounding box's diagonal.
const MOST_ERROR: f64 = 0.04;

/// Triangles that one thread takes at a time. What comes of one may depend on the one before.
const SHARE: usize = 1 << 12;

/// Triangles of the surface for each cell of a triangle of the copy.
const PER_CELL: usize = 4;

/// A coarser copy of a substrate, in the same local units.
pub(crate) struct Coarse {
    surface: Substrate,
    /// For each triangle of the fine surface, the one that stands for it.
    above: Vec<u32>,
    cells: Vec<Cells>,
    /// For each cell, the triangle of the fine surface whose centroid is nearest to its middle.
    below: Vec<u32>,
    error: f64,
    /// For each of its triangles, how far those of the fine surface that it stands for are from it at
    /// most.
    deviations: Vec<f64>,
}

/// Cells of one triangle: parallelograms, so that half of them lie outside of it.
#[derive(Clone, Copy)]
struct Cells {
    begin: u32,
    along: u32,
}

/// A triangle stands for one that is above or below it by no more than this share of the error: to look
/// for a nearer one takes longer than all else, and brings nobody nearer than the farthest.
const NEAR: f64 = 0.5;

/// No triangle.
const NONE: u32 = u32::MAX;

/// Coarser copies of a substrate, each of the one before.
#[derive(Default)]
pub(crate) struct Copies {
    /// The finest first.
    pub(crate) all: Vec<Coarse>,
    /// Whether the first is one that hardly strays at all.
    pub(crate) has_near: bool,
}

/// What copies are made for.
#[derive(Clone, Copy)]
pub(crate) struct Errors {
    /// How far one that hardly strays may stray, where one is asked for; local units.
    pub(crate) near: Option<f64>,
    /// How far the finest of the others may.
    pub(crate) far: f64,
}

/// What a copy is for.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Purpose {
    /// To walk on everywhere.
    Near,
    /// To walk on where nothing is near.
    Far,
}

/// The last copies that were made of a substrate, by their errors: runs of one radius share them.
#[derive(Default)]
pub(super) struct Kept(Mutex<Option<(Errors, Arc<Copies>)>>);

impl Substrate {
    /// Ever coarser copies. They are made now if the last asked for had other errors. None where they are not
    /// worth having.
    pub(crate) fn coarser(&self, errors: Errors) -> Arc<Copies> {
        let kept = || {
            self.coarser
                .0
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
        };
        // Where none that hardly strays came of it, they serve those who asked for none too.
        let serves = |(made_for, copies): &&(Errors, Arc<Copies>)| {
            let same = made_for.near == errors.near;
            made_for.far == errors.far && (same || errors.near.is_none() && !copies.has_near)
        };
        if let Some((_, copies)) = kept().as_ref().filter(serves) {
            return Arc::clone(copies);
        }
        // Not under the lock: a thread that helps to make them may begin another run meanwhile.
        let copies = Arc::new(self.copies(errors));
        *kept() = Some((errors, Arc::clone(&copies)));
        copies
    }

    fn copies(&self, errors: Errors) -> Copies {
        let [low, high] = self.bounds();
        let most = MOST_ERROR * low.distance(high);
        let near = errors
            .near
            .and_then(|error| Coarse::new(self, error, Purpose::Near));
        let mut copies = Copies {
            has_near: near.is_some(),
            all: near.into_iter().collect(),
        };
        let is_enough = |copy: &Coarse| !copy.surface.is_fine();
        if copies.all.first().is_some_and(is_enough) {
            return copies;
        }
        let mut error = errors.far;
        while error <= most {
            let finer = copies.all.last().map_or(self, Coarse::surface);
            copies.all.extend(Coarse::new(finer, error, Purpose::Far));
            error *= COARSER;
        }
        copies
    }

    /// Whether parts of it can do with few triangles, by an error that hardly strays.
    pub(crate) fn is_smooth(&self, error: f64) -> bool {
        let all = self.triangles();
        let part = (all.len() / TRIED_SHARE).min(MOST_TRIED);
        let limits = Limits {
            most_error: error,
            least_triangles: 0,
            at_once: true,
        };
        let left = |begin: &usize| {
            let (vertices, tried) = used(&self.vertices, &all[*begin..][..part]);
            simplify(&vertices, &tried, limits).triangles.len()
        };
        let left: usize = [all.len() / 3, all.len() / 2].iter().map(left).sum();
        left as f64 <= TRIED_WORTH * (2 * part) as f64
    }
}

impl Coarse {
    /// A copy simplified to this error, in local units; [`deviations`](Self::deviations) say how far
    /// places stray from it. None where it would not be much coarser, or would not hang together as
    /// the surface does.
    pub(crate) fn new(fine: &Substrate, error: f64, purpose: Purpose) -> Option<Self> {
        let worth = match purpose {
            Purpose::Near => NEAR_WORTH,
            Purpose::Far => WORTH,
        };
        let least = LEAST_TRIANGLES * fine.components().len();
        if is_too_fine(least, fine, worth) {
            return None;
        }
        let limits = Limits {
            most_error: error,
            least_triangles: least,
            at_once: purpose == Purpose::Near,
        };
        let simplified = simplify(fine.vertices(), fine.triangles(), limits);
        debug_assert!(simplified.error <= error, "{}", simplified.error);
        debug_assert_eq!(simplified.source.len(), simplified.triangles.len());
        if is_too_fine(simplified.triangles.len(), fine, worth) {
            return None;
        }
        let (vertices, triangles) = used(fine.vertices(), &simplified.triangles);
        let surface = Substrate::from_welded(weld::Welded {
            units: *fine.units(),
            vertices,
            source: (0..triangles.len() as u32).collect(),
            parts: caps::Parts::new(),
            triangles,
            degenerate: 0,
            duplicate: 0,
            merged: 0,
            seams: 0,
        });
        if surface.components().len() != fine.components().len() {
            return None;
        }
        let stand_ins = stand_ins(
            fine,
            &surface,
            &simplified.triangles,
            &simplified.onto,
            error,
        )?;
        let (away, above): (Vec<f64>, Vec<u32>) = stand_ins.into_iter().unzip();
        if purpose == Purpose::Near && !keeps_pieces(fine, &surface, &above) {
            return None;
        }
        let below = Grouped::new(surface.triangles().len(), &above);
        let deviations = deviations(fine, &surface, &away, &below);
        let (cells, below) = cells(fine, &surface, &below);
        Some(Self {
            surface,
            above,
            cells,
            below,
            error,
            deviations,
        })
    }

    /// The copy.
    pub(crate) fn surface(&self) -> &Substrate {
        &self.surface
    }

    /// How far it was allowed to stray, local units.
    pub(crate) fn error(&self) -> f64 {
        self.error
    }

    /// For each triangle of the copy, how far from it the places are that it stands for, at most, in local
    /// units; on the surface that the fine one is a copy of, where these are the fine one's own.
    pub(crate) fn deviations(&self, finer: Option<&[f64]>) -> Vec<f64> {
        let mut deviations = vec![0.0f64; self.deviations.len()];
        for (&above, &of_finer) in self.above.iter().zip(finer.unwrap_or_default()) {
            let most = &mut deviations[above as usize];
            *most = most.max(of_finer);
        }
        let own = deviations.iter_mut().zip(&self.deviations);
        own.for_each(|(all, own)| *all += own);
        deviations
    }

    /// For each triangle of the fine surface, the one that stands for it.
    pub(crate) fn stand_ins(&self) -> &[u32] {
        &self.above
    }

    /// A triangle of the fine surface near to a place on the copy, given by its triangle and where
    /// that place is in its chart.
    pub(crate) fn below(&self, facet: &Facet, at: DVec2) -> u32 {
        let cells = self.cells[facet.triangle as usize];
        self.below[cells.index(facet.chart.shares(at))]
    }
}

impl Cells {
    /// The cell of a place given in shares of the triangle's first and last edge.
    fn index(self, shares: DVec2) -> usize {
        let [x, y] = self.cell(shares);
        (self.begin + y * self.along + x) as usize
    }

    /// The same by its column and row.
    fn cell(self, shares: DVec2) -> [u32; 2] {
        let n = f64::from(self.along);
        let cell = (shares * n).clamp(DVec2::ZERO, DVec2::splat(n - 1.0));
        [cell.x as u32, cell.y as u32]
    }

    fn all(self) -> Range<usize> {
        self.begin as usize..(self.begin + self.along * self.along) as usize
    }

    /// The middle of a cell, as shares of the triangle's first and last edge.
    fn middle(self, cell: [u32; 2]) -> DVec2 {
        let [x, y] = cell.map(f64::from);
        (DVec2::new(x, y) + 0.5) / f64::from(self.along)
    }
}

/// Whether for all of a piece one piece of the copy stands, and for each another: where two share a corner and lie
/// on one another, what is nearest may be the other's.
fn keeps_pieces(fine: &Substrate, copy: &Substrate, above: &[u32]) -> bool {
    let all = fine.components();
    if all.len() == 1 {
        return true;
    }
    let piece = |t: u32| copy.component_of(above[t as usize]).triangles.start;
    let mut found: Vec<u32> = all.iter().map(|c| piece(c.triangles.start)).collect();
    let keeps = |(c, &of_first): (&Component, &u32)| {
        let mut rest = c.triangles.clone();
        rest.all(|t| piece(t) == of_first)
    };
    let each_keeps = all.iter().zip(&found).all(keeps);
    found.sort_unstable();
    found.dedup();
    each_keeps && found.len() == all.len()
}

/// Whether a copy of so many triangles is not worth having.
fn is_too_fine(triangles: usize, fine: &Substrate, worth: f64) -> bool {
    triangles as f64 > worth * fine.triangles().len() as f64
}

/// The vertices that triangles use, and the triangles by their numbers among these.
fn used(vertices: &[DVec3], triangles: &[[u32; 3]]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut numbers = vec![NONE; vertices.len()];
    let mut kept = Vec::new();
    let mut number = |v: u32| {
        let number = &mut numbers[v as usize];
        if *number == NONE {
            *number = kept.len() as u32;
            kept.push(vertices[v as usize]);
        }
        *number
    };
    let triangles = triangles.iter().map(|t| t.map(&mut number)).collect();
    (kept, triangles)
}

/// The coarse triangle that stands for each fine one, and its distance from that one's middle.
///
/// It is that of the triangle before, or the first about the vertices that the corners went into, which faces
/// the same way and above or below which this one is, and near; where there is none, the nearest that faces the
/// same way, if that is within the error, or the nearest.
fn stand_ins(
    fine: &Substrate,
    coarse: &Substrate,
    triangles: &[[u32; 3]],
    onto: &[u32],
    error: f64,
) -> Option<Vec<(f64, u32)>> {
    let corners: Vec<[u32; 3]> = (0..triangles.len() as u32)
        .map(|t| triangles[coarse.source_triangle(t) as usize])
        .collect();
    let about = Grouped::new(onto.len(), corners.as_flattened());
    let lying: Vec<Lying> = (0..triangles.len() as u32)
        .into_par_iter()
        .map(|t| Lying::new(coarse, t))
        .collect();
    // The triangle before is near, and mostly has the same one.
    let one = |t: u32, last: u32| {
        let [a, b, c] = fine.corners(t);
        let (middle, normal) = (middle([a, b, c]), normal([a, b, c]));
        let into = fine.triangles()[t as usize].map(|v| onto[v as usize]);
        let is_about = |s: u32| corners[s as usize].iter().any(|v| into.contains(v));
        let around = || into.iter().flat_map(|v| about.of(*v)).map(|&i| i / 3);
        let last = Some(last).filter(|last| *last != NONE && is_about(*last));
        let faces_alike = |s: u32| lying[s as usize].normal.dot(normal) > 0.0;
        let stands = |s: u32| {
            let height = height(&lying[s as usize].facet, middle);
            let height = height.filter(|h| *h <= NEAR * error)?;
            faces_alike(s).then_some((height, s))
        };
        let nearest = |may: &dyn Fn(u32) -> bool| {
            // Most that are asked are seen to be too far by the ball about them.
            let nearer = |s: u32, than: f64| {
                let (centre, radius) = lying[s as usize].ball;
                let most = than + radius;
                let may = centre.distance_squared(middle) <= most * most && may(s);
                may.then(|| distance(coarse, s, middle))
            };
            let from_all = || {
                around().fold((f64::INFINITY, NONE), |first, s| {
                    let away = nearer(s, first.0).unwrap_or(f64::INFINITY);
                    if (away, s) < first { (away, s) } else { first }
                })
            };
            let last = last.filter(|last| may(*last));
            let first = last.map_or_else(from_all, |last| (distance(coarse, last, middle), last));
            (first.1 != NONE).then(|| nearest_from(coarse, first, nearer))
        };
        let above = last.into_iter().chain(around()).find_map(stands);
        let beside = || nearest(&faces_alike).filter(|found| found.0 <= error);
        above.or_else(beside).or_else(|| nearest(&|_| true))
    };
    let shares = fine.triangles().par_chunks(SHARE).enumerate();
    let all: Option<Vec<Vec<(f64, u32)>>> = shares
        .map(|(i, share)| {
            let mut last = NONE;
            let begin = (i * SHARE) as u32;
            let all = (begin..begin + share.len() as u32).map(|t| {
                let found = one(t, last)?;
                last = found.1;
                Some(found)
            });
            all.collect()
        })
        .collect();
    all.map(|all| all.concat())
}

/// Vertices that are remembered to have been asked about.
const ASKED: usize = 256;

/// For each coarse triangle, the greatest distance of the fine ones that it stands for, whose middles'
/// distances are given. One that stands for none has the greatest of all.
fn deviations(fine: &Substrate, coarse: &Substrate, away: &[f64], below: &Grouped) -> Vec<f64> {
    let of = |s: u32| {
        let facet = coarse.facet(s);
        // Triangles that come one after the other share most corners.
        let mut asked = [NONE; ASKED];
        below.of(s).iter().fold(0.0, |greatest, &t| {
            // Most are seen to be nearer than another by a ball about them.
            if away[t as usize] + ball_about(fine.corners(t)).1 <= greatest {
                return greatest;
            }
            let corners = fine.triangles()[t as usize].into_iter();
            let new =
                corners.filter(|&v| std::mem::replace(&mut asked[v as usize % ASKED], v) != v);
            new.fold(greatest, |greatest, v| {
                let p = fine.vertices()[v as usize];
                // Most are straight above or below, and seen to be nearer by that.
                match height(&facet, p).is_some_and(|h| h < SURELY_LESS * greatest) {
                    true => greatest,
                    false => distance(coarse, s, p).max(greatest),
                }
            })
        })
    };
    let all = 0..coarse.triangles().len() as u32;
    let mut deviations: Vec<f64> = all.clone().into_par_iter().map(of).collect();
    let greatest = deviations.iter().copied().fold(0.0, f64::max);
    for s in all.filter(|&s| below.of(s).is_empty()) {
        deviations[s as usize] = greatest;
    }
    deviations
}

/// What is straight above a triangle is no farther from it than it is high, but for round-off, for which this leaves
/// room.
const SURELY_LESS: f64 = 0.99;

/// The distance of a triangle from a point.
fn distance(surface: &Substrate, triangle: u32, p: DVec3) -> f64 {
    let nearest = surface.nearest_in(triangle, p);
    surface.position(&nearest).distance(p)
}

/// The triangle to which ever nearer ones about the corners lead, and its distance. `nearer` is a
/// triangle's distance, unless that is known to be greater than some other.
fn nearest_from(
    coarse: &Substrate,
    first: (f64, u32),
    nearer: impl Fn(u32, f64) -> Option<f64>,
) -> (f64, u32) {
    let mut nearest = first;
    loop {
        let before = nearest.1;
        for v in coarse.triangles()[before as usize] {
            for s in coarse.half_edges_at(v).iter().map(|h| h / 3) {
                if s == before || s == nearest.1 {
                    continue;
                }
                if let Some(away) = nearer(s, nearest.0).filter(|away| *away < nearest.0) {
                    nearest = (away, s);
                }
            }
        }
        if nearest.1 == before {
            return nearest;
        }
    }
}

/// Cells for all coarse triangles, and the fine triangle to begin with in each.
fn cells(fine: &Substrate, coarse: &Substrate, below: &Grouped) -> (Vec<Cells>, Vec<u32>) {
    let mut begin = 0;
    let cells: Vec<Cells> = (0..coarse.triangles().len() as u32)
        .map(|t| {
            let along = (2.0 * below.of(t).len() as f64 / PER_CELL as f64).sqrt();
            let along = along.max(1.0) as u32;
            let cells = Cells { begin, along };
            begin += along * along;
            cells
        })
        .collect();
    let first = (0..coarse.triangles().len())
        .into_par_iter()
        .flat_map_iter(|t| begin_in(fine, coarse, t as u32, cells[t], below.of(t as u32)))
        .collect();
    (cells, first)
}

/// The fine triangles to begin with in the cells of one coarse triangle.
fn begin_in(
    fine: &Substrate,
    coarse: &Substrate,
    triangle: u32,
    cells: Cells,
    below: &[u32],
) -> Vec<u32> {
    let Facet { chart, frame, .. } = coarse.facet(triangle);
    let shares = |t: u32| chart.shares(frame.flatten(middle(fine.corners(t))));
    let mut nearest = vec![(f64::INFINITY, NONE); cells.all().len()];
    for &t in below {
        let shares = shares(t);
        let [x, y] = cells.cell(shares);
        let away = cells.middle([x, y]).distance_squared(shares);
        let cell = &mut nearest[(y * cells.along + x) as usize];
        if away < cell.0 {
            *cell = (away, t);
        }
    }
    spread(nearest, cells.along as usize)
}

/// Fills empty cells from their neighbours, ever farther.
fn spread(mut cells: Vec<(f64, u32)>, along: usize) -> Vec<u32> {
    while cells.iter().any(|c| c.1 == NONE) && cells.iter().any(|c| c.1 != NONE) {
        let before = cells.clone();
        for (i, cell) in cells.iter_mut().enumerate().filter(|(_, c)| c.1 == NONE) {
            let (x, y) = (i % along, i / along);
            let beside = [
                (x > 0).then(|| i - 1),
                (x + 1 < along).then(|| i + 1),
                (y > 0).then(|| i - along),
                (y + 1 < along).then(|| i + along),
            ];
            let known = beside.into_iter().flatten().map(|j| before[j]);
            *cell = known.into_iter().find(|c| c.1 != NONE).unwrap_or(*cell);
        }
    }
    cells.into_iter().map(|c| c.1).collect()
}

/// The positions of values in a list, by value.
struct Grouped {
    begin: Vec<u32>,
    sorted: Vec<u32>,
}

impl Grouped {
    fn new(most: usize, values: &[u32]) -> Self {
        let mut begin = vec![0; most + 2];
        values.iter().for_each(|&v| begin[v as usize + 2] += 1);
        (2..begin.len()).for_each(|i| begin[i] += begin[i - 1]);
        let mut sorted = vec![0; values.len()];
        for (i, &v) in (0..).zip(values) {
            let at = &mut begin[v as usize + 1];
            sorted[*at as usize] = i;
            *at += 1;
        }
        Self { begin, sorted }
    }

    fn of(&self, value: u32) -> &[u32] {
        let [from, to] = [value, value + 1].map(|v| self.begin[v as usize] as usize);
        &self.sorted[from..to]
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn on_threads(threads: usize, surface: &Substrate, error: f64) -> Coarse {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let copy = pool
            .expect("a pool")
            .install(|| Coarse::new(surface, error, Purpose::Far));
        copy.expect("worth having")
    }

    #[test]
    fn copies_are_the_same_on_any_number_of_threads() {
        let boulder = Substrate::load(Path::new("meshes/boulder.glb")).expect("a mesh");
        let error = boulder.units().length_to_local(8.0 * boulder.auto_radius());
        let one = on_threads(1, &boulder, error);
        for threads in [2, 3, 8] {
            let many = on_threads(threads, &boulder, error);
            assert_eq!(one.surface.vertices(), many.surface.vertices());
            assert_eq!(one.surface.triangles(), many.surface.triangles());
            assert!(one.above == many.above && one.below == many.below);
            assert_eq!(one.deviations, many.deviations);
        }
    }

    /// A plate of unit sides and this thickness, each face cut into so many squares along its sides.
    fn plate(thickness: f64, squares: u32) -> Substrate {
        let mut soup = crate::substrate::Soup::default();
        let at = |i: u32| f64::from(i) / f64::from(squares);
        let mut add = |corners: [[f64; 3]; 4]| {
            let first = soup.positions.len() as u32;
            soup.positions.extend(corners);
            let halves = [[0, 1, 2], [0, 2, 3]];
            soup.triangles.extend(halves.map(|t| t.map(|k| first + k)));
        };
        for i in 0..squares {
            let (from, to) = (at(i), at(i + 1));
            for j in 0..squares {
                let (low, high) = (at(j), at(j + 1));
                let round = [[from, low], [to, low], [to, high], [from, high]];
                add(round.map(|[x, y]| [x, y, thickness]));
                add([0, 3, 2, 1].map(|k| [round[k][0], round[k][1], 0.0]));
            }
            let mut rim = |from: [f64; 2], to: [f64; 2]| {
                let place = |[x, y]: [f64; 2], z| [x, y, z];
                add([
                    place(from, 0.0),
                    place(to, 0.0),
                    place(to, thickness),
                    place(from, thickness),
                ]);
            };
            rim([from, 0.0], [to, 0.0]);
            rim([1.0, from], [1.0, to]);
            rim([1.0 - from, 1.0], [1.0 - to, 1.0]);
            rim([0.0, 1.0 - from], [0.0, 1.0 - to]);
        }
        Substrate::from_soup(soup).expect("a mesh")
    }

    #[test]
    fn what_stands_for_a_face_of_a_plate_is_not_on_the_other() {
        for share in [0.3, 1.0] {
            let plate = plate(0.005, 110);
            let error = 0.005 / share * plate.units().length_to_local(1.0);
            let copy = Coarse::new(&plate, error, Purpose::Far).expect("worth having");
            let is_turned = |t: &u32| {
                let above = copy.surface.normal(copy.above[*t as usize]);
                plate.normal(*t).dot(above) < -0.5
            };
            let all = 0..plate.triangles().len() as u32;
            let turned = all.filter(is_turned).count();
            assert_eq!(
                turned,
                0,
                "{share}: {} triangles",
                copy.surface.triangles().len()
            );
        }
    }

    #[test]
    fn those_that_were_made_last_are_made_once() {
        let boulder = Substrate::load(Path::new("meshes/boulder.glb")).expect("a mesh");
        let radius = boulder.units().length_to_local(boulder.auto_radius());
        let made = |near: Option<f64>, far: f64| boulder.coarser(Errors { near, far });
        let first = made(Some(0.02 * radius), 8.0 * radius);
        assert!(!first.has_near && first.all.len() == 2);
        for near in [Some(0.02 * radius), None] {
            assert!(Arc::ptr_eq(&first, &made(near, 8.0 * radius)));
        }
        assert!(!Arc::ptr_eq(&first, &made(None, 9.0 * radius)));
    }
}
