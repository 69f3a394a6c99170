//! What a sweep's folder says of itself: its grid, and what each run came to.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use serde::{Deserialize, Serialize};
use thallus::analysis::{Centres, SurfaceMetric, analyze};
use thallus::export::{OutputDir, OutputError, write_file_atomically};
use thallus::run::{Growth, RunReport};
use thallus::substrate::Substrate;
use thallus::sweep::{Grid, GridRun, Outcome};

use super::export::smooth_on;
use super::failure::Failure;
use super::output::{ELEMENTS, REPORT, as_written};

/// The record of the grid.
pub(super) const GRID: &str = "grid.toml";

/// Where the runs are.
pub(super) const CELLS: &str = "cells";

/// What a run came to; the last of its files to appear.
pub(super) const MEASURES: &str = "measures.json";

/// Opens the folder of a sweep, or makes it.
pub(super) fn open(folder: &Path, grid: &Grid) -> Result<(), Failure> {
    let record = folder.join(GRID);
    if !record.is_file() {
        check_vacant(folder)?;
        let text = grid.to_toml();
        match write_file_atomically(&record, false, |out| out.write_all(text.as_bytes())) {
            // Another part of the sweep began in this moment.
            Ok(()) | Err(OutputError::FileExists(_)) => {}
            Err(error) => return Err(error.into()),
        }
    }
    check_same(&Grid::read(&record)?, grid, folder)?;
    let cells = folder.join(CELLS);
    let made = fs::create_dir_all(&cells);
    Ok(made.with_context(|| format!("{}: making the folder failed", cells.display()))?)
}

/// Refuses a folder with something else in it.
fn check_vacant(folder: &Path) -> Result<(), Failure> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Ok(());
    };
    let ours = |name: &str| name == CELLS || name.starts_with(".thallus-");
    let foreign = entries.flatten().any(|entry| {
        let name = entry.file_name();
        !name.to_str().is_some_and(ours)
    });
    match foreign {
        false => Ok(()),
        true => Err(Failure::Failed(anyhow::anyhow!(
            "{} is not empty, and there is no sweep in it: choose another folder",
            folder.display()
        ))),
    }
}

/// Refuses the folder of another grid.
pub(super) fn check_same(there: &Grid, grid: &Grid, folder: &Path) -> Result<(), Failure> {
    let differences = there.differences(grid);
    match differences.is_empty() {
        true => Ok(()),
        false => Err(Failure::Failed(anyhow::anyhow!(
            "{} holds another sweep: {}; choose another folder",
            folder.display(),
            differences.join("; ")
        ))),
    }
}

/// What a run came to, as `measures.json` has it.
#[derive(Debug, Deserialize, Serialize)]
struct Record {
    recipe_hash: String,
    stopped: String,
    measures: Vec<Measure>,
}

#[derive(Debug, Deserialize, Serialize)]
struct Measure {
    name: String,
    /// Null where there is no number.
    value: Option<f64>,
}

/// The part of `report.json` that the record does not have.
#[derive(Debug, Deserialize)]
struct Timed {
    seconds: Seconds,
}

#[derive(Debug, Deserialize)]
struct Seconds {
    grow: f64,
}

/// Writes what a run came to into its folder, to appear after everything else.
pub(super) fn write(
    output: &mut OutputDir,
    run: &GridRun,
    measures: Vec<(String, f64)>,
    stopped: &str,
) -> Result<(), Failure> {
    let measure = |(name, value): (String, f64)| Measure {
        name,
        value: value.is_finite().then_some(value),
    };
    let record = Record {
        recipe_hash: run.hash().context("a run without a recipe")?,
        stopped: stopped.to_owned(),
        measures: measures.into_iter().map(measure).collect(),
    };
    let json = serde_json::to_string_pretty(&record).context("writing JSON")? + "\n";
    Ok(output.write(MEASURES, |out: &mut dyn Write| {
        out.write_all(json.as_bytes())
    })?)
}

/// What a run came to, if its folder holds it finished.
pub(super) fn read(folder: &Path, run: &GridRun) -> Option<Outcome> {
    let json = |name: &str| fs::read(folder.join(name)).ok();
    let record: Record = serde_json::from_slice(&json(MEASURES)?).ok()?;
    let timed: Timed = serde_json::from_slice(&json(REPORT)?).ok()?;
    let is_whole = record.recipe_hash == run.hash()? && folder.join(ELEMENTS).is_file();
    let value = |m: Measure| (m.name, m.value.unwrap_or(f64::NAN));
    is_whole.then(|| Outcome {
        stopped: record.stopped,
        measures: record.measures.into_iter().map(value).collect(),
        seconds: timed.seconds.grow,
    })
}

/// Where it is said why a run failed: beside its folder, which may be what is wrong.
fn error_file(folder: &Path) -> PathBuf {
    folder.with_added_extension("error.txt")
}

/// Says why the run of this folder failed.
pub(super) fn write_error(folder: &Path, reason: &str) -> Result<(), OutputError> {
    let text = format!("{reason}\n");
    let fill = |out: &mut dyn Write| out.write_all(text.as_bytes());
    write_file_atomically(&error_file(folder), true, fill)
}

/// Why the run of this folder failed, if it is said.
pub(super) fn read_error(folder: &Path) -> Option<String> {
    let reason = fs::read_to_string(error_file(folder)).ok()?;
    Some(reason.trim().to_owned())
}

/// Forgets why the run of this folder failed.
pub(super) fn remove_error(folder: &Path) {
    let _ = fs::remove_file(error_file(folder));
}

/// The named numbers of a finished run, lengths in mesh units: those of the analysis, as `thallus analyze`
/// finds them in its folder, and what growing it took.
pub(super) fn measures(
    substrate: &Substrate,
    growth: &Growth,
    report: &RunReport,
) -> Result<Vec<(String, f64)>, Failure> {
    let mut elements = as_written(substrate, &growth.cluster)?;
    let places = smooth_on(&mut elements, substrate).context(ELEMENTS)?;
    let metric = SurfaceMetric::new(substrate, &places);
    let analysis = analyze(&elements.sample(), Some(&metric), Centres::default());
    let scalars = analysis.scalars().into_iter();
    // The radius is a parameter.
    let found = scalars.filter(|(name, _)| *name != "radius");
    let took = [
        ("covered_share", report.covered_share),
        ("walkers_per_element", report.walkers_per_element),
        ("contacts_per_walker", report.contacts_per_walker),
        ("steps_per_walker", report.steps_per_walker),
    ];
    let all = found.chain(took);
    Ok(all.map(|(name, x)| (name.to_owned(), x)).collect())
}
