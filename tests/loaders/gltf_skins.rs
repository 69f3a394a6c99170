//! Skinned meshes: where their joints take them, whatever the node that shows them says.

use serde_json::{Value, json};
use thallus::substrate::Soup;

use crate::gltf_doc::{Doc, FLOAT, U8, floats};

const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// A triangle whose vertices hang on joints by weights, shown by a node that moves it far away.
fn skinned(joints: [[u8; 4]; 3], weights: [[f32; 4]; 3], skin: Value) -> Doc {
    let mut doc = Doc::new();
    let position = doc.positions(&CORNERS);
    let joints = doc.accessor(joints.as_flattened(), U8, "VEC4", 3);
    let weights: Vec<u8> = weights
        .as_flattened()
        .iter()
        .flat_map(|w| w.to_le_bytes())
        .collect();
    let weights = doc.accessor(&weights, FLOAT, "VEC4", 3);
    let attributes = json!({"POSITION": position, "JOINTS_0": joints, "WEIGHTS_0": weights});
    doc.show(
        json!({"attributes": attributes}),
        json!({"skin": 0, "translation": [100, 0, 0], "scale": [0.01, 0.01, 0.01]}),
    );
    doc.json["skins"] = json!([skin]);
    doc
}

/// A matrix that moves and scales, column by column.
fn matrix(translation: [f32; 3], scale: f32) -> [f32; 16] {
    let [x, y, z] = translation;
    let s = scale;
    [
        s, 0.0, 0.0, 0.0, 0.0, s, 0.0, 0.0, 0.0, 0.0, s, 0.0, x, y, z, 1.0,
    ]
}

fn with_bind_matrices(doc: &mut Doc, matrices: &[[f32; 16]]) {
    let bytes: Vec<u8> = matrices
        .as_flattened()
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let accessor = doc.accessor(&bytes, FLOAT, "MAT4", matrices.len());
    doc.json["skins"][0]["inverseBindMatrices"] = json!(accessor);
}

fn assert_at(soup: &Soup, expected: [[f64; 3]; 3]) {
    for (found, expected) in soup.positions.iter().zip(expected) {
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() < 1e-6, "{:?}", soup.positions);
        }
    }
}

const ALL_ON_THE_FIRST: [[f32; 4]; 3] = [[1.0, 0.0, 0.0, 0.0]; 3];

/// The corners where a joint takes them that is 8 higher.
const LIFTED: [[f64; 3]; 3] = [[0.0, 0.0, 8.0], [1.0, 0.0, 8.0], [0.0, 1.0, 8.0]];

#[test]
fn the_node_that_shows_a_skinned_mesh_does_not_move_it() {
    let mut doc = skinned([[0; 4]; 3], ALL_ON_THE_FIRST, json!({"joints": [1]}));
    doc.push("nodes", json!({"translation": [0, 0, 5]}));
    let soup = doc.load();
    assert_at(&soup, [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]]);
    assert_eq!(soup.notes, ["1 skinned mesh read as posed"]);
}

#[test]
fn a_joint_takes_a_vertex_from_the_bound_pose_to_its_own() {
    // The armature is 1/100 and turned, as those of Mixamo arrive; the mesh was bound in it.
    let mut doc = skinned([[0; 4]; 3], ALL_ON_THE_FIRST, json!({"joints": [2]}));
    let turned = [0.0, 0.0, 0.5f64.sqrt(), 0.5f64.sqrt()];
    doc.push(
        "nodes",
        json!({"children": [2], "scale": [0.01, 0.01, 0.01], "rotation": turned}),
    );
    doc.push("nodes", json!({"translation": [100, 0, 0]}));
    with_bind_matrices(&mut doc, &[matrix([0.0, 0.0, 7.0], 100.0)]);
    // 100 times, up by 7; along x by 100; a hundredth, turned about z by a right angle.
    assert_at(
        &doc.load(),
        [[0.0, 1.0, 0.07], [0.0, 2.0, 0.07], [-1.0, 1.0, 0.07]],
    );
}

#[test]
fn vertices_between_joints_are_where_the_mean_of_these_takes_them() {
    let weights = [
        [1.0, 0.0, 0.0, 0.0],
        [0.25, 0.75, 0.0, 0.0],
        [2.0, 2.0, 0.0, 0.0],
    ];
    let mut doc = skinned([[0, 1, 9, 9]; 3], weights, json!({"joints": [1, 2]}));
    doc.push("nodes", json!({}));
    doc.push("nodes", json!({"translation": [0, 0, 8]}));
    assert_at(&doc.load(), [[0.0; 3], [1.0, 0.0, 6.0], [0.0, 1.0, 4.0]]);
}

#[test]
fn several_sets_of_joints_count() {
    let none = [[0.0; 4]; 3];
    let mut doc = skinned([[0; 4]; 3], none, json!({"joints": [1, 2]}));
    let joints = doc.accessor(&[1; 12], U8, "VEC4", 3);
    let weights = doc.accessor(&floats(&[[1.0, 0.0, 0.0]; 4]), FLOAT, "VEC4", 3);
    let attributes = &mut doc.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_1"] = json!(joints);
    attributes["WEIGHTS_1"] = json!(weights);
    doc.push("nodes", json!({}));
    doc.push("nodes", json!({"translation": [0, 0, 8]}));
    assert_at(&doc.load(), LIFTED);
}

