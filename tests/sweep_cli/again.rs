//! What a sweep does when it is called again, stopped, or finds less than it left.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, SystemTime};

use super::desk::{Desk, said};
use super::found::{SMALL, damaged_log};
use super::{GRID, LONG, assert_same, command, desk, done, finished, refused, runs, wait_for};

fn written(desk: &Desk, file: &str) -> SystemTime {
    let file = desk.path(file).metadata().unwrap();
    file.modified().unwrap()
}

/// Takes from a run what only a finished one has.
fn unfinish(desk: &Desk, run: &str) {
    for name in ["measures.json", "elements.ply", "report.json"] {
        fs::remove_file(desk.path(&format!("{run}/{name}"))).unwrap();
    }
}

/// The disk may be back tomorrow, and the log sound.
#[cfg(target_os = "linux")]
#[test]
fn a_log_whose_head_cannot_be_read_is_no_damaged_one() {
    let desk = desk();
    done(&desk, &format!("{SMALL} -o out"));
    let run = "out/cells/L=5r/seed-1";
    unfinish(&desk, run);
    let log = desk.path(&format!("{run}/run.log"));
    fs::remove_file(&log).unwrap();
    std::os::unix::fs::symlink("/proc/self/mem", &log).unwrap();
    for words in ["", "--only L=5r"] {
        let parts = [
            "1 run failed: L=5r seed 1",
            "run.log: reading the log failed",
        ];
        refused(&desk, &format!("{SMALL} -o out {words}"), 1, &parts);
        assert!(log.is_symlink());
    }
}

/// Hours of growing may be in the log.
#[test]
fn a_cell_alone_goes_on_where_it_is_unfinished_and_begins_anew_where_it_is_finished() {
    let desk = desk();
    let grid = LONG
        .replace("--L 5r,10r,20r --B 0.3,0.9", "--L 5r,10r --seeds 2")
        .replace("6000", "2500")
        .replace("--quiet", "");
    done(&desk, &format!("{grid} -o clean"));
    done(&desk, &format!("{grid} -o out"));
    let [first, second] = [1, 2].map(|seed| format!("out/cells/L=5r/seed-{seed}"));
    let log = damaged_log(&desk, &second);
    unfinish(&desk, &second);
    fs::write(desk.path(&format!("{second}/run.log")), log).unwrap();

    let elements = format!("{first}/elements.ply");
    let before = written(&desk, &elements);
    let only = format!("{grid} -o out --only L=5r");
    let told = said(&done(&desk, &only));
    assert!(told.contains("goes on from the 500 elements"), "{told}");
    assert_eq!(
        written(&desk, &elements),
        before,
        "what is finished is kept"
    );
    assert_same(&desk, "out", "clean");

    done(&desk, &only);
    assert!(written(&desk, &elements) != before, "grown anew");
    assert_same(&desk, "out", "clean");

    // What is of another run is replaced.
    unfinish(&desk, &second);
    let [other, log] = ["out/cells/L=10r/seed-2", &second].map(|run| format!("{run}/run.log"));
    fs::copy(desk.path(&other), desk.path(&log)).unwrap();
    let parts = ["of another run than this sweep's", "--only L=5r"];
    refused(&desk, &format!("{grid} -o out"), 1, &parts);
    done(&desk, &only);
    assert_same(&desk, "out", "clean");
}

#[test]
fn a_finished_run_that_goes_while_others_grow_is_missed() {
    let desk = desk();
    done(&desk, &format!("{LONG} -o out --only L=5r_B=0.9"));
    let gone = runs(&desk, "out").pop().unwrap();
    let mut child = command(&desk, &format!("{LONG} -o out"));
    let child = child.stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = child.spawn().unwrap();
    wait_for(|| runs(&desk, "out").len() > 1);
    fs::remove_dir_all(gone).unwrap();
    let output = child.wait_with_output().unwrap();
    let parts = [
        "5 of 6 runs are finished",
        "what 1 run came to is gone, or cannot be read: L=5r_B=0.9 seed 1",
        "the same command",
    ];
    super::desk::assert_refused(&output, 1, &parts);
    assert!(!desk.path("out/report.html").exists());
}

