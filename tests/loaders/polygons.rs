//! Polygons, through OBJ.

use super::*;

use std::f64::consts::{PI, TAU};

use thallus::substrate::Substrate;

fn polygon(outline: &[[f64; 3]]) -> String {
    let mut text = String::new();
    for [x, y, z] in outline {
        text += &format!("v {x:?} {y:?} {z:?}\n");
    }
    let corners: Vec<String> = (1..=outline.len()).map(|i| i.to_string()).collect();
    text + "f " + &corners.join(" ") + "\n"
}

/// Area and winding of a planar outline, by its vector area.
fn outline_turn(outline: &[[f64; 3]]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for i in 0..outline.len() {
        let part = turn([outline[0], outline[i], outline[(i + 1) % outline.len()]]);
        sum = std::array::from_fn(|k| sum[k] + part[k]);
    }
    sum
}

/// The laws: n − 2 triangles, all facing as the outline does, together of its area, whose
/// unmatched edges are the outline's.
fn check(outline: &[[f64; 3]]) {
    let soup = parsed(polygon(outline), Format::Obj);
    let n = outline.len() as u32;
    assert_eq!(soup.triangles.len(), outline.len() - 2, "{outline:?}");
    let expected = outline_turn(outline);
    let size = expected.iter().map(|x| x * x).sum::<f64>().sqrt();
    for triangle in corners(&soup) {
        let facing: f64 = turn(triangle)
            .iter()
            .zip(expected)
            .map(|(a, b)| a * b)
            .sum();
        assert!(
            facing >= -1e-9 * size * size,
            "{triangle:?} faces away in {outline:?}"
        );
    }
    let found = total_area(&soup);
    assert!(
        (found - 0.5 * size).abs() <= 1e-9 * size,
        "{found} of {} in {outline:?}",
        0.5 * size
    );
    let mut edges: Vec<(u32, u32)> = soup
        .triangles
        .iter()
        .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
        .collect();
    let all = edges.clone();
    edges.retain(|&(a, b)| !all.contains(&(b, a)));
    edges.sort_unstable();
    let mut rim: Vec<(u32, u32)> = (0..n).map(|i| (i, (i + 1) % n)).collect();
    rim.sort_unstable();
    assert_eq!(edges, rim, "{outline:?}");
}

fn flat(points: &[(f64, f64)]) -> Vec<[f64; 3]> {
    points.iter().map(|&(x, y)| [x, y, 0.0]).collect()
}

#[test]
fn concave_outlines_keep_their_area_either_way_round_and_in_any_plane() {
    let shapes = [
        flat(&[(0., 0.), (2., 0.), (2., 2.), (1., 0.5)]),
        flat(&[(2., 0.), (2., 2.), (1., 0.5), (0., 0.)]),
        flat(&[(0., 0.), (4., 0.), (4., 3.), (2., 1.), (0., 3.)]),
        flat(&[
            (0., 0.),
            (3., 0.),
            (3., 1.),
            (1., 1.),
            (1., 2.),
            (3., 2.),
            (3., 3.),
            (0., 3.),
        ]),
    ];
    for shape in shapes {
        let mut back = shape.clone();
        back.reverse();
        for outline in [shape, back] {
            check(&outline);
            check(
                &outline
                    .iter()
                    .map(|[x, y, z]| [*z, *x, *y])
                    .collect::<Vec<_>>(),
            );
            check(
                &outline
                    .iter()
                    .map(|[x, y, _]| [*y, x + 2.0 * y, 5.0 - x])
                    .collect::<Vec<_>>(),
            );
        }
    }
}

