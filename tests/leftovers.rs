//! What others have left or put where the program reads and writes: it is told from what is its own.

#[path = "common/desk.rs"]
mod desk;

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use desk::{Desk, RUN, assert_refused_in_a_line, names, said};
use thallus::log::LogWriter;
use thallus::run::{Execution, Run, watch};

/// Commands that read a lichen on the mesh that its recipe names.
const ON_MESH: [&str; 4] = [
    "analyze ../out",
    "export ../out -o a.csv",
    "skin ../out -o a.ply",
    "render ../out -o a.png --size 32x24",
];

#[test]
fn another_mesh_of_the_name_is_not_taken_for_the_one_of_the_run() {
    let desk = Desk::new();
    desk.done(&format!("{RUN} -o out --quiet"));
    let longer = RUN.replace("3000", "4000");
    desk.done(&format!("{longer} -o whole --quiet"));
    fs::create_dir_all(desk.path("there/rock.obj")).unwrap();
    fs::create_dir(desk.path("here")).unwrap();
    let other = fs::read_to_string(desk.path("rock.obj")).unwrap();
    fs::write(desk.path("here/rock.obj"), other + "# another\n").unwrap();
    for folder in ["there", "here"] {
        for words in ON_MESH {
            let mut command = desk.call(words, "");
            let output = command.current_dir(desk.path(folder)).output().unwrap();
            let told = said(&output);
            assert!(output.status.success(), "{folder}, {words}: {told}");
            assert!(
                !told.contains("is not as it was"),
                "{folder}, {words}: {told}"
            );
        }
    }
    let mut command = desk.command("--resume ../out --elements 4000 --quiet");
    let output = command.current_dir(desk.path("here")).output().unwrap();
    assert!(output.status.success(), "{}", said(&output));
    desk.assert_same("out", "whole");
}

#[test]
fn a_picture_stays_where_nothing_more_grows() {
    let desk = Desk::new();
    let grow = |words: &str, preview: &str| {
        let mut command = desk.call(&format!("grow {words} --quiet"), preview);
        let output = command.output().unwrap();
        assert!(output.status.success(), "{words}: {}", said(&output));
        fs::read(desk.path("out/preview.png")).ok()
    };
    let taken = grow(&format!("{RUN} -o out"), "--preview 32");
    assert!(taken.is_some());
    assert_eq!(grow("--resume out", "--preview 0"), taken);
    let longer = "--resume out --elements 3010";
    assert_eq!(grow(longer, "--preview 0"), None);
}

/// The log of a run that was killed when it had three elements.
fn young_log(desk: &Desk, run: &str) -> Vec<u8> {
    let (substrate, recipe, log) = desk.begin_log("rock.obj", run, "young.log");
    let (log, begun) = LogWriter::open(log).unwrap();
    let stop = watch(|_, progress| match progress.elements {
        3 => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    });
    let run = Run::new(&substrate, &recipe, begun).unwrap();
    let mut watchers = (log, stop);
    run.grow(&Execution::default(), &mut watchers);
    watchers.0.finish().unwrap();
    desk.read("young.log")
}

/// A killed run has neither elements.ply nor a picture: who has put one there is asked to move it.
#[test]
fn a_killed_run_does_not_replace_what_it_has_not_written() {
    let desk = Desk::new();
    desk.done(&format!("{RUN} -o whole --quiet"));
    desk.done(&format!("{RUN} --seed 2 -o other --quiet"));
    let log = desk.read("whole/run.log");
    let put = |log: &[u8]| desk.put_log("whole", "out", log);
    let half = &log[..log.len() / 2];
    let young = young_log(&desk, "whole");
    for (name, foreign, log) in [
        ("elements.ply", desk.read("other/elements.ply"), half),
        ("elements.ply", desk.read("other/elements.ply"), &young),
        ("elements.ply", b"a model of something".to_vec(), half),
        ("preview.png", b"a picture".to_vec(), half),
    ] {
        put(log);
        fs::write(desk.path("out").join(name), &foreign).unwrap();
        desk.fails(
            "--resume out",
            1,
            &[name, "would replace it", "move it away"],
        );
        assert!(desk.read(&format!("out/{name}")) == foreign);
        fs::remove_dir_all(desk.path("out")).unwrap();
    }
    // Another run's report does not make its lichen this one's.
    put(&young);
    for name in ["elements.ply", "report.json"] {
        fs::copy(desk.path("other").join(name), desk.path("out").join(name)).unwrap();
    }
    desk.fails("--resume out", 1, &["elements.ply", "another lichen"]);
    fs::remove_dir_all(desk.path("out")).unwrap();
    // As it is when the run is killed while the files are put in their places.
    for there in [&["elements.ply"][..], &["elements.ply", "preview.png"]] {
        put(&log);
        for name in there {
            fs::write(
                desk.path("out").join(name),
                desk.read(&format!("whole/{name}")),
            )
            .unwrap();
        }
        desk.done("--resume out --quiet");
        desk.assert_same("out", "whole");
        fs::remove_dir_all(desk.path("out")).unwrap();
    }
}

