//! Where elements are: the questions that growth asks of space.

use glam::DVec3;

use super::{Element, Population};

/// Answers growth's questions about the elements' centres. Ids are ages.
///
/// The elements themselves stay where they are and are handed in with every question: all that
/// have been inserted, in that order.
///
/// One thread may [insert](Self::insert) and [adopt](Self::adopt) while others look. What these see of elements that
/// they do not know of yet may be all, some or nothing: whether a walker saw what it would have seen after
/// their births is asked of its notes ([`held`](Self::held)) before its element is born, with all that there are by
/// then. Of those that it knew of it must miss none.
///
/// Growth depends on nothing else, so an index can be replaced without touching it. The law stays the same, not
/// the elements: bounds may be any, and walkers step by them; only by [`Steps::Small`](crate::growth::Steps::Small)
/// are the elements the same too. What touches, and who is within a distance, has to be exact. Looking never
/// changes an index: what it would like to keep for the next time goes into `Notes`, which each
/// walker has of its own and hands in at its end. Answers depend on the elements and on where the walker
/// has been, never on what others asked or handed in.
pub trait ElementIndex: Sync {
    /// What a walker saw, and what looking found out that is worth keeping.
    type Notes: Default + Send + Sync;

    /// An empty index for elements of this radius inside a box, given by its lower and upper
    /// corner; `wide` is the largest radius that [`count_bound`](Self::count_bound) and
    /// [`within`](Self::within) will be asked for often, none where that is a few element radii. An index may panic
    /// where the radius is not a positive finite number, or a corner is not finite.
    fn new(radius: f64, wide: Option<f64>, bounds: [DVec3; 2]) -> Self
    where
        Self: Sized;

    /// Reserves memory for so many elements in all, where there is any to be had. Vectors that grow move, and leave
    /// behind what they had.
    fn expect(&mut self, elements: usize);

    /// Makes room for the next births, a few hundred if they are usual ones, and for one at least.
    fn make_room(&mut self);

    /// Adds the youngest of the elements; all before it have been. It must lie in the bounds that the index was made
    /// for: an index may panic where it does not. False where there is no room: then it has to be
    /// [made](Self::make_room), and this one inserted again.
    #[must_use]
    fn insert(&self, elements: &Population<'_>) -> bool;

    /// Adds the youngest of the elements, and makes room for it where there is none: for whoever is alone with the
    /// index.
    fn add(&mut self, elements: &Population<'_>) {
        while !self.insert(elements) {
            self.make_room();
        }
    }

    /// Keeps what looking found out, as far as there is room.
    fn adopt(&self, elements: &Population<'_>, notes: &mut Self::Notes);

    /// How much a walker has seen until now.
    fn mark(&self, notes: &Self::Notes) -> Mark;

    /// How much of what a walker saw it would see again: it would see the same up to any mark
    /// [within](Mark::is_within) this one.
    fn held(&self, elements: &Population<'_>, notes: &Self::Notes) -> Mark;

    /// Forgets what a walker saw after a mark, up to which all holds. So many elements are known to it now.
    fn rewind(&self, known: usize, notes: &mut Self::Notes, mark: Mark);

    /// A new walker starts, which has to be told before its first [`look`](Self::look): forgets where the last
    /// one was. So many elements are known to it. What it sees is remembered for [`held`](Self::held) only where
    /// `others_walk`, so that one thread does not pay for many.
    fn begin(&self, known: usize, notes: &mut Self::Notes, others_walk: bool);

    /// Forgets what a walker saw, where all of it holds and no other comes before it any more.
    fn forget(&self, notes: &mut Self::Notes);

    /// How near the nearest centre is.
    ///
    /// How good the bound is may depend on where the walker has been.
    fn look(&self, elements: &Population<'_>, p: DVec3, notes: &mut Self::Notes) -> Look;

    /// At least the number of centres nearer than `radius` to a point: any number below `enough`, or
    /// that number and perhaps a few more, farther by rounding.
    fn count_bound(&self, elements: &Population<'_>, p: DVec3, radius: f64, enough: usize)
    -> usize;

    /// Reads what will be needed to tell what is in contact with a place: for whoever has several places to
    /// ask about, and would wait for each.
    fn read_ahead(&self, elements: &Population<'_>, p: DVec3);

    /// Whether some element with its centre nearer than `radius` to a point passes a test. They are
    /// tried in no stated order until one does.
    fn any_within(
        &self,
        elements: &Population<'_>,
        p: DVec3,
        radius: f64,
        test: &mut dyn FnMut(u32, &Element) -> bool,
    ) -> bool;

    /// The same for those nearer than two radii, for a walker that has [begun](Self::begin) and mostly
    /// [looked](Self::look) from there.
    fn any_touching(
        &self,
        elements: &Population<'_>,
        p: DVec3,
        notes: &mut Self::Notes,
        test: &mut dyn FnMut(u32, &Element) -> bool,
    ) -> bool;

    /// Visits every element with its centre nearer than `radius` to a point, in no stated order.
    fn within(
        &self,
        elements: &Population<'_>,
        p: DVec3,
        radius: f64,
        visit: &mut dyn FnMut(u32, &Element),
    ) {
        self.any_within(elements, p, radius, &mut |id, element| {
            visit(id, element);
            false
        });
    }
}

/// What a walker sees about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// No centre is nearer than this. The distance to the nearest may be larger.
    pub clear: f64,
    /// Some centre is nearer than two radii.
    pub touching: bool,
}

/// How much a walker has seen: the lengths of its notes, by kind, and where its next search begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mark {
    /// Lengths of the lists that an index keeps notes in.
    pub seen: [u32; 3],
    /// Where the next search begins.
    pub level: u32,
}

impl Mark {
    /// Whether all seen up to here had been seen at another mark.
    pub fn is_within(&self, other: &Self) -> bool {
        self.seen.iter().zip(other.seen).all(|(a, b)| *a <= b)
    }
}
