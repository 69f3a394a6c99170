//! Which triangle each texel of an image shows.
//!
//! Places of the image are counted in texels: the middle of texel (i, j), column and row, is at
//! (i, j). The image repeats, as textures do: coordinates beyond it come in again at the other side.

use glam::DVec2;

use super::BakeError;
use super::shown::Shown;
use crate::substrate::Substrate;

/// No triangle.
pub(super) const NONE: u32 = u32::MAX;

/// A triangle's corners in texels.
pub(super) type Corners = [DVec2; 3];

/// The substrate's triangles in an image.
pub(super) struct Layout {
    /// Texels in a row, and rows.
    pub(super) size: usize,
    /// For each triangle; none where it has no area in the image.
    pub(super) corners: Vec<Option<Corners>>,
    /// For each texel, row by row, the triangle under its middle, or in the gutter the nearest one;
    /// [`NONE`] beyond.
    pub(super) owners: Vec<u32>,
    /// Texels that a triangle covers with their middles.
    pub(super) covered: usize,
    pub(super) overlaps: Overlaps,
}

/// Parts of the surface that share texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Overlaps {
    /// Texels under more than one triangle.
    pub texels: usize,
    /// Triangles that share a texel with another.
    pub triangles: usize,
}

/// Twice the area in texels below which a triangle shows nothing.
const FLAT: f64 = 1e-9;

/// How far inside two triangles a texel's middle must be to count as shared, in texels: neighbours
/// share their edge.
pub(super) const SHARED: f64 = 0.01;

/// How far beyond its edge a triangle that has no texel's middle can still be the nearest one that
/// bilinear sampling comes to.
pub(super) const FOOTPRINT: f64 = 1.5;

impl Layout {
    /// With a gutter so many texels wide around what is covered.
    pub(super) fn new(shown: &Shown, size: usize, gutter: usize) -> Result<Self, BakeError> {
        let mut layout = Self {
            size,
            corners: corners(shown, size)?,
            owners: vec![NONE; size * size],
            covered: 0,
            overlaps: Overlaps::default(),
        };
        layout.cover();
        layout.reach_out(shown.substrate);
        layout.dilate(gutter);
        Ok(layout)
    }

    /// The number of the texel at a column and a row, which may lie beyond the image.
    pub(super) fn texel(&self, x: i64, y: i64) -> usize {
        let size = self.size as i64;
        (y.rem_euclid(size) * size + x.rem_euclid(size)) as usize
    }

    /// The middle of the texel of this number.
    pub(super) fn middle(&self, texel: usize) -> DVec2 {
        DVec2::new((texel % self.size) as f64, (texel / self.size) as f64)
    }

    /// A place, moved by whole images to where its owner is.
    pub(super) fn near(&self, corners: &Corners, p: DVec2) -> DVec2 {
        let [low, high] = bounds(corners);
        let size = self.size as f64;
        let nearest = p + ((0.5 * (low + high) - p) / size).round() * size;
        match (high - low).max_element() > size {
            true => nearest_copy(corners, nearest, size),
            false => nearest,
        }
    }

    /// Gives each triangle the texels whose middles it covers, the first one where two do.
    fn cover(&mut self) {
        let mut shares = vec![false; self.corners.len()];
        let mut shared = vec![false; self.owners.len()];
        for t in 0..self.corners.len() {
            let Some(corners) = self.corners[t] else {
                continue;
            };
            for (x, y) in under(corners) {
                let p = DVec2::new(x as f64, y as f64);
                let inside = inside(&corners, p);
                if inside < -1e-9 {
                    continue;
                }
                let texel = self.texel(x, y);
                let owner = self.owners[texel];
                if owner == NONE {
                    self.owners[texel] = t as u32;
                    self.covered += 1;
                } else if inside > SHARED && self.is_well_inside(owner, p) {
                    shared[texel] = true;
                    shares[t] = true;
                    shares[owner as usize] = true;
                }
            }
        }
        let count = |marks: &[bool]| marks.iter().filter(|&&m| m).count();
        self.overlaps = Overlaps {
            texels: count(&shared),
            triangles: count(&shares),
        };
    }

    fn is_well_inside(&self, triangle: u32, p: DVec2) -> bool {
        let corners = self.corners[triangle as usize];
        corners.is_some_and(|c| inside(&c, self.near(&c, p)) > SHARED)
    }

