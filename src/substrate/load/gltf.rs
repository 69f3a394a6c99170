//! glTF 2.0: the scene's nodes, their transforms, and the GLB container.
//!
//! Read is what the default scene shows (without one, the first; without any, all root nodes).
//! Transforms are composed in `f64`; the world positions are then rounded to `f32`, so that points
//! which several instances share stay equal to the bit. Far from the origin they are rounded
//! relative to the middle of the scene, so that geocentric offsets cost nothing. Skinned meshes are
//! read in the pose that their joints have (`gltf_skin.rs`), morphed ones by their weights (`gltf_morph.rs`). Cameras
//! and animations are not looked at, materials only where textures are asked for (`gltf_material.rs`), nor are
//! extensions that concern only them.

use std::path::Path;

use glam::{DAffine3, DMat3, DQuat, DVec3};
use serde_json::Value;

use crate::input::{quoted, without_mark};
use crate::substrate::texturing::Of;
use crate::substrate::{Soup, Texturing};

use super::error::{LoadFault, Parsed};
use super::gltf_accessor::Accessors;
use super::gltf_buffers::{Buffers, EXPORT_AGAIN};
use super::gltf_material::Looks;
use super::gltf_morph::Morphs;
use super::gltf_primitive::{Collector, Placing, SharedPositions, Tally};
use super::gltf_schema::{Instancing, Node, OnlyAsset, Root};
use super::gltf_skin::Pose;
use super::{Format, counted, no_triangles};

/// Extensions that change the geometry and are understood (or refused where they are used).
const UNDERSTOOD: [&str; 6] = [
    "KHR_mesh_quantization",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "EXT_mesh_gpu_instancing",
    "KHR_draco_mesh_compression",
    "KHR_node_visibility",
];

/// How far from the origin, in sizes of the scene, before rounding is relative to its middle.
const FAR: f64 = 8.0;

const GLB_HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;
const JSON_CHUNK: &[u8] = b"JSON";
const BIN_CHUNK: &[u8] = b"BIN\0";

/// Reads the JSON form.
pub(super) fn parse_gltf(
    json: &[u8],
    base: Option<&Path>,
    hasher: &mut blake3::Hasher,
    texturing: Option<&mut Texturing>,
) -> Parsed<Soup> {
    parse_document(json, None, Format::Gltf, base, hasher, texturing)
}

/// Reads the binary container.
pub(super) fn parse_glb(
    bytes: &[u8],
    base: Option<&Path>,
    hasher: &mut blake3::Hasher,
    texturing: Option<&mut Texturing>,
) -> Parsed<Soup> {
    let (json, chunk) = open_container(bytes)?;
    parse_document(json, chunk, Format::Glb, base, hasher, texturing)
}

/// The JSON of a GLB file, if that is one.
pub(super) fn json_of(glb: &[u8]) -> Option<&[u8]> {
    open_container(glb).ok().map(|(json, _)| json)
}

/// The JSON and the binary chunk of a GLB file.
fn open_container(bytes: &[u8]) -> Parsed<(&[u8], Option<&[u8]>)> {
    let fault = |at: usize, problem: String, cure: &str| {
        Err(LoadFault::malformed(
            Format::Glb,
            format!("byte {at}"),
            problem,
            cure,
        ))
    };
    if !bytes.starts_with(b"glTF") {
        return fault(0, "it does not begin with 'glTF'".into(), EXPORT_AGAIN);
    }
    let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
        return fault(
            bytes.len(),
            "the file ends within its header".into(),
            EXPORT_AGAIN,
        );
    };
    if version != 2 {
        let cure = "export it as glTF 2.0";
        return fault(4, format!("GLB container version {version}, not 2"), cure);
    }
    if length > bytes.len() {
        let problem = format!("{length} bytes are promised, {} are there", bytes.len());
        return fault(8, problem, "it was cut short: export or copy it again");
    }
    let mut chunks = Chunks {
        bytes: &bytes[..length.max(GLB_HEADER)],
        at: GLB_HEADER,
    };
    let Some((kind, json)) = chunks.next().transpose()? else {
        return fault(GLB_HEADER, "there is no JSON chunk".into(), EXPORT_AGAIN);
    };
    if kind != JSON_CHUNK {
        let problem = format!("the first chunk is {}, not JSON", quoted(kind));
        return fault(GLB_HEADER, problem, EXPORT_AGAIN);
    }
    // Against the specification some pad it as they do the other.
    let json = &json[..json
        .iter()
        .rposition(|&b| b != 0)
        .map_or(0, |last| last + 1)];
    for chunk in chunks {
        if let (BIN_CHUNK, data) = chunk? {
            return Ok((json, Some(data)));
        }
    }
    Ok((json, None))
}

