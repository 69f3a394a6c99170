//! The mesh while it is being simplified: triangles, and those about each vertex.

use glam::DVec3;

use super::checks::MOST_ABOUT;

/// The corners after each.
const AFTER: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];

/// What a collapse has left nothing of.
const GONE: [u32; 3] = [u32::MAX; 3];

/// How the triangles about a vertex join. A collapse that keeps the topology keeps it too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// In a ring: the vertex may go to any neighbour.
    Inner,
    /// In a row: it may go along the border.
    Border,
    /// In any other way, or too many; the vertex stays.
    Fixed,
}

/// Triangles over given places.
///
/// The triangles about a vertex are those of the last [`Surface::renew`], read as they are now. So
/// they are complete until something collapses onto that vertex.
pub(super) struct Surface<'a> {
    places: &'a [DVec3],
    triangles: Vec<[u32; 3]>,
    /// Number of each triangle in the given list.
    source: Vec<u32>,
    /// Where v is a corner of triangles is `about[offsets[v]..offsets[v + 1]]`, with 3 · triangle + k for the k-th.
    offsets: Vec<u32>,
    about: Vec<u32>,
    live: usize,
}

impl<'a> Surface<'a> {
    /// Of [`valid`] triangles.
    pub(super) fn new(places: &'a [DVec3], triangles: Vec<[u32; 3]>) -> Self {
        let mut surface = Self {
            places,
            live: triangles.len(),
            source: (0..triangles.len() as u32).collect(),
            triangles,
            offsets: Vec::new(),
            about: Vec::new(),
        };
        surface.collect_fans();
        surface
    }

    pub(super) fn place(&self, v: u32) -> DVec3 {
        self.places[v as usize]
    }

    /// How many triangles are left.
    pub(super) fn live(&self) -> usize {
        self.live
    }

    /// Forgets what is gone, and collects anew which triangles are about each vertex.
    pub(super) fn renew(&mut self) {
        if self.live < self.triangles.len() {
            self.forget_gone();
            self.collect_fans();
        }
    }

    fn forget_gone(&mut self) {
        let mut kept = 0;
        for i in 0..self.triangles.len() {
            let triangle = self.triangles[i];
            self.triangles[kept] = triangle;
            self.source[kept] = self.source[i];
            kept += usize::from(triangle != GONE);
        }
        self.triangles.truncate(kept);
        self.source.truncate(kept);
    }

    fn collect_fans(&mut self) {
        let corners = self.triangles.as_flattened();
        self.offsets.clear();
        self.offsets.resize(self.places.len() + 1, 0);
        corners.iter().for_each(|&v| self.offsets[v as usize] += 1);
        let mut sum = 0;
        for offset in &mut self.offsets {
            sum += *offset;
            *offset = sum;
        }
        self.about.resize(corners.len(), 0);
        for (corner, &v) in corners.iter().enumerate().rev() {
            self.offsets[v as usize] -= 1;
            self.about[self.offsets[v as usize] as usize] = corner as u32;
        }
    }

    fn about(&self, v: u32) -> &[u32] {
        let v = v as usize;
        &self.about[self.offsets[v] as usize..self.offsets[v + 1] as usize]
    }

    /// At most how many triangles are about a vertex: gone ones count until the next renewal.
    pub(super) fn crowd(&self, v: u32) -> usize {
        self.about(v).len()
    }

    /// For each triangle about a vertex that is not gone, its next two corners.
    pub(super) fn fan(&self, v: u32) -> impl Iterator<Item = [u32; 2]> + '_ {
        let there = |&corner: &u32| self.ends_at(corner);
        let all = self.about(v).iter().map(there);
        all.filter_map(|(ends, is_gone)| (!is_gone).then_some(ends))
    }

    /// Lists the same, without a branch for each.
    pub(super) fn list_fan(&self, v: u32, fan: &mut Vec<[u32; 2]>) {
        let about = self.about(v);
        fan.clear();
        fan.resize(about.len(), [0; 2]);
        let mut listed = 0;
        for &corner in about {
            let (ends, is_gone) = self.ends_at(corner);
            fan[listed] = ends;
            listed += usize::from(!is_gone);
        }
        fan.truncate(listed);
    }

    /// The other two corners of the triangle that one is of, and whether that is gone.
    fn ends_at(&self, corner: u32) -> ([u32; 2], bool) {
        let triangle = &self.triangles[corner as usize / 3];
        let ends = AFTER[corner as usize % 3].map(|k| triangle[k]);
        (ends, *triangle == GONE)
    }

    /// How the triangles about a vertex join, and whether they are a ring that all runs the same way round.
    pub(super) fn kind(&self, v: u32) -> (Kind, bool) {
        if self.crowd(v) > MOST_ABOUT {
            return (Kind::Fixed, false);
        }
        if self.is_ring_about(v) {
            return (Kind::Inner, true);
        }
        let mut fan: Vec<[u32; 2]> = self.fan(v).collect();
        let mut corners = fan.as_flattened().to_vec();
        corners.sort_unstable();
        let times = corners.chunk_by(|a, b| a == b);
        let (ends, most) = times.fold((0, 0), |(ends, most), same| {
            (ends + usize::from(same.len() == 1), most.max(same.len()))
        });
        let kind = match (ends, most, is_one_row(&mut fan)) {
            (0, 2, true) if fan.len() > 2 => Kind::Inner,
            (2, 1..=2, true) => Kind::Border,
            _ => Kind::Fixed,
        };
        (kind, false)
    }

    /// Whether the triangles about a vertex, at most [`MOST_ABOUT`], are a ring that all runs the same way
    /// round.
    pub(super) fn is_ring_about(&self, v: u32) -> bool {
        let (mut fan, mut all) = ([[0; 2]; MOST_ABOUT], 0);
        for ends in self.fan(v) {
            fan[all] = ends;
            all += 1;
        }
        is_one_ring(&fan[..all])
    }

    /// Moves a vertex to a neighbour.
    pub(super) fn collapse(&mut self, from: u32, onto: u32) {
        let fan = self.offsets[from as usize] as usize..self.offsets[from as usize + 1] as usize;
        for corner in &self.about[fan] {
            let triangle = &mut self.triangles[*corner as usize / 3];
            if *triangle == GONE {
                continue;
            }
            *triangle = triangle.map(|v| if v == from { onto } else { v });
            if repeats_corner(*triangle) {
                *triangle = GONE;
                self.live -= 1;
            }
        }
    }

    /// The triangles that are left, and their numbers in the given list.
    pub(super) fn into_triangles(mut self) -> (Vec<[u32; 3]>, Vec<u32>) {
        self.forget_gone();
        (self.triangles, self.source)
    }
}

