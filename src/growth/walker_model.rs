//! Walkers in order of their numbers, on any number of threads (`docs/architecture.md`).
//!
//! A walker's way depends on the lichen as it is when all walkers before it have come to their end.
//! To use several threads, a fleet of walkers walks at the same time against the lichen as it is
//! just now, and each leaves a [`Track`](super::flight::Track) of what it asked. They land in order.
//! A walker that would have seen something else, had it waited, is first taken back to before that
//! and walks on from there. So the result is that of one walker after the other, bit for bit,
//! whatever the threads and the size of the fleet.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use rayon::prelude::*;

use super::barren;
use super::far::Far;
use super::flight::{Flight, Stage};
use super::launcher::Launcher;
use super::sharing::Sharing;
use super::stick::{Crowd, widest_count};
use super::walker::{Fate, Interrupts, Walk};
use super::{
    Counts, GrowthModel, Habitat, Halt, Law, Parallel, Parameters, Steps, Stickiness, Surroundings,
};
use crate::cluster::{Cluster, Element, ElementIndex, SparseIndex};
use crate::substrate::Substrate;
use crate::walk::Connectivity;

/// Edges that walkers cross, a triangle, before the coarser copies of the mesh are made. Making them takes as long as some
/// 15 crossings a triangle, but a run that has come so far mostly goes on for much longer.
pub const CROSSINGS_PER_TRIANGLE: u64 = 4;

/// The same where one that hardly strays seems to be worth having: that saves nearly all crossings. If it is not
/// after all, the others are made then.
const CROSSINGS_WHERE_SMOOTH: u64 = 1;

/// Walkers on their way for each thread, at most, while few are lost.
const FLEET_PER_THREAD: usize = 3;

/// Walkers on their way, at most, where most are lost: these come in nobody's way.
const MOST_TOGETHER: usize = 384;

/// Walkers that open edges take in a row before growth ends: some seconds at least. A lichen that grows slowly
/// because they take most loses some thousands for each element.
const MOST_ABSORBED: u64 = 10_000_000;

/// Looks at what a thread waits for before it may sleep: some hundred microseconds.
const MOST_WAITS: u32 = 10_000;

/// Diffusion-limited aggregation with curvature-based sticking.
pub struct WalkerModel<'a, I: ElementIndex = SparseIndex> {
    substrate: &'a Substrate,
    habitat: Habitat<'a>,
    parameters: Parameters,
    law: Stickiness,
    index: I,
    launcher: Launcher,
    /// None also where it is not worth having.
    far: Option<Far>,
    copies: MadeCopies,
    counts: Counts,
    /// What they were at the last birth.
    counts_at_birth: Counts,
    /// Walkers on their way, in order of their numbers.
    fleet: VecDeque<Box<Flight<I>>>,
    /// Flights that have landed, for what they hold in memory.
    landed: Vec<Box<Flight<I>>>,
    sharing: Sharing,
    /// For each that walk at the same time, on the surface and on a copy.
    scratch: Vec<Mutex<[Connectivity; 2]>>,
    parallel: Parallel,
    /// Flights of the fleet so far.
    flown: Arc<AtomicU64>,
    /// Elements that it was told of.
    told: usize,
}

impl<I: ElementIndex> std::fmt::Debug for WalkerModel<'_, I> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("WalkerModel").finish_non_exhaustive()
    }
}

/// Whether the coarser copies have been made.
#[derive(Clone, Copy, PartialEq)]
enum MadeCopies {
    NotYet,
    /// None that hardly strays is worth having; others may be.
    NotYetAsRough,
    AllThereWillBe,
}

type Cancelled<'b> = &'b (dyn Fn() -> bool + Sync);

impl<'a> WalkerModel<'a> {
    /// A model for a cluster that is still empty, on one thread.
    ///
    /// # Panics
    /// When the parameters are not [sound](Parameters::are_sound), or the radius is below
    /// [`LEAST_RADIUS`](crate::cluster::LEAST_RADIUS) of the diagonal of the substrate's bounding box.
    pub fn new(substrate: &'a Substrate, parameters: Parameters) -> Self {
        Self::with_index(substrate, parameters)
    }
}