/// The caps of a cylinder of many sides, with as many digits as OBJ files mostly have: corner by corner the outline
/// bends inwards and outwards.
#[test]
fn outlines_of_many_corners_are_cut_where_they_cannot_cross_themselves() {
    for n in [20_000, 100_000] {
        let rounded = |x: f64| (1e6 * x).round() / 1e6;
        let corner = |i: u32| {
            let (sin, cos) = (TAU * f64::from(i) / f64::from(n)).sin_cos();
            [rounded(cos), rounded(sin), 3.0]
        };
        let outline: Vec<[f64; 3]> = (0..n).map(corner).collect();
        let soup = parsed(polygon(&outline), Format::Obj);
        assert_eq!(soup.triangles.len(), outline.len() - 2);
        assert!((total_area(&soup) - PI).abs() < 1e-5);
        let back: Vec<[f64; 3]> = outline.iter().rev().copied().collect();
        assert_eq!(
            parsed(polygon(&back), Format::Obj).triangles.len(),
            outline.len() - 2
        );
        // Twice round, and a comb, may be anything.
        let twice: Vec<[f64; 3]> = (0..n).map(|i| corner(2 * i)).collect();
        let comb: Vec<[f64; 3]> = (0..n)
            .map(|i| [f64::from(i), f64::from(i % 2), 0.0])
            .collect();
        for outline in [twice, comb] {
            let message = refused(polygon(&outline), Format::Obj);
            assert_says(&message, &["corners, more than 16384", "triangulate"]);
        }
    }
}

#[test]
fn corners_on_straight_edges_stay_or_a_crack_would_open() {
    let mut square = Vec::new();
    let sides = [
        ((0., 0.), (1., 0.)),
        ((4., 0.), (0., 1.)),
        ((4., 4.), (-1., 0.)),
        ((0., 4.), (0., -1.)),
    ];
    for ((x, y), (dx, dy)) in sides {
        square.extend((0..4).map(|i| (x + dx * f64::from(i), y + dy * f64::from(i))));
    }
    check(&flat(&square));
    check(&flat(&[(0., 0.), (1., 0.), (2., 0.), (0., 2.)]));
    check(&flat(&[(0., 0.), (2., 0.), (1., 1.), (0., 2.)]));
    check(&flat(&[(1., 0.), (2., 0.), (0., 2.), (0., 0.)]));
    check(&flat(&[
        (0., 0.),
        (1., 0.),
        (2., 0.),
        (3., 0.),
        (4., 0.),
        (0., 3.),
    ]));
}

#[test]
fn polygons_without_an_inside_are_cut_with_a_note() {
    let line = [(0., 0.), (1., 0.), (2., 0.), (3., 0.), (4., 0.)];
    let crossing = [(0., 0.), (2., 2.), (2., 0.), (0., 2.), (1., 5.)];
    let bow_tie = [(0., 0.), (1., 0.), (0., 1.), (1., 1.)];
    let leaning = [(0., 0.), (1., 0.), (0., 1.), (1.1, 1.)];
    for outline in [&line[..], &line[..4], &crossing, &bow_tie, &leaning] {
        let soup = parsed(polygon(&flat(outline)), Format::Obj);
        assert_eq!(soup.triangles.len(), outline.len() - 2);
        let said = &soup.notes[1];
        assert!(said.starts_with("1 polygon that crosses itself"), "{said}");
    }
}

#[test]
fn a_huge_polygon_takes_no_time() {
    // A comb: every second corner is reflex.
    let tooth = |i: usize| (i as f64, [1.0, 9.0][i % 2]);
    let mut points: Vec<(f64, f64)> = (0..16_000).map(tooth).collect();
    points.extend([(16_000.0, 0.0), (0.0, 0.0)]);
    points.reverse();
    let begun = std::time::Instant::now();
    let soup = parsed(polygon(&flat(&points)), Format::Obj);
    assert_eq!(soup.triangles.len(), 16_000);
    assert!(begun.elapsed().as_secs_f64() < 5.0, "{:?}", begun.elapsed());
}

#[test]
fn a_polygon_that_would_take_minutes_is_refused() {
    let points: Vec<(f64, f64)> = (0..20_000)
        .map(|i| (f64::from(i), f64::from(i * i % 7)))
        .collect();
    let message = refused(polygon(&flat(&points)), Format::Obj);
    assert_says(&message, &["line 20001", "20000 corners", "triangulate it"]);
}

