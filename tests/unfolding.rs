//! Traces against the geodesics of surfaces that unroll, and over every mesh there is.
//!
//! Tolerances are in local units (a mesh is about 1 across) and stand well above what is measured;
//! a wrong frame or a wrong edge is off by the size of a triangle.
#![allow(clippy::print_stdout, clippy::print_stderr)] // measurements, for whoever asks to see them

mod common;
#[path = "common/paths.rs"]
mod paths;
#[path = "common/shapes.rs"]
mod shapes;

use std::path::{Path as FilePath, PathBuf};

use glam::{DVec2, DVec3};
use paths::{Path, survey};
use rayon::prelude::*;
use shapes::*;
use thallus::rng::Stream;
use thallus::substrate::Substrate;
use thallus::walk::{End, SurfacePoint, Trace, trace, trace_visiting};

const CLOSE: f64 = 1e-9;

/// A random triangle, number among the file's, and a point inside.
fn random_point(substrate: &Substrate, stream: &mut Stream) -> SurfacePoint {
    let triangle = (stream.uniform() * substrate.triangles().len() as f64) as u32;
    let (a, b) = (stream.uniform(), stream.uniform());
    SurfacePoint::from_weights(triangle, [a * (1.0 - b), a * b, 1.0 - a])
}

/// A trace by a vector in space (file units) that lies in the start triangle's plane.
fn go(substrate: &Substrate, from: &SurfacePoint, step: DVec3) -> Trace {
    let local = step * substrate.units().length_to_local(1.0);
    trace(
        substrate,
        from,
        in_chart(substrate, from.triangle, local),
        false,
    )
}

fn file_position(substrate: &Substrate, p: &SurfacePoint) -> DVec3 {
    substrate.units().to_file(substrate.position(p))
}

/// A coordinate folded into [0, length] by mirrors at both ends.
fn mirrored(x: f64, length: f64) -> f64 {
    let x = x.rem_euclid(2.0 * length);
    x.min(2.0 * length - x)
}

#[test]
fn a_cylinder_unrolls() {
    for (sides, rows) in [(3, 1), (7, 2), (200, 3)] {
        let prism = Prism { sides, height: 2.5 };
        let mesh = prism.mesh(rows);
        let mut stream = stream(10);
        for _ in 0..2000 {
            let from = random_point(&mesh, &mut stream);
            let p = file_position(&mesh, &from);
            let turn = p.z.atan2(p.x).rem_euclid(std::f64::consts::TAU);
            let side = (turn / (std::f64::consts::TAU / sides as f64)).floor() * prism.width();
            let edge = prism.roll(side + 1e-13, 0.0);
            let s = side + DVec3::new(p.x - edge.x, 0.0, p.z - edge.z).length();
            let across = (prism.roll(side + 0.9 * prism.width(), 0.0) - edge).normalize();
            let d = direction(&mut stream) * 30.0 * stream.uniform();
            let end = go(&mesh, &from, across * d.x + DVec3::Y * d.y);
            let expected = prism.roll(s + d.x, mirrored(p.y + d.y, prism.height));
            let error = file_position(&mesh, &end.point).distance(expected);
            assert!(error < CLOSE, "{sides} sides: {error:e} after {d}");
        }
    }
}

/// Straight on the unrolled cone is straight in the plane: the distance from the apex and the
/// angle about it follow, however often that winds about a narrow cone.
#[test]
fn cones_unroll_the_narrow_and_the_saddle() {
    for (angle, faces) in [
        (0.2, 5),
        (1.0, 3),
        (4.5, 40),
        (6.0, 7),
        (8.0, 12),
        (14.0, 40),
    ] {
        let cone = Cone { angle, faces };
        let (mesh, face_of) = cone.mesh(&[0.1, 0.35, 0.6, 1.0]);
        // The rim is a polygon; inside this circle no path meets it.
        let safe = 0.999 * (cone.face_angle() / 2.0).cos();
        let (mut stream, mut done) = (stream(11), 0);
        while done < 2000 {
            let from = random_point(&mesh, &mut stream);
            let face = face_of[mesh.source_triangle(from.triangle) as usize];
            let (distance, turn) = cone.unroll(face, file_position(&mesh, &from));
            let d = direction(&mut stream) * 2.0 * stream.uniform();
            let (p, q) = (DVec2::new(distance, 0.0), DVec2::new(distance, 0.0) + d);
            if distance > safe || q.length() > safe {
                continue;
            }
            done += 1;
            let out = cone.roll(1.0, turn);
            let ahead = cone.generator(face).cross(cone.generator(face + 1));
            let across = ahead.cross(out).normalize();
            let end = go(&mesh, &from, out * d.x + across * d.y);
            let swept = p.perp_dot(q).atan2(p.dot(q));
            let error =
                file_position(&mesh, &end.point).distance(cone.roll(q.length(), turn + swept));
            assert!(error < CLOSE, "angle {angle}: {error:e}");
        }
    }
}

