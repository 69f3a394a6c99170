//! `thallus animate` as it is called.

#[path = "common/desk.rs"]
mod desk;
#[path = "animate_cli/usd.rs"]
mod usd;

use std::fs;
use std::io::Cursor;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use desk::{Desk, assert_refused, assert_refused_in_a_line, names, said};
use thallus::export::read_elements;
use thallus::substrate::Substrate;

const GROWN: &str = "rock.obj --radius 0.4% --elements 400 -o out";

fn animate(desk: &Desk, words: &str) -> Output {
    desk.call("animate", words).output().unwrap()
}

fn made(desk: &Desk, words: &str) {
    let output = animate(desk, words);
    assert!(output.status.success(), "{words}: {}", said(&output));
}

fn refused(desk: &Desk, words: &str, code: i32, parts: &[&str]) {
    assert_refused_in_a_line(&animate(desk, words), code, parts);
}

fn desk() -> Desk {
    let desk = Desk::new();
    desk.done(GROWN);
    desk
}

#[test]
fn frames_are_closed_meshes_in_numbered_files() {
    let desk = desk();
    for format in ["ply", "glb", "obj"] {
        made(
            &desk,
            &format!("out -o f{format} --frames 6 --format {format}"),
        );
        let found = names(&desk.path(&format!("f{format}")));
        let expected: Vec<_> = (1..=6).map(|k| format!("frame_000{k}.{format}")).collect();
        assert_eq!(found, expected);
        let mut triangles = Vec::new();
        for name in &found[1..] {
            let path = desk.path(&format!("f{format}/{name}"));
            let report = Substrate::load(&path).unwrap().report().clone();
            assert_eq!(
                (report.boundary_edges, report.non_manifold_edges),
                (0, 0),
                "{name}"
            );
            triangles.push(report.triangles);
        }
        assert!(triangles.is_sorted_by(|a, b| a < b), "{triangles:?}");
    }
}

#[test]
fn folders_may_have_dots_in_their_names() {
    let desk = desk();
    fs::create_dir(desk.path("there.mov")).unwrap();
    for folder in [
        "there.mov",
        "slash.mov/",
        "slash.ply/",
        "slash.gif/",
        "slash.usda/",
        "B_0.3",
        ".hidden",
    ] {
        made(&desk, &format!("out -o {folder} --frames 1 --what points"));
        assert_eq!(names(&desk.path(folder)), ["frame_0001.ply"], "{folder}");
    }
}

#[test]
fn earlier_frames_are_replaced_only_when_asked_and_all_of_them() {
    let desk = desk();
    made(&desk, "out -o f --frames 5 --window 0");
    fs::write(desk.path("f/notes.txt"), "mine").unwrap();
    fs::write(desk.path("f/frame_9.txt"), "mine").unwrap();
    let before = desk.read("f/frame_0002.ply");
    refused(
        &desk,
        "out -o f --frames 3",
        1,
        &["f exists already", "--force", "animation"],
    );
    assert_eq!(desk.read("f/frame_0002.ply"), before);
    made(&desk, "out -o f --frames 3 --force");
    let expected = [
        "frame_0001.ply",
        "frame_0002.ply",
        "frame_0003.ply",
        "frame_9.txt",
        "notes.txt",
    ];
    assert_eq!(names(&desk.path("f")), expected);
    assert_ne!(desk.read("f/frame_0002.ply"), before);
    // Names that are not frames', or not in a frame's format.
    fs::write(desk.path("f/frame_0001.txt"), "mine").unwrap();
    fs::write(desk.path("f/frame_02.ply"), "mine").unwrap();
    made(&desk, "out -o f --frames 2 --force --format glb");
    let expected = [
        "frame_0001.glb",
        "frame_0001.ply",
        "frame_0001.txt",
        "frame_0002.glb",
        "frame_0002.ply",
        "frame_0003.ply",
        "frame_02.ply",
        "frame_9.txt",
        "notes.txt",
    ];
    assert_eq!(names(&desk.path("f")), expected);
    // What it is read from.
    fs::create_dir(desk.path("s")).unwrap();
    fs::copy(desk.path("out/elements.ply"), desk.path("s/frame_0007.ply")).unwrap();
    let words = "s/frame_0007.ply --mesh rock.obj -o s --frames 2 --force";
    refused(&desk, words, 2, &["s/frame_0007.ply is read for this"]);
    assert_eq!(names(&desk.path("s")), ["frame_0007.ply"]);
    // A folder in a frame's place.
    fs::create_dir(desk.path("f/frame_0005.ply")).unwrap();
    let before = desk.read("f/frame_0002.ply");
    refused(
        &desk,
        "out -o f --frames 3 --force",
        1,
        &["f/frame_0005.ply is a folder"],
    );
    assert_eq!(desk.read("f/frame_0002.ply"), before);
    made(&desk, "out -o a.usda --frames 2");
    refused(
        &desk,
        "out -o a.usda --frames 2",
        1,
        &["a.usda exists already", "--force"],
    );
    made(&desk, "out -o a.usda --frames 2 --force");
}

