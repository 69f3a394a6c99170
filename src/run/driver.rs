//! The loop that grows: births, one after the other, until a rule says stop.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec3;

use super::settings::check_room;
use super::{Execution, Observer, Progress, Recipe, SettingsError, StopRule};
use crate::cluster::{Cluster, Element};
use crate::growth::{Counts, GrowthModel, Halt, Parallel, PlaceError, WalkerModel};
use crate::substrate::Substrate;

/// What a run made.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Growth {
    /// The elements.
    pub cluster: Cluster,
    /// Why it ended.
    pub stopped: Stopped,
    /// What it took.
    pub counts: Counts,
    /// What it took up to the last birth.
    pub counts_at_birth: Counts,
    /// How the work was shared among threads.
    pub parallel: Parallel,
}

impl Growth {
    /// To go on from here: [`Run::new`] with the same recipe, but for its stop rule, grows what a run that never
    /// stopped would have grown.
    pub fn begun(self) -> Begun {
        Begun {
            elements: self.cluster.into_elements(),
            counts: self.counts_at_birth,
        }
    }
}

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Stopped {
    /// It has the number of elements that was asked for.
    Elements,
    /// Its effective radius reached the length that was asked for.
    Reach,
    /// It covers the share that was asked for.
    Cover,
    /// No place is left free on its component.
    Full,
    /// Open edges that absorb took ten million walkers since the last birth.
    Starved,
    /// Where it may grow it is hemmed in: a thousand walkers or more since the last birth, or a million contacts or
    /// more, came to nothing.
    Hemmed,
    /// It was told to stop.
    Cancelled,
    /// Its observer ended it.
    Observer,
}

/// Why a run could not start.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GrowError {
    /// A seed element has no place.
    #[error(transparent)]
    Place(#[from] PlaceError),
    /// The recipe has a value that settings could not have.
    #[error(transparent)]
    Recipe(#[from] SettingsError),
    /// The recipe has another axis up than the substrate.
    #[error(
        "the recipe has another axis up than the substrate: give its mesh_up to Substrate::with_up"
    )]
    Up,
    /// The recipe has another mask than the substrate.
    #[error(
        "the recipe has another mask than the substrate, or one has none: give the recipe's to Substrate::with_mask"
    )]
    Mask,
    /// An element to go on from cannot be one of this run.
    #[error(
        "element {age} of those to go on from cannot have grown on this mesh by this recipe: they are another run's, or \
         damaged; begin anew"
    )]
    Foreign {
        /// Its age.
        age: usize,
    },
    /// The counters to go on from are impossible for so many elements.
    #[error(
        "the counters to go on from ({walkers} walkers among them) are impossible for {elements} elements: they are \
         another run's, or damaged; begin anew"
    )]
    ForeignCounts {
        /// How many elements there are.
        elements: usize,
        /// Walkers by the counters.
        walkers: u64,
    },
    /// The run to go on with is larger than what is asked for.
    #[error(
        "there are {total} elements already, and the size asked for was reached at {end}: ask for \
         more, or grow to that size in another folder"
    )]
    PastTheEnd {
        /// Elements at which the stop rule would have ended the run.
        end: usize,
        /// Elements to go on from.
        total: usize,
    },
}

/// Most elements: their ages are 32-bit numbers, and one is kept for 'none'.
const MOST_ELEMENTS: u64 = u32::MAX as u64 - 1;

/// Bytes: room is made for some 400 an element.
const TWICE_THE_ROOM: usize = 800;

/// Grows a lichen by a recipe.
///
/// The result depends on the substrate and the recipe alone.
///
/// # Errors
/// When the recipe has a value that [`Settings`](super::Settings) could not have (its fields are public), the
/// radius does not fit the mesh, or a seed element has no place.
pub fn grow(
    substrate: &Substrate,
    recipe: &Recipe,
    execution: &Execution,
    observer: &mut dyn Observer,
) -> Result<Growth, GrowError> {
    let run = Run::new(substrate, recipe, Begun::default())?;
    Ok(run.grow(execution, observer))
}

/// What an earlier run by the same recipe, but for its stop rule, has come to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Begun {
    /// Its elements, oldest first; none for a run from the start.
    pub elements: Vec<Element>,
    /// What they took: the counts after the last birth. The next walker is chosen by them, so that elements do not go
    /// on without theirs.
    pub counts: Counts,
}

