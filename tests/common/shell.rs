//! The real program in a folder of its own, and small meshes to give it.
#![allow(dead_code, reason = "each test crate uses its own part of this")]

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use tempfile::TempDir;

#[path = "words.rs"]
mod words;

use words::{as_elsewhere, says};

/// A folder to work in, with a plane of two triangles and a bumpy sheet.
pub(crate) struct Desk(pub(crate) TempDir);

pub(crate) const PLANE: &str = "v 0 0 0\nv 10 0 0\nv 10 0 10\nv 0 0 10\nf 1 3 2\nf 1 4 3\n";

impl Desk {
    pub(crate) fn new() -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        desk.put("plane.obj", PLANE);
        desk
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn put(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).unwrap();
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub(crate) fn text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).unwrap()
    }

    pub(crate) fn command(&self, words: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_thallus"));
        command
            .args(words.split_whitespace())
            .current_dir(self.0.path());
        if words.starts_with("grow") && !words.contains("--help") {
            command.args(["--preview", "64"]); // a full picture takes longer than the growth
        }
        command
    }

    pub(crate) fn run(&self, words: &str) -> Ran {
        Ran::from(self.command(words).output().unwrap())
    }

    /// Runs what must succeed.
    pub(crate) fn done(&self, words: &str) -> Ran {
        let ran = self.run(words);
        assert_eq!(ran.code, 0, "thallus {words}\n{}", ran.err);
        ran
    }

    /// Runs what must fail with this code and say these words, not as a panic.
    pub(crate) fn fails(&self, words: &str, code: i32, said: &[&str]) {
        let ran = self.run(words);
        assert_eq!(ran.code, code, "thallus {words}\n{}", ran.err);
        for part in said {
            assert!(
                says(&ran.err, part),
                "thallus {words}\n'{part}' not in: {}",
                ran.err
            );
        }
        assert!(!ran.err.contains("panicked"), "{}", ran.err);
    }

    pub(crate) fn names_in(&self, folder: &str) -> Vec<String> {
        let entries = fs::read_dir(self.path(folder)).unwrap();
        let mut names: Vec<_> = entries
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

pub(crate) struct Ran {
    pub(crate) code: i32,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl From<Output> for Ran {
    fn from(output: Output) -> Self {
        Self {
            code: output.status.code().unwrap_or(-1),
            out: String::from_utf8(output.stdout).unwrap(),
            err: as_elsewhere(&output.stderr),
        }
    }
}

/// A grid of n x n quads over 10 x 10, which `height` lifts.
pub(crate) fn sheet(n: usize, height: impl Fn(usize, usize) -> f64) -> String {
    let step = 10.0 / n as f64;
    let mut obj = String::new();
    for i in 0..=n {
        for j in 0..=n {
            obj += &format!(
                "v {} {} {}\n",
                i as f64 * step,
                height(i, j),
                j as f64 * step
            );
        }
    }
    let vertex = |i: usize, j: usize| i * (n + 1) + j + 1;
    for i in 0..n {
        for j in 0..n {
            let (a, b) = (vertex(i, j), vertex(i, j + 1));
            let (c, d) = (vertex(i + 1, j + 1), vertex(i + 1, j));
            obj += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
        }
    }
    obj
}

pub(crate) fn bumpy() -> String {
    sheet(20, |i, j| ((i * 7 + j * 13) % 5) as f64 * 0.1)
}
