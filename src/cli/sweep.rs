//! `thallus sweep`: grid → mesh → plan → runs → one page.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use thallus::run::{Execution, Recipe, Settings};
use thallus::sweep::{Grid, Outcome, Plan};

use super::failure::Failure;
use super::named_mesh::named_mesh;
use super::number::{count, duration, plural};
use super::output::check_names_folder;
use super::run_args::start_threads;
use super::sweep_args::{SweepArgs, SweepCommand};
use super::sweep_ended::Ended;
use super::sweep_ends::{End, Ends};
use super::sweep_estimate::Estimate;
use super::sweep_files::GRID;
use super::sweep_plan::{failed, first_of, plan, settle};
use super::sweep_record as record;
use super::sweep_run::{Replace, Sweep};
use super::sweep_view::PictureStyle;
use super::terminal::{self, Voice};
use super::{grow, interrupt, mask, memory, sweep_merge, sweep_part, warnings};

pub(crate) fn sweep(args: &SweepArgs) -> Result<(), Failure> {
    match (&args.command, &args.from, &args.output) {
        (Some(SweepCommand::Merge(merge)), ..) => sweep_merge::merge(merge),
        (None, Some(from), Some(output)) => sweep_into(args, from, output),
        _ => Err(Failure::usage(
            "say what to grow on and where to: thallus sweep MESH -o DIR --L 5r,10r,20r",
        )),
    }
}

fn sweep_into(args: &SweepArgs, from: &Path, output: &Path) -> Result<(), Failure> {
    check_names_folder(output)?;
    check_names_mesh_or_grid(from)?;
    let voice = Voice { quiet: args.quiet };
    let mut grid = grid(args, from)?;
    grid.cells()?;
    let mesh = mesh_file(args, from, &grid)?;
    start_threads(args.threads)?;
    let execution = Execution {
        threads: rayon::current_num_threads(),
        ..Execution::default()
    };
    interrupt::listen(execution.cancel.clone());
    let grid_file = is_grid(from).then_some(from);
    let named_by = [args.recipe.as_deref(), grid_file].into_iter().flatten();
    let named_by: Vec<PathBuf> = named_by.map(Path::to_owned).collect();
    let grow::Ready {
        substrate,
        mask_layers,
        cutout,
        ..
    } = grow::load(&mesh, &grid.base, &named_by, voice)?;
    grid.base.mask = mask::named(&grid.base, &mask_layers, &output.join(GRID));
    let is_named = args.mesh.is_some() || !is_grid(from);
    settle(&mut grid, &substrate, &mesh, is_named, voice)?;
    let plan = plan(&grid, &substrate)?;
    let only = args.only.as_deref().map(|name| cell(name, &plan));
    let only = only.transpose()?;
    let beside = from.parent().filter(|_| is_grid(from));
    let folders: Vec<&Path> = [output].into_iter().chain(beside).collect();
    let style = PictureStyle::new(&args.pictures, &folders)?;
    record::open(output, &grid)?;
    style.keep(output)?;
    args.shard
        .map_or(Ok(()), |shard| sweep_part::mark(output, shard))?;
    let sweep = Sweep {
        substrate: &substrate,
        cutout: cutout.as_ref(),
        grid: &grid,
        plan: &plan,
        folder: output,
        execution,
        voice,
    };
    let (asked, replace) = chosen(args, only, &sweep);
    let (runs, impossible): (Vec<_>, Vec<_>) =
        asked.into_iter().partition(|&run| sweep.is_possible(run));
    sweep.leave_out(&impossible);
    // The part that ends last takes the pictures, and no part knows whether it will be.
    let takes_pictures = args.shard.is_none();
    sweep.announce(&runs, takes_pictures.then_some(&style));
    let ends = sweep.grow(&runs, replace);
    let now = sweep.failed_now(&impossible, &ends);
    sweep.conclude(args, &style, now, &ends)
}

/// The grid that file and flags say.
fn grid(args: &SweepArgs, from: &Path) -> Result<Grid, Failure> {
    let flags = args.settings();
    let mut grid = match is_grid(from) {
        true => Grid::read(from)?,
        false => Grid {
            base: Settings::default(),
            axes: Vec::new(),
            seeds: 1,
        },
    };
    if is_grid(from) && !args.axes.0.is_empty() && !grid.axes.is_empty() {
        return Err(Failure::usage(format!(
            "{} has axes already: vary them there, or leave out --L, --B and --axis",
            from.display()
        )));
    }
    grid.axes.extend(args.axes.0.iter().cloned());
    grid.seeds = args.seeds.unwrap_or(grid.seeds);
    grid.check_flags(&flags)?;
    let recipe = args.recipe.as_deref().map(Settings::read).transpose()?;
    let below = recipe.unwrap_or_default().over(grid.base);
    grid.base = Settings {
        version: None,
        ..flags.over(below)
    };
    if !is_grid(from) {
        grid.base.mesh = None;
    }
    // A recipe may say what an axis varies.
    grid.forget_overruled();
    Ok(grid)
}

