//! What files of a sweep are called.

/// The record of the grid.
pub(super) const GRID: &str = "grid.toml";

/// Where the runs are.
pub(super) const CELLS: &str = "cells";

/// What a run came to; the last of its files to appear.
pub(super) const MEASURES: &str = "measures.json";

/// The table of all runs.
pub(super) const CSV: &str = "results.csv";