/// A run that has its first elements and is ready for the next.
pub struct Run<'a> {
    substrate: &'a Substrate,
    rule: StopRule,
    /// One a colony.
    seeds: Vec<Element>,
    /// Of all pieces that these are on, as far as lichen may grow there.
    area: f64,
    /// How far elements are from their colonies' seeds at most.
    reach: f64,
    cluster: Cluster,
    model: WalkerModel<'a>,
}

impl std::fmt::Debug for Run<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Run")
            .field("elements", &self.cluster.len())
            .field("rule", &self.rule)
            .field("colonies", &self.seeds.len())
            .finish_non_exhaustive()
    }
}

impl<'a> Run<'a> {
    /// Takes up what has begun. It goes on as if it had never stopped: the index, the launch arcs
    /// and the extent are rebuilt by telling the model of the births again.
    ///
    /// # Errors
    /// As [`grow`]; when the elements or their counts are not those of this mesh and recipe, as far as that shows;
    /// [`GrowError::PastTheEnd`] when the stop rule would have ended the run before the last one.
    pub fn new(substrate: &'a Substrate, recipe: &Recipe, begun: Begun) -> Result<Self, GrowError> {
        if !substrate.has_up(recipe.mesh_up) {
            return Err(GrowError::Up);
        }
        let has_its_mask = match (substrate.mask(), &recipe.mask) {
            (Some(mask), Some(id)) => id.is_of(mask),
            (found, asked) => found.is_none() && asked.is_none(),
        };
        if !has_its_mask {
            return Err(GrowError::Mask);
        }
        recipe.check(substrate)?;
        let seeds = recipe.seeds(substrate)?;
        check_room(substrate, &seeds, recipe, false)?;
        let parameters = recipe.parameters(substrate);
        let mut run = Self {
            substrate,
            rule: recipe.stop,
            area: recipe
                .habitat(substrate)
                .area(seeds.iter().map(|at| at.triangle)),
            seeds: (0..)
                .zip(seeds)
                .map(|(colony, at)| Element {
                    colony,
                    ..Element::seed(substrate, at)
                })
                .collect(),
            reach: 0.0,
            cluster: Cluster::new(parameters.radius),
            model: WalkerModel::new(substrate, parameters),
        };
        run.make_room();
        run.replay(begun)?;
        Ok(run)
    }

    /// Makes room for the elements asked for, where twice as much is to be had: under a limit on
    /// address space, or where memory is promised once only, the rest of the program needs some too.
    fn make_room(&mut self) {
        let StopRule::Elements(n) = self.rule else {
            return;
        };
        let n = n.min(MOST_ELEMENTS) as usize;
        let mut twice: Vec<u8> = Vec::new();
        let is_there = twice.try_reserve_exact(n.saturating_mul(TWICE_THE_ROOM));
        // Nobody looks into it, and so the compiler might do without it.
        std::hint::black_box(&twice);
        drop(twice);
        if is_there.is_ok() {
            self.cluster.expect(n);
            self.model.expect(n);
        }
    }

    fn replay(&mut self, begun: Begun) -> Result<(), GrowError> {
        let total = begun.elements.len();
        if !begun.counts.can_be_of(total, self.seeds.len()) {
            return Err(GrowError::ForeignCounts {
                elements: total,
                walkers: begun.counts.walkers,
            });
        }
        let bounds = self.substrate.bounds();
        for (age, element) in begun.elements.into_iter().enumerate() {
            if !self.may_follow(&element, bounds) {
                return Err(GrowError::Foreign { age });
            }
            self.add(element);
            if age + 1 < total && self.reached(&self.progress()).is_some() {
                return Err(GrowError::PastTheEnd {
                    end: age + 1,
                    total,
                });
            }
        }
        self.model.resume(begun.counts);
        Ok(())
    }

    /// Whether an element can be the next one: a seed, or one on the mesh with an older parent.
    fn may_follow(&self, element: &Element, bounds: [DVec3; 2]) -> bool {
        if let Some(seed) = self.next_seed() {
            return *element == seed;
        }
        let parent = self.cluster.elements().get(element.parent as usize);
        parent.is_some_and(|parent| parent.colony == element.colony)
            && (0.0..=1.0).contains(&element.probability)
            && self.is_on_mesh(element, bounds)
    }

    /// Whether an element is where it says, in its triangle, and the mesh is there.
    fn is_on_mesh(&self, element: &Element, [low, high]: [DVec3; 2]) -> bool {
        let (at, place) = (&element.at, element.position);
        let room = DVec3::splat(self.cluster.radius());
        let is_within = at.weights().iter().all(|&weight| weight >= -OUTSIDE);
        (at.triangle as usize) < self.substrate.triangles().len()
            && is_within
            && place == self.substrate.position(at)
            && place.cmpge(low - room).all()
            && place.cmple(high + room).all()
    }

