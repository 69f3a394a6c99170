//! Growth models: laws that choose where the next element is born.

mod parameters;

pub use parameters::{Boundary, Join, Parameters, Steps};
