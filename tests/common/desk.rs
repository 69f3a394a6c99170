//! A folder in which the real program grows.
#![allow(dead_code, reason = "each test crate uses its own part of this")]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

use serde_json::Value;
use tempfile::TempDir;
use thallus::log::{Log, head};
use thallus::run::{Recipe, Settings};
use thallus::substrate::Substrate;

#[path = "words.rs"]
mod words;

use words::{as_elsewhere, says};

/// A folder to work in, with a mesh.
pub(crate) struct Desk(pub(crate) TempDir);

/// Every file of a run whose bytes are promised.
pub(crate) const PROMISED: [&str; 4] = ["elements.ply", "recipe.toml", "preview.png", "run.log"];

/// What a run of these tests is by default.
pub(crate) const RUN: &str = "rock.obj --radius 0.2% --elements 3000";

impl Desk {
    pub(crate) fn new() -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        let rock = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes/rock.obj");
        fs::copy(rock, desk.path("rock.obj")).unwrap();
        desk
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// `thallus grow` with these words, on one thread.
    pub(crate) fn command(&self, words: &str) -> Command {
        self.command_on(1, words)
    }

    /// The same on some threads.
    pub(crate) fn command_on(&self, threads: usize, words: &str) -> Command {
        let grow = format!("grow --preview 32 --threads {threads}");
        let mut command = self.call(&grow, words);
        command.stdout(Stdio::null());
        command
    }

    /// A command of the program, with these words.
    pub(crate) fn call(&self, name: &str, words: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_thallus"));
        command
            .args(name.split_whitespace())
            .args(words.split_whitespace())
            .current_dir(self.0.path());
        command
    }

    /// Grows what must succeed, and gives what it said.
    pub(crate) fn done(&self, words: &str) -> String {
        self.done_on(1, words)
    }

    /// The same on some threads.
    pub(crate) fn done_on(&self, threads: usize, words: &str) -> String {
        let output = self.command_on(threads, words).output().unwrap();
        assert!(output.status.success(), "{words}: {}", said(&output));
        said(&output)
    }

    /// Grows what must fail with this code and say these words.
    pub(crate) fn fails(&self, words: &str, code: i32, parts: &[&str]) {
        assert_refused(&self.command(words).output().unwrap(), code, parts);
    }

    pub(crate) fn assert_same_elements(&self, found: &str, expected: &str) {
        let [found, expected] =
            [found, expected].map(|folder| self.read(&format!("{folder}/elements.ply")));
        assert!(found == expected);
    }

    pub(crate) fn start(&self, words: &str) -> Child {
        self.start_on(1, words)
    }

    pub(crate) fn start_on(&self, threads: usize, words: &str) -> Child {
        let mut command = self.command_on(threads, words);
        command.stderr(Stdio::null()).spawn().unwrap()
    }

    pub(crate) fn log(&self, folder: &str) -> Log {
        Log::read(&self.path(folder).join("run.log")).unwrap()
    }

    /// The report without what is not promised.
    pub(crate) fn report(&self, folder: &str) -> Value {
        let text = self.read(&format!("{folder}/report.json"));
        let mut report: Value = serde_json::from_slice(&text).unwrap();
        for how in ["seconds", "threads", "parallel", "serial_share"] {
            report[how].take();
        }
        report
    }

    /// Whether two runs left the same files, all of them.
    pub(crate) fn assert_same(&self, found: &str, expected: &str) {
        for file in PROMISED {
            let same =
                self.read(&format!("{found}/{file}")) == self.read(&format!("{expected}/{file}"));
            assert!(same, "{found}/{file}");
        }
        assert_eq!(self.report(found), self.report(expected), "{found}");
        assert_eq!(names(&self.path(found)), names(&self.path(expected)));
    }

    /// The mesh, the recipe and a log without elements, for a run like another on a mesh of this name.
    pub(crate) fn begin_log(&self, mesh: &str, run: &str, log: &str) -> (Substrate, Recipe, Log) {
        let substrate = Substrate::load(&self.path(mesh)).unwrap();
        let settings = Settings::read(&self.path(&format!("{run}/recipe.toml"))).unwrap();
        let recipe = settings.resolve(&substrate, mesh).unwrap();
        fs::write(self.path(log), head(&recipe)).unwrap();
        (substrate, recipe, Log::read(&self.path(log)).unwrap())
    }

    /// A finished run's folder with other bytes as its log, and nothing that only a finished run has.
    pub(crate) fn put_log(&self, run: &str, folder: &str, log: &[u8]) {
        let _ = fs::remove_dir_all(self.path(folder));
        fs::create_dir(self.path(folder)).unwrap();
        let recipe = |folder: &str| self.path(folder).join("recipe.toml");
        fs::copy(recipe(run), recipe(folder)).unwrap();
        fs::write(self.path(folder).join("run.log"), log).unwrap();
    }
}

pub(crate) fn said(output: &Output) -> String {
    as_elsewhere(&output.stderr)
}

pub(crate) fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let name = |e: std::io::Result<fs::DirEntry>| e.unwrap().file_name().into_string().unwrap();
    let mut names: Vec<_> = entries.map(name).collect();
    names.sort();
    names
}

/// The program ended with this code and said these words, and not by a panic.
pub(crate) fn assert_refused(output: &Output, code: i32, parts: &[&str]) {
    let said = said(output);
    assert_eq!(output.status.code(), Some(code), "{said}");
    for part in parts {
        assert!(says(&said, part), "'{part}' not in: {said}");
    }
    assert!(!said.contains("panicked"), "{said}");
}

/// The same, in one line.
pub(crate) fn assert_refused_in_a_line(output: &Output, code: i32, parts: &[&str]) {
    assert_refused(output, code, parts);
    assert_eq!(said(output).lines().count(), 1, "{}", said(output));
}

/// Names of all that a JSON says, those within others as `outer.inner`.
pub(crate) fn fields(json: &Value, within: &str, found: &mut BTreeSet<String>) {
    let Value::Object(map) = json else {
        found.insert(within.to_owned());
        return;
    };
    for (name, value) in map {
        let dot = if within.is_empty() { "" } else { "." };
        fields(value, &format!("{within}{dot}{name}"), found);
    }
}
