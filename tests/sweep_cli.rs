//! `thallus sweep` as it is called: resumed, killed, sharded, merged.

#[path = "sweep_cli/again.rs"]
mod again;
#[path = "common/desk.rs"]
mod desk;
#[path = "sweep_cli/failed.rs"]
mod failed;
#[path = "sweep_cli/found.rs"]
mod found;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use desk::{Desk, assert_refused, said};
use thallus::run::Settings;

/// Four cells of two seeds, and pictures that cost nothing.
const GRID: &str = "plane.obj --L 5r,10r --B 0.3,0.9 --seeds 2 --radius 0.4% --reach 18r \
                    --size 48x40 --samples 1 --quiet";

fn desk() -> Desk {
    let desk = Desk::new();
    let plane = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes/plane.obj");
    fs::copy(plane, desk.path("plane.obj")).unwrap();
    desk
}

fn command(desk: &Desk, words: &str) -> Command {
    desk.call("sweep", words)
}

fn done(desk: &Desk, words: &str) -> Output {
    let output = command(desk, words).output().unwrap();
    assert!(output.status.success(), "{words}: {}", said(&output));
    output
}

fn refused(desk: &Desk, words: &str, code: i32, parts: &[&str]) {
    assert_refused(&command(desk, words).output().unwrap(), code, parts);
}

/// Every file below a folder, by its path in it. What is not promised is taken out: seconds, and
/// the whole of `results.parquet`, whose columns are those of `results.csv`.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let name = path.strip_prefix(folder).unwrap().to_owned();
            if name.to_string_lossy().starts_with("part-") {
                continue;
            }
            files.insert(name, promised(&path));
        }
    }
    files
}

fn promised(path: &Path) -> Vec<u8> {
    let bytes = fs::read(path).unwrap();
    match path.file_name().unwrap().to_str().unwrap() {
        "results.parquet" => Vec::new(),
        "results.csv" => {
            let text = String::from_utf8(bytes).unwrap();
            let kept = |line: &str| line.rsplit_once(',').unwrap().0.to_owned() + "\n";
            assert!(text.lines().next().unwrap().ends_with(",seconds_grow"));
            text.lines().map(kept).collect::<String>().into_bytes()
        }
        "report.json" => {
            let mut report: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
            report["seconds"].take();
            report.to_string().into_bytes()
        }
        _ => bytes,
    }
}

fn assert_same(desk: &Desk, found: &str, expected: &str) {
    let [found, expected] = [found, expected].map(|folder| files(&desk.path(folder)));
    assert_eq!(
        found.keys().collect::<Vec<_>>(),
        expected.keys().collect::<Vec<_>>()
    );
    for (name, bytes) in &expected {
        assert!(found[name] == *bytes, "{} differs", name.display());
    }
}

fn is_done(run: &Path) -> bool {
    run.join("measures.json").is_file()
}

fn runs(desk: &Desk, folder: &str) -> Vec<PathBuf> {
    let mut runs = Vec::new();
    let Ok(cells) = fs::read_dir(desk.path(folder).join("cells")) else {
        return runs;
    };
    for cell in cells.flatten() {
        let seeds = fs::read_dir(cell.path()).into_iter().flatten().flatten();
        runs.extend(seeds.map(|seed| seed.path()).filter(|path| path.is_dir()));
    }
    runs
}

fn finished(desk: &Desk, folder: &str) -> usize {
    runs(desk, folder).iter().filter(|run| is_done(run)).count()
}

/// A record as another program would have made it.
fn sealed(record: &str) -> String {
    let record: serde_json::Value = serde_json::from_str(record).unwrap();
    let [recipe, elements, stopped, measures] =
        ["recipe_hash", "elements_hash", "stopped", "measures"].map(|key| record[key].to_string());
    let hash = blake3::hash(format!("[{recipe},{elements},{stopped},{measures}]").as_bytes());
    format!(
        "{{\"recipe_hash\":{recipe},\"elements_hash\":{elements},\"stopped\":{stopped},\
         \"measures\":{measures},\"hash\":\"{hash}\"}}"
    )
}