/// Where a cube rolled over the plane has its walker: the point and its face's axes turn by
/// quarter turns at each edge.
fn roll_cube(mut p: DVec3, mut d: DVec3, mut left: f64) -> DVec3 {
    loop {
        let n = (0..3)
            .find(|&k| p[k].abs() == 1.0 && d[k] == 0.0)
            .expect("on a face");
        let reach = |k: usize| ((d[k].signum() - p[k]) / d[k]).max(0.0);
        let k = (0..3)
            .filter(|&k| k != n && d[k] != 0.0)
            .min_by(|&a, &b| reach(a).total_cmp(&reach(b)))
            .expect("a direction");
        let length = reach(k);
        if length >= left {
            return p + d * left;
        }
        p += d * length;
        left -= length;
        p[k] = d[k].signum();
        // Over the edge: what went outwards along k now goes inwards along n.
        let (outwards, normal) = (d[k].abs(), p[n]);
        d[k] = 0.0;
        d[n] = -normal * outwards;
    }
}

#[test]
fn a_cube_rolls_over_the_plane() {
    for n in [1, 4] {
        let mesh = cube(n);
        let mut stream = stream(12);
        for _ in 0..4000 {
            let from = random_point(&mesh, &mut stream);
            let mut p = file_position(&mesh, &from);
            let face = (0..3)
                .find(|&k| (p[k].abs() - 1.0).abs() < 1e-12)
                .expect("a face");
            p[face] = p[face].round();
            let flat = direction(&mut stream);
            let mut d = DVec3::ZERO;
            (d[(face + 1) % 3], d[(face + 2) % 3]) = (flat.x, flat.y);
            let length = 40.0 * stream.uniform();
            let end = go(&mesh, &from, d * length);
            let error = file_position(&mesh, &end.point).distance(roll_cube(p, d, length));
            assert!(error < CLOSE, "{n} squares: {error:e}");
        }
    }
}

/// The three kinds of closed geodesic through a cube's face: the square belt (length 4 sides), the
/// hexagon at 45 degrees (3√2 sides), and the one of slope 1/2 (2√5 sides).
#[test]
fn a_cubes_closed_geodesics_close() {
    let mesh = cube(3);
    let (from, _) = mesh.nearest(mesh.units().to_local([1.0, 0.1234, -0.3456]));
    for (y, z) in [(1.0, 0.0), (1.0, 1.0), (1.0, 2.0)] {
        let d = DVec3::new(0.0, y, z);
        let length = match z {
            0.0 => 4.0,
            1.0 => 3.0 * 2f64.sqrt(),
            _ => 2.0 * 5f64.sqrt(),
        };
        let end = go(&mesh, &from, d.normalize() * 2.0 * length);
        let error = file_position(&mesh, &end.point).distance(file_position(&mesh, &from));
        println!("{z}: {error:e}");
        assert!(error < CLOSE, "{d}: {error:e}");
    }
}

fn rectangles() -> Vec<Substrate> {
    let with_needles = vec![0.0, 0.3, 0.3 + 1e-6, 0.3 + 2e-6, 0.55, 0.55 + 1e-6, 1.0];
    vec![
        rectangle(&[0.0, 3.0], &[0.0, 1.0], None),
        rectangle(&even(3.0, 17), &even(1.0, 5), None),
        rectangle(&even(3.0, 17), &even(1.0, 5), Some(stream(13))),
        rectangle(&with_needles, &with_needles, Some(stream(14))),
        rectangle(&even(1.0, 1), &with_needles, Some(stream(15))),
    ]
}