    /// Gives the texels along the borders of charts, as far as bilinear sampling reads them, to the
    /// nearest triangle: a chart may be narrower than a texel.
    fn reach_out(&mut self, substrate: &Substrate) {
        let mut nearest = vec![f32::INFINITY; self.owners.len()];
        let covered: Vec<bool> = self.owners.iter().map(|&o| o != NONE).collect();
        for half_edge in self.seams(substrate) {
            let triangle = half_edge / 3;
            let Some(corners) = self.corners[triangle as usize] else {
                continue;
            };
            for (x, y) in about(&corners, half_edge as usize % 3, FOOTPRINT) {
                let p = DVec2::new(x as f64, y as f64);
                let distance = distance_to(&corners, p) as f32;
                let texel = self.texel(x, y);
                let near = f64::from(distance) <= FOOTPRINT && distance < nearest[texel];
                if near && !covered[texel] {
                    nearest[texel] = distance;
                    self.owners[texel] = triangle;
                }
            }
        }
    }

    /// Half-edges where the image is cut: open edges of the surface, and those whose two triangles
    /// lie apart in the image.
    pub(super) fn seams(&self, substrate: &Substrate) -> Vec<u32> {
        let half_edges = 0..3 * self.corners.len() as u32;
        let seam = |&h: &u32| {
            let twin = substrate.twin(h);
            let other = twin.half_edge();
            let [a, b] = match (self.edge(h), self.edge(other)) {
                (Some(here), Some([c, d])) if twin.is_flipped() => [here, [c, d]],
                (Some(here), Some([c, d])) => [here, [d, c]],
                (here, _) => return here.is_some(),
            };
            other == h || a.iter().zip(b).any(|(p, q)| (*p - q).length() > 1e-6)
        };
        half_edges.filter(seam).collect()
    }

    /// The ends of a half-edge in the image.
    pub(super) fn edge(&self, half_edge: u32) -> Option<[DVec2; 2]> {
        let corners = self.corners[half_edge as usize / 3]?;
        let k = half_edge as usize % 3;
        Some([corners[k], corners[(k + 1) % 3]])
    }

    /// Gives so many rings of texels around what has an owner to the nearest of their neighbours'.
    fn dilate(&mut self, rings: usize) {
        let mut ring: Vec<usize> = (0..self.owners.len())
            .filter(|&i| self.owners[i] != NONE)
            .collect();
        for _ in 0..rings {
            let free = |i: &usize| self.owners[*i] == NONE;
            let mut next: Vec<usize> = ring
                .iter()
                .flat_map(|&i| self.neighbours(i))
                .filter(free)
                .collect();
            next.sort_unstable();
            next.dedup();
            let owners: Vec<u32> = next.iter().map(|&i| self.nearest_owner(i)).collect();
            for (&i, owner) in next.iter().zip(owners) {
                self.owners[i] = owner;
            }
            ring = next;
        }
    }

    fn neighbours(&self, texel: usize) -> [usize; 8] {
        const AROUND: [(i64, i64); 8] = [
            (-1, -1),
            (0, -1),
            (1, -1),
            (-1, 0),
            (1, 0),
            (-1, 1),
            (0, 1),
            (1, 1),
        ];
        let (x, y) = ((texel % self.size) as i64, (texel / self.size) as i64);
        AROUND.map(|(dx, dy)| self.texel(x + dx, y + dy))
    }

    fn nearest_owner(&self, texel: usize) -> u32 {
        let p = self.middle(texel);
        let mut best = (f64::INFINITY, NONE);
        for neighbour in self.neighbours(texel) {
            let owner = self.owners[neighbour];
            let corners = self.corners.get(owner as usize).copied().flatten();
            if let Some(corners) = corners.filter(|_| owner != best.1) {
                let distance = distance_to(&corners, self.near(&corners, p));
                if distance < best.0 || (distance == best.0 && owner < best.1) {
                    best = (distance, owner);
                }
            }
        }
        best.1
    }
}

/// How many times over triangles may cover the image: more are a texture that many parts share.
pub(super) const MOST_IMAGES: f64 = 32.0;

/// How many images wide a triangle may be. Layouts exceed the image by rounding and by careless
/// scaling, one from the wild by 1.8 %: the strip that comes in again is then under the triangle twice,
/// which is told as any overlap. What is wider repeats its texture on purpose.
pub(super) const WIDEST: f64 = 1.05;

/// Whether there is a layout of an image of this size.
pub(super) fn check(shown: &Shown, size: usize) -> Result<(), BakeError> {
    corners(shown, size).map(drop)
}

/// The corners of a triangle in texels, if it has an area there, of an image with so many in a row.
pub(super) fn corners_of(
    shown: &Shown,
    triangle: u32,
    size: f64,
) -> Result<Option<Corners>, BakeError> {
    let Some(uvs) = shown.uvs_of(triangle) else {
        return Ok(None);
    };
    let corners = uvs.map(|uv| DVec2::from(uv) * size - 0.5);
    let [low, high] = bounds(&corners);
    let tiles = (high - low).max_element() / size;
    match tiles > WIDEST {
        true => Err(BakeError::Repeats {
            triangle: shown.substrate.source_triangle(triangle),
            tiles,
        }),
        false => Ok(Some(corners).filter(|c| doubled_area(c).abs() > FLAT)),
    }
}