#[test]
fn the_same_bytes_on_any_number_of_threads_and_in_any_parts() {
    let desk = desk();
    done(&desk, &format!("{GRID} -o whole --threads 1"));
    let names: Vec<_> = files(&desk.path("whole")).into_keys().collect();
    assert_eq!(names.len(), 8 * 5 + 4 + 6, "{names:?}");
    done(&desk, &format!("{GRID} -o threads --threads 3"));
    assert_same(&desk, "threads", "whole");

    // Parts in folders of their own, joined.
    for part in 1..=3 {
        done(&desk, &format!("{GRID} -o part{part} --shard {part}/3"));
    }
    assert_eq!(
        [1, 2, 3].map(|p| finished(&desk, &format!("part{p}"))),
        [3, 3, 2]
    );
    refused(
        &desk,
        "merge part1 part3 -o joined --quiet",
        1,
        &[
            "part 2/3 is missing: 3 runs are in none of the folders",
            "seed",
        ],
    );
    assert!(!desk.path("joined").exists(), "nothing is written");
    done(&desk, "merge part1 part2 part3 -o joined --quiet");
    assert_same(&desk, "joined", "whole");

    // A join that was interrupted goes on, and one of the parts can take the others in.
    fs::remove_file(desk.path("joined/report.html")).unwrap();
    fs::remove_dir_all(&runs(&desk, "joined")[3]).unwrap();
    done(&desk, "merge part1 part2 part3 -o joined --quiet");
    assert_same(&desk, "joined", "whole");
    fs::create_dir(desk.path("other")).unwrap();
    fs::write(desk.path("other/mine.txt"), "mine").unwrap();
    refused(
        &desk,
        "merge part1 part2 part3 -o other --quiet",
        1,
        &["other exists, and there is no sweep in it"],
    );
    done(&desk, &format!("{GRID} -o shared1 --shard 1/2"));
    done(&desk, &format!("{GRID} -o shared2 --shard 2/2"));
    done(&desk, "merge ./shared1 shared2 -o shared1 --quiet");
    assert_same(&desk, "shared1", "whole");
    assert!(
        !desk.path("shared1/part-1-of-2.txt").exists(),
        "it is a part no more"
    );

    // A doubled part is told; one that differs is refused.
    let output = done(&desk, "merge part1 part2 part3 whole -o twice");
    assert!(
        said(&output).contains("3 runs are both in part1 and in whole"),
        "{}",
        said(&output)
    );
    assert_same(&desk, "twice", "whole");
    let half = desk.path("half");
    fs::create_dir(&half).unwrap();
    for name in ["grid.toml", "part-1-of-3.txt"] {
        fs::copy(desk.path("part1").join(name), half.join(name)).unwrap();
    }
    let output = done(&desk, "merge part1 part2 part3 part1 -o named");
    assert!(
        said(&output).contains("part1 is named twice"),
        "{}",
        said(&output)
    );
    refused(
        &desk,
        "merge half part2 -o less --quiet",
        1,
        &["part 3/3 is missing; part 1/3 in half lacks 3 runs"],
    );
    let measures = runs(&desk, "part2")[0].join("measures.json");
    let text = fs::read_to_string(&measures).unwrap();
    let changed = text.replace("\"reach\"", "\"full\"");
    for (text, parts) in [
        (
            changed.clone(),
            ["measures.json", "changed after it was measured"],
        ),
        (
            sealed(&changed),
            ["measures.json", "differs between whole and part2"],
        ),
    ] {
        fs::write(&measures, text).unwrap();
        refused(&desk, "merge whole part2 -o wrong --quiet", 1, &parts);
    }

    // Parts that share a folder: the last to end makes the page.
    for part in [2, 3, 1] {
        assert!(!desk.path("shared/report.html").exists());
        done(&desk, &format!("{GRID} -o shared --shard {part}/3"));
    }
    assert_same(&desk, "shared", "whole");
}

