//! Seeds that begin elsewhere than where they were asked for.

use thallus::growth::SeedPlace;
use thallus::run::Recipe;
use thallus::substrate::Substrate;

use super::number::place;

/// Says so of each whose place is one by name at which nothing may grow.
pub(super) fn seeds(substrate: &Substrate, recipe: &Recipe) -> Vec<String> {
    if recipe.habitat(substrate).is_everywhere() {
        return Vec::new();
    }
    let seeds = recipe.seeds(substrate).unwrap_or_default();
    let placed = (0..).zip(recipe.at.iter().zip(seeds));
    let named = placed.filter(|(_, (name, _))| **name != SeedPlace::Random);
    let moved = named.filter_map(|(colony, (name, at))| {
        let as_named = name.locate(substrate, recipe.seed, colony).ok()?;
        let now = substrate.units().to_file(substrate.position(&at));
        (as_named != at).then(|| {
            format!(
                "at {name}: by the mask or the slope nothing may grow there; the seed is at {}, which is near",
                place(now.to_array())
            )
        })
    });
    moved.collect()
}
