//! The glTF loader's features on documents that the tests build, and its errors.

use serde_json::{Value, json};
use thallus::substrate::{Format, LoadFault, Soup, load_soup, parse_soup};

const FLOAT: u32 = 5126;
const U8: u32 = 5121;
const U16: u32 = 5123;
const U32: u32 = 5125;
const I8: u32 = 5120;
const I16: u32 = 5122;

/// A document with one buffer.
struct Doc {
    json: Value,
    bin: Vec<u8>,
}

impl Doc {
    fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"}, "bufferViews": [], "accessors": [], "meshes": [],
            "nodes": [], "buffers": [{"byteLength": 0}],
        });
        Self {
            json,
            bin: Vec::new(),
        }
    }

    fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.json[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let at = self.bin.len();
        self.bin.extend(bytes);
        self.push(
            "bufferViews",
            json!({"buffer": 0, "byteOffset": at, "byteLength": bytes.len()}),
        )
    }

    fn accessor(&mut self, bytes: &[u8], component: u32, lanes: &str, count: usize) -> usize {
        let view = self.view(bytes);
        let accessor =
            json!({"bufferView": view, "componentType": component, "type": lanes, "count": count});
        self.push("accessors", accessor)
    }

    fn positions(&mut self, positions: &[[f32; 3]]) -> usize {
        self.accessor(&floats(positions), FLOAT, "VEC3", positions.len())
    }

    fn indices(&mut self, indices: &[u16]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
        self.accessor(&bytes, U16, "SCALAR", indices.len())
    }

    /// A mesh of one primitive, and a node that shows it.
    fn show(&mut self, primitive: Value, node: Value) -> usize {
        let mesh = self.push("meshes", json!({"primitives": [primitive]}));
        let mut node = node;
        node["mesh"] = json!(mesh);
        self.push("nodes", node)
    }

    fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"][0]["byteLength"] = json!(self.bin.len());
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut bin = self.bin.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        let mut bytes = b"glTF\x02\0\0\0".to_vec();
        bytes.extend((28 + text.len() as u32 + bin.len() as u32).to_le_bytes());
        for (kind, data) in [(b"JSON", text), (b"BIN\0", bin)] {
            bytes.extend((data.len() as u32).to_le_bytes());
            bytes.extend(kind);
            bytes.extend(data);
        }
        bytes
    }

    fn with_uri(&self, uri: &str) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"][0] = json!({"byteLength": self.bin.len(), "uri": uri});
        json.to_string().into_bytes()
    }

    fn load(&self) -> Soup {
        parse_soup(&self.glb(), Format::Glb, None).unwrap_or_else(|error| panic!("{error}"))
    }

    fn refused(&self) -> String {
        match parse_soup(&self.glb(), Format::Glb, None) {
            Ok(soup) => panic!("loaded {} triangles", soup.triangles.len()),
            Err(error) => error.to_string(),
        }
    }
}

fn floats(positions: &[[f32; 3]]) -> Vec<u8> {
    positions
        .iter()
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .collect()
}

fn base64(bytes: &[u8]) -> String {
    let alphabet = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for group in bytes.chunks(3) {
        let bits = group
            .iter()
            .fold(0_u32, |bits, b| bits << 8 | u32::from(*b))
            << (8 * (3 - group.len()));
        for i in 0..4 {
            let symbol = alphabet[(bits >> (18 - 6 * i) & 63) as usize];
            text.push(if i <= group.len() {
                symbol as char
            } else {
                '='
            });
        }
    }
    text
}

#[track_caller]
fn assert_says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "{part:?} is not in {message:?}");
    }
}

/// A tetrahedron with outward winding.
const CORNERS: [[f32; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
];
const SOLID: [u16; 12] = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];