#[test]
fn the_bytes_are_the_same_on_any_number_of_threads() {
    let desk = desk();
    for (what, extension) in [
        ("skin", "usda"),
        ("skin", "glb"),
        ("points", "usda"),
        ("curves", "glb"),
    ] {
        let [one, three] = [1, 3].map(|threads| {
            let file = format!("a{threads}.{extension}");
            let flags = "--frames 5 --ease smooth --clock radius --force --quiet";
            made(
                &desk,
                &format!("out -o {file} --what {what} {flags} --threads {threads}"),
            );
            desk.read(&file)
        });
        assert!(one == three, "{what} {extension}");
    }
    let [one, three] = [1, 3].map(|threads| {
        made(
            &desk,
            &format!("out -o f{threads} --frames 4 --threads {threads}"),
        );
        desk.read(&format!("f{threads}/frame_0003.ply"))
    });
    assert!(one == three);
}

#[test]
fn points_are_those_that_have_any_influence() {
    let desk = desk();
    made(&desk, "out -o f --what points --frames 4 --window 0");
    let grown = read_elements(&desk.path("out/elements.ply")).unwrap();
    for (k, count) in [(1, 100), (2, 200), (4, 400)] {
        let frame = read_elements(&desk.path(&format!("f/frame_000{k}.ply"))).unwrap();
        assert_eq!(frame.len(), count);
        assert_eq!(frame.parent, grown.parent[..count]);
    }
    let curve = "--clock 0:0,1:40,3:40,4:100%";
    made(
        &desk,
        &format!("out -o g --what points --frames 4 --window 10 {curve}"),
    );
    let counts = [40, 40, 40, 400];
    for (k, count) in counts.into_iter().enumerate() {
        let frame = read_elements(&desk.path(&format!("g/frame_000{}.ply", k + 1))).unwrap();
        // Of the ten that fade in, one has come: 40 is a tenth of the way.
        let born = (count + count / 40 - 1).min(400);
        assert_eq!(frame.len(), born, "frame {}", k + 1);
    }
}

#[test]
fn pictures_move() {
    let desk = desk();
    made(&desk, "out -o p --what picture --frames 2 --width 64");
    let [first, last] = ["p/frame_0001.png", "p/frame_0002.png"].map(|name| desk.read(name));
    assert!(first.starts_with(b"\x89PNG") && last.starts_with(b"\x89PNG") && first != last);
    made(&desk, "out -o p.gif --frames 3 --width 64 --fps 30");
    let bytes = desk.read("p.gif");
    let mut gif = gif::DecodeOptions::new()
        .read_info(bytes.as_slice())
        .unwrap();
    assert_eq!((gif.width(), gif.height()), (64, 48));
    let mut delays = Vec::new();
    while let Some(frame) = gif.read_next_frame().unwrap() {
        delays.push(frame.delay);
    }
    // Thirtieths of a second in hundredths.
    assert_eq!(delays, [3, 4, 3]);
    made(&desk, "out -o q.gif --frames 2 --width 16 --fps 50");
}

/// The bytes of a picture's pixels.
fn pixels(desk: &Desk, name: &str) -> Vec<u8> {
    let bytes = desk.read(name);
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    pixels
}

