//! What a sweep finds in the folder of a run, and makes of it.

use std::fs;
use std::ops::ControlFlow;

use thallus::log::{Log, LogWriter};
use thallus::run::{Execution, Observer, Run, watch};

use super::desk::{Desk, said};
use super::{GRID, LONG, assert_same, desk, done, refused};

/// Runs that take no time.
pub(crate) const SMALL: &str =
    "plane.obj --L 5r,10r --radius 0.4% --elements 60 --size 48x40 --samples 1 --quiet";

/// Measures are of the lichen that they lie beside, and what a user grew in a sweep's folder is theirs.
#[test]
fn another_lichen_in_the_place_of_a_finished_run_is_told_and_kept() {
    let desk = desk();
    done(&desk, &format!("{SMALL} -o clean"));
    let sweep = format!("{SMALL} -o out");
    let run = "out/cells/L=5r/seed-1";
    let grow = |words: &str| {
        let output = desk
            .call("grow --quiet --preview 16", words)
            .output()
            .unwrap();
        assert!(output.status.success(), "{words}: {}", said(&output));
    };
    let cut = || {
        let file = desk.path(&format!("{run}/elements.ply"));
        let text = fs::read(&file).unwrap();
        fs::write(&file, [&text[..], b"\n"].concat()).unwrap();
    };
    let resumed = format!("plane.obj --resume {run} --elements 90");
    let forced = format!("plane.obj -o {run} --force --radius 0.4% --elements 60 --bias 0.9");
    let changes: [(&str, &dyn Fn(), &str); 3] = [
        (
            "resumed",
            &|| grow(&resumed),
            "the size was elements = 60 and is elements = 90",
        ),
        ("forced", &|| grow(&forced), "bias was 0.5 and is 0.9"),
        (
            "cut",
            &cut,
            "elements.ply was changed or damaged after it was measured",
        ),
    ];
    for (name, change, told) in changes {
        done(&desk, &sweep);
        change();
        let elements = desk.read(&format!("{run}/elements.ply"));
        let parts = [
            "1 run failed: L=5r seed 1",
            "L=5r/seed-1 holds another lichen than this sweep's",
            told,
            "--only L=5r",
        ];
        refused(&desk, &sweep, 1, &parts);
        assert!(
            desk.read(&format!("{run}/elements.ply")) == elements,
            "{name}: it is kept"
        );
        let csv = String::from_utf8(desk.read("out/results.csv")).unwrap();
        assert_eq!(csv.matches(",failed,").count(), 1, "{name}: {csv}");
        let words = "merge out clean -o joined --quiet";
        refused(
            &desk,
            words,
            1,
            &[told, "leave that part out", "nothing was written"],
        );
        assert!(!desk.path("joined").exists(), "{name}");
        let words = "merge clean out -o out --quiet";
        refused(&desk, words, 1, &[told]);
        assert!(
            desk.read(&format!("{run}/elements.ply")) == elements,
            "{name}: not merged over"
        );
        // Both cures.
        match name {
            "forced" => fs::rename(desk.path(run), desk.path("mine")).unwrap(),
            _ => drop(done(&desk, &format!("{sweep} --only L=5r"))),
        }
        done(&desk, &sweep);
        let _ = fs::remove_file(desk.path(&format!("{run}/preview.png")));
        assert_same(&desk, "out", "clean");
    }
}

/// By a program that did not look at elements, or changed since: the lichen is the sweep's, and is measured again.
#[test]
fn a_record_that_is_not_whole_is_made_again() {
    let desk = desk();
    done(&desk, &format!("{SMALL} -o clean"));
    done(&desk, &format!("{SMALL} -o out"));
    let file = desk.path("out/cells/L=5r/seed-1/measures.json");
    let text = fs::read_to_string(&file).unwrap();
    let hashless = |line: &&str| !line.contains("elements_hash");
    let hashless: Vec<&str> = text.lines().filter(hashless).collect();
    let changed = text.replacen("\"value\": ", "\"value\": 1", 1);
    for other in [hashless.join("\n"), changed] {
        assert!(other != text);
        fs::write(&file, other).unwrap();
        done(&desk, &format!("{SMALL} -o out"));
        assert_same(&desk, "out", "clean");
        assert!(fs::read_to_string(&file).unwrap() == text);
    }
}

