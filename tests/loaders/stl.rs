//! STL.

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
fn what_is_as_long_as_a_facet_need_not_be_one() {
    let mut bytes = binary(b"any", &FACETS);
    bytes.extend(b"made by a program that adds a remark of fifty byte");
    let soup = parsed(bytes, Format::Stl);
    assert_eq!(corners(&soup), expected());
    assert_eq!(soup.notes, ["50 bytes after the last facet ignored"]);
}

#[test]
fn words_of_stl_in_other_files_do_not_make_them_stl() {
    let remark = "facet outer loop vertex";
    let mut bytes = binary(remark.as_bytes(), &FACETS);
    bytes.extend([0; 3]);
    assert_eq!(corners(&parsed(bytes, Format::Stl)), expected());
    let folder = tempfile::tempdir().unwrap();
    let vertices = "0 0 0\n1 0 0\n0 1 0\n";
    let ply = format!(
        "ply\nformat ascii 1.0\ncomment {remark}\nelement vertex 3\nproperty float x\nproperty float y\n\
         property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n{vertices}3 0 1 2\n"
    );
    let obj = format!("# {remark}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for (name, text, format) in [("a.ply", ply, Format::Ply), ("a.obj", obj, Format::Obj)] {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        let loaded = load_soup(&path).unwrap();
        assert_eq!((loaded.format, loaded.soup.triangles.len()), (format, 1));
    }
}

