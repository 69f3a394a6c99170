//! Runs, cells and grids that cannot be.

use std::fs;

use super::{GRID, assert_same, desk, done, files, finished, refused, runs};

#[test]
fn a_run_that_fails_is_told_and_the_others_go_on() {
    let desk = desk();
    let blocked = desk.path("out/cells/L=10r_B=0.3/seed-2");
    fs::create_dir_all(blocked.parent().unwrap()).unwrap();
    fs::write(&blocked, "in the way").unwrap();
    refused(
        &desk,
        &format!("{GRID} -o out"),
        1,
        &[
            "1 run failed: L=10r_B=0.3 seed 2",
            "is a file",
            "tries again",
        ],
    );
    assert_eq!(finished(&desk, "out"), 7);
    let error = desk.read("out/cells/L=10r_B=0.3/seed-2.error.txt");
    assert!(String::from_utf8_lossy(&error).contains("is a file"));
    let csv = String::from_utf8(desk.read("out/results.csv")).unwrap();
    assert_eq!(csv.matches(",failed,").count(), 1);
    assert!(desk.path("out/report.html").is_file());
    fs::remove_file(&blocked).unwrap();
    done(&desk, &format!("{GRID} -o out"));
    done(&desk, &format!("{GRID} -o clean"));
    assert_same(&desk, "out", "clean");
}

/// Of six cells four cannot be: too sharp a curve, and too high a bias.
const HOLED: &str = "plane.obj --L 5r,1r --B 0.3,0.9,7 --seeds 2 --radius 0.4% --reach 18r \
                     --size 48x40 --samples 1";

#[test]
fn cells_that_cannot_be_are_told_and_the_others_go_on() {
    let desk = desk();
    let cells = "L=1r_B=0.3, L=1r_B=0.9, L=5r_B=7, L=1r_B=7";
    let warning =
        format!("4 cells cannot be grown: {cells}; the first one: --curvature-radius 1.0r");
    let names = "L=1r_B=0.3 seed 1, L=1r_B=0.3 seed 2, L=1r_B=0.9 seed 1";
    let failed = format!("8 runs failed: {names}");
    let parts = [&warning, &failed, "2r to 1000r", "in another folder"];
    refused(&desk, &format!("{HOLED} -o out"), 1, &parts);
    assert_eq!(finished(&desk, "out"), 4);
    assert_eq!(runs(&desk, "out").len(), 4, "no folder of what cannot be");
    let error = desk.read("out/cells/L=5r_B=7/seed-2.error.txt");
    assert!(String::from_utf8_lossy(&error).contains("--bias 7 is out of range"));
    let csv = String::from_utf8(desk.read("out/results.csv")).unwrap();
    assert_eq!(csv.matches(",failed,").count(), 8);
    let html = String::from_utf8(desk.read("out/report.html")).unwrap();
    assert_eq!(html.matches("<span class=\"failed\">").count(), 4);
    let command = "L=1r_B=0.3 --radius=0.4% --curvature-radius=1.0r --bias=0.3";
    let error = "seed 1: --curvature-radius 1.0r is out of range";
    assert!(html.contains(command) && html.contains(error));
    for words in ["area<small>, mesh units²</small>", "R_e = 203.6 mesh units"] {
        assert!(html.contains(words), "{words}");
    }

    // The same lichens as without them.
    done(&desk, &format!("{GRID} -o sound --only L=5r_B=0.3"));
    let elements = "cells/L=5r_B=0.3/seed-2/elements.ply";
    let [found, expected] = ["out", "sound"].map(|o| desk.read(&format!("{o}/{elements}")));
    assert!(found == expected);

    // The same again tells them again, and leaves what is finished alone.
    let before = files(&desk.path("out"));
    let time = || {
        desk.path("out")
            .join(elements)
            .metadata()
            .unwrap()
            .modified()
    };
    let grown = time().unwrap();
    refused(&desk, &format!("{HOLED} -o out"), 1, &parts);
    refused(&desk, &format!("{HOLED} -o out --quiet"), 1, &[&failed]);
    assert!(files(&desk.path("out")) == before);
    assert_eq!(time().unwrap(), grown);

    // In parts, and joined.
    for part in 1..=2 {
        let words = format!("{HOLED} --quiet -o part{part} --shard {part}/2");
        refused(&desk, &words, 1, &["4 runs failed: L=1r_B=0.3 seed"]);
    }
    let words = "merge part1 part2 -o joined --quiet";
    refused(&desk, words, 1, &[&failed, "in another folder"]);
    assert_same(&desk, "joined", "out");
    for part in 1..=2 {
        assert!(!desk.path("shared/report.html").exists());
        let words = format!("{HOLED} --quiet -o shared --shard {part}/2");
        refused(&desk, &words, 1, &["runs failed: L=1r_B=0.3 seed"]);
    }
    assert_same(&desk, "shared", "out");
}

