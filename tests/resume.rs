//! Runs that are killed, cut short or extended: they end with the bytes of a run that never
//! stopped.
#![allow(clippy::print_stderr)] // where the kills fell

#[path = "common/desk.rs"]
mod desk;

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use desk::{Desk, RUN, assert_refused, names, said};
use thallus::cluster::Element;
use thallus::growth::Counts;
use thallus::log::{LOG, Log};
use thallus::run::{Begun, Execution, Recipe, Run, Settings, StopRule, StopSetting};
use thallus::substrate::{Substrate, SurfacePoint};

/// Numbers that look random: a fixed sequence in [0, 1).
fn shares(n: usize) -> impl Iterator<Item = f64> {
    (1..=n).map(|i| (i as f64 * 0.618_033_988_749_895).fract())
}

/// Waits until so many elements of a run are durable.
fn wait_for_elements(folder: &Path, elements: usize) {
    let are_there =
        || Log::read(&folder.join(LOG)).is_ok_and(|log| log.begun.elements.len() >= elements);
    let patience = Instant::now() + Duration::from_secs(60);
    while !are_there() {
        assert!(Instant::now() < patience, "nothing became durable");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn slow_run() -> String {
    RUN.replace("3000", "6000")
}

/// The real program, killed without warning at 50 moments of its life, ten of them on a mesh so fine that
/// coarser copies are made of it. It runs on one to three threads, and goes on on another number.
#[test]
fn a_killed_run_goes_on_to_the_same_bytes() {
    let desk = Desk::new();
    let boulder = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes/boulder.glb");
    fs::copy(boulder, desk.path("boulder.glb")).unwrap();
    let fine = "boulder.glb --elements 6000";
    // Edges crossed, for 80,000 triangles, after which there are copies.
    const CROSSED: u64 = 4 * 80_000;
    for (run, kills, enough) in [(slow_run().as_str(), 40, 20), (fine, 10, 4)] {
        desk.done(&format!("{run} -o whole --quiet --force"));
        let lives = [1, 2, 3].map(|threads| life(&desk, threads, run));
        let mut found = [0; 3];
        for (i, share) in shares(kills).enumerate() {
            let (before, after) = (i % 3, (i + 1 + i / 3 % 2) % 3);
            let mut child = desk.start_on(before + 1, &format!("{run} -o out"));
            std::thread::sleep(lives[before].mul_f64(share));
            child.kill().unwrap();
            child.wait().unwrap();
            found[resume_or_start(&desk, after + 1, run)] += 1;
            desk.assert_same("out", "whole");
            fs::remove_dir_all(desk.path("out")).unwrap();
        }
        eprintln!("killed before the log, with nothing logged, with elements logged: {found:?}");
        assert!(
            found[2] >= enough,
            "kills that fell into the growth: {found:?}"
        );
        let crossed = desk.report("whole")["counts"]["crossings"].as_u64();
        assert!(run != fine || crossed > Some(CROSSED), "no copies");
    }
}

/// How long a run takes.
fn life(desk: &Desk, threads: usize, run: &str) -> Duration {
    let started = Instant::now();
    desk.done_on(threads, &format!("{run} -o out --quiet"));
    fs::remove_dir_all(desk.path("out")).unwrap();
    started.elapsed()
}

/// Goes on with a killed run, or starts it where it had not begun; says how far it had come.
fn resume_or_start(desk: &Desk, threads: usize, run: &str) -> usize {
    if !desk.path("out/recipe.toml").exists() {
        desk.done_on(threads, &format!("{run} -o out --quiet"));
        return 0;
    }
    let logged = desk.path("out/run.log").exists().then(|| desk.log("out"));
    desk.done_on(threads, "--resume out --quiet");
    logged.map_or(0, |log| 1 + usize::from(!log.begun.elements.is_empty()))
}

/// Killed, gone on with and killed again, until it is done.
#[test]
fn a_run_may_be_killed_again_and_again() {
    let desk = Desk::new();
    let run = slow_run();
    desk.done(&format!("{run} -o whole --quiet"));
    let mut child = desk.start(&format!("{run} -o out"));
    let mut sizes = Vec::new();
    for patience in 1..100 {
        // Ever longer, so that loading and replay leave time to grow.
        std::thread::sleep(Duration::from_millis(20 * patience));
        child.kill().unwrap();
        let ended = child.wait().unwrap();
        if ended.success() {
            break;
        }
        let log = desk.path("out/run.log").exists().then(|| desk.log("out"));
        sizes.extend(log.map(|log| log.begun.elements.len()));
        let words = match desk.path("out/recipe.toml").exists() {
            true => "--resume out".to_owned(),
            false => format!("{run} -o out"),
        };
        child = desk.start(&words);
    }
    child.wait().unwrap();
    assert!(sizes.is_sorted(), "nothing durable is lost: {sizes:?}");
    desk.assert_same("out", "whole");
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_goes_on_to_the_same_bytes() {
    let desk = Desk::new();
    let run = RUN.replace("3000", "40000");
    desk.done(&format!("{run} -o whole --quiet"));
    let child = desk.start(&format!("{run} -o out"));
    wait_for_elements(&desk.path("out"), 1);
    let id = child.id().to_string();
    let kill = Command::new("kill").args(["-INT", &id]).status();
    assert!(kill.unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    let interrupted = desk.report("out");
    assert_eq!(interrupted["stopped"], "cancelled");
    assert_eq!(
        interrupted["elements"],
        desk.log("out").begun.elements.len()
    );
    desk.done("--resume out --quiet");
    desk.assert_same("out", "whole");
}

/// A run to 500 elements, stopped by a signal while its picture is taken. One of this size takes a minute, and
/// `report.json` comes after it: so it is being taken when the log has all elements.
#[cfg(unix)]
fn stopped_at_the_picture(desk: &Desk, words: &str, signal: &str) -> Output {
    let mut large = desk.call("grow --preview 8192 --threads 2", words);
    let child = large.stderr(Stdio::piped()).spawn().unwrap();
    wait_for_elements(&desk.path("out"), 500);
    std::thread::sleep(Duration::from_millis(500));
    let id = child.id().to_string();
    let kill = Command::new("kill").args([signal, &id]).status();
    assert!(kill.unwrap().success());
    child.wait_with_output().unwrap()
}

#[cfg(unix)]
#[test]
fn an_interrupted_picture_is_left_out() {
    let desk = Desk::new();
    let run = "rock.obj --elements 500 --quiet";
    let output = stopped_at_the_picture(&desk, &format!("{run} -o out"), "-INT");
    assert_eq!(output.status.code(), Some(130), "{}", said(&output));
    let files = ["elements.ply", "recipe.toml", "report.json", "run.log"];
    assert_eq!(names(&desk.path("out")), files);
    desk.done(&format!("{run} -o whole"));
    assert!(desk.read("out/elements.ply") == desk.read("whole/elements.ply"));
}

#[test]
fn a_run_without_a_picture_is_the_same_but_for_that() {
    let desk = Desk::new();
    let grow = |words: &str| desk.call("grow --preview 0", words).output().unwrap();
    desk.done("rock.obj --elements 200 --quiet -o out");
    let output = grow("--resume out --elements 300");
    assert!(output.status.success(), "{}", said(&output));
    let files = ["elements.ply", "recipe.toml", "report.json", "run.log"];
    assert_eq!(names(&desk.path("out")), files, "nor one of fewer elements");
    assert!(!String::from_utf8_lossy(&output.stdout).contains("preview"));
    desk.done("rock.obj --elements 300 --quiet -o whole");
    assert!(desk.read("out/elements.ply") == desk.read("whole/elements.ply"));
    let output = desk.call("grow --preview 8", "rock.obj -o tiny").output();
    let output = output.unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(
        said(&output).contains("0 for no picture"),
        "{}",
        said(&output)
    );
}

/// Whether it was interrupted or killed without warning.
#[cfg(unix)]
#[test]
fn no_picture_of_a_smaller_lichen_stays() {
    let desk = Desk::new();
    for signal in ["-INT", "-KILL"] {
        desk.done("rock.obj --elements 200 --quiet -o out --force");
        assert!(desk.path("out/preview.png").exists());
        stopped_at_the_picture(&desk, "--resume out --elements 500 --quiet", signal);
        assert!(!desk.path("out/preview.png").exists(), "{signal}");
    }
    desk.done("--resume out --quiet");
    desk.done("rock.obj --elements 500 --quiet -o whole");
    desk.assert_same("out", "whole");
}

#[test]
fn a_finished_run_is_extended_as_if_it_had_been_asked_at_once() {
    let desk = Desk::new();
    let base = "rock.obj --radius 0.2%";
    for (name, first, then) in [
        ("elements", "--elements 500", "--elements 1500"),
        ("until", "--until-elements 1", "--until-elements 2"),
        ("reach", "--reach 20r", "--until-reach 35r"),
        ("cover", "--elements 400", "--until-cover 0.008"),
        ("again", "--cover 0.001", "--elements 2000"),
    ] {
        let whole = format!("{name}-whole");
        desk.done(&format!("{base} -o {name} --quiet {first}"));
        desk.done(&format!("{base} -o {whole} --quiet {then}"));
        desk.done(&format!("--resume {name} --quiet {then}"));
        desk.assert_same(name, &whole);
        desk.done(&format!("--resume {name} --quiet"));
        desk.assert_same(name, &whole);
    }
}

#[test]
#[cfg(unix)]
fn the_command_that_a_message_names_can_be_pasted() {
    let (desk, folder) = (Desk::new(), "my rock's run");
    desk.done("rock.obj --radius 0.2% --elements 300 -o whole --quiet");
    desk.put_log("whole", folder, &desk.read("whole/run.log"));
    let mut skin = desk.call("skin", "-o skin.ply");
    let message = said(&skin.arg(folder).output().unwrap());
    let command = message.split(" goes on").next().unwrap();
    let command = &command[command.find("thallus grow").unwrap()..];
    let pasted = format!("thallus() {{ \"$0\" \"$@\"; }}; {command} --threads 1 --preview 32");
    let output = Command::new("sh")
        .args(["-c", &pasted, env!("CARGO_BIN_EXE_thallus")])
        .current_dir(desk.0.path())
        .output()
        .unwrap();
    assert!(output.status.success(), "{command}: {}", said(&output));
    desk.assert_same(folder, "whole");
}

#[test]
fn a_size_that_lies_behind_is_refused() {
    let desk = Desk::new();
    desk.done(&format!("{RUN} -o out --quiet"));
    let before: Vec<_> = names(&desk.path("out"));
    let files = || {
        before
            .iter()
            .map(|name| desk.read(&format!("out/{name}")))
            .collect::<Vec<_>>()
    };
    let content = files();
    for size in ["--elements 2999", "--reach 10r", "--cover 0.0001"] {
        desk.fails(
            &format!("--resume out {size}"),
            2,
            &["3000 elements already", "ask for more"],
        );
        assert!(files() == content, "{size}");
    }
    assert_eq!(names(&desk.path("out")), before);
}

/// Blocks end at every 65,536 elements, whatever stopped between.
#[test]
fn long_logs_are_the_same_too() {
    let desk = Desk::new();
    let run = "rock.obj --radius 0.1% --preset dla --quiet";
    desk.done(&format!("{run} -o out --elements 65000"));
    desk.done("--resume out --elements 65536 --quiet");
    desk.done("--resume out --elements 67000 --quiet");
    desk.done(&format!("{run} -o whole --elements 67000"));
    desk.assert_same("out", "whole");
}

#[test]
fn what_cannot_be_gone_on_with_is_explained() {
    let desk = Desk::new();
    fs::create_dir(desk.path("empty")).unwrap();
    desk.fails("--resume nowhere", 1, &["nowhere holds no run"]);
    desk.fails("--resume empty", 1, &["empty holds no run"]);
    assert!(!desk.path("nowhere").exists());
    desk.done(&format!("{RUN} -o out --quiet"));
    for flags in [
        "-o other",
        "--force",
        "--recipe out/recipe.toml",
        "--bias 0.7",
        "--seed 3",
    ] {
        desk.fails(
            &format!("--resume out {flags}"),
            2,
            &["cannot be used with"],
        );
    }
    desk.fails("rock.obj --keep-sound", 2, &["--resume"]);
    fs::rename(desk.path("rock.obj"), desk.path("moved.obj")).unwrap();
    desk.fails(
        "--resume out",
        1,
        &["rock.obj", "thallus grow MESH --resume out"],
    );
    desk.done("moved.obj --resume out --elements 3500 --quiet");
    let recipe = String::from_utf8(desk.read("out/recipe.toml")).unwrap();
    assert!(recipe.contains("mesh = \"moved.obj\""), "{recipe}");
    desk.done("moved.obj --radius 0.2% -o whole --elements 3500 --quiet");
    desk.assert_same("out", "whole");
}

#[test]
fn a_recipe_without_a_log_begins_anew() {
    let desk = Desk::new();
    desk.done(&format!("{RUN} -o whole --quiet"));
    desk.put_log("whole", "out", b"");
    fs::remove_file(desk.path("out/run.log")).unwrap();
    let said = desk.done("--resume out");
    assert!(said.contains("begins anew"), "{said}");
    desk.assert_same("out", "whole");
    fs::remove_file(desk.path("out/run.log")).unwrap();
    for gone in ["elements.ply", "preview.png"] {
        desk.fails("--resume out", 1, &["a finished run whose run.log is gone"]);
        fs::remove_file(desk.path("out").join(gone)).unwrap();
    }
    desk.fails("--resume out", 1, &["a finished run whose run.log is gone"]);
    assert!(desk.path("out/report.json").exists());
}

/// What it leads to may be on a disk that is away.
#[cfg(unix)]
#[test]
fn a_log_that_is_a_link_to_nothing_is_not_begun_anew() {
    let desk = Desk::new();
    desk.done(&format!("{RUN} -o whole --quiet"));
    desk.put_log("whole", "out", b"");
    fs::remove_file(desk.path("out/run.log")).unwrap();
    std::os::unix::fs::symlink("/nowhere/run.log", desk.path("out/run.log")).unwrap();
    desk.fails("--resume out", 1, &["out/run.log", "No such file"]);
    assert!(desk.path("out/run.log").is_symlink());
}

/// What is there goes when the new run can begin, and not before.
#[test]
fn a_forced_run_that_cannot_begin_leaves_the_run_before() {
    let desk = Desk::new();
    desk.done(&format!("{RUN} -o out --quiet"));
    fs::remove_file(desk.path("out/report.json")).unwrap();
    fs::create_dir(desk.path("out/report.json")).unwrap();
    let before = names(&desk.path("out"));
    desk.fails(&format!("{RUN} -o out --force"), 1, &["out/report.json"]);
    desk.fails("--resume out --elements 4000", 1, &["out/report.json"]);
    assert_eq!(names(&desk.path("out")), before);
    assert_eq!(desk.log("out").begun.elements.len(), 3000);
}

/// The next run has its name now.
#[cfg(unix)]
#[test]
fn a_run_whose_folder_is_gone_leaves_alone_the_next_one_of_its_name() {
    let desk = Desk::new();
    let mut next = None;
    let said = said_without_folder(&desk, || {
        fs::rename(desk.path("out"), desk.path("moved")).unwrap();
        next = Some(desk.start(&format!("{ENDLESS} -o out --quiet --seed 2")));
        wait_for_elements(&desk.path("out"), 1);
    });
    assert!(
        said.contains("went with it, unless out was moved"),
        "{said}"
    );
    desk.fails("--resume out", 1, &["another run"]);
    let mut next = next.unwrap();
    assert!(next.try_wait().unwrap().is_none());
    next.kill().unwrap();
    next.wait().unwrap();
    let more = desk.log("out").begun.elements.len() + 100;
    desk.done(&format!("--resume out --elements {more} --quiet"));
}

/// More elements than any test has time for.
const ENDLESS: &str = "rock.obj --radius 0.02% --elements 5000000";

#[test]
fn a_second_run_into_the_folder_is_refused() {
    let desk = Desk::new();
    let mut first = desk.start(&format!("{ENDLESS} -o out"));
    wait_for_elements(&desk.path("out"), 1);
    desk.fails("--resume out", 1, &["out is being written by another run"]);
    desk.fails(
        "rock.obj -o out --force",
        1,
        &["out is being written by another run"],
    );
    desk.fails("rock.obj -o out", 1, &["out exists already", "--resume"]);
    first.kill().unwrap();
    first.wait().unwrap();
    let more = desk.log("out").begun.elements.len() + 100;
    desk.done(&format!("--resume out --elements {more} --quiet"));
}

#[test]
fn a_forced_run_leaves_nothing_of_the_run_before() {
    let desk = Desk::new();
    desk.done(&format!("{RUN} -o out --quiet --seed 2"));
    let mut child = desk.start(&format!("{ENDLESS} -o out --force"));
    let goal = Some(StopSetting::Elements(5_000_000));
    let begun = |log: Log| log.recipe.stop == goal && !log.begun.elements.is_empty();
    let patience = Instant::now() + Duration::from_secs(60);
    while !Log::read(&desk.path("out/run.log")).is_ok_and(begun) {
        assert!(Instant::now() < patience, "nothing became durable");
        std::thread::sleep(Duration::from_millis(5));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(
        names(&desk.path("out")),
        [".thallus-run", "recipe.toml", "run.log"]
    );
    let more = desk.log("out").begun.elements.len() + 100;
    desk.done(&format!("--resume out --elements {more} --quiet"));
    desk.done(&format!("{ENDLESS} -o whole --quiet").replace("5000000", &more.to_string()));
    desk.assert_same("out", "whole");
}

/// What a run says when its folder is taken away.
#[cfg(unix)]
fn said_without_folder(desk: &Desk, take: impl FnOnce()) -> String {
    let mut command = desk.command(&format!("{ENDLESS} -o out --quiet"));
    let child = command.stderr(Stdio::piped()).spawn().unwrap();
    wait_for_elements(&desk.path("out"), 1);
    take();
    let output = child.wait_with_output().unwrap();
    let said = said(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    said
}

#[cfg(unix)]
#[test]
fn a_folder_that_is_taken_away_ends_the_run_and_goes_on_elsewhere() {
    let desk = Desk::new();
    let said = said_without_folder(&desk, || {
        fs::rename(desk.path("out"), desk.path("moved")).unwrap();
    });
    assert!(
        said.contains("run.log") && said.contains("removed"),
        "{said}"
    );
    let more = desk.log("moved").begun.elements.len() + 100;
    desk.done(&format!("--resume moved --elements {more} --quiet"));
    desk.done(&format!("{ENDLESS} -o whole --quiet").replace("5000000", &more.to_string()));
    desk.assert_same("moved", "whole");
}

#[cfg(unix)]
#[test]
fn a_folder_that_is_deleted_is_not_promised_to_go_on() {
    let desk = Desk::new();
    let said = said_without_folder(&desk, || {
        // Away at once, as nothing may be made in it while it is being deleted.
        fs::rename(desk.path("out"), desk.path("moved")).unwrap();
        fs::remove_dir_all(desk.path("moved")).unwrap();
    });
    assert!(
        said.contains("went with it, unless out was moved") && !said.contains("--resume out"),
        "{said}"
    );
}

#[cfg(unix)]
#[test]
fn a_pipe_in_place_of_log_or_recipe_is_refused() {
    let desk = Desk::new();
    // That of the report is not waited for either.
    desk.done("rock.obj --elements 50 -o reported --quiet");
    fs::remove_file(desk.path("reported/report.json")).unwrap();
    let made = Command::new("mkfifo")
        .arg(desk.path("reported/report.json"))
        .status();
    assert!(made.unwrap().success());
    desk.done("--resume reported --elements 60 --quiet");
    for file in ["run.log", "recipe.toml"] {
        desk.done("rock.obj --elements 50 -o out --quiet --force");
        let path = desk.path(&format!("out/{file}"));
        fs::remove_file(&path).unwrap();
        let made = Command::new("mkfifo").arg(path).status();
        assert!(made.unwrap().success());
        let words = [&format!("out/{file}"), "this is a pipe"];
        desk.fails("--resume out --elements 60", 1, &words);
    }
}

/// Root may write everywhere, so there the run is another user's.
#[cfg(unix)]
#[test]
fn permission_lost_on_the_way_ends_the_run_and_loses_nothing() {
    use std::os::unix::fs::{MetadataExt, PermissionsExt};
    use std::os::unix::process::CommandExt;

    const NOBODY: u32 = 65534;
    let desk = Desk::new();
    let allow = |path: &Path, mode| fs::set_permissions(path, fs::Permissions::from_mode(mode));
    allow(desk.0.path(), 0o777).unwrap();
    let run = RUN.replace("3000", "12000");
    let mut command = desk.command(&format!("{run} -o out --quiet"));
    command.stderr(Stdio::piped());
    let is_root = fs::metadata(desk.path("rock.obj")).unwrap().uid() == 0;
    if is_root {
        command.uid(NOBODY).gid(NOBODY);
    }
    let child = match command.spawn() {
        Ok(child) => child,
        Err(error) if is_root => return eprintln!("skipped: no other user may run it: {error}"),
        Err(error) => panic!("{error}"),
    };
    wait_for_elements(&desk.path("out"), 1);
    allow(&desk.path("out"), 0o555).unwrap();
    let output = child.wait_with_output().unwrap();
    let said = said(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("denied") && said.contains("go on with thallus grow --resume out"),
        "{said}"
    );
    assert_eq!(said.lines().count(), 1, "{said}");
    allow(&desk.path("out"), 0o755).unwrap();
    desk.done("--resume out --quiet");
    desk.done(&format!("{run} -o whole --quiet"));
    desk.assert_same("out", "whole");
}

/// A limit on the size of files stands for the full disk; ignored, its signal is an error.
#[cfg(unix)]
#[test]
fn what_was_written_before_the_disk_was_full_goes_on() {
    let desk = Desk::new();
    desk.done(&format!("{RUN} -o whole --quiet"));
    // In units of 512 or 1024 bytes: the log is full while growing, or the table at the end.
    for limit in [3, 60, 190, 350] {
        let program = env!("CARGO_BIN_EXE_thallus");
        let script = format!(
            "trap '' XFSZ; ulimit -f {limit}; exec {program} grow {RUN} -o out --quiet --preview 32 \
             --threads 1"
        );
        let shell = Command::new("sh")
            .args(["-c", &script])
            .current_dir(desk.0.path())
            .output();
        let output = shell.unwrap();
        if output.status.success() {
            assert_eq!(limit, 350, "units of 1024 bytes");
            continue;
        }
        let said = said(&output);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(
            said.contains("safe: go on with thallus grow --resume out"),
            "{said}"
        );
        assert_eq!(said.lines().count(), 1, "{said}");
        desk.done("--resume out --quiet");
        desk.assert_same("out", "whole");
        fs::remove_dir_all(desk.path("out")).unwrap();
    }
}

/// A run under a limit on address space, in thousands of bytes.
#[cfg(target_os = "linux")]
fn in_little_memory(desk: &Desk, limit: u64, words: &str) -> Output {
    let program = env!("CARGO_BIN_EXE_thallus");
    let script = format!("ulimit -v {limit}; exec {program} grow {words}");
    let mut shell = Command::new("sh");
    shell.args(["-c", &script]).current_dir(desk.0.path());
    shell.output().unwrap()
}

#[cfg(target_os = "linux")]
#[test]
fn what_does_not_fit_into_memory_is_refused_with_the_number() {
    let desk = Desk::new();
    let run = "rock.obj --radius 0.0001% --elements 1000000000 -o out";
    let output = in_little_memory(&desk, 4_000_000, run);
    assert_refused(&output, 1, &["1,000,000,000 elements", "450 GB", "free"]);
    assert!(!desk.path("out").exists());
}

/// More elements are asked for than have a place: room that is made for them leaves enough for all else.
#[cfg(target_os = "linux")]
#[test]
fn room_made_ahead_leaves_room() {
    let desk = Desk::new();
    let run = "rock.obj --radius 1% --threads 1 --preview 32 --quiet -o out --force";
    for elements in [5_000_000, 40_000_000] {
        let output = in_little_memory(&desk, 500_000, &format!("{run} --elements {elements}"));
        assert!(output.status.success(), "{elements}: {}", said(&output));
    }
}

#[test]
fn elements_that_cannot_be_of_the_run_are_refused() {
    let desk = Desk::new();
    let substrate = Substrate::load(&desk.path("rock.obj")).unwrap();
    let recipe = Settings::default().resolve(&substrate, "rock.obj").unwrap();
    let counted = |elements: &[Element], counts: Counts| {
        let begun = Begun {
            elements: elements.to_vec(),
            counts,
        };
        let run = Run::new(&substrate, &recipe, begun);
        run.map(|run| assert_eq!(run.cluster().elements(), elements))
    };
    let run = |elements: &[Element]| {
        let walkers = elements.len() as u64 - 1;
        let counts = Counts {
            walkers,
            ..Counts::default()
        };
        counted(elements, counts)
    };
    let grown = thallus::run::grow(
        &substrate,
        &Recipe {
            stop: StopRule::Elements(5),
            ..recipe.clone()
        },
        &Execution::default(),
        &mut (),
    );
    let elements = grown.unwrap().cluster.elements().to_vec();
    assert!(run(&elements).is_ok());
    assert!(run(&elements[1..]).is_err(), "no seed");
    let right = elements[4];
    let placed = |at: SurfacePoint| Element {
        at,
        position: substrate.position(&at),
        ..right
    };
    let far = |u: f64| placed(SurfacePoint { u, ..right.at });
    let nowhere = SurfacePoint::centroid(1 << 30);
    for wrong in [
        Element { parent: 4, ..right },
        Element {
            at: nowhere,
            ..right
        },
        Element {
            position: right.position + 1e-9,
            ..right
        },
        Element { colony: 1, ..right },
        Element {
            probability: f64::NAN,
            ..right
        },
        far(1e9),
        far(-1e-3),
        far(f64::INFINITY),
        far(f64::NAN),
    ] {
        let elements = [&elements[..4], &[wrong]].concat();
        let error = run(&elements).unwrap_err().to_string();
        assert!(error.contains("element 4"), "{error}");
    }

    let walkers = |walkers: u64, steps: u64| {
        let counts = Counts {
            walkers,
            steps,
            ..Counts::default()
        };
        counted(&elements, counts)
    };
    assert!(walkers(4, 0).is_ok() && walkers(900, 70_000).is_ok());
    for (few_or_many, steps) in [(0, 0), (3, 0), (u64::MAX, 0), (9, u64::MAX)] {
        let error = walkers(few_or_many, steps).unwrap_err().to_string();
        assert!(error.contains("5 elements"), "{error}");
    }
}
