//! Walkers in order of their numbers, on any number of threads: one after the other here, on several threads
//! [together](super::together).

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Instant;

use crossbeam_utils::CachePadded;

use super::books::Books;
use super::far::Far;
use super::flight::Flight;
use super::launcher::Launcher;
use super::scene::Scene;
use super::sharing::Sharing;
use super::stick::widest_count;
use super::together::{Limits, MOST_AHEAD, Together, wait_while};
use super::walker::{Fate, Interrupts};
use super::{Counts, GrowthModel, Habitat, Halt, Law, Parallel, Parameters, Steps, Stickiness};
use crate::cluster::{Cluster, Element, ElementIndex, Population, SparseIndex};
use crate::substrate::Substrate;

/// Edges that walkers cross, a triangle, before the coarser copies of the mesh are made. Making them takes as long as
/// some 15 crossings a triangle, but a run that has come so far mostly goes on for much longer.
pub const CROSSINGS_PER_TRIANGLE: u64 = 4;

/// The same where one that hardly strays seems to be worth having: that saves nearly all crossings. If it is not
/// after all, the others are made then.
const CROSSINGS_WHERE_SMOOTH: u64 = 1;

/// Walkers on their way for each thread, at most, while few are lost.
const FLEET_PER_THREAD: usize = 3;

/// Walkers on their way, at most, where most are lost: these come in nobody's way.
const MOST_TOGETHER: usize = 384;

/// Diffusion-limited aggregation with curvature-based sticking.
pub struct WalkerModel<'a, I: ElementIndex = SparseIndex> {
    scene: Scene<'a, I>,
    copies: MadeCopies,
    books: Books,
    /// Places for elements that are born ahead of those that were asked for.
    young: Box<[OnceLock<Element>]>,
    /// Walkers on their way, in order of their numbers.
    fleet: VecDeque<Box<Flight<I>>>,
    /// Flights that have landed, for what they hold in memory.
    landed: Vec<Box<Flight<I>>>,
    sharing: Sharing,
    parallel: Parallel,
    /// How often walkers have walked together.
    flown: Arc<AtomicU64>,
    /// Elements that are to be expected in all.
    expected: usize,
    /// Elements that the index has.
    inserted: usize,
    told: Told,
}

/// What whoever asks for elements knows of.
#[derive(Default)]
struct Told {
    /// Elements that it has told of in turn.
    births: usize,
    /// What the elements took that it has asked for.
    counts: Counts,
    /// What it took up to the last birth that it told of.
    at_birth: Counts,
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
    /// A model for a cluster that is still empty, on one thread, with an index of one's own.
    ///
    /// # Panics
    /// As [`new`](WalkerModel::new).
    pub fn with_index(substrate: &'a Substrate, parameters: Parameters) -> Self {
        assert!(parameters.are_sound(), "unsound parameters: {parameters:?}");
        let law = Stickiness::new(&parameters);
        let wide = law.counts().then(|| widest_count(&parameters));
        let walks_on_copies = parameters.steps == Steps::Large && substrate.is_fine();
        Self {
            scene: Scene {
                habitat: Habitat::new(substrate, parameters.slope, parameters.radius),
                law,
                index: I::new(parameters.radius, wide, substrate.bounds()),
                launcher: Launcher::default(),
                far: None,
                scratch: vec![CachePadded::default()],
                substrate,
                parameters,
            },
            copies: match walks_on_copies {
                true => MadeCopies::NotYet,
                false => MadeCopies::AllThereWillBe,
            },
            books: Books::default(),
            young: (0..MOST_AHEAD).map(|_| OnceLock::new()).collect(),
            fleet: VecDeque::new(),
            landed: Vec::new(),
            sharing: Sharing::always(1),
            parallel: Parallel::default(),
            flown: Arc::default(),
            expected: 0,
            inserted: 0,
            told: Told::default(),
        }
    }

    /// This model on several threads of the present rayon pool, always; 1024 of them at most.
    #[must_use]
    pub fn on_threads(self, threads: usize) -> Self {
        self.sharing(Sharing::always(threads))
    }

    /// This model on as many threads of the present rayon pool as pay, but no more than these, nor than 1024.
    #[must_use]
    pub fn on_threads_that_pay(self, most: usize) -> Self {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        self.sharing(Sharing::new(most, cores))
    }

    fn sharing(mut self, sharing: Sharing) -> Self {
        self.scene
            .scratch
            .resize_with(sharing.most(), CachePadded::default);
        self.sharing = sharing;
        self
    }

