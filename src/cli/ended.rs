//! What a run had when it ended: its log never has less, unless it was damaged.
//!
//! A log is durable before the files of a finished run are put in their place. So one that has fewer sound
//! elements than `report.json` says lost some afterwards. They would grow again as they were, but a run that is
//! stopped meanwhile, or at a smaller size, must not put less in the place of what is finished.

use std::io::{self, BufReader, ErrorKind};
use std::path::Path;

use thallus::cluster::Element;
use thallus::export::{Elements, read_elements};
use thallus::input;
use thallus::log::{LOG, Log};
use thallus::run::{Growth, StopRule, Stopped, shell_path};

use super::failure::Failure;
use super::number::{count, plural};
use super::output::{ELEMENTS, PREVIEW, REPORT};
use super::terminal;

/// Elements that the run in this folder had when it ended, whether it was done or stopped; 0 where none has. The
/// table says it too, where the report cannot be read.
pub(super) fn elements(folder: &Path) -> Result<u64, Failure> {
    let report = folder.join(REPORT);
    let problem = match reported(&report) {
        Ok(elements) => return Ok(elements),
        Err(problem) if problem.kind() == ErrorKind::NotFound => return Ok(0),
        Err(problem) => problem,
    };
    let table = read_elements(&folder.join(ELEMENTS));
    let elements = table.map(|table| table.len() as u64);
    elements.map_err(|_| {
        Failure::Failed(anyhow::anyhow!(
            "{}: {problem}: so nothing says how many elements the run in this folder had when it ended; if it had not \
             ended, move that file away",
            report.display()
        ))
    })
}

/// The number in a report.
fn reported(report: &Path) -> io::Result<u64> {
    let file = BufReader::new(input::regular(report)?);
    let report: serde_json::Value = serde_json::from_reader(file)?;
    let none = || io::Error::new(ErrorKind::InvalidData, "it has no number of elements");
    report["elements"].as_u64().ok_or_else(none)
}

/// Elements that the log has lost since the run ended.
pub(super) fn lost(folder: &Path, log: &Log) -> Result<u64, Failure> {
    let ended = elements(folder)?;
    Ok(ended.saturating_sub(log.begun.elements.len() as u64))
}

/// Refuses to replace files that the run has not written. A run that has not ended has none of them, unless it was
/// killed while they were put in their places: its log was whole then, `elements.ply` came first, and `report.json`
/// last.
pub(super) fn spare_foreign(folder: &Path, log: &Log) -> Result<(), Failure> {
    let is_there = |name: &str| folder.join(name).symlink_metadata().is_ok();
    let (elements, table) = (&log.begun.elements, folder.join(ELEMENTS));
    let foreign = match (is_there(ELEMENTS), is_there(REPORT)) {
        (true, true) => read_elements(&table).is_ok_and(|table| !are_one(&table, elements)),
        (true, false) => !read_elements(&table)
            .is_ok_and(|table| table.len() <= elements.len() && are_one(&table, elements)),
        (false, _) => false,
    };
    let is_picture = !is_there(ELEMENTS) && !is_there(REPORT) && is_there(PREVIEW);
    let (name, why) = match (foreign, is_picture) {
        (true, _) => (
            ELEMENTS,
            "this is another lichen than the run in this folder",
        ),
        (_, true) => (PREVIEW, "the run in this folder has not ended"),
        _ => return Ok(()),
    };
    Err(Failure::Failed(anyhow::anyhow!(
        "{}: {why}, which would replace it: move it away",
        folder.join(name).display()
    )))
}

/// Whether a table and a log are of one lichen, as far as both go: whatever the numbers of the triangles.
fn are_one(table: &Elements, log: &[Element]) -> bool {
    let mut both = log.iter().zip(table.parent.iter().zip(&table.uv));
    both.all(|(element, (&parent, &uv))| {
        parent == element.parent as i32 && uv == [element.at.u as f32, element.at.v as f32]
    })
}

/// Refuses a size below that of the run that ended, where that is known before growing.
pub(super) fn refuse_fewer(folder: &Path, log: &Log, stop: StopRule) -> Result<(), Failure> {
    let ended = elements(folder)?;
    match stop {
        StopRule::Elements(asked) if lost(folder, log)? > 0 && asked < ended => {
            Err(Failure::usage(format!(
                "{} has a run of {ended} elements, of which the log lost some, and {asked} are asked for: ask for \
                 no fewer than it had, or grow to that size in another folder",
                folder.display()
            )))
        }
        _ => Ok(()),
    }
}

/// Refuses to put fewer elements in the place of those that the run had.
pub(super) fn spare_finished(
    folder: &Path,
    stop: StopRule,
    growth: &Growth,
) -> Result<(), Failure> {
    let (ended, grown) = (elements(folder)?, growth.cluster.len());
    if grown as u64 >= ended {
        return Ok(());
    }
    let size = match stop {
        StopRule::Elements(asked) if asked >= ended => String::new(),
        _ => format!(" --elements {ended}"),
    };
    let said = format!(
        "it stopped before it had the {} elements of the run whose log was damaged, whose files stay; {} safe \
         in {LOG}: go on with thallus grow --resume {}{size}",
        count(ended),
        plural(grown, "element is", "elements are"),
        shell_path(folder)
    );
    match growth.stopped {
        Stopped::Cancelled => {
            terminal::warn(&format!("interrupted; {said}"));
            Err(Failure::Interrupted)
        }
        _ => Err(Failure::Failed(anyhow::Error::msg(said))),
    }
}