impl<'a, I: ElementIndex> WalkerModel<'a, I> {
    /// As [`new`](WalkerModel::new), with an index of one's own.
    ///
    /// # Panics
    /// As [`new`](WalkerModel::new).
    pub fn with_index(substrate: &'a Substrate, parameters: Parameters) -> Self {
        assert!(parameters.are_sound(), "unsound parameters: {parameters:?}");
        let law = Stickiness::new(&parameters);
        let wide = law.counts().then(|| widest_count(&parameters));
        let walks_on_copies = parameters.steps == Steps::Large && substrate.is_fine();
        Self {
            habitat: Habitat::new(substrate, parameters.slope, parameters.radius),
            law,
            index: I::new(parameters.radius, wide, substrate.bounds()),
            launcher: Launcher::default(),
            far: None,
            copies: match walks_on_copies {
                true => MadeCopies::NotYet,
                false => MadeCopies::AllThereWillBe,
            },
            counts: Counts::default(),
            counts_at_birth: Counts::default(),
            fleet: VecDeque::new(),
            landed: Vec::new(),
            sharing: Sharing::always(1),
            scratch: vec![Mutex::default()],
            parallel: Parallel::default(),
            flown: Arc::default(),
            told: 0,
            substrate,
            parameters,
        }
    }

    /// The same on several threads of the present rayon pool, always; 1024 of them at most.
    #[must_use]
    pub fn on_threads(self, threads: usize) -> Self {
        self.sharing(Sharing::always(threads))
    }

    /// The same on as many threads of the present rayon pool as pay, but no more than these, nor than 1024.
    #[must_use]
    pub fn on_threads_that_pay(self, most: usize) -> Self {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        self.sharing(Sharing::new(most, cores))
    }

    fn sharing(mut self, sharing: Sharing) -> Self {
        self.scratch.resize_with(sharing.most(), Mutex::default);
        self.sharing = sharing;
        self
    }

    /// How the work was shared.
    pub fn parallel(&self) -> Parallel {
        Parallel {
            threads: self.sharing.threads(),
            ..self.parallel
        }
    }

    /// What it took up to the last birth.
    pub fn counts_at_birth(&self) -> &Counts {
        &self.counts_at_birth
    }

    /// Walkers that walk at the same time: enough to share among the threads, but so few beside the
    /// lichen's tips that they seldom come in each other's way.
    fn fleet_size(&self, elements: usize) -> usize {
        match self.sharing.threads() {
            1 => 1,
            threads => {
                let born = (elements.isqrt() / 8).clamp(1, FLEET_PER_THREAD * threads);
                let lost = (self.counts.walkers - self.counts_at_birth.walkers) as usize;
                (born * lost.max(1)).min(born.max(MOST_TOGETHER))
            }
        }
    }

    /// Sends new walkers on their way until the fleet is complete.
    fn complete_fleet(&mut self, elements: usize) {
        for _ in self.fleet.len()..self.fleet_size(elements) {
            let mut flight = self.landed.pop().unwrap_or_default();
            flight.begin(self.counts.walkers + self.fleet.len() as u64);
            self.fleet.push_back(flight);
        }
    }

    /// Lets the fleet walk, at least until its first walker has come to its end.
    fn fly(&mut self, cluster: &Cluster, cancelled: Cancelled<'_>) {
        self.sharing.walked(&self.counts);
        self.complete_fleet(cluster.len());
        let mut fleet = std::mem::take(&mut self.fleet);
        match self.sharing.threads().min(fleet.len()) {
            1 => {
                let interrupts = Interrupts {
                    cancelled,
                    paused: &|| false,
                };
                self.advance(&mut fleet[0], cluster, (0, false), interrupts);
            }
            threads => self.fly_together(&mut fleet, threads, cluster, cancelled),
        }
        self.fleet = fleet;
    }