fn is_grid(from: &Path) -> bool {
    from.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("toml"))
}

/// Refuses a folder; names the grid in it if there is one.
fn check_names_mesh_or_grid(from: &Path) -> Result<(), Failure> {
    let grid = from.join(GRID);
    match (from.is_dir(), grid.is_file()) {
        (false, _) => Ok(()),
        (true, true) => Err(Failure::usage(format!(
            "{} is a folder: name the grid in it, {}",
            from.display(),
            grid.display()
        ))),
        (true, false) => Err(Failure::usage(format!(
            "{} is a folder: name a mesh, or a grid that a sweep has left",
            from.display()
        ))),
    }
}

/// The mesh to grow on: MESH, --mesh, or the one that the grid or its recipe names.
fn mesh_file(args: &SweepArgs, from: &Path, grid: &Grid) -> Result<PathBuf, Failure> {
    match (&args.mesh, is_grid(from), &grid.base.mesh) {
        (Some(mesh), true, _) => Ok(mesh.clone()),
        (Some(mesh), false, _) => Err(Failure::usage(format!(
            "{} and --mesh {} are two meshes: name one, for --mesh says where that of a grid lies",
            from.display(),
            mesh.display()
        ))),
        (None, false, _) => Ok(from.to_owned()),
        (None, true, None) => Err(Failure::usage(format!(
            "{} names no mesh: add mesh = \"FILE\" to it, or give --mesh FILE",
            from.display()
        ))),
        (None, true, Some(named)) => named_mesh(from, named, grid.base.mesh_hash.as_deref()).ok_or_else(|| {
            Failure::Failed(anyhow::anyhow!(
                "{named}: the mesh that {} names is not here, nor beside it or above; name it with --mesh",
                from.display()
            ))
        }),
    }
}

/// The cell of this name, if it can be grown.
fn cell(name: &str, plan: &Plan) -> Result<usize, Failure> {
    let found = plan.cells.iter().position(|cell| cell.name == name);
    let cell = found.ok_or_else(|| {
        let first = &plan.cells[0].name;
        Failure::usage(format!(
            "--only {name}: there is no such cell; cells have names as {first}, those of the folders \
             in cells/"
        ))
    })?;
    match plan.problem(cell) {
        None => Ok(cell),
        Some(problem) => Err(Failure::usage(format!(
            "--only {name}: this cell cannot be grown: {}",
            Failure::from(problem.clone()).reason()
        ))),
    }
}

/// The runs to grow, the costliest first, and what they may replace: all that are not finished, of the part or
/// the cell that was asked for; or all of that cell, where nothing is left of it to grow.
fn chosen(args: &SweepArgs, only: Option<usize>, sweep: &Sweep) -> (Vec<usize>, Replace) {
    let plan = sweep.plan;
    let mut runs = match args.shard {
        None => plan.order(),
        Some(shard) => plan.shard(shard.part, shard.parts),
    };
    runs.retain(|&run| only.is_none_or(|cell| plan.runs[run].cell == cell));
    let (finished, left): (Vec<_>, Vec<_>) =
        runs.iter().partition(|&&run| sweep.outcome(run).is_some());
    match only {
        Some(_) if !left.iter().any(|&run| sweep.is_possible(run)) => (runs, Replace::All),
        _ => {
            finished.into_iter().for_each(|run| sweep.tidy(run));
            (left, only.map_or(Replace::Nothing, |_| Replace::Foreign))
        }
    }
}

/// So many runs are worth a word about memory and time.
const MANY_RUNS: usize = 500;

