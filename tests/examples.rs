//! The examples do what they say.

use std::path::Path;

use thallus::export::read_elements;
use thallus::run::Stopped;

#[expect(dead_code, reason = "main")]
#[path = "../examples/files.rs"]
mod files;
#[expect(dead_code, reason = "main")]
#[path = "../examples/grow_and_print.rs"]
mod grow_and_print;
#[expect(dead_code, reason = "main")]
#[path = "../examples/in_memory.rs"]
mod in_memory;
#[expect(dead_code, reason = "main")]
#[path = "../examples/own_observer.rs"]
mod own_observer;
#[expect(dead_code, reason = "main")]
#[path = "../examples/own_stop_rule.rs"]
mod own_stop_rule;
#[expect(dead_code, reason = "main")]
#[path = "../examples/resume.rs"]
mod resume;

const ROCK: &str = "meshes/rock.obj";

#[test]
fn examples_that_print_come_to_an_end() {
    grow_and_print::run(ROCK).unwrap();
    own_observer::run(ROCK).unwrap();
    in_memory::run().unwrap();
}

#[test]
fn own_stop_rule_stops_by_its_rule() {
    let (elements, stopped) = own_stop_rule::run(ROCK).unwrap();
    assert_eq!(stopped, Stopped::Observer);
    assert!(elements > 100);
}

/// `resume` leaves a log, which is all that `files` needs of a run.
#[test]
fn resume_leaves_what_files_opens() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("run.log");
    let elements = resume::run(ROCK, &log).unwrap();
    assert_eq!(resume::run(ROCK, &log).unwrap(), elements);
    let name = folder.path().join("lichen");
    let name = name.to_str().unwrap();
    files::run(folder.path(), name).unwrap();
    let table = read_elements(Path::new(&format!("{name}.ply"))).unwrap();
    assert_eq!(table.len(), elements);
    let taken = files::run(folder.path(), name).unwrap_err();
    assert!(taken.to_string().contains("lichen.glb"), "{taken}");
}
