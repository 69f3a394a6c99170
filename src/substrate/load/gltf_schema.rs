//! The part of a glTF 2.0 document that decides where its triangles are.
//!
//! A schema of our own and not that of `gltf` 1.4.1: it keeps node transforms as `f32` (half a
//! metre lost at geocentric offsets), panics on an out-of-range `POSITION` accessor, fails on faults
//! in parts that do not concern us (animations), refuses a scene without `nodes` (which the
//! specification allows), cuts indices to 32 bits (mesh 2³² is read as mesh 0), and forgets the
//! number of an unknown mode or component type, which our messages name. Its container reader
//! panics on a length below the header's and refuses unknown chunks after the JSON. What is not named
//! here is not looked at. All indices are unchecked.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer};

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Root<'a> {
    #[serde(borrow)]
    pub(super) asset: Asset<'a>,
    #[serde(default)]
    pub(super) accessors: Vec<Accessor<'a>>,
    #[serde(default, borrow)]
    pub(super) buffers: Vec<Buffer<'a>>,
    #[serde(default)]
    pub(super) buffer_views: Vec<BufferView<'a>>,
    #[serde(default)]
    pub(super) meshes: Vec<Mesh<'a>>,
    #[serde(default)]
    pub(super) nodes: Vec<Node<'a>>,
    #[serde(default)]
    pub(super) scenes: Vec<Scene>,
    #[serde(default)]
    pub(super) skins: Vec<Skin>,
    pub(super) scene: Option<usize>,
    #[serde(default)]
    pub(super) extensions_required: Vec<String>,
}

/// Read alone when the whole document cannot be: another version has another schema.
#[derive(Deserialize)]
pub(super) struct OnlyAsset {
    pub(super) asset: OnlyVersion,
}

#[derive(Deserialize)]
pub(super) struct OnlyVersion {
    /// A number in some files of version 1.
    pub(super) version: serde_json::Value,
}

#[derive(Deserialize)]
pub(super) struct Asset<'a> {
    #[serde(borrow)]
    pub(super) version: Cow<'a, str>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor<'a> {
    pub(super) buffer_view: Option<usize>,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) component_type: u32,
    #[serde(default)]
    pub(super) normalized: bool,
    pub(super) count: usize,
    #[serde(rename = "type", borrow)]
    pub(super) lanes: Cow<'a, str>,
    pub(super) sparse: Option<Sparse>,
}

#[derive(Deserialize)]
pub(super) struct Sparse {
    pub(super) count: usize,
    pub(super) indices: SparseIndices,
    pub(super) values: SparseValues,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseIndices {
    pub(super) buffer_view: usize,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) component_type: u32,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseValues {
    pub(super) buffer_view: usize,
    #[serde(default)]
    pub(super) byte_offset: usize,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer<'a> {
    #[serde(borrow)]
    pub(super) uri: Option<Uri<'a>>,
    pub(super) byte_length: usize,
}

/// A URI that stays where it is: serde would copy an `Option<Cow>`, and data URIs are large.
#[derive(Deserialize)]
pub(super) struct Uri<'a>(#[serde(borrow)] pub(super) Cow<'a, str>);

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView<'a> {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) byte_length: usize,
    pub(super) byte_stride: Option<usize>,
    #[serde(default, borrow, deserialize_with = "or_absent")]
    pub(super) extensions: ViewExtensions<'a>,
}

#[derive(Default, Deserialize)]
pub(super) struct ViewExtensions<'a> {
    #[serde(rename = "EXT_meshopt_compression", borrow)]
    pub(super) ext_meshopt: Option<Compressed<'a>>,
    #[serde(rename = "KHR_meshopt_compression", borrow)]
    pub(super) khr_meshopt: Option<Compressed<'a>>,
}

/// `EXT_meshopt_compression` on a buffer view.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Compressed<'a> {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) byte_length: usize,
    pub(super) byte_stride: usize,
    pub(super) count: usize,
    #[serde(borrow)]
    pub(super) mode: Cow<'a, str>,
    #[serde(default, borrow)]
    pub(super) filter: Option<Cow<'a, str>>,
}

#[derive(Deserialize)]
pub(super) struct Mesh<'a> {
    #[serde(borrow)]
    pub(super) primitives: Vec<Primitive<'a>>,
    pub(super) weights: Option<Vec<f64>>,
}

#[derive(Deserialize)]
pub(super) struct Primitive<'a> {
    #[serde(borrow)]
    pub(super) attributes: BTreeMap<Cow<'a, str>, usize>,
    pub(super) indices: Option<usize>,
    #[serde(default = "triangles")]
    pub(super) mode: u32,
    #[serde(default, borrow, deserialize_with = "or_absent")]
    pub(super) targets: Vec<BTreeMap<Cow<'a, str>, usize>>,
    #[serde(default, deserialize_with = "or_absent")]
    pub(super) extensions: PrimitiveExtensions,
}

/// Some programs write `null` for what is not there.
pub(super) fn or_absent<'de, D, T>(deserializer: D) -> Result<T, D::Error>
where
    D: Deserializer<'de>,
    T: Default + Deserialize<'de>,
{
    Option::deserialize(deserializer).map(Option::unwrap_or_default)
}

fn triangles() -> u32 {
    4
}

#[derive(Default, Deserialize)]
pub(super) struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub(super) draco: Option<serde::de::IgnoredAny>,
}

#[derive(Deserialize)]
pub(super) struct Node<'a> {
    #[serde(default)]
    pub(super) children: Vec<usize>,
    pub(super) mesh: Option<usize>,
    pub(super) skin: Option<usize>,
    pub(super) weights: Option<Vec<f64>>,
    pub(super) matrix: Option<[f64; 16]>,
    pub(super) translation: Option<[f64; 3]>,
    pub(super) rotation: Option<[f64; 4]>,
    pub(super) scale: Option<[f64; 3]>,
    #[serde(default, borrow, deserialize_with = "or_absent")]
    pub(super) extensions: NodeExtensions<'a>,
}

#[derive(Default, Deserialize)]
pub(super) struct NodeExtensions<'a> {
    #[serde(rename = "EXT_mesh_gpu_instancing", borrow)]
    pub(super) instancing: Option<Instancing<'a>>,
    #[serde(
        default,
        rename = "KHR_node_visibility",
        deserialize_with = "or_absent"
    )]
    pub(super) visibility: Option<Visibility>,
}

#[derive(Deserialize)]
pub(super) struct Visibility {
    #[serde(default = "yes")]
    pub(super) visible: bool,
}

fn yes() -> bool {
    true
}

#[derive(Deserialize)]
pub(super) struct Instancing<'a> {
    #[serde(borrow)]
    pub(super) attributes: BTreeMap<Cow<'a, str>, usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Skin {
    pub(super) inverse_bind_matrices: Option<usize>,
    #[serde(default)]
    pub(super) joints: Vec<usize>,
}

#[derive(Deserialize)]
pub(super) struct Scene {
    #[serde(default)]
    pub(super) nodes: Vec<usize>,
}
