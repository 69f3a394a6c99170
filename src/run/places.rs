//! Where the seed elements of many runs go on one mesh.

use std::cell::RefCell;
use std::collections::HashMap;

use super::Recipe;
use crate::growth::{PlaceError, SeedPlace};
use crate::substrate::{Substrate, SurfacePoint};

/// Finds places of seed elements, and the area about them, each of them once: to find one may take a look at every
/// triangle, and most grids of many runs have one for all of them.
pub(crate) struct Places<'a> {
    pub(super) substrate: &'a Substrate,
    found: RefCell<HashMap<String, Found>>,
    areas: RefCell<HashMap<String, f64>>,
}

type Found = Result<Vec<SurfacePoint>, PlaceError>;

impl<'a> Places<'a> {
    pub(crate) fn on(substrate: &'a Substrate) -> Self {
        Self {
            substrate,
            found: RefCell::default(),
            areas: RefCell::default(),
        }
    }

    /// The places for a run.
    pub(super) fn of(&self, recipe: &Recipe) -> Found {
        self.of_by(recipe, || recipe.seeds(self.substrate))
    }

    /// The area of the pieces of the mesh that a run grows on, as far as it may, local units; of the largest where its
    /// seeds have no places.
    pub(crate) fn area(&self, recipe: &Recipe) -> f64 {
        let Ok(seeds) = self.of(recipe) else {
            return self.substrate.components()[0].area;
        };
        let seeds = || seeds.iter().map(|at| at.triangle);
        let pieces = self.substrate.pieces_of(seeds());
        let pieces: Vec<u32> = pieces.iter().map(|piece| piece.triangles.start).collect();
        // What is exposed goes by the radius.
        let key = format!("{pieces:?} {} {:?}", recipe.radius, recipe.slope);
        *{ self.areas.borrow_mut() }
            .entry(key)
            .or_insert_with(|| recipe.habitat(self.substrate).area(seeds()))
    }

    fn of_by(&self, recipe: &Recipe, locate: impl FnOnce() -> Found) -> Found {
        // Only chance asks for the seed, and only it, colonies beside others, masks and slopes for the radius.
        let is_anywhere = recipe.mask.is_none() && recipe.slope.is_none();
        let key = match &recipe.at[..] {
            [place] if *place != SeedPlace::Random && is_anywhere => format!("{place:?}"),
            places => format!(
                "{places:?} {} {:?} {:?}",
                recipe.seed, recipe.radius, recipe.slope
            ),
        };
        let mut found = self.found.borrow_mut();
        found.entry(key).or_insert_with(locate).clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::{Length, Settings};
    use crate::substrate::Soup;

    #[test]
    fn places_are_looked_for_once_and_those_of_chance_once_a_seed_and_radius() {
        let soup = Soup {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            notes: Vec::new(),
        };
        let substrate = Substrate::from_soup(soup).unwrap();
        let sound = Settings {
            radius: Some(Length::Units(0.01)),
            ..Settings::default()
        };
        let sound = sound.resolve(&substrate, "").unwrap();
        let places = Places::on(&substrate);
        let looks = |at: &[SeedPlace]| {
            let mut looks = 0;
            for (seed, radius) in [(1, 0.01), (2, 0.01), (1, 0.01), (1, 0.02)] {
                let recipe = Recipe {
                    at: at.to_vec(),
                    seed,
                    radius,
                    ..sound.clone()
                };
                let locate = || {
                    looks += 1;
                    recipe.seeds(&substrate)
                };
                let found = places.of_by(&recipe, locate);
                assert_eq!(found, recipe.seeds(&substrate), "{at:?}");
            }
            looks
        };
        let there = |x| SeedPlace::Point([x, 0.0, 0.0]);
        assert_eq!(looks(&[SeedPlace::Top]), 1);
        assert_eq!([there(0.1), there(0.2)].map(|at| looks(&[at])), [1, 1]);
        assert_eq!(looks(&[there(1e9)]), 1, "one that is none");
        assert_eq!(looks(&[SeedPlace::Random]), 3);
        assert_eq!(looks(&[SeedPlace::Top, there(0.1)]), 3);
    }
}
