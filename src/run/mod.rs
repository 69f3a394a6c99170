//! A run: recipe, execution, the loop that grows, and who watches it.

mod driver;
mod execution;
mod observer;
mod recipe;

pub use crate::growth::SeedPlace;
pub use driver::{GrowError, Growth, Stopped, grow};
pub use execution::Execution;
pub use observer::{Observer, Progress};
pub use recipe::{MeshId, Recipe, StopRule};
