//! NPZ: a zip of one NPY array a column, stored without compression.
//!
//! Each column is produced twice, once for its checksum and once for the file, so that nothing is
//! held in memory and sizes stand in front of the data, where every reader finds them.
//! Zip layout: PKWARE APPNOTE 6.3, sections 4.3.7, 4.3.12 and 4.3.16. Dates are fixed, because the
//! same table gives the same bytes.

use std::io::{self, Write};

use super::elements::{Attribute, Row, Values};
use super::npy::header;
use super::{AgeColor, Elements};

/// One array: its rows have `width` numbers of type `kind`.
struct Column<'a> {
    name: &'static str,
    kind: &'static str,
    width: usize,
    push: Push<'a>,
}

enum Push<'a> {
    Of(fn(&Row, &mut Vec<u8>)),
    Attribute(&'a Values),
}

const COLUMNS: [Column<'_>; 9] = [
    Column {
        name: "position",
        kind: "<f8",
        width: 3,
        push: Push::Of(|r, b| push_all(b, r.position.map(f64::to_le_bytes))),
    },
    Column {
        name: "normal",
        kind: "<f4",
        width: 3,
        push: Push::Of(|r, b| push_all(b, r.normal.map(f32::to_le_bytes))),
    },
    Column {
        name: "radius",
        kind: "<f8",
        width: 1,
        push: Push::Of(|r, b| b.extend(r.radius.to_le_bytes())),
    },
    Column {
        name: "birth",
        kind: "<i4",
        width: 1,
        push: Push::Of(|r, b| b.extend(r.birth.to_le_bytes())),
    },
    Column {
        name: "parent",
        kind: "<i4",
        width: 1,
        push: Push::Of(|r, b| b.extend(r.parent.to_le_bytes())),
    },
    Column {
        name: "colony",
        kind: "<i4",
        width: 1,
        push: Push::Of(|r, b| b.extend(r.colony.to_le_bytes())),
    },
    Column {
        name: "triangle",
        kind: "<i4",
        width: 1,
        push: Push::Of(|r, b| b.extend(r.triangle.to_le_bytes())),
    },
    Column {
        name: "uv",
        kind: "<f4",
        width: 2,
        push: Push::Of(|r, b| push_all(b, r.uv.map(f32::to_le_bytes))),
    },
    Column {
        name: "probability",
        kind: "<f4",
        width: 1,
        push: Push::Of(|r, b| b.extend(r.probability.to_le_bytes())),
    },
];

const SOURCE_TRIANGLE: Column<'_> = Column {
    name: "source_triangle",
    kind: "<i4",
    width: 1,
    push: Push::Of(|r, b| b.extend(r.source_triangle.unwrap_or(-1).to_le_bytes())),
};

fn push_all<const N: usize, const M: usize>(bytes: &mut Vec<u8>, numbers: [[u8; M]; N]) {
    bytes.extend_from_slice(numbers.as_flattened());
}

impl<'a> Column<'a> {
    fn of(attribute: &'a Attribute) -> Self {
        let (kind, width) = match &attribute.values {
            Values::I32(_) => ("<i4", 1),
            Values::F32(_) => ("<f4", 1),
            Values::Quaternion(_) => ("<f4", 4),
        };
        Self {
            name: attribute.name,
            kind,
            width,
            push: Push::Attribute(&attribute.values),
        }
    }

    fn write(&self, elements: &Elements, out: &mut dyn Write) -> io::Result<()> {
        let rows = elements.len();
        let shape = match self.width {
            1 => format!("({rows},)"),
            width => format!("({rows}, {width})"),
        };
        out.write_all(&header(&format!("'{}'", self.kind), &shape))?;
        let mut record = Vec::with_capacity(32);
        for (i, row) in elements.rows().enumerate() {
            record.clear();
            match self.push {
                Push::Of(push) => push(&row, &mut record),
                Push::Attribute(Values::I32(v)) => record.extend(v[i].to_le_bytes()),
                Push::Attribute(Values::F32(v)) => record.extend(v[i].to_le_bytes()),
                Push::Attribute(Values::Quaternion(v)) => {
                    push_all(&mut record, v[i].map(f32::to_le_bytes));
                }
            }
            out.write_all(&record)?;
        }
        Ok(())
    }
}

