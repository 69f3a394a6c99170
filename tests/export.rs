//! The tables of elements that are written, and the one that is read back.

use std::io::{self, Write};
use std::path::Path;

use proptest::prelude::*;
use thallus::export::{Elements, FORMATS, ReadError, format_of, parse_elements, read_elements};

/// Header of a table of two elements, as the format is specified.
const HEADER: &str = "ply
format binary_little_endian 1.0
comment thallus VERSION: lichen elements in birth order
element vertex 2
property float x
property float y
property float z
property float nx
property float ny
property float nz
property float radius
property int birth
property int parent
property int colony
property int triangle
property float u
property float v
property float probability
property uchar red
property uchar green
property uchar blue
end_header
";

fn two() -> Elements {
    Elements {
        radius: 0.5,
        positions: vec![[0.0, -1.5, 3.25], [1.0, 1e-7, 1e20]],
        normals: vec![[0.0, 0.0, 1.0], [0.6, 0.8, -0.0]],
        parent: vec![-1, 0],
        colony: vec![0, 7],
        triangle: vec![4607, i32::MAX as u32],
        uv: vec![[0.25, 0.5], [1.0, 0.0]],
        probability: vec![1.0, 0.1],
        source_triangle: None,
        attributes: Vec::new(),
    }
}

/// A table that float32 holds exactly.
fn small() -> Elements {
    let mut elements = two();
    elements.positions = vec![[0.0, -1.5, 3.25], [1.0, f64::from(0.1_f32), -2.0]];
    elements
}

fn grey(age: f32) -> [u8; 3] {
    [(age * 255.0) as u8; 3]
}

fn bytes(extension: &str, elements: &Elements) -> Vec<u8> {
    let mut bytes = Vec::new();
    let format = format_of(&Path::new("a").with_extension(extension)).unwrap();
    format.write(elements, &grey, &mut bytes).unwrap();
    bytes
}

fn parse(bytes: &[u8]) -> Result<Elements, ReadError> {
    parse_elements(Path::new("dir/elements.ply"), bytes)
}

fn split_header(ply: &[u8]) -> (String, &[u8]) {
    let end = ply.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    (String::from_utf8(ply[..end].to_vec()).unwrap(), &ply[end..])
}

/// The data after `header`, spelled by `rows` in ascii.
fn ascii(header: &str, rows: &str) -> Vec<u8> {
    let header = header.replace("binary_little_endian", "ascii");
    format!("{header}{rows}").into_bytes()
}

const ASCII_ROWS: &str = "0 -1.5 3.25 0 0 1 0.5 0 -1 0 4607 0.25 0.5 1 0 0 0\n\
                          1 0.1 -2 0.6 0.8 -0 0.5 1 0 7 2147483647 1 0 0.1 255 255 255\n";

#[test]
fn ply_header_is_as_specified() {
    let ply = bytes("ply", &small());
    let (header, data) = split_header(&ply);
    assert_eq!(header, HEADER.replace("VERSION", env!("CARGO_PKG_VERSION")));
    assert_eq!(data.len(), 2 * (4 * 14 + 3));
    assert_eq!(data[..4], 0_f32.to_le_bytes());
    assert_eq!(data[59 + 56..], [255; 3]);
}

#[test]
fn ply_comes_back_equal() {
    let ply = bytes("ply", &small());
    assert_eq!(parse(&ply).unwrap(), small());
    assert_eq!(bytes("ply", &parse(&ply).unwrap()), ply);
}

#[test]
fn positions_that_float_cannot_resolve_are_double() {
    let mut elements = small();
    elements.positions = vec![[500_000.123_456_789, 5_400_000.25, 112.7]; 2];
    elements.radius = 0.001;
    let ply = bytes("ply", &elements);
    let (header, _) = split_header(&ply);
    assert!(header.contains("property double x\nproperty double y\nproperty double z\n"));
    assert!(header.contains("comment x y z are double"));
    assert!(header.contains("property float radius"));
    let back = parse(&ply).unwrap();
    assert_eq!(back.positions, elements.positions);
    elements.radius = 50.0;
    let (header, _) = (bytes("ply", &elements), ());
    assert!(String::from_utf8_lossy(&header).contains("property float x\n"));
}

