//! Says which commit the program is built from: `THALLUS_BUILD`, as `0123456789ab` or `0123456789ab-dirty`, and
//! `THALLUS_VERSION`, which has both. Without git, or outside of a repository that tracks this package, there is no
//! `THALLUS_BUILD`, and the build goes on.

use std::env;
use std::fmt::Display;
use std::io::{self, Write};
use std::path::Path;
use std::process::Command;

/// What decides the program: with another text of these it is another one.
const SOURCES: [&str; 4] = ["src", "build.rs", "Cargo.toml", "Cargo.lock"];

fn main() {
    let version = env::var("CARGO_PKG_VERSION").unwrap_or_default();
    SOURCES.into_iter().for_each(watch);
    let commit = commit();
    let version = match &commit {
        Some(commit) => format!("{version} ({commit})"),
        None => version,
    };
    if let Some(commit) = commit {
        tell("rustc-env=THALLUS_BUILD", commit);
    }
    tell("rustc-env=THALLUS_VERSION", version);
}

/// The commit that is checked out, where this package is part of it, and a mark where its sources are not those of it.
fn commit() -> Option<String> {
    // A copy that somebody keeps untracked in a repository of their own is not of that repository's commit.
    git(&["ls-files", "--error-unmatch", "Cargo.toml"])?;
    let commit = git(&["rev-parse", "--short=12", "HEAD"])?;
    // Where nothing but other files was committed, an earlier commit has the same sources: programs for tests, which
    // take minutes to build, may name that one.
    if env::var("PROFILE").is_ok_and(|profile| profile == "release") {
        watch_head();
    }
    let mut status = vec!["--no-optional-locks", "status", "--porcelain", "-uno", "--"];
    status.extend(SOURCES);
    match git(&status)?.is_empty() {
        true => Some(commit),
        false => Some(commit + "-dirty"),
    }
}

/// Looks again when another commit is checked out. A ref that was packed has no file of its own until it moves, but the
/// log of all moves has.
fn watch_head() {
    let branch = git(&["symbolic-ref", "--quiet", "HEAD"]);
    let names = ["HEAD", "logs/HEAD", "packed-refs"];
    for name in names.into_iter().chain(branch.as_deref()) {
        if let Some(file) = git(&["rev-parse", "--git-path", name]) {
            watch(&file);
        }
    }
}

/// Asks for another look when a file changes. What is not there would ask for one every time.
fn watch(file: &str) {
    if Path::new(file).exists() {
        tell("rerun-if-changed", file);
    }
}

/// What git says, if there is one and it has no objection. Cargo calls this in the package's folder; hooks name their
/// own repository in the environment.
fn git(words: &[&str]) -> Option<String> {
    let mut git = Command::new("git");
    git.env_remove("GIT_DIR").env_remove("GIT_INDEX_FILE");
    let output = git.args(words).output().ok()?;
    let said = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| said.trim().to_owned())
}

/// An instruction for cargo, which has gone if it cannot be written.
fn tell(what: &str, value: impl Display) {
    let _ = writeln!(io::stdout(), "cargo::{what}={value}");
}
