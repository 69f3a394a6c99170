//! Seeds that begin elsewhere than where they were asked for.

use thallus::growth::{SeedPlace, Solids};
use thallus::run::Recipe;
use thallus::substrate::{Substrate, SurfacePoint};

use super::number::{place, short};

/// Says so of each whose place is one by name at which nothing may grow, or nothing has room, or nobody sees it.
pub(super) fn notes(substrate: &Substrate, recipe: &Recipe, seeds: &[SurfacePoint]) -> Vec<String> {
    let habitat = recipe.habitat(substrate);
    if habitat.is_everywhere() && substrate.components().len() == 1 {
        return Vec::new();
    }
    let solids = Solids::of(substrate);
    let units = substrate.units();
    let placed = (0..).zip(recipe.at.iter().zip(seeds));
    let named = placed.filter(|(_, (name, _))| **name != SeedPlace::Random);
    let moved = named.filter_map(|(colony, (name, at))| {
        let as_named = name.locate(substrate, recipe.seed, colony).ok()?;
        let [asked, now] = [&as_named, at].map(|at| units.to_file(substrate.position(at)));
        (as_named != *at).then(|| {
            let why = match solids.conceal(&as_named) {
                true => "another piece of the mesh hides that place",
                false => "by the mask or the slope nothing may grow there or about it",
            };
            format!(
                "at {name}: {why}; the seed is at {}, {} away, where there is room for a lichen",
                place(now.to_array()),
                short(asked.distance(now))
            )
        })
    });
    moved.collect()
}
