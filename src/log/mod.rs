//! The element log: what makes a run that was killed go on as if it had not been.
//!
//! Elements are appended in birth order as the run goes, in blocks that are made durable by and by
//! (see [`LogWriter`]). Index, launch arcs and the like are not stored: [`Run`](crate::run::Run)
//! rebuilds them from the elements. [`Log::read`] takes a log back, drops the torn tail that a
//! killed run may leave, and tells damage from it. `docs/log.md` has the format byte by byte.

mod block;
mod error;
mod head;
mod read;
mod rhythm;
mod whole;
mod write;

pub use block::LARGEST_BLOCK;
pub use error::LogError;
pub use head::head;
pub use read::{Log, count_elements};
pub use whole::write_whole;
pub use write::LogWriter;

/// Name of the log in a run's folder.
pub const LOG: &str = "run.log";
