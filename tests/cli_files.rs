//! The command on files: what reaches `recipe.toml`, what the bytes depend on, and disks that
//! refuse.
#![allow(clippy::print_stderr)] // a skipped test says so

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn rock() -> String {
    let rock = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes/rock.obj");
    rock.display().to_string()
}

/// Runs `thallus` in a folder.
fn thallus(folder: &Path, words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_thallus"));
    command.args(words).current_dir(folder);
    if words.first() == Some(&"grow") {
        command.args(["--preview", "64"]); // a full picture takes longer than the growth
    }
    command.output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Grows a few elements on the rock and gives the folder.
fn grown(folder: &Path, name: &str, flags: &str) -> PathBuf {
    let rock = rock();
    let mut words = vec!["grow", &rock, "-o", name, "--quiet"];
    words.extend(flags.split_whitespace());
    let output = thallus(folder, &words);
    assert!(output.status.success(), "{flags}: {}", said(&output));
    folder.join(name)
}

fn recipe(folder: &Path) -> toml::Table {
    let text = fs::read_to_string(folder.join("recipe.toml")).unwrap();
    text.parse().unwrap()
}

/// `--force` is for what an earlier run wrote, killed ones included.
#[test]
fn a_run_replaces_runs_and_nothing_else() {
    let desk = tempfile::tempdir().unwrap();
    let put = |folder: &str, name: &str, bytes: &[u8]| {
        fs::create_dir_all(desk.path().join(folder)).unwrap();
        fs::write(desk.path().join(folder).join(name), bytes).unwrap();
    };
    let mesh = fs::read(rock()).unwrap();
    put("mine", "preview.png", b"mine");
    put("mesh", "elements.ply", &mesh);
    put("log", "run.log", b"lumber\n");
    let rock = rock();
    for (mesh, folder, file, is) in [
        (rock.as_str(), "mine", "preview.png", "is not a run's"),
        (rock.as_str(), "log", "run.log", "is not a run's"),
        (
            "mesh/elements.ply",
            "mesh",
            "elements.ply",
            "is the mesh itself",
        ),
    ] {
        let before = fs::read(desk.path().join(folder).join(file)).unwrap();
        let ran = thallus(
            desk.path(),
            &["grow", mesh, "-o", folder, "--force", "--elements", "5"],
        );
        assert_eq!(ran.status.code(), Some(1), "{folder}");
        let said = said(&ran);
        assert!(said.contains(file) && said.contains(is), "{said}");
        assert_eq!(
            fs::read(desk.path().join(folder).join(file)).unwrap(),
            before
        );
        assert_eq!(fs::read_dir(desk.path().join(folder)).unwrap().count(), 1);
    }
    let run = grown(desk.path(), "run", "--elements 5");
    fs::write(run.join("mine.txt"), "mine").unwrap();
    for lost in ["report.json", "recipe.toml", "run.log"] {
        fs::remove_file(run.join(lost)).unwrap();
        grown(desk.path(), "run", "--elements 6 --force");
    }
    assert_eq!(fs::read_to_string(run.join("mine.txt")).unwrap(), "mine");
    // A run in a folder with the mesh, and again.
    put("both", "rock.obj", &mesh);
    for elements in ["5", "6"] {
        let words = [
            "grow",
            "both/rock.obj",
            "-o",
            "both",
            "--force",
            "--elements",
            elements,
        ];
        assert!(thallus(desk.path(), &words).status.success());
    }
    assert_eq!(fs::read(desk.path().join("both/rock.obj")).unwrap(), mesh);
}

#[test]
fn a_recipe_repeats_every_byte_from_another_folder() {
    let desk = tempfile::tempdir().unwrap();
    fs::copy(rock(), desk.path().join("rock.obj")).unwrap();
    let grow = |from: &Path, words: &[&str]| {
        let ran = thallus(from, words);
        assert!(ran.status.success(), "{}", said(&ran));
    };
    grow(
        desk.path(),
        &["grow", "rock.obj", "-o", "run", "--elements", "20"],
    );
    let run = desk.path().join("run");
    grow(&run, &["grow", "--recipe", "recipe.toml", "-o", "../again"]);
    for file in ["elements.ply", "recipe.toml", "run.log", "preview.png"] {
        let read = |folder: &str| fs::read(desk.path().join(folder).join(file)).unwrap();
        assert!(read("run") == read("again"), "{file}");
    }
    // A name that leads nowhere from there is of no use.
    let far = tempfile::tempdir().unwrap();
    let away = far.path().join("away");
    grow(
        &run,
        &[
            "grow",
            "--recipe",
            "recipe.toml",
            "-o",
            away.to_str().unwrap(),
        ],
    );
    let named = recipe(&away)["mesh"].as_str().unwrap().to_owned();
    assert!(
        Path::new(&named).is_absolute() && named.ends_with("rock.obj"),
        "{named}"
    );
}

#[test]
fn every_flag_changes_its_line_of_the_recipe_and_no_other() {
    let desk = tempfile::tempdir().unwrap();
    let plain = recipe(&grown(desk.path(), "plain", "--elements 8"));
    let cases: [(&str, &[(&str, toml::Value)]); 15] = [
        (
            "--radius 0.002 --curvature-radius 0.02",
            &[("radius", 0.002.into()), ("curvature-radius", 0.02.into())],
        ),
        (
            "--curvature-radius 0.012",
            &[("curvature-radius", 0.012.into())],
        ),
        ("--bias -0.25", &[("bias", (-0.25).into())]),
        ("--gain 2.5", &[("gain", 2.5.into())]),
        ("--min-stick 0.125", &[("min-stick", 0.125.into())]),
        ("--seed 77", &[("seed", 77.into())]),
        ("--at -1,2,0.5", &[("at", vec![-1.0, 2.0, 0.5].into())]),
        ("--at highest", &[("at", "highest".into())]),
        ("--launch 2", &[("launch", 2.0.into())]),
        ("--kill 20", &[("kill", 20.0.into())]),
        ("--join touch", &[("join", "touch".into())]),
        ("--steps small", &[("steps", "small".into())]),
        ("--steps exact", &[("steps", "exact".into())]),
        ("--boundary absorb", &[("boundary", "absorb".into())]),
        ("--threads 2", &[]),
    ];
    for (i, (flags, changes)) in cases.iter().enumerate() {
        let flags = format!("--elements 8 {flags}");
        let mut expected = plain.clone();
        for (key, value) in *changes {
            expected.insert((*key).to_owned(), value.clone());
        }
        let found = recipe(&grown(desk.path(), &i.to_string(), &flags));
        assert_eq!(found, expected, "{flags}");
    }
    let triangle = recipe(&grown(
        desk.path(),
        "t",
        "--elements 8 --at-triangle 12,0.25,0.5",
    ));
    assert!(triangle.contains_key("at-triangle") && !triangle.contains_key("at"));
    for (flags, key) in [("--reach 4r", "reach"), ("--cover 0.00001", "cover")] {
        let found = recipe(&grown(desk.path(), key, flags));
        assert!(
            found.contains_key(key) && !found.contains_key("elements"),
            "{found}"
        );
    }
}

/// Two separate bumpy sheets, the first larger, in either order in the file.
fn two_pieces(swapped: bool) -> String {
    let sheet = |n: i64, at: f64| {
        let cells = (0..n).flat_map(move |i| (0..n).map(move |j| (i, j)));
        let corner = move |i: i64, j: i64| {
            let y = ((i * 7 + j * 13) % 5) as f64 * 0.0625;
            [at + i as f64 * 0.5, y, j as f64 * 0.5]
        };
        cells.flat_map(move |(i, j)| {
            let [a, b, c, d] = [(0, 0), (0, 1), (1, 1), (1, 0)].map(|(x, y)| corner(i + x, j + y));
            [[a, b, c], [a, c, d]]
        })
    };
    let (large, small) = (sheet(12, 0.0), sheet(7, 50.0));
    let triangles: Vec<_> = match swapped {
        false => large.chain(small).collect(),
        true => small.chain(large).collect(),
    };
    let mut obj = String::new();
    for (t, corners) in triangles.iter().enumerate() {
        for [x, y, z] in corners {
            obj += &format!("v {x} {y} {z}\n");
        }
        obj += &format!("f {} {} {}\n", 3 * t + 1, 3 * t + 2, 3 * t + 3);
    }
    obj
}

#[test]
fn the_order_of_unrelated_pieces_in_the_file_changes_no_byte() {
    let desk = tempfile::tempdir().unwrap();
    let mut tables = Vec::new();
    for (name, swapped) in [("a", false), ("b", true)] {
        let mesh = format!("{name}.obj");
        fs::write(desk.path().join(&mesh), two_pieces(swapped)).unwrap();
        for (place, at) in [("top", "top"), ("small", "51,0,1"), ("random", "random")] {
            let folder = format!("{name}-{place}");
            let words = [
                "grow",
                &mesh,
                "-o",
                &folder,
                "--elements",
                "200",
                "--at",
                at,
            ];
            let output = thallus(desk.path(), &words);
            assert!(output.status.success(), "{}", said(&output));
            tables.push(fs::read(desk.path().join(folder).join("elements.ply")).unwrap());
        }
    }
    assert_ne!(tables[0], tables[1], "the places differ");
    assert_eq!(tables[..3], tables[3..]);
}

#[test]
fn the_shipped_rock_gives_the_same_bytes_whatever_the_threads() {
    let desk = tempfile::tempdir().unwrap();
    let table = |threads: &str| {
        let flags = format!("--elements 400 --threads {threads}");
        fs::read(grown(desk.path(), threads, &flags).join("elements.ply")).unwrap()
    };
    let one = table("1");
    for threads in ["2", "4", "1024"] {
        assert_eq!(table(threads), one, "{threads} threads");
    }
}

/// Otherwise the system ends the program without a word.
#[cfg(unix)]
#[test]
fn a_file_beyond_the_limit_on_sizes_is_an_error() {
    let desk = tempfile::tempdir().unwrap();
    let grow = "exec \"$0\" grow \"$1\" -o out --elements 20000 --quiet --preview 64";
    let mut limited = Command::new("bash");
    limited.args(["-c", &format!("ulimit -f 40; {grow}")]);
    limited.args([env!("CARGO_BIN_EXE_thallus"), &rock()]);
    let output = limited.current_dir(desk.path()).output().unwrap();
    let err = said(&output);
    assert_eq!(output.status.code(), Some(1), "{err}");
    assert!(
        err.contains("run.log") && err.contains("ulimit -f"),
        "{err}"
    );
}

#[cfg(unix)]
fn mkfifo(path: &Path) {
    let made = Command::new("mkfifo").arg(path).status().unwrap();
    assert!(made.success());
}

#[cfg(unix)]
#[test]
fn pipes_that_nothing_writes_into_are_errors() {
    let desk = tempfile::tempdir().unwrap();
    grown(desk.path(), "few", "--elements 5");
    for name in ["pipe", "pipe.obj", "pipe.toml", "pipe.json"] {
        mkfifo(&desk.path().join(name));
    }
    let rock = rock();
    for command in [
        "grow pipe.obj -o out",
        "grow ROCK --recipe pipe.toml -o out",
        "grow --resume pipe",
        "check pipe.obj",
        "analyze pipe",
        "export pipe -o a.csv",
        "skin pipe -o a.glb",
        "skin few --mesh pipe.obj -o a.glb",
        "skin few --colormap pipe.toml -o a.glb",
        "bake pipe -o maps",
        "animate pipe -o a.gif",
        "render pipe -o a.png",
        "render few --camera pipe.json -o a.png",
        "sweep pipe.toml -o grid",
        "sweep pipe.obj --L 5r,6r -o grid",
    ] {
        let line = command.replace("ROCK", &rock);
        let words: Vec<_> = line.split_whitespace().collect();
        let mut run = Command::new("timeout");
        run.args(["20", env!("CARGO_BIN_EXE_thallus")]).args(&words);
        let output = run.current_dir(desk.path()).output().unwrap();
        let said = said(&output);
        assert_eq!(output.status.code(), Some(1), "{command}: {said}");
        assert!(said.contains("error: pipe"), "{command}: {said}");
        assert_eq!(said.lines().count(), 1, "{command}: {said}");
    }
}

/// As `<(command)` of a shell gives them, late and in parts.
#[cfg(unix)]
#[test]
fn recipes_and_elements_may_come_through_pipes() {
    let desk = tempfile::tempdir().unwrap();
    grown(desk.path(), "few", "--elements 5");
    let elements = desk.path().join("few/elements.ply");
    fs::copy(elements, desk.path().join("copy.ply")).unwrap();
    let script = "\"$0\" grow \"$1\" --recipe <(sleep 0.2; cat few/recipe.toml) -o again --quiet --preview 64 \
                  && \"$0\" export <(head -c 300 few/elements.ply; sleep 0.2; tail -c +301 few/elements.ply) \
                  --mesh \"$1\" -o piped.csv && \"$0\" export copy.ply --mesh \"$1\" -o \
                  named.csv";
    let mut shell = Command::new("bash");
    shell.args(["-c", script, env!("CARGO_BIN_EXE_thallus"), &rock()]);
    let output = shell.current_dir(desk.path()).output().unwrap();
    assert!(output.status.success(), "{}", said(&output));
    let bytes = |name: &str| fs::read(desk.path().join(name)).unwrap();
    assert_eq!(bytes("again/elements.ply"), bytes("few/elements.ply"));
    assert_eq!(bytes("piped.csv"), bytes("named.csv"));
}

#[test]
fn errors_are_one_line() {
    let desk = tempfile::tempdir().unwrap();
    fs::write(desk.path().join("broken.toml"), "seed = 1\nbias = = 2\n").unwrap();
    fs::write(desk.path().join("typed.toml"), "bias = \"much\"\n").unwrap();
    fs::write(desk.path().join("key.toml"), "seed = 1\nbiass = 2\n").unwrap();
    fs::write(desk.path().join("part.toml"), "seed = 1.5\n").unwrap();
    fs::write(desk.path().join("far.toml"), "bias = inf\n").unwrap();
    fs::write(desk.path().join("wide.toml"), "curvature-radius = 1e6\n").unwrap();
    let sliver = "v 0 0 0\nv 1 0 0\nv 0.5 1e-9 0\nf 1 2 3\n";
    fs::write(desk.path().join("sliver.obj"), sliver).unwrap();
    grown(desk.path(), "few", "--elements 5");
    grown(desk.path(), "one", "--elements 1");
    fs::create_dir(desk.path().join("cut")).unwrap();
    let log = desk.path().join("few/run.log");
    fs::copy(log, desk.path().join("cut/run.log")).unwrap();
    let far = r#"{"eye": [1e40, 0, 0], "target": [0, 0, 0]}"#;
    fs::write(
        desk.path().join("picture.obj"),
        b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR",
    )
    .unwrap();
    let rock = rock();
    for (words, code, place) in [
        (vec!["grow", &rock, "--recipe", "broken.toml"], 2, "line 2"),
        (vec!["grow", &rock, "--recipe", "typed.toml"], 2, "line 1"),
        (vec!["grow", &rock, "--recipe", "key.toml"], 2, "line 2"),
        (vec!["grow", &rock, "--recipe", "none.toml"], 1, "none.toml"),
        (vec!["grow", &rock, "--recipe", "part.toml"], 2, "whole"),
        (vec!["grow", &rock, "--recipe", "far.toml"], 2, "far.toml"),
        (
            vec!["grow", &rock, "--recipe", "wide.toml"],
            2,
            "wide.toml: curvature-radius",
        ),
        (vec!["grow", &rock, "--keep-sound"], 2, "--resume"),
        (
            vec!["grow", "--resume", "few/recipe.toml"],
            2,
            "few/recipe.toml is a file",
        ),
        (vec!["skin", "few", "-o", "a.glb/"], 2, "leave the slash"),
        (
            vec!["skin", "few", "--lod", "2", "-o", "a.glb/"],
            2,
            "leave the slash",
        ),
        (vec!["render", "few", "-o", "a.png/"], 2, "leave the slash"),
        (vec!["export", "few", "-o", "a.csv/"], 2, "leave the slash"),
        (
            vec!["export", "one", "--what", "curves", "-o", "a.glb"],
            1,
            "error: a.glb: there are no branches",
        ),
        (vec!["grow", "sliver.obj"], 1, "sliver.obj"),
        (vec!["skin", "cut", "-o", "a.glb"], 1, "--resume cut"),
        (
            vec!["render", "few", "-o", "a.png", "--camera", far],
            2,
            "1e15",
        ),
        (vec!["grow", &rock, "--bogus"], 2, "--bogus"),
        (vec!["grow", &rock, "--bias", "x"], 2, "--bias"),
        (vec!["grow", &rock, "--threads", "1025"], 2, "--threads"),
        (vec!["grow", &rock, "--seed", "-1"], 2, "--seed"),
        (vec!["grow", &rock, "--elements", "-1"], 2, "--elements"),
        (vec!["grow", &rock, "--threads", "-1"], 2, "--threads"),
        (vec!["grow", &rock, "--at", "1,2"], 2, "--at"),
        (vec!["grow", &rock, "--reach", "auto"], 2, "--reach"),
        (vec!["export", &rock], 2, "--output"),
        (vec!["check", "picture.obj"], 1, "picture.obj"),
    ] {
        let output = thallus(desk.path(), &words);
        let err = said(&output);
        assert_eq!(output.status.code(), Some(code), "{words:?}: {err}");
        assert!(
            err.starts_with("error: ") && err.contains(place),
            "{words:?}: {err}"
        );
        assert_eq!(err.lines().count(), 1, "{words:?}: {err}");
        assert!(output.stdout.is_empty(), "{words:?}");
    }
}

#[test]
fn a_curvature_radius_that_nothing_grows_with_is_not_measured_by() {
    let desk = tempfile::tempdir().unwrap();
    let folder = grown(desk.path(), "few", "--elements 50");
    let export = |name: &str| {
        let output = thallus(desk.path(), &["export", "few", "-o", name]);
        let table = fs::read_to_string(desk.path().join(name)).unwrap();
        let mut rows = table.lines().map(|row| row.split(','));
        let column = rows.next().unwrap().position(|name| name == "density");
        let density =
            |mut row: std::str::Split<'_, char>| row.nth(column.unwrap()).unwrap().parse();
        let densities: Vec<f32> = rows.map(|row| density(row).unwrap()).collect();
        (said(&output), densities)
    };
    let (_, usual) = export("usual.csv");
    let mut changed = recipe(&folder);
    changed.insert("curvature-radius".to_owned(), 1e308.into());
    fs::write(folder.join("recipe.toml"), changed.to_string()).unwrap();
    let (told, without) = export("without.csv");
    assert!(
        told.contains("curvature radius that no lichen grows with"),
        "{told}"
    );
    let is_near = |(a, b): (&f32, &f32)| (a - b).abs() < 1e-4 * a;
    assert!(
        usual.iter().zip(&without).all(is_near),
        "10 r is the usual one"
    );
}

#[test]
fn a_file_that_is_not_what_its_name_says_is_read_by_its_content() {
    let desk = tempfile::tempdir().unwrap();
    fs::copy(rock(), desk.path().join("rock.stl")).unwrap();
    let output = thallus(desk.path(), &["check", "rock.stl", "--json"]);
    assert!(output.status.success(), "{}", said(&output));
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(answer["triangles"], 4608);
    assert!(answer["repairs"].to_string().contains("OBJ"), "{answer}");
}

#[test]
fn every_format_is_exported() {
    let desk = tempfile::tempdir().unwrap();
    grown(desk.path(), "run", "--elements 30");
    let head = |name: &str, start: &[u8]| {
        let file = format!("cloud.{name}");
        let output = thallus(desk.path(), &["export", "run", "-o", &file]);
        assert!(output.status.success(), "{name}: {}", said(&output));
        let bytes = fs::read(desk.path().join(file)).unwrap();
        assert!(bytes.starts_with(start), "{name}");
    };
    let starts: [(&str, &[u8]); 5] = [
        ("ply", b"ply\n"),
        ("csv", b""),
        ("npy", b"\x93NUMPY"),
        ("npz", b"PK"),
        ("parquet", b"PAR1"),
    ];
    assert_eq!(
        starts.len(),
        thallus::export::FORMATS.len(),
        "a new format needs a line here"
    );
    for (extension, start) in starts {
        head(&format!("out.{extension}"), start);
    }
    let quiet = ["export", "run", "-o", "quiet.ply", "--quiet"];
    let output = thallus(desk.path(), &quiet);
    assert!(output.status.success(), "{}", said(&output));
    assert!(output.stdout.is_empty() && output.stderr.is_empty());
}

/// A file system of 64 kB, unmounted when dropped. Only root may have one.
#[cfg(target_os = "linux")]
struct TinyDisk(tempfile::TempDir);

#[cfg(target_os = "linux")]
impl TinyDisk {
    fn new() -> Option<Self> {
        let at = tempfile::tempdir().unwrap();
        let mount = Command::new("mount")
            .args(["-t", "tmpfs", "-o", "size=64k", "tmpfs"])
            .arg(at.path())
            .output();
        let mounted = mount.is_ok_and(|output| output.status.success());
        mounted.then_some(Self(at))
    }
}

#[cfg(target_os = "linux")]
impl Drop for TinyDisk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(self.0.path()).status();
    }
}