/// The triangles' corners in texels, and that none is much larger than the image.
fn corners(shown: &Shown, size: usize) -> Result<Vec<Option<Corners>>, BakeError> {
    let scale = size as f64;
    let all = shown.substrate.triangles().len() as u32;
    let mut found = Vec::with_capacity(all as usize);
    let (mut missing, mut images) = (0, 0.0);
    for t in 0..all {
        missing += usize::from(shown.uvs_of(t).is_none());
        let corners = corners_of(shown, t, scale)?;
        let area = corners.map_or(0.0, |corners| 0.5 * doubled_area(&corners).abs());
        images += area / (scale * scale);
        found.push(corners);
    }
    match found.iter().all(Option::is_none) {
        true if missing < found.len() => Err(BakeError::FlatUvs),
        true => Err(BakeError::NoUvs),
        false if images > MOST_IMAGES => Err(BakeError::Stacked { images }),
        false => Ok(found),
    }
}

pub(super) fn bounds(corners: &Corners) -> [DVec2; 2] {
    let [a, b, c] = *corners;
    [a.min(b).min(c), a.max(b).max(c)]
}

pub(super) fn doubled_area([a, b, c]: &Corners) -> f64 {
    (*b - *a).perp_dot(*c - *a)
}

/// Columns and rows of the texels in the box of a triangle's side, grown by a distance, that are at
/// most as far outside the triangle, and few others: as many as its sides are long, whatever the box.
/// All three sides count, as another one's surroundings may lie in the box.
fn about(
    corners: &Corners,
    side: usize,
    distance: f64,
) -> impl Iterator<Item = (i64, i64)> + use<> {
    let corners = *corners;
    let [a, b] = [corners[side], corners[(side + 1) % 3]];
    let from = (a.min(b) - distance).ceil();
    let to = (a.max(b) + distance).floor();
    (from.y as i64..=to.y as i64).flat_map(move |y| {
        let mut spans = [0, 1, 2].map(|k| {
            let ends = [corners[k], corners[(k + 1) % 3]];
            let [first, last] = near_in_row(ends, y as f64, distance);
            [first.max(from.x) as i64, last.min(to.x) as i64]
        });
        spans.sort_unstable();
        // Where spans share texels, each comes once.
        let mut free = i64::MIN;
        let columns = spans.map(|[first, last]| {
            let first = first.max(free);
            free = free.max(last.saturating_add(1));
            first..=last
        });
        columns.into_iter().flatten().map(move |x| (x, y))
    })
}

/// The first and the last column of a row that may be as near to a line between two ends; the last is
/// before the first where none is.
fn near_in_row([a, b]: [DVec2; 2], row: f64, distance: f64) -> [f64; 2] {
    const ROUND_OFF: f64 = 1e-6;
    let reach = distance + ROUND_OFF;
    let [low, high] = if a.y < b.y { [a, b] } else { [b, a] };
    let (from, to) = (low.y.max(row - reach), high.y.min(row + reach));
    if from > to {
        return [0.0, -1.0];
    }
    let slope = (high.x - low.x) / (high.y - low.y);
    let ends = match high.y - low.y > ROUND_OFF {
        true => [from, to].map(|y| low.x + (y - low.y) * slope),
        false => [low.x, high.x],
    };
    [
        (ends[0].min(ends[1]) - reach).ceil(),
        (ends[0].max(ends[1]) + reach).floor(),
    ]
}

/// Columns and rows of the texels whose middles are under a triangle, and a few beside them: as many
/// as its area and its height say, whatever its box.
pub(super) fn under(corners: Corners) -> impl Iterator<Item = (i64, i64)> {
    const ROUND_OFF: f64 = 1e-6;
    let [low, high] = bounds(&corners);
    let rows = low.y.ceil() as i64..=high.y.floor() as i64;
    rows.flat_map(move |y| {
        let at = y as f64;
        let mut span = [f64::INFINITY, f64::NEG_INFINITY];
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            if (a.y - at) * (b.y - at) > 0.0 {
                continue;
            }
            let crossing = a.x + (at - a.y) / (b.y - a.y) * (b.x - a.x);
            let ends = match a.y == b.y {
                true => [a.x, b.x],
                false => [crossing; 2],
            };
            span[0] = span[0].min(ends[0]).min(ends[1]);
            span[1] = span[1].max(ends[0]).max(ends[1]);
        }
        let columns = (span[0] - ROUND_OFF).ceil() as i64..=(span[1] + ROUND_OFF).floor() as i64;
        columns.map(move |x| (x, y))
    })
}

