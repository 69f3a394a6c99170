//! Places spread over a lichen about which something is built: areoles, apothecia.
//!
//! Elements are gone through by birth, and one becomes a site where no site is nearer than the spacing:
//! random sequential adsorption on the elements. So a site stays one as the lichen grows, as in nature,
//! where areoles are founded on the prothallus as it advances; and sites lie on the surface.

use std::hash::Hasher;

use glam::{DVec3, Vec3};

use super::grid::{Grid, WordHasher};
use super::lichen::Granule;

/// An element that something is built about.
#[derive(Clone, Copy, Debug)]
pub(super) struct Site {
    pub(super) position: DVec3,
    /// The surface's.
    pub(super) normal: Vec3,
    pub(super) birth: u32,
    /// The element's distance from the rim, in element radii.
    pub(super) rim: f32,
}

/// Sites, to be asked for by place.
pub(super) struct Sites {
    sites: Vec<Site>,
    grid: Grid,
    /// How far questions reach, local units.
    reach: f64,
}

impl Sites {
    /// Of elements in birth order, by these lengths in local units.
    pub(super) fn new(granules: &[Granule], spacing: f64, reach: f64) -> Self {
        let founders = founders(granules, spacing);
        let places: Vec<DVec3> = founders.iter().map(|site| site.position).collect();
        let (grid, order) = Grid::new(&places, reach);
        Self {
            sites: order.iter().map(|&i| founders[i as usize]).collect(),
            grid,
            reach,
        }
    }

    /// The sites within reach of a place where the surface has this normal, on this side of it.
    pub(super) fn near(&self, p: DVec3, normal: Vec3) -> impl Iterator<Item = &Site> {
        let reach_sq = self.reach * self.reach;
        let runs = self.grid.around(p);
        let near = runs.flat_map(|run| &self.sites[run]);
        near.filter(move |site| {
            let within = (site.position - p).length_squared() < reach_sq;
            within && site.normal.dot(normal) > 0.0
        })
    }

    /// Tells each site how far it is from the rim, by its birth.
    pub(super) fn set_rims(&mut self, rim: impl Fn(u32) -> f32) {
        self.sites.iter_mut().for_each(|s| s.rim = rim(s.birth));
    }
}

impl Site {
    /// A number of its own, 0 to 1, for a purpose.
    pub(super) fn chance(&self, purpose: u32) -> f32 {
        let mut hasher = WordHasher::default();
        hasher.write_u64(u64::from(self.birth) << 8 | u64::from(purpose));
        hasher.write_u64(1);
        (hasher.finish() >> 40) as f32 / (1 << 24) as f32
    }
}

fn founders(granules: &[Granule], spacing: f64) -> Vec<Site> {
    let places: Vec<DVec3> = granules.iter().map(|g| g.position).collect();
    let (grid, order) = Grid::new(&places, spacing);
    let mut taken = vec![false; granules.len()];
    let mut sites = Vec::new();
    for (i, granule) in granules.iter().enumerate() {
        if taken[i] {
            continue;
        }
        let Granule {
            position,
            normal,
            birth,
            rim,
            ..
        } = *granule;
        sites.push(Site {
            position,
            normal,
            birth,
            rim,
        });
        for &j in grid.around(position).flat_map(|run| &order[run]) {
            let other = &granules[j as usize];
            let near = (other.position - position).length_squared() < spacing * spacing;
            taken[j as usize] |= near && other.normal.dot(normal) > 0.0;
        }
    }
    sites
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    /// Elements of radius 1 on a disc of this radius in the plane z = 0, a jittered lattice, as if
    /// they had grown from the middle. There are 0.22 to a square radius.
    pub(in crate::skin) fn disc(radius: f64) -> Vec<Granule> {
        const APART: f64 = 2.3;
        let mut stream = Stream::new(5, Purpose::Walker, 1 << 40);
        let rows = (radius / APART) as i32 * 2;
        let mut places = Vec::new();
        for (i, j) in (-rows..=rows).flat_map(|j| (-rows..=rows).map(move |i| (i, j))) {
            let mut jitter = || 0.6 * stream.uniform() - 0.3;
            let x = APART * (f64::from(i) + 0.5 * f64::from(j & 1)) + jitter();
            let y = APART * f64::from(j) * 0.75f64.sqrt() + jitter();
            places.push(DVec3::new(x, y, 0.0));
        }
        places.retain(|p| p.length() < radius);
        places.sort_by(|a, b| a.length().total_cmp(&b.length()));
        let granule = |(position, birth): (DVec3, u32)| Granule {
            position,
            normal: Vec3::Z,
            home: 0,
            birth,
            colony: 0,
            density: 0.7,
            rim: (radius - position.length()) as f32,
            outline: 0.0,
            influence: 1.0,
        };
        places.into_iter().zip(0..).map(granule).collect()
    }

    #[test]
    fn sites_are_apart_and_no_element_is_far_from_one() {
        for spacing in [3.0, 7.0, 20.0] {
            let granules = disc(80.0);
            let sites = founders(&granules, spacing);
            let far = |a: &Site| {
                let others = sites.iter().filter(|b| b.birth != a.birth);
                others.fold(f64::INFINITY, |d, b| {
                    d.min((a.position - b.position).length())
                })
            };
            assert!(sites.iter().all(|a| far(a) >= spacing), "{spacing}");
            for g in &granules {
                let near = |s: &Site| (s.position - g.position).length() < spacing;
                assert!(sites.iter().any(near), "{spacing}: {}", g.position);
            }
        }
    }

    #[test]
    fn sites_stay_as_a_lichen_grows() {
        let granules = disc(60.0);
        let all = founders(&granules, 9.0);
        let some = founders(&granules[..granules.len() / 3], 9.0);
        assert!(some.len() > 10 && some.len() < all.len());
        assert!(some.iter().zip(&all).all(|(a, b)| a.birth == b.birth));
    }

    #[test]
    fn those_within_reach_on_this_side_are_near() {
        let mut granules = disc(40.0);
        for (i, granule) in granules.iter_mut().enumerate() {
            granule.normal = if i % 3 == 0 { Vec3::NEG_Z } else { Vec3::Z };
        }
        let (spacing, reach) = (6.0, 11.0);
        let sites = Sites::new(&granules, spacing, reach);
        let founders = founders(&granules, spacing);
        for p in granules.iter().map(|g| g.position).step_by(7) {
            let mut found: Vec<u32> = sites.near(p, Vec3::Z).map(|s| s.birth).collect();
            found.sort_unstable();
            let near = |s: &&Site| s.normal.z > 0.0 && (s.position - p).length() < reach;
            let expected: Vec<u32> = founders.iter().filter(near).map(|s| s.birth).collect();
            assert!(found == expected && found.len() > 2, "{p}");
        }
    }
}
