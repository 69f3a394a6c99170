//! Walkers on several threads (`docs/architecture.md`).
//!
//! A walker's way depends on the lichen as it is when all walkers before it have come to their end.
//! To use several threads, walkers walk at the same time against the lichen as it is just then, and each leaves a
//! [`Track`](super::flight::Track) of what it asked. They land in order: whichever thread finds that the next one in
//! order has come to its end lands it, and adds its element to the lichen, while the others walk on.
//! A walker that would have seen something else, had it waited, is first taken back to before that
//! and walks on from there. So the result is that of one walker after the other, bit for bit,
//! whatever the threads and the number of those that walk.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError, TryLockError};
use std::time::{Duration, Instant};

use crossbeam_utils::CachePadded;
use rayon::prelude::*;

use super::Halt;
use super::books::Books;
use super::flight::Flight;
use super::scene::Scene;
use super::walker::{Fate, Interrupts};
use crate::cluster::{Cluster, Element, ElementIndex, Population};

/// Elements born before the caller is told of them, at most.
pub(super) const MOST_AHEAD: usize = 256;

/// How long walkers walk before it is, at most.
const LONGEST: Duration = Duration::from_millis(10);

/// Looks at what a thread waits for, until walkers walk together again, before it may sleep: some hundred microseconds.
const MOST_WAITS: u32 = 10_000;

/// The same while they do, and there are none left for it.
const FEW_WAITS: u32 = 2_000;

/// How long it sleeps then.
const NAP: Duration = Duration::from_micros(100);

/// Walkers from one look at the clock to the next.
const CLOCK: u64 = 16;

/// What bounds a while of walking together.
#[derive(Clone, Copy)]
pub(super) struct Limits {
    pub(super) threads: usize,
    /// Walkers on their way, with those that wait to land.
    pub(super) walkers: usize,
    pub(super) births: usize,
    /// Edges crossed up to a birth, after which the scene may change.
    pub(super) crossings: u64,
}

/// A while in which walkers walk together.
pub(super) struct Together<'b, 'a, I: ElementIndex> {
    scene: &'b Scene<'a, I>,
    cluster: &'b Cluster,
    /// Those born ahead of it.
    young: &'b [OnceLock<Element>],
    /// How many elements there are, as far as the index has them.
    born: CachePadded<AtomicUsize>,
    limits: Limits,
    cancelled: &'b (dyn Fn() -> bool + Sync),
    roster: Mutex<Roster<I>>,
    /// Whoever has them lands walkers.
    books: Mutex<(Books, Outcome)>,
    is_over: CachePadded<AtomicBool>,
    /// How often the roster has changed.
    changes: AtomicUsize,
    conflicts: AtomicU64,
    since: Instant,
}

/// What came of a while, besides what is in the books.
#[derive(Default)]
pub(super) struct Outcome {
    pub(super) halt: Option<Halt>,
    /// Whether the index had no room for the last element.
    pub(super) index_is_full: bool,
    /// Seconds that landing took.
    pub(super) landing: f64,
    pub(super) conflicts: u64,
}

/// Walkers on their way, in order of their numbers.
struct Roster<I: ElementIndex> {
    places: VecDeque<Place<I>>,
    /// The number of the first.
    first: u64,
    /// Flights for others.
    spare: Vec<Box<Flight<I>>>,
}

enum Place<I: ElementIndex> {
    Waits(Box<Flight<I>>),
    Walks,
    Ended(Box<Flight<I>>),
}

impl<I: ElementIndex> Place<I> {
    fn of(flight: Box<Flight<I>>) -> Self {
        match flight.fate() {
            Some(_) => Place::Ended(flight),
            None => Place::Waits(flight),
        }
    }

    fn flight(self) -> Option<Box<Flight<I>>> {
        match self {
            Place::Waits(flight) | Place::Ended(flight) => Some(flight),
            Place::Walks => None,
        }
    }
}

impl<I: ElementIndex> Roster<I> {
    /// The first that is to walk, and whether others are before it.
    fn next(&mut self, limits: &Limits) -> Option<(Box<Flight<I>>, bool)> {
        // One whose track is full has to wait until it is the first.
        let waits = |(i, place): (usize, &Place<I>)| match place {
            Place::Waits(flight) => i == 0 || !flight.track.is_full(),
            _ => false,
        };
        if let Some(i) = self.places.iter().enumerate().position(waits) {
            let place = std::mem::replace(&mut self.places[i], Place::Walks);
            return place.flight().map(|flight| (flight, i > 0));
        }
        let before = self.places.len();
        (before < limits.walkers).then(|| {
            let mut flight = self.spare.pop().unwrap_or_default();
            flight.begin(self.first + before as u64);
            flight.track.share_room(limits.walkers);
            self.places.push_back(Place::Walks);
            (flight, before > 0)
        })
    }