#[test]
fn pictures_of_the_skin_end_with_that_of_render() {
    let desk = desk();
    let view = "--camera 20,50 --zoom 3 --ground bark --samples 8";
    let words = |rest: &str| format!("{rest} {view} --colormap rhizocarpon");
    made(
        &desk,
        &words("out -o p --what picture --frames 2 --width 64"),
    );
    made(
        &desk,
        &format!("out -o q --what picture --frames 2 --width 64 --draw points {view}"),
    );
    let mut rendered = desk.call("render", &words("out -o r.png --size 64x48"));
    assert!(rendered.output().unwrap().status.success());
    let whole = pixels(&desk, "r.png");
    let differs = |name: &str| {
        let other = pixels(&desk, name);
        assert_eq!(other.len(), whole.len());
        let differ = whole.iter().zip(other).filter(|(a, b)| a.abs_diff(*b) > 2);
        differ.count() as f64 / whole.len() as f64
    };
    // Vertices come in another order, and a ray through an edge may meet its other side.
    assert!(differs("p/frame_0002.png") < 0.01);
    assert!(differs("p/frame_0001.png") > 0.05);
    assert!(differs("q/frame_0002.png") > 0.05);
}

#[test]
fn a_film_without_ffmpeg_says_so_and_leaves_nothing() {
    let desk = desk();
    let mut command = Command::new(env!("CARGO_BIN_EXE_thallus"));
    let words = "animate out -o a.mp4 --frames 2 --width 32";
    command.args(words.split_whitespace()).env("PATH", "");
    let output = command.current_dir(desk.0.path()).output().unwrap();
    let said = said(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("no ffmpeg") && said.contains(".gif"),
        "{said}"
    );
    assert_eq!(names(desk.0.path()), ["out", "rock.obj"]);
}

/// Two that begin apart, and meet.
#[test]
fn several_lichens_grow_in_one_animation() {
    let desk = Desk::new();
    for (name, at) in [("one", "center"), ("two", "0.05,0.6,0.1")] {
        desk.done(&format!(
            "rock.obj --radius 0.4% --elements 120 --at {at} -o {name}"
        ));
    }
    desk.done("rock.obj --radius 0.4% --elements 80 -o few");
    let view = "--what picture --frames 2 --width 64 --samples 1 --camera top --quiet";
    let last = |words: &str, folder: &str| {
        made(&desk, &format!("{words} -o {folder} {view}"));
        desk.read(&format!("{folder}/frame_0002.png"))
    };
    for (n, draw) in ["--draw points", "--draw skin"].iter().enumerate() {
        let one = last(&format!("one {draw}"), &format!("one{n}"));
        let both = last(&format!("one --also two {draw}"), &format!("both{n}"));
        let other = last(&format!("two --also one {draw}"), &format!("other{n}"));
        assert!(both != one, "{draw}");
        assert!(both == other, "{draw}: the same lichens");
        assert!(desk.read(&format!("both{n}/frame_0001.png")) != both);
    }
    let colored = last("one --also two,xanthoria", "colored");
    assert!(colored != desk.read("both1/frame_0002.png"));
    let overlapping = animate(
        &desk,
        "one --also one -o over --what picture --frames 1 --width 32",
    );
    assert!(said(&overlapping).contains("it lies over another"));
    let cases: &[(&str, i32, &[&str])] = &[
        ("one -o a.glb --also two", 2, &["--also is for pictures"]),
        (
            "one -o a.gif --also nowhere",
            1,
            &["--also nowhere", "no such file"],
        ),
        (
            "one -o a.gif --also two,xanthoria --draw points",
            2,
            &["--also two,xanthoria", "by age"],
        ),
        (
            "one -o a.gif --also few --clock 0:0,1:90",
            2,
            &["--also few", "90", "80"],
        ),
        (
            "one -o a.gif --also two,puce",
            2,
            &["--also two,puce", "no colour map 'puce'"],
        ),
    ];
    for (words, code, parts) in cases {
        refused(&desk, words, *code, parts);
    }
}

/// Pictures of bare rock would be a wrong answer.
#[test]
fn a_skin_that_misses_the_lichen_is_refused_in_pictures_too() {
    let desk = desk();
    desk.done("rock.obj --radius 0.05% --elements 1 -o one");
    for out in [
        "f --what skin",
        "f --what picture --width 16",
        "f.gif --width 16",
    ] {
        let words = format!("one -o {out} --frames 2 --falloff 0.8r --resolution 10r");
        refused(&desk, &words, 2, &["resolution", "finer"]);
    }
    assert_eq!(names(desk.0.path()), ["one", "out", "rock.obj"]);
}

