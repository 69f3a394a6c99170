//! What work costs on a machine that does other work too.
#![allow(dead_code, reason = "each bench uses its own part of this")]

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

/// The most memory that this process had, in bytes, where Linux tells it; otherwise 0.
pub(crate) fn peak_bytes() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|l| l.trim().split(' ').next()?.parse::<f64>().ok());
    1024.0 * kilobytes.unwrap_or(0.0)
}