    fn put_back(&mut self, flight: Box<Flight<I>>) {
        let place = (flight.number - self.first) as usize;
        self.places[place] = Place::of(flight);
    }

    fn first_has_ended(&self) -> bool {
        matches!(self.places.front(), Some(Place::Ended(_)))
    }

    /// The first, if it has come to its end.
    fn first_ended(&mut self) -> Option<Box<Flight<I>>> {
        match self.first_has_ended() {
            true => std::mem::replace(&mut self.places[0], Place::Walks).flight(),
            false => None,
        }
    }

    /// It has landed.
    fn remove_first(&mut self, flight: Box<Flight<I>>) {
        self.places.pop_front();
        self.first += 1;
        self.spare.push(flight);
    }
}

/// Ends the while when a thread leaves, for whatever reason: others might wait for its walker for ever.
struct Leaving<'b>(&'b AtomicBool);

impl Drop for Leaving<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The walkers on their way, and flights for others.
pub(super) type Fleet<I> = (VecDeque<Box<Flight<I>>>, Vec<Box<Flight<I>>>);

impl<'b, 'a, I: ElementIndex> Together<'b, 'a, I> {
    /// Ready to walk. No element is ahead, and all places for them are free.
    pub(super) fn new(
        (scene, cluster, young): (&'b Scene<'a, I>, &'b Cluster, &'b [OnceLock<Element>]),
        (fleet, spare): Fleet<I>,
        books: Books,
        limits: Limits,
        cancelled: &'b (dyn Fn() -> bool + Sync),
    ) -> Self {
        let roster = Roster {
            places: fleet.into_iter().map(Place::of).collect(),
            first: books.counts.walkers,
            spare,
        };
        Self {
            scene,
            cluster,
            young,
            born: AtomicUsize::new(cluster.len()).into(),
            limits,
            cancelled,
            roster: Mutex::new(roster),
            books: Mutex::new((books, Outcome::default())),
            is_over: CachePadded::default(),
            changes: AtomicUsize::new(0),
            conflicts: AtomicU64::new(0),
            since: Instant::now(),
        }
    }

    /// Walks for a while: until elements are to be told of, or the scene has to change.
    pub(super) fn walk(self) -> (Fleet<I>, Books, Outcome) {
        (0..self.limits.threads)
            .into_par_iter()
            .with_max_len(1)
            .for_each(|job| self.work(job));
        let roster = self.roster.into_inner();
        let roster = roster.unwrap_or_else(PoisonError::into_inner);
        let fleet = roster.places.into_iter().filter_map(Place::flight);
        let books = self.books.into_inner();
        let (books, outcome) = books.unwrap_or_else(PoisonError::into_inner);
        let conflicts = self.conflicts.into_inner();
        let outcome = Outcome {
            conflicts,
            ..outcome
        };
        ((fleet.collect(), roster.spare), books, outcome)
    }

    fn is_over(&self) -> bool {
        self.is_over.load(Ordering::Relaxed)
    }

    fn end(&self) {
        self.is_over.store(true, Ordering::Relaxed);
    }

