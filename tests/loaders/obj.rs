//! OBJ.

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

/// A folder's name may end a comment, a group or a material.
#[test]
fn a_backslash_that_ends_a_comment_or_a_name_takes_nothing_away() {
    for before in [
        r"# from C:\scans\",
        r"f 1 2 3 # from C:\scans\",
        r"g scans\",
        r"o C:\scans\",
        r"usemtl C:\paint\",
        r"mtllib C:\paint\",
    ] {
        for after in ["f 1 2 3", "v 7 7 7", "\nf 1 2 3"] {
            for end in ["\n", "\r\n", "\r"] {
                let text = format!("{TRIANGLE}{before}\n{after}\nf 1 2 3\n");
                let faces = text.lines().filter(|line| line.starts_with('f')).count();
                let vertices = text.lines().filter(|line| line.starts_with('v')).count();
                let soup = parsed(text.replace('\n', end), Format::Obj);
                assert_eq!(soup.triangles.len(), faces, "{text:?}");
                assert_eq!(soup.positions.len(), vertices, "{text:?}");
            }
        }
    }
    // Numbers go on with numbers, and a line that begins with a word is another statement.
    let text = format!("{TRIANGLE}f 1 \\\n 2 \\ \t\n3\nf 1 2 3 \\\nf 3 2 1\n");
    assert_eq!(
        parsed(text, Format::Obj).triangles,
        [[0, 1, 2], [0, 1, 2], [2, 1, 0]]
    );
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
    let text = with("mtllib nowhere.mtl\nusemtl stone\ng a b\ns 1\nl 1 2\nl 2 3\np 1\nf 1 2 3\n");
    let soup = parsed(text, Format::Obj);
    assert_eq!(soup.triangles.len(), 1);
    assert_eq!(soup.notes, ["2 lines ignored", "1 point element ignored"]);
}

#[test]
fn vertices_that_no_face_uses_need_no_position() {
    let soup = parsed(with("v nan nan nan\nv 1 -inf 2\nf 1 2 3\n"), Format::Obj);
    assert_eq!(soup.positions[3..], [[0.0; 3]; 2]);
    let note = "2 unused vertices without a finite position ignored";
    assert_eq!(soup.notes, [note]);
}

#[test]
fn errors_name_the_line_and_the_cure() {
    let cases: [(&str, &[&str]); 10] = [
        (
            "f 1 2 4\n",
            &["line 4", "'4'", "there are 3", "export the file again"],
        ),
        ("f 1 2 0\n", &["line 4", "'0'", "counted from 1"]),
        ("\n# a\nf 1 2 -4\n", &["line 6", "'-4'"]),
        ("f 1 2 x\n", &["line 4", "'x'"]),
        ("f 1 2 99999999999999999999\n", &["line 4", "there are 3"]),
        ("v 1 2\nf 1 2 3\n", &["line 4", "three numbers"]),
        (
            "v 1 2 nan\nf 1 2 4\n",
            &["line 4", "(1, 2, NaN) is not finite", "repair"],
        ),
        ("v 1 -inf 2\nf 1 2 3 4\n", &["line 4", "-inf"]),
        (
            "f 1 2.0 3\n",
            &["line 4", "the whole number of a vertex, not '2.0'"],
        ),
        (
            "v 1 1e39 2\nf 1 2 3 4\n",
            &["line 4", "beyond single precision"],
        ),
    ];
    for (rest, parts) in cases {
        assert_says(&refused(with(rest), Format::Obj), parts);
        let old = with(rest).replace('\n', "\r");
        assert_says(&refused(old, Format::Obj), parts);
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

/// As where a program has put a line on top of another's file.
#[test]
fn line_ends_may_be_mixed() {
    let lines: Vec<&str> = "# made by\nv 0 0 0\nv 1 0 0\n\nv 0 1 \\\n0\n# a\nf 1 \\\n2 3\nf 3 2 1"
        .lines()
        .collect();
    for first in 0..3 {
        let ends = ["\n", "\r", "\r\n"];
        let ended = lines.iter().enumerate();
        let text: String = ended
            .map(|(k, line)| format!("{line}{}", ends[(first + k * (k + 1) / 2) % 3]))
            .collect();
        let soup = parsed(&text, Format::Obj);
        assert_eq!(soup.positions.len(), 3, "{text:?}");
        assert_eq!(soup.triangles, [[0, 1, 2], [2, 1, 0]], "{text:?}");
        assert_says(
            &refused(format!("{text}f 1 2 9"), Format::Obj),
            &["line 11"],
        );
    }
}

/// As Microsoft's C library wrote what is not finite; a `#` begins a comment elsewhere.
#[test]
fn no_numbers_are_no_comments() {
    for word in ["1.#QNAN", "-1.#IND", "1.#INF", "-1.#IND00", "1.#J"] {
        let text = with(&format!("v 0 0 {word} # why\nf 1 2 3"));
        let soup = parsed(&text, Format::Obj);
        let note = "1 unused vertex without a finite position ignored";
        assert_eq!(soup.notes, [note], "{word}");
        let message = refused(format!("{text}\nf 1 2 4"), Format::Obj);
        assert_says(&message, &["line 4", "(0, 0, NaN) is not finite", "repair"]);
    }
    let soup = parsed(with("v 0 0 7#a\nv 0 0 1 #1.#b\nf 1 2 3#c\n"), Format::Obj);
    assert_eq!(soup.positions[3..], [[0.0, 0.0, 7.0], [0.0, 0.0, 1.0]]);
    let message = refused(with("v 0 0 1.#7\nf 1 2 3\n"), Format::Obj);
    assert_says(&message, &["line 4", "three numbers", "'1.#7'"]);
}
