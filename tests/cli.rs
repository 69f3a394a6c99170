//! The command as a user meets it: flags, files, messages and exit codes.

#[path = "common/shell.rs"]
mod shell;

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

use shell::{Desk, PLANE, Ran, bumpy};

#[test]
fn help_and_version_are_results() {
    let desk = Desk::new();
    assert!(
        desk.done("--version")
            .out
            .contains(env!("CARGO_PKG_VERSION"))
    );
    for words in ["help --help", "help -h"] {
        assert_eq!(desk.done(words).out, desk.done("help").out, "{words}");
    }
    let help = desk.done("grow --help").out;
    for flag in [
        "--radius",
        "--curvature-radius",
        "--bias",
        "--gain",
        "--min-stick",
        "--seed",
        "--at ",
        "--at-triangle",
        "--launch",
        "--kill",
        "--join",
        "--steps",
        "--boundary",
        "--preset",
        "--recipe",
        "--threads",
        "--quiet",
        "--force",
        "--elements",
        "--reach",
        "--cover",
        "--output",
    ] {
        assert!(help.contains(flag), "{flag}");
    }
}

#[test]
fn wrong_usage_is_2() {
    let desk = Desk::new();
    desk.fails("", 2, &["Usage"]);
    desk.fails("growl plane.obj", 2, &["growl"]);
    desk.fails("grow", 2, &["no mesh to grow on"]);
    desk.fails("grow plane.obj --biass 3", 2, &["--bias"]);
    desk.fails(
        "grow plane.obj --elements 5 --cover 0.5",
        2,
        &["cannot be used with"],
    );
    desk.fails(
        "grow plane.obj --at top --at-triangle 0",
        2,
        &["cannot be used with"],
    );
    desk.fails("grow plane.obj --join glue", 2, &["pack", "touch"]);
    desk.fails(
        "grow plane.obj --radius 3mm",
        2,
        &["3mm", "mesh units have no name"],
    );
    desk.fails(
        "grow plane.obj --threads 0",
        2,
        &["--threads", "give a whole number from 1 to 1024"],
    );
    let only_those_typed = "cannot be used with: --bias <B>; --seed <N>";
    desk.fails(
        "grow --resume out --seed 3 --bias=0.2",
        2,
        &[only_those_typed],
    );
    fs::write(desk.0.path().join("binary"), [0xff, 0xfe]).unwrap();
    desk.fails("grow plane.obj --recipe binary", 1, &["binary", "not text"]);
    desk.fails("grow plane.obj --elements -4", 2, &["-4"]);
    assert!(!desk.path("out").exists());
}

#[test]
fn values_out_of_range_are_2_and_explained() {
    let desk = Desk::new();
    desk.fails(
        "grow plane.obj --bias 3",
        2,
        &["--bias 3", "-1 to 2", "Openness"],
    );
    desk.fails("grow plane.obj --min-stick 0", 2, &["--min-stick 0"]);
    desk.fails("grow plane.obj --cover 1.5", 2, &["--cover 1.5"]);
    desk.fails("grow plane.obj --gain -1", 2, &["--gain -1"]);
    desk.fails("grow plane.obj --elements 0", 2, &["--elements 0"]);
    desk.fails("grow plane.obj --launch 1", 2, &["--launch 1"]);
    desk.fails(
        "grow plane.obj --kill 1.2",
        2,
        &["--kill 1.2", "--launch 1.5"],
    );
    desk.fails(
        "grow plane.obj --preset folios",
        2,
        &["did you mean 'foliose'?"],
    );
    desk.fails(
        "grow plane.obj --radius 100",
        2,
        &["larger than the mesh", "auto"],
    );
    desk.fails("grow plane.obj --radius 2r", 2, &["by itself"]);
    desk.fails(
        "grow plane.obj --curvature-radius 1r",
        2,
        &["--curvature-radius", "2r to 1000r"],
    );
    desk.fails(
        "grow plane.obj --curvature-radius 100",
        2,
        &["--curvature-radius 100", "r here", "2r to 1000r"],
    );
    for (symbol, flag) in [
        ("L", "--curvature-radius"),
        ("B", "--bias"),
        ("A", "--gain"),
    ] {
        let words = format!("grow plane.obj --{symbol} 5");
        desk.fails(&words, 2, &[&format!("{symbol} is {flag}")]);
    }
    desk.fails(
        "grow out/recipe.toml",
        2,
        &["is a recipe by its name", "--recipe out/recipe.toml"],
    );
    desk.put("grid.toml", "seeds = 2\n\n[axes]\nbias = [0.3, 0.5]\n");
    desk.fails(
        "grow plane.obj --recipe grid.toml",
        2,
        &["grid.toml: line 3", "'axes'", "a grid", "thallus sweep"],
    );
    desk.fails(
        "grow plane.obj --at-triangle 2",
        2,
        &["--at-triangle 2", "from 0 to 1"],
    );
    desk.fails(
        "grow plane.obj --at-triangle 0,0.9,0.9",
        2,
        &["outside the triangle"],
    );
    desk.fails("grow plane.obj --at 1000,0,-1000", 2, &["--at", "1000"]);
    assert!(!desk.path("out").exists(), "a refused run leaves nothing");
}

