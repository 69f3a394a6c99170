//! Places inside another piece of a mesh, as where rocks are put together that go through each other.

use glam::DVec3;

use crate::substrate::{Component, Substrate, SurfacePoint};

/// The pieces of a mesh, as solids that places may be inside of.
#[derive(Clone, Copy, Debug)]
pub struct Solids<'a> {
    substrate: &'a Substrate,
}

impl<'a> Solids<'a> {
    /// The pieces of a substrate.
    pub fn of(substrate: &'a Substrate) -> Self {
        substrate.piece_tree();
        Self { substrate }
    }

    /// Whether a place is inside a solid that another piece of the mesh is: of six ways away from it four at least come
    /// out of that once more often than they go in. So the solid may have holes; one with its faces to the inside is a
    /// room.
    ///
    /// # Panics
    /// When the substrate does not have the place's triangle.
    pub fn hide(&self, at: &SurfacePoint) -> bool {
        let place = self.substrate.position(at);
        self.substrate.is_inside_another(at.triangle, place)
    }

    /// Whether what is so high above a place, a length in file units, is inside such a solid: an element of that radius
    /// has no room there.
    ///
    /// # Panics
    /// When the substrate does not have the place's triangle.
    pub fn bury(&self, at: &SurfacePoint, height: f64) -> bool {
        let height = self.substrate.units().length_to_local(height);
        self.substrate.is_buried(at, height)
    }

    /// Whether nobody sees a place: it is [inside](Self::hide) another piece, or close [under](Self::cover) one.
    ///
    /// # Panics
    /// When the substrate does not have the place's triangle.
    pub fn conceal(&self, at: &SurfacePoint) -> bool {
        self.hide(at) || self.is_under(at)
    }

    /// Whether other pieces that are nearer than a twentieth of the mesh's diagonal are more than nine tenths of what a
    /// place looks at.
    ///
    /// # Panics
    /// When the substrate does not have the place's triangle.
    pub fn is_under(&self, at: &SurfacePoint) -> bool {
        let rays = f64::from(RAYS);
        let free = ((1.0 - COVERED) * rays).ceil() as usize;
        let within = NEAR * self.substrate.units().diagonal();
        // As soon as so many are free it is not.
        self.free_rays(at, within).take(free).count() < free
    }

    /// How much of what a place looks at is another piece of the mesh, no farther away than `within`, a length in file
    /// units: from 0 to 1, by 24 directions.
    ///
    /// # Panics
    /// When the substrate does not have the place's triangle.
    pub fn cover(&self, at: &SurfacePoint, within: f64) -> f64 {
        1.0 - self.free_rays(at, within).count() as f64 / f64::from(RAYS)
    }

    /// The directions in which no other piece is in the way of a place.
    fn free_rays(&self, at: &SurfacePoint, within: f64) -> impl Iterator<Item = DVec3> {
        let substrate = self.substrate;
        let within = substrate.units().length_to_local(within);
        let place = substrate.position(at);
        let own = substrate.component_of(at.triangle);
        let is_near = |piece: &&Component| distance_to_box(piece.bounds, place) <= within;
        let mut near = substrate.components().iter().filter(is_near);
        let is_alone = near.all(|piece| piece == own);
        let rays = rays_about(substrate.normal(at.triangle));
        rays.filter(move |ray| is_alone || !meets_another(substrate, own, place, *ray, within))
    }
}

/// Other pieces that are nearer than this share of the mesh's diagonal cover what they are above.
const NEAR: f64 = 0.05;

/// Of all that a place looks at, more than it may be another piece.
const COVERED: f64 = 0.9;

/// Directions in which it is looked what covers a place.
const RAYS: u32 = 24;

/// As many per area of the disc below them as light comes from them: along a spiral whose turns are golden sections.
fn rays_about(normal: DVec3) -> impl Iterator<Item = DVec3> {
    let (x, y) = normal.any_orthonormal_pair();
    (0..RAYS).map(move |i| {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * 0.618_034 * f64::from(i));
        let aside_sq = (f64::from(i) + 0.5) / f64::from(RAYS);
        let aside = aside_sq.sqrt() * (cos * x + sin * y);
        (aside + (1.0 - aside_sq).sqrt() * normal).normalize()
    })
}

