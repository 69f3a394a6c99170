//! Morphed meshes: as the weights that the file has make them.

use serde_json::{Value, json};

use crate::gltf_doc::{Doc, FLOAT, floats};
use crate::looks::textured;

const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// A triangle with two targets, of which the first raises its corners by 1, 2 and 3 and the second moves the last
/// by 4 along x, shown by such a node.
fn morphed(node: Value) -> Doc {
    let mut doc = Doc::new();
    let position = doc.positions(&CORNERS);
    let first = doc.positions(&[[0.0, 0.0, 1.0], [0.0, 0.0, 2.0], [0.0, 0.0, 3.0]]);
    let at = doc.view(&[2, 0, 0, 0]);
    let by = doc.view(&floats(&[[4.0, 0.0, 0.0]]));
    let sparse = json!({"count": 1, "indices": {"bufferView": at, "componentType": 5121}, "values": {"bufferView": by}});
    let second = json!({"componentType": FLOAT, "type": "VEC3", "count": 3, "sparse": sparse});
    let second = doc.push("accessors", second);
    let targets = json!([{"POSITION": first}, {"POSITION": second}]);
    doc.show(
        json!({"attributes": {"POSITION": position}, "targets": targets}),
        node,
    );
    doc
}

const MORPHED: [[f64; 3]; 3] = [[0.0, 0.0, 0.5], [1.0, 0.0, 1.0], [-8.0, 1.0, 1.5]];

#[test]
fn the_weights_of_a_mesh_move_its_vertices_before_its_node_does() {
    let mut doc = morphed(json!({"translation": [0, 0, 100]}));
    doc.json["meshes"][0]["weights"] = json!([0.5, -2]);
    let soup = doc.load();
    let placed = MORPHED.map(|[x, y, z]| [x, y, z + 100.0]);
    assert_eq!(soup.positions, placed);
    assert_eq!(soup.notes, ["1 morphed primitive read as posed"]);
}

#[test]
fn the_weights_of_a_node_count_before_those_of_its_mesh() {
    let mut doc = morphed(json!({"weights": [0.5, -2]}));
    doc.json["meshes"][0]["weights"] = json!([7, 7]);
    doc.push("nodes", json!({"mesh": 0, "weights": [0, 0]}));
    let soup = doc.load();
    assert_eq!(soup.positions[..3], MORPHED);
    let at_rest = CORNERS.map(|corner| corner.map(f64::from));
    assert_eq!(soup.positions[3..], at_rest);
    let notes = [
        "1 morphed primitive read as posed",
        "1 primitive with morph targets read at rest",
    ];
    assert_eq!(soup.notes, notes);
}

#[test]
fn primitives_that_share_places_but_no_targets_do_not_share_vertices() {
    let mut doc = morphed(json!({"weights": [1, 0]}));
    let mut rigid = doc.json["meshes"][0]["primitives"][0].clone();
    rigid["targets"] = Value::Null;
    let primitives = doc.json["meshes"][0]["primitives"].as_array_mut();
    primitives.unwrap().push(rigid);
    let soup = doc.load();
    assert_eq!(soup.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!([2, 5].map(|v| soup.positions[v][2]), [3.0, 0.0]);
}

#[test]
fn joints_move_what_is_morphed() {
    let mut doc = morphed(json!({"weights": [1, 0], "skin": 0}));
    let joints = doc.accessor(&[0; 12], 5121, "VEC4", 3);
    let weights = [[1.0, 0.0, 0.0]; 4];
    let weights = doc.accessor(&floats(&weights), FLOAT, "VEC4", 3);
    let primitive = &mut doc.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["JOINTS_0"] = json!(joints);
    primitive["attributes"]["WEIGHTS_0"] = json!(weights);
    doc.json["skins"] = json!([{"joints": [1]}]);
    doc.push("nodes", json!({"translation": [0, 0, 8]}));
    let soup = doc.load();
    assert_eq!([0, 1, 2].map(|v| soup.positions[v][2]), [9.0, 10.0, 11.0]);
}

#[test]
fn a_target_of_other_vertices_is_refused() {
    let mut doc = morphed(json!({"weights": [0, 1]}));
    let last = doc.json["accessors"].as_array().unwrap().len() - 1;
    doc.json["accessors"][last]["count"] = json!(4);
    let said = doc.refused();
    let place = "node 0, mesh 0, primitive 0, morph target 1";
    assert!(said.contains(place), "{said}");
    assert!(said.contains("it moves 4 of 3 vertices"), "{said}");
    // What has no weight is not looked at.
    doc.json["nodes"][0]["weights"] = json!([1, 0]);
    assert_eq!(doc.load().triangles.len(), 1);
}

#[test]
fn normals_go_with_what_is_morphed() {
    let mut doc = morphed(json!({"weights": [0.5, 0]}));
    let normal = doc.positions(&[[0.0, 0.0, 1.0]; 3]);
    let turn = doc.positions(&[[2.0, 0.0, -2.0]; 3]);
    let uv = doc.accessor(&[0; 24], FLOAT, "VEC2", 3);
    let primitive = &mut doc.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["NORMAL"] = json!(normal);
    primitive["attributes"]["TEXCOORD_0"] = json!(uv);
    primitive["targets"][0]["NORMAL"] = json!(turn);
    let (texturing, _) = textured(&[("a.glb", &doc.glb())]);
    let found = texturing.normals[0].unwrap();
    assert!(
        found.iter().all(|n| n.to_array() == [1.0, 0.0, 0.0]),
        "{found:?}"
    );
}