impl Sweep<'_> {
    /// Names the cells that cannot be grown, and leaves beside each of these runs why.
    fn leave_out(&self, impossible: &[usize]) {
        let Some(&first) = impossible.first() else {
            return;
        };
        let names = self.names_of_impossible(impossible);
        self.voice.warn(&format!(
            "{} cannot be grown: {}; the first one: {} (the others grow without them)",
            plural(names.len(), "cell", "cells"),
            first_of(&names),
            self.problem(first).trim_end_matches('.')
        ));
        for &run in impossible {
            if self.execution.is_cancelled() {
                break;
            }
            self.keep_error(run, &self.problem(run));
        }
    }

    fn is_possible(&self, run: usize) -> bool {
        self.plan.runs[run].recipe.is_ok()
    }

    /// Why a run cannot be grown.
    fn problem(&self, run: usize) -> String {
        let problem = self.plan.runs[run].recipe.as_ref().err();
        problem.map_or_else(String::new, |problem| {
            Failure::from(problem.clone()).reason()
        })
    }

    /// Cells by their names; where a place on the mesh that chance finds is what does not suit, those
    /// of its seeds.
    fn names_of_impossible(&self, impossible: &[usize]) -> Vec<String> {
        let cell = |run: usize| self.plan.runs[run].cell;
        let cells: BTreeSet<usize> = impossible.iter().map(|&run| cell(run)).collect();
        let has_none = |cell: &usize| self.plan.problem(*cell).is_some();
        let hopeless: BTreeSet<usize> = cells.into_iter().filter(has_none).collect();
        let name = |&run: &usize| match hopeless.contains(&cell(run)) {
            true => self.plan.cells[cell(run)].name.clone(),
            false => self.plan.name(run),
        };
        let mut names: Vec<String> = impossible.iter().map(name).collect();
        names.dedup();
        names
    }

    /// What the runs grow.
    fn recipes(&self, runs: &[usize]) -> impl Iterator<Item = &Recipe> {
        runs.iter()
            .filter_map(|&run| self.plan.runs[run].recipe.as_ref().ok())
    }

    /// About how long these runs take, with the pictures of their cells if they are to be taken.
    fn estimate(&self, runs: &[usize], style: Option<&PictureStyle>) -> Estimate {
        let mut estimate = Estimate::default();
        self.recipes(runs)
            .for_each(|recipe| estimate.add_run(self.substrate, recipe));
        if let Some(style) = style {
            self.recipes(&self.one_of_each_cell(runs))
                .for_each(|recipe| estimate.add_picture(self.substrate, recipe, style));
        }
        estimate
    }

    /// A run of each cell that these are of.
    fn one_of_each_cell(&self, runs: &[usize]) -> Vec<usize> {
        let mut one = runs.to_vec();
        one.sort_by_key(|&run| self.plan.runs[run].cell);
        one.dedup_by_key(|run| self.plan.runs[*run].cell);
        one
    }

    /// Says what is about to happen.
    fn announce(&self, runs: &[usize], style: Option<&PictureStyle>) {
        let (all, cells) = (self.plan.runs.len(), self.plan.cells.len());
        let radius = self.plan.recipes().next().map(|recipe| recipe.radius);
        radius
            .map(|radius| warnings::warnings(self.substrate, radius))
            .iter()
            .flatten()
            .for_each(|warning| self.voice.warn(warning));
        if runs.is_empty() {
            return self
                .voice
                .note("no run is left to grow: only the page is made again");
        }
        let threads = self.execution.threads;
        let seconds = self.estimate(runs, style).seconds(threads);
        let kept = match all - runs.len() {
            0 => String::new(),
            n => format!(
                ", {} of which are not grown now (finished, not asked for or impossible)",
                count(n as u64)
            ),
        };
        self.voice.note(&format!(
            "{} of {}{kept}: roughly {} on {}",
            plural(all, "run", "runs"),
            plural(cells, "cell", "cells"),
            duration(seconds),
            plural(threads, "thread", "threads"),
        ));
        self.warn_of_memory(runs, threads);
        if runs.len() >= MANY_RUNS {
            self.voice.note(
                "that is a great many: --shard I/N spreads them over machines, and the same command \
                 goes on after Ctrl-C",
            );
        }
    }

    /// The largest runs may be at work together.
    fn warn_of_memory(&self, runs: &[usize], threads: usize) {
        let needed = self
            .recipes(runs)
            .map(|r| memory::needed(self.substrate, r));
        let mut needed: Vec<f64> = needed.collect();
        needed.sort_by(|a, b| b.total_cmp(a));
        let lichens: f64 = needed.iter().take(threads).sum();
        let together = lichens + memory::pictured(self.substrate);
        if let Some(free) = memory::available().filter(|free| together > *free) {
            self.voice.warn(&format!(
                "{} runs at a time may need {} of memory, and {} are free: give a smaller --threads",
                threads,
                memory::size(together),
                memory::size(free)
            ));
        }
    }

    /// What came of it, and how the command ends.
    fn conclude(
        &self,
        args: &SweepArgs,
        style: &PictureStyle,
        now: BTreeMap<usize, String>,
        ends: &Ends,
    ) -> Result<(), Failure> {
        let all = self.plan.runs.len();
        // Once: it reads all elements.
        let found: Vec<_> = (0..all).map(|run| self.outcome(run)).collect();
        let finished = found.iter().flatten().count();
        let folder = self.folder.display();
        if self.execution.is_cancelled() {
            let (finished, all) = (count(finished as u64), count(all as u64));
            // It would begin anew.
            let is_over = args.only.is_some() && ends.values().all(|end| *end == End::Finished);
            let without = if is_over { "without --only " } else { "" };
            terminal::warn(&format!(
                "interrupted: {finished} of {all} runs of {folder} are finished; {without}the same command \
                 goes on"
            ));
            return Err(Failure::Interrupted);
        }
        let failures = self.failures(&found, now);
        let outcomes = match outcomes(found, &failures) {
            Ok(outcomes) => outcomes,
            Err(missing) => {
                let done = format!(
                    "{folder}: {} of {} runs are finished",
                    count(finished as u64),
                    count(all as u64)
                );
                self.tell_unfinished(args, &done, &missing, ends)?;
                return failed(self.plan, &failures, AGAIN);
            }
        };
        let ended = Ended {
            substrate: self.substrate,
            cutout: self.cutout,
            grid: self.grid,
            plan: self.plan,
            folder: self.folder,
            outcomes: &outcomes,
            cancel: self.execution.cancel.clone(),
            voice: self.voice,
        };
        ended.make(style)?;
        failed(self.plan, &failures, AGAIN)?;
        ended.tell()
    }

    /// The runs that failed now, those that cannot be among them, and why.
    fn failed_now(&self, impossible: &[usize], ends: &Ends) -> BTreeMap<usize, String> {
        let ended = ends.iter().filter_map(|(&run, end)| match end {
            End::Failed(reason) => Some((run, reason.clone())),
            _ => None,
        });
        let left_out = impossible.iter().map(|&run| (run, self.problem(run)));
        ended.chain(left_out).collect()
    }

    /// The runs that failed, now or before, and why.
    fn failures(
        &self,
        found: &[Option<Outcome>],
        now: BTreeMap<usize, String>,
    ) -> BTreeMap<usize, String> {
        let left = (0..found.len()).filter(|&run| found[run].is_none());
        let recorded = |run| Some((run, record::read_error(&self.folder_of(run))?));
        left.filter_map(recorded).chain(now).collect()
    }

    /// Other parts, or another process, have yet to end; or what had ended is there no longer.
    fn tell_unfinished(
        &self,
        args: &SweepArgs,
        done: &str,
        missing: &[usize],
        ends: &Ends,
    ) -> Result<(), Failure> {
        let is_part = args.shard.is_some() || args.only.is_some();
        let is_gone = |run: &&usize| match ends.get(*run) {
            Some(End::Elsewhere) => false,
            Some(End::Finished) => true,
            _ => !is_part,
        };
        let gone = missing.iter().filter(is_gone);
        let gone: Vec<String> = gone.map(|&run| self.plan.name(run)).collect();
        if !gone.is_empty() {
            return Err(Failure::Failed(anyhow::anyhow!(
                "{done}; what {} came to is gone, or cannot be read: {}; the same command grows again what \
                 is missing",
                plural(gone.len(), "run", "runs"),
                first_of(&gone)
            )));
        }
        if !is_part {
            return Err(Failure::Failed(anyhow::anyhow!(
                "{done}, and another process grows the others: wait for it, then give the same command \
                 again for the page"
            )));
        }
        if !self.voice.quiet {
            terminal::say(&format!(
                "{done}. The page is made by the part that ends last in this folder; parts in several \
                 folders are joined by: thallus sweep merge DIR... -o OUT"
            ))?;
        }
        Ok(())
    }
}

/// What every run came to; or the runs that came to nothing yet.
fn outcomes(
    found: Vec<Option<Outcome>>,
    failures: &BTreeMap<usize, String>,
) -> Result<Vec<Result<Outcome, String>>, Vec<usize>> {
    let (mut outcomes, mut missing) = (Vec::new(), Vec::new());
    for (run, outcome) in found.into_iter().enumerate() {
        match outcome
            .map(Ok)
            .or_else(|| failures.get(&run).cloned().map(Err))
        {
            Some(outcome) => outcomes.push(outcome),
            None => missing.push(run),
        }
    }
    match missing.is_empty() {
        true => Ok(outcomes),
        false => Err(missing),
    }
}

/// How a sweep tries again what failed.
const AGAIN: &str = "the same command tries again";