fn distance_to_box([low, high]: [DVec3; 2], place: DVec3) -> f64 {
    place.distance(place.clamp(low, high))
}

/// Whether a ray meets another piece; where that lies on the place itself, whether it looks at it.
fn meets_another(
    substrate: &Substrate,
    own: &Component,
    from: DVec3,
    ray: DVec3,
    within: f64,
) -> bool {
    /// Of what is as near, in local units, nobody can say which is above.
    const TOUCHING: f64 = 1e-9;
    let all = 0..substrate.triangles().len() as u32;
    let near = substrate.triangles_near_line(from, ray, &all);
    let mut others = near.into_iter().filter(|t| !own.triangles.contains(t));
    others.any(|t| {
        let height = substrate
            .plumb(t, from, ray)
            .map(|(height, _)| height - from.dot(ray));
        let looks_back = substrate.normal(t).dot(ray) < 0.0;
        let nearest = if looks_back { -TOUCHING } else { TOUCHING };
        height.is_some_and(|height| height > nearest && height <= within)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::growth::launch::AreaSampler;
    use crate::rng::{Purpose, Stream};
    use crate::substrate::Soup;

    /// Cubes about these places of these sides, with faces to the outside or to the inside, and the last face left out
    /// where it is open.
    fn cubes(all: &[(DVec3, f64, bool)], is_open: bool) -> Substrate {
        let mut soup = Soup::default();
        for &(middle, side, is_outside) in all {
            for face in 0..if is_open { 5 } else { 6 } {
                let first = soup.positions.len() as u32;
                let height = if face < 3 { 0.5 } else { -0.5 };
                for (i, j) in [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)] {
                    let mut p = [i, j, height];
                    p.rotate_left(face % 3);
                    soup.positions
                        .push((middle + side * DVec3::from(p)).to_array());
                }
                let ways = [[0, 1, 2], [0, 2, 3]];
                let turn = (face < 3) == is_outside;
                let triangle = |[a, b, c]: [u32; 3]| if turn { [a, b, c] } else { [a, c, b] };
                soup.triangles
                    .extend(ways.map(|t| triangle(t).map(|k| first + k)));
            }
        }
        Substrate::from_soup(soup).expect("a mesh")
    }

    /// For random places, whether they are hidden, and whether they are inside the other of two cubes.
    fn compared(substrate: &Substrate, inside: impl Fn(DVec3) -> bool) -> [usize; 4] {
        let area = AreaSampler::of_all(substrate);
        let solids = Solids::of(substrate);
        let mut stream = Stream::new(1, Purpose::Walker, 0);
        let mut counts = [0; 4];
        for _ in 0..4000 {
            let at = area.sample(&mut stream);
            let place = substrate.units().to_file(substrate.position(&at));
            counts[usize::from(solids.hide(&at)) + 2 * usize::from(inside(place))] += 1;
        }
        counts
    }

    #[test]
    fn what_is_in_another_solid_is_hidden() {
        let aside = DVec3::new(0.7, 0.6, 0.55);
        let is_in = |p: DVec3, middle: DVec3, side: f64| {
            (p - middle).abs().max_element() < 0.5 * side - 1e-6
        };
        let crossing = [(DVec3::ZERO, 1.0, true), (aside, 1.1, true)];
        let is_inside = |p| is_in(p, DVec3::ZERO, 1.0) || is_in(p, aside, 1.1);
        let [seen, wrong, missed, hidden] = compared(&cubes(&crossing, false), is_inside);
        assert!(
            wrong == 0 && missed == 0 && seen > 3000 && hidden > 100,
            "{seen} {hidden}"
        );
        // With a face missing most are.
        let [_, wrong, missed, hidden] = compared(&cubes(&crossing, true), is_inside);
        assert!(wrong == 0 && missed < hidden, "{wrong} {missed} {hidden}");
        let room = [(DVec3::ZERO, 4.0, false), (aside, 1.1, true)];
        let [_, wrong, _, hidden] = compared(&cubes(&room, false), |p| is_in(p, DVec3::ZERO, 4.0));
        assert_eq!([wrong, hidden], [0, 0], "a room hides nothing");
    }
}
