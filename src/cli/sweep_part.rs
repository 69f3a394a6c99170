//! Which parts of a sweep a folder holds: a file each, that `merge` and a reader know them by.

use std::collections::BTreeSet;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use thallus::export::write_file_atomically;
use thallus::sweep::Plan;

use super::failure::Failure;
use super::number::plural;
use super::sweep_args::Shard;
use super::sweep_plan::first_of;

const START: &str = "part-";
const MIDDLE: &str = "-of-";
const END: &str = ".txt";

/// Says in a folder that this part is grown into it.
pub(super) fn mark(folder: &Path, shard: Shard) -> Result<(), Failure> {
    let file = folder.join(file_name(shard));
    if file.is_file() {
        return Ok(());
    }
    let text = format!("This folder holds part {shard} of the sweep in grid.toml.\n");
    let fill = |out: &mut dyn Write| out.write_all(text.as_bytes());
    Ok(write_file_atomically(&file, true, fill)?)
}

/// Takes away what says so, where a folder has come to hold all of them.
pub(super) fn unmark(folder: &Path) -> Result<(), Failure> {
    let files = marks(folder)
        .into_iter()
        .map(|shard| folder.join(file_name(shard)));
    for file in files {
        fs::remove_file(&file)
            .with_context(|| format!("{}: removing it failed", file.display()))?;
    }
    Ok(())
}

fn file_name(Shard { part, parts }: Shard) -> String {
    format!("{START}{part}{MIDDLE}{parts}{END}")
}

/// The parts that a folder says it holds.
fn marks(folder: &Path) -> Vec<Shard> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let shard = |entry: fs::DirEntry| {
        let name = entry.file_name();
        let numbers = name.to_str()?.strip_prefix(START)?.strip_suffix(END)?;
        numbers.replace(MIDDLE, "/").parse().ok()
    };
    let mut marks: Vec<Shard> = entries.filter_map(shard).collect();
    marks.sort_by_key(|shard| (shard.parts, shard.part));
    marks
}

/// The parts that two folders both say they hold, in words; empty for none.
pub(super) fn in_both(first: &Path, second: &Path) -> String {
    let theirs = marks(second);
    let both = marks(first)
        .into_iter()
        .filter(|mark| theirs.contains(mark));
    named(&both.collect::<Vec<_>>())
}

/// Which parts are missing, and which are not finished, in words, as far as the folders say; empty where
/// they do not.
pub(super) fn wanting(folders: &[PathBuf], plan: &Plan, missing: &BTreeSet<usize>) -> String {
    let marked = |folder: &PathBuf| -> Vec<(Shard, PathBuf)> {
        let with_folder = |shard| (shard, folder.clone());
        marks(folder).into_iter().map(with_folder).collect()
    };
    let marked: Vec<_> = folders.iter().flat_map(marked).collect();
    let Some((Shard { parts, .. }, _)) = marked.first() else {
        return String::new();
    };
    if marked.iter().any(|(shard, _)| shard.parts != *parts) {
        return String::new();
    }
    let mut words = Vec::new();
    let is_there = |part: usize| marked.iter().find(|(shard, _)| shard.part == part);
    let absent = (1..=*parts).filter(|&part| is_there(part).is_none());
    let absent: Vec<Shard> = absent
        .map(|part| Shard {
            part,
            parts: *parts,
        })
        .collect();
    match absent.len() {
        0 => {}
        1 => words.push(format!("{} is missing", named(&absent))),
        _ => words.push(format!("{} are missing", named(&absent))),
    }
    for (shard, folder) in (1..=*parts).filter_map(is_there) {
        let runs = plan.shard(shard.part, shard.parts);
        let left = runs.iter().filter(|run| missing.contains(run)).count();
        if left > 0 {
            let runs = plural(left, "run", "runs");
            let folder = folder.display();
            words.push(format!("part {shard} in {folder} lacks {runs}"));
        }
    }
    words.join("; ")
}

/// So many are named one by one.
const FEW: usize = 8;

/// `parts 2/3 and 3/3`; empty for none.
fn named(shards: &[Shard]) -> String {
    let all: Vec<String> = shards.iter().map(Shard::to_string).collect();
    match all.split_last() {
        None => String::new(),
        Some((only, [])) => format!("part {only}"),
        Some(_) if all.len() > FEW => format!("parts {}", first_of(&all)),
        Some((last, others)) => format!("parts {} and {last}", others.join(", ")),
    }
}