/// The chunks of a GLB file: kind and data.
struct Chunks<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Iterator for Chunks<'a> {
    type Item = Parsed<(&'a [u8], &'a [u8])>;

    fn next(&mut self) -> Option<Self::Item> {
        let start = self.at;
        if start >= self.bytes.len() {
            return None;
        }
        let data_at = start + CHUNK_HEADER;
        let end = word(self.bytes, start)
            .and_then(|length| data_at.checked_add(length))
            .filter(|&end| end <= self.bytes.len());
        let Some(end) = end else {
            self.at = self.bytes.len();
            return Some(Err(LoadFault::malformed(
                Format::Glb,
                format!("byte {start}"),
                "a chunk reaches beyond the end of the file",
                "it was cut short: export or copy it again",
            )));
        };
        self.at = end;
        Some(Ok((
            &self.bytes[start + 4..data_at],
            &self.bytes[data_at..end],
        )))
    }
}

fn word(bytes: &[u8], at: usize) -> Option<usize> {
    let raw = bytes.get(at..at.checked_add(4)?)?.try_into().ok()?;
    usize::try_from(u32::from_le_bytes(raw)).ok()
}

fn parse_document(
    json: &[u8],
    chunk: Option<&[u8]>,
    format: Format,
    base: Option<&Path>,
    hasher: &mut blake3::Hasher,
    texturing: Option<&mut Texturing>,
) -> Parsed<Soup> {
    let json = without_mark(json);
    let plain;
    let (json, root) = match read_json(json, format) {
        Ok(root) => (json, root),
        Err(fault) => {
            plain = with_plain_numbers(json).unwrap_or_default();
            // Where that does not help, the fault is told as it is in the file.
            (&plain[..], read_json(&plain, format).map_err(|_| fault)?)
        }
    };
    let buffers = Buffers::new(&root, format, chunk, base);
    let accessors = Accessors::new(&root, buffers, format);
    let looks = texturing.is_some().then(|| Looks::read(json));
    let mut scene = SceneWalk {
        root: &root,
        looks: looks.as_ref(),
        parents: Vec::new(),
        collector: Collector::new(accessors, looks.is_some()),
    };
    scene.walk()?;
    scene.collector.accessors.buffers.hash_external(hasher);
    if let (Some(out), Some(looks)) = (texturing, &looks) {
        *out = scene.collector.texturing.take().unwrap_or_default();
        looks.materials_into(out, &scene.collector.accessors.buffers);
    }
    finish(scene)
}

fn read_json(json: &[u8], format: Format) -> Parsed<Root<'_>> {
    match serde_json::from_slice::<Root>(json) {
        Ok(root) => check_version(&root.asset.version, format).map(|()| root),
        Err(error) => {
            if let Ok(only) = serde_json::from_slice::<OnlyAsset>(json) {
                let version = only.asset.version;
                let text = version
                    .as_str()
                    .map_or_else(|| version.to_string(), str::to_owned);
                check_version(&text, format)?;
            }
            let place = format!("JSON line {}, column {}", error.line(), error.column());
            let text = error.to_string();
            let problem = in_words(text.split(" at line ").next().unwrap_or_default());
            let cure = "correct it or export the file again";
            Err(LoadFault::malformed(format, place, problem, cure))
        }
    }
}

/// What serde says of a document, without the names that things have in this program.
fn in_words(problem: &str) -> String {
    let Some((found, expected)) = problem.split_once(", expected ") else {
        return problem.to_owned();
    };
    let expected = match expected {
        "u32" | "u64" | "usize" => "a whole number that is not negative",
        "f32" | "f64" => "a number",
        "a map" => "an object",
        "a sequence" => "an array",
        name if name.starts_with("struct ") => "an object",
        other => other,
    };
    let found = found.replace("type: map", "type: object");
    format!(
        "{}, expected {expected}",
        found.replace("type: sequence", "type: array")
    )
}

