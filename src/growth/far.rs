//! Far jumps on coarser copies of the surface.
//!
//! Most of the edges that a walker crosses lie far from the lichen. There it walks on a copy with
//! fewer triangles, the farther away the fewer, and comes back to the surface before it is near.
//! Contacts, sheets and joining know nothing of it. On a copy bumps are flatter, so far jumps go over
//! them straighter; what that changes in where walkers come to the lichen is measured in
//! `tests/far.rs`.

use std::sync::Arc;

use crate::substrate::{Coarse, Substrate, SurfacePoint};
use crate::walk::Stand;

/// How far the finest copy's vertices may stray from the surface, in element radii. Coarser copies
/// may as many times more as their bounds are larger.
const ERROR: f64 = 8.0;

/// A walker on a copy lands when its bound is less than this many times what the copy may stray.
const LAND: f64 = 1.5;

/// Bounds this many times as large as those below which a walker leaves a copy are for that copy.
const LIFT: f64 = 2.0;

/// Walks on the surface to a place on the copy, at most.
const MOST_WALKS: usize = 3;

/// Coarser copies, and when to walk on them.
pub(super) struct Far {
    copies: Arc<Vec<Coarse>>,
    reaches: Vec<Reach>,
}

/// Which surface a walker is on: the mesh's own, or the copy with this number from 1, the finest
/// first.
pub(super) type Level = usize;

/// Where a copy serves.
struct Reach {
    /// For each triangle, how far from it the places on the surface are that it stands for, at most.
    deviations: Vec<f64>,
    /// A walker on the copy with a smaller bound lands.
    land: f64,
}

impl Far {
    /// For elements of this radius, local units. None where no copy would be worth having.
    pub(super) fn new(substrate: &Substrate, radius: f64) -> Option<Self> {
        let copies = substrate.coarser(ERROR * radius);
        let mut reaches: Vec<Reach> = Vec::new();
        for copy in copies.iter() {
            let finer = reaches.last().map(|reach| reach.deviations.as_slice());
            reaches.push(Reach {
                deviations: copy.deviations(finer),
                land: LAND * copy.error(),
            });
        }
        (!reaches.is_empty()).then_some(Self { copies, reaches })
    }

    /// The surface to walk on.
    #[inline]
    pub(super) fn surface<'a>(&'a self, level: Level, substrate: &'a Substrate) -> &'a Substrate {
        match level {
            0 => substrate,
            _ => self.copies[level - 1].surface(),
        }
    }

    /// How far from a triangle of this level the places on the surface are that it stands for, at most.
    pub(super) fn deviation(&self, level: Level, triangle: u32) -> f64 {
        match level {
            0 => 0.0,
            _ => self.reaches[level - 1].deviations[triangle as usize],
        }
    }

    /// Bounds below this are for a finer level.
    pub(super) fn least(&self, level: Level) -> f64 {
        match level {
            0 => f64::NEG_INFINITY,
            _ => self.reaches[level - 1].land,
        }
    }

    /// Bounds above this are for the next coarser level.
    pub(super) fn most(&self, level: Level) -> f64 {
        let next = self.reaches.get(level);
        next.map_or(f64::INFINITY, |next| LIFT * next.land)
    }

    /// From a level to the next coarser one.
    pub(super) fn lifted(&self, level: Level, here: &Stand) -> Stand {
        let copy = &self.copies[level];
        Stand::new(copy.surface(), &copy.above(here.triangle, here.position))
    }

    /// From a copy to the next finer level: from a triangle near there by short walks over that
    /// surface, each towards the place on the copy, as long as they lead nearer.
    pub(super) fn landed(
        &self,
        level: Level,
        substrate: &Substrate,
        here: &Stand,
    ) -> Option<Stand> {
        let triangle = self.copies[level - 1].below(here.triangle, here.at);
        if triangle == u32::MAX {
            return None;
        }
        let finer = self.surface(level - 1, substrate);
        let mut there = Stand::new(finer, &SurfacePoint::from_weights(triangle, [1.0; 3]));
        for _ in 0..MOST_WALKS {
            let frame = &finer.frames()[there.triangle as usize];
            let onward = frame.turned(here.position - there.position);
            let next = there.step(finer, onward, false).to;
            let [before, after] = [there, next].map(|s| s.position.distance_squared(here.position));
            if after >= before {
                break;
            }
            there = next;
        }
        Some(there)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::growth::launch::AreaSampler;
    use crate::rng::{Purpose, Stream};

    fn boulder() -> (Substrate, Far) {
        let substrate = Substrate::load(Path::new("meshes/boulder.glb")).expect("a mesh");
        let radius = substrate.units().length_to_local(substrate.auto_radius());
        let far = Far::new(&substrate, radius).expect("worth having");
        (substrate, far)
    }

    #[test]
    fn copies_have_ever_fewer_triangles_and_serve_ever_larger_bounds() {
        let (substrate, far) = boulder();
        assert_eq!(far.copies.len(), 2);
        let mut finer = &substrate;
        for level in 1..=2 {
            let copy = far.surface(level, &substrate);
            assert!(4 * copy.triangles().len() < finer.triangles().len());
            assert!(far.most(level - 1) > far.least(level));
            finer = copy;
        }
        assert_eq!(far.most(2), f64::INFINITY);
    }

    #[test]
    fn places_on_copies_stand_for_places_within_the_deviation() {
        let (substrate, far) = boulder();
        let area = AreaSampler::new(&substrate, 0..substrate.triangles().len() as u32);
        let mut stream = Stream::new(1, Purpose::Walker, 0);
        let (mut adrift, mut beyond) = (0, 0);
        for _ in 0..2000 {
            let mut here = Stand::new(&substrate, &area.sample(&mut stream));
            let there = here.position;
            for level in 1..=2 {
                here = far.lifted(level - 1, &here);
                let most = far.deviation(level, here.triangle);
                assert!(here.position.distance(there) <= most);
            }
            for level in [2, 1] {
                // Some triangles of a copy stand for none: nobody lands from there.
                let Some(landed) = far.landed(level, &substrate, &here) else {
                    adrift += 1;
                    break;
                };
                let aside = landed.position.distance(here.position);
                let most = far.deviation(level, here.triangle);
                assert!(aside <= 2.0 * most, "{aside} aside, level {level}");
                beyond += usize::from(aside > most);
                here = landed;
            }
        }
        assert!(adrift < 40, "{adrift} of 2000");
        // What is nearest to a place may be one that the triangle beside stands for.
        assert!(beyond < 20, "{beyond} of 4000");
    }
}
