//! How much ground the surface has at a distance.
//!
//! Triangles are cut into pieces that are small beside the rings and their distance, the corners of
//! the pieces have exact distances, and within a piece the distance is taken as linear: then the part
//! of it within a distance has a closed form. Tests hold the rings to those of planes, spheres and
//! prisms within a hundredth.

use glam::DVec3;

use super::geodesic::SurfaceMetric;
use super::mass::Metric;
use crate::substrate::{Substrate, SurfacePoint, area};

/// Pieces, beyond those that a mesh has anyway, of which rings are made at most: a gigabyte of them.
const MOST_PIECES: usize = 1 << 24;

/// The narrowest rings, in shares of the diagonal of the mesh: in pieces of less the corners are in one place.
const NARROWEST: f64 = 1e-10;

/// Areas of so many rings of this width about a place, in the units of the file. None where they are too narrow, or so
/// many that it takes too many pieces.
pub(super) fn ring_areas(
    substrate: &Substrate,
    centre: SurfacePoint,
    width: f64,
    rings: usize,
) -> Option<Vec<f64>> {
    assert!(
        width > 0.0 && width.is_finite(),
        "rings of a positive width, not {width}"
    );
    let units = substrate.units();
    if width < NARROWEST * units.diagonal() {
        return None;
    }
    let reach = width * rings as f64;
    let mut pieces = Pieces::new(substrate, centre, units.length_to_local(width), rings);
    (0..substrate.triangles().len() as u32).try_for_each(|t| pieces.cut(t))?;
    let places = &pieces.places;
    let distances = SurfaceMetric::new(substrate, places).distances(0, reach + width);
    let mut areas = vec![0.0; rings];
    for (corners, area) in distances[1..].as_chunks().0.iter().zip(pieces.areas) {
        add(&mut areas, *corners, units.area_to_file(area), width);
    }
    Some(areas)
}

/// Shares the area of a piece out to the rings that it lies in.
fn add(areas: &mut [f64], mut corners: [f64; 3], area: f64, width: f64) {
    corners.sort_by(f64::total_cmp);
    // What no way of the length asked for leads to is beyond all rings.
    if corners[2].is_infinite() {
        return;
    }
    let [first, last] = [corners[0], corners[2]].map(|d| (d / width) as usize);
    let mut before = 0.0;
    for (k, ring) in areas.iter_mut().enumerate().take(last + 1).skip(first) {
        let within = share_within(corners, (k + 1) as f64 * width);
        *ring += area * (within - before);
        before = within;
    }
}

/// The share of a triangle whose distance, linear with these ascending ones at its corners, is no
/// greater than `edge`.
fn share_within([a, b, c]: [f64; 3], edge: f64) -> f64 {
    match edge {
        _ if edge <= a => 0.0,
        _ if edge >= c => 1.0,
        _ if edge < b => (edge - a) * (edge - a) / ((b - a) * (c - a)),
        _ => 1.0 - (c - edge) * (c - edge) / ((c - b) * (c - a)),
    }
}

/// What the surface about a place is cut into.
struct Pieces<'a> {
    substrate: &'a Substrate,
    centre: DVec3,
    /// Width of a ring, and of all; local units.
    width: f64,
    reach: f64,
    /// How many there may be.
    most: usize,
    /// The place, and three corners a piece.
    places: Vec<SurfacePoint>,
    /// Local units.
    areas: Vec<f64>,
}

impl<'a> Pieces<'a> {
    fn new(substrate: &'a Substrate, centre: SurfacePoint, width: f64, rings: usize) -> Self {
        Self {
            substrate,
            centre: substrate.position(&centre),
            width,
            reach: width * rings as f64,
            most: MOST_PIECES + substrate.triangles().len(),
            places: vec![centre],
            areas: Vec::new(),
        }
    }

    /// Halves what is too large, and leaves out what is too far away through space, and so along the
    /// surface too. None where there are too many pieces.
    fn cut(&mut self, triangle: u32) -> Option<()> {
        let corner = |weights| SurfacePoint::from_weights(triangle, weights);
        let whole = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(corner);
        let mut left = vec![whole];
        while let Some(piece) = left.pop() {
            let at = piece.map(|p| self.substrate.position(&p));
            let (longest, size) = longest_edge(at);
            let middle = at.iter().sum::<DVec3>() / 3.0;
            let nearest = middle.distance(self.centre) - size;
            if nearest > self.reach {
                continue;
            }
            if size > self.largest(nearest) {
                left.extend(halves(piece, longest));
                continue;
            }
            if self.areas.len() == self.most {
                return None;
            }
            self.places.extend(piece);
            self.areas.push(area(at));
        }
        Some(())
    }

    /// Near the middle distances are far from linear.
    fn largest(&self, distance: f64) -> f64 {
        (0.25 * distance).clamp(0.125 * self.width, 0.5 * self.width)
    }
}

/// The edge's first corner, and its length.
fn longest_edge(corners: [DVec3; 3]) -> (usize, f64) {
    let length = |k: usize| corners[k].distance(corners[(k + 1) % 3]);
    let longer = |a: usize, b: usize| if length(b) > length(a) { b } else { a };
    let longest = longer(longer(0, 1), 2);
    (longest, length(longest))
}

/// Both sides of a line from the middle of an edge. Slivers halved so become less so.
fn halves(piece: [SurfacePoint; 3], edge: usize) -> [[SurfacePoint; 3]; 2] {
    let [a, b, c] = [0, 1, 2].map(|k| piece[(edge + k) % 3]);
    let middle = SurfacePoint {
        triangle: a.triangle,
        u: 0.5 * (a.u + b.u),
        v: 0.5 * (a.v + b.v),
    };
    [[a, middle, c], [middle, b, c]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::substrate::Soup;

    #[test]
    fn there_are_no_more_pieces_than_there_may_be() {
        let soup = Soup {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            ..Soup::default()
        };
        let substrate = Substrate::from_soup(soup).expect("a mesh");
        let mut pieces = Pieces::new(&substrate, SurfacePoint::centroid(0), 1e-5, 100_000);
        pieces.most = 1000;
        assert_eq!((pieces.cut(0), pieces.areas.len()), (None, 1000));
    }
}