/// The document with whole numbers written as such, and the last of members with one name alone: glTF allows
/// `12.0` and `1.2e1` for integers, and lets the last of such members win.
fn with_plain_numbers(json: &[u8]) -> Option<Vec<u8>> {
    let mut document: Value = serde_json::from_slice(json).ok()?;
    plain(&mut document);
    serde_json::to_vec(&document).ok()
}

fn plain(value: &mut Value) {
    match value {
        Value::Array(values) => values.iter_mut().for_each(plain),
        Value::Object(members) => members.values_mut().for_each(plain),
        Value::Number(number) => {
            let whole = number
                .as_f64()
                .filter(|x| x.fract() == 0.0 && x.abs() < MOST_WHOLE);
            if let Some(whole) = whole.filter(|_| number.is_f64()) {
                *value = Value::from(whole as i64);
            }
        }
        _ => {}
    }
}

/// Whole numbers below this are exact as f64.
const MOST_WHOLE: f64 = (1u64 << 53) as f64;

fn check_version(version: &str, format: Format) -> Parsed<()> {
    // Against the specification some write no point.
    if version == "2" || version.starts_with("2.") {
        return Ok(());
    }
    let problem = format!("glTF version {}, not 2", quoted(version.as_bytes()));
    Err(LoadFault::malformed(
        format,
        "asset",
        problem,
        "export it as glTF 2.0",
    ))
}

fn finish(mut scene: SceneWalk) -> Parsed<Soup> {
    scene.collector.refuse_endless()?;
    let unseen = scene.root.meshes.len();
    let Collector {
        mut soup,
        passed_over,
        ..
    } = scene.collector;
    let mut ignored = passed_over.ignored();
    if soup.triangles.is_empty() {
        if ignored.is_empty() && soup.positions.is_empty() && unseen > 0 {
            ignored.push(counted(
                unseen,
                "mesh that no node shows",
                "meshes that no node shows",
            ));
        }
        return Err(no_triangles(soup.positions.len(), &ignored));
    }
    let ignored = ignored.into_iter().map(|what| format!("{what} ignored"));
    soup.notes.extend(ignored);
    soup.notes.extend(passed_over.at_rest());
    soup.notes
        .extend(scene.root.extensions_required.iter().filter_map(|name| {
            let only_looks = ["KHR_materials_", "KHR_texture_", "EXT_texture_"];
            let known = UNDERSTOOD.contains(&name.as_str())
                || only_looks.iter().any(|family| name.starts_with(family));
            let shown = quoted(name.as_bytes());
            (!known)
                .then(|| format!("the file requires the extension {shown}, which was not applied"))
        }));
    if scene.root.scenes.len() > 1 {
        soup.notes
            .push(format!("one of {} scenes read", scene.root.scenes.len()));
    }
    round_to_single(&mut soup);
    Ok(soup)
}

impl Tally {
    fn ignored(&self) -> Vec<String> {
        met([
            (
                self.hidden,
                "mesh of a hidden node (KHR_node_visibility)",
                "meshes of hidden nodes (KHR_node_visibility)",
            ),
            (self.points, "point primitive", "point primitives"),
            (self.lines, "line primitive", "line primitives"),
            (
                self.without_positions,
                "primitive without positions",
                "primitives without positions",
            ),
            (
                self.leftover_indices,
                "index beyond the triangles",
                "indices beyond the triangles",
            ),
        ])
    }

    fn at_rest(&self) -> Vec<String> {
        let posed = met([
            (self.posed, "skinned mesh", "skinned meshes"),
            (self.morphed, "morphed primitive", "morphed primitives"),
        ]);
        let at_rest = met([
            (self.skinned, "skinned mesh", "skinned meshes"),
            (
                self.unmorphed,
                "primitive with morph targets",
                "primitives with morph targets",
            ),
        ]);
        let posed = posed.into_iter().map(|what| what + " read as posed");
        posed
            .chain(at_rest.into_iter().map(|what| what + " read at rest"))
            .collect()
    }
}

