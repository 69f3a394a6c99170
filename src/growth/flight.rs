//! A walk that can be left and gone on with, and taken back to where others disturbed it.

use glam::DVec3;

use super::Counts;
use super::far::Level;
use super::patience::Patience;
use super::step::RandomStep;
use super::walker::Fate;
use crate::cluster::{Element, ElementIndex, Mark, Population};
use crate::rng::Stream;
use crate::substrate::{Facet, Substrate};
use crate::walk::Stand;

/// Milestones of a walker, each some 400 bytes and 300 more for what it saw on the way there. A walker
/// to an element takes some ten, one in small steps may take millions.
const MOST_MILESTONES: usize = 4096;

/// Those of all that walk at the same time: 70 MB.
const ALL_MILESTONES: usize = 100_000;

/// A walk that may be under way.
pub(super) struct Flight<I: ElementIndex> {
    /// The walker's number.
    pub(super) number: u64,
    pub(super) stage: Stage,
    pub(super) track: Track<I>,
    /// Elements that there were when all that the walker saw was last as it saw it.
    pub(super) elements: usize,
    /// The launcher that it was launched by.
    pub(super) launcher: u64,
}

/// How far a walk has come.
pub(super) enum Stage {
    Ready,
    UnderWay(Way),
    Ended(Fate),
}

/// A walker between two steps.
#[derive(Clone)]
pub(super) struct Way {
    pub(super) here: Stand,
    /// On which surface: that of the mesh or a coarser copy.
    pub(super) level: Level,
    pub(super) underfoot: Underfoot,
    /// The bound on the next step, and what is random in it.
    pub(super) bound: f64,
    pub(super) random: RandomStep,
    pub(super) patience: Patience,
    /// Whether it was refused just now. Only Brownian motion asks.
    pub(super) thrown_back: bool,
    /// How often it was kept from leaving the habitat.
    pub(super) kept: u32,
    /// How often it found no place to join where it was to stick.
    pub(super) unjoined: u32,
    pub(super) stream: Stream,
}

/// A triangle of a level as it lies there: the one where a step led, from where the next mostly begins.
#[derive(Clone)]
pub(super) struct Underfoot {
    level: Level,
    pub(super) facet: Facet,
}

impl Underfoot {
    pub(super) fn new((level, triangle): (Level, u32), surface: &Substrate) -> Self {
        Self::of(level, surface.facet(triangle))
    }

    pub(super) fn of(level: Level, facet: Facet) -> Self {
        Self { level, facet }
    }

    /// Makes it that of a triangle.
    pub(super) fn be(&mut self, at: (Level, u32), surface: &Substrate) {
        if (self.level, self.facet.triangle) != at {
            *self = Self::new(at, surface);
        }
    }
}

/// What a walker leaves behind.
pub(super) struct Track<I: ElementIndex> {
    /// What it took.
    pub(super) counts: Counts,
    /// What it saw of the index.
    pub(super) notes: I::Notes,
    /// Where it asked which elements there are.
    pub(super) asked: Vec<Asked>,
    /// Places to which it can be taken back.
    milestones: Vec<Milestone>,
    /// How many of them there may be.
    room: usize,
}

/// A ball whose elements decided something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Asked {
    pub(super) centre: DVec3,
    pub(super) radius: f64,
    /// How many more elements there might be without making a difference.
    pub(super) spare: usize,
}

/// A walker between two steps, and the lengths of what it had left behind.
struct Milestone {
    way: Way,
    counts: Counts,
    mark: Mark,
    asked: usize,
}

impl<I: ElementIndex> Default for Track<I> {
    fn default() -> Self {
        Self {
            counts: Counts::default(),
            notes: I::Notes::default(),
            asked: Vec::new(),
            milestones: Vec::new(),
            room: MOST_MILESTONES,
        }
    }
}

impl<I: ElementIndex> Track<I> {
    /// A new walker starts.
    pub(super) fn begin(&mut self, index: &I, known: usize, others_walk: bool) {
        self.counts = Counts {
            walkers: 1,
            ..Counts::default()
        };
        self.asked.clear();
        self.milestones.clear();
        index.begin(known, &mut self.notes, others_walk);
    }

