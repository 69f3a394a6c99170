//! What a run had when it ended: its log never has less, unless it was damaged.
//!
//! A log is durable before the files of a finished run are put in their place. So one that has fewer sound
//! elements than `report.json` says lost some afterwards. They would grow again as they were, but a run that is
//! stopped meanwhile, or at a smaller size, must not put less in the place of what is finished.

use std::io::BufReader;
use std::path::Path;

use thallus::input;
use thallus::log::{LOG, Log};
use thallus::run::{Growth, StopRule, Stopped, shell_path};

use super::failure::Failure;
use super::number::{count, plural};
use super::output::REPORT;
use super::terminal;

/// Elements that the run in this folder had when it ended, whether it was done or stopped; 0 where none has.
pub(super) fn elements(folder: &Path) -> u64 {
    let file = input::regular(&folder.join(REPORT));
    let report = file.and_then(|file| Ok(serde_json::from_reader(BufReader::new(file))?));
    let report: serde_json::Value = report.unwrap_or_default();
    report["elements"].as_u64().unwrap_or(0)
}

/// Elements that the log has lost since the run ended.
pub(super) fn lost(folder: &Path, log: &Log) -> u64 {
    elements(folder).saturating_sub(log.begun.elements.len() as u64)
}

/// Refuses a size below that of the run that ended, where that is known before growing.
pub(super) fn refuse_fewer(folder: &Path, log: &Log, stop: StopRule) -> Result<(), Failure> {
    let ended = elements(folder);
    match stop {
        StopRule::Elements(asked) if lost(folder, log) > 0 && asked < ended => {
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
pub(super) fn spare_finished(folder: &Path, growth: &Growth) -> Result<(), Failure> {
    let (ended, grown) = (elements(folder), growth.cluster.len());
    if grown as u64 >= ended {
        return Ok(());
    }
    let said = format!(
        "it stopped before it had the {} elements of the run whose log was damaged, whose files stay; {} safe \
         in {LOG}: go on with thallus grow --resume {} --elements {ended}",
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