/// What a part says that it could not grow is not missing from it.
#[test]
fn a_run_that_failed_in_a_part_is_told_when_parts_are_joined() {
    let desk = desk();
    let blocked = desk.path("part/cells/L=10r_B=0.3/seed-2");
    fs::create_dir_all(blocked.parent().unwrap()).unwrap();
    fs::write(&blocked, "in the way").unwrap();
    let name = "1 run failed: L=10r_B=0.3 seed 2";
    refused(&desk, &format!("{GRID} -o part"), 1, &[name]);
    let again = "thallus sweep joined/grid.toml -o joined tries again";
    let words = "merge part -o joined --quiet";
    refused(&desk, words, 1, &[name, "is a file", again]);
    assert!(desk.path("joined/report.html").is_file());
    done(&desk, "joined/grid.toml -o joined --quiet");
    done(&desk, &format!("{GRID} -o clean"));
    assert_same(&desk, "joined", "clean");

    // Where another part has it, it has not failed.
    fs::remove_file(&blocked).unwrap();
    done(&desk, "merge part clean -o part --quiet");
    assert!(
        !desk
            .path("part/cells/L=10r_B=0.3/seed-2.error.txt")
            .exists()
    );
}

#[test]
fn wrong_grids_are_named_before_anything_is_written() {
    let desk = desk();
    fs::write(
        desk.path("bad.toml"),
        "mesh = \"plane.obj\"\n[axes]\nbiass = [1]\n",
    )
    .unwrap();
    fs::write(desk.path("none.toml"), "[axes]\nbias = [1]\n").unwrap();
    fs::create_dir_all(desk.path("left/cells")).unwrap();
    fs::copy(desk.path("none.toml"), desk.path("left/grid.toml")).unwrap();
    fs::write(
        desk.path("both.toml"),
        "mesh = \"plane.obj\"\nelements = 50\n[axes]\nreach = \"9r,18r\"\n",
    )
    .unwrap();
    for (words, code, parts) in [
        ("plane.obj", 2, ["nothing to compare", "--L 5r,10r,20r"]),
        (
            "plane.obj --B 7,8",
            2,
            ["no cell of the grid can be grown; cell B=7", "-1 to 2"],
        ),
        ("plane.obj --B 0.2,x", 2, ["axis bias", "x"]),
        ("plane.obj --B 0.2,,0.5", 2, ["axis bias", "missing"]),
        (
            "plane.obj --mesh rock.obj --B 0.2,0.5",
            2,
            ["two meshes", "plane.obj and --mesh rock.obj"],
        ),
        ("left", 2, ["left is a folder", "left/grid.toml"]),
        ("left/cells", 2, ["left/cells is a folder", "name a mesh"]),
        (
            "plane.obj --axis biass=1,2",
            2,
            ["biass", "did you mean 'bias'"],
        ),
        (
            "plane.obj --axis seed=1,2",
            2,
            ["seed cannot be an axis", "--seeds"],
        ),
        (
            "plane.obj --B 0.2 --bias 0.3",
            2,
            ["bias is an axis", "keep one"],
        ),
        (
            "plane.obj --B 0.2,0.3 --shard 3/2",
            2,
            ["--shard", "from 1"],
        ),
        ("plane.obj --B 0.2,0.3 --seeds 0", 2, ["--seeds", "0"]),
        ("plane.obj --L 1r,1.5r", 2, ["cell L=1r", "2r to 1000r"]),
        (
            "plane.obj --L 5r,1r --only L=1r",
            2,
            ["--only L=1r", "2r to 1000r"],
        ),
        ("bad.toml", 2, ["bad.toml: line 3", "did you mean 'bias'"]),
        (
            "both.toml",
            2,
            ["both.toml: line 4: reach is an axis", "elements is set"],
        ),
        (
            "plane.obj --B 0.2,0.3 --bias 0.2",
            2,
            ["bias is an axis", "keep one"],
        ),
        ("none.toml", 2, ["none.toml names no mesh", "--mesh"]),
        ("gone.toml", 1, ["gone.toml", "reading the grid failed"]),
        ("gone.obj --B 0.2,0.3", 1, ["gone.obj", "os error 2"]),
    ] {
        refused(&desk, &format!("{words} -o out"), code, &parts);
        assert!(!desk.path("out").exists(), "{words}");
    }
}
