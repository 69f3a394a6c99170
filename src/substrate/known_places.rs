//! Places that have been looked for, kept for whoever asks for them again.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use super::SurfacePoint;

/// Answers that are kept: a run asks for those on one piece of the mesh and on all.
const MOST: usize = 4;

/// Places that were found, and among how many.
pub(crate) type Found = Arc<(Vec<SurfacePoint>, usize)>;

/// The last answers, by what was asked.
#[derive(Default)]
pub(crate) struct KnownPlaces(Mutex<VecDeque<(u64, Found)>>);

impl KnownPlaces {
    /// The answer of this number, which is looked for unless it is known.
    pub(crate) fn get_or(
        &self,
        asked: u64,
        look: impl FnOnce() -> (Vec<SurfacePoint>, usize),
    ) -> Found {
        let known = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, found)) = known().iter().find(|(key, _)| *key == asked) {
            return Arc::clone(found);
        }
        // Not under the lock: that would have others wait who ask for something else.
        let found = Arc::new(look());
        let mut all = known();
        all.truncate(MOST - 1);
        all.push_front((asked, Arc::clone(&found)));
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_asks_again_has_the_same_answer_without_a_look() {
        let known = KnownPlaces::default();
        let looks = std::cell::Cell::new(0);
        let ask = |asked: u64| {
            let found = known.get_or(asked, || {
                looks.set(looks.get() + 1);
                (Vec::new(), asked as usize)
            });
            found.1 as u64 == asked
        };
        assert!([7, 7, 8, 7, 8].into_iter().all(ask));
        assert_eq!(looks.get(), 2);
        // Of many the last are kept.
        assert!((0..20).chain(16..20).all(ask));
        assert_eq!(looks.get(), 22);
        assert!(ask(0));
        assert_eq!(looks.get(), 23);
    }
}
