//! How far a growth has come: a bar on a terminal, a line now and then elsewhere.

use std::io::{IsTerminal, stderr};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use thallus::cluster::Element;
use thallus::growth::Counts;
use thallus::run::{Observer, Progress, StopRule};

use super::number::{count, duration, percent, short};
use super::terminal;

/// Ticks of a full bar.
pub(super) const FULL: u64 = 1000;

/// A cluster's effective radius grows with its elements about like this: DLA's dimension.
pub(crate) const DIMENSION: f64 = 1.71;

/// Watches a growth and shows it on stderr.
pub(crate) struct Display {
    goal: Goal,
    form: Form,
    shown: Instant,
    pace: Pace,
    /// Whether it was said that open edges take the walkers.
    starving: bool,
}

/// When a growth ends.
#[derive(Clone, Copy)]
pub(crate) struct Goal {
    /// As it was asked for.
    pub(crate) stop: StopRule,
    /// Share of the surface at which no room is left, whatever was asked for.
    pub(crate) most_covered: f64,
    /// How many lichens grow.
    pub(crate) colonies: usize,
}

enum Form {
    Nothing,
    Bar(ProgressBar),
    Lines,
}

impl Display {
    /// For a growth that has come this far already.
    pub(crate) fn new(goal: Goal, begun: &Progress, quiet: bool) -> Self {
        let form = match (quiet, stderr().is_terminal()) {
            (true, _) => Form::Nothing,
            (false, true) => Form::Bar(bar()),
            (false, false) => Form::Lines,
        };
        let now = Instant::now();
        Self {
            goal,
            form,
            shown: now,
            pace: Pace::new(now, begun.elements, share_done(&goal, begun)),
            starving: false,
        }
    }

    /// Takes the bar away.
    pub(crate) fn finish(self) {
        if let Form::Bar(bar) = self.form {
            bar.finish_and_clear();
        }
    }

    fn show(&mut self, now: Instant, progress: &Progress) {
        self.shown = now;
        let share = share_done(&self.goal, progress);
        self.pace.update(now, progress.elements, share);
        self.tell_of_starving(progress);
        match &self.form {
            Form::Nothing => {}
            Form::Lines => {
                let size = size(progress, self.goal.colonies, "effective radius");
                terminal::plain(&line(progress, &size, &self.pace, share));
            }
            Form::Bar(bar) => {
                let size = size(progress, self.goal.colonies, "R_e");
                bar.set_message(short_line(progress, &size, &self.pace, share));
                bar.set_position((share * FULL as f64) as u64);
            }
        }
    }

    /// Says once why a growth comes to a stand-still at open edges that absorb.
    fn tell_of_starving(&mut self, progress: &Progress) {
        let Some(why) = starving(progress).filter(|_| !self.starving) else {
            return;
        };
        self.starving = true;
        match &self.form {
            Form::Bar(bar) => bar.suspend(|| terminal::warn(&why)),
            Form::Lines => terminal::warn(&why),
            Form::Nothing => {}
        }
    }
}

impl Observer for Display {
    fn born(&mut self, _: &Element, progress: &Progress) -> ControlFlow<()> {
        let every = match self.form {
            Form::Nothing => return ControlFlow::Continue(()),
            Form::Bar(_) => Duration::from_millis(100),
            Form::Lines => Duration::from_secs(3),
        };
        let now = Instant::now();
        self.pace.birth(now, progress.elements);
        if now - self.shown >= every {
            self.show(now, progress);
        }
        ControlFlow::Continue(())
    }
}

/// A bar for a growth, on stderr.
pub(super) fn bar() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(FULL), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{spinner} {bar:16} {percent:>3}% {wide_msg}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.set_message("growing");
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// How far the lichen extends, or of several the one that extends farthest.
fn size(progress: &Progress, colonies: usize, of_one: &str) -> String {
    match colonies {
        1 => format!("{of_one} {}", short(progress.effective_radius)),
        _ => format!("reach {}", short(progress.reach)),
    }
}

fn line(progress: &Progress, size: &str, pace: &Pace, share: f64) -> String {
    format!(
        "{} elements, {size}, covering {}, {} elements/s, {} left",
        count(progress.elements),
        percent(progress.covered),
        count(pace.elements_per_second as u64),
        time_left(pace, share),
    )
}

