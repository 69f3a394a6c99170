//! Polygons, through OBJ.

use super::*;

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
fn polygons_without_an_inside_are_fanned_with_a_note() {
    let crossing = flat(&[(0., 0.), (2., 2.), (2., 0.), (0., 2.), (1., 5.)]);
    let line = flat(&[(0., 0.), (1., 0.), (2., 0.), (3., 0.), (4., 0.)]);
    for outline in [crossing, line] {
        let soup = parsed(polygon(&outline), Format::Obj);
        assert_eq!(soup.triangles.len(), 3);
    }
    let line = flat(&[(0., 0.), (1., 0.), (2., 0.), (3., 0.), (4., 0.)]);
    assert!(
        parsed(polygon(&line), Format::Obj).notes[1].starts_with("1 polygon that crosses itself")
    );
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
