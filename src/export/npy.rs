//! NPY, format version 1.0: one structured record an element (NumPy's NEP 1).
//!
//! Field types do not depend on the values, so that tables can be concatenated.

use std::io::{self, Write};

use super::elements::Row;
use super::{AgeColor, Elements};

const FIELDS: [(&str, &str); 14] = [
    ("x", "<f8"),
    ("y", "<f8"),
    ("z", "<f8"),
    ("nx", "<f4"),
    ("ny", "<f4"),
    ("nz", "<f4"),
    ("radius", "<f8"),
    ("birth", "<i4"),
    ("parent", "<i4"),
    ("colony", "<i4"),
    ("triangle", "<i4"),
    ("u", "<f4"),
    ("v", "<f4"),
    ("probability", "<f4"),
];

pub(super) fn write(
    elements: &Elements,
    _color: AgeColor<'_>,
    out: &mut dyn Write,
) -> io::Result<()> {
    let source = elements
        .source_triangle
        .is_some()
        .then_some(("source_triangle", "<i4"));
    let fields: Vec<_> = FIELDS
        .iter()
        .chain(&source)
        .map(|(name, kind)| format!("('{name}', '{kind}')"))
        .collect();
    let kind = format!("[{}]", fields.join(", "));
    out.write_all(&header(&kind, &format!("({},)", elements.len())))?;
    let mut record = Vec::with_capacity(96);
    for row in elements.rows() {
        record.clear();
        push_row(&mut record, &row);
        out.write_all(&record)?;
    }
    Ok(())
}

/// An NPY header: magic, version, length and the dictionary, padded to a multiple of 64 bytes.
pub(super) fn header(descr: &str, shape: &str) -> Vec<u8> {
    const PREFIX: usize = 10;
    let dict = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}");
    let total = (PREFIX + dict.len() + 1).next_multiple_of(64);
    let length = (total - PREFIX) as u16;
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend_from_slice(&length.to_le_bytes());
    bytes.extend_from_slice(dict.as_bytes());
    bytes.resize(total - 1, b' ');
    bytes.push(b'\n');
    bytes
}

fn push_row(record: &mut Vec<u8>, row: &Row) {
    row.position
        .iter()
        .for_each(|x| record.extend_from_slice(&x.to_le_bytes()));
    row.normal
        .iter()
        .for_each(|x| record.extend_from_slice(&x.to_le_bytes()));
    record.extend_from_slice(&row.radius.to_le_bytes());
    for index in [row.birth, row.parent, row.colony, row.triangle] {
        record.extend_from_slice(&index.to_le_bytes());
    }
    for x in [row.uv[0], row.uv[1], row.probability] {
        record.extend_from_slice(&x.to_le_bytes());
    }
    if let Some(triangle) = row.source_triangle {
        record.extend_from_slice(&triangle.to_le_bytes());
    }
}
