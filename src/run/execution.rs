//! What a run needs that changes nothing in its result.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// How to run, apart from what to grow.
#[derive(Clone, Debug)]
pub struct Execution {
    /// Threads to use; the result is the same for any number.
    pub threads: usize,
    /// Set it to stop after the current element.
    pub cancel: Arc<AtomicBool>,
}

impl Default for Execution {
    fn default() -> Self {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        Self {
            threads,
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