/// Where its corners are rounded to what it bends from one to the next, to cut it takes a quarter of a minute, and
/// one of twice as many corners a minute.
#[test]
fn a_round_polygon_that_would_take_long_is_refused_and_a_smaller_one_cut() {
    let circle = |corners: u32| {
        let at = |i: u32| TAU * f64::from(i) / f64::from(corners);
        let rounded = |x: f64| (x * 1e9).round() / 1e9;
        let points = (0..corners).map(|i| (rounded(at(i).cos()), rounded(at(i).sin())));
        polygon(&flat(&points.collect::<Vec<_>>()))
    };
    assert_eq!(parsed(circle(40_000), Format::Obj).triangles.len(), 39_998);
    let message = refused(circle(160_000), Format::Obj);
    assert_says(
        &message,
        &["line 160001", "160000 corners may", "triangulate it"],
    );

    let large = circle(65_000);
    let face = large.lines().last().expect("a face").to_owned() + "\n";
    let message = refused(large.clone() + &face.repeat(4), Format::Obj);
    assert_says(
        &message,
        &["line 65005", "too many as large", "triangulate it"],
    );
}

/// To cut it ear by ear would take hours.
#[test]
fn a_polygon_that_comes_to_four_places_again_and_again_is_cut_as_a_fan() {
    let corners = "1 2 3 4 ".repeat(4_000);
    let text = format!("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf {corners}\n");
    let soup = parsed(text, Format::Obj);
    assert_eq!(soup.triangles.len(), 15_998);
    let fan = |(i, triangle): (u32, &[u32; 3])| *triangle == [0, (i + 1) % 4, (i + 2) % 4];
    assert!((0..).zip(&soup.triangles).all(fan));
    let said = &soup.notes[1];
    assert!(said.starts_with("1 polygon that crosses itself"), "{said}");
}

#[test]
fn a_file_of_many_polygons_that_would_take_minutes_is_refused() {
    // A comb is cut in no time, but is not known not to cross itself.
    let comb = (0..16_000).map(|i| (f64::from(i), f64::from(i % 2)));
    let points: Vec<(f64, f64)> = comb.collect();
    let one = polygon(&flat(&points));
    let face = one.lines().last().expect("a face").to_owned() + "\n";
    let message = refused(one.clone() + &face.repeat(20), Format::Obj);
    assert_says(
        &message,
        &[
            "line 16009",
            "16000 corners",
            "too many of that kind",
            "triangulate",
        ],
    );
}

/// Holes that are joined to the outline and to each other: every bridge is passed twice, and its ends are there twice.
#[test]
fn a_plate_with_many_holes_keeps_its_area() {
    const HOLES: usize = 20;
    let mut points = vec![(80.0, 0.0), (80.0, 80.0), (0.0, 80.0)];
    let mut ring = vec![0, 1, 2];
    for row in (0..HOLES).rev() {
        let y = 4.0 * row as f64 + 2.0;
        let edge = points.len();
        points.push((0.0, y));
        ring.push(edge);
        let mut back = Vec::new();
        for x in (0..HOLES).map(|column| 4.0 * column as f64 + 2.0) {
            let first = points.len();
            points.extend([(x - 1.0, y), (x, y + 1.0), (x + 1.0, y), (x, y - 1.0)]);
            ring.extend([0, 1, 2].map(|k| first + k));
            back.push([2, 3, 0].map(|k| first + k));
        }
        ring.extend(back.into_iter().rev().flatten());
        ring.push(edge);
    }
    points.push((0.0, 0.0));
    ring.push(points.len() - 1);
    let vertices: String = points
        .iter()
        .map(|(x, y)| format!("v {x} {y} 0\n"))
        .collect();
    let corners: Vec<String> = ring.iter().map(|corner| (corner + 1).to_string()).collect();
    let soup = parsed(format!("{vertices}f {}\n", corners.join(" ")), Format::Obj);
    assert_eq!(soup.notes, ["1 polygon triangulated"]);
    let holes = 2.0 * (HOLES * HOLES) as f64;
    assert!((total_area(&soup) - (6400.0 - holes)).abs() < 1e-6);
}

