//! What work costs on a machine that does other work too.

use std::path::PathBuf;
use std::sync::OnceLock;
use std::time::Instant;

/// CPU time of this process's threads, where Linux tells it; otherwise time.
pub(crate) fn seconds() -> f64 {
    static START: OnceLock<Instant> = OnceLock::new();
    let start = START.get_or_init(Instant::now);
    let tasks = std::fs::read_dir("/proc/self/task").into_iter().flatten();
    let told = |path: PathBuf| {
        let text = std::fs::read_to_string(path.join("schedstat")).ok()?;
        text.split(' ').next()?.parse::<f64>().ok()
    };
    let nanoseconds: f64 = tasks.flatten().filter_map(|task| told(task.path())).sum();
    match nanoseconds {
        0.0 => start.elapsed().as_secs_f64(),
        n => n * 1e-9,
    }
}
