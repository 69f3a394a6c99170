//! What a sweep's folder says of itself: its grid, and what each run came to.

use std::fs;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use anyhow::Context;
use serde::{Deserialize, Serialize};
use thallus::analysis::{Centres, SurfaceMetric, analyze};
use thallus::cluster::Cluster;
use thallus::export::{Elements, OutputDir, OutputError, format_of, write_file_atomically};
use thallus::picture::age_color;
use thallus::run::{Growth, Recipe, RunReport, Settings};
use thallus::substrate::Substrate;
use thallus::sweep::{Grid, GridRun, Outcome};

use super::export::smooth_on;
use super::failure::Failure;
use super::output::{ELEMENTS, RECIPE, REPORT, as_written};
use super::paths::hash_of;
use super::sweep_files::{CELLS, GRID, MEASURES};

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
pub(super) struct Record {
    recipe_hash: String,
    /// Of `elements.ply`, so that the measures are not taken for those of another lichen that came into
    /// the folder later. Records of earlier programs have none.
    elements_hash: Option<String>,
    stopped: String,
    measures: Vec<Measure>,
    /// Of all this, so that numbers that were changed later are not taken for measured ones. Records of earlier
    /// programs have none.
    hash: Option<String>,
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

impl Record {
    /// What a run came to.
    pub(super) fn of(
        substrate: &Substrate,
        run: &GridRun,
        growth: &Growth,
        report: &RunReport,
    ) -> Result<Self, Failure> {
        let measure = |(name, value): (String, f64)| Measure {
            name,
            value: value.is_finite().then_some(value),
        };
        let measures = measures(substrate, growth, report)?;
        let record = Self {
            recipe_hash: run.hash().context("a run without a recipe")?,
            elements_hash: Some(hash_to_be(substrate, &growth.cluster)?),
            stopped: report.stopped.to_owned(),
            measures: measures.into_iter().map(measure).collect(),
            hash: None,
        };
        Ok(Self {
            hash: record.hash_of_all(),
            ..record
        })
    }

    fn is_as_written(&self) -> bool {
        self.hash.is_some() && self.hash == self.hash_of_all()
    }

    fn hash_of_all(&self) -> Option<String> {
        let all = (
            &self.recipe_hash,
            &self.elements_hash,
            &self.stopped,
            &self.measures,
        );
        let json = serde_json::to_vec(&all).ok()?;
        Some(blake3::hash(&json).to_string())
    }

    /// Writes it into the folder of its run, to appear after everything else.
    pub(super) fn write(&self, output: &mut OutputDir) -> Result<(), Failure> {
        let json = serde_json::to_string_pretty(self).context("writing JSON")? + "\n";
        Ok(output.write(MEASURES, |out: &mut dyn Write| {
            out.write_all(json.as_bytes())
        })?)
    }

    /// That of this run in its folder, if it is there.
    fn read(folder: &Path, run: &GridRun) -> Option<Self> {
        let record: Self = json(folder, MEASURES)?;
        (record.recipe_hash == run.hash()?).then_some(record)
    }