    /// How the work was shared.
    pub fn parallel(&self) -> Parallel {
        Parallel {
            threads: self.sharing.threads(),
            walks: self.books.landed_together,
            ..self.parallel
        }
    }

    /// What it took up to the last birth that it was told of.
    pub fn counts_at_birth(&self) -> &Counts {
        &self.told.at_birth
    }

    /// Walkers that walk at the same time: enough to share among the threads, but so few beside the
    /// lichen's tips that they seldom come in each other's way.
    fn fleet_size(&self, elements: usize) -> usize {
        match self.sharing.threads() {
            1 => 1,
            threads => {
                let born = (elements.isqrt() / 8).clamp(1, FLEET_PER_THREAD * threads);
                let lost = self.books.lost() as usize;
                (born * lost.max(1)).min(born.max(MOST_TOGETHER))
            }
        }
    }

    /// Lets walkers walk, until one has come to its end at least.
    fn fly(
        &mut self,
        cluster: &Cluster,
        cancelled: Cancelled<'_>,
    ) -> Result<Option<Element>, Halt> {
        self.sharing.walked(&self.books.counts);
        self.scene.index.make_room();
        let walkers = self.fleet_size(cluster.len());
        match self.sharing.threads().min(walkers) {
            1 => self.fly_alone(cluster, cancelled),
            threads => {
                let limits = Limits {
                    threads,
                    walkers,
                    births: self.most_ahead(cluster.len()),
                    crossings: self.crossings_before_copies().unwrap_or(u64::MAX),
                };
                self.fly_together(cluster, limits, cancelled)
            }
        }
    }

    /// How many elements may be born before the first is asked for: no more than are still to be expected.
    fn most_ahead(&self, elements: usize) -> usize {
        match self.expected.checked_sub(elements) {
            None | Some(0) => MOST_AHEAD,
            Some(expected) => expected.min(MOST_AHEAD),
        }
    }

    /// Lets the next walker walk to its end.
    fn fly_alone(
        &mut self,
        cluster: &Cluster,
        cancelled: Cancelled<'_>,
    ) -> Result<Option<Element>, Halt> {
        let mut flight = self.fleet.pop_front().unwrap_or_else(|| {
            let mut flight = self.landed.pop().unwrap_or_default();
            flight.begin(self.books.counts.walkers);
            flight
        });
        let interrupts = Interrupts {
            cancelled,
            paused: &|| false,
        };
        let elements = Population::from(cluster);
        let again = self
            .scene
            .advance(&mut flight, elements, (0, false), interrupts);
        self.parallel.conflicts += u64::from(again);
        let fate = flight.fate();
        if let Some(Fate::Joined(_) | Fate::Lost) = fate {
            self.scene.index.adopt(&elements, &mut flight.track.notes);
            self.books.add(&flight);
            self.books.landed_together += u64::from(self.sharing.threads() > 1);
        }
        self.landed.push(flight);
        match fate {
            Some(Fate::Joined(element)) => Ok(Some(element)),
            Some(Fate::Halted(halt)) => Err(halt),
            _ => Ok(None),
        }
    }

    /// Lets walkers walk on several threads for a while.
    fn fly_together(
        &mut self,
        cluster: &Cluster,
        limits: Limits,
        cancelled: Cancelled<'_>,
    ) -> Result<Option<Element>, Halt> {
        let started = Instant::now();
        self.flown.fetch_add(1, Ordering::Relaxed);
        for place in &mut self.young {
            place.take();
        }
        let mut books = std::mem::take(&mut self.books);
        books.measure(cluster);
        let fleet = (
            std::mem::take(&mut self.fleet),
            std::mem::take(&mut self.landed),
        );
        let lichen = (&self.scene, cluster, &*self.young);
        let together = Together::new(lichen, fleet, books, limits, cancelled);
        let (fleet, books, outcome) = together.walk();
        (self.fleet, self.landed) = fleet;
        // What had them stop may hold no longer when they are to land.
        let halted = |flight: &&mut Box<Flight<I>>| matches!(flight.fate(), Some(Fate::Halted(_)));
        for flight in self.fleet.iter_mut().filter(halted) {
            flight.begin(flight.number);
        }
        self.books = books;
        self.take_in(cluster, outcome.index_is_full);
        self.parallel.seconds += started.elapsed().as_secs_f64();
        self.parallel.landing += outcome.landing;
        self.parallel.conflicts += outcome.conflicts;
        self.keep_awake(limits.threads);
        outcome.halt.map_or(Ok(None), Err)
    }

