//! Growth models: laws that choose where the next element is born.
//!
//! A law is a [`GrowthModel`]. The one of Sumner 2001 is [`WalkerModel`]: follow
//! [`walker`](WalkerModel) from launch to joining through `launch`, `stick` and `join`.

mod barren;
mod books;
mod brownian;
mod enclosed;
mod far;
mod flight;
mod habitat;
mod hidden;
mod join;
mod launch;
mod launcher;
mod model;
mod near;
mod nearby;
mod orbit;
mod parameters;
mod passage;
mod patience;
mod place;
mod scene;
mod seeds;
mod sharing;
mod step;
mod stick;
mod stride;
mod surroundings;
mod together;
mod walker;
mod walker_model;

pub use habitat::{Habitat, Slope};
pub use hidden::Solids;
pub use join::Joined;
pub use launch::LaunchRing;
pub(crate) use model::COUNTS;
pub use model::{Counts, GrowthModel, Halt, Parallel};
pub use parameters::{Boundary, Join, Law, Parameters, Steps};
pub use passage::{Arrival, Lune};
pub(crate) use place::four_digits;
pub use place::{PlaceError, SeedPlace};
pub use step::{RandomStep, random_step};
pub use stick::Stickiness;
pub use surroundings::Surroundings;
pub use walker_model::{CROSSINGS_PER_TRIANGLE, WalkerModel};