/// Files round places, and elements stand at multiples of what is looked for: the numbers are of the same.
#[test]
fn analyze_finds_in_a_folder_what_the_table_says() {
    let desk = desk();
    done(&desk, &format!("{GRID} -o out"));
    let text = String::from_utf8(desk.read("out/results.csv")).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let names = lines.next().unwrap();
    let column = |name: &str| names.iter().position(|n| *n == name).unwrap();
    let mut compared = 0;
    for row in lines {
        let folder = format!(
            "out/cells/{}/seed-{}",
            row[column("cell")],
            row[column("seed")]
        );
        let output = desk
            .call("analyze", &format!("{folder} --json"))
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", said(&output));
        let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let scalars = found["scalars"].as_object().unwrap().iter();
        // The radius in the table is the parameter, not what the file rounds it to.
        for (name, value) in scalars.filter(|(name, _)| *name != "radius") {
            let expected = row[column(name)].parse::<f64>().ok();
            assert_eq!(value.as_f64(), expected, "{folder}: {name}");
            compared += 1;
        }
    }
    assert!(compared > 8 * 40, "{compared}");
}

#[test]
fn a_grid_file_is_the_same_sweep() {
    let desk = desk();
    done(&desk, &format!("{GRID} -o first"));
    done(
        &desk,
        "first/grid.toml -o second --size 48x40 --samples 1 --quiet",
    );
    assert_same(&desk, "second", "first");
    let text = "mesh = \"plane.obj\"\nradius = \"0.4%\"\nreach = \"18r\"\nseeds = 2\n\
                [axes]\nL = [\"5r\", \"10r\"]\nB = \"0.3,0.9\"\n";
    fs::write(desk.path("hand.toml"), text).unwrap();
    done(&desk, "hand.toml -o third --size 48x40 --samples 1 --quiet");
    assert_same(&desk, "third", "first");
}

/// The record of a sweep says each setting once, and so can be read again.
#[test]
fn an_axis_goes_before_what_a_recipe_says() {
    let desk = desk();
    fs::write(desk.path("recipe.toml"), "bias = 0.3\ngain = 2\n").unwrap();
    let words = "--axis reach=9r --B 0.4,0.9 --radius 0.4% --size 48x40 --samples 1 --quiet";
    done(
        &desk,
        &format!("plane.obj {words} --recipe recipe.toml -o out"),
    );
    done(&desk, "out/grid.toml -o again --quiet");
    assert_same(&desk, "again", "out");
    let recipe = desk.path("out/cells/reach=9r_B=0.4/seed-1/recipe.toml");
    let recipe = Settings::read(&recipe).unwrap();
    assert_eq!((recipe.bias, recipe.gain), (Some(0.4), Some(2.0)));
}

#[test]
fn the_commands_of_the_page_make_the_same_lichen() {
    let desk = desk();
    done(&desk, &format!("{GRID} -o out"));
    let html = String::from_utf8(desk.read("out/report.html")).unwrap();
    let data = html
        .split("id=\"data\">")
        .nth(1)
        .unwrap()
        .split("</script>")
        .next()
        .unwrap();
    let data: serde_json::Value = serde_json::from_str(data).unwrap();
    let cell = &data["cells"][2];
    let words = cell["command"].as_str().unwrap();
    let mut grow = Command::new(env!("CARGO_BIN_EXE_thallus"));
    grow.args(words.split_whitespace().skip(1))
        .args(["--quiet", "--preview", "16"]);
    assert!(
        grow.current_dir(desk.0.path()).status().unwrap().success(),
        "{words}"
    );
    let name = cell["name"].as_str().unwrap();
    let again = desk.read(&format!("{name}/elements.ply"));
    assert!(again == desk.read(&format!("out/cells/{name}/seed-1/elements.ply")));

    // One cell alone, in another folder and in its place.
    done(
        &desk,
        &format!("out/grid.toml -o only --only {name} --quiet"),
    );
    assert_eq!(finished(&desk, "only"), 2);
    assert!(again == desk.read(&format!("only/cells/{name}/seed-1/elements.ply")));
    let before = files(&desk.path("out"));
    let page = "--quiet";
    done(&desk, &format!("out/grid.toml -o out --only {name} {page}"));
    assert!(files(&desk.path("out")) == before);
    refused(
        &desk,
        &format!("{GRID} -o out --only L=7r"),
        2,
        &["no such cell", "L=5r_B=0.3"],
    );
}