    fn fly_together(
        &mut self,
        fleet: &mut VecDeque<Box<Flight<I>>>,
        threads: usize,
        cluster: &Cluster,
        cancelled: Cancelled<'_>,
    ) {
        let started = Instant::now();
        let (stopped, first_ended) = (AtomicUsize::new(0), AtomicBool::new(false));
        let conflicts = AtomicU64::new(0);
        // When a thread has nothing left to do, the others pause, but the first goes on to its end:
        // without it none can land.
        let enough = (fleet.len() + 1).saturating_sub(threads);
        let paused =
            || stopped.load(Ordering::Relaxed) >= enough && first_ended.load(Ordering::Relaxed);
        let interrupts = Interrupts {
            cancelled,
            paused: &paused,
        };
        let this = &*self;
        self.flown.fetch_add(1, Ordering::Relaxed);
        let all = fleet.len();
        fleet.iter_mut().for_each(|f| f.track.share_room(all));
        let waiting = Mutex::new(fleet.iter_mut().enumerate());
        (0..threads)
            .into_par_iter()
            .with_max_len(1)
            .for_each(|job| {
                while let Some((i, flight)) = next_of(&waiting) {
                    let again = this.advance(flight, cluster, (job, i > 0), interrupts);
                    conflicts.fetch_add(again.into(), Ordering::Relaxed);
                    stopped.fetch_add(1, Ordering::Relaxed);
                    first_ended.fetch_or(i == 0, Ordering::Relaxed);
                }
                wait_while(|| stopped.load(Ordering::Relaxed) < all);
            });
        self.parallel.seconds += started.elapsed().as_secs_f64();
        self.parallel.conflicts += conflicts.into_inner();
        self.keep_awake(threads);
    }

    /// Keeps the other threads from falling asleep until the fleet flies again: that takes less time
    /// than to wake them.
    fn keep_awake(&self, threads: usize) {
        let flown = self.flown.load(Ordering::Relaxed);
        for _ in 1..threads {
            let latest = Arc::clone(&self.flown);
            rayon::spawn(move || wait_while(|| latest.load(Ordering::Relaxed) == flown));
        }
    }

    /// Takes a walker back to where it was disturbed, and lets it walk on. Whether it was taken
    /// back. `others_walk` says whether others may land before it, and the number which of those who
    /// walk now this is.
    fn advance(
        &self,
        flight: &mut Flight<I>,
        cluster: &Cluster,
        (job, others_walk): (usize, bool),
        interrupts: Interrupts<'_>,
    ) -> bool {
        let again = self.catch_up(flight, cluster);
        if !others_walk {
            flight.track.forget(&self.index);
        }
        let mut scratch = match self.scratch[job].lock() {
            Ok(scratch) => scratch,
            // Scratch is good in any state.
            Err(poisoned) => poisoned.into_inner(),
        };
        let [scratch, on_copy] = &mut *scratch;
        let mut walk = Walk {
            around: Surroundings {
                substrate: self.substrate,
                parameters: &self.parameters,
                cluster,
                index: &self.index,
            },
            law: &self.law,
            launcher: &self.launcher,
            far: self.far.as_ref(),
            habitat: self.habitat,
            scratch,
            on_copy,
            crowd: Crowd::default(),
            track: &mut flight.track,
            others_walk,
            interrupts,
        };
        if let Stage::Ready = flight.stage {
            flight.launcher = self.launcher.version;
            flight.stage = match walk.set_out(flight.number) {
                Ok(way) => Stage::UnderWay(way),
                Err(fate) => Stage::Ended(fate),
            };
        }
        if let Stage::UnderWay(way) = &mut flight.stage
            && let Some(fate) = walk.go_on(way)
        {
            flight.stage = Stage::Ended(fate);
        }
        again
    }

