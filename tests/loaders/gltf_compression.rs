//! glTF: meshopt compression decoded, Draco refused.

use super::gltf_doc::*;
use super::*;
use serde_json::json;

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

/// Zeros, a thousand to a byte, in views that stand for the same bytes.
#[test]
fn a_little_data_does_not_fill_the_memory() {
    let count = 1 << 21;
    let zeros = vec![[0.0f32; 3]; count];
    let data = meshopt::encode_vertex_buffer(&zeros).unwrap();
    let mut doc = tetrahedron(json!({}));
    let packed = doc.view(&data);
    let at = doc.json["bufferViews"][packed]["byteOffset"].clone();
    let compressed = json!({
        "buffer": 0, "byteOffset": at, "byteLength": data.len(),
        "byteStride": 12, "count": count, "mode": "ATTRIBUTES",
    });
    for _ in 0..64 {
        let extensions = json!({"EXT_meshopt_compression": compressed});
        let view = json!({"buffer": 1, "byteLength": 12 * count, "extensions": extensions});
        let view = doc.push("bufferViews", view);
        let accessor =
            json!({"bufferView": view, "componentType": FLOAT, "type": "VEC3", "count": count});
        let position = doc.push("accessors", accessor);
        let primitives = doc.json["meshes"][0]["primitives"].as_array_mut().unwrap();
        primitives.push(json!({"attributes": {"POSITION": position}, "indices": 1}));
    }
    doc.push("buffers", json!({"byteLength": 1}));
    let message = doc.refused();
    assert_says(
        &message,
        &["bufferView", "may still unfold to", "without EXT_meshopt"],
    );
}
