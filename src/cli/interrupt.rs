//! Ctrl-C: the first ends the growth well, the second quits at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::{INTERRUPTED, terminal};

/// Makes Ctrl-C (and a polite kill) set `cancel`, and a second one quit.
pub(crate) fn listen(cancel: Arc<AtomicBool>) {
    let heard = ctrlc::set_handler(move || {
        if cancel.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(INTERRUPTED));
        }
        terminal::plain(
            "\nStopping: the current element is finished and what there is gets written. \
             Ctrl-C again quits at once.",
        );
    });
    if let Err(e) = heard {
        terminal::warn(&format!("Ctrl-C will lose what has grown: {e}"));
    }
}