    /// Makes the coarser copies of the surface when enough edges have been crossed. That depends on the
    /// counts at the last birth alone: so a run that goes on after an interruption has them from the same
    /// walker on.
    fn weigh_far(&mut self) {
        if self.copies == MadeCopies::NotYet && self.has_crossed(CROSSINGS_WHERE_SMOOTH) {
            let is_smooth = self.parameters.law == Law::Thesis
                && Far::would_hardly_stray(self.substrate, self.parameters.radius);
            match is_smooth {
                true => self.make_copies(true),
                false => self.copies = MadeCopies::NotYetAsRough,
            }
        }
        if self.copies == MadeCopies::NotYetAsRough && self.has_crossed(CROSSINGS_PER_TRIANGLE) {
            self.make_copies(false);
        }
    }

    /// Whether walkers had crossed more than so many edges a triangle at the last birth.
    fn has_crossed(&self, per_triangle: u64) -> bool {
        let crossings = self.counts_at_birth.crossings;
        crossings > per_triangle * self.substrate.triangles().len() as u64
    }

    fn make_copies(&mut self, near: bool) {
        self.copies = MadeCopies::AllThereWillBe;
        self.far = Far::new(self.substrate, self.parameters.radius, near);
        self.launcher.change();
    }

    fn catch_up(&self, flight: &mut Flight<I>, cluster: &Cluster) -> bool {
        flight.catch_up(&self.index, cluster.elements(), self.launcher.version)
    }

    /// The next walker's fate, with everything that it found out and took taken in.
    fn take(&mut self, cluster: &Cluster, cancelled: Cancelled<'_>) -> Fate {
        loop {
            if let Some(mut first) = self.fleet.pop_front() {
                let again = self.catch_up(&mut first, cluster);
                self.parallel.conflicts += u64::from(again);
                if let Some(fate) = first.fate() {
                    self.land(first, cluster);
                    return fate;
                }
                self.fleet.push_front(first);
            }
            self.fly(cluster, cancelled);
        }
    }

    fn is_starved(&self) -> bool {
        self.counts.absorbed - self.counts_at_birth.absorbed >= MOST_ABSORBED
    }

    fn is_hemmed(&self, elements: usize) -> bool {
        let counts = [&self.counts_at_birth, &self.counts];
        !self.habitat.is_everywhere() && barren::is_hemmed(&self.parameters, elements, counts)
    }

    /// Launches walkers inside the launch sphere, until the next birth, when many from outside were lost: they seem to find
    /// no way over habitat.
    fn weigh_enclosed(&mut self, elements: usize) {
        let counts = [&self.counts_at_birth, &self.counts];
        if !self.habitat.is_everywhere() && !barren::comes_in(elements, counts) {
            self.launcher.launch_inside();
        }
    }

    fn land(&mut self, mut flight: Box<Flight<I>>, cluster: &Cluster) {
        if !matches!(flight.fate(), Some(Fate::Halted(_))) {
            self.index
                .adopt(cluster.elements(), &mut flight.track.notes);
            self.counts.add(&flight.track.counts);
            self.parallel.walks += u64::from(self.sharing.threads() > 1);
        }
        self.landed.push(flight);
    }
}

/// The next one, for whichever thread asks first.
fn next_of<T>(all: &Mutex<impl Iterator<Item = T>>) -> Option<T> {
    all.lock().unwrap_or_else(PoisonError::into_inner).next()
}

/// Waits, but not for ever, without letting the thread fall asleep: to wake it takes longer than the
/// others mostly do.
fn wait_while(not_yet: impl Fn() -> bool) {
    (0..MOST_WAITS)
        .take_while(|_| not_yet())
        .for_each(|_| std::hint::spin_loop());
}