/// A picture of many pixels takes longer than anybody waits who has asked to stop.
#[cfg(unix)]
#[test]
fn ctrl_c_ends_a_picture_that_is_being_taken() {
    let desk = desk();
    let grid = "plane.obj --L 5r,1r --radius 0.4% --elements 60 --size 2000x2000 --samples 64";
    let mut child = command(&desk, &format!("{grid} --threads 2 -o out"));
    let child = child.stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = child.spawn().unwrap();
    wait_for(|| desk.path("out/results.parquet").exists());
    sleep(Duration::from_secs(1));
    let kill = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(kill.unwrap().success());
    let output = child.wait_with_output().unwrap();
    let told = said(&output);
    assert_eq!(output.status.code(), Some(130), "{told}");
    let ended = "every run has ended, 1 of them failed; the page is not made";
    assert!(told.contains(ended), "{told}");
    let pictures = fs::read_dir(desk.path("out/pictures"))
        .into_iter()
        .flatten();
    assert_eq!(pictures.count(), 0, "none was finished");
}

#[test]
fn why_a_run_cannot_be_grown_is_written_once() {
    let desk = desk();
    let words = SMALL.replace("5r,10r", "5r,1r");
    let parts = ["1 run failed: L=1r seed 1"];
    refused(&desk, &format!("{words} -o out"), 1, &parts);
    let error = "out/cells/L=1r/seed-1.error.txt";
    let before = written(&desk, error);
    refused(&desk, &format!("{words} -o out"), 1, &parts);
    assert_eq!(written(&desk, error), before);
    fs::write(desk.path(error), "something else\n").unwrap();
    refused(&desk, &format!("{words} -o out"), 1, &parts);
    assert!(String::from_utf8_lossy(&desk.read(error)).contains("2r to 1000r"));
}

#[test]
fn parts_are_joined_into_a_folder_and_the_first_missing_ones_named() {
    let desk = desk();
    let many = "1/10000000000";
    let parts = ["--shard", "a million parts at most"];
    refused(&desk, &format!("{SMALL} -o part --shard {many}"), 2, &parts);
    done(&desk, &format!("{SMALL} -o part --shard 1/1000"));
    let parts = ["parts 1/1000", "2/1000, 3/1000", "991 more are missing"];
    refused(&desk, "merge part -o joined --quiet", 1, &parts[1..]);
    // As an earlier program wrote it.
    let mark = |of: &str| desk.path(&format!("part/part-1-of-{of}.txt"));
    fs::rename(mark("1000"), mark("10000000000")).unwrap();
    let parts = ["1 run is in none of the folders: L="];
    refused(&desk, "merge part -o joined --quiet", 1, &parts);

    done(&desk, &format!("{GRID} -o whole"));
    let parts = ["out.html", "folder"];
    refused(&desk, "merge whole -o out.html --quiet", 2, &parts);
    assert!(!desk.path("out.html").exists());
    assert_eq!(finished(&desk, "whole"), 8);
}

/// The same grid in other words.
#[test]
fn numbers_written_otherwise_are_the_same_sweep() {
    let desk = desk();
    let words = "plane.obj --radius 0.4% --size 48x40 --samples 1 --quiet -o out";
    done(&desk, &format!("{words} --B 0,1 --axis elements=60,1e2"));
    done(
        &desk,
        &format!("{words} --B 0.0,1.0 --axis elements=6e1,100"),
    );
    let run: PathBuf = desk.path("out/cells/B=1_elements=100/seed-1");
    assert!(run.is_dir());
}

/// A card whose leaf is cut out of an image.
fn put_card(desk: &Desk, alphas: [u8; 2]) {
    let texels = alphas.map(|alpha| [60, 160, 60, alpha]);
    let mut image = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut image, 2, 1);
    encoder.set_color(::png::ColorType::Rgba);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(texels.as_flattened()).unwrap();
    writer.finish().unwrap();
    fs::write(desk.path("leaf.png"), image).unwrap();
    let library = "newmtl Leaf\nmap_Kd -clamp on leaf.png\nmap_d leaf.png\n";
    fs::write(desk.path("card.mtl"), library).unwrap();
    let card = "mtllib card.mtl\nusemtl Leaf\nv 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\n\
                vt 0 0\nvt 0 1\nvt 1 1\nvt 1 0\nf 1/1 2/2 3/3 4/4\n";
    fs::write(desk.path("card.obj"), card).unwrap();
}

#[test]
fn pictures_are_taken_again_where_the_mesh_is_cut_out_in_another_way() {
    let desk = desk();
    let sweep = format!("{} -o out", SMALL.replace("plane", "card"));
    let picture = || {
        done(&desk, &sweep);
        desk.read("out/pictures/L=5r.png")
    };
    put_card(&desk, [255, 0]);
    let first = picture();
    assert!(picture() == first);
    put_card(&desk, [0, 255]);
    assert!(picture() != first);
}