    /// How far it has come.
    pub fn progress(&self) -> Progress {
        let to_file = |length| self.substrate.units().length_to_file(length);
        let effective_radius = to_file(self.cluster.extent().effective_radius());
        Progress {
            elements: self.cluster.len() as u64,
            effective_radius,
            reach: match self.seeds.len() {
                1 => effective_radius,
                _ => to_file(self.reach),
            },
            covered: (self.cluster.covered_area() / self.area).min(1.0),
            counts: self.model.counts().clone(),
        }
    }

    /// Why it ends with what it has already, if its rule says so: then it grows nothing.
    pub fn ended(&self) -> Option<Stopped> {
        let begun = !self.cluster.is_empty();
        begun.then(|| self.reached(&self.progress())).flatten()
    }

    /// What has grown so far: what a log holds, to be measured or drawn without going on.
    pub fn cluster(&self) -> &Cluster {
        &self.cluster
    }

    /// What has grown so far, to keep, where the run is not to go on.
    pub fn into_cluster(self) -> Cluster {
        self.cluster
    }

    /// Grows until a rule says stop. The observer sees the births from here on: one that counts begins with
    /// [`Run::progress`], and one that has stopped a run before its rule did is asked again after the next birth only.
    pub fn grow(mut self, execution: &Execution, observer: &mut dyn Observer) -> Growth {
        self.model = match execution.uses_all_threads {
            true => self.model.on_threads(execution.threads),
            false => self.model.on_threads_that_pay(execution.threads),
        };
        let stopped = match execution.threads {
            0 | 1 => self.until_stopped(execution, observer),
            // From inside the pool this thread takes its share of the walkers.
            _ => rayon::scope(|_| self.until_stopped(execution, observer)),
        };
        Growth {
            counts: self.model.counts().clone(),
            counts_at_birth: self.model.counts_at_birth().clone(),
            parallel: self.model.parallel(),
            cluster: self.cluster,
            stopped,
        }
    }

    fn until_stopped(&mut self, execution: &Execution, observer: &mut dyn Observer) -> Stopped {
        let mut ended = self.ended();
        let mut untold = Vec::new();
        loop {
            let (told, next) = match ended {
                Some(stopped) => (tell(&untold, execution, observer), Err(stopped)),
                None => self.tell_and_go_on(&untold, execution, observer),
            };
            if let Err(broken) = told {
                self.take_back(&untold, broken.told);
                let is_last = broken.told == untold.len();
                let by_rule = ended.filter(|why| is_last && *why != Stopped::Cancelled);
                return by_rule.unwrap_or(broken.why);
            }
            untold.clear();
            ended = match next {
                Ok(next) => self.take_in(next, execution, &mut untold),
                Err(stopped) => return stopped,
            };
        }
    }

    /// Tells of births, and finds the next element: at the same time, where that is worth it.
    fn tell_and_go_on(
        &mut self,
        untold: &[Birth],
        execution: &Execution,
        observer: &mut dyn Observer,
    ) -> (Result<(), Broken>, Result<Element, Stopped>) {
        let cancelled = || execution.is_cancelled();
        if untold.len() < WORTH_SHARING || rayon::current_num_threads() < 2 {
            return match tell(untold, execution, observer) {
                Ok(()) => (Ok(()), self.next(&cancelled)),
                Err(Broken { told, why }) => (Err(Broken { told, why }), Err(why)),
            };
        }
        at_once(
            || tell(untold, execution, observer),
            |is_broken| self.next(&|| cancelled() || is_broken()),
        )
    }

    /// Adds an element, and those after it that are there already. Why the run ends with the last of them, if it does.
    fn take_in(
        &mut self,
        mut next: Element,
        execution: &Execution,
        untold: &mut Vec<Birth>,
    ) -> Option<Stopped> {
        loop {
            self.add(next);
            let progress = self.progress();
            let reached = self.reached(&progress);
            untold.push((next, progress));
            if reached.is_some() || !self.model.knows_next() {
                return reached;
            }
            next = match self.next(&|| execution.is_cancelled()) {
                Ok(next) => next,
                Err(stopped) => return Some(stopped),
            };
        }
    }

    /// Takes back the births that the observer was not told of, and what was walked for the next.
    fn take_back(&mut self, untold: &[Birth], told: usize) {
        if let Some((_, last)) = told.checked_sub(1).and_then(|last| untold.get(last)) {
            self.cluster.truncate(last.elements as usize);
            self.model.resume(last.counts.clone());
        }
    }