#[cfg(unix)]
#[test]
fn interrupted_it_leaves_nothing() {
    let desk = desk();
    for words in [
        "out -o f --frames 100000 --what points",
        "out -o f --frames 100000 --what picture --width 16",
        "out -o f.glb --frames 100000 --threads 1",
        "out -o f.gif --frames 100000 --width 16",
    ] {
        let mut command = desk.call("animate", words);
        let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
        // What it writes is there under another name, or in a file without one.
        let is_there = || fs::read_dir(desk.0.path()).unwrap().count() > 2;
        for _ in 0..300 {
            std::thread::sleep(Duration::from_millis(10));
            if is_there() {
                break;
            }
        }
        let kill = Command::new("kill")
            .args(["-INT", &child.id().to_string()])
            .status();
        assert!(kill.unwrap().success(), "{words}: it ended before");
        assert_eq!(child.wait().unwrap().code(), Some(130), "{words}");
        assert_eq!(names(desk.0.path()), ["out", "rock.obj"], "{words}");
    }
}

/// Puts a program in the place of ffmpeg; where programs then are.
#[cfg(unix)]
fn instead_of_ffmpeg(desk: &Desk, script: &str) -> std::ffi::OsString {
    use std::os::unix::fs::PermissionsExt;
    let bin = desk.path("bin");
    fs::create_dir(&bin).unwrap();
    fs::write(bin.join("ffmpeg"), format!("#!/bin/sh\n{script}\n")).unwrap();
    fs::set_permissions(bin.join("ffmpeg"), fs::Permissions::from_mode(0o755)).unwrap();
    std::env::join_paths([bin, "/usr/bin".into(), "/bin".into()]).unwrap()
}