/// Reflection is the mirror-image formula, with any winding, and over needles of aspect 1e6.
#[test]
fn a_rectangle_reflects_as_its_mirror_images() {
    for (i, mesh) in rectangles().iter().enumerate() {
        let [_, size] = mesh.units().bounding_box();
        let mut stream = stream(16);
        let mut worst = 0.0f64;
        for _ in 0..4000 {
            let from = random_point(mesh, &mut stream);
            let d = direction(&mut stream) * 50.0 * stream.uniform();
            let end = go(mesh, &from, d.extend(0.0));
            assert_eq!(end.end, End::Distance);
            let p = file_position(mesh, &from).truncate() + d;
            let expected = DVec2::new(mirrored(p.x, size.x), mirrored(p.y, size.y));
            let error = file_position(mesh, &end.point)
                .truncate()
                .distance(expected);
            worst = worst.max(error);
        }
        println!("rectangle {i}: {worst:e}");
        assert!(
            worst < if i < 3 { CLOSE } else { 1e-6 },
            "rectangle {i}: {worst:e}"
        );
    }
}

#[test]
fn a_rectangle_absorbs_where_the_line_leaves_it() {
    for mesh in &rectangles() {
        let [_, size] = mesh.units().bounding_box();
        let mut stream = stream(17);
        for _ in 0..2000 {
            let from = random_point(mesh, &mut stream);
            let p = file_position(mesh, &from).truncate();
            let d = direction(&mut stream) * 2.0 * stream.uniform();
            let local = d * mesh.units().length_to_local(1.0);
            let end = trace(
                mesh,
                &from,
                in_chart(mesh, from.triangle, local.extend(0.0)),
                true,
            );
            let exit = |p: f64, d: f64, size: f64| if d > 0.0 { (size - p) / d } else { -p / d };
            let share = exit(p.x, d.x, size.x).min(exit(p.y, d.y, size.y));
            let expected = p + d * share.min(1.0);
            let error = file_position(mesh, &end.point)
                .truncate()
                .distance(expected);
            assert!(error < 1e-8, "{error:e}");
            assert_eq!(end.end == End::Boundary, share < 1.0);
        }
    }
}

/// A path into a narrow wedge is reflected π/angle times on its way to the tip and out again: the
/// worst case of a needle. The unrolled wedge says where it comes out.
#[test]
fn a_wedge_winds_a_path_up_and_lets_it_out() {
    for angle in [0.3f64, 1e-2, 1e-4, 1e-5] {
        let (sin, cos) = angle.sin_cos();
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [cos, sin, 0.0]];
        let mesh = common::substrate(positions, vec![[0, 1, 2]]);
        let turn = 0.4 * angle;
        let p = DVec2::from_angle(turn) * 0.5;
        let (from, _) = mesh.nearest(mesh.units().to_local([p.x, p.y, 0.0]));
        let d = DVec2::from_angle(turn + 3.0) * 1.2;
        let end = go(&mesh, &from, d.extend(0.0));
        let q = p + d;
        let swept = p.perp_dot(q).atan2(p.dot(q));
        let expected = DVec2::from_angle(mirrored(turn + swept, angle)) * q.length();
        let error = file_position(&mesh, &end.point)
            .truncate()
            .distance(expected);
        println!("wedge {angle}: {} crossings, {error:e}", end.crossings);
        assert_eq!(end.end, End::Distance);
        assert!(error < 1e-8, "wedge {angle}: {error:e}");
    }
}

/// The tip of a wedge so narrow that the path would be reflected π·10⁷ times: it gives up where it
/// got to, which is still on the surface.
#[test]
fn a_wedge_too_narrow_ends_on_the_surface() {
    let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1e-7, 0.0]];
    let mesh = common::substrate(positions, vec![[0, 1, 2]]);
    let from = SurfacePoint::from_weights(0, [0.5, 0.3, 0.2]);
    let end = trace(&mesh, &from, DVec2::from_angle(3.0) * 1.2, false);
    assert_eq!(end.end, End::Crossings);
    assert!(
        end.point.weights().iter().all(|w| (0.0..=1.0).contains(w)),
        "{end:?}"
    );
}

