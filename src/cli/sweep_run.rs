//! Growing the runs of a grid: the costliest first, each durable as soon as it is done.

use std::fs;
use std::io::{self, ErrorKind};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use thallus::export::{OutputDir, OutputError};
use thallus::log::{LOG, Log, LogError, LogWriter};
use thallus::run::{Execution, Recipe, Run, Stopped, Timings};
use thallus::substrate::Substrate;
use thallus::sweep::{Grid, Outcome, Plan};

use super::cutout::Cutout;
use super::failure::Failure;
use super::memory::After;
use super::output::Finished;
use super::sweep_ends::{End, Ends, lock};
use super::sweep_files::MEASURES;
use super::sweep_progress::Show;
use super::sweep_record::{self as record, Record};
use super::terminal::Voice;
use super::{memory, number, resume};

/// A sweep that is ready to run.
pub(super) struct Sweep<'a> {
    pub(super) substrate: &'a Substrate,
    /// What of it is seen, if not all is.
    pub(super) cutout: Option<&'a Cutout>,
    pub(super) grid: &'a Grid,
    pub(super) plan: &'a Plan,
    pub(super) folder: &'a Path,
    /// Threads are those of all runs together.
    pub(super) execution: Execution,
    pub(super) voice: Voice,
}

/// What runs may put theirs in the place of, besides what is unfinished of them, which they go on with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Replace {
    Nothing,
    /// What is not of this sweep, or no longer as it was measured.
    Foreign,
    /// That, and what is finished.
    All,
}

