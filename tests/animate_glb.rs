//! A film as one glTF: which frame shows when, and where all of them lie.

#[path = "common/desk.rs"]
mod desk;

use std::fs;

use desk::{Desk, said};
use gltf::animation::{Interpolation, util::ReadOutputs};

fn made(desk: &Desk, words: &str) {
    let output = desk.call("animate", words).output().unwrap();
    assert!(output.status.success(), "{words}: {}", said(&output));
}

fn desk() -> Desk {
    let desk = Desk::new();
    desk.done("rock.obj --radius 0.4% --elements 400 -o out");
    desk
}

/// Seconds at which nodes are switched, and their scales from then on.
fn switches(desk: &Desk, file: &str) -> Vec<Vec<(f32, f32)>> {
    let file = gltf::Gltf::from_slice_without_validation(&desk.read(file)).unwrap();
    let blob = file.blob.clone().unwrap();
    let animation = file.animations().next().unwrap();
    let switches = animation.channels().map(|channel| {
        assert_eq!(channel.sampler().interpolation(), Interpolation::Step);
        let reader = channel.reader(|_| Some(&blob));
        let times = reader.read_inputs().unwrap();
        let Some(ReadOutputs::Scales(scales)) = reader.read_outputs() else {
            panic!("scales")
        };
        times.zip(scales.map(|[x, _, _]| x)).collect()
    });
    switches.collect()
}

#[test]
fn one_glb_shows_a_frame_at_a_time() {
    let desk = desk();
    made(&desk, "out -o a.glb --frames 4 --fps 2 --window 0");
    let expected = [
        vec![(0.0, 1.0), (0.5, 0.0)],
        vec![(0.0, 0.0), (0.5, 1.0), (1.0, 0.0)],
        vec![(0.0, 0.0), (1.0, 1.0), (1.5, 0.0)],
        vec![(0.0, 0.0), (1.5, 1.0), (2.0, 1.0)],
    ];
    assert_eq!(switches(&desk, "a.glb"), expected);
    let file = gltf::Gltf::from_slice_without_validation(&desk.read("a.glb")).unwrap();
    let nodes: Vec<_> = file.nodes().filter(|n| n.mesh().is_some()).collect();
    let scales: Vec<f32> = nodes
        .iter()
        .map(|n| n.transform().decomposed().2[0])
        .collect();
    assert_eq!(scales, [0.0, 0.0, 0.0, 1.0]);
    made(
        &desk,
        "out -o b.glb --frames 4 --fps 2 --window 0 --what points",
    );
    let mut expected = [0.5, 1.0, 1.5].map(|t| vec![(0.0, 0.0), (t, 1.0)]);
    expected[2].push((2.0, 1.0));
    assert_eq!(switches(&desk, "b.glb"), expected);
    let file = gltf::Gltf::from_slice_without_validation(&desk.read("b.glb")).unwrap();
    let count = |m: gltf::Mesh| {
        let primitive = m.primitives().next().unwrap();
        primitive.get(&gltf::Semantic::Positions).unwrap().count()
    };
    assert_eq!(file.meshes().map(count).collect::<Vec<_>>(), [100; 4]);
}

/// The places of the last mesh of a glTF where its nodes move them, and how far.
fn placed(desk: &Desk, file: &str) -> ([f32; 3], Vec<[f32; 3]>) {
    let file = gltf::Gltf::from_slice_without_validation(&desk.read(file)).unwrap();
    let blob = file.blob.clone().unwrap();
    let root = file.scenes().next().unwrap().nodes().next().unwrap();
    let (moved, ..) = root.transform().decomposed();
    let primitive = file.meshes().last().unwrap().primitives().next().unwrap();
    let positions = primitive.reader(|_| Some(&blob)).read_positions().unwrap();
    let place = |p: [f32; 3]| [0, 1, 2].map(|k| p[k] + moved[k]);
    (moved, positions.map(place).collect())
}

/// A viewer takes frames of scale 0 into the box of a film, which were at the origin of its mesh.
#[test]
fn hidden_frames_of_a_glb_lie_inside_the_lichen() {
    let desk = desk();
    let text = String::from_utf8(desk.read("rock.obj")).unwrap();
    let lines = text.lines().map(|line| match line.strip_prefix("v ") {
        Some(v) => {
            let (x, others) = v.split_once(' ').unwrap();
            format!("v {} {others}", x.parse::<f64>().unwrap() + 50.0)
        }
        None => line.to_owned(),
    });
    fs::write(desk.path("aside.obj"), lines.collect::<Vec<_>>().join("\n")).unwrap();
    desk.done("aside.obj --radius 0.4% --elements 60 -o aside");
    for what in ["skin", "points", "curves"] {
        let words = format!("--what {what} --frames 3 --window 0 --force");
        made(&desk, &format!("aside -o film.glb {words}"));
        made(&desk, &format!("aside -o alone {words} --format glb"));
        let (hidden, film) = placed(&desk, "film.glb");
        let (_, alone) = placed(&desk, "alone/frame_0003.glb");
        for k in 0..3 {
            let on_axis = alone.iter().map(|p| p[k]);
            let low = on_axis.clone().fold(f32::INFINITY, f32::min);
            let high = on_axis.fold(f32::NEG_INFINITY, f32::max);
            assert!((low..=high).contains(&hidden[k]), "{what}: {hidden:?}");
        }
        let near = |p: &[f32; 3], q: &[f32; 3]| (0..3).all(|k| (p[k] - q[k]).abs() < 1e-5);
        let is_there = |p: &[f32; 3]| alone.iter().any(|q| near(p, q));
        assert!(film.iter().all(is_there), "{what}");
    }
}
