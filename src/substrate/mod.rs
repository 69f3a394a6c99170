//! The triangle mesh that lichen grows on: cleaned, welded, immutable after loading.

mod load;
mod soup;

pub use load::{Format, LoadError, LoadFault, Loaded, load_soup, parse_soup};
pub use soup::Soup;
