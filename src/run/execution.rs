//! What a run needs that changes nothing in its result.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// How to run, apart from what to grow.
#[derive(Clone, Debug)]
pub struct Execution {
    /// Threads that walk, at most, 0 being taken for 1 and more than 1024 for 1024; the result is the same for any
    /// number. One by default: two are 1.4 to 1.7 times as fast, and many lichens are grown faster side by side
    /// (`docs/performance.md`). They are threads of the rayon pool that the run is in; while one of them adds births
    /// the others tell the observer of those before or spin, so the pool is busy until the run ends.
    pub threads: usize,
    /// Whether all of them walk all the time, for measurements. Else, where fewer are faster, fewer do:
    /// that is found by trial.
    pub uses_all_threads: bool,
    /// Set it to stop; the walkers on their way are dropped, and births that the observer was not told of. It stays
    /// set: a run that is given it again stops at once, so clear it or take another [`Execution`] to go on.
    pub cancel: Arc<AtomicBool>,
}

impl Default for Execution {
    fn default() -> Self {
        Self {
            threads: 1,
            uses_all_threads: false,
            cancel: Arc::default(),
        }
    }
}

impl Execution {
    /// Whether somebody asked the run to stop.
    pub fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }
}