/// The counts that are not zero, with their nouns.
fn met<const N: usize>(counts: [(usize, &str, &str); N]) -> Vec<String> {
    let met = counts.into_iter().filter(|(count, ..)| *count > 0);
    met.map(|(count, one, many)| counted(count, one, many))
        .collect()
}

/// Rounds to `f32`, relative to the origin or, when that is far away, to the scene's middle. Vertices that no triangle
/// uses may be anywhere, and do not say where that is.
fn round_to_single(soup: &mut Soup) {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for &corner in soup.triangles.as_flattened() {
        let position = soup.positions[corner as usize];
        for axis in 0..3 {
            low[axis] = low[axis].min(position[axis]);
            high[axis] = high[axis].max(position[axis]);
        }
    }
    let size = (0..3)
        .map(|axis| high[axis] - low[axis])
        .fold(0.0, f64::max);
    let middle: [f64; 3] = std::array::from_fn(|axis| {
        let middle = 0.5 * low[axis] + 0.5 * high[axis];
        if middle.abs() > FAR * size {
            f64::from(middle as f32)
        } else {
            0.0
        }
    });
    for coordinate in soup
        .positions
        .iter_mut()
        .flat_map(|p| p.iter_mut().zip(middle))
    {
        let (at, middle) = coordinate;
        let rounded = f64::from((*at - middle) as f32) + middle;
        // As far apart as numbers go, which only an unused vertex can be.
        *at = if rounded.is_finite() { rounded } else { middle };
    }
}

/// The walk down the node hierarchy.
struct SceneWalk<'a> {
    root: &'a Root<'a>,
    /// Materials, where textures are asked for.
    looks: Option<&'a Looks>,
    /// Of each node the one that it is a child of.
    parents: Vec<Option<usize>>,
    collector: Collector<'a>,
}

/// Nodes above a node whose names choose it too.
const MOST_ABOVE: usize = 32;

impl<'a> SceneWalk<'a> {
    fn walk(&mut self) -> Parsed<()> {
        let placed = self.placed()?;
        self.parents = vec![None; self.root.nodes.len()];
        for &(index, ..) in &placed {
            let children = self.root.nodes[index].children.iter();
            children.for_each(|&child| self.parents[child] = Some(index));
        }
        let mut worlds = vec![None; self.root.nodes.len()];
        for &(index, world, _) in &placed {
            worlds[index] = Some(world);
        }
        let nodes = &self.root.nodes;
        for (index, world, is_hidden) in placed {
            match is_hidden {
                true => {
                    self.collector.passed_over.hidden += usize::from(nodes[index].mesh.is_some());
                }
                false => self.node(index, &nodes[index], world, &worlds)?,
            }
        }
        Ok(())
    }

    /// The nodes of the scene, parents first, the transform of each, and whether it or one above it is hidden.
    fn placed(&self) -> Parsed<Vec<(usize, DAffine3, bool)>> {
        let mut placed = Vec::new();
        let mut met = vec![false; self.root.nodes.len()];
        let roots = self.root_nodes()?;
        let roots = || roots.iter().rev().copied();
        let root = |node| (node, DAffine3::IDENTITY, false);
        let mut pending: Vec<_> = roots().map(root).collect();
        while let Some((index, parent, is_below_hidden)) = pending.pop() {
            let Some(node) = self.root.nodes.get(index) else {
                let problem = format!("there is no such node, the file has {}", met.len());
                return Err(self.fault(format!("node {index}"), problem));
            };
            if std::mem::replace(&mut met[index], true) {
                let problem = match roots().filter(|&root| root == index).count() {
                    0 => "it is its own ancestor, or the child of two nodes",
                    1 => "the scene names it, and it is the child of a node too",
                    _ => "the scene names it twice",
                };
                return Err(self.fault(format!("node {index}"), problem.into()));
            }
            let world = parent * self.local_transform(index, node)?;
            let visibility = node.extensions.visibility.as_ref();
            let is_hidden = is_below_hidden || visibility.is_some_and(|said| !said.visible);
            placed.push((index, world, is_hidden));
            let children = node.children.iter().rev();
            pending.extend(children.map(|&child| (child, world, is_hidden)));
        }
        Ok(placed)
    }