impl<I: ElementIndex> GrowthModel for WalkerModel<'_, I> {
    fn expect(&mut self, elements: usize) {
        self.index.expect(elements);
    }

    fn born(&mut self, cluster: &Cluster) {
        self.counts_at_birth.clone_from(&self.counts);
        if !cluster.is_empty() {
            self.told += 1;
            self.index.insert(cluster.elements());
            self.launcher
                .update(self.substrate, &self.parameters, cluster);
        }
    }

    fn next(&mut self, cluster: &Cluster, cancelled: Cancelled<'_>) -> Result<Element, Halt> {
        // Walkers would find nothing of it, or nothing to set out from, and go on for ever.
        let (told, born) = (self.told, cluster.len());
        assert!(
            told == born && born > 0,
            "a model told of {told} births, and a cluster of {born}: tell it of each, a seed first"
        );
        self.weigh_far();
        let halt = loop {
            self.launcher.make_ready(&self.habitat, self.far.as_ref());
            match self.take(cluster, cancelled) {
                Fate::Joined(element) => return Ok(element),
                Fate::Halted(halt) => break halt,
                Fate::Lost if cancelled() => break Halt::Cancelled,
                Fate::Lost if self.is_starved() => break Halt::Starved,
                Fate::Lost if self.is_hemmed(cluster.len()) => break Halt::Hemmed,
                Fate::Lost => self.weigh_enclosed(cluster.len()),
            }
        };
        // The others may have been told to stop too: if it goes on they begin anew, under their own numbers.
        self.landed.extend(self.fleet.drain(..));
        Err(halt)
    }

    fn counts(&self) -> &Counts {
        &self.counts
    }

    fn resume(&mut self, counts: Counts) {
        self.counts_at_birth.clone_from(&counts);
        self.counts = counts;
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::stick::tests::parameters;
    use super::*;

    /// A model that was told of these births, and the cluster of them.
    fn begun<'a>(
        substrate: &'a Substrate,
        parameters: &Parameters,
        births: &[Element],
        threads: usize,
    ) -> (WalkerModel<'a>, Cluster) {
        let mut model = WalkerModel::new(substrate, parameters.clone()).on_threads(threads);
        let mut cluster = Cluster::new(parameters.radius);
        for birth in births {
            cluster.push(*birth);
            model.born(&cluster);
        }
        (model, cluster)
    }

    fn grow(
        model: &mut WalkerModel,
        cluster: &mut Cluster,
        births: usize,
        seen: &mut dyn FnMut(&WalkerModel),
    ) {
        for _ in 0..births {
            cluster.push(model.next(cluster, &|| false).expect("a birth"));
            model.born(cluster);
            seen(model);
        }
    }

    #[test]
    fn clusters_that_it_was_not_told_of_are_refused() {
        let substrate = Substrate::load(Path::new("meshes/plane.obj")).expect("a mesh");
        let seed = Element::seed(&substrate, substrate.nearest(substrate.bounds()[0]).0);
        for births in [0, 1] {
            let births = &[seed][..births];
            let (mut model, mut cluster) = begun(&substrate, &parameters(1e-3), births, 1);
            cluster.extend(births.iter().copied());
            let next = std::panic::AssertUnwindSafe(|| model.next(&cluster, &|| true));
            assert!(std::panic::catch_unwind(next).is_err(), "{births:?}");
        }
    }

    #[test]
    fn walkers_in_small_steps_wait_where_their_tracks_are_full() {
        let substrate = Substrate::load(Path::new("meshes/plane.obj")).expect("a mesh");
        let large = parameters(
            substrate
                .units()
                .length_to_local(substrate.units().diagonal())
                / 4000.0,
        );
        let small = Parameters {
            steps: Steps::Small,
            kill: 20.0,
            ..large.clone()
        };
        let (at, _) = substrate.nearest(substrate.bounds()[0].midpoint(substrate.bounds()[1]));
        let seed = Element::seed(&substrate, at);
        let (mut model, mut cluster) = begun(&substrate, &large, &[seed], 1);
        grow(&mut model, &mut cluster, 400, &mut |_| {});

        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(2)
            .build()
            .expect("threads");
        let mut full = 0;
        let [one, two] = [1, 2].map(|threads| {
            let (mut model, mut cluster) = begun(&substrate, &small, cluster.elements(), threads);
            pool.install(|| {
                grow(&mut model, &mut cluster, 60, &mut |model| {
                    full += model
                        .fleet
                        .iter()
                        .filter(|flight| flight.track.is_full())
                        .count();
                });
            });
            cluster
        });
        assert_eq!(one.elements(), two.elements());
        assert!(full > 0, "no walk was long enough");
    }
}
