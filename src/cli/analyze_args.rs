//! The arguments of `thallus analyze`.

use std::path::PathBuf;

use clap::Args;
use thallus::analysis::Centres;

use super::run_args::{RUN, RunArgs};

#[derive(Debug, Args)]
pub(crate) struct AnalyzeArgs {
    /// The folder of a run, or its elements.ply
    #[arg(value_name = "DIR|elements.ply")]
    pub(crate) from: PathBuf,
    /// The mesh that the lichen grew on, or a turned copy, for distances along it [default: the one that recipe.toml
    /// beside the elements names]
    #[arg(long, value_name = "MESH")]
    pub(crate) mesh: Option<PathBuf>,
    /// Measure one colony alone, by its number, from 0 [default: all as one lichen]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) colony: Option<u32>,
    /// Everything as JSON: curves, local slopes, ranges and errors of the fits, histograms
    #[arg(long)]
    pub(crate) json: bool,
    /// Folder for plots as SVG and PNG: the fits, their local slopes, widths of the branches, growth and
    /// density
    #[arg(long, value_name = "DIR")]
    pub(crate) plots: Option<PathBuf>,
    /// Elements to average over through space, at most
    #[arg(long, value_name = "N", default_value_t = Centres::default().space as u32, value_parser = clap::value_parser!(u32).range(1..), allow_negative_numbers = true)]
    pub(crate) centres: u32,
    /// Elements to average over along the surface, at most, which takes longer; 0 for no dimensions
    /// along it
    #[arg(long, value_name = "N", default_value_t = Centres::default().surface as u32, allow_negative_numbers = true)]
    pub(crate) surface_centres: u32,
    /// Overwrite plots that are there
    #[arg(long, help_heading = RUN)]
    pub(crate) force: bool,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}