proptest! {
    /// Star-shaped outlines with corners on their straight edges, in a tilted plane.
    #[test]
    fn stars_keep_the_laws(
        radii in prop::collection::vec(1_u32..20, 3..30),
        extra in prop::collection::vec(any::<bool>(), 30),
        tilt in -8_i32..8,
    ) {
        let n = radii.len();
        // Directions and halves with few bits: points on edges are exactly on them.
        let corner = |i: usize| {
            let angle = std::f64::consts::TAU * i as f64 / n as f64;
            let r = f64::from(radii[i]);
            [(r * angle.cos() * 1024.0).round(), (r * angle.sin() * 1024.0).round()]
        };
        let mut outline = Vec::new();
        for (i, on_edge) in extra.into_iter().take(n).enumerate() {
            let (a, b) = (corner(i), corner((i + 1) % n));
            outline.push(a);
            if on_edge {
                outline.push([0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]);
            }
        }
        let tilted: Vec<[f64; 3]> =
            outline.iter().map(|[x, y]| [*x, *y, f64::from(tilt) * x - y]).collect();
        check(&tilted);
    }
}

/// A direction and two across, not along any axis.
const TURNED: [[f64; 3]; 3] = [[0.48, 0.6, 0.64], [-0.8, 0.6, 0.0], [-0.36, -0.512, 0.78]];

fn place([x, y, z]: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| x * TURNED[0][k] + y * TURNED[1][k] + z * TURNED[2][k])
}

/// Round-off says on which side of the line through its neighbours such a corner lies.
#[test]
fn a_quad_is_not_cut_along_three_corners_on_a_line() {
    for tenth in 1..10 {
        let on = 0.1 * f64::from(tenth);
        let outline = [[0.0, 0.0], [on, 0.1 * on], [1.0, 0.1], [0.3, 0.9]];
        for first in 0..4 {
            let mut outline = outline.map(|[x, y]| place([x, y, 0.0]));
            outline.rotate_left(first);
            let soup = parsed(polygon(&outline), Format::Obj);
            for t in &soup.triangles {
                let corners = t.map(|v| soup.positions[v as usize]);
                let area = turn(corners).iter().map(|x| x * x).sum::<f64>().sqrt();
                assert!(area > 0.01, "{outline:?} {t:?}");
            }
        }
    }
}

/// Each face of a cube has corners on its edges, and so have its neighbours.
#[test]
fn a_body_of_polygons_with_corners_on_their_edges_is_closed() {
    let mut text = String::new();
    let mut known: Vec<[i32; 3]> = Vec::new();
    let mut faces = String::new();
    for axis in 0..3 {
        for high in [0, 7] {
            let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
            let outline = (0..7).map(|i| [i, 0]).chain((0..7).map(|i| [7, i]));
            let outline = outline
                .chain((0..7).map(|i| [7 - i, 7]))
                .chain((0..7).map(|i| [0, 7 - i]));
            faces += "f";
            for [a, b] in outline {
                let mut corner = [0; 3];
                (corner[axis], corner[u], corner[v]) = (high, a, b);
                let number = known.iter().position(|k| *k == corner).unwrap_or_else(|| {
                    let [x, y, z] = place(corner.map(|x| f64::from(x) / 7.0));
                    text += &format!("v {x:?} {y:?} {z:?}\n");
                    known.push(corner);
                    known.len() - 1
                });
                faces += &format!(" {}", number + 1);
            }
            faces += "\n";
        }
    }
    let substrate = Substrate::from_soup(parsed(text + &faces, Format::Obj)).unwrap();
    let report = substrate.report();
    assert_eq!((report.boundary_edges, report.non_manifold_edges), (0, 0));
    assert_eq!(
        (report.components.len(), report.degenerate_triangles),
        (1, 0)
    );
    let face = turn([[0.0; 3], TURNED[0], TURNED[1]])
        .iter()
        .map(|x| x * x)
        .sum::<f64>()
        .sqrt();
    assert!(report.area > 5.0 * face, "{}", report.area);
}