fn awkward() -> Vec<(&'static str, Substrate)> {
    let (saddle, _) = Cone {
        angle: 9.0,
        faces: 30,
    }
    .mesh(&[0.2, 1.0]);
    let (spike, _) = Cone {
        angle: 0.05,
        faces: 3,
    }
    .mesh(&[0.2, 1.0]);
    vec![
        ("rock", common::rock(24)),
        ("sphere", common::sphere(16)),
        ("cube", cube(4)),
        ("plane", common::plane(1.0)),
        (
            "prism",
            Prism {
                sides: 9,
                height: 1.0,
            }
            .mesh(3),
        ),
        ("saddle", saddle),
        ("spike", spike),
        ("Möbius band", moebius(40, 4)),
        ("book of five pages", book()),
        ("needles", needles()),
    ]
}

/// Needles that a path along them leaves by their short edge, or would.
#[test]
fn a_path_along_needles_ends_where_it_should() {
    for width in [1e-4, 1e-6, 1e-7] {
        let strip = (0..40).map(|i| 0.3 + f64::from(i) * width);
        let across: Vec<f64> = [0.0].into_iter().chain(strip).chain([1.0]).collect();
        let mesh = rectangle(&across, &[0.0, 1.0, 2.0], None);
        assert_eq!(mesh.triangles().len(), 4 * 41, "{width}");
        let mut stream = stream(20);
        let mut worst = 0.0f64;
        for _ in 0..4000 {
            let from = random_point(&mesh, &mut stream);
            let p = file_position(&mesh, &from).truncate();
            let to = DVec2::new(
                p.x + width * (stream.uniform() - 0.5),
                2.0 * stream.uniform(),
            );
            let end = go(&mesh, &from, (to - p).extend(0.0));
            assert_eq!(end.end, End::Distance, "{width}: {p} to {to}");
            worst = worst.max(file_position(&mesh, &end.point).truncate().distance(to));
        }
        println!("needles of {width:e}: {worst:e}");
        // The frame of a needle is known to round-off over its width.
        assert!(worst < 1e-14 / width, "{width}: {worst:e}");
    }
}

/// A path along the short edges of many needles asks little of each.
#[test]
fn a_path_along_short_edges_takes_no_longer_for_that() {
    let strip = (0..20_000).map(|i| 0.3 + f64::from(i) * 1e-6);
    let across: Vec<f64> = [0.0].into_iter().chain(strip).chain([1.0]).collect();
    let mesh = rectangle(&across, &[0.0, 1.0, 2.0], None);
    // From the edge that leads to them, on the line that they all lie on, but for round-off.
    let ends = [DVec3::new(0.0, 1.0, 0.0), DVec3::new(0.3, 1.0, 0.0)];
    let corner = |t: u32, end: DVec3| {
        let away = |p: DVec3| mesh.units().to_file(p).distance(end) < 1e-9;
        mesh.corners(t).into_iter().position(away)
    };
    let edges = (0..mesh.triangles().len() as u32)
        .filter_map(|t| Some((t, [corner(t, ends[0])?, corner(t, ends[1])?])));
    let mut asked = 0;
    for (triangle, [far, near]) in edges {
        for i in 1..40 {
            let mut weights = [0.0; 3];
            weights[near] = f64::from(i) / 40.0;
            weights[far] = 1.0 - weights[near];
            let from = SurfacePoint::from_weights(triangle, weights);
            let to = DVec3::new(0.31, 1.0, 0.0);
            let end = go(&mesh, &from, to - file_position(&mesh, &from));
            assert_eq!(end.end, End::Distance);
            assert!(file_position(&mesh, &end.point).distance(to) < 1e-7);
            asked += 1;
        }
    }
    assert_eq!(asked, 2 * 39);
}

