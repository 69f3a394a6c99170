//! How many threads share the walkers: as many as pay.

use std::time::{Duration, Instant};

use super::Counts;

/// Finds by trial on how many threads most is walked in a second. Where walks are short, or other programs
/// keep the cores busy, fewer are faster than all. The result is the same for any number, so the clock may
/// decide.
pub(super) struct Sharing {
    threads: usize,
    most: usize,
    /// Whether it tries others than the most.
    tries: bool,
    phase: Phase,
    /// Walkers until it looks at the clock again.
    next_look: u64,
    /// When the phase began, and what had been walked by then.
    since: Option<(Instant, Walked)>,
    /// How long a number is kept before another is tried.
    pause: Duration,
    /// Whether the next to be tried is greater, where there is a choice.
    upwards: bool,
}

#[derive(Clone, Copy)]
enum Phase {
    Settled,
    /// What is kept is timed, to be compared.
    Timed,
    /// Another is timed.
    Tried {
        kept: usize,
        pace: f64,
    },
}

#[derive(Clone, Copy)]
struct Walked {
    walkers: u64,
    work: u64,
}

impl Walked {
    /// Work in hundreds of instructions, about.
    fn of(counts: &Counts) -> Self {
        Self {
            walkers: counts.walkers,
            work: 20 * counts.walkers + 10 * counts.contacts + 4 * counts.steps + counts.crossings,
        }
    }
}

/// Threads that walk, at most: more than there are walkers for, and each takes memory from the start.
const MOST_THREADS: usize = 1024;

/// How long a number of threads is timed, unless it is hopeless.
const TRIAL: Duration = Duration::from_millis(4);

/// How long at least.
const SHORT_TRIAL: Duration = Duration::from_millis(1);

/// What is tried is given up where its pace is less than this share of the usual one.
const HOPELESS: f64 = 0.75;

/// Walkers that it is timed by at least.
const WALKERS: u64 = 64;

/// The shortest and the longest time between trials: short while they find something better.
const PAUSES: [Duration; 2] = [Duration::from_millis(32), Duration::from_secs(2)];

/// Walkers from one look at the clock to the next: it takes a tenth of the time of a short walk.
const LOOK: u64 = 16;

/// How much faster another number must be to be kept.
const GAIN: f64 = 1.05;

impl Sharing {
    /// Always among this many threads.
    pub(super) fn always(threads: usize) -> Self {
        Self {
            tries: false,
            ..Self::new(threads, threads)
        }
    }

    /// Among this many threads at most, on a machine of so many cores.
    pub(super) fn new(most: usize, cores: usize) -> Self {
        let most = most.clamp(1, MOST_THREADS);
        Self {
            threads: most.min(cores).max(1),
            most,
            tries: most > 1,
            phase: Phase::Settled,
            next_look: 0,
            since: None,
            pause: PAUSES[0],
            upwards: false,
        }
    }

    /// Threads to walk on now.
    pub(super) fn threads(&self) -> usize {
        self.threads
    }

    /// The most that there may be.
    pub(super) fn most(&self) -> usize {
        self.most
    }

    /// Tells what has been walked.
    pub(super) fn walked(&mut self, counts: &Counts) {
        if self.tries && counts.walkers >= self.next_look {
            self.next_look = counts.walkers + LOOK;
            self.at(Instant::now(), Walked::of(counts));
        }
    }

    fn at(&mut self, now: Instant, walked: Walked) {
        let (began, before) = *self.since.get_or_insert((now, walked));
        let time = now.duration_since(began);
        let pace = || (walked.work - before.work) as f64 / time.as_secs_f64();
        let is_enough = |least| time >= least && walked.walkers - before.walkers >= WALKERS;
        let is_over = match self.phase {
            Phase::Settled => time >= self.pause,
            Phase::Timed => is_enough(TRIAL),
            Phase::Tried { pace: usual, .. } => {
                is_enough(TRIAL) || is_enough(SHORT_TRIAL) && pace() < HOPELESS * usual
            }
        };
        if is_over {
            self.since = Some((now, walked));
            self.pass(pace());
        }
    }