fn tetrahedron(node: Value) -> Doc {
    let mut doc = Doc::new();
    let (position, indices) = (doc.positions(&CORNERS), doc.indices(&SOLID));
    doc.show(
        json!({"attributes": {"POSITION": position}, "indices": indices}),
        node,
    );
    doc
}

/// Six times the signed volume: positive when triangles wind counter-clockwise seen from outside.
fn volume(soup: &Soup) -> f64 {
    let term = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| soup.positions[i as usize]);
        (0..3)
            .map(|k| {
                let (l, m) = ((k + 1) % 3, (k + 2) % 3);
                a[k] * (b[l] * c[m] - b[m] * c[l])
            })
            .sum::<f64>()
    };
    soup.triangles.iter().map(term).sum()
}

fn close(a: [f64; 3], b: [f64; 3]) -> bool {
    (0..3).all(|k| (a[k] - b[k]).abs() < 1e-6)
}

#[test]
fn transforms_compose_down_the_hierarchy() {
    let mut doc = tetrahedron(json!({"translation": [1, 2, 3]}));
    // A quarter turn about z, and twice the size, above it.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    doc.push(
        "nodes",
        json!({"children": [0], "rotation": [0, 0, half, half], "scale": [2, 2, 2]}),
    );
    let soup = doc.load();
    assert!(
        close(soup.positions[0], [-4.0, 2.0, 6.0]),
        "{:?}",
        soup.positions
    );
    assert!(
        close(soup.positions[1], [-4.0, 4.0, 6.0]),
        "{:?}",
        soup.positions
    );
    assert!((volume(&soup) - 8.0).abs() < 1e-5);
}

