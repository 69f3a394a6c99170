//! Walkers in order of their numbers, on any number of threads (DESIGN section 5).
//!
//! A walker's way depends on the lichen as it is when all walkers before it have come to their end.
//! To use several threads, a batch of walkers walks at the same time against the lichen as it is
//! when the batch begins, and each leaves a [`Track`] of what it asked. They are then taken in
//! order. A walker that would still get the same answers has walked as it should; one that would
//! not walks again. So the result is that of one walker after the other, bit for bit, whatever the
//! threads and the length of the batch.

use std::sync::Mutex;
use std::time::Instant;

use rayon::prelude::*;

use super::launcher::Launcher;
use super::walker::{Asked, Fate, Track, Walk};
use super::{Counts, GrowthModel, Halt, Parallel, Parameters, Stickiness, Surroundings};
use crate::cluster::{Cluster, Element, ElementIndex, SparseIndex};
use crate::substrate::Substrate;
use crate::walk::Connectivity;

/// Diffusion-limited aggregation with curvature-based sticking.
pub struct WalkerModel<'a, I: ElementIndex = SparseIndex> {
    substrate: &'a Substrate,
    parameters: Parameters,
    law: Stickiness,
    index: I,
    launcher: Launcher,
    counts: Counts,
    batch: Batch<I>,
    threads: usize,
    /// One a thread.
    scratch: Vec<Mutex<Connectivity>>,
    parallel: Parallel,
}

/// Walkers that walked at the same time.
struct Batch<I: ElementIndex> {
    flights: Vec<Flight<I>>,
    /// How many of the flights are this batch's.
    flown: usize,
    /// How many of those have been taken.
    taken: usize,
    /// What there was when they walked.
    elements: usize,
    launcher: u64,
}

/// A walk that has been walked but not been taken.
struct Flight<I: ElementIndex> {
    track: Track<I>,
    fate: Fate,
}

impl<I: ElementIndex> Default for Batch<I> {
    fn default() -> Self {
        Self {
            flights: Vec::new(),
            flown: 0,
            taken: 0,
            elements: 0,
            launcher: 0,
        }
    }
}

type Cancelled<'b> = &'b (dyn Fn() -> bool + Sync);

impl<'a, I: ElementIndex> WalkerModel<'a, I> {
    /// A model of its own index, for a cluster that is still empty, on one thread.
    pub fn new(substrate: &'a Substrate, parameters: Parameters) -> Self {
        let wide = (parameters.gain != 0.0).then_some(parameters.curvature_radius);
        Self {
            law: Stickiness::new(&parameters),
            index: I::new(parameters.radius, wide, substrate.bounds()),
            launcher: Launcher::default(),
            counts: Counts::default(),
            batch: Batch::default(),
            threads: 1,
            scratch: vec![Mutex::default()],
            parallel: Parallel::default(),
            substrate,
            parameters,
        }
    }

    /// The same on several threads of the present rayon pool.
    #[must_use]
    pub fn on_threads(mut self, threads: usize) -> Self {
        self.threads = threads.max(1);
        self.scratch.resize_with(self.threads, Mutex::default);
        self
    }

    /// How the work was shared.
    pub fn parallel(&self) -> &Parallel {
        &self.parallel
    }

    /// Walkers that walk at the same time: enough to share among the threads, but so few beside the
    /// lichen's tips that they seldom come in each other's way.
    fn batch_length(&self, elements: usize) -> usize {
        match self.threads {
            1 => 1,
            threads => (elements.isqrt() / 8).clamp(1, WALKERS_PER_THREAD * threads),
        }
    }

