//! A run: recipe, execution, the loop that grows, and who watches it.

mod recipe;

pub use recipe::{MeshId, Recipe, SeedPlace, StopRule};
