//! The element log cut, damaged, and of other runs.
#![allow(clippy::print_stderr)] // the measurement prints

#[path = "common/desk.rs"]
mod desk;

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use desk::{Desk, RUN};
use thallus::cluster::Element;
use thallus::export::OutputError;
use thallus::glam::DVec3;
use thallus::growth::Counts;
use thallus::log::{LARGEST_BLOCK, Log, LogError, LogWriter, count_elements, head};
use thallus::run::{
    Begun, Execution, GrowError, Growth, Observer, Progress, Recipe, Run, Settings, StopRule,
    StopSetting, Stopped, grow,
};
use thallus::substrate::{Mask, Soup, Substrate, UpAxis};

fn square() -> Substrate {
    let soup = Soup {
        positions: vec![
            [0.0; 3],
            [10.0, 0.0, 0.0],
            [10.0, 10.0, 0.0],
            [0.0, 10.0, 0.0],
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        notes: Vec::new(),
    };
    Substrate::from_soup(soup).unwrap()
}

/// A recipe for so many elements on a substrate.
fn recipe_on(substrate: &Substrate, elements: u64) -> Recipe {
    let settings = Settings {
        stop: Some(StopSetting::Elements(elements)),
        ..Settings::default()
    };
    settings.resolve(substrate, "a square").unwrap()
}

/// A recipe on a square, and that.
fn on_square(elements: u64) -> (Substrate, Recipe) {
    let square = square();
    let recipe = recipe_on(&square, elements);
    (square, recipe)
}

/// The log of 300 elements on a square, to be finished, and these.
fn grown_log(path: &Path) -> (LogWriter, Growth) {
    let (square, recipe) = on_square(300);
    let mut log = LogWriter::create(path, &recipe).unwrap();
    let growth = grow(&square, &recipe, &Execution::default(), &mut log).unwrap();
    (log, growth)
}

#[test]
fn a_writer_that_is_dropped_writes_what_waits() {
    let desk = Desk::new();
    let path = desk.path("dropped.log");
    let (log, growth) = grown_log(&path);
    drop(log);
    let read = Log::read(&path).unwrap();
    assert_eq!(read.begun.elements, growth.cluster.elements());
    assert_eq!(read.begun.counts, growth.counts);
}

#[test]
fn a_closed_log_has_all_births_takes_no_more_and_is_known_by_its_file() {
    let desk = Desk::new();
    let path = desk.path("closed.log");
    let (mut log, growth) = grown_log(&path);
    log.close().unwrap();
    log.finish().unwrap();
    let begun = growth.begun();
    assert_eq!(Log::read(&path).unwrap().begun, begun);
    assert!(log.is_in_place().unwrap());

    let (square, further) = on_square(400);
    let run = Run::new(&square, &further, begun.clone()).unwrap();
    run.grow(&Execution::default(), &mut log);
    let message = log.finish().unwrap_err().to_string();
    assert!(message.contains("the log is closed"), "{message}");
    assert_eq!(Log::read(&path).unwrap().begun, begun);

    let another = desk.path("another.log");
    fs::copy(&path, &another).unwrap();
    fs::rename(&another, &path).unwrap();
    assert!(!log.is_in_place().unwrap());
}

#[test]
fn a_log_is_begun_once() {
    let desk = Desk::new();
    let path = desk.path("begun.log");
    let (_, recipe) = on_square(300);
    let mut log = LogWriter::create(&path, &recipe).unwrap();
    log.finish().unwrap();
    assert_eq!(fs::read(&path).unwrap(), head(&recipe));
    let again = LogWriter::create(&path, &recipe);
    assert!(matches!(again, Err(OutputError::FileExists(_))));
}

/// Grows 300 elements on a substrate, and then on to 400.
fn grown_and_extended(path: &Path, substrate: &Substrate) -> Vec<Element> {
    let recipe = recipe_on(substrate, 300);
    let mut log = LogWriter::create(path, &recipe).unwrap();
    let growth = grow(substrate, &recipe, &Execution::default(), &mut log).unwrap();
    log.finish().unwrap();
    let (mut log, _) = LogWriter::open(Log::read(path).unwrap()).unwrap();
    let run = Run::new(substrate, &recipe_on(substrate, 400), growth.begun()).unwrap();
    let growth = run.grow(&Execution::default(), &mut log);
    log.finish().unwrap();
    growth.cluster.into_elements()
}

#[test]
fn a_log_gives_back_its_lichen_and_on_its_own_substrate_only() {
    let desk = Desk::new();
    let (plain, masked) = (square(), square());
    let mask = || Some(Mask::beside(&plain, &[DVec3::ZERO], 0.01));
    let masked = masked.with_mask(mask());
    for (name, substrate) in [("plain.log", &plain), ("masked.log", &masked)] {
        let elements = grown_and_extended(&desk.path(name), substrate);
        let log = Log::read(&desk.path(name)).unwrap();
        assert_eq!(elements.len(), 400);
        assert_eq!(log.cluster(substrate).unwrap().elements(), elements);
    }
    let log = |name: &str| Log::read(&desk.path(name)).unwrap();
    let refused = |name: &str, other: &Substrate| log(name).cluster(other).unwrap_err();
    let turned = square().with_up(Some(UpAxis::Z));
    let is_of = |error: LogError, expected| matches!(error, LogError::Run { problem, .. } if *problem == expected);
    assert!(is_of(refused("plain.log", &masked), GrowError::Mask));
    assert!(is_of(refused("plain.log", &turned), GrowError::Up));
    for (name, other) in [
        ("plain.log", &masked),
        ("masked.log", &plain),
        ("plain.log", &turned),
    ] {
        let error = refused(name, other);
        assert!(matches!(error, LogError::Run { .. }), "{error}");
        assert!(error.to_string().contains(name), "{error}");
    }
    let rock = Substrate::load(&desk.path("rock.obj")).unwrap();
    let error = refused("plain.log", &rock);
    assert!(matches!(error, LogError::Mesh { .. }), "{error}");
}

/// A run may be killed before all colonies have begun.
#[test]
fn a_log_without_elements_gives_back_an_empty_lichen() {
    let desk = Desk::new();
    let path = desk.path("empty.log");
    let (square, recipe) = on_square(300);
    LogWriter::create(&path, &recipe).unwrap().finish().unwrap();
    let cluster = Log::read(&path).unwrap().cluster(&square).unwrap();
    assert!(cluster.is_empty());
    assert_eq!(
        cluster.radius(),
        square.units().length_to_local(recipe.radius)
    );
}

/// Or zeros would lie between what was read and what follows.
#[test]
fn a_log_that_was_cut_after_it_was_read_is_not_gone_on_with() {
    let desk = Desk::new();
    let path = desk.path("cut.log");
    let (mut log, _) = grown_log(&path);
    log.finish().unwrap();
    let read = Log::read(&path).unwrap();
    let head = head(&on_square(300).1);
    fs::write(&path, &head).unwrap();
    let refused = LogWriter::open(read).unwrap_err().to_string();
    assert!(refused.contains("was cut since it was read"), "{refused}");
    assert_eq!(fs::read(&path).unwrap(), head);
}

#[test]
fn births_of_a_run_begun_anew_are_kept_out_of_a_log_that_has_elements() {
    let desk = Desk::new();
    let path = desk.path("anew.log");
    let (mut log, _) = grown_log(&path);
    log.finish().unwrap();
    drop(log);
    let whole = fs::read(&path).unwrap();

    let (square, recipe) = on_square(300);
    let (mut log, _) = LogWriter::open(Log::read(&path).unwrap()).unwrap();
    let growth = grow(&square, &recipe, &Execution::default(), &mut log).unwrap();
    assert_eq!(growth.stopped, Stopped::Observer);
    let message = log.finish().unwrap_err().to_string();
    for part in ["anew.log", "element 1,", "the log has 300"] {
        assert!(message.contains(part), "{part} in {message}");
    }
    drop(log);
    assert_eq!(fs::read(&path).unwrap(), whole);
}

/// A log of several blocks, as a run leaves it that was stopped between them.
struct Blocks {
    desk: Desk,
    bytes: Vec<u8>,
    /// Where the blocks begin, and the end.
    starts: Vec<usize>,
}

/// All that a log says.
fn told(read: &Result<Log, LogError>) -> Result<(&Begun, u64, u64), String> {
    match read {
        Ok(log) => Ok((&log.begun, log.sound_bytes, log.torn_bytes)),
        Err(error) => Err(error.to_string()),
    }
}

/// Sizes at which the run of [`Blocks`] was stopped: its last blocks are short.
const STOPS: [u64; 4] = [700, 740, 770, 800];

const MARKER: &[u8] = b"\xf5\xb1ock\r\n\xfe";

impl Blocks {
    fn new() -> Self {
        Self::of_seed(1)
    }

    /// Grown in the library, by the recipe of a run of the program, but for the seed.
    fn of_seed(seed: u64) -> Self {
        let desk = Desk::new();
        desk.done(&format!("{RUN} -o whole --quiet"));
        let substrate = Substrate::load(&desk.path("rock.obj")).unwrap();
        let settings = Settings::read(&desk.path("whole/recipe.toml")).unwrap();
        let mut recipe = settings.resolve(&substrate, "rock.obj").unwrap();
        recipe.seed = seed;
        let path = desk.path("blocks.log");
        fs::write(&path, head(&recipe)).unwrap();
        for stop in STOPS {
            recipe.stop = StopRule::Elements(stop);
            grow_on(&substrate, &recipe, &path);
        }
        let bytes = fs::read(&path).unwrap();
        let is_start = |&at: &usize| bytes[at..].starts_with(MARKER);
        let mut starts: Vec<_> = (0..bytes.len()).filter(is_start).collect();
        assert!(starts.len() >= STOPS.len());
        starts.push(bytes.len());
        Self {
            desk,
            bytes,
            starts,
        }
    }

    /// The last blocks, newest first: 0 is the last.
    fn block(&self, back: usize) -> std::ops::Range<usize> {
        let end = self.starts.len() - 1 - back;
        self.starts[end - 1]..self.starts[end]
    }

    fn read(&self, bytes: &[u8]) -> Result<Log, LogError> {
        let path = self.desk.path("cut.log");
        fs::write(&path, bytes).unwrap();
        let read = Log::read(&path);
        assert_eq!(told(&read), told(&Log::parse(&path, bytes)));
        read
    }

    /// Where the block begins whose first element has this age.
    fn start_of(&self, age: u64) -> usize {
        let begins = |start: &&usize| self.bytes[**start + 12..].starts_with(&age.to_le_bytes());
        *self.starts.iter().find(begins).expect("a block")
    }

    /// What there is up to a block.
    fn before(&self, block: &std::ops::Range<usize>) -> Begun {
        self.read(&self.bytes[..block.start]).unwrap().begun
    }

    /// The log with one byte changed.
    fn damaged(&self, at: usize) -> Vec<u8> {
        let mut bytes = self.bytes.clone();
        bytes[at] ^= 1 << (at % 8);
        bytes
    }

    /// The real program goes on with these bytes to those of the whole run.
    fn assert_goes_on(&self, bytes: &[u8], flags: &str) -> String {
        self.desk.put_log("whole", "out", bytes);
        let said = self.desk.done(&format!("--resume out {flags}"));
        let _ = fs::remove_file(self.desk.path("out/run.log.damaged"));
        self.desk.assert_same("out", "whole");
        said
    }
}

fn grow_on(substrate: &Substrate, recipe: &Recipe, path: &Path) {
    let (mut log, begun) = LogWriter::open(Log::read(path).unwrap()).unwrap();
    let run = Run::new(substrate, recipe, begun).unwrap();
    run.grow(&Execution::default(), &mut log);
    log.finish().unwrap();
}

#[test]
fn a_log_cut_anywhere_in_its_last_block_loses_that_block_alone() {
    let blocks = Blocks::new();
    let last = blocks.block(0);
    let before = blocks.before(&last);
    assert!(before.elements.len() >= 700 && before.counts.walkers >= 699);
    for cut in last.clone() {
        let log = blocks.read(&blocks.bytes[..cut]).unwrap();
        assert_eq!(log.begun, before, "cut at byte {cut}");
        assert_eq!(log.torn_bytes as usize, cut - last.start);
    }
    for share in [0.0, 0.01, 0.5, 0.999] {
        let cut = last.start + (share * last.len() as f64) as usize;
        let said = blocks.assert_goes_on(&blocks.bytes[..cut], "");
        assert!(
            cut == last.start || said.contains("not sound, as a killed run leaves it"),
            "{said}"
        );
    }
    let said = blocks.assert_goes_on(&blocks.bytes, "");
    assert!(said.contains("going on from 800 elements"), "{said}");
    blocks.assert_goes_on(&blocks.bytes[..blocks.starts[0]], "");
}

#[test]
fn a_damaged_last_block_is_dropped() {
    let blocks = Blocks::new();
    let last = blocks.block(0);
    let before = blocks.before(&last);
    for at in last.clone() {
        let log = blocks.read(&blocks.damaged(at)).unwrap();
        assert_eq!(log.begun, before, "byte {at}");
    }
    blocks.assert_goes_on(&blocks.damaged(last.start + 9), "");
    let mut longer = blocks.bytes.clone();
    longer.extend(MARKER.iter().chain(&[0; 3000]));
    blocks.assert_goes_on(&longer, "");
}

#[test]
fn damage_in_the_middle_is_refused_and_what_is_sound_can_be_kept() {
    let blocks = Blocks::new();
    let middle = blocks.block(1);
    let sound = blocks.before(&middle);
    for at in middle.clone() {
        match blocks.read(&blocks.damaged(at)).unwrap_err() {
            LogError::Damaged { at, elements, .. } => {
                assert_eq!(at as usize, middle.start);
                assert_eq!(elements, sound.elements.len());
            }
            other => panic!("byte {at}: {other}"),
        }
    }
    // On a busy machine blocks are cut by time too, and this one may be short.
    let damaged = blocks.damaged(middle.start);
    blocks.desk.put_log("whole", "out", &damaged);
    let number = format!(
        "the {} elements before that are sound",
        sound.elements.len()
    );
    let parts = [number.as_str(), "--resume out --keep-sound"];
    blocks.desk.fails("--resume out", 1, &parts);
    assert_eq!(
        blocks.desk.read("out/run.log"),
        damaged,
        "nothing is touched"
    );
    let behind = ["ask for more"];
    blocks
        .desk
        .fails("--resume out --keep-sound --elements 10", 2, &behind);
    assert_eq!(blocks.desk.read("out/run.log"), damaged);
    assert!(!blocks.desk.path("out/run.log.damaged").exists());
    blocks.desk.done("--resume out --keep-sound --quiet");
    assert_eq!(blocks.desk.read("out/run.log.damaged"), damaged);
    // Who is killed once that is done, and before the log is cut, does it again: it is there already.
    fs::write(blocks.desk.path("out/run.log"), &damaged).unwrap();
    blocks.desk.done("--resume out --keep-sound --quiet");
    assert_eq!(blocks.desk.read("out/run.log.damaged"), damaged);
    assert!(!blocks.desk.path("out/run.log.damaged-2").exists());
    // What was put aside stays when another damage comes.
    let again = blocks.damaged(middle.end - 1);
    fs::write(blocks.desk.path("out/run.log"), &again).unwrap();
    let said = blocks.desk.done("--resume out --keep-sound");
    assert!(!said.contains("as a killed run leaves"), "{said}");
    assert_eq!(blocks.desk.read("out/run.log.damaged"), damaged);
    assert_eq!(blocks.desk.read("out/run.log.damaged-2"), again);
    for name in ["run.log.damaged", "run.log.damaged-2"] {
        fs::remove_file(blocks.desk.path("out").join(name)).unwrap();
    }
    blocks.assert_goes_on(&damaged, "--keep-sound");
    blocks.assert_goes_on(&blocks.bytes, "--keep-sound");
}

#[test]
fn a_lost_piece_in_the_middle_is_damage_too() {
    let blocks = Blocks::new();
    let middle = blocks.block(1);
    let without = [&blocks.bytes[..middle.start], &blocks.bytes[middle.end..]].concat();
    let error = blocks.read(&without);
    assert!(matches!(error, Err(LogError::Damaged { .. })), "{error:?}");
}

#[test]
fn blocks_of_another_run_are_none_of_this_log() {
    let [one, other] = [1, 7].map(Blocks::of_seed);
    for age in [0, STOPS[0], STOPS[2]] {
        let [own, foreign] = [&one, &other].map(|blocks| blocks.start_of(age));
        let spliced = [&one.bytes[..own], &other.bytes[foreign..]].concat();
        let log = one.read(&spliced).unwrap();
        assert_eq!(log.begun.elements.len() as u64, age);
        assert_eq!(log.begun, one.read(&one.bytes[..own]).unwrap().begun);
        assert_eq!(log.torn_bytes as usize, other.bytes.len() - foreign);
    }
}

#[test]
fn a_damaged_head_is_refused() {
    let blocks = Blocks::new();
    for at in 0..blocks.starts[0] {
        assert!(blocks.read(&blocks.damaged(at)).is_err(), "byte {at}");
        let cut = blocks.read(&blocks.bytes[..at]).unwrap_err().to_string();
        assert!(cut.contains("cut.log"), "{cut}");
    }
}

/// The head of a log as another version would have written it.
fn of_version(log: &[u8], version: &str) -> Vec<u8> {
    let number = |at: usize| u32::from_le_bytes(log[at..at + 4].try_into().unwrap()) as usize;
    let recipe = 16 + number(12);
    let end = recipe + 4 + number(recipe);
    let mut head = log[..12].to_vec();
    head.extend((version.len() as u32).to_le_bytes());
    head.extend(version.as_bytes());
    head.extend(&log[recipe..end]);
    head.extend(crc32fast::hash(&head).to_le_bytes());
    head.extend(&log[end + 4..]);
    head
}

#[test]
fn a_log_of_another_run_is_refused_by_what_differs() {
    let desk = Desk::new();
    desk.done(&format!("{RUN} -o out --quiet"));
    let (recipe, log) = (desk.read("out/recipe.toml"), desk.read("out/run.log"));
    let text = String::from_utf8(recipe.clone()).unwrap();

    fs::write(desk.path("out/run.log"), of_version(&log, "0.0.9")).unwrap();
    desk.fails(
        "--resume out",
        1,
        &["out/run.log", "thallus 0.0.9", env!("CARGO_PKG_VERSION")],
    );
    let this = of_version(&log, env!("CARGO_PKG_VERSION"));
    assert!(this == log, "the test knows the format");
    let mut format = log.clone();
    format[8] = 3;
    fs::write(desk.path("out/run.log"), &format).unwrap();
    desk.fails("--resume out", 1, &["head of the log is damaged"]);
    let sealed = of_version(&format, "0.2.0");
    fs::write(desk.path("out/run.log"), sealed).unwrap();
    desk.fails("--resume out", 1, &["thallus 0.2.0 with log format 3"]);
    fs::write(desk.path("out/run.log"), "ply\n").unwrap();
    desk.fails("--resume out", 1, &["out/run.log is not a log"]);
    fs::write(desk.path("out/run.log"), &log).unwrap();

    let line = text.lines().find(|line| line.starts_with("elements ="));
    let cut = text.replace(&format!("{}\n", line.unwrap()), "");
    fs::write(desk.path("out/recipe.toml"), &cut).unwrap();
    let parts = ["out/recipe.toml", "cut off or changed", "--elements"];
    desk.fails("--resume out", 1, &parts);
    assert!(desk.read("out/recipe.toml") == cut.as_bytes());

    let other = text
        .replace("bias = 0.5", "bias = 0.75")
        .replace("seed = 1", "seed = 7");
    fs::write(desk.path("out/recipe.toml"), other).unwrap();
    let parts = [
        "another recipe",
        "bias was 0.5 and is 0.75",
        "seed was 1 and is 7",
    ];
    desk.fails("--resume out", 1, &parts);
    fs::write(desk.path("out/recipe.toml"), &recipe).unwrap();

    let mesh = fs::read_to_string(desk.path("rock.obj")).unwrap();
    fs::write(desk.path("other.obj"), mesh.clone() + "# another\n").unwrap();
    desk.fails(
        "other.obj --resume out",
        1,
        &["another mesh", "MESH --resume out"],
    );
    fs::rename(desk.path("other.obj"), desk.path("rock.obj")).unwrap();
    desk.fails("--resume out", 1, &["another mesh"]);
    let hash = Substrate::load(&desk.path("rock.obj"))
        .unwrap()
        .mesh_hash()
        .to_owned();
    let hashed = |line: &str| match line.starts_with("mesh-hash") {
        true => format!("mesh-hash = \"{hash}\"\n"),
        false => format!("{line}\n"),
    };
    fs::write(
        desk.path("out/recipe.toml"),
        text.lines().map(hashed).collect::<String>(),
    )
    .unwrap();
    desk.fails(
        "--resume out",
        1,
        &["run.log is of a run on another mesh", &hash],
    );
    assert_eq!(desk.read("out/run.log"), log, "nothing was touched");
}

/// How long this many births take to be logged, and the log. No element is grown for it.
fn logged(desk: &Desk, births: usize) -> (Duration, Vec<u8>) {
    let elements = desk.log("out").begun.elements;
    let mut progress = Progress {
        elements: 0,
        effective_radius: 0.0,
        reach: 0.0,
        covered: 0.0,
        counts: Counts::default(),
    };
    let path = desk.path("births.log");
    let log = desk.read("out/run.log");
    let start = log.windows(MARKER.len()).position(|w| w == MARKER).unwrap();
    fs::write(&path, &log[..start]).unwrap();
    let (mut writer, _) = LogWriter::open(Log::read(&path).unwrap()).unwrap();
    let started = Instant::now();
    for element in elements.iter().cycle().take(births) {
        progress.elements += 1;
        assert!(writer.born(element, &progress).is_continue());
    }
    let took = started.elapsed();
    writer.finish().unwrap();
    assert_eq!(count_elements(&path).unwrap(), births as u64);
    (took, fs::read(&path).unwrap())
}

/// Each flush ends a block, and so does every 65,536th element. A young run is flushed when it is a third older,
/// from a microsecond on; an older one every two seconds or 65,536 elements.
#[test]
fn many_births_are_flushed_seldom() {
    const BIRTHS: usize = 1_000_000;
    let desk = Desk::new();
    desk.done(&format!("{RUN} -o out --quiet"));
    let (took, log) = logged(&desk, BIRTHS);
    let blocks = log.windows(MARKER.len()).filter(|w| *w == MARKER).count();
    let seconds = took.as_secs_f64();
    eprintln!("{} ns an element", took.as_nanos() / BIRTHS as u128);
    let young = (seconds / 1e-6).ln() / (4.0f64 / 3.0).ln();
    let most = young + 0.5 * seconds + 2.0 * (BIRTHS / LARGEST_BLOCK) as f64 + 2.0;
    assert!(
        blocks >= BIRTHS / LARGEST_BLOCK && blocks as f64 <= most,
        "{blocks} blocks in {seconds} s, at most {most}"
    );
}