/// The rule itself: whichever type is chosen, no position moves by over a hundredth of the radius.
#[test]
fn positions_survive_to_a_hundredth_of_the_radius() {
    for scale in [1e-60, 1e-40, 1e-30, 1e-6, 1.0, 1e6, 1e30, 1e37, 1e38, 1e60] {
        for offset in [0.0, 1.0, 1e2, 1e5, 1e6, 1e9] {
            let mut elements = small();
            let position = [
                scale * (offset + 0.123_456_789),
                -scale * offset / 3.0,
                scale / 7.0,
            ];
            elements.positions = vec![position; 2];
            elements.radius = scale;
            let back = parse(&bytes("ply", &elements)).unwrap();
            let moved = |i: usize| (back.positions[1][i] - position[i]).abs();
            assert!(
                (0..3).all(|i| moved(i) <= scale / 100.0),
                "{scale} {offset}"
            );
            assert!((back.radius / scale - 1.0).abs() < 1e-6, "{scale}");
        }
    }
}

#[test]
fn empty_table_in_every_format() {
    for format in FORMATS {
        assert!(!bytes(format.extension, &Elements::default()).is_empty());
    }
    let empty = parse(&bytes("ply", &Elements::default())).unwrap();
    assert_eq!(empty, Elements::default());
}

#[test]
fn csv_is_as_specified() {
    let text = String::from_utf8(bytes("csv", &two())).unwrap();
    let expected = "x,y,z,nx,ny,nz,radius,birth,parent,colony,triangle,u,v,probability\n\
                    0.0,-1.5,3.25,0.0,0.0,1.0,0.5,0,-1,0,4607,0.25,0.5,1.0\n\
                    1.0,1.0e-7,1.0e20,0.6,0.8,-0.0,0.5,1,0,7,2147483647,1.0,0.0,0.1\n";
    assert_eq!(text, expected);
}

#[test]
fn csv_prints_single_precision_as_it_was_meant() {
    let text = String::from_utf8(bytes("csv", &small())).unwrap();
    assert!(text.ends_with("\n1.0,0.1,-2.0,0.6,0.8,-0.0,0.5,1,0,7,2147483647,1.0,0.0,0.1\n"));
}

#[test]
fn csv_and_npy_have_the_source_triangle_when_known() {
    let mut elements = small();
    elements.source_triangle = Some(vec![9, 8]);
    let text = String::from_utf8(bytes("csv", &elements)).unwrap();
    let lines: Vec<_> = text.lines().collect();
    assert!(lines[0].ends_with(",probability,source_triangle"));
    assert!(lines[1].ends_with(",1.0,9") && lines[2].ends_with(",0.1,8"));
    let npy = bytes("npy", &elements);
    assert!(npy.ends_with(&[8, 0, 0, 0]));
    assert_eq!(npy.len() % 64, 2 * 76 % 64);
    let npz = bytes("npz", &elements);
    assert!(npz.windows(19).any(|w| w == b"source_triangle.npy"));
    assert_eq!(bytes("ply", &elements), bytes("ply", &small()));
}

#[test]
fn npy_header_is_as_numpy_defines_it() {
    let npy = bytes("npy", &small());
    assert_eq!(&npy[..8], b"\x93NUMPY\x01\x00");
    let length = usize::from(u16::from_le_bytes([npy[8], npy[9]]));
    assert_eq!((10 + length) % 64, 0);
    assert_eq!(npy.len(), 10 + length + 2 * 72);
    let dict = std::str::from_utf8(&npy[10..10 + length]).unwrap();
    assert!(dict.starts_with("{'descr': [('x', '<f8'), ('y', '<f8'), ('z', '<f8'), ('nx', '<f4')"));
    assert!(
        dict.trim_end()
            .ends_with("'fortran_order': False, 'shape': (2,), }")
    );
    assert!(dict.ends_with('\n'));
}