/// The same for beside a bar, on a terminal of 80 columns.
fn short_line(progress: &Progress, size: &str, pace: &Pace, share: f64) -> String {
    format!(
        "{} elements, {size}, {}/s, {} left",
        count(progress.elements),
        count(pace.elements_per_second as u64),
        time_left(pace, share),
    )
}

fn time_left(pace: &Pace, share: f64) -> String {
    match pace.seconds_left(share).map(duration) {
        None => "?".to_owned(),
        Some(left) if pace.is_falling() => format!("over {left}"),
        Some(left) => left,
    }
}

/// Walkers that open edges take for each element, from which on nearly all of the time goes into them.
const STARVING: u64 = 200;

fn starving(progress: &Progress) -> Option<String> {
    let Counts { absorbed, .. } = progress.counts;
    let each = absorbed / progress.elements.max(1);
    (each >= STARVING).then(|| {
        format!(
            "{} walkers were lost at open edges, {} for each element, and ever more will be: --boundary reflect \
             loses none",
            count(absorbed),
            count(each)
        )
    })
}

/// Share of the work that is done, 0 to 1, as far as one can tell.
fn share_done(goal: &Goal, progress: &Progress) -> f64 {
    let share = match goal.stop {
        StopRule::Elements(n) => progress.elements as f64 / n as f64,
        StopRule::Reach(length) => (progress.reach / length).powf(DIMENSION),
        StopRule::Cover(share) => progress.covered / share,
    };
    share
        .max(progress.covered / goal.most_covered)
        .clamp(0.0, 1.0)
}

/// The least time between two births that can be a pause, and births that there would have been in it.
const PAUSE: Duration = Duration::from_secs(1);
const MISSED: f64 = 100.0;

/// Of the greatest speed, below which it is taken to fall: a lichen that grows freely slows down by less.
const SMALL_PART: f64 = 0.2;

/// Recent speed.
struct Pace {
    /// When it began, with so many elements.
    begun: (Instant, u64),
    last_birth: Instant,
    has_paused: bool,
    at: Instant,
    elements: u64,
    share: f64,
    elements_per_second: f64,
    share_per_second: f64,
    /// The most that this has been.
    most_per_second: f64,
    /// Seconds that the averages look back on.
    memory: f64,
}

impl Pace {
    fn new(now: Instant, elements: u64, share: f64) -> Self {
        Self {
            begun: (now, elements),
            last_birth: now,
            has_paused: false,
            at: now,
            elements,
            share,
            elements_per_second: 0.0,
            share_per_second: 0.0,
            most_per_second: 0.0,
            memory: 0.0,
        }
    }

    /// Leaves out, once, the time in which coarser copies of a fine mesh are made: they take as long as
    /// thousands of births, and the time left was told to be minutes after it.
    fn birth(&mut self, now: Instant, elements: u64) {
        let gap = now - std::mem::replace(&mut self.last_birth, now);
        if self.has_paused || gap < PAUSE {
            return;
        }
        let before = (now - self.begun.0).saturating_sub(gap).as_secs_f64();
        let births = elements.saturating_sub(self.begun.1) as f64;
        if births * gap.as_secs_f64() > MISSED * before {
            self.has_paused = true;
            self.at += gap;
        }
    }

    /// Averages over about the last ten seconds.
    fn update(&mut self, now: Instant, elements: u64, share: f64) {
        let seconds = (now - self.at).as_secs_f64().max(1e-6);
        self.memory = (self.memory + seconds).min(10.0);
        let weight = (seconds / self.memory).min(1.0);
        let elements_now = elements.saturating_sub(self.elements) as f64 / seconds;
        let share_now = (share - self.share).max(0.0) / seconds;
        self.elements_per_second += weight * (elements_now - self.elements_per_second);
        self.share_per_second += weight * (share_now - self.share_per_second);
        self.most_per_second = self.most_per_second.max(self.share_per_second);
        (self.at, self.elements, self.share) = (now, elements, share);
    }

    /// Whether it has come down to a small part of what it was, as where the last room fills up: it will come down
    /// further.
    fn is_falling(&self) -> bool {
        self.share_per_second < SMALL_PART * self.most_per_second
    }

