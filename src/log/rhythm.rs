//! When a log that grows is flushed to the disk.

use std::time::{Duration, Instant};

use super::block::LARGEST_BLOCK;

/// The longest time between flushes, where they are quick.
const EVERY: Duration = Duration::from_secs(2);

/// A run of this many times that age waits no longer for its next flush.
const YOUTH: u32 = 4;

/// Time between flushes, in times of what the last one took.
const PATIENCE: u32 = 100;

/// A flush that took longer than this puts the next one off by no more than one of this time does, two minutes,
/// unless those before it took long too: a disk may stall once, and what grows meanwhile would be at risk for an hour.
const STALL: Duration = Duration::from_millis(1200);

/// Flushes that are looked back at.
const RECENT: usize = 3;

/// Bytes that wait for a slow disk at most.
const MOST_WAITING: usize = 1 << 27;

/// Says when to flush, by what waits and what the last flush took. It is told the time, and never asks.
#[derive(Debug)]
pub(super) struct Rhythm {
    opened: Instant,
    flushed: Instant,
    /// What the last flushes took, the latest first; 0 where there were none.
    costs: [Duration; RECENT],
}

/// What is not durable yet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Waiting {
    pub(super) elements: u64,
    /// Of whole blocks.
    pub(super) bytes: usize,
}

impl Rhythm {
    /// Of a log that was opened between these moments, as durably as it will be flushed.
    pub(super) fn new(started: Instant, opened: Instant) -> Self {
        Self {
            opened,
            flushed: opened,
            costs: [opened - started, Duration::ZERO, Duration::ZERO],
        }
    }

    /// What a flush is taken to cost.
    fn cost(&self) -> Duration {
        let least = self.costs.iter().min().copied().unwrap_or_default();
        self.costs[0].min(STALL.max(least))
    }

    /// Whether to flush now: enough time has passed or enough waits, and it costs little beside that time.
    pub(super) fn is_due(&self, now: Instant, waiting: Waiting) -> bool {
        let since = now - self.flushed;
        let old = since >= EVERY.min((now - self.opened) / YOUTH);
        let many = waiting.elements >= LARGEST_BLOCK as u64;
        let worth = since >= PATIENCE * self.cost() || waiting.bytes >= MOST_WAITING;
        (old || many) && worth
    }

    /// Told of a flush between these moments.
    pub(super) fn flushed(&mut self, started: Instant, ended: Instant) {
        self.flushed = ended;
        self.costs.rotate_right(1);
        self.costs[0] = ended - started;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ELEMENT: usize = 60;

    /// A log under a clock that goes by births and flushes alone.
    struct Simulated {
        now: Instant,
        rhythm: Rhythm,
        waiting: u64,
        flushes: Vec<Flush>,
    }

    /// All in seconds of the run.
    struct Flush {
        at: f64,
        took: f64,
        elements: u64,
    }

    /// Seconds that a run takes to be born and to flush this many bytes.
    struct Pace<'a> {
        birth: f64,
        flush: &'a dyn Fn(u64) -> f64,
    }

    impl Simulated {
        fn run(elements: u64, pace: &Pace) -> Self {
            let started = Instant::now();
            let now = started + Duration::from_secs_f64((pace.flush)(0));
            let mut run = Self {
                now,
                rhythm: Rhythm::new(started, now),
                waiting: 0,
                flushes: Vec::new(),
            };
            (0..elements).for_each(|_| run.birth(pace));
            run
        }

        fn birth(&mut self, pace: &Pace) {
            self.now += Duration::from_secs_f64(pace.birth);
            self.waiting += 1;
            let waiting = Waiting {
                elements: self.waiting,
                bytes: self.waiting as usize / LARGEST_BLOCK * LARGEST_BLOCK * ELEMENT,
            };
            if self.rhythm.is_due(self.now, waiting) {
                self.flush(pace);
            }
        }

        fn flush(&mut self, pace: &Pace) {
            let (at, took) = (self.now, (pace.flush)(ELEMENT as u64 * self.waiting));
            self.now += Duration::from_secs_f64(took);
            self.rhythm.flushed(at, self.now);
            self.flushes.push(Flush {
                at: (at - self.rhythm.opened).as_secs_f64(),
                took,
                elements: self.waiting,
            });
            self.waiting = 0;
        }

        fn age(&self) -> f64 {
            (self.now - self.rhythm.opened).as_secs_f64()
        }

