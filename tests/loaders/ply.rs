//! PLY.

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
    // The first line alone in another way, as where headers are put together; in capitals; a mark; blanks.
    for first in [
        "ply\r\n",
        "PLY\r\n",
        "\u{feff}ply\n",
        "ply \t\n",
        "\u{feff}ply \r\n",
    ] {
        let text = ascii().replacen("ply\n", first, 1);
        assert_eq!(parsed(&text, Format::Ply), soup, "{first:?}");
    }
    // As Blender 2.4 wrote it.
    let text = ascii().replacen("comment made", "Created", 1);
    assert_eq!(parsed(text, Format::Ply), soup);
    let begun = [b"\xEF\xBB\xBFply \r\n", &binary(false)[4..]].concat();
    assert_eq!(parsed(begun, Format::Ply), soup);
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

/// As Blender writes attributes that are called so.
#[test]
fn names_may_have_spaces_in_them() {
    let rows = "7 0 0 0\n7 1 0 0\n7 0 1 0\n3 0 1 2 2 8 9\n";
    let text = small(
        "float",
        "uchar int vertex_indices\nproperty list uchar int my own  list",
        rows,
    );
    let text = text.replacen(
        "property float x",
        "property float my weight\nproperty float x",
        1,
    );
    let soup = parsed(text, Format::Ply);
    assert_eq!(soup.positions, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(soup.triangles, [[0, 1, 2]]);
}

#[test]
fn axes_may_be_capitals() {
    let list = "uchar int vertex_indices";
    let small = small("float", list, "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    let axes = ["x", "y", "z"].iter().fold(small, |text, axis| {
        text.replace(
            &format!("float {axis}"),
            &format!("float {}", axis.to_uppercase()),
        )
    });
    let soup = parsed(axes, Format::Ply);
    assert_eq!(soup.positions, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
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
fn vertices_that_no_face_uses_need_no_position() {
    let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
                property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
                end_header\nnan nan nan\n0 0 0\n1 0 0\n0 1 0\n3 1 2 3\n";
    let soup = parsed(text, Format::Ply);
    assert_eq!(soup.positions[0], [0.0; 3]);
    let note = "1 unused vertex without a finite position ignored";
    assert_eq!(soup.notes, [note]);
}

#[test]
fn errors_name_the_place_and_the_cure() {
    let list = "uchar int vertex_indices";
    let cases: [(String, &[&str]); 10] = [
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
            small("list uchar float", list, ROWS),
            &["property", "is a list"],
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
    let text =
        small("float", "uchar int vertex_indices", "0 0 0 1 0 0 0 1 0").replace("face 1", "face 0");
    assert_says(
        &refused(text, Format::Ply),
        &["no triangles to grow on", "3 points"],
    );
}

/// Scans keep a vertex for every direction they looked in. Only what is refused asks for its line.
#[test]
fn many_vertices_without_a_position_take_no_time() {
    let count = 200_000;
    let text = small("float", "uchar int vertex_indices", ROWS);
    let text = text.replace("vertex 3", &format!("vertex {}", count + 3));
    let text = text.replace(ROWS, &format!("{}{ROWS}", "nan nan nan\n".repeat(count)));
    let [a, b, c] = [0, 1, 2].map(|corner| corner + count);
    let text = text.replace("3 0 1 2", &format!("3 {a} {b} {c}"));
    let begun = std::time::Instant::now();
    assert_eq!(parsed(&text, Format::Ply).triangles.len(), 1);
    assert!(
        begun.elapsed().as_secs_f64() < 10.0,
        "{:?}",
        begun.elapsed()
    );
    let text = text.replace(&format!("3 {a} {b}"), &format!("3 {a} 7"));
    assert_says(
        &refused(text, Format::Ply),
        &["vertex 7 (line 17)", "not finite"],
    );
}

#[test]
fn what_is_left_over_is_told() {
    let list = "uchar int vertex_indices";
    let text = small("float", list, &format!("{ROWS}3 2 1 0\n"));
    let note = "4 words after the last element ignored";
    assert_eq!(parsed(text, Format::Ply).notes, [note]);
    // Wrapped anywhere, with a word too many.
    let text = small("float", list, "0 0 0 1 0\n0 0 1 0 3\n0 1 2 9\n");
    let note = "1 word after the last element ignored";
    assert_eq!(parsed(text, Format::Ply).notes, [note]);
    for rows in [
        "0 0 0 1 0\n0 0 1 0 3\n0 1 2\n",
        "0 0 0 1\n0 0\n0 1 0 3\n0 1 2\n",
    ] {
        assert!(
            parsed(small("float", list, rows), Format::Ply)
                .notes
                .is_empty()
        );
    }
    let mut bytes = binary(false);
    bytes.extend([0; 3]);
    let notes = parsed(bytes, Format::Ply).notes;
    assert!(
        notes.contains(&"3 bytes after the last element ignored".into()),
        "{notes:?}"
    );
}

/// Read on as if it were declared it gave another mesh, or a fault that is none.
#[test]
fn a_value_in_each_line_that_is_not_declared_is_named() {
    let list = "uchar int vertex_indices";
    let every = "0 0 0 1\n1 0 0 1\n0 1 0 1\n3 0 1 2\n";
    for rows in [
        every,
        &every.replace('\n', "\r\n"),
        &ROWS.replace("1 0 0", "1 0 0 1"),
    ] {
        let line = if rows.starts_with("0 0 0 1") {
            "line 10"
        } else {
            "line 11"
        };
        let parts = [
            line,
            "more in this line than the header declares",
            "declare it",
        ];
        assert_says(&refused(small("float", list, rows), Format::Ply), &parts);
    }
    let faces = ROWS.replace("3 0 1 2", "3 0 1 2 255 0 0");
    assert_eq!(
        refused(small("float", list, &faces), Format::Ply),
        "PLY, line 13: there is more in this line than the header declares; declare it in the header or export the \
         file again"
    );
}