/// Waits until a folder has so many files.
fn wait_for_files(folder: &Path, number: usize) {
    let patience = Instant::now() + Duration::from_secs(60);
    while fs::read_dir(folder).map_or(0, Iterator::count) != number {
        assert!(Instant::now() < patience, "not {number} files");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Killed without warning while a file is written: the next one that is written there clears the rest, and spares
/// what is still being written.
#[test]
fn half_a_file_of_a_killed_program_is_cleared_by_the_next() {
    let desk = Desk::new();
    desk.done(&format!("{RUN} -o out --quiet"));
    let to = desk.path("to");
    fs::create_dir(&to).unwrap();
    let start = |name: &str| {
        let words = format!("out -o to/{name}.gif --frames 2000 --quiet");
        desk.call("animate", &words).spawn().unwrap()
    };
    let mut living = start("a");
    wait_for_files(&to, 1);
    let spared = names(&to).remove(0);
    let mut killed = start("b");
    wait_for_files(&to, 2);
    killed.kill().unwrap();
    killed.wait().unwrap();
    let export = |name: &str| {
        let mut command = desk.call("export", &format!("out -o to/{name}.csv"));
        let status = command.stdout(Stdio::null()).status();
        assert!(status.unwrap().success());
    };
    export("c");
    assert!(living.try_wait().unwrap().is_none(), "it has ended");
    assert_eq!(names(&to), [spared.as_str(), "c.csv"]);
    living.kill().unwrap();
    living.wait().unwrap();
    export("d");
    assert_eq!(names(&to), ["c.csv", "d.csv"]);
}

#[cfg(unix)]
#[test]
fn frames_that_are_interrupted_twice_leave_nothing() {
    let desk = Desk::new();
    desk.done("rock.obj --radius 0.2% --elements 20000 -o out --quiet");
    let words = "out -o new/film --frames 400 --what skin";
    let mut child = desk.call("animate", words);
    let mut child = child.stderr(Stdio::null()).spawn().unwrap();
    let patience = Instant::now() + Duration::from_secs(30);
    while !desk.path("new/film/.thallus-run/files").exists() && Instant::now() < patience {
        std::thread::sleep(Duration::from_millis(1));
    }
    std::thread::sleep(Duration::from_millis(50));
    let id = child.id().to_string();
    while child.try_wait().unwrap().is_none() {
        let _ = Command::new("kill").args(["-INT", &id]).status();
        std::thread::sleep(Duration::from_millis(1));
    }
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(names(desk.0.path()), ["out", "rock.obj"]);
}

#[cfg(unix)]
#[test]
fn what_stands_in_the_way_is_named() {
    use std::os::unix::fs::symlink;
    let desk = Desk::new();
    fs::create_dir_all(desk.path("lock/.thallus-run")).unwrap();
    symlink("/no/such/place", desk.path("lock/.thallus-run/lock")).unwrap();
    fs::create_dir(desk.path("hidden")).unwrap();
    symlink("/no/such/place", desk.path("hidden/.thallus-run")).unwrap();
    fs::create_dir(desk.path("run")).unwrap();
    symlink("recipe.toml", desk.path("run/recipe.toml")).unwrap();
    for (words, parts) in [
        (format!("{RUN} -o lock"), ["lock", "No such file"]),
        (
            format!("{RUN} -o hidden"),
            ["hidden/.thallus-run", "a link that leads nowhere"],
        ),
        (
            "--resume run".to_owned(),
            ["run/recipe.toml", "reading the recipe failed"],
        ),
    ] {
        let output = desk.command(&words).output().unwrap();
        assert_refused_in_a_line(&output, 1, &parts);
    }
}
