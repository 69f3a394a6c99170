//! Logs of finished runs that lost elements, and folders of runs as people handle them.
#![allow(clippy::print_stderr)] // a skipped test says so

#[path = "common/desk.rs"]
mod desk;

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use desk::{Desk, RUN, assert_refused_in_a_line, names, said};
use thallus::log::count_elements;

/// Waits until more than this many elements of a run are durable.
fn wait_for_more(log: &Path, than: u64) {
    let patience = Instant::now() + Duration::from_secs(60);
    while !count_elements(log).is_ok_and(|elements| elements > than) {
        assert!(Instant::now() < patience, "nothing became durable");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// What a run says that must end by itself.
fn ended(mut child: Child) -> Output {
    let patience = Instant::now() + Duration::from_secs(60);
    while child.try_wait().unwrap().is_none() {
        if Instant::now() > patience {
            kill(child);
            panic!("it goes on");
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    child.wait_with_output().unwrap()
}

fn kill(mut child: Child) {
    child.kill().unwrap();
    child.wait().unwrap();
}

/// All files of a folder by name.
fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let names = names(folder).into_iter();
    names
        .map(|name| (name.clone(), fs::read(folder.join(name)).unwrap()))
        .collect()
}

/// One that is named with `--mesh` is taken as it is.
#[test]
fn a_mesh_that_has_changed_since_is_told_of() {
    let desk = Desk::new();
    desk.done(&format!("{RUN} -o out"));
    let tells = |words: &str| {
        let output = desk.call(words, "").output().unwrap();
        assert!(output.status.success(), "{words}: {}", said(&output));
        said(&output).contains("rock.obj is not as it was when this grew")
    };
    let commands = [
        "analyze out",
        "export out -o a.csv --force",
        "skin out -o a.ply --force",
        "render out -o a.png --size 32x24 --force",
        "animate out -o film --frames 1 --force",
    ];
    assert!(!commands.into_iter().any(tells));
    let edited = [desk.read("rock.obj"), b"# edited\n".to_vec()].concat();
    fs::write(desk.path("rock.obj"), edited).unwrap();
    for words in commands {
        assert!(tells(words), "{words}");
        assert!(!tells(&format!("{words} --mesh rock.obj")), "{words}");
        assert!(!tells(&format!("{words} --quiet")), "{words}");
    }
}

#[test]
fn the_folder_of_a_run_stands_for_its_recipe() {
    let desk = Desk::new();
    desk.done(&format!("{RUN} -o out"));
    desk.done("--recipe out -o again");
    desk.assert_same("again", "out");
}

/// A finished run of 3000 elements in `out`, the same in `whole`, and a log of its first 2000.
struct Finished {
    desk: Desk,
    log: Vec<u8>,
    shorter: Vec<u8>,
}

impl Finished {
    fn new() -> Self {
        let desk = Desk::new();
        for (folder, elements) in [("out", 3000), ("whole", 3000), ("short", 2000)] {
            desk.done(&format!(
                "rock.obj --radius 0.2% --elements {elements} -o {folder} --quiet"
            ));
        }
        let (log, shorter) = (desk.read("out/run.log"), desk.read("short/run.log"));
        Self { desk, log, shorter }
    }

    fn put(&self, log: &[u8]) {
        fs::write(self.desk.path("out/run.log"), log).unwrap();
    }

    /// Logs that lost elements, with how many are lost.
    fn damaged(&self) -> Vec<(Vec<u8>, &'static str)> {
        let whole = &self.log;
        let cut = |length: usize| whole[..length].to_vec();
        let flipped = |at: usize| {
            let mut bytes = whole.clone();
            bytes[at] ^= 16;
            bytes
        };
        let last = whole.len() - 1;
        let longer = [&self.shorter[..], &whole[last - 5000..]].concat();
        vec![
            (cut(last), "3,000 of its elements are gone"),
            (cut(whole.len() / 2), "3,000 of its elements are gone"),
            (flipped(whole.len() / 2), "3,000 of its elements are gone"),
            (flipped(last), "3,000 of its elements are gone"),
            (self.shorter.clone(), "1,000 of its elements are gone"),
            (longer, "1,000 of its elements are gone"),
        ]
    }
}

#[test]
fn a_finished_run_whose_log_lost_elements_grows_them_again() {
    let finished = Finished::new();
    let desk = &finished.desk;
    for (i, (log, lost)) in finished.damaged().iter().enumerate() {
        finished.put(log);
        let before = files(&desk.path("out"));
        desk.fails(
            "--resume out --elements 2500",
            2,
            &["2500 are asked for", "3000 elements"],
        );
        assert!(files(&desk.path("out")) == before, "{i}");
        let said = desk.done("--resume out");
        assert!(said.contains(lost), "{i}: {said}");
        assert!(!said.contains("as a killed run leaves it"), "{said}");
        desk.assert_same("out", "whole");
    }
}

/// Then the table says how many elements there were, if it can be read.
#[test]
fn a_report_that_cannot_be_read_is_no_run_that_has_not_ended() {
    let finished = Finished::new();
    let desk = &finished.desk;
    let last = finished.shorter.len() - 1;
    finished.put(&finished.shorter[..last]);
    fs::write(desk.path("out/report.json"), "{").unwrap();
    let fewer = "--resume out --elements 2500";
    let before = files(&desk.path("out"));
    desk.fails(fewer, 2, &["2500 are asked for", "3000 elements"]);
    assert!(files(&desk.path("out")) == before);
    let said = desk.done("--resume out");
    assert!(said.contains("3,000 of its elements are gone"), "{said}");
    desk.assert_same("out", "whole");

    finished.put(&finished.shorter[..last]);
    fs::write(desk.path("out/report.json"), "{}").unwrap();
    fs::write(desk.path("out/elements.ply"), "ply").unwrap();
    let parts = [
        "report.json: it has no number of elements",
        "move that file away",
    ];
    desk.fails(fewer, 1, &parts);
}

/// With a reach the end is not known before.
#[test]
fn fewer_elements_never_take_the_place_of_a_finished_run() {
    let finished = Finished::new();
    let desk = &finished.desk;
    finished.put(&finished.shorter);
    let radius = |folder: &str| desk.report(folder)["effective_radius"].as_f64().unwrap();
    let between = 0.5 * (radius("short") + radius("out"));
    desk.fails(
        &format!("--resume out --reach {between}"),
        1,
        &["before it had the 3,000", "whose files stay"],
    );
    let table = |folder: &str| desk.read(&format!("{folder}/elements.ply"));
    assert!(table("out") == table("whole"));
    assert_eq!(desk.report("out")["elements"], 3000);
    desk.done("--resume out --quiet --elements 3000");
    desk.assert_same("out", "whole");
}

#[cfg(unix)]
#[test]
fn an_interrupt_on_the_way_back_leaves_the_finished_run() {
    let desk = Desk::new();
    let run = "rock.obj --radius 0.2% --quiet";
    desk.done(&format!("{run} --elements 40000 -o whole"));
    desk.done(&format!("{run} --elements 40000 -o out"));
    desk.done(&format!("{run} --elements 1000 -o short"));
    fs::copy(desk.path("short/run.log"), desk.path("out/run.log")).unwrap();
    let mut command = desk.command("--resume out --quiet");
    let child = command.stderr(Stdio::piped()).spawn().unwrap();
    wait_for_more(&desk.path("out/run.log"), 1000);
    let id = child.id().to_string();
    let kill = Command::new("kill").args(["-INT", &id]).status();
    assert!(kill.unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", said(&output));
    let told = said(&output);
    assert!(
        told.contains("interrupted") && told.contains("files stay"),
        "{told}"
    );
    // The recipe says as many already, or more.
    assert!(
        told.contains("--resume out") && !told.contains("--elements"),
        "{told}"
    );
    let table = |folder: &str| desk.read(&format!("{folder}/elements.ply"));
    assert!(table("out") == table("whole"));
    desk.done("--resume out --quiet");
    desk.assert_same("out", "whole");
}

/// Commands that read a lichen, and where they write it.
const READERS: [(&str, &str, &str); 6] = [
    ("skin", "-o READ.ply --quiet", "READ.ply"),
    ("export", "-o READ.csv", "READ.csv"),
    (
        "render",
        "-o READ.png --size 32x24 --samples 1 --quiet",
        "READ.png",
    ),
    ("animate", "-o READ.glb --frames 2 --quiet", "READ.glb"),
    ("bake", "-o READ --size 32 --quiet", "READ/base_color.png"),
    ("analyze", "--json --quiet", ""),
];

/// What each of them makes of `out`, and says.
fn read_by_all(desk: &Desk) -> Vec<(Output, Vec<u8>)> {
    let read = |(name, words, made): &(&str, &str, &str)| {
        let output = desk.call(name, &format!("out {words}")).output().unwrap();
        assert!(output.status.success(), "{name}: {}", said(&output));
        let made = match made.is_empty() {
            true => Vec::new(),
            false => desk.read(made),
        };
        for leftover in ["READ.ply", "READ.csv", "READ.png", "READ.glb"] {
            let _ = fs::remove_file(desk.path(leftover));
        }
        let _ = fs::remove_dir_all(desk.path("READ"));
        (output, made)
    };
    READERS.iter().map(read).collect()
}

/// A square with texture coordinates, for `bake`.
const SQUARE: &str =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";

#[test]
fn what_reads_a_finished_run_has_all_of_it_whatever_its_log() {
    let desk = Desk::new();
    fs::write(desk.path("square.obj"), SQUARE).unwrap();
    desk.done("square.obj --radius 1% --elements 400 -o out --quiet");
    let expected = read_by_all(&desk);
    let log = desk.read("out/run.log");
    let mut flipped = log.clone();
    flipped[log.len() / 2] ^= 1;
    for log in [&log[..log.len() / 2], &log[..log.len() - 1], &flipped, &[]] {
        fs::write(desk.path("out/run.log"), log).unwrap();
        assert!(read_by_all(&desk) == expected, "{} bytes", log.len());
    }
}

#[test]
fn what_reads_a_table_that_was_cut_refuses() {
    let desk = Desk::new();
    fs::write(desk.path("square.obj"), SQUARE).unwrap();
    desk.done("square.obj --radius 1% --elements 400 -o out --quiet");
    let table = desk.read("out/elements.ply");
    for length in [table.len() - 1, table.len() / 2, 40, 0] {
        fs::write(desk.path("out/elements.ply"), &table[..length]).unwrap();
        for (name, words, _) in READERS {
            let output = desk.call(name, &format!("out {words}")).output().unwrap();
            assert_refused_in_a_line(&output, 1, &["elements.ply"]);
        }
    }
}

/// `elements.ply` is still that of the run before, and the recipe says more.
#[test]
fn a_run_that_was_killed_while_it_was_extended_is_told_of() {
    let desk = Desk::new();
    desk.done(&format!("{RUN} -o out --quiet"));
    let table = desk.read("out/elements.ply");
    let say = |name: &str, words: &str| {
        let output = desk.call(name, &format!("out {words}")).output().unwrap();
        assert!(output.status.success(), "{name}: {}", said(&output));
        said(&output)
    };
    let all = || {
        [
            say("export", "-o a.csv"),
            say("skin", "-o a.ply --resolution 2r --force"),
            say("analyze", ""),
            say("render", "-o a.png --size 32x24 --samples 1 --force"),
            say("animate", "-o a.glb --frames 2 --resolution 2r --force"),
        ]
    };
    assert!(!all().concat().contains("extended"));
    let child = desk.start("--resume out --elements 2000000 --quiet");
    wait_for_more(&desk.path("out/run.log"), 3000);
    kill(child);
    assert!(desk.read("out/elements.ply") == table);
    fs::remove_file(desk.path("a.csv")).unwrap();
    for told in all() {
        assert!(
            told.contains("the 3,000 elements of the run before it was extended")
                && told.contains("grow --resume out goes on"),
            "{told}"
        );
    }
    assert_eq!(say("analyze", "--quiet"), "");
    let more = desk.log("out").begun.elements.len() + 100;
    desk.done(&format!("--resume out --elements {more} --quiet"));
    fs::remove_file(desk.path("a.csv")).unwrap();
    assert!(!all().concat().contains("extended"));
}

#[test]
fn a_log_that_is_none_is_refused_and_nothing_is_touched() {
    let desk = Desk::new();
    desk.done(&format!("{RUN} -o out --quiet"));
    let log = desk.path("out/run.log");
    for (content, part) in [
        (&b""[..], "is not a log of thallus"),
        (&[0; 4096], "is not a log of thallus"),
        (&desk.read("rock.obj"), "is not a log of thallus"),
        (
            &desk.read("out/run.log")[..30],
            "head of the log is damaged",
        ),
    ] {
        fs::write(&log, content).unwrap();
        let before = files(&desk.path("out"));
        for flags in ["", " --keep-sound"] {
            desk.fails(&format!("--resume out{flags}"), 1, &["run.log", part]);
        }
        assert!(files(&desk.path("out")) == before, "{part}");
    }
    fs::remove_file(&log).unwrap();
    fs::create_dir(&log).unwrap();
    desk.fails("--resume out", 1, &["run.log", "this is a folder"]);
    assert!(names(&log).is_empty());
}

/// A recipe whose size was changed by hand is asked for like one that is given.
#[test]
fn a_size_changed_in_the_recipe_counts() {
    let desk = Desk::new();
    desk.done(&format!("{RUN} -o out --quiet"));
    let text = String::from_utf8(desk.read("out/recipe.toml")).unwrap();
    let put = |size: &str| {
        let changed = text.replace("elements = 3000", size);
        assert_ne!(changed, text);
        fs::write(desk.path("out/recipe.toml"), changed).unwrap();
    };
    put("elements = 2000");
    desk.fails("--resume out", 2, &["3000 elements already"]);
    put("reach = 0.0001");
    desk.fails("--resume out", 2, &["3000 elements already"]);
    put("elements = 3500");
    desk.done("--resume out --quiet");
    desk.done("rock.obj --radius 0.2% --elements 3500 -o whole --quiet");
    desk.assert_same("out", "whole");
}

/// Times of files say nothing about which is newer: clocks are set back, and copies change them.
#[test]
fn times_of_files_mean_nothing() {
    let desk = Desk::new();
    desk.done(&format!("{RUN} -o whole --quiet"));
    desk.done("rock.obj --radius 0.2% --elements 2000 -o out --quiet");
    let future = std::time::SystemTime::now() + Duration::from_secs(1 << 30);
    for (name, time) in [
        ("out/run.log", std::time::UNIX_EPOCH),
        ("out/elements.ply", future),
        ("out/recipe.toml", future),
        ("rock.obj", future),
    ] {
        let file = fs::File::options().append(true).open(desk.path(name));
        file.unwrap().set_modified(time).unwrap();
    }
    desk.done("--resume out --elements 3000 --quiet");
    desk.assert_same("out", "whole");
}

/// `thallus grow` with a folder whose name cannot be split at spaces.
fn grow_in(desk: &Desk, words: &str, folder: &str) -> std::process::Command {
    let mut command = desk.command(words);
    command.arg(folder).stderr(Stdio::piped());
    command
}

#[test]
fn folders_may_have_any_name() {
    let desk = Desk::new();
    for folder in ["two words", "Flechten/Grüße 日本", "it's at $HOME"] {
        let run = ENDLESS.to_owned() + " --quiet -o";
        let child = grow_in(&desk, &run, folder).spawn().unwrap();
        wait_for_more(&desk.path(folder).join("run.log"), 100);
        kill(child);
        let more = count_elements(&desk.path(folder).join("run.log")).unwrap() + 100;
        let resume = format!("--elements {more} --quiet --resume");
        let output = grow_in(&desk, &resume, folder).output().unwrap();
        assert!(output.status.success(), "{folder}: {}", said(&output));
        let whole = desk.path("check");
        desk.done(&format!("{ENDLESS} -o check --quiet").replace("5000000", &more.to_string()));
        for name in desk::PROMISED {
            let same = fs::read(desk.path(folder).join(name)).unwrap()
                == fs::read(whole.join(name)).unwrap();
            assert!(same, "{folder}: {name}");
        }
        fs::remove_dir_all(whole).unwrap();
    }
}

/// More elements than any test has time for.
const ENDLESS: &str = "rock.obj --radius 0.02% --elements 5000000";

#[cfg(unix)]
#[test]
fn a_link_to_the_folder_is_the_folder() {
    use std::os::unix::fs::symlink;
    let desk = Desk::new();
    symlink("real", desk.path("link")).unwrap();
    let child = desk.start(&format!("{ENDLESS} -o real"));
    wait_for_more(&desk.path("real/run.log"), 100);
    desk.fails("--resume link", 1, &["being written by another run"]);
    desk.fails(
        "rock.obj -o link --force",
        1,
        &["being written by another run"],
    );
    kill(child);
    let more = desk.log("real").begun.elements.len() + 100;
    desk.done(&format!("--resume link --elements {more} --quiet"));
    assert!(desk.path("link").is_symlink());
    desk.done(&format!("{ENDLESS} -o whole --quiet").replace("5000000", &more.to_string()));
    desk.assert_same("real", "whole");
}

#[cfg(unix)]
#[test]
fn a_log_may_lie_on_another_disk() {
    use std::os::unix::fs::symlink;
    let desk = Desk::new();
    desk.done(&format!("{RUN} -o whole --quiet"));
    desk.done("rock.obj --radius 0.2% --elements 2000 -o out --quiet");
    fs::rename(desk.path("out/run.log"), desk.path("elsewhere.log")).unwrap();
    symlink("../elsewhere.log", desk.path("out/run.log")).unwrap();
    desk.done("--resume out --elements 3000 --quiet");
    desk.assert_same("out", "whole");
    fs::remove_file(desk.path("out/run.log")).unwrap();
    symlink("nowhere.log", desk.path("out/run.log")).unwrap();
    desk.fails("--resume out", 1, &["run.log is gone"]);
}

/// Both go for a folder that is not there yet, or for one to go on with.
#[test]
fn of_two_runs_at_once_one_is_refused() {
    let desk = Desk::new();
    desk.done(&format!("{RUN} -o whole --quiet"));
    for _ in 0..5 {
        one_of_two(&desk, &format!("{RUN} -o out --quiet"));
        desk.assert_same("out", "whole");
        fs::remove_dir_all(desk.path("out")).unwrap();
        desk.done("rock.obj --radius 0.2% --elements 1000 -o out --quiet");
        one_of_two(&desk, "--resume out --elements 3000 --quiet");
        desk.assert_same("out", "whole");
        fs::remove_dir_all(desk.path("out")).unwrap();
    }
}

/// The second comes while the first grows, or finds what it left: nothing is lost either way.
fn one_of_two(desk: &Desk, words: &str) {
    let start = || desk.command(words).stderr(Stdio::piped()).spawn().unwrap();
    let both = [start(), start()].map(|child| child.wait_with_output().unwrap());
    let done = both.iter().filter(|output| output.status.success()).count();
    assert!(done >= 1, "{}{}", said(&both[0]), said(&both[1]));
    for output in both.iter().filter(|output| !output.status.success()) {
        assert_eq!(output.status.code(), Some(1));
        let told = said(output);
        assert!(
            told.contains("written by another run") || told.contains("exists already"),
            "{told}"
        );
    }
}

/// As where no locks are, and another run comes, or an editor.
#[test]
fn a_log_that_something_else_writes_ends_the_run() {
    let desk = Desk::new();
    for (name, spoil) in [("cut", &b""[..]), ("longer", &b"more"[..])] {
        let mut command = desk.command(&format!("{ENDLESS} --quiet -o {name}"));
        let child = command.stderr(Stdio::piped()).spawn().unwrap();
        let log = desk.path(name).join("run.log");
        wait_for_more(&log, 100);
        let bytes = fs::read(&log).unwrap();
        match spoil.is_empty() {
            true => {
                let file = fs::File::options().write(true).open(&log).unwrap();
                file.set_len(bytes.len() as u64 - 10).unwrap();
            }
            false => {
                let mut file = fs::File::options().append(true).open(&log).unwrap();
                file.write_all(spoil).unwrap();
            }
        }
        let output = ended(child);
        let parts = ["something else wrote into the file", "safe: go on with"];
        assert_refused_in_a_line(&output, 1, &parts);
        let told = said(&output);
        let safe = told
            .split("on; ")
            .nth(1)
            .unwrap()
            .split(' ')
            .next()
            .unwrap();
        let sound = desk.log(name).begun.elements.len();
        assert_eq!(safe.replace(',', ""), sound.to_string(), "{told}");
        desk.done(&format!(
            "--resume {name} --elements {} --quiet",
            sound + 100
        ));
    }
}

/// Nothing is left to go on with, and that is said.
#[test]
fn a_log_that_is_emptied_while_it_grows_is_not_promised_to_go_on() {
    let desk = Desk::new();
    let mut command = desk.command(&format!("{ENDLESS} --quiet -o emptied"));
    let child = command.stderr(Stdio::piped()).spawn().unwrap();
    let log = desk.path("emptied").join("run.log");
    wait_for_more(&log, 100);
    fs::File::options()
        .write(true)
        .open(&log)
        .unwrap()
        .set_len(0)
        .unwrap();
    let output = ended(child);
    assert_refused_in_a_line(&output, 1, &["what was durable is lost", "run.log"]);
    assert!(!said(&output).contains("safe"), "{}", said(&output));
}

/// Whoever should read what it says does not: the second Ctrl-C ends it all the same.
#[cfg(unix)]
#[test]
fn a_run_that_nobody_listens_to_can_be_ended() {
    use std::os::fd::OwnedFd;
    use std::os::unix::net::UnixStream;

    let desk = Desk::new();
    for quiet in ["--quiet", ""] {
        let folder = format!("deaf{quiet}");
        let (mut full, _unread) = UnixStream::pair().unwrap();
        full.set_nonblocking(true).unwrap();
        for bytes in [512, 1] {
            while full.write(&vec![b' '; bytes]).is_ok() {}
        }
        full.set_nonblocking(false).unwrap();
        let mut command = desk.command(&format!("{ENDLESS} {quiet} -o {folder}"));
        let mut child = command.stderr(OwnedFd::from(full)).spawn().unwrap();
        match quiet {
            "" => std::thread::sleep(Duration::from_secs(3)),
            _ => wait_for_more(&desk.path(&folder).join("run.log"), 100),
        }
        let id = child.id().to_string();
        let patience = Instant::now() + Duration::from_secs(30);
        let status = loop {
            assert!(Instant::now() < patience, "it goes on");
            let _ = Command::new("kill").args(["-INT", &id]).status();
            std::thread::sleep(Duration::from_millis(500));
            if let Some(status) = child.try_wait().unwrap() {
                break status;
            }
        };
        assert_eq!(status.code(), Some(130), "{quiet}");
    }
}

/// Root may write everywhere, so there the run is another user's.
#[cfg(unix)]
#[test]
fn what_may_not_be_written_is_refused_and_not_touched() {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, chown};
    use std::os::unix::process::CommandExt;

    const NOBODY: u32 = 65534;
    let desk = Desk::new();
    let allow = |path: &Path, mode| fs::set_permissions(path, fs::Permissions::from_mode(mode));
    desk.done(&format!("{RUN} -o out --quiet"));
    let is_root = fs::metadata(desk.path("rock.obj")).unwrap().uid() == 0;
    if is_root {
        allow(desk.0.path(), 0o777).unwrap();
        let inside = names(&desk.path("out")).into_iter();
        for name in inside
            .map(|name| format!("out/{name}"))
            .chain(["out".to_owned()])
        {
            chown(desk.path(&name), Some(NOBODY), Some(NOBODY)).unwrap();
        }
    }
    let resume = || {
        let mut command = desk.command("--resume out --elements 3500 --quiet");
        if is_root {
            command.uid(NOBODY).gid(NOBODY);
        }
        command.output()
    };
    for (name, closed, open) in [("out", 0o555, 0o755), ("out/run.log", 0o444, 0o644)] {
        let before = files(&desk.path("out"));
        allow(&desk.path(name), closed).unwrap();
        let output = match resume() {
            Ok(output) => output,
            Err(error) if is_root => return eprintln!("skipped: no other user: {error}"),
            Err(error) => panic!("{error}"),
        };
        assert_refused_in_a_line(
            &output,
            1,
            &["denied", "choose a place where you may write"],
        );
        assert!(files(&desk.path("out")) == before, "{name}");
        allow(&desk.path(name), open).unwrap();
    }
    let output = resume().unwrap();
    assert!(output.status.success(), "{}", said(&output));
    desk.done("rock.obj --radius 0.2% --elements 3500 -o whole --quiet");
    desk.assert_same("out", "whole");
}

/// Interrupted while the file is being written, in a folder that was made for it.
#[cfg(unix)]
#[test]
fn half_a_file_goes_when_it_is_interrupted() {
    let desk = Desk::new();
    desk.done("rock.obj --radius 0.2% --elements 20000 -o out --quiet");
    for (command, words, signal) in [
        ("export", "out -o new/er/a.usda", "-INT"),
        ("skin", "out -o new/er/a.obj --resolution 0.5r", "-TERM"),
    ] {
        let mut child = desk.call(command, words).spawn().unwrap();
        let is_begun = || fs::read_dir(desk.path("new/er")).is_ok_and(|files| files.count() > 0);
        while !is_begun() && child.try_wait().unwrap().is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        let id = child.id().to_string();
        let kill = Command::new("kill").args([signal, &id]).status();
        assert!(kill.unwrap().success());
        let code = child.wait().unwrap().code();
        assert_eq!(code, Some(130), "{command}: 0 when it ended before");
        assert_eq!(names(desk.0.path()), ["out", "rock.obj"], "{command}");
    }
}