#[test]
fn mirrored_and_uneven_transforms_keep_the_outside_outside() {
    let mirror = [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
    let nodes = [
        json!({"scale": [-2, 1, 3]}),
        json!({"scale": [-1, -1, -1]}),
        json!({"matrix": mirror}),
        json!({"scale": [-1, -2, 1]}),
        json!({}),
    ];
    for (node, expected) in nodes.into_iter().zip([6.0, 1.0, 1.0, 2.0, 1.0]) {
        let found = volume(&tetrahedron(node.clone()).load());
        assert!((found - expected).abs() < 1e-9, "{node}: {found}");
    }
}

#[test]
fn a_mesh_that_two_nodes_show_is_there_twice() {
    let mut doc = tetrahedron(json!({}));
    doc.push("nodes", json!({"mesh": 0, "translation": [10, 0, 0]}));
    let soup = doc.load();
    assert_eq!(soup.triangles.len(), 8);
    assert_eq!(soup.positions[5], [11.0, 0.0, 0.0]);
}

#[test]
fn shared_points_of_instances_stay_equal_and_far_offsets_cost_nothing() {
    let mut doc = tetrahedron(json!({"translation": [0.1, 0.2, 0.3], "scale": [0.3, 0.3, 0.3]}));
    doc.push(
        "nodes",
        json!({"mesh": 0, "translation": [0.4, 0.2, 0.3], "scale": [0.3, 0.3, 0.3]}),
    );
    let soup = doc.load();
    assert_eq!(soup.positions[1], soup.positions[4]);
    // Geocentric: single precision would be half a metre here.
    let far =
        tetrahedron(json!({"translation": [4_510_731.123, -2_703_000.5, 5_000_000.25]})).load();
    let edge: Vec<f64> = (0..3)
        .map(|k| far.positions[1][k] - far.positions[0][k])
        .collect();
    assert!(
        (edge[0] - 1.0).abs() < 1e-6 && edge[1].abs() < 1e-6,
        "{edge:?}"
    );
    assert!((far.positions[0][0] - 4_510_731.123).abs() < 1e-6);
}

#[test]
fn only_the_default_scene_is_read() {
    let mut doc = tetrahedron(json!({}));
    doc.push("nodes", json!({"mesh": 0}));
    assert_eq!(doc.load().triangles.len(), 8);
    doc.json["scenes"] = json!([{"nodes": [0, 1]}, {"nodes": [1]}]);
    assert_eq!(doc.load().triangles.len(), 8);
    doc.json["scene"] = json!(1);
    let soup = doc.load();
    assert_eq!(soup.triangles.len(), 4);
    assert_eq!(soup.notes, ["one of 2 scenes read"]);
}

#[test]
fn lists_strips_and_fans_wind_as_the_specification_says() {
    let square = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
    ];
    let cases = [
        (4, vec![0, 1, 2, 1, 3, 2, 0], vec![[0, 1, 2], [1, 3, 2]]),
        (5, vec![0, 1, 2, 3], vec![[0, 1, 2], [1, 3, 2]]),
        (6, vec![0, 1, 3, 2], vec![[0, 1, 3], [0, 3, 2]]),
    ];
    for (mode, order, expected) in cases {
        let mut doc = Doc::new();
        let (position, indices) = (doc.positions(&square), doc.indices(&order));
        doc.show(
            json!({"attributes": {"POSITION": position}, "indices": indices, "mode": mode}),
            json!({}),
        );
        let soup = doc.load();
        assert_eq!(soup.triangles, expected);
        assert!(soup.triangles.iter().all(|t| {
            let [a, b, c] = t.map(|i| soup.positions[i as usize]);
            (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0
        }));
        assert_eq!(soup.notes.len(), usize::from(mode == 4), "{:?}", soup.notes);
    }
}

#[test]
fn primitives_may_lack_indices_and_points_and_lines_are_noted() {
    let mut doc = Doc::new();
    let position = doc.positions(&CORNERS[..3]);
    doc.show(json!({"attributes": {"POSITION": position}}), json!({}));
    for mode in [0, 1, 2, 3] {
        doc.show(
            json!({"attributes": {"POSITION": position}, "mode": mode}),
            json!({}),
        );
    }
    doc.show(
        json!({"attributes": {"NORMAL": position}}),
        json!({"skin": 7}),
    );
    let soup = doc.load();
    assert_eq!(soup.triangles, [[0, 1, 2]]);
    let expected = [
        "1 point primitive ignored",
        "3 line primitives ignored",
        "1 primitive without positions ignored",
        "1 skinned mesh read at rest",
    ];
    assert_eq!(soup.notes, expected);
}

#[test]
fn indices_of_every_width() {
    type Write = fn(u16) -> Vec<u8>;
    let widths: [(u32, Write); 3] = [
        (U8, |i| vec![i as u8]),
        (U16, |i| i.to_le_bytes().to_vec()),
        (U32, |i| u32::from(i).to_le_bytes().to_vec()),
    ];
    for (component, write) in widths {
        let mut doc = Doc::new();
        let position = doc.positions(&CORNERS);
        let bytes: Vec<u8> = SOLID.iter().flat_map(|&i| write(i)).collect();
        let indices = doc.accessor(&bytes, component, "SCALAR", SOLID.len());
        doc.show(
            json!({"attributes": {"POSITION": position}, "indices": indices}),
            json!({}),
        );
        assert_eq!(volume(&doc.load()), 1.0);
    }
}

#[test]
fn interleaved_positions_are_found_by_their_stride() {
    let mut doc = tetrahedron(json!({}));
    let mut bytes = vec![0xFF; 8];
    for (i, corner) in CORNERS.iter().enumerate() {
        bytes.extend(floats(&[*corner]));
        // The last element has nothing behind it.
        if i < 3 {
            bytes.extend([0xEE; 8]);
        }
    }
    let view = doc.view(&bytes);
    doc.json["bufferViews"][view]["byteStride"] = json!(20);
    doc.json["accessors"][0]["bufferView"] = json!(view);
    doc.json["accessors"][0]["byteOffset"] = json!(8);
    assert_eq!(volume(&doc.load()), 1.0);
}

#[test]
fn sparse_accessors_replace_elements_with_and_without_a_base() {
    let mut doc = tetrahedron(json!({}));
    let (at, values) = (
        doc.view(&[1, 3]),
        doc.view(&floats(&[[2.0, 0.0, 0.0], [0.0, 0.0, 5.0]])),
    );
    let sparse = json!({"count": 2, "values": {"bufferView": values},
                        "indices": {"bufferView": at, "componentType": U8}});
    doc.json["accessors"][0]["sparse"] = sparse;
    assert_eq!(volume(&doc.load()), 10.0);
    doc.json["accessors"][0]
        .as_object_mut()
        .unwrap()
        .remove("bufferView");
    let soup = doc.load();
    assert_eq!(
        soup.positions,
        [[0.0; 3], [2.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 5.0]]
    );
    let at = doc.view(&[1, 4]);
    doc.json["accessors"][0]["sparse"]["indices"]["bufferView"] = json!(at);
    assert_says(
        &doc.refused(),
        &["accessor 0", "sparse index 4, but 4 elements"],
    );
}

#[test]
fn quantized_positions_are_dequantized_as_the_specification_says() {
    let cases: [(u32, bool, &[u8], f64); 8] = [
        (I8, false, &[0x80], -128.0),
        (I8, true, &[0x80], -1.0),
        (I8, true, &[127], 1.0),
        (U8, true, &[51], 0.2),
        (I16, false, &[0, 0x80], -32768.0),
        (I16, true, &[0, 0x80], -1.0),
        (U16, false, &[0xFF, 0xFF], 65535.0),
        (U16, true, &[0xFF, 0xFF], 1.0),
    ];
    for (component, normalized, value, expected) in cases {
        let mut doc = Doc::new();
        let zero = vec![0; value.len()];
        let vertices: Vec<u8> = [
            [value, &zero, &zero],
            [&zero, value, &zero],
            [&zero, &zero, value],
        ]
        .iter()
        .flat_map(|v| [v.concat(), vec![0; value.len()]].concat())
        .collect();
        let position = doc.accessor(&vertices, component, "VEC3", 3);
        doc.json["bufferViews"][0]["byteStride"] = json!(4 * value.len());
        doc.json["accessors"][0]["normalized"] = json!(normalized);
        doc.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        doc.show(json!({"attributes": {"POSITION": position}}), json!({}));
        let soup = doc.load();
        let expected = f64::from(expected as f32);
        assert_eq!(soup.positions[0], [expected, 0.0, 0.0]);
        assert_eq!(soup.positions[2], [0.0, 0.0, expected]);
        assert_eq!(soup.notes, Vec::<String>::new());
    }
}

#[test]
fn gpu_instances_are_all_there() {
    let mut doc = tetrahedron(json!({"scale": [2, 2, 2]}));
    let translation = doc.positions(&[[0.0; 3], [5.0, 0.0, 0.0]]);
    let scale = doc.positions(&[[1.0; 3], [1.0, -1.0, 1.0]]);
    // Normalized shorts; unnormalized length is forgiven.
    let turns: Vec<u8> = [[0_i16, 0, 0, 32767], [0, 0, 16384, 16384]]
        .iter()
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let rotation = doc.accessor(&turns, I16, "VEC4", 2);
    doc.json["accessors"][rotation]["normalized"] = json!(true);
    let attributes = json!({"TRANSLATION": translation, "SCALE": scale, "ROTATION": rotation});
    doc.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"] =
        json!({"attributes": attributes});
    let soup = doc.load();
    assert_eq!(soup.triangles.len(), 8);
    assert!((volume(&soup) - 16.0).abs() < 1e-5, "{}", volume(&soup));
    assert!(
        close(soup.positions[5], [10.0, 2.0, 0.0]),
        "{:?}",
        soup.positions
    );
    doc.json["accessors"][scale]["count"] = json!(1);
    assert_says(
        &doc.refused(),
        &["node 0", "EXT_mesh_gpu_instancing", "differ in count"],
    );
}

#[test]
fn buffers_come_from_the_chunk_from_data_uris_and_from_files() {
    let doc = tetrahedron(json!({}));
    let expected = doc.load();
    let uri = format!("data:application/octet-stream;base64,{}", base64(&doc.bin));
    assert_eq!(
        parse_soup(&doc.with_uri(&uri), Format::Gltf, None).unwrap(),
        expected
    );

    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a b%é.bin"), &doc.bin).unwrap();
    let path = folder.path().join("scene.gltf");
    std::fs::write(&path, doc.with_uri("a%20b%25%C3%A9.bin")).unwrap();
    let loaded = load_soup(&path).unwrap();
    assert_eq!(loaded.soup, expected);
    let mut hasher = blake3::Hasher::new();
    hasher
        .update(&std::fs::read(&path).unwrap())
        .update(&doc.bin);
    assert_eq!(loaded.hash, hasher.finalize().to_hex().to_string());
}

#[test]
fn missing_and_short_buffers_are_named() {
    let doc = tetrahedron(json!({}));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.gltf");
    std::fs::write(&path, doc.with_uri("gone.bin")).unwrap();
    let error = load_soup(&path).unwrap_err();
    assert!(matches!(error.fault, LoadFault::Unreadable { .. }));
    assert_says(
        &error.to_string(),
        &["scene.gltf: buffer 0", "gone.bin", "beside the glTF file"],
    );

    std::fs::write(folder.path().join("gone.bin"), &doc.bin[1..]).unwrap();
    assert_says(
        &load_soup(&path).unwrap_err().to_string(),
        &["buffer 0", "cut short"],
    );

    let cases = [
        ("https://example.org/a.bin", "lies elsewhere"),
        ("data:;base64,????", "not valid base64"),
        ("a.bin", "external file"),
        ("%zz.bin", "external file"),
    ];
    for (uri, problem) in cases {
        let error = parse_soup(&doc.with_uri(uri), Format::Gltf, None)
            .unwrap_err()
            .to_string();
        assert_says(&error, &["accessor 0", "buffer 0", problem]);
    }
}

/// Meshopt data as an exporter writes it: the view's own buffer is an empty placeholder.
fn compressed(name: &str) -> Doc {
    let mut doc = tetrahedron(json!({}));
    let words: Vec<[f32; 3]> = CORNERS.to_vec();
    let vertices = meshopt::encode_vertex_buffer(&words).unwrap();
    let indices: Vec<u32> = SOLID.iter().map(|&i| i.into()).collect();
    let faces = meshopt::encode_index_buffer(&indices, 4).unwrap();
    for (view, data, stride, count, mode) in [
        (0, vertices, 12, 4, "ATTRIBUTES"),
        (1, faces, 2, 12, "TRIANGLES"),
    ] {
        let packed = doc.view(&data);
        let at = doc.json["bufferViews"][packed]["byteOffset"].clone();
        doc.json["bufferViews"][view]["buffer"] = json!(1);
        doc.json["bufferViews"][view]["extensions"][name] = json!({
            "buffer": 0, "byteOffset": at, "byteLength": data.len(),
            "byteStride": stride, "count": count, "mode": mode,
        });
    }
    doc.push("buffers", json!({"byteLength": 1000}));
    doc
}

#[test]
fn meshopt_compression_is_decoded_under_either_name() {
    for name in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
        let mut doc = compressed(name);
        assert_eq!(volume(&doc.load()), 1.0);
        doc.json["bufferViews"][0]["extensions"][name]["byteLength"] = json!(5);
        assert_says(
            &doc.refused(),
            &["primitive 0, accessor 0, bufferView 0", name, "export"],
        );
        doc.json["bufferViews"][0]["extensions"][name]["count"] = json!(4_000_000_000_u64);
        assert_says(&doc.refused(), &["cannot hold 4000000000 elements"]);
    }
}