/// Walks the archive by its own sizes and offsets.
#[test]
fn npz_is_a_zip_whose_sizes_and_offsets_agree() {
    let npz = bytes("npz", &small());
    let u16_at = |at: usize| usize::from(u16::from_le_bytes([npz[at], npz[at + 1]]));
    let u32_at = |at: usize| u32::from_le_bytes(npz[at..at + 4].try_into().unwrap());
    let end = npz.len() - 22;
    assert_eq!(&npz[end..end + 4], b"PK\x05\x06");
    let mut central = u32_at(end + 16) as usize;
    assert_eq!(central + u32_at(end + 12) as usize, end);
    let mut local = 0;
    for _ in 0..u16_at(end + 10) {
        assert_eq!(&npz[central..central + 4], b"PK\x01\x02");
        assert_eq!(u32_at(central + 42) as usize, local);
        assert_eq!(&npz[local..local + 4], b"PK\x03\x04");
        let size = u32_at(local + 18) as usize;
        let data = local + 30 + u16_at(local + 26);
        assert_eq!(&npz[data..data + 6], b"\x93NUMPY");
        assert_eq!(u32_at(local + 14), crc32(&npz[data..data + size]));
        assert_eq!(npz[central + 16..central + 28], npz[local + 14..local + 26]);
        local = data + size;
        central += 46 + u16_at(central + 28);
    }
    assert_eq!((central, u32_at(end + 16) as usize), (end, local));
}

/// The checksum by its definition, a bit at a time.
fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32| (crc >> 1) ^ (0xEDB8_8320 * (crc & 1));
    !bytes.iter().fold(!0, |crc, &b| {
        (0..8).fold(crc ^ u32::from(b), |crc, _| step(crc))
    })
}

#[test]
fn formats_are_known_by_extension() {
    assert_eq!(
        format_of(Path::new("out/a.b.PLY")).unwrap().extension,
        "ply"
    );
    let unknown = format_of(Path::new("out/a.xls")).unwrap_err().to_string();
    for name in ["out/a.xls", ".xls", ".ply", ".csv", ".npy", ".npz"] {
        assert!(unknown.contains(name), "{unknown}");
    }
    assert!(
        format_of(Path::new("elements"))
            .unwrap_err()
            .to_string()
            .contains("no extension")
    );
    assert!(format_of(Path::new(".ply")).is_err());
}

#[test]
fn unsound_tables_are_not_written() {
    let broken: [fn(&mut Elements); 10] = [
        |e| e.positions[1][2] = f64::NAN,
        |e| e.normals[0][0] = f32::INFINITY,
        |e| e.probability[1] = f32::NAN,
        |e| e.uv[1][1] = f32::NAN,
        |e| e.parent[1] = 1,
        |e| e.parent[0] = -2,
        |e| e.triangle[1] = 1 << 31,
        |e| e.colony.truncate(1),
        |e| e.radius = 0.0,
        |e| e.source_triangle = Some(vec![1]),
    ];
    for (number, breaks) in broken.iter().enumerate() {
        let mut elements = small();
        breaks(&mut elements);
        for format in FORMATS {
            let mut out = Vec::new();
            let error = format.write(&elements, &grey, &mut out).unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::InvalidData, "{number}");
            assert!(out.is_empty());
        }
    }
}

/// Accepts a number of bytes, then is full.
struct Full(usize);

impl Write for Full {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.0 == 0 {
            return Err(io::ErrorKind::StorageFull.into());
        }
        let taken = bytes.len().min(self.0);
        self.0 -= taken;
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_full_disk_is_reported_wherever_it_strikes() {
    for format in FORMATS {
        let size = bytes(format.extension, &small()).len();
        for room in 0..size {
            let error = format.write(&small(), &grey, &mut Full(room)).unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::StorageFull);
        }
        format.write(&small(), &grey, &mut Full(size)).unwrap();
    }
}