/// The way back is the way there: back at the start, to round-off, pointing the other way.
#[test]
fn there_and_back_returns_to_round_off() {
    for (name, mesh) in awkward() {
        let (mut stream, mut there, mut back) = (stream(18), Path::default(), Path::default());
        let mut worst = (0.0f64, 0.0f64);
        for _ in 0..3000 {
            let from = random_point(&mesh, &mut stream);
            let step = direction(&mut stream) * 5.0 * stream.uniform();
            let end = trace_visiting(&mesh, &from, step, &mut there);
            let home = trace_visiting(&mesh, &end.point, -there.onward, &mut back);
            assert_eq!(home.end, End::Distance);
            let error = mesh.position(&home.point).distance(mesh.position(&from));
            worst.0 = worst.0.max(error);
            if home.point.triangle == from.triangle {
                worst.1 = worst.1.max(back.onward.distance(-step));
            }
        }
        println!(
            "{name}: back within {:e}, pointing within {:e}",
            worst.0, worst.1
        );
        // Over an edge of 1e-6 a direction is only known to 1e-10, and a path is up to 5 long.
        let (place, pointing) = match name {
            "needles" => (1e-8, 1e-7),
            _ => (CLOSE, CLOSE),
        };
        assert!(worst.0 < place && worst.1 < pointing, "{name}: {worst:?}");
    }
}

/// Traces in all, over all meshes.
const TRACES: usize = 1_000_000;

fn checked(name: &str, mesh: &Substrate, traces: usize, index: u64) {
    let worst = survey(mesh, traces, &mut stream((1 << 20) + index));
    println!("{name}: {worst:?}");
    assert!(worst.outside < 1e-12, "{name}: {worst:?}");
    // A path into a corner is reflected up to π/angle times before it comes out: it may give up
    // in one narrower than this, and only there. So many crossings add up their round-off.
    let narrow = sharpest_angle(mesh) < 1e-5;
    assert!(worst.gave_up == 0 || narrow, "{name}: {worst:?}");
    let (bent, long) = if narrow { (1e-8, 1e-6) } else { (CLOSE, CLOSE) };
    assert!(worst.bend < bent, "{name}: {worst:?}");
    assert!(worst.length < long, "{name}: {worst:?}");
}

/// The least angle of any triangle, or rather its sine.
fn sharpest_angle(mesh: &Substrate) -> f64 {
    let of_triangle = |t| {
        let [a, b, c] = mesh.corners(t);
        let longest = (b - a).length().max((c - b).length()).max((a - c).length());
        2.0 * mesh.area(t) / (longest * longest)
    };
    let all = 0..mesh.triangles().len() as u32;
    all.map(of_triangle).fold(1.0, f64::min)
}

/// The meshes we ship, and those that were lent to us where they are.
fn files() -> Vec<PathBuf> {
    let root = FilePath::new(env!("CARGO_MANIFEST_DIR"));
    let mut files: Vec<PathBuf> = std::fs::read_dir(root.join("meshes"))
        .into_iter()
        .flatten()
        .map(|entry| entry.expect("a readable folder").path())
        .filter(|p| p.extension().is_some_and(|e| e != "md"))
        .collect();
    files.sort();
    if let Some(shared) = common::shared_folder() {
        let manifest = std::fs::read_to_string(shared.join("MANIFEST.tsv")).expect("a manifest");
        files.extend(loadable(&manifest).map(|file| shared.join(file)));
    }
    files
}

/// Files of the manifest that a good importer loads whole.
fn loadable(manifest: &str) -> impl Iterator<Item = &str> {
    let mut lines = manifest.lines();
    let head: Vec<&str> = lines.next().unwrap_or("").split('\t').collect();
    let expect = head
        .iter()
        .position(|&h| h == "expect")
        .expect("a column 'expect'");
    lines.filter_map(move |line| {
        let fields: Vec<&str> = line.split('\t').collect();
        let file = fields[0].strip_prefix("shared/").unwrap_or(fields[0]);
        fields[expect].starts_with("load (").then_some(file)
    })
}

#[test]
fn a_million_long_walks_never_leave_the_surface() {
    let (made, files) = (awkward(), files());
    let each = TRACES / (made.len() + files.len()) + 1;
    made.par_iter()
        .enumerate()
        .for_each(|(i, (name, mesh))| checked(name, mesh, each, i as u64));
    files.par_iter().enumerate().for_each(|(i, file)| {
        let mesh = Substrate::load(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        checked(&file.display().to_string(), &mesh, each, 100 + i as u64);
    });
}