/// The log of a run that was killed, durable after every 500 elements, and damaged in the second 500.
pub(crate) fn damaged_log(desk: &Desk, run: &str) -> Vec<u8> {
    let file = desk.path("killed.log");
    let (substrate, recipe, log) = desk.begin_log("plane.obj", run, "killed.log");
    let (mut log, begun) = LogWriter::open(log).unwrap();
    let mut lengths = Vec::new();
    let mut watching = watch(|element, progress| {
        let _ = log.born(element, progress);
        if progress.elements.is_multiple_of(500) {
            log.finish().unwrap();
            lengths.push(file.metadata().unwrap().len() as usize);
        }
        match lengths.len() {
            4 => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        }
    });
    let begun = Run::new(&substrate, &recipe, begun).unwrap();
    begun.grow(&Execution::default(), &mut watching);
    let mut bytes = fs::read(&file).unwrap();
    bytes[lengths[0] + 50] ^= 1;
    bytes
}

/// What is sound of a log is gone on with, and what is not is told; a log that cannot be read is no reason to
/// begin anew.
#[test]
fn a_damaged_log_is_told_and_one_that_cannot_be_read_is_an_error() {
    let desk = desk();
    let grid = LONG
        .replace("--L 5r,10r,20r --B 0.3,0.9", "--L 5r,10r")
        .replace("--quiet", "");
    done(&desk, &format!("{grid} -o clean"));
    done(&desk, &format!("{grid} -o out"));
    let run = "out/cells/L=5r/seed-1";
    let log = desk.path(&format!("{run}/run.log"));
    let whole = fs::read(&log).unwrap();
    let unfinished = |bytes: &[u8]| {
        for name in ["measures.json", "elements.ply", "report.json"] {
            fs::remove_file(desk.path(&format!("{run}/{name}"))).unwrap();
        }
        fs::write(&log, bytes).unwrap();
    };
    let flipped = |at: usize| {
        let mut bytes = whole.clone();
        bytes[at] ^= 1;
        bytes
    };
    let block = Log::read(&log).unwrap().sound_bytes as usize;
    let from = "goes on from the 500 elements before that";
    let cases = [
        (flipped(block - 20), None),
        (flipped(30), Some("run.log is damaged at its head")),
        (Vec::new(), Some("run.log is damaged at its head")),
        (damaged_log(&desk, run), Some(from)),
    ];
    for (bytes, told) in cases {
        unfinished(&bytes);
        let output = done(&desk, &format!("{grid} -o out"));
        let said = said(&output);
        assert_eq!(said.contains("damaged"), told.is_some(), "{said}");
        assert!(said.contains(told.unwrap_or_default()), "{said}");
        assert_same(&desk, "out", "clean");
    }

    unfinished(&whole);
    fs::remove_file(&log).unwrap();
    fs::create_dir(&log).unwrap();
    let parts = [
        "1 run failed: L=5r seed 1",
        "run.log: reading the log failed",
    ];
    refused(&desk, &format!("{grid} -o out"), 1, &parts);
    assert!(log.is_dir());
    fs::remove_dir(&log).unwrap();

    // Of another recipe.
    fs::copy(desk.path("out/cells/L=10r/seed-1/run.log"), &log).unwrap();
    let parts = [
        "run.log is of another run than this sweep's: curvature-radius was",
        "--only L=5r",
    ];
    refused(&desk, &format!("{grid} -o out"), 1, &parts);
    fs::remove_file(&log).unwrap();
    done(&desk, &format!("{grid} -o out"));
    assert_same(&desk, "out", "clean");
}

#[test]
fn another_grid_in_the_folder_is_refused() {
    let desk = desk();
    done(&desk, &format!("{GRID} -o out --only L=5r_B=0.3"));
    let grid = desk.read("out/grid.toml");
    for (old, new, part) in [
        ("--seeds 2", "--seeds 3", "seeds was 2 and is 3"),
        ("5r,10r", "5r,20r", "axes were"),
        ("18r", "19r", "the size was reach = \"18.0r\""),
        ("0.4%", "0.5%", "radius was"),
        ("plane.obj", "rock.obj", "mesh-hash was"),
    ] {
        refused(
            &desk,
            &format!("{} -o out", GRID.replace(old, new)),
            1,
            &["out holds another sweep", part, "choose another folder"],
        );
    }
    assert!(desk.read("out/grid.toml") == grid);
    fs::create_dir(desk.path("full")).unwrap();
    fs::write(desk.path("full/notes.txt"), "mine").unwrap();
    refused(&desk, &format!("{GRID} -o full"), 1, &["full is not empty"]);
}