    fn root_nodes(&self) -> Parsed<Vec<usize>> {
        let root = self.root;
        if let Some(index) = root
            .scene
            .or_else(|| (!root.scenes.is_empty()).then_some(0))
        {
            let scene = root.scenes.get(index).ok_or_else(|| {
                let problem = format!("there is no such scene, the file has {}", root.scenes.len());
                self.fault(format!("scene {index}"), problem)
            })?;
            return Ok(scene.nodes.clone());
        }
        let mut is_child = vec![false; root.nodes.len()];
        for &child in root.nodes.iter().flat_map(|node| &node.children) {
            if let Some(mark) = is_child.get_mut(child) {
                *mark = true;
            }
        }
        let roots: Vec<usize> = (0..root.nodes.len())
            .filter(|&node| !is_child[node])
            .collect();
        if roots.is_empty() && !root.nodes.is_empty() {
            return Err(self.fault("nodes".into(), "they form a cycle".into()));
        }
        Ok(roots)
    }

    fn node(
        &mut self,
        index: usize,
        node: &Node,
        world: DAffine3,
        worlds: &[Option<DAffine3>],
    ) -> Parsed<()> {
        let Some(mesh_index) = node.mesh else {
            return Ok(());
        };
        let Some(mesh) = self.root.meshes.get(mesh_index) else {
            return Err(self.fault(
                format!("node {index}"),
                format!("there is no mesh {mesh_index}"),
            ));
        };
        let placing = Placing {
            morphs: Morphs::of(node, mesh),
            pose: self.pose(index, node, worlds)?,
            transforms: match &node.extensions.instancing {
                None => vec![world],
                Some(instancing) => self.instances(index, instancing, world)?,
            },
        };
        let tally = &mut self.collector.passed_over;
        tally.posed += usize::from(placing.pose.is_some());
        tally.skinned += usize::from(node.skin.is_some() && placing.pose.is_none());
        let place = format!("node {index}");
        self.collector.charge(placing.transforms.len(), &place)?;
        let mut shared = SharedPositions::default();
        for (number, primitive) in mesh.primitives.iter().enumerate() {
            let place = format!("node {index}, mesh {mesh_index}, primitive {number}");
            self.looks_of((index, world), mesh_index, number);
            self.collector
                .primitive(primitive, &place, &placing, &mut shared)?;
        }
        Ok(())
    }

    /// Takes note of what a node's primitive looks like and is called.
    fn looks_of(&mut self, node: (usize, DAffine3), mesh: usize, primitive: usize) {
        let Some(looks) = self.looks else {
            return;
        };
        let material = looks.material_of(mesh, primitive);
        let above = |&node: &usize| self.parents[node];
        let line = std::iter::successors(Some(node.0), above).take(1 + MOST_ABOVE);
        let part = looks.part_of((line, node.1), mesh, material);
        let texturing = self.collector.texturing.as_mut();
        self.collector.of = Of {
            material,
            part: texturing.zip(part).map(|(all, part)| all.add_part(part)),
        };
    }

    /// The pose of a node's skin, if it has one whose joints are all in the scene.
    fn pose(&self, index: usize, node: &Node, worlds: &[Option<DAffine3>]) -> Parsed<Option<Pose>> {
        let (Some(number), None) = (node.skin, &node.extensions.instancing) else {
            return Ok(None);
        };
        let Some(skin) = self.root.skins.get(number) else {
            return Ok(None);
        };
        let place = format!("node {index}, skin {number}");
        Pose::new(skin, worlds, &self.collector.accessors, &place)
    }

    /// The world transforms of a node's `EXT_mesh_gpu_instancing` copies.
    fn instances(
        &self,
        index: usize,
        instancing: &Instancing,
        world: DAffine3,
    ) -> Parsed<Vec<DAffine3>> {
        let place = format!("node {index}, EXT_mesh_gpu_instancing");
        let translations = self.instance_vectors::<3>(instancing, "TRANSLATION", &place)?;
        let rotations = self.instance_vectors::<4>(instancing, "ROTATION", &place)?;
        let scales = self.instance_vectors::<3>(instancing, "SCALE", &place)?;
        let counts = [
            translations.as_ref().map(Vec::len),
            rotations.as_ref().map(Vec::len),
            scales.as_ref().map(Vec::len),
        ];
        let count = counts.into_iter().flatten().next().unwrap_or(0);
        if count == 0 || counts.into_iter().flatten().any(|other| other != count) {
            let problem = "its attributes are missing or differ in count";
            return Err(self.fault(place, problem.into()));
        }
        (0..count)
            .map(|i| {
                let local = compose(
                    translations.as_ref().map(|all| all[i]),
                    rotations.as_ref().map(|all| all[i]),
                    scales.as_ref().map(|all| all[i]),
                );
                let place = || format!("{place}, instance {i}");
                self.usable(local.map(|local| world * local), place)
            })
            .collect()
    }