#[test]
fn ascii_and_big_endian_are_read() {
    let ply = bytes("ply", &small());
    let (header, data) = split_header(&ply);
    assert_eq!(parse(&ascii(&header, ASCII_ROWS)).unwrap(), small());
    let crlf = ascii(&header, ASCII_ROWS);
    let crlf = String::from_utf8(crlf).unwrap().replace('\n', "\r\n");
    assert_eq!(parse(crlf.as_bytes()).unwrap(), small());
    let mut big = header.replace("little", "big").into_bytes();
    for row in data.chunks(59) {
        row[..56]
            .chunks(4)
            .for_each(|word| big.extend(word.iter().rev()));
        big.extend_from_slice(&row[56..]);
    }
    assert_eq!(parse(&big).unwrap(), small());
}

/// As Blender writes it back: indices as floats, other properties between, faces after.
#[test]
fn rewritten_tables_are_read() {
    let header = "ply\nformat ascii 1.0\ncomment x\nobj_info y\nelement vertex 2\n\
                  property float probability\nproperty short birth\nproperty float v\n\
                  property float u\nproperty double triangle\nproperty float parent\n\
                  property uint8 colony\nproperty double radius\nproperty float foreign\n\
                  property double nz\nproperty float ny\nproperty float nx\n\
                  property double z\nproperty float y\nproperty float x\n\
                  element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    let rows = "0.1 1 0 1 2147483647 0 7 0.5 99 -0 0.8 0.6 -2 0.1 1\n\
                1 0 0.5 0.25 4607 -1 0 0.5 99 1 0 0 3.25 -1.5 0\n3 0 1 2\n";
    let mut expected = small();
    expected.normals[1][2] = -0.0;
    assert_eq!(
        parse(format!("{header}{rows}").as_bytes()).unwrap(),
        expected
    );
}

/// What programs do to headers of meshes they do to this one.
#[test]
fn headers_are_read_as_those_of_meshes() {
    let ply = bytes("ply", &small());
    let (header, data) = split_header(&ply);
    let marked = [
        b"\xEF\xBB\xBF".as_slice(),
        header.replacen("ply", "PLY", 1).as_bytes(),
        data,
    ]
    .concat();
    assert_eq!(parse(&marked).unwrap(), small());
    let lone_cr = [header.replace('\n', "\r").as_bytes(), data].concat();
    assert_eq!(parse(&lone_cr).unwrap(), small());
    let wide = ascii(
        &header.replace("property int parent", "property int64 parent"),
        ASCII_ROWS,
    );
    assert_eq!(parse(&wide).unwrap(), small());
}

fn problem(bytes: &[u8]) -> String {
    let problem = parse(bytes).unwrap_err().to_string();
    assert!(problem.starts_with("dir/elements.ply: "), "{problem}");
    problem
}

