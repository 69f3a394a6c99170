//! Films and frames in USD.

use std::fs;

use super::desk::{Desk, names};
use super::{desk, made, refused};

#[test]
fn usd_has_time_samples() {
    let desk = desk();
    made(
        &desk,
        "out -o a.usda --frames 3 --fps 30 --what points --window 0",
    );
    let text = String::from_utf8(desk.read("a.usda")).unwrap();
    for line in [
        "startTimeCode = 1",
        "endTimeCode = 3",
        "timeCodesPerSecond = 30",
        "framesPerSecond = 30",
    ] {
        assert!(text.contains(line), "{line}");
    }
    let frames = |array: &str| -> Vec<Vec<f64>> {
        let (_, rest) = text
            .split_once(&format!("{array}.timeSamples = {{"))
            .unwrap();
        let frames = rest.split('}').next().unwrap().lines();
        let numbers = frames.filter_map(|line| line.split_once('['));
        let numbers = numbers.map(|(_, line)| line.split_once(']').unwrap().0.split(", "));
        numbers
            .map(|frame| frame.map(|x| x.parse().unwrap()).collect())
            .collect()
    };
    for array in ["int64[] ids", "float[] primvars:pscale"] {
        let counts: Vec<usize> = frames(array).iter().map(Vec::len).collect();
        assert_eq!(counts, [133, 266, 400], "{array}");
    }
    assert_eq!(frames("int[] primvars:colony")[0], [0.0; 133]);
    // The age among all, whatever there is in the frame.
    let nage = &frames("float[] primvars:nage")[1];
    assert!(nage[0] == 1.0 && (nage[265] - 134.0 / 399.0).abs() < 1e-6);
}

#[test]
fn frames_are_numbered_from_where_they_are_to_start() {
    let desk = desk();
    made(
        &desk,
        "out -o f --format csv --what points --frames 3 --start 1001",
    );
    let frames = |numbers: &[u32]| -> Vec<String> {
        numbers
            .iter()
            .map(|n| format!("frame_{n:04}.csv"))
            .collect()
    };
    assert_eq!(names(&desk.path("f")), frames(&[1001, 1002, 1003]));
    made(
        &desk,
        "out -o f --format csv --what points --frames 2 --start 0 --force",
    );
    assert_eq!(names(&desk.path("f")), frames(&[0, 1]));
    made(
        &desk,
        "out -o film.usda --what points --frames 2 --start 1001",
    );
    let film = String::from_utf8(desk.read("film.usda")).unwrap();
    for part in [
        "startTimeCode = 1001\n",
        "endTimeCode = 1002\n",
        " 1001: [",
        " 1002: [",
    ] {
        assert!(film.contains(part), "{part}");
    }
    assert!(!film.contains(" 1: [") && !film.contains(" 1003: ["));
    made(&desk, "out -o film.glb --what points --frames 2 --start 9");
    let film = desk.read("film.glb");
    let has = |name: &str| film.windows(name.len()).any(|w| w == name.as_bytes());
    assert!(has("\"frame 0009\"") && has("\"frame 0010\"") && !has("\"frame 0001\""));
    let words = "out -o film.gif --frames 2 --start 2";
    refused(&desk, words, 2, &["--start", "film.gif"]);
}

/// What is small needs an origin of its own sooner than what it is part of, and farther away each has another middle.
#[test]
fn numbered_frames_lie_about_one_origin() {
    let desk = desk();
    fs::write(desk.path("far.obj"), far_rock(&desk, [0, 1, 2])).unwrap();
    desk.done("rock.obj --radius 0.1% --elements 400 -o small");
    desk.done("far.obj --radius 0.4% --elements 400 -o far");
    for (lichen, what, lies_far) in [
        ("small", "skin", false),
        ("far", "skin", true),
        ("far", "points", true),
    ] {
        let out = format!("{lichen}-{what}");
        let words = format!("{lichen} -o {out} --what {what} --format usda --frames 12");
        made(&desk, &words);
        let frames = names(&desk.path(&out));
        let moved = frames.iter().map(|frame| {
            let text = String::from_utf8(desk.read(&format!("{out}/{frame}"))).unwrap();
            let mut lines = text.lines();
            let moved = lines.find(|line| line.contains("xformOp:translate ="));
            moved.map(str::to_owned)
        });
        let moved: Vec<Option<String>> = moved.collect();
        assert_eq!((moved.len(), moved[0].is_some()), (12, lies_far), "{out}");
        let same = moved.iter().all(|origin| *origin == moved[0]);
        assert!(same, "{out}: {moved:?}");
    }
}

/// The rock in map coordinates, with its axes in this order.
fn far_rock(desk: &Desk, axes: [usize; 3]) -> String {
    let far = [500_000.0, 112.0, -5_400_000.0];
    let place = |line: &str| {
        let numbers: Vec<f64> = line[2..].split(' ').map(|x| x.parse().unwrap()).collect();
        let there = [0, 1, 2].map(|k| numbers[k] + far[k]);
        let sign = if axes[1] == 2 { -1.0 } else { 1.0 };
        let [x, y, z] = [there[0], sign * there[axes[1]], there[axes[2]]];
        format!("v {x} {y} {z}")
    };
    let file = String::from_utf8(desk.read("rock.obj")).unwrap();
    let lines = file.lines().map(|line| match line.starts_with("v ") {
        true => place(line),
        false => line.to_owned(),
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// Far from its origin a film's places are stored from one of its own: where the film lies, not where the elements
/// lay before a program turned the mesh.
#[test]
fn a_film_on_a_turned_mesh_far_away_is_as_fine_as_on_the_other() {
    let desk = desk();
    let [upright, turned] = [[0, 1, 2], [0, 2, 1]].map(|axes| far_rock(&desk, axes));
    fs::write(desk.path("far.obj"), upright).unwrap();
    fs::write(desk.path("turned.obj"), turned).unwrap();
    desk.done("far.obj --radius 0.4% --elements 60 -o far");
    made(&desk, "far -o far.usda --frames 2 --up y");
    made(
        &desk,
        "far -o turned.usda --frames 2 --mesh turned.obj --up y",
    );
    let size = |file: &str| {
        let text = String::from_utf8(desk.read(file)).unwrap();
        let after = text.split("float3[] extent").nth(1).unwrap();
        let line = after.lines().find(|line| line.contains("2: ")).unwrap();
        let numbers: Vec<f64> = line
            .split(|c: char| !(c.is_ascii_digit() || ".-e".contains(c)))
            .filter_map(|x| x.parse().ok())
            .collect();
        let [low, high] = [&numbers[1..4], &numbers[4..7]];
        [0, 1, 2].map(|k| high[k] - low[k])
    };
    let [[x, y, z], turned] = ["far.usda", "turned.usda"].map(size);
    let near = |(a, b): (f64, f64)| (a - b).abs() < 1e-3 * a;
    let pairs = std::iter::zip([x, z, y], turned);
    assert!(pairs.into_iter().all(near), "{x} {z} {y} {turned:?}");
}
