//! How the runs of a sweep ended.

use std::collections::BTreeMap;
use std::sync::Mutex;

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum End {
    Finished,
    Failed(String),
    /// Another process grows it now.
    Elsewhere,
    /// Somebody asked to stop; what there is of it is logged.
    Interrupted,
}

/// How each of some runs ended.
pub(super) type Ends = BTreeMap<usize, End>;

pub(super) fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(|e| e.into_inner())
}
