//! glTF: what is refused, where, and with which cure.

use super::gltf_doc::*;
use super::*;
use serde_json::{Value, json};

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
            &[
                "primitive 0, accessor 0, vertex 1",
                "beyond single precision",
            ],
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
    let number = br#"{"asset": {"version": 1}, "nodes": {}}"#;
    let json = parse_soup(number, Format::Gltf, None);
    assert_says(&json.unwrap_err().to_string(), &["version '1', not 2"]);
    let json = parse_soup(b"{\n\"asset\": }", Format::Gltf, None);
    assert_says(&json.unwrap_err().to_string(), &["JSON line 2, column 10"]);
}
