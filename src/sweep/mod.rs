//! Grids of lichens: what parameters do on one mesh, compared under equal conditions (Sumner 2001,
//! figure 9-4: L across, B down, everything else the same, each grown to the same radius).
//!
//! A [`Grid`] has [`Axis`]es over any settings, and seeds; [`Grid::plan`] makes the runs of it on a
//! mesh, in an order by cost, in parts for several machines. What the runs came to is a
//! [`Results`] table, and [`page()`] makes one self-contained HTML page of it. Nothing here grows,
//! reads a run or writes.

mod axis;
mod chart;
mod error;
mod grid;
mod grid_text;
mod page;
mod results;

pub use axis::{Axis, AxisValue, SYMBOLS};
pub use error::{AxisError, GridError, GridFileError, GridTextError};
pub use grid::{Cell, Grid, GridRun, Layout, Plan, REACH_RADII, cost};
pub use page::{CellPicture, captions, mean_of, page, title};
pub use results::{Outcome, Results, Summary};