    /// Takes in the elements born ahead, as far as that was not to be done while walkers walked.
    fn take_in(&mut self, cluster: &Cluster, index_is_full: bool) {
        let Some((youngest, _)) = self.books.ahead.back() else {
            return;
        };
        let all = cluster.len() + self.books.ahead.len();
        self.inserted = all;
        let scene = &mut self.scene;
        if index_is_full {
            let elements = Population::from(cluster).with_young(&self.young, all);
            scene.index.add(&elements);
        }
        let surface = (scene.substrate, &scene.parameters);
        scene
            .launcher
            .update(surface, self.books.extent(), youngest);
    }

    /// Keeps the other threads from falling asleep until walkers walk together again: that takes less time
    /// than to wake them.
    fn keep_awake(&self, threads: usize) {
        let flown = self.flown.load(Ordering::Relaxed);
        for _ in 1..threads {
            let latest = Arc::clone(&self.flown);
            rayon::spawn(move || wait_while(|| latest.load(Ordering::Relaxed) == flown));
        }
    }

    /// Makes the coarser copies of the surface when enough edges have been crossed. That depends on the
    /// counts at the last birth alone: so a run that goes on after an interruption has them from the same
    /// walker on.
    fn weigh_far(&mut self) {
        if self.copies == MadeCopies::NotYet && self.has_crossed_enough() {
            let Scene {
                substrate,
                parameters,
                ..
            } = &self.scene;
            let is_smooth = parameters.law == Law::Thesis
                && Far::would_hardly_stray(substrate, parameters.radius);
            match is_smooth {
                true => self.make_copies(true),
                false => self.copies = MadeCopies::NotYetAsRough,
            }
        }
        if self.copies == MadeCopies::NotYetAsRough && self.has_crossed_enough() {
            self.make_copies(false);
        }
    }

    fn has_crossed_enough(&self) -> bool {
        let enough = self.crossings_before_copies();
        enough.is_some_and(|enough| self.books.at_birth.crossings > enough)
    }

    /// Edges that walkers have crossed, up to a birth, before copies are made or weighed; none where all are made.
    fn crossings_before_copies(&self) -> Option<u64> {
        let per_triangle = match self.copies {
            MadeCopies::NotYet => CROSSINGS_WHERE_SMOOTH,
            MadeCopies::NotYetAsRough => CROSSINGS_PER_TRIANGLE,
            MadeCopies::AllThereWillBe => return None,
        };
        Some(per_triangle * self.scene.substrate.triangles().len() as u64)
    }

    fn make_copies(&mut self, near: bool) {
        self.copies = MadeCopies::AllThereWillBe;
        let Scene {
            substrate,
            parameters,
            ..
        } = &self.scene;
        self.scene.far = Far::new(substrate, parameters.radius, near);
        self.scene.launcher.change();
    }

    /// Whether the next element is there already.
    pub(crate) fn knows_next(&self) -> bool {
        !self.books.ahead.is_empty()
    }

    /// The next element that was born ahead.
    fn born_ahead(&mut self) -> Option<Element> {
        let (element, counts) = self.books.ahead.pop_front()?;
        self.told.counts = counts;
        Some(element)
    }

    /// What to do about walkers that came to nothing: nothing; to launch them inside the launch sphere, until the next
    /// birth, when those from outside seem to find no way over habitat; or to stop.
    fn weigh_lost(&mut self, elements: usize, cancelled: Cancelled<'_>) -> Result<(), Halt> {
        if cancelled() {
            return Err(Halt::Cancelled);
        }
        if let Some(halt) = self.books.in_vain(&self.scene, elements) {
            return Err(halt);
        }
        if self.books.none_comes_in(&self.scene, elements) {
            self.scene.launcher.launch_inside();
        }
        Ok(())
    }

    /// The next element, or why there is none.
    fn found(&mut self, cluster: &Cluster, cancelled: Cancelled<'_>) -> Result<Element, Halt> {
        loop {
            if let Some(element) = self.born_ahead() {
                return Ok(element);
            }
            if self.books.lost() > 0 {
                self.told.counts.clone_from(&self.books.counts);
                self.weigh_lost(cluster.len(), cancelled)?;
            }
            self.weigh_far();
            let Scene {
                launcher,
                habitat,
                far,
                ..
            } = &mut self.scene;
            launcher.make_ready(habitat, far.as_ref());
            let flown = self.fly(cluster, cancelled);
            if self.books.ahead.is_empty() {
                self.told.counts.clone_from(&self.books.counts);
                if let Some(element) = flown? {
                    return Ok(element);
                }
            } else if flown.is_err() {
                // If it still holds it stops growth again, when these have been asked for.
                self.landed.extend(self.fleet.drain(..));
            }
        }
    }
}

