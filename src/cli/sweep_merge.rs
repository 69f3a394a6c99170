//! `thallus sweep merge`: parts that were grown apart, as one sweep.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;
use thallus::export::{OutputDir, OutputError};
use thallus::run::{Settings, shell_path};
use thallus::sweep::{Grid, Outcome, Plan};

use super::failure::Failure;
use super::grow;
use super::named_mesh::named_mesh;
use super::number::plural;
use super::output::{ELEMENTS, FILES, check_names_folder};
use super::run_args::start_threads;
use super::sweep_args::MergeArgs;
use super::sweep_ended::Ended;
use super::sweep_files::{GRID, MEASURES};
use super::sweep_plan::{failed, first_of, plan, settle};
use super::sweep_record as record;
use super::sweep_view::PictureStyle;
use super::terminal::{self, Voice};
use super::{interrupt, mask, resume, sweep_part};

pub(super) fn merge(args: &MergeArgs) -> Result<(), Failure> {
    let voice = args.run.voice();
    check_names_folder(&args.output)?;
    let parts = folders(args, voice)?;
    let mut grid = common_grid(&parts)?;
    start_threads(args.run.threads)?;
    let cancel = Arc::default();
    interrupt::listen(Arc::clone(&cancel));
    let mesh = mesh_file(args, &grid)?;
    let named_by: Vec<PathBuf> = parts.iter().map(|part| part.join(GRID)).collect();
    if !args.mask.is_empty() {
        let now = Settings {
            mask: Some(args.mask.clone()),
            ..Settings::default()
        };
        resume::mask_hash(&now, &grid.base)?;
        grid.base.mask = now.mask;
    }
    let grow::Ready {
        substrate,
        mask_layers,
        cutout,
        ..
    } = grow::load(&mesh, &grid.base, &named_by, voice)?;
    grid.base.mask = mask::named(&grid.base, &mask_layers, &args.output.join(GRID));
    settle(&mut grid, &substrate, &mesh, false, voice)?;
    let plan = plan(&grid, &substrate)?;
    let sources = sources(&parts, &args.output, &plan, &cancel, voice)?;
    let style = style(args, &parts)?;
    record::open(&args.output, &grid)?;
    style.keep(&args.output)?;
    for (run, source) in sources.iter().enumerate() {
        check_cancelled(&cancel)?;
        take(source, &args.output, &plan.folder(run))?;
    }
    let outcomes = outcomes(&sources, &args.output, &plan);
    let ended = Ended {
        substrate: &substrate,
        cutout: cutout.as_ref(),
        grid: &grid,
        plan: &plan,
        folder: &args.output,
        outcomes: &outcomes.context("a run was changed while it was copied: merge again")?,
        cancel: Arc::clone(&cancel),
        voice,
    };
    ended.make(&style)?;
    sweep_part::unmark(&args.output)?;
    let reason = |(run, source): (usize, &Source)| Some((run, source.as_ref().err()?.clone()));
    let failures = sources.iter().enumerate().filter_map(reason).collect();
    let [grid, output] = [&args.output.join(GRID), &args.output].map(|p| shell_path(p));
    let again = format!("thallus sweep {grid} -o {output} tries again");
    failed(&plan, &failures, &again)?;
    ended.tell()
}

/// Ends the command when somebody asked to stop before the page is begun.
fn check_cancelled(cancel: &AtomicBool) -> Result<(), Failure> {
    if !cancel.load(Ordering::Relaxed) {
        return Ok(());
    }
    terminal::warn("interrupted: the same command goes on");
    Err(Failure::Interrupted)
}

/// What every run came to; none where one is no longer there.
fn outcomes(
    sources: &[Source],
    output: &Path,
    plan: &Plan,
) -> Option<Vec<Result<Outcome, String>>> {
    let outcome = |(run, source): (usize, &Source)| match source {
        Ok(_) => record::read(&output.join(plan.folder(run)), &plan.runs[run]).map(Ok),
        Err(reason) => Some(Err(reason.clone())),
    };
    sources.iter().enumerate().map(outcome).collect()
}