    /// Whether the elements in the folder are those that were measured.
    fn is_of(&self, elements: &str) -> bool {
        self.elements_hash.as_deref() == Some(elements)
    }
}

fn json<T: for<'a> Deserialize<'a>>(folder: &Path, name: &str) -> Option<T> {
    serde_json::from_slice(&fs::read(folder.join(name)).ok()?).ok()
}

/// A hash of the elements' file as it will be written.
fn hash_to_be(substrate: &Substrate, cluster: &Cluster) -> anyhow::Result<String> {
    let mut hasher = blake3::Hasher::new();
    let elements = Elements::of(substrate, cluster);
    format_of(ELEMENTS.as_ref())?.write(&elements, &age_color, &mut hasher)?;
    Ok(hasher.finalize().to_string())
}

/// A hash of the elements' file that is there.
fn hash_there(folder: &Path) -> io::Result<String> {
    hash_of(&folder.join(ELEMENTS))
}

/// What a run came to, if its folder holds it finished.
pub(super) fn read(folder: &Path, run: &GridRun) -> Option<Outcome> {
    let record = Record::read(folder, run)?;
    let timed: Timed = json(folder, REPORT)?;
    let is_whole = record.is_as_written() && record.is_of(&hash_there(folder).ok()?);
    let value = |m: Measure| (m.name, m.value.unwrap_or(f64::NAN));
    is_whole.then(|| Outcome {
        stopped: record.stopped,
        measures: record.measures.into_iter().map(value).collect(),
        seconds: timed.seconds.grow,
    })
}

/// Whether the numbers in the folder of a run were changed after they were found.
pub(super) fn is_changed(folder: &Path, run: &GridRun) -> bool {
    let record = Record::read(folder, run);
    record.is_some_and(|record| record.hash.is_some() && !record.is_as_written())
}

/// Why what is in the folder of a run must not be replaced: it is not of this sweep, or no longer as it
/// was measured, and somebody may want it. None where it is a run of the sweep that is not finished, or
/// nothing.
pub(super) fn foreign(folder: &Path, run: &GridRun) -> Option<String> {
    let recipe = run.recipe.as_ref().ok()?;
    let other = other_recipe(folder, recipe).or_else(|| other_elements(folder, run))?;
    Some(format!(
        "{} holds another lichen than this sweep's: {other}",
        folder.display()
    ))
}

/// In what the recipe in a folder is not this one. A log alone says itself whose it is.
fn other_recipe(folder: &Path, recipe: &Recipe) -> Option<String> {
    let is_there = |name: &str| folder.join(name).symlink_metadata().is_ok();
    match (is_there(RECIPE), is_there(ELEMENTS)) {
        (false, false) => return None,
        (false, true) => return Some(format!("there is no {RECIPE} beside {ELEMENTS}")),
        (true, _) => {}
    }
    match Settings::read(&folder.join(RECIPE)) {
        Ok(there) => other_settings(&there, recipe),
        Err(error) => Some(Failure::from(error).reason()),
    }
}

/// In what settings that are complete are not this recipe, size included.
pub(super) fn other_settings(there: &Settings, recipe: &Recipe) -> Option<String> {
    let planned = Settings::from(recipe);
    let differences = planned.differences_and_size(there);
    (!differences.is_empty()).then(|| differences.join(", "))
}

/// Whether the elements in a folder are other ones than were measured.
fn other_elements(folder: &Path, run: &GridRun) -> Option<String> {
    let record = Record::read(folder, run).filter(|record| record.elements_hash.is_some())?;
    match hash_there(folder) {
        Ok(hash) if record.is_of(&hash) => None,
        Ok(_) => Some(format!(
            "{ELEMENTS} was changed or damaged after it was measured"
        )),
        Err(error) if error.kind() == ErrorKind::NotFound => None,
        Err(error) => Some(format!("{ELEMENTS}: reading failed: {error}")),
    }
}

/// Where it is said why a run failed: beside its folder, which may be what is wrong.
fn error_file(folder: &Path) -> PathBuf {
    folder.with_added_extension("error.txt")
}

/// Says why the run of this folder failed, where that is not said already.
pub(super) fn write_error(folder: &Path, reason: &str) -> Result<(), OutputError> {
    if read_error(folder).as_deref() == Some(reason.trim()) {
        return Ok(());
    }
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
fn measures(
    substrate: &Substrate,
    growth: &Growth,
    report: &RunReport,
) -> Result<Vec<(String, f64)>, Failure> {
    let mut elements = as_written(substrate, &growth.cluster)?;
    let (places, _) = smooth_on(&mut elements, substrate).context(ELEMENTS)?;
    let metric = SurfaceMetric::new(substrate, &places);
    let analysis = analyze(&elements.sample(), Some(&metric), Centres::default());
    let analysis = analysis.context(ELEMENTS)?;
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
