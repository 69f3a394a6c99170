//! What work takes of memory.

/// The most memory that this process had, in bytes, where Linux tells it; otherwise 0.
pub(crate) fn peak_bytes() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|l| l.trim().split(' ').next()?.parse::<f64>().ok());
    1024.0 * kilobytes.unwrap_or(0.0)
}