#[test]
fn vertices_without_weights_go_with_their_first_joint() {
    let mut doc = skinned([[1; 4]; 3], [[0.0; 4]; 3], json!({"joints": [1, 2]}));
    doc.push("nodes", json!({}));
    doc.push("nodes", json!({"translation": [0, 0, 8]}));
    assert_at(&doc.load(), LIFTED);
}

#[test]
fn joints_that_turn_inside_out_turn_the_triangles() {
    let mut doc = skinned([[0; 4]; 3], ALL_ON_THE_FIRST, json!({"joints": [1]}));
    doc.push("nodes", json!({"scale": [-1, 1, 1]}));
    let soup = doc.load();
    assert_at(&soup, [[0.0; 3], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(soup.triangles, [[0, 2, 1]]);
}

#[test]
fn a_mesh_whose_joints_are_not_in_the_scene_is_read_at_rest() {
    let doc = skinned([[0; 4]; 3], ALL_ON_THE_FIRST, json!({"joints": [5]}));
    let soup = doc.load();
    assert_at(
        &soup,
        [[100.0, 0.0, 0.0], [100.01, 0.0, 0.0], [100.0, 0.01, 0.0]],
    );
    assert_eq!(soup.notes, ["1 skinned mesh read at rest"]);
}

#[test]
fn joints_and_matrices_that_are_not_there_are_named() {
    let mut doc = skinned([[3; 4]; 3], ALL_ON_THE_FIRST, json!({"joints": [1]}));
    doc.push("nodes", json!({}));
    let said = doc.refused();
    assert!(
        said.contains("vertex 0 hangs on joint 3, the skin has 1"),
        "{said}"
    );
    let mut doc = skinned([[0; 4]; 3], ALL_ON_THE_FIRST, json!({"joints": [1, 1]}));
    doc.push("nodes", json!({}));
    with_bind_matrices(&mut doc, &[matrix([0.0; 3], 1.0)]);
    let said = doc.refused();
    assert!(said.contains("skin 0: 1 matrices for 2 joints"), "{said}");
}

/// Two triangles, the second of which hangs on the second joint.
fn two_skinned() -> Doc {
    let mut doc = skinned([[0; 4]; 3], ALL_ON_THE_FIRST, json!({"joints": [1, 2]}));
    let joints = doc.accessor(&[1; 12], U8, "VEC4", 3);
    let mut other = doc.json["meshes"][0]["primitives"][0].clone();
    other["attributes"]["JOINTS_0"] = json!(joints);
    let primitives = doc.json["meshes"][0]["primitives"].as_array_mut();
    primitives.unwrap().push(other);
    doc
}

#[test]
fn a_joint_that_turns_inside_out_turns_what_hangs_on_it_alone() {
    let mut doc = two_skinned();
    doc.push("nodes", json!({"scale": [-1, 1, 1]}));
    doc.push("nodes", json!({"translation": [0, 0, 8]}));
    let soup = doc.load();
    assert_eq!(soup.triangles, [[0, 2, 1], [3, 4, 5]]);
    assert_at(&soup, [[0.0; 3], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    // The first turns nothing that hangs on the second, nor by a weight that is less than the other's.
    let weights = [[0.4, 0.6, 0.0, 0.0]; 3];
    let mut doc = skinned([[0, 1, 0, 0]; 3], weights, json!({"joints": [1, 2]}));
    doc.push("nodes", json!({"scale": [-1, 1, 1]}));
    doc.push("nodes", json!({}));
    assert_eq!(doc.load().triangles, [[0, 1, 2]]);
}

#[test]
fn primitives_that_differ_in_their_second_joints_have_each_their_pose() {
    let weights = [[0.5, 0.0, 0.0, 0.0]; 3];
    let mut doc = skinned([[0; 4]; 3], weights, json!({"joints": [1, 2]}));
    let half: Vec<u8> = [[0.5f32, 0.0, 0.0, 0.0]; 3]
        .as_flattened()
        .iter()
        .flat_map(|w| w.to_le_bytes())
        .collect();
    let half = doc.accessor(&half, FLOAT, "VEC4", 3);
    let first = doc.json["meshes"][0]["primitives"][0].clone();
    let primitives = [0, 1].map(|joint| {
        let joints = doc.accessor(&[joint; 12], U8, "VEC4", 3);
        let mut primitive = first.clone();
        primitive["attributes"]["JOINTS_1"] = json!(joints);
        primitive["attributes"]["WEIGHTS_1"] = json!(half);
        primitive
    });
    doc.json["meshes"][0]["primitives"] = json!(primitives);
    doc.push("nodes", json!({}));
    doc.push("nodes", json!({"translation": [0, 0, 8]}));
    let soup = doc.load();
    assert_eq!(soup.positions.len(), 6);
    assert_eq!([0, 3].map(|v| soup.positions[v][2]), [0.0, 4.0]);
}