pub(super) fn write(
    elements: &Elements,
    _color: AgeColor<'_>,
    out: &mut dyn Write,
) -> io::Result<()> {
    let source = elements
        .source_triangle
        .is_some()
        .then_some(SOURCE_TRIANGLE);
    let mut directory = Vec::new();
    let mut offset = 0;
    let mut entries = 0;
    let attributes: Vec<_> = elements.attributes.iter().map(Column::of).collect();
    for column in COLUMNS.iter().chain(&source).chain(&attributes) {
        let mut sum = Sum::default();
        column.write(elements, &mut sum)?;
        let entry = Entry {
            name: format!("{}.npy", column.name),
            offset,
            sum,
        };
        let local = entry.local_header()?;
        out.write_all(&local)?;
        column.write(elements, out)?;
        directory.extend(entry.central_header()?);
        offset += local.len() as u64 + entry.sum.size;
        entries += 1;
    }
    out.write_all(&directory)?;
    out.write_all(&end_of_directory(entries, directory.len(), offset)?)
}

/// Counts and checksums what is written to it.
#[derive(Default)]
struct Sum {
    size: u64,
    crc: crc32fast::Hasher,
}

impl Write for Sum {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.size += bytes.len() as u64;
        self.crc.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

struct Entry {
    name: String,
    offset: u64,
    sum: Sum,
}

/// Version 2.0 needed, no flags, stored, 00:00 on 1 January 1980.
const COMMON: [u8; 10] = [20, 0, 0, 0, 0, 0, 0, 0, 0x21, 0];

impl Entry {
    fn local_header(&self) -> io::Result<Vec<u8>> {
        let mut bytes = b"PK\x03\x04".to_vec();
        self.push_common(&mut bytes)?;
        bytes.extend_from_slice(self.name.as_bytes());
        Ok(bytes)
    }

    fn central_header(&self) -> io::Result<Vec<u8>> {
        const MADE_BY_UNIX: [u8; 2] = [20, 3];
        const MODE: u32 = 0o100_644 << 16;
        let mut bytes = b"PK\x01\x02".to_vec();
        bytes.extend_from_slice(&MADE_BY_UNIX);
        self.push_common(&mut bytes)?;
        // No comment, disk 0, no internal attributes.
        bytes.extend_from_slice(&[0; 6]);
        bytes.extend_from_slice(&MODE.to_le_bytes());
        bytes.extend_from_slice(&small(self.offset)?.to_le_bytes());
        bytes.extend_from_slice(self.name.as_bytes());
        Ok(bytes)
    }

    fn push_common(&self, bytes: &mut Vec<u8>) -> io::Result<()> {
        let size = small(self.sum.size)?;
        bytes.extend_from_slice(&COMMON);
        bytes.extend_from_slice(&self.sum.crc.clone().finalize().to_le_bytes());
        bytes.extend_from_slice(&size.to_le_bytes());
        bytes.extend_from_slice(&size.to_le_bytes());
        bytes.extend_from_slice(&(self.name.len() as u16).to_le_bytes());
        bytes.extend_from_slice(&0_u16.to_le_bytes());
        Ok(())
    }
}

fn end_of_directory(entries: u16, size: usize, offset: u64) -> io::Result<Vec<u8>> {
    let mut bytes = b"PK\x05\x06\0\0\0\0".to_vec();
    bytes.extend_from_slice(&entries.to_le_bytes());
    bytes.extend_from_slice(&entries.to_le_bytes());
    bytes.extend_from_slice(&small(size as u64)?.to_le_bytes());
    bytes.extend_from_slice(&small(offset)?.to_le_bytes());
    bytes.extend_from_slice(&0_u16.to_le_bytes());
    Ok(bytes)
}

/// Sizes and offsets of a plain zip have 32 bits; its highest value is reserved.
fn small(size: u64) -> io::Result<u32> {
    u32::try_from(size)
        .ok()
        .filter(|&size| size < u32::MAX)
        .ok_or_else(|| {
            let problem = "a .npz ends at 4 GiB and these elements need more: export them to .npy";
            io::Error::new(io::ErrorKind::InvalidInput, problem)
        })
}
