//! The files of a run.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use thallus::cluster::Cluster;
use thallus::export::{Elements, OutputDir, OutputError, format_of, parse_elements};
use thallus::log::{LOG, LogWriter, count_elements};
use thallus::picture::age_color;
use thallus::run::{Execution, Growth, Recipe, RunReport, Settings, Timings};
use thallus::substrate::Substrate;

use super::cutout::Cutout;
use super::failure::Failure;
use super::preview::preview;

pub(crate) const ELEMENTS: &str = "elements.ply";
pub(crate) const RECIPE: &str = "recipe.toml";
pub(crate) const REPORT: &str = "report.json";
pub(crate) const PREVIEW: &str = "preview.png";

/// Every file of a run, in the order in which they are listed.
pub(crate) const FILES: &[&str] = &[ELEMENTS, RECIPE, PREVIEW, LOG, REPORT];

/// A finished run.
pub(crate) struct Finished<'a> {
    pub(crate) substrate: &'a Substrate,
    /// What of it is seen, if not all is.
    pub(crate) cutout: Option<&'a Cutout>,
    pub(crate) recipe: &'a Recipe,
    pub(crate) growth: &'a Growth,
    pub(crate) log: &'a LogWriter,
    pub(crate) execution: &'a Execution,
    pub(crate) seconds: Timings,
    /// Width of the picture in pixels; none for no picture.
    pub(crate) preview: Option<u32>,
}

impl Finished<'_> {
    /// Writes every file, which appear together, and says what it took and came to.
    pub(crate) fn write(self, mut folder: OutputDir) -> Result<RunReport, OutputError> {
        let report = self.write_into(&mut folder)?;
        folder.commit()?;
        Ok(report)
    }

    /// The same with files that appear when the folder is committed.
    pub(crate) fn write_into(mut self, folder: &mut OutputDir) -> Result<RunReport, OutputError> {
        let started = Instant::now();
        // First: by its table a run is known that was killed while its files were put in their places (`ended.rs`).
        self.write_lichen(folder)?;
        let recipe = self.recipe.to_toml();
        folder.write(RECIPE, |out| out.write_all(recipe.as_bytes()))?;
        if let Some(width) = self.preview {
            self.write_preview(folder, width)?;
        }
        self.seconds.write = started.elapsed().as_secs_f64();
        let report = self.report();
        let json = report.to_json();
        folder.write(REPORT, |out| out.write_all(json.as_bytes()))?;
        Ok(report)
    }

    /// The picture; none if Ctrl-C comes while it is taken, which may be longer than all of the growth.
    fn write_preview(&self, folder: &mut OutputDir, width: u32) -> Result<(), OutputError> {
        let told_before = self.execution.is_cancelled();
        let stopped = || !told_before && self.execution.is_cancelled();
        match preview(
            (self.substrate, self.cutout),
            &self.growth.cluster,
            width,
            &stopped,
        ) {
            Some(preview) => folder.write(PREVIEW, |out| out.write_all(&preview)),
            None => Ok(()),
        }
    }

    /// As a table and as a log: most of the time passes in waiting until they are on the disk.
    fn write_lichen(&self, folder: &mut OutputDir) -> Result<(), OutputError> {
        let (recipe, cluster) = (self.recipe, &self.growth.cluster);
        let table = |out: &mut dyn Write| write_ply(&Elements::of(self.substrate, cluster), out);
        let log = |out: &mut dyn Write| self.log.write_whole(recipe, cluster, out);
        folder.write_both((ELEMENTS, table), (LOG, log))
    }

    fn report(&self) -> RunReport {
        let Self {
            substrate,
            recipe,
            growth,
            execution,
            seconds,
            ..
        } = self;
        RunReport::new(substrate, recipe, growth, *seconds, execution)
    }
}

/// Refuses to replace files in a folder that no run wrote, or that are what the mesh is read from.
pub(crate) fn check_replaces_a_run(folder: &Path, mesh: &Path) -> Result<(), Failure> {
    let there = FILES.iter().map(|name| folder.join(name));
    let there: Vec<PathBuf> = there.filter(|file| file.exists()).collect();
    let place = mesh.canonicalize().ok();
    let is_mesh = |file: &&PathBuf| place.is_some() && file.canonicalize().ok() == place;
    let is_run =
        Settings::read(&folder.join(RECIPE)).is_ok() || count_elements(&folder.join(LOG)).is_ok();
    let (file, is) = match (there.iter().find(is_mesh), there.first()) {
        (Some(mesh), _) => (mesh, "is the mesh itself"),
        (None, Some(file)) if !is_run => (
            file,
            "is not a run's: there is no recipe.toml or run.log of one beside it",
        ),
        _ => return Ok(()),
    };
    Err(Failure::Failed(anyhow::anyhow!(
        "{} {is}, and --force would replace it: move it, or choose another folder",
        file.display()
    )))
}

fn write_ply(elements: &Elements, out: &mut dyn Write) -> std::io::Result<()> {
    let ply = format_of(ELEMENTS.as_ref()).map_err(std::io::Error::other)?;
    ply.write(elements, &age_color, out)
}

/// A lichen as one reads it from `elements.ply`, which rounds places.
pub(crate) fn as_written(substrate: &Substrate, cluster: &Cluster) -> anyhow::Result<Elements> {
    let mut bytes = Vec::new();
    write_ply(&Elements::of(substrate, cluster), &mut bytes)?;
    Ok(parse_elements(ELEMENTS.as_ref(), &bytes)?)
}

/// Ends of names that are files': one that is given where a folder is asked for is a slip.
const OF_FILES: [&str; 24] = [
    "ply", "glb", "gltf", "obj", "stl", "usd", "usda", "usdc", "usdz", "inc", "npy", "npz", "csv",
    "parquet", "json", "toml", "log", "html", "svg", "png", "jpg", "exr", "gif", "mp4",
];

/// Refuses the name of a file where a folder will be made.
pub(crate) fn check_names_folder(folder: &Path) -> Result<(), Failure> {
    let extension = folder
        .extension()
        .and_then(|e| e.to_str())
        .unwrap_or_default();
    let is_file = OF_FILES.iter().any(|of| of.eq_ignore_ascii_case(extension));
    // What is there is told of where it is opened.
    match is_file && !ends_in_slash(folder) && !folder.exists() {
        false => Ok(()),
        true => Err(Failure::usage(format!(
            "{0} is the name of a file, and a folder of several files will be made: give it another name, or write \
             {0}/ if it is to be called so",
            folder.display()
        ))),
    }
}

/// Refuses the name of a folder, by a slash at its end, where a file will be made.
pub(crate) fn check_names_file(file: &Path) -> Result<(), Failure> {
    match ends_in_slash(file) {
        false => Ok(()),
        true => Err(Failure::usage(format!(
            "{}: a slash at the end names a folder, and a file will be made: leave the slash away",
            file.display()
        ))),
    }
}

/// Whether a path is written as a folder's.
pub(crate) fn ends_in_slash(path: &Path) -> bool {
    let last = path.as_os_str().as_encoded_bytes().last();
    last.is_some_and(|&b| std::path::is_separator(char::from(b)))
}

/// Refuses what would be refused when the work is done.
pub(super) fn check_free(files: &[PathBuf], force: bool) -> Result<(), Failure> {
    let taken = |file: &&PathBuf| !force && file.symlink_metadata().is_ok();
    match files.iter().find(taken) {
        Some(file) => Err(OutputError::FileExists(file.clone()).into()),
        None => Ok(()),
    }
}
