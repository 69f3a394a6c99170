//! `thallus sweep merge`: parts that were grown apart, as one sweep.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context;
use thallus::export::{OutputDir, OutputError};
use thallus::sweep::{Grid, Plan};

use super::failure::Failure;
use super::grow::{self, named_mesh};
use super::interrupt;
use super::number::plural;
use super::output::{ELEMENTS, FILES};
use super::skin::start_threads;
use super::sweep::{first_of, plan, settle};
use super::sweep_args::MergeArgs;
use super::sweep_page::Page;
use super::sweep_record::{self as record, GRID, MEASURES};
use super::terminal::Voice;

pub(super) fn merge(args: &MergeArgs) -> Result<(), Failure> {
    let voice = args.run.voice();
    let parts = folders(args)?;
    let mut grid = common_grid(&parts)?;
    start_threads(args.run.threads)?;
    let cancel = Arc::default();
    interrupt::listen(Arc::clone(&cancel));
    let mesh = mesh_file(args, &grid)?;
    let (substrate, _) = grow::load(&mesh)?;
    settle(&mut grid, &substrate, &mesh, false, voice)?;
    let plan = plan(&grid, &substrate)?;
    let sources = sources(&parts, &args.output, &plan, voice)?;
    record::open(&args.output, &grid)?;
    for (run, part) in sources.iter().enumerate() {
        let folder = plan.folder(run);
        if *part != args.output {
            copy(&part.join(&folder), &args.output.join(&folder))?;
        }
    }
    let folder = |run| args.output.join(plan.folder(run));
    let read = |run| record::read(&folder(run), &plan.runs[run]);
    let outcomes: Option<Vec<_>> = (0..plan.runs.len()).map(|run| read(run).map(Ok)).collect();
    let page = Page {
        substrate: &substrate,
        grid: &grid,
        plan: &plan,
        folder: &args.output,
        outcomes: &outcomes.context("a run was changed while it was copied: merge again")?,
        cancel: Arc::clone(&cancel),
        voice,
    };
    page.make(&args.pictures)?;
    page.tell()
}

/// The grid that all parts are of.
fn common_grid(parts: &[PathBuf]) -> Result<Grid, Failure> {
    let mut first: Option<(&PathBuf, Grid)> = None;
    for part in parts {
        let grid = Grid::read(&part.join(GRID))?;
        match &first {
            None => first = Some((part, grid)),
            Some((of, expected)) => {
                let differences = expected.differences(&grid);
                if !differences.is_empty() {
                    return Err(Failure::Failed(anyhow::anyhow!(
                        "{} is a part of another sweep than {}: {}",
                        part.display(),
                        of.display(),
                        differences.join("; ")
                    )));
                }
            }
        }
    }
    first
        .map(|(_, grid)| grid)
        .ok_or_else(|| Failure::usage("name the folders of the parts"))
}

/// The folders that runs are looked for in: the parts, and before them the output where it holds a
/// sweep, as after a join that was interrupted. It must not hold anything else.
fn folders(args: &MergeArgs) -> Result<Vec<PathBuf>, Failure> {
    let output = &args.output;
    let place = |folder: &Path| folder.canonicalize().ok();
    if output.join(GRID).is_file() {
        let there = place(output);
        let others = args.parts.iter().filter(|part| place(part) != there);
        return Ok([output].into_iter().chain(others).cloned().collect());
    }
    let is_new = match fs::read_dir(output) {
        Ok(mut entries) => entries.next().is_none(),
        Err(_) => !output.exists(),
    };
    match is_new {
        true => Ok(args.parts.clone()),
        false => Err(Failure::Failed(anyhow::anyhow!(
            "{} exists, and there is no sweep in it: the parts are joined into a new folder, or into one \
             of theirs",
            output.display()
        ))),
    }
}

fn mesh_file(args: &MergeArgs, grid: &Grid) -> Result<PathBuf, Failure> {
    if let Some(mesh) = &args.mesh {
        return Ok(mesh.clone());
    }
    let named = grid.base.mesh.as_deref().unwrap_or_default();
    named_mesh(&args.parts[0].join(GRID), named).ok_or_else(|| {
        Failure::Failed(anyhow::anyhow!(
            "{named}: the mesh of the sweep is neither here nor beside {}; name it with --mesh",
            args.parts[0].join(GRID).display()
        ))
    })
}

/// For each run the part that has it. What is in the output already is not told.
fn sources<'a>(
    parts: &'a [PathBuf],
    output: &Path,
    plan: &Plan,
    voice: Voice,
) -> Result<Vec<&'a Path>, Failure> {
    let mut sources = Vec::new();
    let mut missing = Vec::new();
    for run in 0..plan.runs.len() {
        let has =
            |part: &&PathBuf| record::read(&part.join(plan.folder(run)), &plan.runs[run]).is_some();
        let mut holders = parts.iter().filter(has);
        let Some(first) = holders.next() else {
            missing.push(plan.name(run));
            continue;
        };
        for second in holders {
            check_same(first, second, plan, run)?;
            if first == output {
                continue;
            }
            voice.warn(&format!(
                "{} is in {} and in {}: they are the same, and the first is taken",
                plan.name(run),
                first.display(),
                second.display()
            ));
        }
        sources.push(first.as_path());
    }
    match missing.is_empty() {
        true => Ok(sources),
        false => Err(lacking(&missing)),
    }
}

fn lacking(missing: &[String]) -> Failure {
    Failure::Failed(anyhow::anyhow!(
        "{} in none of the parts: {}; grow what is missing, or name its folder too; nothing was \
         written",
        plural(missing.len(), "run is", "runs are"),
        first_of(missing),
    ))
}

/// Refuses two results of one run.
fn check_same(first: &Path, second: &Path, plan: &Plan, run: usize) -> Result<(), Failure> {
    for name in [ELEMENTS, MEASURES] {
        let [a, b] =
            [first, second].map(|part| fs::read(part.join(plan.folder(run)).join(name)).ok());
        if a != b {
            return Err(Failure::Failed(anyhow::anyhow!(
                "{} differs between {} and {} in {name}: one of them was changed; grow it again with \
                 --only, or leave that part out",
                plan.name(run),
                first.display(),
                second.display()
            )));
        }
    }
    Ok(())
}

/// Copies a finished run, to appear complete or not at all.
fn copy(from: &Path, to: &Path) -> Result<(), Failure> {
    let mut output = OutputDir::create(to, true)?;
    let there = |name: &&&str| from.join(name).is_file();
    for name in FILES.iter().filter(there).chain([&MEASURES]) {
        let bytes = fs::read(from.join(name)).map_err(|source| OutputError::Io {
            path: from.join(name),
            doing: "reading",
            source,
        })?;
        output.write(name, |out| out.write_all(&bytes))?;
    }
    Ok(output.commit()?)
}