#[test]
fn whole_facets_beyond_a_wrong_count_are_read() {
    for promised in [0u32, 1] {
        let mut bytes = binary(b"any", &FACETS);
        bytes[80..84].copy_from_slice(&promised.to_le_bytes());
        let soup = parsed(bytes, Format::Stl);
        assert_eq!(corners(&soup), expected());
        let note = format!(
            "the header promises {promised} facets, the file holds {}: all are read",
            FACETS.len()
        );
        assert_eq!(soup.notes, [note]);
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

/// Two solids of a facet each, as most programs write them.
const TWO_SOLIDS: &str = "solid a vertex facet\nfacet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  \
                          vertex 1.0e0 0 0\n  vertex 0 1 0.5\n endloop\nendfacet\nendsolid a vertex\n\
                          solid b\nfacet normal 0 0 1\n outer loop\n  vertex 2 0 0\n  vertex 3 0 0\n  \
                          vertex 2 1 0.5\n endloop\nendfacet\nendsolid b\n";

#[test]
fn white_space_of_any_sort_parts_the_words_of_ascii() {
    let expected = parsed(TWO_SOLIDS, Format::Stl);
    assert_eq!(expected.positions.len(), 6);
    assert_eq!(expected.positions[5], [2.0, 1.0, 0.5]);
    let one_line = TWO_SOLIDS.replace('\n', " ");
    let unnamed = TWO_SOLIDS.replace(" a vertex facet", "");
    let word_a_line = unnamed.replace(" a vertex", "").replace(" b", "");
    for text in [
        TWO_SOLIDS.replace('\n', "\r\n"),
        TWO_SOLIDS.replace('\n', "\r"),
        TWO_SOLIDS.replace('\n', "\n\r\n\t"),
        one_line.clone(),
        one_line.to_uppercase(),
        one_line.replace(' ', "\t"),
        word_a_line.replace(' ', "\n"),
        word_a_line.replace(' ', "\r"),
    ] {
        assert_eq!(parsed(&text, Format::Stl), expected, "{text:?}");
    }
}

#[test]
fn a_remark_may_come_first_and_ends_may_be_two_words() {
    let expected = parsed(TWO_SOLIDS, Format::Stl);
    let parted = TWO_SOLIDS.replace("endsolid", "end solid");
    let parted = parted.replace("endloop", "end loop");
    let parted = parted.replace("endfacet", "End  Facet");
    for text in [parted.clone(), parted.replace('\n', " ")] {
        assert_eq!(parsed(&text, Format::Stl), expected, "{text:?}");
    }
    let remark = format!("; made by hand\n{TWO_SOLIDS}");
    let soup = parsed(remark, Format::Stl);
    assert_eq!(soup.positions, expected.positions);
}

#[test]
fn lines_that_are_not_stl_are_passed_over_whatever_ends_them() {
    let strange = TWO_SOLIDS.replace("endfacet\n", "endfacet\n# a vertex here\ncolor 1 0 facet\n");
    for text in [strange.clone(), strange.replace('\n', "\r")] {
        let soup = parsed(text, Format::Stl);
        assert_eq!(soup.positions, parsed(TWO_SOLIDS, Format::Stl).positions);
        assert!(
            soup.notes
                .iter()
                .any(|n| n == "4 lines that are not STL ignored"),
            "{:?}",
            soup.notes
        );
    }
}

#[test]
fn ascii_errors_name_line_and_facet_whatever_ends_a_line() {
    let wrong = TWO_SOLIDS.replace("vertex 3 0 0", "vertex 3 x 0");
    for (text, place) in [
        (wrong.clone(), "line 14 (facet 1)"),
        (wrong.replace('\n', "\r"), "line 14 (facet 1)"),
        (wrong.replace('\n', "\r\n"), "line 14 (facet 1)"),
        (wrong.replace('\n', " "), "line 1 (facet 1)"),
    ] {
        let message = refused(text, Format::Stl);
        assert_says(&message, &[place, "three numbers, not 'x'", "export"]);
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
    let loop_of = |corners: &str| format!("solid\nfacet\nouter loop\n{corners}endloop\nendfacet\n");
    let cases = [
        (
            loop_of(&"vertex 0 0 0\n".repeat(4)),
            "line 7",
            "more than three",
        ),
        (loop_of("vertex 0 0\n"), "line 4", "three numbers"),
        (loop_of("vertex 0 0 inf\n"), "line 4", "not finite"),
        // A damaged byte does not make it binary.
        (loop_of("vertex 0 0 \u{10}0\n"), "line 4", "three numbers"),
        (
            "solid\nfacet\nouter loop\nvertex 0 0 0\n".into(),
            "line 4",
            "within a facet",
        ),
        // Cut between two facets.
        (
            loop_of(&"vertex 0 0 0\n".repeat(3)),
            "(facet 1)",
            "without endsolid",
        ),
        (
            TWO_SOLIDS.replace("endsolid b\n", ""),
            "(facet 2)",
            "without endsolid",
        ),
    ];
    for (text, place, problem) in cases {
        assert_says(&refused(text, Format::Stl), &[place, problem]);
    }
}

#[test]
fn edges_and_points_written_as_facets_are_passed_over() {
    let edge = "facet normal 0 0 0\nouter loop\nvertex 7 7 7\nvertex 8 8 8\nendloop\nendfacet\n";
    let point = "facet normal 0 0 0\nouter loop\nvertex 9 9 9\nendloop\nendfacet\n";
    let text = TWO_SOLIDS.replacen("facet", &format!("{edge}{point}facet"), 1);
    let soup = parsed(&text, Format::Stl);
    assert_eq!(soup.positions, parsed(TWO_SOLIDS, Format::Stl).positions);
    let note = "2 facets of fewer than three vertices ignored";
    assert!(soup.notes.iter().any(|n| n == note), "{:?}", soup.notes);
    // Places count all facets.
    let wrong = refused(text.replace("vertex 3 0 0", "vertex 3 x 0"), Format::Stl);
    assert_says(&wrong, &["(facet 3)"]);
    let only = format!("solid\n{edge}endsolid\n");
    assert_says(
        &refused(only, Format::Stl),
        &["only 1 facet of fewer than three"],
    );
}

#[test]
fn without_facets_there_is_nothing_to_grow_on() {
    for bytes in [binary(b"", &[]), b"solid empty\nendsolid empty\n".to_vec()] {
        assert_says(&refused(bytes, Format::Stl), &["no triangles to grow on"]);
    }
    let within_header = refused(*b"solid by its exporter      ", Format::Stl);
    assert_says(&within_header, &["without endsolid", "cut short"]);
}
