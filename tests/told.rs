//! What a run says of itself: the memory it will take before it starts, and how it went in `report.json`.

#[path = "common/desk.rs"]
mod desk;

use std::collections::BTreeSet;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use desk::{Desk, RUN, fields, said};
use serde_json::Value;
use thallus::log::count_elements;

/// More than anybody waits for: by its elements, and by its refusals.
const LONG: [&str; 2] = [
    "rock.obj --radius 0.02% --elements 2000000",
    "rock.obj --radius 0.02% --elements 100000 --bias -1 --min-stick 0.001",
];

/// What a run says before it starts to grow.
fn first_line(mut child: Child) -> String {
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    let line = lines.next().unwrap().unwrap();
    child.kill().unwrap();
    child.wait().unwrap();
    line
}

/// All that a run says until some of its elements are durable.
fn said_while_growing(desk: &Desk, folder: &str, mut child: Child) -> String {
    let log = desk.path(folder).join("run.log");
    let patience = Instant::now() + Duration::from_secs(60);
    while !count_elements(&log).is_ok_and(|elements| elements > 1) {
        assert!(child.try_wait().unwrap().is_none(), "it ended");
        assert!(Instant::now() < patience, "nothing became durable");
        std::thread::sleep(Duration::from_millis(5));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let mut said = String::new();
    let mut stderr = child.stderr.take().unwrap();
    stderr.read_to_string(&mut said).unwrap();
    said
}

#[test]
fn a_long_run_is_told_its_memory_and_time_before_it_starts() {
    let desk = Desk::new();
    let start = |words: &str| desk.command(words).stderr(Stdio::piped()).spawn().unwrap();
    for (i, (run, elements)) in LONG.iter().zip(["2,000,000", "100,000"]).enumerate() {
        let told = first_line(start(&format!("{run} -o told-{i}")));
        assert!(
            told.starts_with(&format!("note: about {elements} elements: up to ")),
            "{told}"
        );
        for part in [" of memory (", " are free), and roughly ", " on one thread"] {
            assert!(told.contains(part), "{told}");
        }
        let folder = format!("out-{i}");
        let quiet = start(&format!("{run} --quiet -o {folder}"));
        assert_eq!(said_while_growing(&desk, &folder, quiet), "");
    }
    let resumed = told_of_the_rest(&desk, "out-1");
    let (there, rest) = resumed.split_once(" of them there: up to ").unwrap();
    assert!(there.starts_with("100,000 elements, "), "{resumed}");
    assert!(rest.contains(" on one thread"), "{resumed}");
    let short = desk.done(&format!("{RUN} -o short"));
    assert!(!short.contains("memory"), "{short}");
}

/// A skin with many elements near each of very many triangles.
#[test]
fn a_long_skin_is_told_its_time_before_it_is_made() {
    let desk = Desk::new();
    desk.done(&format!("{RUN} -o out"));
    let skin = |words: &str| {
        let mut command = desk.call("skin", &format!("out -o a.ply --threads 1 {words}"));
        command.stderr(Stdio::piped()).spawn().unwrap()
    };
    let told = first_line(skin("--resolution 0.1r --thickness 20r --falloff 8r"));
    for part in ["note: about ", " triangles of skin", " on 1 thread"] {
        assert!(told.contains(part), "{told}");
    }
    let short = skin("").wait_with_output().unwrap();
    assert_eq!(said(&short), "");
}

/// What a run that goes on says of what is left.
fn told_of_the_rest(desk: &Desk, folder: &str) -> String {
    let mut command = desk.command(&format!("--resume {folder}"));
    let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    let told = lines.find_map(|line| Some(line.unwrap().split_once("about ")?.1.to_owned()));
    child.kill().unwrap();
    child.wait().unwrap();
    told.unwrap()
}

/// Peak of memory in bytes that a child takes until it ends, looked at all the while.
#[cfg(target_os = "linux")]
fn peak(child: &mut Child) -> f64 {
    let status = format!("/proc/{}/status", child.id());
    let mut peak: f64 = 0.0;
    while child.try_wait().unwrap().is_none() {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find(|line| line.starts_with("VmHWM:"));
        let number = line.and_then(|line| line.split_whitespace().nth(1)?.parse().ok());
        peak = peak.max(1024.0 * number.unwrap_or(0.0));
        std::thread::sleep(Duration::from_millis(2));
    }
    peak
}

/// Bytes, from `up to 450 MB of memory`.
fn told_bytes(told: &str) -> f64 {
    let number = told.split_once("up to ").unwrap().1;
    let mut words = number.split_whitespace();
    let value: f64 = words.next().unwrap().parse().unwrap();
    match words.next() {
        Some("MB") => 1e6 * value,
        Some("GB") => 1e9 * value,
        other => panic!("{other:?} in {told}"),
    }
}

/// Plain DLA is as sparse as lichen grows, which takes the largest index. Without a picture it takes less.
#[cfg(target_os = "linux")]
#[test]
fn the_memory_that_is_told_is_what_the_run_takes() {
    let desk = Desk::new();
    let plane = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes/plane.obj");
    fs::copy(plane, desk.path("plane.obj")).unwrap();
    for pixels in [0, 32] {
        let run = "plane.obj --radius 0.01% --preset dla --elements 1000000 --threads 1 --force";
        let grow = format!("grow --preview {pixels} -o out");
        let mut command = desk.call(&grow, run);
        let command = command.stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let stderr = child.stderr.take().unwrap();
        let listener = std::thread::spawn(|| std::io::read_to_string(stderr).unwrap());
        let taken = peak(&mut child);
        let said = listener.join().unwrap();
        assert!(child.wait().unwrap().success(), "{said}");
        let told = said.lines().find(|line| line.contains("of memory"));
        let told = told_bytes(told.unwrap());
        assert!(
            taken <= told && told <= 2.0 * taken,
            "{pixels}: told {told:.3e} bytes, took {taken:.3e}"
        );
    }
}

fn report(desk: &Desk, folder: &str) -> Value {
    serde_json::from_slice(&desk.read(&format!("{folder}/report.json"))).unwrap()
}

#[test]
fn the_report_says_how_threads_shared_the_work() {
    let desk = Desk::new();
    for threads in [2, 4] {
        let mut command = desk.call("grow --preview 32", &format!("{RUN} --quiet -o {threads}"));
        let output = command.args(["--threads", &threads.to_string()]).output();
        let output = output.unwrap();
        assert!(output.status.success(), "{}", said(&output));
        let report = report(&desk, &threads.to_string());
        assert_eq!(report["threads"], threads);
        let parallel = &report["parallel"];
        let number = |name: &str| parallel[name].as_u64().unwrap();
        let walkers = report["counts"]["walkers"].as_u64().unwrap();
        // On a single core it may never be tried.
        let least =
            std::thread::available_parallelism().map_or(1, |cores| cores.get().min(2) as u64 - 1);
        assert!((least..=walkers).contains(&number("walks")), "{report}");
        assert!((1..=threads).contains(&number("threads")), "{report}");
        assert!(number("conflicts") <= number("walks"), "{report}");
        let seconds = parallel["seconds"].as_f64().unwrap();
        let grow = report["seconds"]["grow"].as_f64().unwrap();
        assert_eq!(seconds > 0.0, number("walks") > 0, "{report}");
        assert!(seconds < grow, "{report}");
        let share = report["serial_share"].as_f64().unwrap();
        assert!((share - (1.0 - seconds / grow)).abs() < 1e-9, "{report}");
        assert!(0.0 < share && share <= 1.0, "{report}");
    }
}

#[test]
fn on_one_thread_nothing_is_shared() {
    let desk = Desk::new();
    desk.done(&format!("{RUN} --quiet -o out"));
    let report = report(&desk, "out");
    assert_eq!(report["threads"], 1);
    let nothing = serde_json::json!({
        "walks": 0, "conflicts": 0, "seconds": 0.0, "landing": 0.0, "threads": 1
    });
    assert_eq!(report["parallel"], nothing);
    assert_eq!(report["serial_share"], 1.0);
}

/// Names in the table of the page.
fn documented() -> BTreeSet<String> {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/report.md");
    let page = fs::read_to_string(page).unwrap();
    let rows = page.lines().filter_map(|line| line.strip_prefix("| `"));
    rows.map(|row| row.split_once('`').unwrap().0.to_owned())
        .collect()
}

#[test]
fn every_field_of_the_report_is_documented_and_no_other() {
    let desk = Desk::new();
    desk.done(&format!("{RUN} --quiet -o out"));
    let mut found = BTreeSet::new();
    fields(&report(&desk, "out"), "", &mut found);
    assert_eq!(found, documented());
}

#[test]
fn version_and_report_name_the_build_and_promised_bytes_do_not() {
    let desk = Desk::new();
    desk.done(&format!("{RUN} --quiet -o out"));
    let report = report(&desk, "out");
    let version = desk.call("--version", "").output().unwrap().stdout;
    let version = String::from_utf8(version).unwrap();
    let plain = concat!("thallus ", env!("CARGO_PKG_VERSION"));
    let Some(build) = report["build"].as_str() else {
        assert!(report["build"].is_null() && version.trim() == plain);
        return;
    };
    assert_eq!(version.trim(), format!("{plain} ({build})"));
    let commit = build.strip_suffix("-dirty").unwrap_or(build);
    let is_hash = commit.len() == 12 && commit.bytes().all(|b| b.is_ascii_hexdigit());
    assert!(is_hash, "{build}");
    for file in ["elements.ply", "recipe.toml", "run.log"] {
        let bytes = desk.read(&format!("out/{file}"));
        let has = bytes.windows(12).any(|part| part == commit.as_bytes());
        assert!(!has, "{file}");
    }
}