/// Distance from the nearest side's line, positive inside.
pub(super) fn inside(corners: &Corners, p: DVec2) -> f64 {
    let turn = doubled_area(corners).signum();
    let side = |k: usize| {
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        turn * (b - a).perp_dot(p - a) / (b - a).length()
    };
    side(0).min(side(1)).min(side(2))
}

/// Distance to the triangle, 0 inside.
pub(super) fn distance_to(corners: &Corners, p: DVec2) -> f64 {
    (p - nearest_in(corners, p)).length()
}

/// The triangle's point that is nearest to a place.
pub(super) fn nearest_in(corners: &Corners, p: DVec2) -> DVec2 {
    if inside(corners, p) >= 0.0 {
        return p;
    }
    let on_side = |k: usize| {
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        let along = (p - a).dot(b - a) / (b - a).length_squared();
        a + (b - a) * along.clamp(0.0, 1.0)
    };
    let nearer = |a: DVec2, b: DVec2| match (b - p).length_squared() < (a - p).length_squared() {
        true => b,
        false => a,
    };
    nearer(nearer(on_side(0), on_side(1)), on_side(2))
}

/// The copy of a place, whole images away, that is nearest to a triangle which is wider than the image:
/// the one nearest to its middle may lie beside it.
fn nearest_copy(corners: &Corners, p: DVec2, size: f64) -> DVec2 {
    const STEPS: [f64; 3] = [0.0, -1.0, 1.0];
    let copies = STEPS.iter().flat_map(|y| STEPS.map(|x| DVec2::new(x, *y)));
    let mut best = (f64::INFINITY, p);
    for copy in copies.map(|step| p + step * size) {
        let distance = distance_to(corners, copy);
        if distance < best.0 {
            best = (distance, copy);
        }
    }
    best.1
}

/// Barycentric weights of a place, negative beyond the sides.
pub(super) fn weights(corners: &Corners, p: DVec2) -> [f64; 3] {
    let [a, b, c] = corners.map(|corner| corner - p);
    let doubled = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
    doubled.map(|w| w / (doubled[0] + doubled[1] + doubled[2]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    type Texels = Vec<(i64, i64)>;

    /// Texels in the box of a triangle's side, grown by the footprint.
    fn boxed(corners: &Corners, side: usize) -> Texels {
        let [a, b] = [corners[side], corners[(side + 1) % 3]];
        let from = (a.min(b) - FOOTPRINT).ceil().as_i64vec2();
        let to = (a.max(b) + FOOTPRINT).floor().as_i64vec2();
        let rows = from.y..=to.y;
        rows.flat_map(|y| (from.x..=to.x).map(move |x| (x, y)))
            .collect()
    }

    /// Those outside the triangle that are as near as the footprint.
    fn near(corners: &Corners, texels: &[(i64, i64)]) -> Texels {
        let distance = |&(x, y): &(i64, i64)| {
            f64::from(distance_to(corners, DVec2::new(x as f64, y as f64)) as f32)
        };
        let is_near =
            |texel: &&(i64, i64)| (f64::MIN_POSITIVE..=FOOTPRINT).contains(&distance(texel));
        texels.iter().filter(is_near).copied().collect()
    }

    #[test]
    fn texels_about_a_side_are_those_of_its_box() {
        let mut random = Stream::new(7, Purpose::Walker, 0);
        for round in 0..3000 {
            let size = [0.01, 1.0, 6.0, 60.0][round % 4];
            let mut corners = [(); 3].map(|()| random.in_unit_disc() * size);
            match round % 5 {
                // Whole and half texels, level and upright sides, distances that are just the footprint.
                0 => corners = corners.map(|c| (2.0 * c).round() / 2.0),
                // A sliver.
                1 => corners[2] = corners[0] + 0.3 * (corners[1] - corners[0]) + 1e-4,
                2 => corners[1].y = corners[0].y + 1e-7,
                _ => (),
            }
            for side in 0..3 {
                let visited: Texels = about(&corners, side, FOOTPRINT).collect();
                let all = boxed(&corners, side);
                assert_eq!(
                    near(&corners, &visited),
                    near(&corners, &all),
                    "{corners:?}"
                );
                assert!(
                    visited.is_sorted_by(|a, b| (a.1, a.0) < (b.1, b.0)),
                    "each once"
                );
                assert!(visited.iter().all(|texel| all.contains(texel)));
            }
        }
    }

    /// As many texels as sides are long, not as their boxes are large.
    #[test]
    fn long_sides_cost_their_length() {
        let corner = |x: f64, y: f64| DVec2::new(x, y);
        for third in [corner(0.0, 1.0), corner(0.0, 1000.0), corner(501.0, 500.0)] {
            let corners = [corner(0.0, 0.0), corner(1000.0, 1000.0), third];
            let visited = about(&corners, 0, FOOTPRINT).count();
            assert!((5_000..20_000).contains(&visited), "{visited}");
        }
    }
}
