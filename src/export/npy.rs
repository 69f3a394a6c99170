//! NPY, format version 1.0: one structured record an element (NumPy's NEP 1).
//!
//! Field types do not depend on the values, so that tables can be concatenated.

use std::io::{self, Write};

use super::columns::{Column, Kind, columns};
use super::{AgeColor, Elements};

pub(super) fn write(
    elements: &Elements,
    _color: AgeColor<'_>,
    out: &mut dyn Write,
) -> io::Result<()> {
    let columns = columns(elements);
    let field = |c: &Column<'_>| format!("('{}', '{}')", c.name, descr(c.kind));
    let fields: Vec<_> = columns.iter().map(field).collect();
    let kind = format!("[{}]", fields.join(", "));
    out.write_all(&header(&kind, &format!("({},)", elements.len())))?;
    let mut record = Vec::with_capacity(128);
    for row in 0..elements.len() {
        record.clear();
        columns.iter().for_each(|c| c.at(row).push(&mut record));
        out.write_all(&record)?;
    }
    Ok(())
}

fn descr(kind: Kind) -> &'static str {
    match kind {
        Kind::F64 => "<f8",
        Kind::F32 => "<f4",
        Kind::I32 => "<i4",
    }
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