    fn seconds_left(&self, share: f64) -> Option<f64> {
        // More may find room than was thought.
        let is_known = self.share_per_second > 0.0 && share < 1.0;
        is_known.then(|| (1.0 - share) / self.share_per_second)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn progress(elements: u64) -> Progress {
        Progress {
            elements,
            effective_radius: 2.0,
            reach: 2.0,
            covered: 0.25,
            counts: Counts::default(),
        }
    }

    #[test]
    fn shares_follow_the_goal() {
        let p = progress(50);
        let goal = |stop, most_covered| Goal {
            stop,
            most_covered,
            colonies: 1,
        };
        let done = |stop, most_covered| share_done(&goal(stop, most_covered), &p);
        assert_eq!(done(StopRule::Elements(200), 4.0), 0.25);
        assert_eq!(done(StopRule::Cover(0.5), 1.0), 0.5);
        assert_eq!(done(StopRule::Reach(2.0), 1.0), 1.0);
        assert!(done(StopRule::Reach(4.0), 1.0) < 0.5);
        // More is asked for than there is room for.
        assert_eq!(done(StopRule::Elements(1_000_000), 1.0), 0.25);
    }

    #[test]
    fn a_steady_pace_is_measured_and_extrapolated() {
        let start = Instant::now();
        let mut pace = Pace::new(start, 0, 0.0);
        for second in 1..=40u64 {
            let now = start + Duration::from_secs(second);
            pace.update(now, 100 * second, second as f64 / 100.0);
        }
        assert!((pace.elements_per_second - 100.0).abs() < 1e-6);
        assert!((pace.seconds_left(0.4).unwrap() - 60.0).abs() < 1e-6);
    }

    #[test]
    fn a_pace_that_changes_is_forgotten() {
        let start = Instant::now();
        let mut pace = Pace::new(start, 0, 0.0);
        let mut elements = 0;
        for second in 1..=100u64 {
            elements += if second <= 50 { 1000 } else { 10 };
            pace.update(start + Duration::from_secs(second), elements, 0.0);
        }
        assert!((pace.elements_per_second - 10.0).abs() < 10.0);
        assert_eq!(pace.seconds_left(0.0), None);
    }

    #[test]
    fn one_pause_does_not_count_but_births_that_have_become_slow_do() {
        let start = Instant::now();
        let at = |seconds: f64| start + Duration::from_secs_f64(seconds);
        let pace_after = |pauses: u64| {
            let (mut pace, mut now) = (Pace::new(start, 1, 0.0), 0.0);
            for birth in 1..=2000u64 {
                let pauses_now = (1000..1000 + pauses).contains(&birth);
                now += if pauses_now { 20.0 } else { 0.001 };
                pace.birth(at(now), 1 + birth);
                pace.update(at(now), 1 + birth, birth as f64 / 4000.0);
            }
            pace
        };
        for pauses in [0, 1] {
            let left = pace_after(pauses).seconds_left(0.5).unwrap();
            assert!((left - 2.0).abs() < 0.01, "{pauses}: {left}");
        }
        assert!(pace_after(2).seconds_left(0.5).unwrap() > 4.0);
    }

    #[test]
    fn a_pace_that_falls_says_so() {
        let start = Instant::now();
        let mut pace = Pace::new(start, 0, 0.0);
        let mut share = 0.0;
        let mut left = Vec::new();
        for second in 1..=60u64 {
            share += if second <= 20 { 0.02 } else { 0.001 };
            pace.update(start + Duration::from_secs(second), 1, share);
            left.push(time_left(&pace, share));
        }
        assert_eq!(left[19], "29 s");
        assert!(left[59].starts_with("over "), "{}", left[59]);
    }

    #[test]
    fn edges_that_take_nearly_all_walkers_are_told_of() {
        let lost = |absorbed| Progress {
            counts: Counts {
                absorbed,
                ..Counts::default()
            },
            ..progress(50)
        };
        assert_eq!(starving(&lost(9_999)), None);
        let said = starving(&lost(10_000)).expect("a warning");
        assert!(
            said.contains("10,000 walkers") && said.contains("200 for each"),
            "{said}"
        );
    }

    #[test]
    fn the_line_says_it_all() {
        let start = Instant::now();
        let mut pace = Pace::new(start, 0, 0.0);
        pace.update(start + Duration::from_secs(2), 50, 0.25);
        let said = |colonies| {
            let size = size(&progress(50), colonies, "effective radius");
            line(&progress(50), &size, &pace, 0.25)
        };
        assert_eq!(
            said(1),
            "50 elements, effective radius 2, covering 25 %, 25 elements/s, 6.0 s left"
        );
        assert!(said(3).starts_with("50 elements, reach 2, covering"));
    }
}