    fn next(&mut self, cancelled: &(dyn Fn() -> bool + Sync)) -> Result<Element, Stopped> {
        if cancelled() && !self.cluster.is_empty() {
            return Err(Stopped::Cancelled);
        }
        if let Some(seed) = self.next_seed() {
            return Ok(seed);
        }
        let next = self.model.next(&self.cluster, cancelled);
        next.map_err(|halt| match halt {
            Halt::NoFreeSurface => Stopped::Full,
            Halt::Starved => Stopped::Starved,
            Halt::Hemmed => Stopped::Hemmed,
            Halt::Cancelled => Stopped::Cancelled,
        })
    }

    fn next_seed(&self) -> Option<Element> {
        self.seeds.get(self.cluster.len()).copied()
    }

    fn add(&mut self, element: Element) {
        let seed = &self.seeds[element.colony as usize];
        self.reach = element.position.distance(seed.position).max(self.reach);
        self.cluster.push(element);
        self.model.born(&self.cluster);
    }

    /// Not before all colonies have begun.
    fn reached(&self, progress: &Progress) -> Option<Stopped> {
        if self.cluster.len() < self.seeds.len() {
            return None;
        }
        match self.rule {
            StopRule::Elements(n) => (progress.elements >= n).then_some(Stopped::Elements),
            StopRule::Reach(length) => (progress.reach >= length).then_some(Stopped::Reach),
            StopRule::Cover(share) => (progress.covered >= share).then_some(Stopped::Cover),
        }
        .or((progress.elements >= MOST_ELEMENTS).then_some(Stopped::Full))
    }
}

/// An element, and how far the run has come with it.
type Birth = (Element, Progress);

/// Births that are told of while walkers walk: fewer take less time than to share the work.
const WORTH_SHARING: usize = 16;

/// Where a run ends that its rule does not end: with so many of the births to be told of.
struct Broken {
    told: usize,
    why: Stopped,
}

/// Says so when dropped.
struct Breaks<'b>(&'b AtomicBool);

impl Drop for Breaks<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Does both at the same time, on two threads where one is free. The second is asked to stop where the first fails or
/// panics.
fn at_once<T: Send>(
    first: impl FnOnce() -> Result<(), Broken> + Send,
    second: impl FnOnce(&(dyn Fn() -> bool + Sync)) -> T + Send,
) -> (Result<(), Broken>, T) {
    let is_broken = AtomicBool::new(false);
    let (second, first) = rayon::join(
        || second(&|| is_broken.load(Ordering::Relaxed)),
        || {
            let breaks = Breaks(&is_broken);
            first()?;
            std::mem::forget(breaks);
            Ok(())
        },
    );
    (first, second)
}

/// Tells of births, until the observer ends the run or it is told to stop.
fn tell(
    untold: &[Birth],
    execution: &Execution,
    observer: &mut dyn Observer,
) -> Result<(), Broken> {
    for (told, (element, progress)) in (1..).zip(untold) {
        let why = match observer.born(element, progress).is_break() {
            true => Stopped::Observer,
            false if execution.is_cancelled() => Stopped::Cancelled,
            false => continue,
        };
        return Err(Broken { told, why });
    }
    Ok(())
}

/// How far outside its triangle an element may be by round-off, as a weight of a corner.
const OUTSIDE: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::time::{Duration, Instant};

    use super::*;

    /// Walkers may find nothing for minutes.
    #[test]
    fn walkers_stop_where_telling_ends_the_run_or_panics() {
        let was_stopped = AtomicBool::new(false);
        let walk = |is_broken: &(dyn Fn() -> bool + Sync)| {
            let begun = Instant::now();
            while !is_broken() && begun.elapsed() < Duration::from_secs(20) {
                std::thread::yield_now();
            }
            was_stopped.store(is_broken(), Ordering::Relaxed);
        };
        let why = Stopped::Observer;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build();
        pool.expect("threads").install(|| {
            let (told, ()) = at_once(|| Err(Broken { told: 1, why }), walk);
            assert!(told.is_err() && was_stopped.swap(false, Ordering::Relaxed));
            let panics = || at_once(|| panic!("as it should"), walk);
            assert!(catch_unwind(AssertUnwindSafe(panics)).is_err());
            assert!(was_stopped.swap(false, Ordering::Relaxed));
            let (told, ended) = at_once(|| Ok(()), |is_broken| !is_broken());
            assert!(told.is_ok() && ended);
        });
    }
}