        /// Share of the run that went into flushing; the last flush has not been paid back yet.
        fn share(&self) -> f64 {
            let before = self.flushes.split_last().map_or(&[][..], |(_, all)| all);
            before.iter().map(|flush| flush.took).sum::<f64>() / self.age()
        }

        /// Between flushes, from the end of one to the beginning of the next.
        fn gaps(&self) -> impl Iterator<Item = (f64, f64)> {
            let pairs = self.flushes.windows(2);
            pairs.map(|pair| (pair[0].at, pair[1].at - pair[0].at - pair[0].took))
        }
    }

    fn quick(_: u64) -> f64 {
        1e-4
    }

    #[test]
    fn slow_births_are_flushed_every_two_seconds() {
        let birth = 1e-3;
        let run = Simulated::run(
            200_000,
            &Pace {
                birth,
                flush: &quick,
            },
        );
        for (at, gap) in run.gaps() {
            assert!(gap <= 2.0 + 2.0 * birth, "{gap} s after {at} s");
            assert!(gap > 2.0 - 1e-6 || at < 8.0, "{gap} s after {at} s");
        }
        let last = run.flushes.last().unwrap().at;
        assert!(run.age() - last <= 2.1, "{last} of {}", run.age());
        assert!(run.flushes[0].at < 0.1, "the first: {}", run.flushes[0].at);
        assert!(run.flushes.len() < 130, "{}", run.flushes.len());
    }

    #[test]
    fn quick_births_are_flushed_by_their_number() {
        let pace = Pace {
            birth: 1e-6,
            flush: &quick,
        };
        let run = Simulated::run(10_000_000, &pace);
        let block = LARGEST_BLOCK as u64;
        let (young, grown): (Vec<_>, Vec<_>) = run.flushes.iter().partition(|f| f.at < 0.3);
        assert!(grown.len() as u64 >= 9_600_000 / block, "{}", grown.len());
        assert!(grown.iter().all(|flush| flush.elements == block));
        assert!(young.iter().all(|flush| flush.elements <= block));
        assert!(young.len() < 20, "{}", young.len());
    }

    /// Disks from the quickest to ones that take seconds, some of them now and then only.
    #[test]
    fn flushing_takes_a_hundredth_of_the_time_on_any_disk() {
        let disks: [&dyn Fn(u64) -> f64; 5] = [
            &|_| 1e-6,
            &|_| 0.03,
            &|_| 1.0,
            &|bytes| 0.01 + bytes as f64 / 2e9,
            &|bytes| if bytes % 7 == 0 { 0.5 } else { 1e-4 },
        ];
        for (i, flush) in disks.into_iter().enumerate() {
            for birth in [1e-4, 1e-3] {
                let run = Simulated::run(3_000_000, &Pace { birth, flush });
                let share = run.share();
                assert!(share <= 0.0101, "disk {i}, births of {birth} s: {share}");
                assert!(run.flushes.len() > 1, "disk {i}, births of {birth} s");
            }
        }
    }

    /// One stall of half a minute, a hundred seconds into the run.
    #[test]
    fn a_disk_that_stalls_once_is_trusted_again() {
        let calls = std::cell::Cell::new(0);
        let flush = |_: u64| {
            calls.set(calls.get() + 1);
            if calls.get() == 70 { 30.0 } else { 1e-4 }
        };
        let pace = Pace {
            birth: 1e-2,
            flush: &flush,
        };
        let run = Simulated::run(60_000, &pace);
        let longest = run.gaps().map(|(_, gap)| gap).fold(0.0, f64::max);
        assert!((119.0..121.0).contains(&longest), "{longest}");
        assert!(run.flushes.len() > 240, "{}", run.flushes.len());
    }

    /// One that always takes that long is not asked more often than it can.
    #[test]
    fn a_disk_that_is_always_slow_is_waited_for() {
        let pace = Pace {
            birth: 0.1,
            flush: &|_| 30.0,
        };
        let run = Simulated::run(300_000, &pace);
        assert!(run.share() <= 0.0125, "{}", run.share());
    }

    /// Elements that wait take memory: a disk that cannot keep up is waited for.
    #[test]
    fn what_waits_is_bounded_on_a_slow_disk() {
        let pace = Pace {
            birth: 1e-6,
            flush: &|bytes| bytes as f64 / 50e6,
        };
        let run = Simulated::run(20_000_000, &pace);
        let most = run.flushes.iter().map(|flush| flush.elements).max();
        let bytes = most.unwrap() as usize * ELEMENT;
        let block = LARGEST_BLOCK * ELEMENT;
        assert!((MOST_WAITING..MOST_WAITING + block).contains(&bytes));
    }
}