/// What no free surface was left for is not said to have its size.
#[test]
fn lichens_that_stop_full_are_told() {
    let desk = desk();
    let words = "plane.obj --B 0.3,0.9 --radius 4% --elements 9999 --size 48x40 --samples 1";
    let output = done(&desk, &format!("{words} -o out"));
    let warning = "2 lichens stopped short of the size asked for";
    assert!(said(&output).contains(warning), "{}", said(&output));
    let page = String::from_utf8(desk.read("out/report.html")).unwrap();
    assert!(page.contains("9,999 elements, or until no free surface was left"));
    assert_eq!(page.matches("<span>full</span>").count(), 2);
}

/// What is said of pictures is what is done.
#[test]
fn pictures_are_counted_as_they_are_taken() {
    let desk = desk();
    let grid = GRID.replace("--quiet", "");
    let notes = |words: &str| said(&command(&desk, words).output().unwrap());
    let words = format!("{grid} -o out");
    let first = notes(&words);
    assert!(first.contains("making 4 pictures\n"), "{first}");
    let again = notes(&words);
    assert!(again.contains("4 pictures are there already\n"), "{again}");
    assert!(!again.contains("making"), "{again}");
    let one = fs::read_dir(desk.path("out/pictures")).unwrap().next();
    fs::remove_file(one.unwrap().unwrap().path()).unwrap();
    let rest = notes(&words);
    let told = "making 1 picture; 3 others are there already\n";
    assert!(rest.contains(told), "{rest}");
    let impossible = grid.replace("--L 5r,10r --B 0.3,0.9", "--L 1r,10r");
    let told = notes(&format!("{impossible} -o impossible"));
    assert!(told.contains("making 1 picture\n"), "{told}");
}

#[test]
fn help_says_the_size_that_cells_have() {
    let desk = desk();
    let help = done(&desk, "--help").stdout;
    let help = String::from_utf8(help).unwrap();
    let words: Vec<_> = help.split_whitespace().collect();
    let help = words.join(" ");
    assert!(!help.contains("20000"), "{help}");
    assert!(help.contains("[default: 150 radii of the largest elements"));
}

