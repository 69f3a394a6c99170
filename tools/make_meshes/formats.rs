//! Writers: from finished arrays to the bytes of a file.

use glam::DVec3;

use crate::surface::Surface;

/// Decimals of an OBJ coordinate.
const OBJ_DECIMALS: f64 = 1e6;

/// What a coordinate becomes in an OBJ file.
pub(crate) fn obj_coordinate(x: f64) -> f64 {
    (x * OBJ_DECIMALS).round() / OBJ_DECIMALS
}

/// What a coordinate becomes in a GLB or STL file.
pub(crate) fn single_coordinate(x: f64) -> f64 {
    f64::from(x as f32)
}

pub(crate) fn obj(surface: &Surface, name: &str, remark: &str) -> Vec<u8> {
    let mut text = format!("# {remark}\no {name}\n");
    for p in &surface.positions {
        let [x, y, z] = p.to_array().map(trimmed);
        text.push_str(&format!("v {x} {y} {z}\n"));
    }
    for [a, b, c] in &surface.triangles {
        text.push_str(&format!("f {} {} {}\n", a + 1, b + 1, c + 1));
    }
    text.into_bytes()
}

fn trimmed(x: f64) -> String {
    let digits = format!("{x:.6}");
    digits
        .trim_end_matches('0')
        .trim_end_matches('.')
        .to_owned()
}

/// Binary STL; its 80-byte header carries `remark`, cut to fit.
pub(crate) fn stl(surface: &Surface, remark: &str) -> Vec<u8> {
    let mut bytes: Vec<u8> = remark
        .bytes()
        .chain(std::iter::repeat(b' '))
        .take(80)
        .collect();
    bytes.extend((surface.triangles.len() as u32).to_le_bytes());
    for &triangle in &surface.triangles {
        let [a, b, c] = surface.corners(triangle);
        let normal = (b - a).cross(c - a).normalize();
        for v in [normal, a, b, c] {
            put_vector(&mut bytes, v);
        }
        bytes.extend([0, 0]);
    }
    bytes
}

fn put_vector(bytes: &mut Vec<u8>, v: DVec3) {
    bytes.extend(
        v.to_array()
            .iter()
            .flat_map(|&x| (x as f32 + 0.0).to_le_bytes()),
    );
}

/// What a GLB holds: one mesh of one primitive.
pub(crate) struct Glb<'a> {
    pub(crate) name: &'a str,
    pub(crate) remark: &'a str,
    pub(crate) surface: &'a Surface,
    pub(crate) normals: &'a [DVec3],
    pub(crate) uv: Option<&'a [[f64; 2]]>,
    /// Linear red, green, blue of the material.
    pub(crate) colour: [f64; 3],
}

/// A GLB under construction: views and accessors of the binary chunk, one for one.
#[derive(Default)]
struct Chunk {
    bytes: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;

impl Chunk {
    fn push(&mut self, data: &[u8], target: u32, accessor: &str) {
        let (view, offset, length) = (self.views.len(), self.bytes.len(), data.len());
        self.views.push(format!(
            r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{length},"target":{target}}}"#
        ));
        self.accessors
            .push(format!(r#"{{"bufferView":{view},{accessor}}}"#));
        self.bytes.extend_from_slice(data);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
    }

    fn push_vectors(&mut self, vectors: &[DVec3], extra: &str) {
        let mut data = Vec::with_capacity(vectors.len() * 12);
        vectors.iter().for_each(|&v| put_vector(&mut data, v));
        let shape = format!(
            r#""componentType":{FLOAT},"count":{},"type":"VEC3"{extra}"#,
            vectors.len()
        );
        self.push(&data, ARRAY_BUFFER, &shape);
    }

    fn push_uv(&mut self, uv: &[[f64; 2]]) {
        let data: Vec<u8> = uv
            .iter()
            .flatten()
            .flat_map(|&x| (x as f32).to_le_bytes())
            .collect();
        let shape = format!(
            r#""componentType":{FLOAT},"count":{},"type":"VEC2""#,
            uv.len()
        );
        self.push(&data, ARRAY_BUFFER, &shape);
    }

    fn push_indices(&mut self, surface: &Surface) {
        let indices = surface.triangles.iter().flatten();
        let short = surface.positions.len() < usize::from(u16::MAX);
        let data: Vec<u8> = if short {
            indices.flat_map(|&i| (i as u16).to_le_bytes()).collect()
        } else {
            indices.flat_map(|&i| i.to_le_bytes()).collect()
        };
        let kind = if short { UNSIGNED_SHORT } else { UNSIGNED_INT };
        let count = surface.triangles.len() * 3;
        let shape = format!(r#""componentType":{kind},"count":{count},"type":"SCALAR""#);
        self.push(&data, ELEMENT_ARRAY_BUFFER, &shape);
    }
}

/// Writes glTF 2.0 in its binary container.
pub(crate) fn glb(model: &Glb) -> Vec<u8> {
    let mut chunk = Chunk::default();
    let (low, high) = model.surface.bounds();
    let list = |v: DVec3| v.to_array().map(|x| (x as f32).to_string()).join(",");
    let limits = format!(r#","min":[{}],"max":[{}]"#, list(low), list(high));
    chunk.push_vectors(&model.surface.positions, &limits);
    chunk.push_vectors(model.normals, "");
    let mut attributes = r#""POSITION":0,"NORMAL":1"#.to_owned();
    if let Some(uv) = model.uv {
        attributes.push_str(r#","TEXCOORD_0":2"#);
        chunk.push_uv(uv);
    }
    chunk.push_indices(model.surface);
    container(&document(model, &chunk, &attributes), &chunk.bytes)
}

fn document(model: &Glb, chunk: &Chunk, attributes: &str) -> String {
    let Glb {
        name,
        remark,
        colour: [red, green, blue],
        ..
    } = model;
    let mut json = format!(r#"{{"asset":{{"version":"2.0","copyright":"{remark}"}},"scene":0,"#);
    json += &format!(r#""scenes":[{{"nodes":[0]}}],"nodes":[{{"name":"{name}","mesh":0}}],"#);
    json +=
        &format!(r#""meshes":[{{"name":"{name}","primitives":[{{"attributes":{{{attributes}}},"#);
    json += &format!(
        r#""indices":{},"material":0}}]}}],"#,
        chunk.accessors.len() - 1
    );
    json += &format!(r#""materials":[{{"name":"{name}","pbrMetallicRoughness":{{"#);
    json += &format!(
        r#""baseColorFactor":[{red},{green},{blue},1],"metallicFactor":0,"roughnessFactor":0.9}}}}],"#
    );
    json += &format!(r#""accessors":[{}],"#, chunk.accessors.join(","));
    json += &format!(r#""bufferViews":[{}],"#, chunk.views.join(","));
    json + &format!(r#""buffers":[{{"byteLength":{}}}]}}"#, chunk.bytes.len())
}

fn container(json: &str, binary: &[u8]) -> Vec<u8> {
    let padding = json.len().next_multiple_of(4) - json.len();
    let text_length = json.len() + padding;
    let total = 12 + 8 + text_length + 8 + binary.len();
    let mut bytes = b"glTF".to_vec();
    bytes.extend(
        [2, total as u32, text_length as u32]
            .iter()
            .flat_map(|x| x.to_le_bytes()),
    );
    bytes.extend(b"JSON");
    bytes.extend(json.bytes());
    bytes.extend(std::iter::repeat_n(b' ', padding));
    bytes.extend((binary.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(binary);
    bytes
}
