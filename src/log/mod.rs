//! The element log: what makes a run that was killed go on as if it had not been.
//!
//! Elements are appended in birth order as the run goes, in blocks that are made durable by and by
//! (see [`LogWriter`]). Index, launch arcs and the like are not stored: [`Run`](crate::run::Run)
//! rebuilds them from the elements. [`Log::read`] takes a log back, drops the torn tail that a
//! killed run may leave, and tells damage from it. `docs/log.md` has the format byte by byte.
//!
//! A run that begins a log, is stopped, and goes on as if it had not been:
//!
//! ```
//! use std::ops::ControlFlow;
//!
//! use thallus::log::{LOG, Log, LogWriter};
//! use thallus::run::{Execution, Run, Settings, StopSetting, grow, watch};
//! use thallus::substrate::{Soup, Substrate};
//!
//! let soup = Soup {
//!     positions: vec![[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]],
//!     triangles: vec![[0, 2, 1], [0, 3, 2]],
//!     notes: Vec::new(),
//! };
//! let substrate = Substrate::from_soup(soup)?;
//! let settings = Settings { stop: Some(StopSetting::Elements(200)), ..Settings::default() };
//! let recipe = settings.resolve(&substrate, "a square")?;
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join(LOG);
//!
//! // Begin, and stop half-way.
//! let half = watch(|_, progress| match progress.elements {
//!     100 => ControlFlow::Break(()),
//!     _ => ControlFlow::Continue(()),
//! });
//! let mut writer = LogWriter::create(&path, &recipe)?;
//! grow(&substrate, &recipe, &Execution::default(), &mut (&mut writer, half))?;
//! writer.finish()?;
//!
//! // Go on, in this process or another.
//! let log = Log::read(&path)?;
//! log.check(&recipe)?;
//! let (mut writer, begun) = LogWriter::open(log)?;
//! assert_eq!(begun.elements.len(), 100);
//! let growth = Run::new(&substrate, &recipe, begun)?.grow(&Execution::default(), &mut writer);
//! writer.finish()?;
//!
//! let whole = grow(&substrate, &recipe, &Execution::default(), &mut ())?;
//! assert_eq!(growth.cluster.elements(), whole.cluster.elements());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

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