/// One that says more than a pipe holds before it takes the first picture.
#[cfg(unix)]
#[test]
fn whatever_ffmpeg_says_a_movie_ends() {
    let desk = desk();
    let says = "head -c 300000 /dev/zero >&2; echo >&2; echo all is lost >&2";
    let path = instead_of_ffmpeg(&desk, &format!("{says}; cat > /dev/null; exit 3"));
    let mut command = desk.call("animate", "out -o a.mp4 --frames 3 --width 64");
    let mut child = command
        .env("PATH", path)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    for _ in 0..600 {
        if child.try_wait().unwrap().is_some() {
            break;
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    child.kill().unwrap();
    let output = child.wait_with_output().unwrap();
    assert_refused(&output, 1, &["a.mp4: ffmpeg failed: all is lost"]);
    assert_eq!(names(desk.0.path()), ["bin", "out", "rock.obj"]);
}

/// The second Ctrl-C comes while ffmpeg, which takes no picture here, is waited for.
#[cfg(unix)]
#[test]
fn interrupted_twice_a_movie_leaves_nothing() {
    let desk = desk();
    let path = instead_of_ffmpeg(&desk, "exec sleep 20");
    let mut command = desk.call("animate", "out -o a.mp4 --frames 500 --width 320");
    let mut child = command
        .env("PATH", path)
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let hidden = || names(desk.0.path()).len() > 3;
    for _ in 0..6000 {
        std::thread::sleep(Duration::from_millis(10));
        if hidden() {
            break;
        }
    }
    assert!(hidden(), "it makes its movie in a folder");
    for _ in 0..2 {
        let kill = Command::new("kill")
            .args(["-INT", &child.id().to_string()])
            .status();
        assert!(kill.unwrap().success(), "it has ended before");
        std::thread::sleep(Duration::from_millis(300));
    }
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(names(desk.0.path()), ["bin", "out", "rock.obj"]);
}

#[test]
fn what_cannot_be_is_refused_in_one_line() {
    let desk = desk();
    let cases: &[(&str, i32, &[&str])] = &[
        ("out -o a.ply", 2, &["a.ply", "one frame", "folder"]),
        ("out -o a.mov", 2, &["'.mov'", ".usda", ".mp4", "a.mov/"]),
        ("out -o a.AVI --what picture", 2, &["'.AVI'", ".gif"]),
        ("out -o b/z.webp --format png", 2, &["'.webp'", ".webm"]),
        ("out -o a.gif --what skin", 2, &["pictures", "--what"]),
        ("out -o f --format gif", 2, &["one file", "-o f.gif"]),
        (
            "out -o a.gif --background transparent",
            2,
            &["--background", "PNG"],
        ),
        ("out -o f --what picture --ground mud", 2, &["mud", "bark"]),
        (
            "out -o a.gif --fps 50.5",
            2,
            &["50 frames a second", "50.5", "--fps 50", ".mp4"],
        ),
        ("out -o a.usda --what picture", 2, &["no pictures", ".gif"]),
        (
            "out -o a.usda --camera 30,45",
            2,
            &["--camera is for pictures", "a.usda", ".gif"],
        ),
        ("out -o a.glb --width 960", 2, &["--width", "a.glb"]),
        ("out -o a.usd --draw skin", 2, &["--draw"]),
        (
            "out -o a.gif --up z",
            2,
            &["--up", "pictures, which are as the mesh is"],
        ),
        ("out -o f --ground bark", 2, &["--ground", "--what picture"]),
        ("out -o a.glb --format ply", 2, &["--format", "a.glb"]),
        ("out -o f --format xyz", 2, &["'.xyz'", ".ply"]),
        (
            "out -o f --format a/b.ply",
            2,
            &["--format a/b.ply", "alone"],
        ),
        (
            "out -o f --what points --format b.csv",
            2,
            &["--format b.csv", "alone"],
        ),
        (
            "out -o f --what picture --format ply",
            2,
            &["--what picture is written as png", "--format ply"],
        ),
        ("out -o f --what points --format png", 2, &["--format png"]),
        ("out -o f --what curves --format csv", 2, &["csv", "curves"]),
        ("out -o f --frames 0", 2, &["--frames"]),
        ("out -o f --fps 0", 2, &["--fps"]),
        ("out -o f --window -1", 2, &["--window"]),
        ("out -o f --window 401", 2, &["--window 401", "400"]),
        (
            "out -o a.gif --draw points --taper 0.5",
            2,
            &["--taper is for skins", "a.gif"],
        ),
        (
            "out -o a.usda --what curves --colormap xanthoria",
            2,
            &["--colormap is for skins"],
        ),
        ("out -o f --clock noon", 2, &["noon", "birth", "radius"]),
        ("out -o f --clock 0:0,1:401", 2, &["401", "400"]),
        ("out -o f --clock 0:9,1:3", 2, &["does not shrink"]),
        (
            "out -o f --clock 0:0,1:0.3",
            2,
            &["0.3 elements", "1 or more"],
        ),
        (
            "out -o f --window 500 --clock=-1e308:0,1e308:100%",
            2,
            &["too far apart"],
        ),
        ("out -o f --ease bouncy", 2, &["--ease"]),
        ("out -o f --thickness 99r", 2, &["thickness"]),
        ("nothing -o f", 1, &["nothing"]),
    ];
    for (words, code, parts) in cases {
        refused(&desk, words, *code, parts);
    }
    fs::write(desk.path("c.csv"), "time,elements\n0,0\n1,many\n").unwrap();
    refused(
        &desk,
        "out -o f --clock c.csv",
        2,
        &["c.csv", "line 3", "1,many"],
    );
    assert_eq!(names(desk.0.path()), ["c.csv", "out", "rock.obj"]);
}

#[test]
fn a_lichen_without_branches_has_no_film_of_them() {
    let desk = desk();
    desk.done("rock.obj --radius 0.4% --elements 1 -o one");
    for out in ["a.usda", "a.glb", "f"] {
        let words = format!("one -o {out} --what curves --frames 2");
        let output = animate(&desk, &words);
        assert_eq!(output.status.code(), Some(1), "{out}");
    }
    assert_eq!(names(desk.0.path()), ["one", "out", "rock.obj"]);
}

#[test]
fn curves_may_begin_with_a_byte_order_mark() {
    let desk = desk();
    let curve = "time,elements\n0,0\n1,133\n2,400\n";
    fs::write(desk.path("plain.csv"), curve).unwrap();
    fs::write(desk.path("marked.csv"), format!("\u{feff}{curve}")).unwrap();
    let [plain, marked] = ["plain", "marked"].map(|name| {
        let words = format!("out -o {name}.glb --what points --frames 2 --clock {name}.csv");
        made(&desk, &words);
        desk.read(&format!("{name}.glb"))
    });
    assert_eq!(plain, marked);
}