    /// On to the next phase, after one at this pace.
    fn pass(&mut self, pace: f64) {
        self.phase = match self.phase {
            Phase::Settled => Phase::Timed,
            Phase::Timed => {
                let kept = self.threads;
                self.threads = self.rival();
                Phase::Tried { kept, pace }
            }
            Phase::Tried { pace: usual, .. } if pace > GAIN * usual => {
                self.pause = PAUSES[0];
                Phase::Settled
            }
            Phase::Tried { kept, .. } => {
                self.threads = kept;
                self.upwards = !self.upwards;
                self.pause = (2 * self.pause).min(PAUSES[1]);
                Phase::Settled
            }
        };
    }

    /// Twice or half as many.
    fn rival(&self) -> usize {
        match self.threads {
            1 => 2,
            all if all == self.most => all / 2,
            some if self.upwards => (2 * some).min(self.most),
            some => some / 2,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers of threads in use over some seconds, when so many walk at such a pace.
    fn used(mut sharing: Sharing, pace: impl Fn(usize, f64) -> f64) -> Vec<usize> {
        const TICK: f64 = 1e-4;
        let (start, mut walked) = (Instant::now(), [0.0; 2]);
        let tick = |tick: u32| {
            let time = f64::from(tick) * TICK;
            walked[0] += 1e3 * TICK * 60.0;
            walked[1] += pace(sharing.threads(), time) * TICK * 1e6;
            let [walkers, work] = walked.map(|w| w as u64);
            if sharing.tries {
                let now = start + Duration::from_secs_f64(time);
                sharing.at(now, Walked { walkers, work });
            }
            sharing.threads()
        };
        (0..60_000).map(tick).collect()
    }

    fn share_of(used: &[usize], threads: usize) -> f64 {
        used.iter().filter(|t| **t == threads).count() as f64 / used.len() as f64
    }

    #[test]
    fn the_fastest_number_is_found_and_kept() {
        let speeds = |fastest: usize| {
            move |threads: usize, _| 1.0 / (1.0 + (threads as f64 / fastest as f64).log2().abs())
        };
        for (most, fastest) in [
            (2, 1),
            (2, 2),
            (3, 3),
            (8, 1),
            (8, 2),
            (8, 4),
            (8, 8),
            (64, 4),
            (64, 16),
        ] {
            let used = used(Sharing::new(most, 8), speeds(fastest));
            assert_eq!(used[0], most.min(8), "all cores at first");
            assert!(used.iter().all(|&t| (1..=most).contains(&t)));
            let share = share_of(&used[10_000..], fastest);
            assert!(share > 0.95, "{fastest} of {most}: {share}");
        }
    }

    #[test]
    fn what_is_hopeless_is_not_tried_for_long() {
        let tried = |pace: f64| {
            let used = used(Sharing::new(2, 2), |threads, _| [pace, 1.0][threads - 1]);
            let alone = used.chunk_by(|a, b| a == b).filter(|row| row[0] == 1);
            alone.map(<[usize]>::len).max()
        };
        // In ticks; walkers for a trial take ten.
        assert!((10..15).contains(&tried(0.6).expect("a trial")));
        assert!((40..45).contains(&tried(0.9).expect("a trial")));
    }

    #[test]
    fn a_machine_that_others_keep_busy_for_a_while_is_shared_anew() {
        let busy = |t: usize, time: f64| match (t, (1.0..2.0).contains(&time)) {
            (2, false) => 1.5,
            (2, true) => 0.7,
            _ => 1.0,
        };
        let used = used(Sharing::new(2, 2), busy);
        assert!(share_of(&used[..10_000], 2) > 0.8);
        assert!(share_of(&used[15_000..20_000], 1) > 0.8);
        assert!(share_of(&used[40_000..], 2) > 0.95);
    }

    #[test]
    fn all_are_kept_where_that_is_asked_for() {
        let used = used(Sharing::always(8), |t, _| 1.0 / t as f64);
        assert_eq!(share_of(&used, 8), 1.0);
    }

    #[test]
    fn no_number_is_too_large() {
        assert_eq!(Sharing::always(usize::MAX).threads(), MOST_THREADS);
        let some = Sharing::new(usize::MAX, 2);
        assert_eq!((some.threads(), some.most()), (2, MOST_THREADS));
    }

    #[test]
    fn one_is_one() {
        let used = used(Sharing::new(1, 2), |_, _| 1.0);
        assert_eq!(share_of(&used, 1), 1.0);
    }
}