#[test]
fn a_real_fallback_buffer_saves_broken_meshopt_data() {
    let mut doc = compressed("EXT_meshopt_compression");
    doc.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]["mode"] = json!("NEW");
    assert_says(&doc.refused(), &["mode NEW"]);
    let uri = format!("data:;base64,{}", base64(&doc.bin));
    doc.json["buffers"][1] = json!({"byteLength": doc.bin.len(), "uri": uri});
    assert_eq!(volume(&doc.load()), 1.0);
}

#[test]
fn meshopt_filters_are_undone() {
    // EXPONENTIAL: exponent in the high byte, mantissa in the low three. 3·2⁻¹ = 1.5.
    let value = |mantissa: i32, exponent: i32| (exponent << 24 | (mantissa & 0xFF_FFFF)) as u32;
    let words = [
        [value(3, -1), 0, 0],
        [0, value(-1, 2), 0],
        [0, 0, value(1, 0)],
        [0; 3],
    ];
    let data = meshopt::encode_vertex_buffer(&words).unwrap();
    let mut doc = compressed("EXT_meshopt_compression");
    let packed = doc.view(&data);
    let at = doc.json["bufferViews"][packed]["byteOffset"].clone();
    let extension = &mut doc.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"];
    extension["filter"] = json!("EXPONENTIAL");
    extension["byteOffset"] = at;
    extension["byteLength"] = json!(data.len());
    let soup = doc.load();
    assert_eq!(
        soup.positions[..3],
        [[1.5, 0.0, 0.0], [0.0, -4.0, 0.0], [0.0, 0.0, 1.0]]
    );
}