#[test]
fn ranges_are_checked_before_the_mesh_is_read() {
    Desk::new().fails("grow missing.obj --bias 3", 2, &["--bias 3"]);
}

#[test]
fn meshes_that_cannot_be_used_are_1_and_explained() {
    let desk = Desk::new();
    desk.put("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    desk.put("nan.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n");
    desk.put("picture.stl", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR");
    desk.put("empty.ply", "");
    desk.put("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    for (mesh, said) in [
        ("missing.obj", "missing.obj"),
        ("points.obj", "triangles"),
        ("nan.obj", "nan.obj"),
        ("picture.stl", "picture.stl"),
        ("empty.ply", "empty.ply"),
        ("line.obj", "degenerate"),
    ] {
        desk.fails(&format!("grow {mesh} -o out"), 1, &[mesh, said]);
        desk.fails(&format!("check {mesh}"), 1, &[mesh, said]);
    }
    let missing = desk.run("check missing.obj").err;
    assert!(!missing.contains("unfit"), "{missing}");
    assert!(!desk.path("out").exists(), "a failed run leaves nothing");
}

#[test]
fn a_run_writes_its_files_and_says_so() {
    let desk = Desk::new();
    let ran = desk.done("grow plane.obj -o out/run --elements 200");
    assert!(ran.out.contains("out/run: 200 elements"), "{}", ran.out);
    for file in ["elements.ply", "recipe.toml", "report.json"] {
        assert!(desk.path("out/run").join(file).is_file(), "{file}");
    }
    assert!(
        desk.text("recipe.toml".replace("recipe", "out/run/recipe").as_str())
            .contains("elements = 200")
    );
    let report: serde_json::Value =
        serde_json::from_slice(&desk.read("out/run/report.json")).unwrap();
    assert_eq!(report["elements"], 200);
    assert_eq!(report["stopped"], "elements");
    assert!(report["counts"]["walkers"].as_u64().unwrap() >= 199);
    assert!(report["seconds"]["grow"].as_f64().unwrap() > 0.0);
    assert!(report["effective_radius"].as_f64().unwrap() > 0.0);
    assert_eq!(report["mesh"]["triangles"], 2);
}

#[test]
fn without_a_folder_it_goes_by_the_mesh() {
    let desk = Desk::new();
    desk.done("grow plane.obj --elements 5");
    assert!(desk.path("out/plane/elements.ply").is_file());
}

#[test]
fn without_a_folder_no_earlier_run_is_touched() {
    let desk = Desk::new();
    desk.done("grow plane.obj --elements 5");
    let ran = desk.done("grow --recipe out/plane/recipe.toml");
    assert!(
        ran.err
            .contains("out/plane is taken: writing to out/plane-2"),
        "{}",
        ran.err
    );
    let second = Path::new("out").join("plane-2");
    let told = format!("{}: 5 elements", second.display());
    assert!(ran.out.contains(&told), "{}", ran.out);
    desk.done("grow plane.obj --elements 6 --quiet");
    assert_eq!(desk.names_in("out"), ["plane", "plane-2", "plane-3"]);
    let first = desk.read("out/plane/elements.ply");
    assert_eq!(desk.read("out/plane-2/elements.ply"), first);
    desk.done("grow plane.obj --elements 7 --force");
    assert_ne!(desk.read("out/plane/elements.ply"), first);
    assert_eq!(desk.names_in("out").len(), 3);
}

#[test]
fn the_same_recipe_gives_the_same_bytes() {
    let desk = Desk::new();
    desk.put("sheet.obj", bumpy());
    let flags = "--elements 300 --radius 0.3% --bias 0.7 --seed 18446744073709551615 --at -1,2,5 \
                 --curvature-radius 6.5r --min-stick 0.123456789012345";
    desk.done(&format!("grow sheet.obj -o a --threads 1 {flags}"));
    desk.done(&format!("grow sheet.obj -o b --threads 2 {flags}"));
    desk.done(&format!("grow sheet.obj -o c --threads 4 {flags}"));
    desk.done("grow --recipe a/recipe.toml -o d");
    for again in ["b", "c", "d"] {
        for file in ["elements.ply", "recipe.toml"] {
            let same = desk.read(&format!("a/{file}")) == desk.read(&format!("{again}/{file}"));
            assert!(same, "{again}/{file}");
        }
    }
    desk.done("grow sheet.obj -o other --elements 300 --seed 2");
    assert_ne!(desk.read("a/elements.ply"), desk.read("other/elements.ply"));
}

#[test]
fn flags_lie_over_the_recipe_and_the_recipe_over_the_preset() {
    let desk = Desk::new();
    desk.put(
        "mine.toml",
        "mesh = \"plane.obj\"\nbias = 0.8\nelements = 40\n",
    );
    desk.done("grow --recipe mine.toml --preset crustose --elements 30 -o out");
    let recipe = desk.text("out/recipe.toml");
    for line in ["bias = 0.8", "elements = 30", "min-stick = 0.01"] {
        assert!(
            recipe.lines().any(|l| l.starts_with(line)),
            "{line} in {recipe}"
        );
    }
    assert_eq!(radii(&recipe), 20.0, "L of the preset");
}

/// The recipe's L in radii, rounded.
fn radii(recipe: &str) -> f64 {
    let table: toml::Table = recipe.parse().unwrap();
    let number = |key: &str| table[key].as_float().unwrap();
    (number("curvature-radius") / number("radius") * 1e6).round() / 1e6
}

#[test]
fn a_complete_recipe_leaves_a_preset_nothing_to_say() {
    let desk = Desk::new();
    desk.done("grow plane.obj -o a --elements 5");
    let ran = desk.done("grow --recipe a/recipe.toml --preset crustose -o b");
    assert!(
        ran.err.contains("preset crustose changes nothing"),
        "{}",
        ran.err
    );
    assert_eq!(desk.read("a/recipe.toml"), desk.read("b/recipe.toml"));
}

#[test]
fn recipes_that_cannot_be_used_are_explained() {
    let desk = Desk::new();
    desk.put("wrong.toml", "mesh = \"plane.obj\"\nbiass = 0.8\n");
    desk.put("broken.toml", "mesh = plane.obj\n");
    desk.put("bare.toml", "bias = 0.8\n");
    desk.put("gone.toml", "mesh = \"gone.obj\"\n");
    desk.fails(
        "grow --recipe wrong.toml",
        2,
        &["wrong.toml", "line 2", "did you mean 'bias'?"],
    );
    desk.fails("grow --recipe broken.toml", 2, &["broken.toml", "line 1"]);
    desk.fails("grow --recipe bare.toml", 2, &["bare.toml names no mesh"]);
    desk.fails("grow --recipe gone.toml", 1, &["gone.obj", "gone.toml"]);
    desk.fails("grow --recipe missing.toml", 1, &["missing.toml"]);
    desk.fails("grow --recipe plane.obj", 2, &["plane.obj"]);
}

#[test]
fn a_recipe_knows_its_mesh() {
    let desk = Desk::new();
    desk.done("grow plane.obj -o a --elements 20");
    desk.put("plane.obj", PLANE.replace("10", "11"));
    desk.fails(
        "grow --recipe a/recipe.toml -o b",
        1,
        &["plane.obj", "hash"],
    );
    let ran = desk.done("grow plane.obj --recipe a/recipe.toml -o b");
    assert!(ran.err.contains("another mesh"), "{}", ran.err);
}

#[test]
fn a_recipes_mesh_may_lie_beside_it() {
    let desk = Desk::new();
    desk.done("grow plane.obj -o a --elements 20");
    fs::create_dir(desk.path("sent")).unwrap();
    fs::rename(desk.path("plane.obj"), desk.path("sent/plane.obj")).unwrap();
    fs::copy(desk.path("a/recipe.toml"), desk.path("sent/recipe.toml")).unwrap();
    desk.done("grow --recipe sent/recipe.toml -o b");
    assert_eq!(desk.read("a/elements.ply"), desk.read("b/elements.ply"));
}

/// As when a run is sent, or its folder moved: the path is gone, and the hash knows the file.
#[test]
fn a_mesh_whose_path_is_gone_may_lie_beside_the_recipe_or_above() {
    let desk = Desk::new();
    fs::create_dir_all(desk.path("meshes")).unwrap();
    fs::create_dir_all(desk.path("sent/run")).unwrap();
    desk.put("meshes/stone.obj", PLANE);
    let absolute = desk.path("meshes/stone.obj");
    for (name, mesh) in [("a", "meshes/stone.obj"), ("b", absolute.to_str().unwrap())] {
        desk.done(&format!("grow {mesh} -o {name} --elements 20"));
    }
    desk.put("meshes/stone.obj", PLANE.replace("10", "11"));
    for (name, place) in [("a", "sent"), ("b", "sent/run")] {
        fs::copy(
            desk.path(name).join("recipe.toml"),
            desk.path("sent/run/recipe.toml"),
        )
        .unwrap();
        desk.put(&format!("{place}/stone.obj"), PLANE);
        let again = format!("grow --recipe sent/run/recipe.toml -o {name}2");
        desk.done(&again);
        assert_eq!(
            desk.read(&format!("{name}/elements.ply")),
            desk.read(&format!("{name}2/elements.ply"))
        );
        desk.put(&format!("{place}/stone.obj"), PLANE.replace("10", "12"));
        desk.fails(&format!("{again} --force"), 1, &["stone.obj", "hash"]);
        fs::remove_file(desk.path(&format!("{place}/stone.obj"))).unwrap();
    }
}

/// Many meshes have the same name.
#[test]
fn without_a_hash_no_other_folder_is_looked_into() {
    let desk = Desk::new();
    desk.put("hand.toml", "mesh = \"gone/plane.obj\"\nelements = 20\n");
    desk.fails(
        "grow --recipe hand.toml -o out",
        1,
        &["gone/plane.obj", "nor beside the recipe"],
    );
}

#[test]
fn a_recipe_of_another_version_warns() {
    let desk = Desk::new();
    desk.put(
        "old.toml",
        "version = \"0.0.1\"\nmesh = \"plane.obj\"\nelements = 5\n",
    );
    let ran = desk.done("grow --recipe old.toml -o out");
    assert!(ran.err.contains("thallus 0.0.1"), "{}", ran.err);
}

#[test]
fn nothing_is_overwritten_without_force() {
    let desk = Desk::new();
    desk.done("grow plane.obj -o out --elements 20");
    desk.put("out/mine.txt", "keep me");
    let before = desk.read("out/elements.ply");
    desk.fails(
        "grow plane.obj -o out --elements 30",
        1,
        &["out", "--force"],
    );
    assert_eq!(desk.read("out/elements.ply"), before);
    desk.done("grow plane.obj -o out --elements 30 --force");
    assert_ne!(desk.read("out/elements.ply"), before);
    assert_eq!(desk.read("out/mine.txt"), b"keep me");
    fs::create_dir(desk.path("empty")).unwrap();
    desk.done("grow plane.obj -o empty --elements 20");
}

#[test]
fn quiet_says_nothing() {
    let desk = Desk::new();
    let ran = desk.done("grow plane.obj -o out --elements 20 --quiet");
    assert_eq!((ran.out.as_str(), ran.err.as_str()), ("", ""));
    desk.fails("grow plane.obj -o out --quiet", 1, &["--force"]);
}

#[test]
fn sizes_stop_growth() {
    let desk = Desk::new();
    let report = |words: &str| -> serde_json::Value {
        desk.done(&format!(
            "grow plane.obj -o out --force --radius 1% {words}"
        ));
        serde_json::from_slice(&desk.read("out/report.json")).unwrap()
    };
    let reached = report("--reach 20r");
    assert_eq!(reached["stopped"], "reach");
    assert!(reached["effective_radius"].as_f64().unwrap() >= 20.0 * 0.01 * 200f64.sqrt());
    let covered = report("--cover 0.05");
    assert_eq!(covered["stopped"], "cover");
    assert!(covered["covered_share"].as_f64().unwrap() >= 0.05);
}

#[test]
fn a_full_surface_ends_growth() {
    let desk = Desk::new();
    desk.done("grow plane.obj -o out --radius 10% --min-stick 1 --elements 5000");
    let report: serde_json::Value = serde_json::from_slice(&desk.read("out/report.json")).unwrap();
    assert_eq!(report["stopped"], "full", "{report}");
}

#[test]
fn every_choice_grows() {
    let desk = Desk::new();
    let mut tables = Vec::new();
    for (i, flags) in [
        "--join pack",
        "--join touch",
        "--steps small",
        "--boundary absorb",
        "--at highest",
        "--at center",
        "--at random",
        "--at-triangle 1",
        "--at-triangle 0,0.2,0.3",
        "--preset dla",
        "--launch 3 --kill 6",
        "--gain 0 --min-stick 1",
    ]
    .iter()
    .enumerate()
    {
        desk.done(&format!(
            "grow plane.obj -o {i} --radius 1% --elements 60 --quiet {flags}"
        ));
        tables.push(desk.read(&format!("{i}/elements.ply")));
    }
    assert_ne!(tables[0], tables[1], "pack and touch");
    assert_ne!(tables[0], tables[2], "large and small");
}

#[test]
fn folders_that_cannot_be_written_are_1_before_growing() {
    let desk = Desk::new();
    desk.fails("grow plane.obj -o plane.obj", 1, &["plane.obj is a file"]);
    desk.fails(
        "grow plane.obj -o plane.obj/run",
        1,
        &["plane.obj is a file"],
    );
    desk.fails("grow plane.obj -o plane.obj/", 1, &["plane.obj/ is a file"]);
    if cfg!(target_os = "linux") {
        desk.fails("grow plane.obj -o /proc/thallus", 1, &["/proc/thallus"]);
    }
    assert_eq!(desk.text("plane.obj"), PLANE);
}

#[cfg(unix)]
#[test]
fn a_full_disk_leaves_what_can_be_gone_on_with() {
    let desk = Desk::new();
    // A limit on the size of files stands for the full disk; ignored, its signal is an error.
    let script = format!(
        "trap '' XFSZ; ulimit -f 4; exec {} grow plane.obj -o out --elements 2000",
        env!("CARGO_BIN_EXE_thallus")
    );
    let output = Command::new("sh")
        .args(["-c", &script])
        .current_dir(desk.0.path())
        .output();
    let ran = Ran::from(output.unwrap());
    assert_eq!(ran.code, 1, "{}", ran.err);
    assert!(ran.err.contains("run.log"), "{}", ran.err);
    assert!(ran.err.contains("--resume out"), "{}", ran.err);
    assert_eq!(desk.names_in("out"), ["recipe.toml", "run.log"]);
    desk.done("grow --resume out --quiet");
}

#[cfg(target_os = "linux")]
#[test]
fn results_that_cannot_be_printed_are_1() {
    let desk = Desk::new();
    let full = fs::OpenOptions::new()
        .write(true)
        .open("/dev/full")
        .unwrap();
    let output = desk
        .command("check plane.obj")
        .stdout(full)
        .output()
        .unwrap();
    let ran = Ran::from(output);
    assert_eq!(ran.code, 1);
    assert!(ran.err.contains("stdout"), "{}", ran.err);
}

#[cfg(unix)]
#[test]
fn a_closed_pipe_is_success() {
    let desk = Desk::new();
    for words in ["preset list", "check plane.obj", "grow --help"] {
        let mut child = desk
            .command(words)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let ran = Ran::from(child.wait_with_output().unwrap());
        assert_eq!((ran.code, ran.err.as_str()), (0, ""), "{words}");
    }
}

#[cfg(unix)]
#[test]
fn an_interrupt_writes_what_there_is() {
    let desk = Desk::new();
    let mut child = desk
        .command("grow plane.obj -o out --elements 5000000 --radius 0.001%")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    let growing = lines.find(|line| line.as_ref().unwrap().contains("elements/s"));
    assert!(
        growing.is_some(),
        "a line of progress, where there is no terminal"
    );
    let kill = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(kill.unwrap().success());
    let said: String = lines.map(|line| line.unwrap() + "\n").collect();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{said}");
    assert!(
        said.contains("interrupted; what there is was written"),
        "{said}"
    );
    let report: serde_json::Value = serde_json::from_slice(&desk.read("out/report.json")).unwrap();
    assert_eq!(report["stopped"], "cancelled");
    let grown = report["elements"].as_u64().unwrap();
    desk.done("export out --to out.csv");
    assert_eq!(desk.text("out.csv").lines().count() as u64, grown + 1);
    let again = format!("grow --recipe out/recipe.toml --elements {grown} -o again --quiet");
    desk.done(&again);
    let table = |folder: &str| desk.read(&format!("{folder}/elements.ply"));
    assert_eq!(
        table("again"),
        table("out"),
        "the prefix that an uninterrupted run has"
    );
}
#[test]
fn exports_by_extension() {
    let desk = Desk::new();
    desk.done("grow plane.obj -o out --elements 25");
    desk.done("export out --to a.csv");
    assert_eq!(desk.text("a.csv").lines().count(), 26);
    desk.done("export out/elements.ply --to a.npy");
    assert!(desk.read("a.npy").starts_with(b"\x93NUMPY"));
    desk.done("export out --to sub/a.ply");
    let ply = desk.read("sub/a.ply");
    assert!(ply.windows(18).any(|w| w == b"element vertex 25\n"));
    desk.fails("export out --to a.csv", 1, &["a.csv", "--force"]);
    desk.done("export out --to a.csv --force");
    desk.fails("export out --to a.docx", 2, &["docx", ".csv"]);
    desk.fails("export nowhere --to b.csv", 1, &["nowhere"]);
    desk.fails("export plane.obj --to b.csv", 1, &["plane.obj"]);
    desk.fails("export . --to b.csv", 1, &["elements.ply"]);
    assert!(!desk.path("b.csv").exists());
}

#[test]
fn presets_are_listed_and_shown_as_recipes() {
    let desk = Desk::new();
    let list = desk.done("preset list").out;
    for line in list.lines() {
        let name = line.split_whitespace().next().unwrap();
        desk.put("preset.toml", desk.done(&format!("preset show {name}")).out);
        desk.done("grow plane.obj --recipe preset.toml -o a --elements 12 --quiet --force");
        desk.done(&format!(
            "grow plane.obj --preset {name} -o b --elements 12 --quiet --force"
        ));
        assert_eq!(
            desk.read("a/recipe.toml"),
            desk.read("b/recipe.toml"),
            "{name}"
        );
    }
    assert!(list.lines().count() >= 5, "{list}");
    desk.fails("preset show folios", 2, &["did you mean 'foliose'?"]);
}

#[test]
fn the_parameters_page_has_every_parameter_and_preset() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/parameters.md");
    let page = fs::read_to_string(page).unwrap();
    for parameter in thallus::run::PARAMETERS {
        assert!(
            page.contains(&format!("`--{}", parameter.name)),
            "{}",
            parameter.name
        );
    }
    for preset in thallus::run::preset::PRESETS {
        assert!(
            page.contains(&format!("`{}`", preset.name)),
            "{}",
            preset.name
        );
    }
}