/// How the pictures are taken: as in the parts.
fn style(args: &MergeArgs, parts: &[PathBuf]) -> Result<PictureStyle, Failure> {
    let folders: Vec<&Path> = parts.iter().map(PathBuf::as_path).collect();
    PictureStyle::new(&args.pictures, &folders)
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
fn folders(args: &MergeArgs, voice: Voice) -> Result<Vec<PathBuf>, Failure> {
    let output = &args.output;
    let place = |folder: &Path| folder.canonicalize().ok();
    let mut parts: Vec<PathBuf> = Vec::new();
    for part in &args.parts {
        let is_same = |other: &PathBuf| place(other).is_some_and(|p| Some(p) == place(part));
        match parts.iter().any(is_same) {
            true => voice.warn(&format!("{} is named twice", part.display())),
            false => parts.push(part.clone()),
        }
    }
    if output.join(GRID).is_file() {
        let there = place(output);
        let others = parts.into_iter().filter(|part| place(part) != there);
        return Ok([output.clone()].into_iter().chain(others).collect());
    }
    let is_new = match fs::read_dir(output) {
        Ok(mut entries) => entries.next().is_none(),
        Err(_) => !output.exists(),
    };
    match is_new {
        true => Ok(parts),
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
    let hash = grid.base.mesh_hash.as_deref();
    named_mesh(&args.parts[0].join(GRID), named, hash).ok_or_else(|| {
        Failure::Failed(anyhow::anyhow!(
            "{named}: the mesh of the sweep is not here, nor beside {} or above; name it with --mesh",
            args.parts[0].join(GRID).display()
        ))
    })
}

/// The part that has a run; or why it failed, where that is all that the parts have of it.
type Source<'a> = Result<&'a Path, String>;

/// Where each run comes from. What is in the output already is not told.
fn sources<'a>(
    parts: &'a [PathBuf],
    output: &Path,
    plan: &Plan,
    cancel: &AtomicBool,
    voice: Voice,
) -> Result<Vec<Source<'a>>, Failure> {
    let mut sources = Vec::new();
    let mut missing = BTreeSet::new();
    let mut doubled: BTreeMap<[&Path; 2], usize> = BTreeMap::new();
    for run in 0..plan.runs.len() {
        check_cancelled(cancel)?;
        let mut holders = holders(parts, plan, run)?.into_iter();
        let Some(first) = holders.next() else {
            match error(parts, plan, run) {
                Some(reason) => sources.push(Err(reason)),
                None => drop(missing.insert(run)),
            }
            continue;
        };
        for second in holders {
            check_same(first, second, plan, run)?;
            if first != output {
                *doubled.entry([first, second]).or_default() += 1;
            }
        }
        sources.push(Ok(first.as_path()));
    }
    if !missing.is_empty() {
        return Err(lacking(parts, plan, &missing));
    }
    for ([first, second], runs) in doubled {
        voice.warn(&twice(first, second, runs));
    }
    Ok(sources)
}

/// The parts that have a run finished. One that has another lichen in its place is refused.
fn holders<'a>(parts: &'a [PathBuf], plan: &Plan, run: usize) -> Result<Vec<&'a PathBuf>, Failure> {
    let mut holders = Vec::new();
    for part in parts {
        let folder = part.join(plan.folder(run));
        if record::read(&folder, &plan.runs[run]).is_some() {
            holders.push(part);
        } else if let Some(problem) = record::foreign(&folder, &plan.runs[run]) {
            return Err(Failure::Failed(anyhow::anyhow!(
                "{problem}; move it out of the sweep, or leave that part out; nothing was written"
            )));
        } else if record::is_changed(&folder, &plan.runs[run]) {
            return Err(Failure::Failed(anyhow::anyhow!(
                "{}: it was changed after it was measured; grow it again with --only, or leave that part out; \
                 nothing was written",
                folder.join(MEASURES).display()
            )));
        }
    }
    Ok(holders)
}

/// Why a run failed: it cannot be grown, or a part says so.
fn error(parts: &[PathBuf], plan: &Plan, run: usize) -> Option<String> {
    if let Err(problem) = &plan.runs[run].recipe {
        return Some(Failure::from(problem.clone()).reason());
    }
    let said = |part: &PathBuf| record::read_error(&part.join(plan.folder(run)));
    parts.iter().find_map(said)
}

fn lacking(parts: &[PathBuf], plan: &Plan, missing: &BTreeSet<usize>) -> Failure {
    let names: Vec<_> = missing.iter().map(|&run| plan.name(run)).collect();
    let wanting = match sweep_part::wanting(parts, plan, missing) {
        words if words.is_empty() => words,
        words => format!("{words}: "),
    };
    Failure::Failed(anyhow::anyhow!(
        "{wanting}{} in none of the folders: {}; grow what is missing, or name its folder too; nothing \
         was written",
        plural(names.len(), "run is", "runs are"),
        first_of(&names),
    ))
}

fn twice(first: &Path, second: &Path, runs: usize) -> String {
    let part = match sweep_part::in_both(first, second) {
        words if words.is_empty() => words,
        words => format!(" ({words})"),
    };
    format!(
        "{} both in {} and in {}{part}: they are the same, and those of the first are taken",
        plural(runs, "run is", "runs are"),
        first.display(),
        second.display()
    )
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

/// Brings a run into the output, or why it failed.
fn take(source: &Source, output: &Path, folder: &str) -> Result<(), Failure> {
    let to = output.join(folder);
    match source {
        Err(reason) => record::write_error(&to, reason)?,
        Ok(part) => {
            if *part != output {
                copy(&part.join(folder), &to)?;
            }
            record::remove_error(&to);
        }
    }
    Ok(())
}

/// Copies a finished run, to appear complete or not at all.
fn copy(from: &Path, to: &Path) -> Result<(), Failure> {
    let mut output = OutputDir::create(to, true)?;
    let there = |name: &&&str| from.join(name).is_file();
    for name in FILES.iter().filter(there).chain([&MEASURES]) {
        let bytes = fs::read(from.join(name)).map_err(|problem| OutputError::Io {
            path: from.join(name),
            doing: "reading",
            problem,
        })?;
        output.write(name, |out| out.write_all(&bytes))?;
    }
    Ok(output.commit()?)
}
