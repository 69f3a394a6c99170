//! glTF: what is refused, where, and with which cure.

use super::gltf_doc::*;
use super::*;
use serde_json::{Value, json};

#[test]
fn errors_name_the_node_the_primitive_and_the_accessor() {
    type Break = fn(&mut Value);
    let cases: [(Break, &[&str]); 23] = [
        (
            |j| j["accessors"][0]["count"] = json!(-4),
            &["expected a whole number that is not negative"],
        ),
        (
            |j| j["accessors"] = json!({}),
            &["invalid type: object, expected an array"],
        ),
        (
            |j| j["meshes"][0] = json!(3),
            &["integer `3`, expected an object"],
        ),
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
            |j| j["scenes"] = json!([{"nodes": [0, 0]}]),
            &["node 0", "the scene names it twice"],
        ),
        (
            |j| {
                j["nodes"] = json!([{"children": [1]}, {}]);
                j["scenes"] = json!([{"nodes": [0, 1]}]);
            },
            &["node 1", "child of a node too"],
        ),
        (
            |j| {
                let view = json!({"bufferView": 0, "componentType": U16});
                j["accessors"][0]["sparse"] = json!({"count": 5, "indices": view, "values": view});
            },
            &["accessor 0", "5 sparse elements, of 4"],
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
            &["node 0", "its rotation", "no length"],
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

/// A kilobyte that names a million instances of nothing, or the same zeros, again and again.
#[test]
fn what_takes_no_bytes_of_a_file_takes_no_hours() {
    let zeros = json!({"componentType": FLOAT, "type": "VEC3", "count": 1 << 20});
    let mut doc = tetrahedron(json!({}));
    let many = doc.push("accessors", zeros.clone());
    let none = doc.push(
        "accessors",
        json!({"componentType": FLOAT, "type": "VEC3", "count": 0}),
    );
    let primitive = json!({"attributes": {"POSITION": none}});
    doc.push("meshes", json!({"primitives": vec![primitive; 200]}));
    let extension = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": many}}});
    doc.push("nodes", json!({"mesh": 1, "extensions": extension}));
    assert_says(&doc.refused(), &["node 1", "33 million", "export only"]);
    // Normals of triangles, in as many primitives.
    let mut doc = tetrahedron(json!({}));
    let many = doc.push("accessors", zeros);
    let mut primitive = doc.json["meshes"][0]["primitives"][0].clone();
    primitive["attributes"]["JOINTS_0"] = json!(many);
    primitive["attributes"]["WEIGHTS_0"] = json!(many);
    doc.json["accessors"][many]["type"] = json!("VEC4");
    // Each with another position accessor, so that none shares its pose.
    let primitives: Vec<Value> = (0..400)
        .map(|_| {
            let position = doc.json["accessors"][0].clone();
            primitive["attributes"]["POSITION"] = json!(doc.push("accessors", position));
            primitive.clone()
        })
        .collect();
    doc.json["meshes"][0]["primitives"] = json!(primitives);
    doc.json["nodes"][0]["skin"] = json!(0);
    doc.json["skins"] = json!([{"joints": [0]}]);
    assert_says(&doc.refused(), &["again and again", "accessor 2"]);
}

#[test]
fn a_json_chunk_may_be_padded_with_zeros_and_extensions_may_be_null() {
    let mut doc = tetrahedron(json!({"extensions": null}));
    doc.json["meshes"][0]["primitives"][0]["extensions"] = json!(null);
    doc.json["bufferViews"][0]["extensions"] = json!(null);
    let mut whole = doc.glb();
    let end = 20 + u32::from_le_bytes(whole[12..16].try_into().unwrap()) as usize;
    let text = whole[20..end].trim_ascii_end().len();
    whole[20 + text..end].fill(0);
    whole.splice(end..end, [0; 4]);
    whole[12..16].copy_from_slice(&(end as u32 - 16).to_le_bytes());
    let length = whole.len() as u32;
    whole[8..12].copy_from_slice(&length.to_le_bytes());
    let loaded = parse_soup(&whole, Format::Glb, None).unwrap();
    assert_eq!(volume(&loaded.soup), 1.0);
}
