//! How far a sweep has come: a bar on a terminal, a line a run elsewhere.

use std::io::{IsTerminal, stderr};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::ProgressBar;
use thallus::sweep::{Outcome, Plan};

use super::number::{count, duration, elements};
use super::progress::{FULL, bar};
use super::sweep_ends::{End, lock};
use super::terminal::{self, Voice};

/// Shows runs as they end.
pub(super) struct Show<'a> {
    plan: &'a Plan,
    voice: Voice,
    bar: Option<ProgressBar>,
    started: Instant,
    runs: usize,
    /// Runs at a time.
    together: usize,
    /// Of all runs.
    cost: f64,
    done: Mutex<Done>,
}

#[derive(Default)]
struct Done {
    runs: usize,
    cost: f64,
}

impl<'a> Show<'a> {
    pub(super) fn new(plan: &'a Plan, runs: &[usize], together: usize, voice: Voice) -> Self {
        let shown = !voice.quiet && stderr().is_terminal();
        Self {
            plan,
            voice,
            bar: shown.then(bar),
            started: Instant::now(),
            runs: runs.len(),
            together,
            cost: runs.iter().map(|&run| plan.costs[run]).sum(),
            done: Mutex::default(),
        }
    }

    /// A run ended.
    pub(super) fn ended(&self, run: usize, end: &End, outcome: Option<&Outcome>, took: Duration) {
        let mut done = lock(&self.done);
        if *end != End::Interrupted {
            done.runs += 1;
            done.cost += self.plan.costs[run];
        }
        let share = done.cost / self.cost;
        // What those that are under way have done is not known: beside dear ones a cheap one tells nothing.
        let left = match done.runs < self.together {
            true => String::new(),
            false => format!(
                ", {} left",
                duration(left(self.started.elapsed().as_secs_f64(), share))
            ),
        };
        let line = format!(
            "{} of {} runs{left}; {}: {}",
            count(done.runs as u64),
            count(self.runs as u64),
            self.plan.name(run),
            words(end, outcome, took)
        );
        match (&self.bar, end) {
            (_, End::Failed(_)) => self.apart(|| self.voice.warn(&line)),
            (Some(bar), _) => {
                bar.set_position((FULL as f64 * share) as u64);
                bar.set_message(line);
            }
            (None, _) if !self.voice.quiet => terminal::plain(&line),
            (None, _) => {}
        }
    }

    /// Writes lines without tearing the bar.
    fn apart(&self, write: impl FnOnce()) {
        match &self.bar {
            Some(bar) => bar.suspend(write),
            None => write(),
        }
    }

    pub(super) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// Seconds still to go when this share took so many. Costs add up to a little more than all, or less,
/// by the order in which runs end.
fn left(seconds: f64, share: f64) -> f64 {
    (seconds * (1.0 / share.max(1e-9) - 1.0)).max(0.0)
}

fn words(end: &End, outcome: Option<&Outcome>, took: Duration) -> String {
    let grown = outcome.and_then(|o| o.measures.iter().find(|(name, _)| name == "elements"));
    match (end, grown) {
        (End::Failed(reason), _) => reason.clone(),
        (End::Elsewhere, _) => "another process grows it".to_owned(),
        (End::Interrupted, _) => "interrupted".to_owned(),
        (End::Finished, Some((_, n))) => {
            let seconds = duration(took.as_secs_f64());
            format!("{} in {seconds}", elements(*n as usize))
        }
        (End::Finished, None) => "done".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_left_of_the_whole_however_it_was_added_up() {
        assert_eq!(left(10.0, 0.25), 30.0);
        for share in [1f64.next_down(), 1.0, 1f64.next_up(), 1.01] {
            assert_eq!(duration(left(100.0, share)), duration(0.0));
        }
    }
}
