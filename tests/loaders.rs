//! Each loader's features on small files, and each of its errors with the place and the cure.

use std::fs;
use std::path::{Path, PathBuf};

use proptest::prelude::*;
use tempfile::TempDir;
use thallus::substrate::{Format, LoadFault, Soup, load_soup, parse_soup};

fn parsed(bytes: impl AsRef<[u8]>, format: Format) -> Soup {
    parse_soup(bytes.as_ref(), format, None).unwrap_or_else(|error| panic!("{error}"))
}

/// The message of a refusal; every one must end in a cure.
fn refused(bytes: impl AsRef<[u8]>, format: Format) -> String {
    match parse_soup(bytes.as_ref(), format, None) {
        Ok(soup) => panic!("loaded {} triangles", soup.triangles.len()),
        Err(error) => error.to_string(),
    }
}

#[track_caller]
fn assert_says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "{part:?} is not in {message:?}");
    }
}

fn corners(soup: &Soup) -> Vec<[[f64; 3]; 3]> {
    let place = |t: &[u32; 3]| t.map(|i| soup.positions[i as usize]);
    soup.triangles.iter().map(place).collect()
}

/// Twice the vector area of a triangle.
fn turn([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    let u: [f64; 3] = std::array::from_fn(|k| b[k] - a[k]);
    let v: [f64; 3] = std::array::from_fn(|k| c[k] - a[k]);
    [
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    ]
}

fn area(triangle: [[f64; 3]; 3]) -> f64 {
    0.5 * turn(triangle).iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn total_area(soup: &Soup) -> f64 {
    corners(soup).into_iter().map(area).sum()
}

/// Six times the signed volume: positive where triangles wind counter-clockwise from outside.
fn volume(soup: &Soup) -> f64 {
    let term = |t: [[f64; 3]; 3]| -> f64 {
        let [a, b, c] = t;
        (0..3)
            .map(|k| {
                let (l, m) = ((k + 1) % 3, (k + 2) % 3);
                a[k] * (b[l] * c[m] - b[m] * c[l])
            })
            .sum()
    };
    corners(soup).into_iter().map(term).sum()
}

fn bounds(soup: &Soup) -> ([f64; 3], [f64; 3]) {
    let used = || {
        soup.triangles
            .iter()
            .flatten()
            .map(|&i| soup.positions[i as usize])
    };
    let fold = |from: f64, pick: fn(f64, f64) -> f64| {
        std::array::from_fn(|axis| used().map(|p| p[axis]).fold(from, pick))
    };
    (
        fold(f64::INFINITY, f64::min),
        fold(f64::NEG_INFINITY, f64::max),
    )
}

// OBJ

mod obj {
    use super::*;

    const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

    fn with(faces: &str) -> String {
        format!("{TRIANGLE}{faces}")
    }

    #[test]
    fn every_way_to_write_a_corner_names_the_same_vertex() {
        let forms = [
            "f 1 2 3",
            "f 1/1 2/2 3/3",
            "f 1//1 2//2 3//3",
            "f 1/1/1 2/2/2 3/3/3",
        ];
        let odd = [
            "f -3 -2 -1",
            "fo 1 2 3",
            "f\t1 2  3 # why",
            "  f 1 2 3",
            "f 1 \\\n2 3",
            "f +1 2 3",
        ];
        for face in forms.into_iter().chain(odd) {
            for text in [with(face), with(face).replace('\n', "\r\n")] {
                let soup = parsed(&text, Format::Obj);
                assert_eq!(soup.triangles, [[0, 1, 2]], "{text:?}");
                assert_eq!(soup.notes, Vec::<String>::new(), "{text:?}");
            }
        }
    }

    #[test]
    fn lone_carriage_returns_end_lines_too() {
        assert_eq!(
            parsed(with("f 1 2 3").replace('\n', "\r"), Format::Obj)
                .triangles
                .len(),
            1
        );
    }

    #[test]
    fn negative_indices_count_from_the_face_and_not_from_the_end() {
        let soup = parsed(with("f -3 -2 -1\nv 5 5 5\nf -4 -3 -1\n"), Format::Obj);
        assert_eq!(soup.triangles, [[0, 1, 2], [0, 1, 3]]);
    }

    #[test]
    fn a_face_may_stand_before_its_vertices() {
        assert_eq!(
            parsed(format!("f 1 2 3\n{TRIANGLE}"), Format::Obj).triangles,
            [[0, 1, 2]]
        );
    }

    #[test]
    fn positions_keep_double_precision_weights_and_colours_are_passed_over() {
        let text = "v 500000.123456789 1e-3 -2E2\nv 1 0 0 0.5\nv 0 1 0 0.1 0.2 0.3\nf 1 2 3\n";
        let soup = parsed(text, Format::Obj);
        assert_eq!(soup.positions[0], [500000.123456789, 1e-3, -200.0]);
        assert_eq!(soup.positions[1..], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    }

    #[test]
    fn lines_and_points_are_ignored_with_a_note_and_materials_may_be_missing() {
        let text =
            with("mtllib nowhere.mtl\nusemtl stone\ng a b\ns 1\nl 1 2\nl 2 3\np 1\nf 1 2 3\n");
        let soup = parsed(text, Format::Obj);
        assert_eq!(soup.triangles.len(), 1);
        assert_eq!(soup.notes, ["2 lines ignored", "1 point element ignored"]);
    }

    #[test]
    fn errors_name_the_line_and_the_cure() {
        let cases: [(&str, &[&str]); 8] = [
            (
                "f 1 2 4\n",
                &["line 4", "'4'", "there are 3", "export the file again"],
            ),
            ("f 1 2 0\n", &["line 4", "'0'", "counted from 1"]),
            ("\n# a\nf 1 2 -4\n", &["line 6", "'-4'"]),
            ("f 1 2 x\n", &["line 4", "'x'"]),
            ("f 1 2 99999999999999999999\n", &["line 4"]),
            ("v 1 2\nf 1 2 3\n", &["line 4", "three numbers"]),
            (
                "v 1 2 nan\nf 1 2 3\n",
                &["line 4", "(1, 2, NaN) is not finite", "repair"],
            ),
            ("v 1 -inf 2\nf 1 2 3\n", &["line 4", "-inf"]),
        ];
        for (rest, parts) in cases {
            assert_says(&refused(with(rest), Format::Obj), parts);
        }
    }

    #[test]
    fn without_faces_there_is_nothing_to_grow_on() {
        assert_says(
            &refused(with("l 1 2\n"), Format::Obj),
            &["no triangles to grow on", "1 line"],
        );
        assert_says(
            &refused(TRIANGLE, Format::Obj),
            &["no triangles to grow on", "3 points"],
        );
        assert_says(
            &refused(with("f 1 2\n"), Format::Obj),
            &["1 face without three corners"],
        );
    }
}

// Polygons, through OBJ

mod polygons {
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
        assert!(parsed(polygon(&line), Format::Obj).notes[1].starts_with("1 polygon that"));
    }

    #[test]
    fn a_huge_polygon_takes_no_time() {
        // A comb: every second corner is reflex.
        let tooth = |i: usize| (i as f64, [1.0, 9.0][i % 2]);
        let mut points: Vec<(f64, f64)> = (0..20_000).map(tooth).collect();
        points.extend([(20_000.0, 0.0), (0.0, 0.0)]);
        points.reverse();
        let begun = std::time::Instant::now();
        let soup = parsed(polygon(&flat(&points)), Format::Obj);
        assert_eq!(soup.triangles.len(), 20_000);
        assert!(begun.elapsed().as_secs_f64() < 5.0, "{:?}", begun.elapsed());
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
}

// STL

mod stl {
    use super::*;

    fn binary(header: &[u8], facets: &[[[f32; 3]; 3]]) -> Vec<u8> {
        let mut bytes = header.to_vec();
        bytes.resize(80, b' ');
        bytes.extend((facets.len() as u32).to_le_bytes());
        for facet in facets {
            bytes.extend([0; 12]);
            bytes.extend(facet.iter().flatten().flat_map(|x| x.to_le_bytes()));
            bytes.extend([0xAB, 0xCD]);
        }
        bytes
    }

    const FACETS: [[[f32; 3]; 3]; 2] = [
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.1]],
        [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.1]],
    ];

    fn expected() -> Vec<[[f64; 3]; 3]> {
        FACETS
            .iter()
            .map(|facet| facet.map(|p| p.map(f64::from)))
            .collect()
    }

    #[test]
    fn binary_is_read_exactly_whatever_its_header_says() {
        for header in [
            &b""[..],
            b"solid or so it says",
            b"solid\nfacet normal 0 0 0\n",
        ] {
            let soup = parsed(binary(header, &FACETS), Format::Stl);
            assert_eq!(corners(&soup), expected());
            assert_eq!(soup.notes, Vec::<String>::new());
        }
    }

    #[test]
    fn bytes_after_the_last_facet_are_tolerated() {
        for header in [&b"any"[..], b"solid x"] {
            let mut bytes = binary(header, &FACETS);
            bytes.extend([0; 7]);
            let soup = parsed(bytes, Format::Stl);
            assert_eq!(corners(&soup), expected());
            assert_eq!(soup.notes, ["7 bytes after the last facet ignored"]);
        }
    }

    #[test]
    fn ascii_in_any_case_with_many_solids_and_either_line_end() {
        let one = "solid a b\nfacet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1.0e0 0 0\n  \
                   vertex 0 1 0.5\n endloop\nendfacet\nendsolid a b\n";
        let two = one.repeat(2);
        for text in [two.clone(), two.to_uppercase(), two.replace('\n', "\r\n")] {
            let soup = parsed(&text, Format::Stl);
            assert_eq!(soup.triangles, [[0, 1, 2], [3, 4, 5]]);
            assert_eq!(soup.positions[2], [0.0, 1.0, 0.5]);
            assert_eq!(soup.notes, ["2 solids read as one mesh"]);
        }
    }

    #[test]
    fn errors_name_the_place_and_the_cure() {
        let whole = binary(b"", &FACETS);
        let short = refused(&whole[..whole.len() - 1], Format::Stl);
        assert_says(
            &short,
            &["promises 2 facets", "holds 1", "byte 80", "copy it again"],
        );
        assert_says(
            &refused(&whole[..60], Format::Stl),
            &["84-byte header", "byte 60"],
        );
        let mut lying = whole.clone();
        lying[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        assert_says(
            &refused(&lying, Format::Stl),
            &["promises 4294967295 facets"],
        );
        let mut facets = FACETS;
        facets[1][2][0] = f32::NAN;
        let nan = refused(binary(b"", &facets), Format::Stl);
        assert_says(&nan, &["facet 1 (byte 134)", "NaN", "repair"]);
    }

    #[test]
    fn ascii_errors_name_the_line() {
        let loop_of =
            |corners: &str| format!("solid\nfacet\nouter loop\n{corners}endloop\nendfacet\n");
        let cases = [
            (
                loop_of("vertex 0 0 0\nvertex 1 0 0\n"),
                "line 6",
                "2 vertices",
            ),
            (
                loop_of(&"vertex 0 0 0\n".repeat(4)),
                "line 7",
                "more than three",
            ),
            (loop_of("vertex 0 0\n"), "line 4", "three numbers"),
            (loop_of("vertex 0 0 inf\n"), "line 4", "not finite"),
            (
                "solid\nfacet\nouter loop\nvertex 0 0 0\n".into(),
                "line 4",
                "within a facet",
            ),
        ];
        for (text, place, problem) in cases {
            assert_says(&refused(text, Format::Stl), &[place, problem]);
        }
    }

    #[test]
    fn without_facets_there_is_nothing_to_grow_on() {
        for bytes in [binary(b"", &[]), b"solid empty\nendsolid empty\n".to_vec()] {
            assert_says(&refused(bytes, Format::Stl), &["no triangles to grow on"]);
        }
    }
}

// PLY

mod ply {
    use super::*;

    const BODY: &str = "element vertex 4\nproperty float nx\nproperty double x\nproperty double y\n\
        property double z\nproperty list uchar float junk\nelement material 1\nproperty int a\n\
        element face 2\nproperty uchar flag\nproperty list uchar int vertex_indices\nend_header\n";

    fn header(encoding: &str) -> String {
        format!("ply\nformat {encoding} 1.0\ncomment made by a test\n{BODY}")
    }

    const POSITIONS: [[f64; 3]; 4] = [
        [0.1, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ];

    fn ascii() -> String {
        let mut text = header("ascii");
        for [x, y, z] in POSITIONS {
            text += &format!("9 {x} {y} {z} 2 7.5 8\n");
        }
        text + "42\n1 4 0 1 2 3\n0 3 0 2 3\n"
    }

    fn binary(big: bool) -> Vec<u8> {
        let order = |mut raw: Vec<u8>| {
            if big {
                raw.reverse();
            }
            raw
        };
        let name = if big {
            "binary_big_endian"
        } else {
            "binary_little_endian"
        };
        let mut bytes = header(name).into_bytes();
        for position in POSITIONS {
            bytes.extend(order(9_f32.to_le_bytes().to_vec()));
            bytes.extend(
                position
                    .iter()
                    .flat_map(|x| order(x.to_le_bytes().to_vec())),
            );
            bytes.push(2);
            bytes.extend(
                [7.5_f32, 8.0]
                    .iter()
                    .flat_map(|x| order(x.to_le_bytes().to_vec())),
            );
        }
        bytes.extend(order(42_i32.to_le_bytes().to_vec()));
        for face in [&[0_i32, 1, 2, 3][..], &[0, 2, 3]] {
            bytes.extend([1, face.len() as u8]);
            bytes.extend(face.iter().flat_map(|i| order(i.to_le_bytes().to_vec())));
        }
        bytes
    }

    #[test]
    fn all_three_encodings_give_the_same_soup() {
        let soup = parsed(ascii(), Format::Ply);
        assert_eq!(soup.positions, POSITIONS);
        assert_eq!(soup.triangles, [[0, 1, 2], [0, 2, 3], [0, 2, 3]]);
        assert_eq!(
            soup.notes,
            ["1 row of 'material' ignored", "1 polygon triangulated"]
        );
        assert_eq!(parsed(binary(false), Format::Ply), soup);
        assert_eq!(parsed(binary(true), Format::Ply), soup);
        assert_eq!(parsed(ascii().replace('\n', "\r\n"), Format::Ply), soup);
        assert_eq!(parsed(ascii().replace('\n', "\r"), Format::Ply), soup);
    }

    fn small(vertex: &str, list: &str, rows: &str) -> String {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty {vertex} x\nproperty {vertex} y\n\
             property {vertex} z\nelement face 1\nproperty list {list}\nend_header\n{rows}"
        )
    }

    const ROWS: &str = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

    #[test]
    fn any_integer_type_may_hold_indices_and_lengths() {
        for count in ["char", "uchar", "int8", "ushort", "int32", "uint"] {
            for item in ["char", "uint8", "short", "uint16", "int", "uint32", "int64"] {
                for name in ["vertex_indices", "vertex_index", "whatever"] {
                    let text = small("float", &format!("{count} {item} {name}"), ROWS);
                    assert_eq!(parsed(text, Format::Ply).triangles, [[0, 1, 2]]);
                }
            }
        }
    }

    #[test]
    fn floats_are_read_as_their_writer_had_them_doubles_in_full() {
        let rows = "0.1 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
        let list = "uchar int vertex_indices";
        assert_eq!(
            parsed(small("float", list, rows), Format::Ply).positions[0][0],
            f64::from(0.1_f32)
        );
        assert_eq!(
            parsed(small("double", list, rows), Format::Ply).positions[0][0],
            0.1
        );
    }

    #[test]
    fn faces_may_stand_before_their_vertices_and_strips_are_unrolled() {
        let text = "ply\nformat ascii 1.0\nelement tristrips 1\nproperty list int int vertex_indices\n\
                    element vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                    end_header\n9 0 1 2 3 -1 1 0 0 2\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n";
        let soup = parsed(text, Format::Ply);
        // 0 1 2, then 1 2 3 turned round; 1 0 0 and 0 0 2 only stitch.
        assert_eq!(soup.triangles, [[0, 1, 2], [1, 3, 2]]);
    }

    #[test]
    fn errors_name_the_place_and_the_cure() {
        let list = "uchar int vertex_indices";
        let cases: [(String, &[&str]); 9] = [
            (
                small("float", list, &ROWS.replace("3 0 1 2", "3 0 1 3")),
                &["face 0 (line 13)", "vertex 3"],
            ),
            (
                small("float", list, &ROWS.replace("3 0 1 2", "3 0 1 -2")),
                &["vertex -2", "there are 3"],
            ),
            (
                small("float", list, &ROWS.replace("1 0 0", "1 nan 0")),
                &["vertex 1 (line 11)", "not finite"],
            ),
            (
                small("float", list, &ROWS.replace("1 0 0", "1 ? 0")),
                &["line 11", "vertex 1"],
            ),
            (
                small("float", list, "0 0 0\n1 0 0\n0 1 0\n3 0 1"),
                &["line 13", "face 0", "copy the file"],
            ),
            (
                small("quad", list, ROWS),
                &["line 4", "'quad'", "correct the header"],
            ),
            (
                small("float", "float int a", ROWS),
                &["line 8", "'a' must be an integer"],
            ),
            (
                small("float", list, ROWS).replace("vertex 3", "vertex 99999999999"),
                &["99999999999", "cut short"],
            ),
            (
                "ply\nformat ascii 1.0\n".into(),
                &["line 3", "no end_header"],
            ),
        ];
        for (text, parts) in cases {
            assert_says(&refused(text, Format::Ply), parts);
        }
        let bytes = binary(true);
        assert_says(
            &refused(&bytes[..bytes.len() - 1], Format::Ply),
            &["face 1", "byte "],
        );
    }

    #[test]
    fn a_list_longer_than_the_file_allocates_nothing() {
        let text = small("float", "uint uint vertex_indices", "");
        let mut bytes = text.replace("ascii", "binary_little_endian").into_bytes();
        bytes.extend([0; 36]);
        bytes.extend(u32::MAX.to_le_bytes());
        assert_says(&refused(bytes, Format::Ply), &["face 0"]);
    }

    #[test]
    fn points_are_nothing_to_grow_on() {
        let text = small("float", "uchar int vertex_indices", "0 0 0 1 0 0 0 1 0")
            .replace("face 1", "face 0");
        assert_says(
            &refused(text, Format::Ply),
            &["no triangles to grow on", "3 points"],
        );
    }
}

// Files

mod files {
    use super::*;

    const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    const STL: &str = "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
                       vertex 0 1 0\nendloop\nendfacet\nendsolid s\n";

    fn written(name: &str, bytes: impl AsRef<[u8]>) -> (TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        (folder, path)
    }

    fn refusal(path: &Path) -> String {
        let message = load_soup(path).unwrap_err().to_string();
        assert!(
            message.starts_with(&path.display().to_string()),
            "{message}"
        );
        message
    }

    #[test]
    fn the_content_decides_where_the_name_lies() {
        let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                   property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
                   end_header\n0 0 0 1 0 0 0 1 0 3 0 1 2\n";
        for (content, format) in [(OBJ, "OBJ"), (STL, "STL"), (ply, "PLY")] {
            for name in ["a.obj", "a.STL", "a.ply", "a.glb", "a.gltf", "a.txt", "a"] {
                let (_folder, path) = written(name, content);
                let loaded = load_soup(&path).unwrap_or_else(|error| panic!("{error}"));
                assert_eq!(loaded.soup.triangles, [[0, 1, 2]], "{format} in {name}");
                let honest = name.to_lowercase().ends_with(&format.to_lowercase());
                let nameless = name == "a" || name == "a.txt";
                let notes = loaded.soup.notes;
                assert_eq!(
                    notes.is_empty(),
                    honest || nameless,
                    "{format} in {name}: {notes:?}"
                );
                if !notes.is_empty() {
                    assert_says(&notes[0], &["is named as", &format!("read as {format}")]);
                }
            }
        }
    }

    #[test]
    fn the_hash_is_that_of_the_bytes_streamed_or_not() {
        for (name, content) in [("a.obj", OBJ), ("a.stl", STL)] {
            let (_folder, path) = written(name, content);
            let expected = blake3::hash(content.as_bytes()).to_hex().to_string();
            assert_eq!(load_soup(&path).unwrap().hash, expected);
        }
    }

    #[test]
    fn what_is_no_mesh_is_refused_with_a_cure() {
        let cases = [
            ("a.obj", &b""[..], "the file is empty"),
            ("a.stl", b" \n\n", "the file is blank"),
            (
                "a.glb",
                b"version https://git-lfs.github.com/spec/v1\n",
                "git lfs pull",
            ),
            ("a.obj", b"<!DOCTYPE html>", "XML or HTML"),
            ("a.fbx", b"Kaydara FBX Binary  \0", "this is FBX"),
            ("a.bin", b"\x01\x02\x03", "neither its name nor its content"),
            ("a.gltf", b"{\"scene\": 0}", "missing field `asset`"),
            ("a.ply", b"OK\n", "not 'ply'"),
            ("a.glb", b"short", "does not begin with 'glTF'"),
        ];
        for (name, content, part) in cases {
            let (_folder, path) = written(name, content);
            assert_says(&refusal(&path), &[part]);
        }
    }

    #[test]
    fn missing_files_and_folders_are_named() {
        let folder = tempfile::tempdir().unwrap();
        assert_says(
            &refusal(&folder.path().join("gone.obj")),
            &["cannot be read", "check the path"],
        );
        assert_says(&refusal(folder.path()), &["not a regular file"]);
        let error = load_soup(&folder.path().join("gone.obj")).unwrap_err();
        assert!(matches!(error.fault, LoadFault::Unreadable { .. }));
        assert!(std::error::Error::source(&error).is_some());
    }

    #[test]
    fn a_line_without_end_is_not_kept() {
        let mut text = STL.to_string();
        text.insert_str("solid s".len(), &"x".repeat(1 << 20));
        let (_folder, path) = written("a.stl", text);
        assert_eq!(load_soup(&path).unwrap().soup.triangles.len(), 1);
    }

    #[test]
    fn sizes_and_outsides_survive() {
        let cube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
        let (_folder, path) = written("cube.obj", cube);
        let soup = load_soup(&path).unwrap().soup;
        assert_eq!(soup.triangles.len(), 12);
        assert_eq!(volume(&soup), 6.0);
        assert_eq!(total_area(&soup), 6.0);
        assert_eq!(bounds(&soup), ([0.0; 3], [1.0; 3]));
    }
}