    fn elements(&self) -> Population<'b> {
        let born = self.born.load(Ordering::Acquire);
        Population::from(self.cluster).with_young(self.young, born)
    }

    /// What one of the threads does.
    fn work(&self, job: usize) {
        let _leaving = Leaving(&self.is_over);
        let paused = || self.is_over();
        let interrupts = Interrupts {
            cancelled: self.cancelled,
            paused: &paused,
        };
        while !self.is_over() {
            let changes = self.changes.load(Ordering::Relaxed);
            match self.next() {
                Some((mut flight, others_walk)) => {
                    let job = (job, others_walk);
                    let again = self
                        .scene
                        .advance(&mut flight, self.elements(), job, interrupts);
                    self.count_conflict(again);
                    self.put_back(flight);
                }
                None => self.wait_for_more_than(changes),
            }
            self.land_all();
        }
    }

    /// The next to walk, and whether others are before it. None becomes the first once it is over: what it saw would be
    /// forgotten, though an element before it may have found no room in the index.
    fn next(&self) -> Option<(Box<Flight<I>>, bool)> {
        let mut roster = lock(&self.roster);
        match self.is_over() {
            true => None,
            false => roster.next(&self.limits),
        }
    }

    fn count_conflict(&self, is_one: bool) {
        if is_one {
            self.conflicts.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn first_ended(&self) -> Option<Box<Flight<I>>> {
        lock(&self.roster).first_ended()
    }

    fn put_back(&self, flight: Box<Flight<I>>) {
        lock(&self.roster).put_back(flight);
        self.changes.fetch_add(1, Ordering::Relaxed);
    }

    /// Waits, but not for ever, until the roster has changed.
    fn wait_for_more_than(&self, changes: usize) {
        let is_same = || self.changes.load(Ordering::Relaxed) == changes && !self.is_over();
        if is_in_vain(FEW_WAITS, is_same) {
            std::thread::sleep(NAP);
        }
    }

    /// Lands those that have come to their end and have none before them, unless another thread does.
    fn land_all(&self) {
        while !self.is_over() && lock(&self.roster).first_has_ended() {
            let mut books = match self.books.try_lock() {
                Ok(books) => books,
                Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
                Err(TryLockError::WouldBlock) => return,
            };
            while !self.is_over()
                && let Some(flight) = self.first_ended()
            {
                self.land_by_the_clock(&mut books, flight);
            }
        }
    }

    /// Lands a walker, and now and then looks at the clock.
    fn land_by_the_clock(&self, (books, outcome): &mut (Books, Outcome), flight: Box<Flight<I>>) {
        if !flight.number.is_multiple_of(CLOCK) {
            return self.land(books, outcome, flight);
        }
        let started = Instant::now();
        self.land(books, outcome, flight);
        outcome.landing += CLOCK as f64 * started.elapsed().as_secs_f64();
        if self.since.elapsed() > LONGEST {
            self.end();
        }
    }

    /// Takes in what the first walker found out and took; or takes it back, if it was disturbed.
    fn land(&self, books: &mut Books, outcome: &mut Outcome, mut flight: Box<Flight<I>>) {
        let elements = self.elements();
        let again = self.scene.catch_up(&mut flight, &elements);
        self.count_conflict(again);
        let Some(fate) = flight.fate() else {
            return self.put_back(flight);
        };
        if let Fate::Halted(halt) = fate {
            outcome.halt = Some(halt);
            self.end();
            return self.put_back(flight);
        }
        self.scene.index.adopt(&elements, &mut flight.track.notes);
        books.add(&flight);
        books.landed_together += 1;
        match fate {
            Fate::Joined(element) => outcome.index_is_full = !self.give_birth(books, element),
            _ => self.lose(books, elements.len()),
        }
        lock(&self.roster).remove_first(flight);
        self.changes.fetch_add(1, Ordering::Relaxed);
    }

    /// Adds an element. Whether the index has it too.
    fn give_birth(&self, books: &mut Books, element: Element) -> bool {
        let age = self.born.load(Ordering::Relaxed);
        self.young[age - self.cluster.len()].get_or_init(|| element);
        let elements = Population::from(self.cluster).with_young(self.young, age + 1);
        let has_room = self.scene.index.insert(&elements);
        books.born_ahead(&elements);
        if has_room {
            self.born.store(age + 1, Ordering::Release);
        }
        let Scene {
            launcher,
            substrate,
            parameters,
            ..
        } = self.scene;
        let changes_scene = books.at_birth.crossings > self.limits.crossings
            || launcher.is_outdated((substrate, parameters), books.extent(), &element);
        if !has_room || changes_scene || books.ahead.len() >= self.limits.births {
            self.end();
        }
        has_room
    }

    /// A walker came to nothing.
    fn lose(&self, books: &Books, elements: usize) {
        let is_enough = books.in_vain(self.scene, elements).is_some()
            || !self.scene.launcher.is_inside() && books.none_comes_in(self.scene, elements);
        if is_enough || (self.cancelled)() {
            self.end();
        }
    }
}

/// Waits, but not for ever, without letting the thread fall asleep: to wake it takes longer than the
/// others mostly do.
pub(super) fn wait_while(not_yet: impl Fn() -> bool) {
    is_in_vain(MOST_WAITS, not_yet);
}

/// Waits for so many looks at most. Whether it was in vain.
fn is_in_vain(looks: u32, not_yet: impl Fn() -> bool) -> bool {
    (0..looks).all(|_| {
        std::hint::spin_loop();
        not_yet()
    })
}
