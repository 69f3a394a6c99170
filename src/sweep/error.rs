//! What is wrong with a grid.

use std::io;
use std::path::PathBuf;

use crate::run::{RecipeTextError, SettingsError, UnknownSetting};

/// Why a parameter cannot vary so. Each message names the axis and the cure.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AxisError {
    /// No such setting.
    #[error(transparent)]
    Unknown(#[from] UnknownSetting),
    /// A setting that is the same in all cells.
    #[error("{axis} cannot be an axis: {instead}")]
    Fixed {
        /// The setting.
        axis: &'static str,
        /// What to do.
        instead: &'static str,
    },
    /// No values.
    #[error("axis {axis} has no values: list them, as {axis}=A,B,C")]
    Empty {
        /// The setting.
        axis: &'static str,
    },
    /// Nothing between two separators.
    #[error("axis {axis}: a value is missing from the list: write it, or one separator less")]
    Gap {
        /// The setting.
        axis: &'static str,
    },
    /// Not a value of the setting.
    #[error("axis {axis}: {value} is not a valid value: {problem}{advice}")]
    Value {
        /// The setting.
        axis: &'static str,
        /// What was given.
        value: String,
        /// Why not.
        problem: String,
        /// What to try.
        advice: &'static str,
    },
    /// The same value again.
    #[error("axis {axis}: {value} is there twice: keep one")]
    Twice {
        /// The setting.
        axis: &'static str,
        /// The value.
        value: String,
    },
    /// A range that is none.
    #[error("axis {axis}: '{text}' is not a range: {problem}")]
    Range {
        /// The setting.
        axis: &'static str,
        /// What was given.
        text: String,
        /// What to write.
        problem: &'static str,
    },
}

/// Why a grid cannot be grown.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GridError {
    /// An axis is wrong.
    #[error(transparent)]
    Axis(#[from] AxisError),
    /// Two axes of one setting.
    #[error("{0} is an axis twice: put all of its values into one")]
    SameAxis(&'static str),
    /// A flag says what an axis says.
    #[error("{axis} is an axis, and a flag sets it or what excludes it: keep one of them")]
    AxisAndFlag {
        /// The axis.
        axis: &'static str,
    },
    /// Axes that exclude one another.
    #[error("these axes cannot be together: {0}")]
    Exclusive(RecipeTextError),
    /// Nothing varies.
    #[error(
        "there is nothing to compare: give an axis, as curvature-radius=5r,10r,20r, or several seeds"
    )]
    Nothing,
    /// No seeds.
    #[error("a cell needs a seed: seeds may be 1 or more, and the last of them at most 2^64 - 1")]
    Seeds,
    /// Too large to list.
    #[error("{runs:.3e} runs are more than a million: leave out values, or make several sweeps")]
    TooMany {
        /// Cells times seeds.
        runs: f64,
    },
    /// Nothing can be grown.
    #[error("no cell of the grid can be grown; cell {cell}: {problem}")]
    NoCell {
        /// The name of the first.
        cell: String,
        /// Why that cannot.
        problem: SettingsError,
    },
    /// Two cells are one.
    #[error(
        "cells {first} and {second} are the same lichen: an axis changes nothing there; a preset \
         lies under what flags and recipe say, so leave those out"
    )]
    SameCell {
        /// The first.
        first: String,
        /// The other.
        second: String,
    },
}

/// A grid file that cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GridFileError {
    /// It cannot be read.
    #[error("{}: reading the grid failed: {problem}", .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        problem: io::Error,
    },
    /// It is no grid.
    #[error("{}: {problem}", .path.display())]
    Text {
        /// The file.
        path: PathBuf,
        /// Why.
        problem: GridTextError,
    },
}

/// A text that is no grid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GridTextError {
    /// The part that a recipe may have.
    #[error(transparent)]
    Recipe(#[from] RecipeTextError),
    /// An axis.
    #[error("line {line}: {problem}")]
    Axis {
        /// Where it is, from 1.
        line: usize,
        /// What is wrong.
        problem: AxisError,
    },
    /// An axis, and the same for all cells.
    #[error(
        "line {line}: {axis} is an axis, and {key} is set for all cells above [axes]: keep one of them"
    )]
    AlsoSet {
        /// Where the axis is, from 1.
        line: usize,
        /// The axis.
        axis: &'static str,
        /// What is set: the same, or what it excludes.
        key: &'static str,
    },
    /// Something else.
    #[error("line {line}: {problem}")]
    Other {
        /// Where it is, from 1.
        line: usize,
        /// What is wrong, and what to do.
        problem: &'static str,
    },
}