    fn instance_vectors<const N: usize>(
        &self,
        instancing: &Instancing,
        name: &str,
        place: &str,
    ) -> Parsed<Option<Vec<[f64; N]>>> {
        let Some(&accessor) = instancing.attributes.get(name) else {
            return Ok(None);
        };
        self.collector.accessors.vectors(accessor, place).map(Some)
    }

    fn local_transform(&self, index: usize, node: &Node) -> Parsed<DAffine3> {
        let local = match &node.matrix {
            Some(matrix) if matrix.iter().all(|x| x.is_finite()) => {
                let skewed = || {
                    let problem = "the last row of its matrix is not 0 0 0 1: it is not affine";
                    self.fault(format!("node {index}"), problem.into())
                };
                return affine(matrix).ok_or_else(skewed);
            }
            Some(_) => Err(NOT_FINITE),
            None => compose(node.translation, node.rotation, node.scale),
        };
        self.usable(local, || format!("node {index}"))
    }

    fn usable(
        &self,
        transform: Result<DAffine3, &str>,
        place: impl Fn() -> String,
    ) -> Parsed<DAffine3> {
        match transform {
            Ok(transform) if transform.is_finite() => Ok(transform),
            Ok(_) => Err(self.fault(place(), NOT_FINITE.into())),
            Err(problem) => Err(self.fault(place(), problem.into())),
        }
    }

    fn fault(&self, place: String, problem: String) -> LoadFault {
        LoadFault::malformed(
            self.collector.accessors.format,
            place,
            problem,
            EXPORT_AGAIN,
        )
    }
}

const NOT_FINITE: &str = "its transform is not finite";

/// A column-major matrix, if it keeps parallels parallel, but for the round-off of programs that multiply
/// matrices.
pub(super) fn affine(matrix: &[f64; 16]) -> Option<DAffine3> {
    const ROUND_OFF: f64 = 1e-6;
    let [a, b, c, d, e, f, g, h, i, j, k, l, x, y, z, w] = *matrix;
    let off = [d, h, l, w - 1.0].map(f64::abs);
    off.iter().all(|&x| x <= ROUND_OFF).then(|| DAffine3 {
        matrix3: DMat3::from_cols(
            DVec3::new(a, b, c) / w,
            DVec3::new(e, f, g) / w,
            DVec3::new(i, j, k) / w,
        ),
        translation: DVec3::new(x, y, z) / w,
    })
}

/// Translation × rotation × scale. Quaternions are normalized, as exporters round them; a zero one
/// has no meaning.
fn compose(
    translation: Option<[f64; 3]>,
    rotation: Option<[f64; 4]>,
    scale: Option<[f64; 3]>,
) -> Result<DAffine3, &'static str> {
    let turn = match rotation {
        None => DMat3::IDENTITY,
        Some(q) => {
            let length_sq = q.iter().map(|x| x * x).sum::<f64>();
            if length_sq == 0.0 {
                return Err("its rotation, a quaternion, has no length");
            }
            if !length_sq.is_finite() {
                return Err(NOT_FINITE);
            }
            DMat3::from_quat(DQuat::from_array(q.map(|x| x / length_sq.sqrt())))
        }
    };
    let [sx, sy, sz] = scale.unwrap_or([1.0; 3]);
    let matrix3 = DMat3::from_cols(turn.x_axis * sx, turn.y_axis * sy, turn.z_axis * sz);
    Ok(DAffine3 {
        matrix3,
        translation: DVec3::from_array(translation.unwrap_or([0.0; 3])),
    })
}
