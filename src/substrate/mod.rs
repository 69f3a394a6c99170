//! The triangle mesh that lichen grows on: cleaned, welded, immutable after loading.

mod load;
mod soup;

pub use load::{LoadError, load_soup};
pub use soup::Soup;