    /// Sends the next batch on its way.
    fn fly(&mut self, cluster: &Cluster, cancelled: Cancelled<'_>) {
        let length = self.batch_length(cluster.len());
        let mut batch = std::mem::take(&mut self.batch);
        if batch.flights.len() < length {
            batch.flights.resize_with(length, Flight::default);
        }
        (batch.flown, batch.taken) = (length, 0);
        (batch.elements, batch.launcher) = (cluster.len(), self.launcher.version);
        let first = self.counts.walkers;
        let flights = &mut batch.flights[..length];
        if length == 1 {
            self.walk(&mut flights[0], first, cluster, cancelled);
        } else {
            let started = Instant::now();
            flights
                .par_iter_mut()
                .enumerate()
                .with_max_len(1)
                .for_each(|(i, flight)| self.walk(flight, first + i as u64, cluster, cancelled));
            self.parallel.seconds += started.elapsed().as_secs_f64();
            self.parallel.walks += length as u64;
        }
        self.batch = batch;
    }

    /// Walks one walker against the lichen as it is.
    fn walk(
        &self,
        flight: &mut Flight<I>,
        number: u64,
        cluster: &Cluster,
        cancelled: Cancelled<'_>,
    ) {
        let thread = rayon::current_thread_index().unwrap_or(0) % self.threads;
        let mut scratch = match self.scratch[thread].lock() {
            Ok(scratch) => scratch,
            // Scratch is good in any state.
            Err(poisoned) => poisoned.into_inner(),
        };
        let mut walk = Walk {
            around: Surroundings {
                substrate: self.substrate,
                parameters: &self.parameters,
                cluster,
                index: &self.index,
            },
            law: &self.law,
            launcher: &self.launcher,
            scratch: &mut scratch,
            track: &mut flight.track,
            others_walk: self.threads > 1,
            cancelled,
            cramped: 0,
        };
        flight.fate = walk.run(number);
    }

    /// Whether a walker would walk the same way now.
    fn still_holds(&self, flight: &Flight<I>, cluster: &Cluster) -> bool {
        let births = &cluster.elements()[self.batch.elements..];
        if births.is_empty() {
            return true;
        }
        let undisturbed = |asked: &Asked| {
            let limit = asked.radius * asked.radius;
            let inside = |e: &&Element| e.position.distance_squared(asked.centre) < limit;
            births.iter().filter(inside).count() <= asked.spare
        };
        self.launcher.version == self.batch.launcher
            && flight.track.asked.iter().all(undisturbed)
            && self.index.holds(&flight.track.notes)
    }

    /// The next walker's fate, with everything that it found out and took taken in.
    fn take(&mut self, cluster: &Cluster, cancelled: Cancelled<'_>) -> Fate {
        if self.batch.taken == self.batch.flown {
            self.fly(cluster, cancelled);
        }
        let mut flight = std::mem::take(&mut self.batch.flights[self.batch.taken]);
        if !self.still_holds(&flight, cluster) {
            self.parallel.conflicts += 1;
            self.walk(&mut flight, self.counts.walkers, cluster, cancelled);
        }
        let fate = flight.fate;
        if !matches!(fate, Fate::Halted(_)) {
            self.index.adopt(&mut flight.track.notes);
            self.counts.add(&flight.track.counts);
        }
        self.batch.flights[self.batch.taken] = flight;
        self.batch.taken += 1;
        fate
    }
}

/// Walkers that a thread takes on in a batch, on average.
const WALKERS_PER_THREAD: usize = 4;

impl<I: ElementIndex> Default for Flight<I> {
    fn default() -> Self {
        Self {
            track: Track::default(),
            fate: Fate::Lost,
        }
    }
}

impl<I: ElementIndex> GrowthModel for WalkerModel<'_, I> {
    fn born(&mut self, cluster: &Cluster) {
        if let Some(last) = cluster.elements().last() {
            self.index.insert(last.position);
            self.launcher
                .update(self.substrate, &self.parameters, cluster);
        }
    }

    fn next(&mut self, cluster: &Cluster, cancelled: Cancelled<'_>) -> Result<Element, Halt> {
        loop {
            match self.take(cluster, cancelled) {
                Fate::Joined(element) => return Ok(element),
                Fate::Halted(halt) => return Err(halt),
                Fate::Lost if cancelled() => return Err(Halt::Cancelled),
                Fate::Lost => {}
            }
        }
    }

    fn counts(&self) -> &Counts {
        &self.counts
    }

    fn resume(&mut self, counts: Counts) {
        self.counts = counts;
    }
}