#[test]
fn errors_name_the_place() {
    let ply = bytes("ply", &small());
    let (header, data) = split_header(&ply);
    let with = |from: &str, to: &str| {
        assert!(header.contains(from) || ASCII_ROWS.contains(from), "{from}");
        ascii(
            &header.replacen(from, to, 1),
            &ASCII_ROWS.replacen(from, to, 1),
        )
    };
    let cases = [
        (with("ply\n", "obj\n"), "header, line 1"),
        (
            with("property int parent", "property int mother"),
            "no property 'parent'",
        ),
        (
            with("property float u\n", "property list uchar int u\n"),
            "header, line 16: 'u' is a list",
        ),
        (
            with("float u\n", "real u\n"),
            "header, line 16: type 'real' is unknown",
        ),
        (
            with("float u\n", "float v\n"),
            "header, line 17: property 'v' is there twice",
        ),
        (
            with("element vertex 2", "element vertex -2"),
            "header, line 4",
        ),
        (
            with("element vertex 2", "element vertex 99999999999"),
            "header, line 4",
        ),
        (
            with("element vertex 2", "element face 2"),
            "'face' comes before the vertices",
        ),
        (
            with("element vertex 2", "element vertex 3"),
            "element 2 of 3: the file ends here",
        ),
        (
            with("element vertex 2", "element vertex 1"),
            "more than the header declares",
        ),
        (with("0.1 -2", "0.1 abc"), "line 24: 'abc' is not a number"),
        (
            with("0.1 -2", "0.1"),
            "line 24: 16 values where the header declares 17",
        ),
        (
            with("0.1 -2", "0.1 1 1 -2"),
            "line 24: more than the 17 values",
        ),
        (with("1 0 7", "1 0.5 7"), "line 24: parent is 0.5"),
        (
            with("1 0 7", "1 -2 7"),
            "line 24: parent is -2, which is neither -1 nor a whole number",
        ),
        (with("1 0 7", "1 1 7"), "element 1: parent must be"),
        (with("0.5 1 0 7", "0.5 2 0 7"), "no element has birth 1"),
        (with("0.5 1 0 7", "0.5 0 0 7"), "two elements have birth 0"),
        (with("0.5 1 0 7", "0.6 1 0 7"), "line 24: radius 0.6"),
        (
            with("0.1 -2", "inf -2"),
            "element 1: position is not a finite number",
        ),
        (
            with("property int triangle", "property float triangle"),
            "from 16777216 on",
        ),
    ];
    for (file, expected) in cases {
        let problem = problem(&file);
        assert!(problem.contains(expected), "{problem}\nlacks {expected}");
    }
    let longer = [&ply[..], &[0]].concat();
    assert!(problem(&longer).contains("more than the header declares"));
    let text_mode = [header.as_bytes(), &data[..100]].concat();
    assert!(problem(&text_mode).contains("element 1 of 2: the file ends here"));
}

#[test]
fn a_file_cut_off_anywhere_is_an_error() {
    let ply = bytes("ply", &small());
    for length in 0..ply.len() {
        problem(&ply[..length]);
    }
    let (header, _) = split_header(&ply);
    let text = ascii(&header, ASCII_ROWS);
    for length in 0..text.len() {
        problem(&text[..length]);
    }
}

/// A file of a few bytes that declares two billion elements costs a few bytes.
#[test]
fn declared_counts_do_not_allocate() {
    let ply = bytes("ply", &small());
    let (header, data) = split_header(&ply);
    let header = header.replace("vertex 2", "vertex 2147483647");
    let file = [header.as_bytes(), data].concat();
    assert!(problem(&file).contains("element 2 of 2147483647"));
    let long = [b"ply\n".as_slice(), &vec![b'a'; 3 << 20]].concat();
    assert!(problem(&long).contains("first MiB"));
}

#[test]
fn files_that_cannot_be_opened() {
    let missing = read_elements(Path::new("no/such.ply"))
        .unwrap_err()
        .to_string();
    assert!(missing.starts_with("no/such.ply: "), "{missing}");
    let folder = read_elements(Path::new(env!("CARGO_MANIFEST_DIR"))).unwrap_err();
    assert!(folder.to_string().contains("this is a folder"), "{folder}");
}

#[test]
fn a_file_on_disk_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("elements.ply");
    std::fs::write(&path, bytes("ply", &small())).unwrap();
    assert_eq!(read_elements(&path).unwrap(), small());
}

type RowValues = (
    [f32; 3],
    [f32; 3],
    Option<prop::sample::Index>,
    u32,
    u32,
    [f32; 2],
    f32,
);

fn rows() -> impl Strategy<Value = Vec<RowValues>> {
    let f = || prop::num::f32::NORMAL | prop::num::f32::SUBNORMAL | prop::num::f32::ZERO;
    let index = || 0..=i32::MAX as u32;
    let parent = proptest::option::of(any::<prop::sample::Index>());
    let row = (
        [f(), f(), f()],
        [f(), f(), f()],
        parent,
        index(),
        index(),
        [f(), f()],
        f(),
    );
    prop::collection::vec(row, 0..40)
}