/// The triangles that do not repeat a corner and have none that is not there, and their numbers in the given list.
pub(super) fn valid(places: usize, given: &[[u32; 3]]) -> (Vec<[u32; 3]>, Vec<u32>) {
    let is_valid = |(t, _): &([u32; 3], u32)| {
        let exist = t.iter().all(|&v| (v as usize) < places);
        exist && !repeats_corner(*t)
    };
    given.iter().copied().zip(0..).filter(is_valid).unzip()
}

fn repeats_corner([a, b, c]: [u32; 3]) -> bool {
    a == b || b == c || c == a
}

/// Whether links that run from their first end to their second follow each other in one ring.
fn is_one_ring(links: &[[u32; 2]]) -> bool {
    let mut at = 0;
    for met in 1..=links.len() {
        let last = links[at][1];
        // All are asked: to leave off at the one that is found would be after another number of them each time, which
        // no processor foresees.
        let (next, found) = (0..).zip(links).fold((0, 0), |(next, found), (i, link)| {
            let follows = usize::from(link[0] == last);
            (next + i * follows, found + follows)
        });
        if found != 1 {
            return false;
        }
        if next == 0 {
            return met == links.len() && met > 2;
        }
        at = next;
    }
    false
}

/// Whether links join end to end, all of them; where no end is shared by more than two, that is
/// one row or one ring.
fn is_one_row(links: &mut [[u32; 2]]) -> bool {
    let mut joined = 1;
    while joined < links.len() {
        let (row, rest) = links.split_at_mut(joined);
        let touches = |link: &[u32; 2]| row.iter().any(|l| l.iter().any(|v| link.contains(v)));
        let Some(next) = rest.iter().position(touches) else {
            return false;
        };
        rest.swap(0, next);
        joined += 1;
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether links can be put in an order in which each begins where the one before ends, the first where the last
    /// does, and none where another does.
    fn is_ring_in_some_order(links: &mut [[u32; 2]], fixed: usize) -> bool {
        if fixed == links.len() {
            let ends = links.iter().cycle().skip(1);
            let follow = links.iter().zip(ends).all(|(one, next)| one[1] == next[0]);
            let mut firsts: Vec<u32> = links.iter().map(|link| link[0]).collect();
            firsts.sort_unstable();
            firsts.dedup();
            return follow && firsts.len() == links.len();
        }
        (fixed..links.len()).any(|i| {
            links.swap(fixed, i);
            let is_ring = is_ring_in_some_order(links, fixed + 1);
            links.swap(fixed, i);
            is_ring
        })
    }

    #[test]
    fn rings_are_told_whatever_the_order_of_their_links() {
        let ends = (0..4).flat_map(|a| (0..4).map(move |b| [a, b]));
        let all: Vec<[u32; 2]> = ends.filter(|[a, b]| a != b).collect();
        for count in 0..5 {
            let mut rings = 0;
            for number in 0..all.len().pow(count) {
                let digit = |k: u32| number / all.len().pow(k) % all.len();
                let mut links: Vec<[u32; 2]> = (0..count).map(|k| all[digit(k)]).collect();
                let expected = count > 2 && is_ring_in_some_order(&mut links, 0);
                assert_eq!(is_one_ring(&links), expected, "{links:?}");
                rings += usize::from(expected);
            }
            // Of three of four corners 4 · 2, of all four 6, and each in any order.
            assert_eq!(rings, [0, 0, 0, 8 * 6, 6 * 24][count as usize]);
        }
    }
}