impl<I: ElementIndex> GrowthModel for WalkerModel<'_, I> {
    fn expect(&mut self, elements: usize) {
        self.expected = elements;
        self.scene.index.expect(elements);
    }

    fn born(&mut self, cluster: &Cluster) {
        self.told.at_birth.clone_from(&self.told.counts);
        let Some(youngest) = cluster.elements().last() else {
            return;
        };
        self.told.births += 1;
        if self.told.births <= self.inserted {
            return;
        }
        self.inserted = self.told.births;
        self.books.at_birth.clone_from(&self.books.counts);
        let scene = &mut self.scene;
        scene.index.add(&cluster.into());
        let surface = (scene.substrate, &scene.parameters);
        scene.launcher.update(surface, cluster.extent(), youngest);
    }

    fn next(&mut self, cluster: &Cluster, cancelled: Cancelled<'_>) -> Result<Element, Halt> {
        // Walkers would find nothing of it, or nothing to set out from, and go on for ever.
        let (told, born) = (self.told.births, cluster.len());
        assert!(
            told == born && born > 0,
            "a model told of {told} births, and a cluster of {born}: tell it of each, a seed first"
        );
        let found = self.found(cluster, cancelled);
        if found.is_err() {
            // The others may have been told to stop too: if it goes on they begin anew, under their own numbers.
            self.landed.extend(self.fleet.drain(..));
        }
        found
    }

    fn counts(&self) -> &Counts {
        &self.told.counts
    }

    fn resume(&mut self, counts: Counts) {
        self.books.at_birth.clone_from(&counts);
        self.books.counts.clone_from(&counts);
        self.told.at_birth.clone_from(&counts);
        self.told.counts = counts;
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

    /// A deadline may have moved on by the next call.
    #[test]
    fn whoever_was_told_to_stop_may_go_on() {
        let substrate = Substrate::load(Path::new("meshes/rock.obj")).expect("a mesh");
        let parameters = parameters(substrate.units().local_diagonal() / 400.0);
        let seed = Element::seed(&substrate, substrate.nearest(substrate.bounds()[0]).0);
        let (mut model, mut undisturbed) = begun(&substrate, &parameters, &[seed], 1);
        grow(&mut model, &mut undisturbed, 1600, &mut |_| {});
        let (mut model, mut cluster) = begun(&substrate, &parameters, &[seed], 3);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build();
        let mut stops = 0;
        pool.expect("threads").install(|| {
            // So many that several walk.
            grow(&mut model, &mut cluster, 700, &mut |_| {});
            while cluster.len() < undisturbed.len() {
                // Few are born ahead, so that it often comes to walking.
                model.expect(cluster.len() + 8);
                let next = model.next(&cluster, &|| true);
                stops += usize::from(next.is_err());
                let next = next.or_else(|_| model.next(&cluster, &|| false));
                cluster.push(next.expect("nothing to stop it"));
                model.born(&cluster);
            }
        });
        assert!(stops > 50, "{stops}");
        assert!(cluster.elements() == undisturbed.elements());
    }

    /// The others would wait for the walker of a thread that is gone, and for ever.
    #[test]
    fn a_panic_of_one_thread_is_one_of_all() {
        let substrate = Substrate::load(Path::new("meshes/rock.obj")).expect("a mesh");
        let parameters = parameters(substrate.units().local_diagonal() / 400.0);
        let seed = Element::seed(&substrate, substrate.nearest(substrate.bounds()[0]).0);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build();
        let pool = pool.expect("threads");
        let (mut model, mut cluster) = begun(&substrate, &parameters, &[seed], 1);
        grow(&mut model, &mut cluster, 700, &mut |_| {});
        let (mut model, mut cluster) = begun(&substrate, &parameters, cluster.elements(), 3);
        pool.install(|| grow(&mut model, &mut cluster, 300, &mut |_| {}));
        let asked = AtomicU64::new(0);
        let fails = || {
            assert!(
                asked.fetch_add(1, Ordering::Relaxed) != 9000,
                "as it should"
            );
            false
        };
        let next = std::panic::AssertUnwindSafe(|| {
            pool.install(|| {
                for _ in 0..3000 {
                    cluster.push(model.next(&cluster, &fails).expect("a birth"));
                    model.born(&cluster);
                }
            });
        });
        assert!(std::panic::catch_unwind(next).is_err());
        assert!(asked.into_inner() > 9000);
    }

    #[test]
    fn walkers_in_small_steps_wait_where_their_tracks_are_full() {
        let substrate = Substrate::load(Path::new("meshes/plane.obj")).expect("a mesh");
        let large = parameters(substrate.units().local_diagonal() / 4000.0);
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