/// Pictures are taken again where they are missing, damaged or would look different now.
#[test]
fn pictures_that_are_there_are_kept() {
    let desk = desk();
    done(&desk, &format!("{GRID} -o out"));
    let before = files(&desk.path("out"));
    let pictures: Vec<PathBuf> = fs::read_dir(desk.path("out/pictures"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    let times = || -> Vec<_> {
        let time = |file: &PathBuf| file.metadata().unwrap().modified().unwrap();
        pictures.iter().map(time).collect()
    };
    let taken = |words: &str| {
        let earlier = times();
        done(&desk, &format!("{GRID} -o out {words}"));
        let now = times();
        std::iter::zip(earlier, now).filter(|(a, b)| a != b).count()
    };
    assert_eq!(pictures.len(), 4);
    assert_eq!(taken(""), 0);
    fs::write(&pictures[1], &fs::read(&pictures[1]).unwrap()[..200]).unwrap();
    fs::write(&pictures[2], fs::read(&pictures[3]).unwrap()).unwrap();
    assert_eq!(taken(""), 2);
    assert!(files(&desk.path("out")) == before);
    assert_eq!(taken("--camera 30,45"), 4);
    assert!(files(&desk.path("out")) != before);
    assert_eq!(taken(""), 0, "the folder remembers");
    assert_eq!(taken("--camera auto"), 4);
    assert!(files(&desk.path("out")) == before);
    fs::write(desk.path("out/pictures.toml"), b"\xFF").unwrap();
    let parts = ["pictures.toml: it is not text", "remove it"];
    refused(&desk, &format!("{GRID} -o out"), 1, &parts);
}

/// Runs that take a while.
const LONG: &str = "plane.obj --L 5r,10r,20r --B 0.3,0.9 --radius 0.1% --elements 6000 \
                    --size 48x40 --samples 1 --threads 2 --quiet";

fn start(desk: &Desk, words: &str) -> Child {
    let mut command = command(desk, words);
    command
        .stderr(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .unwrap()
}

fn wait_for(mut there: impl FnMut() -> bool) {
    let started = Instant::now();
    while !there() {
        assert!(
            started.elapsed() < Duration::from_secs(120),
            "it never came"
        );
        sleep(Duration::from_millis(5));
    }
}

#[test]
fn a_killed_sweep_goes_on_and_leaves_finished_runs_alone() {
    let desk = desk();
    done(&desk, &format!("{LONG} -o whole"));
    for kills in 1..=2 {
        let folder = format!("killed{kills}");
        for kill in 1..=kills {
            let mut child = start(&desk, &format!("{LONG} -o {folder}"));
            wait_for(|| finished(&desk, &folder) >= 2 * kill);
            child.kill().unwrap();
            child.wait().unwrap();
        }
        assert!(finished(&desk, &folder) < 6, "killed before the end");
        let is_kept = |run: &PathBuf| is_done(run);
        let kept: Vec<_> = runs(&desk, &folder).into_iter().filter(is_kept).collect();
        let times = |kept: &[PathBuf]| -> Vec<_> {
            let file = |run: &PathBuf| run.join("elements.ply").metadata().unwrap();
            kept.iter()
                .map(|run| file(run).modified().unwrap())
                .collect()
        };
        let before = times(&kept);
        done(&desk, &format!("{LONG} -o {folder}"));
        assert_eq!(times(&kept), before, "finished runs are not touched");
        assert_same(&desk, &folder, "whole");
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_stops_cleanly_and_the_same_command_goes_on() {
    let desk = desk();
    let mut child = start(&desk, &format!("{LONG} -o out"));
    wait_for(|| finished(&desk, "out") >= 1);
    let killed = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(killed.unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(!desk.path("out/report.html").exists());
    let stages = runs(&desk, "out")
        .iter()
        .filter(|run| run.join(".thallus-run").exists())
        .count();
    assert_eq!(stages, 0, "nothing half-written is left");
    done(&desk, &format!("{LONG} -o out"));
    done(&desk, &format!("{LONG} -o whole"));
    assert_same(&desk, "out", "whole");
}

#[test]
fn further_axes_are_pages() {
    let desk = desk();
    let words = "plane.obj --L 5r,10r --B 0.5 --axis join=pack,touch --radius 0.4% --elements 60 \
                 --size 48x40 --samples 1 -o out";
    let told = String::from_utf8(done(&desk, words).stdout).unwrap();
    assert!(told.contains("contact-sheet-1.png to -2.png"), "{told}");
    for name in ["contact-sheet-1.png", "contact-sheet-2.png"] {
        assert!(desk.path("out").join(name).is_file(), "{name}");
    }
    let html = String::from_utf8(desk.read("out/report.html")).unwrap();
    assert!(html.contains("<h2>join = pack</h2>") && html.contains("<h2>join = touch</h2>"));
    let csv = String::from_utf8(desk.read("out/results.csv")).unwrap();
    assert!(csv.contains(",60,elements,60,"), "counts are whole: {csv}");
    let recipe = desk.path("out/cells/L=5r_B=0.5_join=touch/seed-1/recipe.toml");
    assert_eq!(Settings::read(&recipe).unwrap().seed, Some(1));
}
