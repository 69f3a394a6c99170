//! Files: names, contents, hashes.

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

/// Reads a mesh with its textures by its path and from memory: the same comes of it.
#[track_caller]
fn assert_same_in_memory(path: &Path, format: Format) {
    let bytes = fs::read(path).unwrap();
    let loaded = load_soup(path).unwrap();
    assert_eq!(loaded.format, format);
    assert_eq!(parse_soup(&bytes, format, path.parent()).unwrap(), loaded);
    let textured = parse_textured(&bytes, format, path.parent()).unwrap();
    assert_eq!(textured, load_textured(path).unwrap());
    assert_eq!(textured.0, loaded);
}

#[test]
fn a_mesh_in_memory_is_the_one_by_its_path() {
    for (name, content, format) in [("a.obj", OBJ, Format::Obj), ("a.stl", STL, Format::Stl)] {
        let (_folder, path) = written(name, content);
        assert_same_in_memory(&path, format);
    }
    let boulder = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes/boulder.glb");
    assert_same_in_memory(&boulder, Format::Glb);
    let bytes = fs::read(&boulder).unwrap();
    let in_memory = Substrate::from_loaded(parse_soup(&bytes, Format::Glb, None).unwrap()).unwrap();
    let by_path = Substrate::load(&boulder).unwrap();
    assert_eq!(in_memory.mesh_hash(), by_path.mesh_hash());
    assert_eq!(in_memory.up_axis(), by_path.up_axis());
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
        (
            "a.obj",
            b"d\x86\x02\0\x7fELF",
            "this is not text, as OBJ is",
        ),
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

/// Stored without compression the text of a mesh stands in an archive as it is, perhaps with that of others.
#[test]
fn an_archive_is_not_read_as_the_mesh_in_it() {
    let zip = [b"PK\x03\x04\x0a\0\0\0\0\0a.obj", OBJ.as_bytes()].concat();
    let mut tar = [b"a.obj".as_slice(), &[0; 252], b"ustar\0"].concat();
    tar.resize(512, 0);
    tar.extend(OBJ.as_bytes());
    let nameless = [b"\0\x01\x02\n", OBJ.as_bytes()].concat();
    for (content, part) in [
        (zip, "ZIP archive"),
        (tar, "tar archive"),
        (nameless, "neither its name nor its content"),
    ] {
        let (_folder, path) = written("mesh", content);
        assert_says(&refusal(&path), &[part]);
    }
}

#[test]
fn utf_16_is_refused_with_a_cure_whatever_its_byte_order() {
    let units = || format!("\u{feff}{OBJ}").encode_utf16().collect::<Vec<_>>();
    let little: Vec<u8> = units().into_iter().flat_map(u16::to_le_bytes).collect();
    let big: Vec<u8> = units().into_iter().flat_map(u16::to_be_bytes).collect();
    for content in [little, big] {
        for name in ["a.obj", "a.stl", "a"] {
            let (_folder, path) = written(name, &content);
            assert_says(&refusal(&path), &["UTF-16 text", "save it as UTF-8"]);
        }
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
    // The text has the system's reason, which programs that print all causes would print again.
    assert!(std::error::Error::source(&error).is_none());
}

#[test]
fn a_line_without_end_is_not_kept() {
    let mut text = STL.to_string();
    text.insert_str("solid s".len(), &"x".repeat(1 << 20));
    let (_folder, path) = written("a.stl", text);
    assert_eq!(load_soup(&path).unwrap().soup.triangles.len(), 1);
}

/// Read as a stream: words and line ends fall on the bounds of what is read at once.
#[test]
fn long_ascii_stl_is_the_same_whatever_ends_its_lines() {
    let facet = |i: usize| {
        format!(
            "facet normal 0 0 1\nouter loop\nvertex {i} 0 0\nvertex {i} 1 0\nvertex {i} 0 1.{i}\nendloop\nendfacet\n"
        )
    };
    let facets: String = (0..3000).map(facet).collect();
    let text = format!("solid long\n{facets}endsolid long\n");
    let (_folder, path) = written("a.stl", &text);
    let expected = load_soup(&path).unwrap().soup;
    assert_eq!(expected.triangles.len(), 3000);
    assert_eq!(expected.positions[8999], [2999.0, 0.0, 1.2999]);
    for end in ["\r", "\r\n", " "] {
        let (_folder, path) = written("a.stl", text.replace('\n', end));
        assert_eq!(load_soup(&path).unwrap().soup, expected, "{end:?}");
    }
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

/// Of a glTF whose texture coordinates are in a file of their own.
#[test]
fn the_hash_is_the_same_with_looks_and_without() {
    let folder = tempfile::tempdir().unwrap();
    let floats = |all: &[f32]| {
        all.iter()
            .flat_map(|x| x.to_le_bytes())
            .collect::<Vec<u8>>()
    };
    let places = floats(&[0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 1.0]);
    std::fs::write(folder.path().join("places.bin"), places).unwrap();
    std::fs::write(
        folder.path().join("uvs.bin"),
        floats(&[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]),
    )
    .unwrap();
    let path = folder.path().join("scene.gltf");
    let scene = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}}]}],
        "buffers": [{"uri": "places.bin", "byteLength": 36}, {"uri": "uvs.bin", "byteLength": 24}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 1, "byteLength": 24}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                      {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"}]}"#;
    std::fs::write(&path, scene).unwrap();
    let (textured, texturing) = load_textured(&path).unwrap();
    assert_eq!(texturing.uvs.len(), 1);
    assert_eq!(textured.hash, load_soup(&path).unwrap().hash);
}
