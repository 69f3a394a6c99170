//! Where seed elements go on one mesh.

use std::cell::RefCell;
use std::collections::HashMap;

use super::Recipe;
use crate::growth::{PlaceError, SeedPlace};
use crate::substrate::{Component, Substrate, SurfacePoint};

/// Finds places of seed elements, each of them once: to find one may take a look at every triangle, and most
/// grids of many runs have one for all of them.
pub(crate) struct Places<'a> {
    pub(super) substrate: &'a Substrate,
    found: RefCell<HashMap<String, Found>>,
}

type Found = Result<SurfacePoint, PlaceError>;

impl<'a> Places<'a> {
    pub(crate) fn on(substrate: &'a Substrate) -> Self {
        Self {
            substrate,
            found: RefCell::default(),
        }
    }

    /// The place for a run with this seed.
    pub(super) fn of(&self, at: &SeedPlace, seed: u64) -> Found {
        self.of_by(at, seed, || at.locate(self.substrate, seed, 0))
    }

    /// The piece of the mesh that a run grows on; the largest where its seed has no place.
    pub(crate) fn piece(&self, recipe: &Recipe) -> &'a Component {
        match self.of(&recipe.at, recipe.seed) {
            Ok(at) => self.substrate.component_of(at.triangle),
            Err(_) => &self.substrate.components()[0],
        }
    }

    fn of_by(&self, at: &SeedPlace, seed: u64, locate: impl FnOnce() -> Found) -> Found {
        // Only chance asks for the seed.
        let key = match at {
            SeedPlace::Random => format!("{at:?} {seed}"),
            _ => format!("{at:?}"),
        };
        let mut found = self.found.borrow_mut();
        found.entry(key).or_insert_with(locate).clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::substrate::Soup;

    #[test]
    fn a_place_is_looked_for_once_and_one_of_chance_once_a_seed() {
        let soup = Soup {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            notes: Vec::new(),
        };
        let substrate = Substrate::from_soup(soup).unwrap();
        let places = Places::on(&substrate);
        let looks = |at: &SeedPlace| {
            let mut looks = 0;
            for seed in [1, 2, 1] {
                let locate = || {
                    looks += 1;
                    at.locate(&substrate, seed, 0)
                };
                let found = places.of_by(at, seed, locate);
                assert_eq!(found, at.locate(&substrate, seed, 0), "{at:?}");
            }
            looks
        };
        let there = |x| SeedPlace::Point([x, 0.0, 0.0]);
        assert_eq!(looks(&SeedPlace::Top), 1);
        assert_eq!([there(0.1), there(0.2)].map(|at| looks(&at)), [1, 1]);
        assert_eq!(looks(&there(1e9)), 1, "one that is none");
        assert_eq!(looks(&SeedPlace::Random), 2);
    }
}