#[test]
fn draco_is_refused_by_name_unless_plain_accessors_are_there_too() {
    let mut doc = tetrahedron(json!({}));
    let draco = json!({"bufferView": 0, "attributes": {"POSITION": 0}});
    doc.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = draco;
    assert_eq!(volume(&doc.load()), 1.0);
    doc.json["accessors"][0]
        .as_object_mut()
        .unwrap()
        .remove("bufferView");
    let message = doc.refused();
    assert_says(
        &message,
        &[
            "KHR_draco_mesh_compression is not supported",
            "export again without",
        ],
    );
}

#[test]
fn materials_and_unknown_extensions_do_not_stop_a_load() {
    let mut doc = tetrahedron(json!({}));
    doc.json["materials"] = json!([{"alphaMode": "STRANGE", "extensions": {"KHR_materials_x": 3}}]);
    doc.json["images"] = json!([{"uri": "gone.ktx2"}]);
    doc.json["extensionsRequired"] =
        json!(["KHR_materials_unlit", "KHR_texture_basisu", "ACME_warp"]);
    let soup = doc.load();
    assert_eq!(volume(&soup), 1.0);
    assert_eq!(
        soup.notes,
        ["the file requires the extension 'ACME_warp', which was not applied"]
    );
}

#[test]
fn errors_name_the_node_the_primitive_and_the_accessor() {
    type Break = fn(&mut Value);
    let cases: [(Break, &[&str]); 17] = [
        (|j| j["scene"] = json!(3), &["scene 3", "no such scene"]),
        (
            |j| j["nodes"][0]["mesh"] = json!(9),
            &["node 0", "no mesh 9"],
        ),
        (
            |j| j["nodes"][0]["children"] = json!([7]),
            &["node 7", "the file has 1"],
        ),
        (
            |j| j["nodes"][0]["children"] = json!([0]),
            &["nodes", "cycle"],
        ),
        (
            |j| j["nodes"] = json!([{"children": [1, 1]}, {}]),
            &["node 1", "child of two nodes"],
        ),
        (
            |j| j["nodes"][0]["scale"] = json!([1e300, 1, 1]),
            &["primitive 0, accessor 0, vertex 1", "not finite"],
        ),
        (
            |j| j["nodes"][0]["rotation"] = json!([0, 0, 0, 0]),
            &["node 0", "transform"],
        ),
        (
            |j| j["nodes"][0]["matrix"] = json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
            &["not affine"],
        ),
        (
            |j| j["accessors"][0]["count"] = json!(5),
            &["accessor 0", "5 elements", "reach beyond"],
        ),
        (
            |j| j["accessors"][0]["byteOffset"] = json!(u64::MAX),
            &["accessor 0", "reach beyond"],
        ),
        (
            |j| j["accessors"][0]["count"] = json!(3),
            &["accessor 1, index 5", "vertex 3 is named"],
        ),
        (
            |j| j["accessors"][0]["type"] = json!("VEC2"),
            &["accessor 0", "VEC2, not VEC3"],
        ),
        (
            |j| j["accessors"][0]["componentType"] = json!(1),
            &["accessor 0", "component type 1"],
        ),
        (
            |j| j["accessors"][1]["componentType"] = json!(FLOAT),
            &["accessor 1", "unsigned"],
        ),
        (
            |j| j["bufferViews"][0]["byteLength"] = json!(u64::MAX),
            &["bufferView 0", "buffer 0"],
        ),
        (
            |j| j["bufferViews"][0]["byteStride"] = json!(4),
            &["accessor 0", "overlap"],
        ),
        (
            |j| j["meshes"][0]["primitives"][0]["mode"] = json!(9),
            &["primitive 0", "mode 9"],
        ),
    ];
    for (damage, parts) in cases {
        let mut doc = tetrahedron(json!({}));
        damage(&mut doc.json);
        assert_says(&doc.refused(), parts);
    }
}