/// Makes room, or takes the permission to write.
#[cfg(target_os = "linux")]
fn remount(place: &Path, option: &str) {
    let options = format!("remount,{option}");
    let mount = Command::new("mount")
        .args(["-o", &options])
        .arg(place)
        .status();
    assert!(mount.unwrap().success());
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_that_leaves_what_can_be_gone_on_with() {
    let Some(disk) = TinyDisk::new() else {
        eprintln!("skipped: no tmpfs may be mounted here");
        return;
    };
    let place = disk.0.path();
    let rock = rock();
    let output = thallus(
        place,
        &["grow", &rock, "-o", "out", "--elements", "3000", "--quiet"],
    );
    let err = said(&output);
    assert_eq!(output.status.code(), Some(1), "{err}");
    assert!(
        err.contains("run.log") && err.contains("make room"),
        "{err}"
    );
    let mut left: Vec<_> = fs::read_dir(place.join("out"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    left.sort();
    assert_eq!(left, ["recipe.toml", "run.log"]);
    remount(place, "size=4m");
    let output = thallus(place, &["grow", "--resume", "out", "--quiet"]);
    assert!(output.status.success(), "{}", said(&output));
    let table = fs::read(place.join("out/elements.ply")).unwrap();
    let desk = tempfile::tempdir().unwrap();
    let whole = grown(desk.path(), "whole", "--elements 3000");
    assert!(table == fs::read(whole.join("elements.ply")).unwrap());
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_cannot_be_written_is_an_error_that_touches_nothing() {
    let Some(disk) = TinyDisk::new() else {
        eprintln!("skipped: no tmpfs may be mounted here");
        return;
    };
    let place = disk.0.path();
    remount(place, "size=4m");
    let folder = grown(place, "out", "--elements 100");
    let log = fs::read(folder.join("run.log")).unwrap();
    remount(place, "ro");
    let words = ["grow", "--resume", "out", "--elements", "200"];
    let output = thallus(place, &words);
    let err = said(&output);
    assert_eq!(output.status.code(), Some(1), "{err}");
    assert!(err.contains("choose a place where you may write"), "{err}");
    assert_eq!(err.lines().count(), 1, "{err}");
    remount(place, "rw");
    assert!(fs::read(folder.join("run.log")).unwrap() == log);
    assert!(thallus(place, &words).status.success());
}