impl Sweep<'_> {
    /// The folder of a run.
    pub(super) fn folder_of(&self, run: usize) -> PathBuf {
        self.folder.join(self.plan.folder(run))
    }

    /// What a run came to, if it is finished.
    pub(super) fn outcome(&self, run: usize) -> Option<Outcome> {
        record::read(&self.folder_of(run), &self.plan.runs[run])
    }

    /// Clears what a process left in the folder of a finished run when it was killed in the moment
    /// between the last file and the clearing.
    pub(super) fn tidy(&self, run: usize) {
        let entries = fs::read_dir(self.folder_of(run)).into_iter().flatten();
        let is_stage = |e: fs::DirEntry| e.file_name().to_string_lossy().starts_with(".thallus-");
        if entries.flatten().any(is_stage) {
            drop(OutputDir::create(&self.folder_of(run), true));
        }
    }

    /// Grows these runs in this order, as many at a time as there are threads. Tells how each ended.
    pub(super) fn grow(&self, runs: &[usize], replace: Replace) -> Ends {
        let workers = self.execution.threads.min(runs.len());
        // Two threads gain a run little (docs/performance.md).
        let each = Execution {
            threads: 1,
            ..self.execution.clone()
        };
        let next = AtomicUsize::new(0);
        let interrupted = runs.iter().map(|&run| (run, End::Interrupted));
        let ends: Mutex<Ends> = Mutex::new(interrupted.collect());
        let show = Show::new(self.plan, runs, workers, self.voice);
        let work = || {
            while !each.is_cancelled() {
                let place = next.fetch_add(1, Ordering::Relaxed);
                let Some(&run) = runs.get(place) else { break };
                let started = Instant::now();
                let end = self.try_run(run, &each, replace);
                show.ended(run, &end, self.outcome(run).as_ref(), started.elapsed());
                lock(&ends).insert(run, end);
            }
        };
        std::thread::scope(|scope| {
            (0..workers).for_each(|_| {
                scope.spawn(work);
            });
        });
        show.finish();
        ends.into_inner().unwrap_or_else(|e| e.into_inner())
    }

    /// Grows a run, and leaves its error beside its folder where it fails.
    fn try_run(&self, run: usize, execution: &Execution, replace: Replace) -> End {
        let folder = self.folder_of(run);
        let grow = || self.run(run, &folder, execution, replace);
        let done = catch_unwind(AssertUnwindSafe(grow));
        let reason = match done {
            Ok(Ok(end)) => {
                record::remove_error(&folder);
                return end;
            }
            Ok(Err(failure)) => failure.reason(),
            Err(_) => "the program failed at this run: please report it with the recipe".to_owned(),
        };
        self.keep_error(run, &reason);
        End::Failed(reason)
    }

    /// Leaves beside a run's folder why it failed.
    pub(super) fn keep_error(&self, run: usize, reason: &str) {
        if let Err(error) = record::write_error(&self.folder_of(run), reason) {
            self.voice.warn(&error.to_string());
        }
    }

    fn run(
        &self,
        run: usize,
        folder: &Path,
        execution: &Execution,
        replace: Replace,
    ) -> Result<End, Failure> {
        let mut output = match OutputDir::create(folder, true) {
            Err(OutputError::Locked { .. }) => return Ok(End::Elsewhere),
            output => output?,
        };
        if replace != Replace::All && self.outcome(run).is_some() {
            return Ok(End::Finished);
        }
        let replace = self.check_ours(run, folder, replace)?;
        let recipe = self.plan.runs[run].recipe.as_ref();
        let recipe = recipe.map_err(Clone::clone)?;
        memory::check(
            self.substrate,
            recipe,
            0,
            After::Sweep,
            Voice { quiet: true },
        )?;
        let (begun, mut log) = self.begin(&mut output, run, recipe, replace)?;
        let started = Instant::now();
        let growth = begun.grow(execution, &mut log);
        let seconds = Timings {
            grow: started.elapsed().as_secs_f64(),
            ..Timings::default()
        };
        log.close()?;
        if growth.stopped == Stopped::Cancelled {
            return Ok(End::Interrupted);
        }
        let finished = Finished {
            substrate: self.substrate,
            cutout: self.cutout,
            recipe,
            growth: &growth,
            log: &log,
            execution,
            seconds,
            preview: None,
        };
        let report = finished.write_into(&mut output)?;
        let grown = &self.plan.runs[run];
        Record::of(self.substrate, grown, &growth, &report)?.write(&mut output)?;
        output.commit()?;
        Ok(End::Finished)
    }

    /// Refuses to replace what somebody grew in the folder of a run, or changed there, unless that was asked for:
    /// then all of it goes.
    fn check_ours(&self, run: usize, folder: &Path, replace: Replace) -> Result<Replace, Failure> {
        match record::foreign(folder, &self.plan.runs[run]) {
            None => Ok(replace),
            Some(problem) if replace == Replace::Nothing => Err(self.with_cure(run, &problem)),
            Some(_) => Ok(Replace::All),
        }
    }

    /// A problem with what is in the folder of a run, and how it is grown all the same.
    fn with_cure(&self, run: usize, problem: &str) -> Failure {
        let cell = &self.plan.cells[self.plan.runs[run].cell].name;
        Failure::Failed(anyhow::anyhow!(
            "{problem}; move it out of the sweep if you want to keep it, or let --only {cell} grow the \
             cell anew in its place"
        ))
    }

    /// The run with what is sound of an interrupted one, and its log.
    fn begin(
        &self,
        output: &mut OutputDir,
        run: usize,
        recipe: &Recipe,
        replace: Replace,
    ) -> Result<(Run<'_>, LogWriter), Failure> {
        let earlier = match replace {
            Replace::All => None,
            _ => self.earlier(run, recipe, replace)?,
        };
        output.remove(MEASURES)?;
        let Some(earlier) = earlier else {
            let (log, begun) = LogWriter::open(resume::begin(output, recipe)?)?;
            return Ok((Run::new(self.substrate, recipe, begun)?, log));
        };
        let (log, begun) = LogWriter::open(earlier)?;
        let run = Run::new(self.substrate, recipe, begun)?;
        resume::place_recipe(output, recipe)?;
        Ok((run, log))
    }

    /// What is sound of an interrupted run's log; none where the run begins anew. What is dropped of a damaged
    /// log is told, and grows again as it was. A log that cannot be read now may be sound.
    fn earlier(
        &self,
        run: usize,
        recipe: &Recipe,
        replace: Replace,
    ) -> Result<Option<Log>, Failure> {
        let path = self.folder_of(run).join(LOG);
        let shown = path.display();
        let other = |problem: String| match replace {
            Replace::Nothing => Err(self.with_cure(run, &problem)),
            _ => Ok(None),
        };
        let is_gone = |error: io::Error| error.kind() == ErrorKind::NotFound;
        if path.symlink_metadata().is_err_and(is_gone) {
            return Ok(None);
        }
        let log = match Log::read_sound(&path) {
            Ok(log) if log.is_damaged => {
                self.voice.warn(&format!(
                    "{shown} is damaged at byte {}: the run goes on from the {} before that, and what came \
                     after them grows again as it was",
                    log.sound_bytes,
                    number::elements(log.begun.elements.len())
                ));
                log
            }
            Err(LogError::NoLog(_) | LogError::Head(_)) => {
                self.voice.warn(&format!(
                    "{shown} is damaged at its head: nothing in it can be trusted, and the run begins anew"
                ));
                return Ok(None);
            }
            Err(LogError::Version { found, .. }) => {
                return other(format!("{shown} is of a run by thallus {found}"));
            }
            log => log?,
        };
        match record::other_settings(&log.recipe, recipe) {
            None => Ok(Some(log)),
            Some(differences) => other(format!(
                "{shown} is of another run than this sweep's: {differences}"
            )),
        }
    }
}
