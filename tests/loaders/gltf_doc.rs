//! glTF documents built in memory.

use serde_json::{Value, json};
use thallus::substrate::{Format, Soup, parse_soup};

pub(crate) const FLOAT: u32 = 5126;
pub(crate) const U8: u32 = 5121;
pub(crate) const U16: u32 = 5123;
pub(crate) const U32: u32 = 5125;
pub(crate) const I8: u32 = 5120;
pub(crate) const I16: u32 = 5122;

/// A document with one buffer.
pub(crate) struct Doc {
    pub(crate) json: Value,
    pub(crate) bin: Vec<u8>,
}

impl Doc {
    pub(crate) fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"}, "bufferViews": [], "accessors": [], "meshes": [],
            "nodes": [], "buffers": [{"byteLength": 0}],
        });
        Self {
            json,
            bin: Vec::new(),
        }
    }

    pub(crate) fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.json[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let at = self.bin.len();
        self.bin.extend(bytes);
        self.push(
            "bufferViews",
            json!({"buffer": 0, "byteOffset": at, "byteLength": bytes.len()}),
        )
    }

    pub(crate) fn accessor(
        &mut self,
        bytes: &[u8],
        component: u32,
        lanes: &str,
        count: usize,
    ) -> usize {
        let view = self.view(bytes);
        let accessor =
            json!({"bufferView": view, "componentType": component, "type": lanes, "count": count});
        self.push("accessors", accessor)
    }

    pub(crate) fn positions(&mut self, positions: &[[f32; 3]]) -> usize {
        self.accessor(&floats(positions), FLOAT, "VEC3", positions.len())
    }

    pub(crate) fn indices(&mut self, indices: &[u16]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
        self.accessor(&bytes, U16, "SCALAR", indices.len())
    }

    /// A mesh of one primitive, and a node that shows it.
    pub(crate) fn show(&mut self, primitive: Value, node: Value) -> usize {
        let mesh = self.push("meshes", json!({"primitives": [primitive]}));
        let mut node = node;
        node["mesh"] = json!(mesh);
        self.push("nodes", node)
    }

    pub(crate) fn glb(&self) -> Vec<u8> {
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

    pub(crate) fn with_uri(&self, uri: &str) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"][0] = json!({"byteLength": self.bin.len(), "uri": uri});
        json.to_string().into_bytes()
    }

    pub(crate) fn load(&self) -> Soup {
        let loaded = parse_soup(&self.glb(), Format::Glb, None);
        loaded.unwrap_or_else(|error| panic!("{error}")).soup
    }

    pub(crate) fn refused(&self) -> String {
        match parse_soup(&self.glb(), Format::Glb, None) {
            Ok(loaded) => panic!("loaded {} triangles", loaded.soup.triangles.len()),
            Err(error) => error.to_string(),
        }
    }
}

pub(crate) fn floats(positions: &[[f32; 3]]) -> Vec<u8> {
    positions
        .iter()
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .collect()
}

pub(crate) fn base64(bytes: &[u8]) -> String {
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

/// A tetrahedron with outward winding.
pub(crate) const CORNERS: [[f32; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
];
pub(crate) const SOLID: [u16; 12] = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];

pub(crate) fn tetrahedron(node: Value) -> Doc {
    let mut doc = Doc::new();
    let (position, indices) = (doc.positions(&CORNERS), doc.indices(&SOLID));
    doc.show(
        json!({"attributes": {"POSITION": position}, "indices": indices}),
        node,
    );
    doc
}