    /// All that the walker saw holds, and no other comes before it any more: it is not taken back.
    pub(super) fn forget(&mut self, index: &I) {
        self.asked.clear();
        self.milestones.clear();
        index.forget(&mut self.notes);
    }

    /// Takes as much room as one of so many walkers may.
    pub(super) fn share_room(&mut self, walkers: usize) {
        self.room = MOST_MILESTONES.min(ALL_MILESTONES / walkers);
    }

    /// Whether it is so long that the walker had better wait until it need not leave any.
    pub(super) fn is_full(&self) -> bool {
        self.milestones.len() >= self.room
    }

    /// Notes a place to which the walker can be taken back.
    pub(super) fn remember(&mut self, index: &I, way: &Way) {
        self.milestones.push(Milestone {
            way: way.clone(),
            counts: self.counts.clone(),
            mark: index.mark(&self.notes),
            asked: self.asked.len(),
        });
    }
}

impl<I: ElementIndex> Flight<I> {
    /// Makes it that of another walker.
    pub(super) fn begin(&mut self, number: u64) {
        (self.number, self.stage) = (number, Stage::Ready);
    }

    pub(super) fn fate(&self) -> Option<Fate> {
        match self.stage {
            Stage::Ended(fate) => Some(fate),
            _ => None,
        }
    }

    /// Takes the walker back to before anything that it would see otherwise now. False where there
    /// was nothing of the kind.
    pub(super) fn catch_up(&mut self, index: &I, elements: &Population<'_>, launcher: u64) -> bool {
        let known = std::mem::replace(&mut self.elements, elements.len());
        if matches!(self.stage, Stage::Ready) {
            return false;
        }
        if launcher != self.launcher {
            self.stage = Stage::Ready;
            return true;
        }
        if known == elements.len() {
            return false;
        }
        let births = elements.since(known);
        let (held, asked) = (
            index.held(elements, &self.track.notes),
            self.undisturbed(births),
        );
        let now = index.mark(&self.track.notes);
        if now.is_within(&held) && asked == self.track.asked.len() {
            index.rewind(elements.len(), &mut self.track.notes, now);
            return false;
        }
        self.take_back(index, elements.len(), (held, asked));
        true
    }

    /// The number of the first ball in which births make a difference, or of all.
    fn undisturbed<'a>(&mut self, births: impl Iterator<Item = &'a Element> + Clone) -> usize {
        let disturbed = |asked: &mut Asked| {
            let limit = asked.radius * asked.radius;
            let inside = |e: &&Element| e.position.distance_squared(asked.centre) < limit;
            let inside = births.clone().filter(inside).count();
            let disturbed = inside > asked.spare;
            asked.spare -= inside.min(asked.spare);
            disturbed
        };
        let all = self.track.asked.len();
        let first = self.track.asked.iter_mut().position(disturbed);
        first.unwrap_or(all)
    }

    /// Takes the walker back to its last milestone before these, or to before its launch.
    fn take_back(&mut self, index: &I, known: usize, (held, asked): (Mark, usize)) {
        let track = &mut self.track;
        let before = |m: &Milestone| m.mark.is_within(&held) && m.asked <= asked;
        let kept = track.milestones.iter().take_while(|m| before(m)).count();
        track.milestones.truncate(kept);
        self.stage = match track.milestones.last() {
            None => Stage::Ready,
            Some(milestone) => {
                track.counts = milestone.counts.clone();
                track.asked.truncate(milestone.asked);
                index.rewind(known, &mut track.notes, milestone.mark);
                Stage::UnderWay(milestone.way.clone())
            }
        };
    }
}

impl<I: ElementIndex> Default for Flight<I> {
    fn default() -> Self {
        Self {
            number: 0,
            stage: Stage::Ready,
            track: Track::default(),
            elements: 0,
            launcher: 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cluster::SparseIndex;

    #[test]
    fn milestones_of_all_that_walk_are_bounded() {
        let mut track = Track::<SparseIndex>::default();
        for walkers in [1, 6, 48, 384, 5000] {
            track.share_room(walkers);
            assert!((1..=MOST_MILESTONES).contains(&track.room), "{walkers}");
            assert!(walkers * track.room <= ALL_MILESTONES);
        }
        track.share_room(6);
        assert_eq!(track.room, MOST_MILESTONES);
    }
}