#[test]
fn nothing_is_allocated_on_a_counts_word() {
    let mut doc = tetrahedron(json!({}));
    doc.json["accessors"][0] =
        json!({"componentType": FLOAT, "type": "VEC3", "count": 1_u64 << 40});
    assert_says(&doc.refused(), &["without any data"]);
    // A kilobyte of instances of a megabyte: refused before the memory is full.
    let mut doc = Doc::new();
    let position = doc.positions(&vec![[0.0, 1.0, 2.0]; 60_000]);
    doc.show(json!({"attributes": {"POSITION": position}}), json!({}));
    for _ in 0..3_000 {
        doc.push("nodes", json!({"mesh": 0}));
    }
    assert_says(&doc.refused(), &["33 million", "export only the object"]);
}

#[test]
fn containers_are_checked() {
    let whole = tetrahedron(json!({})).glb();
    let refused = |bytes: &[u8]| {
        parse_soup(bytes, Format::Glb, None)
            .unwrap_err()
            .to_string()
    };
    assert_says(
        &refused(&whole[..whole.len() - 4]),
        &["byte 8", "promised", "cut short"],
    );
    assert_says(&refused(&whole[..10]), &["byte 10", "header"]);
    let mut old = whole.clone();
    old[4] = 1;
    assert_says(&refused(&old), &["byte 4", "version 1, not 2", "glTF 2.0"]);
    let mut kind = whole.clone();
    kind[16..20].copy_from_slice(b"TEXT");
    assert_says(&refused(&kind), &["byte 12", "'TEXT', not JSON"]);
    let mut long = whole.clone();
    long[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    assert_says(&refused(&long), &["byte 12", "beyond the end"]);
    let json = parse_soup(
        b"{\"asset\": {\"version\": \"1.0\"}, \"nodes\": {}}",
        Format::Gltf,
        None,
    );
    assert_says(
        &json.unwrap_err().to_string(),
        &["'1.0', not 2", "export it as glTF 2.0"],
    );
    let json = parse_soup(b"{\n\"asset\": }", Format::Gltf, None);
    assert_says(&json.unwrap_err().to_string(), &["JSON line 2, column 10"]);
}