fn table(rows: &[RowValues], radius: f32) -> Elements {
    let mut elements = Elements {
        radius: f64::from(radius),
        ..Elements::default()
    };
    for (born, (position, normal, parent, colony, triangle, uv, probability)) in
        rows.iter().enumerate()
    {
        let parent = parent
            .filter(|_| born > 0)
            .map_or(-1, |i| i.index(born) as i32);
        elements.positions.push(position.map(f64::from));
        elements.normals.push(*normal);
        elements.parent.push(parent);
        elements.colony.push(*colony);
        elements.triangle.push(*triangle);
        elements.uv.push(*uv);
        elements.probability.push(*probability);
    }
    elements
}

/// Reads the numbers of a CSV file back into a table.
fn from_csv(text: &str) -> Elements {
    let mut elements = Elements::default();
    for line in text.lines().skip(1) {
        let words: Vec<_> = line.split(',').collect();
        let f = |i: usize| words[i].parse::<f32>().unwrap();
        let n = |i: usize| words[i].parse::<i32>().unwrap();
        assert!(
            [0, 1, 2, 3, 4, 5, 6, 11, 12, 13]
                .iter()
                .all(|&i: &usize| words[i].contains('.'))
        );
        assert_eq!(n(7) as usize, elements.len());
        elements.positions.push([f(0), f(1), f(2)].map(f64::from));
        elements.normals.push([f(3), f(4), f(5)]);
        elements.radius = f64::from(f(6));
        elements.parent.push(n(8));
        elements.colony.push(n(9) as u32);
        elements.triangle.push(n(10) as u32);
        elements.uv.push([f(11), f(12)]);
        elements.probability.push(f(13));
    }
    elements
}

proptest! {
    // A failure becomes a test by hand, not a file.
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_table_comes_back_from_ply_and_csv(rows in rows(), radius in f32::MIN_POSITIVE..1e30) {
        let mut elements = table(&rows, radius);
        prop_assert_eq!(&from_csv(std::str::from_utf8(&bytes("csv", &elements)).unwrap()).positions,
            &elements.positions);
        let ply = bytes("ply", &elements);
        if elements.is_empty() {
            elements.radius = 0.0;
        }
        prop_assert_eq!(&parse(&ply).unwrap(), &elements);
        prop_assert_eq!(bytes("ply", &parse(&ply).unwrap()), ply);
        prop_assert_eq!(from_csv(std::str::from_utf8(&bytes("csv", &elements)).unwrap()), elements);
    }

    #[test]
    fn rows_are_sorted_by_birth(rows in rows(), keys in prop::collection::vec(any::<u32>(), 40)) {
        let elements = table(&rows, 0.5);
        let ply = bytes("ply", &elements);
        let (header, data) = split_header(&ply);
        let stride = if elements.is_empty() { 1 } else { data.len() / elements.len() };
        let mut chunks: Vec<_> = data.chunks(stride).zip(keys).collect();
        chunks.sort_by_key(|(_, key)| *key);
        let shuffled = chunks.iter().flat_map(|(chunk, _)| chunk.iter().copied());
        let file: Vec<u8> = header.bytes().chain(shuffled).collect();
        let back = parse(&file).unwrap();
        prop_assert_eq!(back.positions, elements.positions);
        prop_assert_eq!(back.parent, elements.parent);
        prop_assert_eq!(back.probability, elements.probability);
    }

    #[test]
    fn damaged_files_never_panic(
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..20),
        to_ascii in any::<bool>(),
    ) {
        let mut file = bytes("ply", &small());
        if to_ascii {
            let (header, _) = split_header(&file);
            file = ascii(&header, ASCII_ROWS);
        }
        for (place, byte) in damage {
            let place = place.index(file.len());
            file[place] = byte;
        }
        if let Ok(elements) = parse(&file) {
            prop_assert!(elements.check().is_ok());
        }
    }

    #[test]
    fn garbage_never_panics(garbage in prop::collection::vec(any::<u8>(), 0..300)) {
        prop_assert!(parse(&garbage).is_err());
        let headed = [HEADER.as_bytes(), &garbage].concat();
        let _ = parse(&headed);
    }
}
