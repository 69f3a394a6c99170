//! Apache Parquet, format version 1: required columns of plain numbers and texts, not compressed.
//!
//! Written after the specification of the Apache Parquet project (`parquet.thrift`, "File format",
//! "Data pages"), because the reference crate takes minutes to build and 67 others with it. Rows go
//! in groups of [`GROUP`], each column of a group as one page, so that memory does not grow with
//! the table. Metadata is in Thrift's compact protocol.

use std::io::{self, Write};

use super::columns::{Column, Kind, columns};
use super::{AgeColor, Elements};

/// Rows in a row group, at most. A page has to be smaller than 2 GiB.
const GROUP: usize = 1 << 20;

const MAGIC: &[u8; 4] = b"PAR1";

/// Values of the enumerations in `parquet.thrift`.
const REQUIRED: i64 = 0;
const PLAIN: i64 = 0;
const RLE: i64 = 3;
const UNCOMPRESSED: i64 = 0;
const DATA_PAGE: i64 = 0;

/// Appends the value of a row to a page.
type Push<'a> = Box<dyn Fn(usize, &mut Vec<u8>) + 'a>;

/// A column of a file.
pub(super) struct Leaf<'a> {
    pub(super) name: String,
    pub(super) physical: Physical,
    pub(super) push: Push<'a>,
}

/// The types of columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Physical {
    I32,
    F32,
    F64,
    U64,
    Text,
}

impl Physical {
    /// Number of the type in `parquet.thrift`, and of the logical type over it.
    fn numbers(self) -> (i64, Option<i64>) {
        match self {
            Self::I32 => (1, None),
            Self::F32 => (4, None),
            Self::F64 => (5, None),
            Self::U64 => (2, Some(14)),
            Self::Text => (6, Some(0)),
        }
    }
}

pub(super) fn write(
    elements: &Elements,
    _color: AgeColor<'_>,
    out: &mut dyn Write,
) -> io::Result<()> {
    let leaves: Vec<Leaf> = columns(elements).into_iter().map(leaf).collect();
    write_leaves("elements", elements.len(), &leaves, out)
}

fn leaf(column: Column<'_>) -> Leaf<'_> {
    Leaf {
        name: column.name.clone(),
        physical: match column.kind {
            Kind::I32 => Physical::I32,
            Kind::F32 => Physical::F32,
            Kind::F64 => Physical::F64,
        },
        push: Box::new(move |row, page| column.at(row).push(page)),
    }
}

/// A whole file: a table of this name.
pub(super) fn write_leaves(
    name: &str,
    rows: usize,
    leaves: &[Leaf<'_>],
    out: &mut dyn Write,
) -> io::Result<()> {
    out.write_all(MAGIC)?;
    let mut offset = MAGIC.len();
    let mut groups = Vec::new();
    for start in (0..rows).step_by(GROUP) {
        let rows = start..rows.min(start + GROUP);
        let mut chunks = Vec::new();
        for leaf in leaves {
            let page = page(leaf, rows.clone());
            out.write_all(&page)?;
            chunks.push(Chunk {
                offset,
                bytes: page.len(),
            });
            offset += page.len();
        }
        groups.push((rows.len(), chunks));
    }
    let footer = footer(name, rows, leaves, &groups);
    out.write_all(&footer)?;
    out.write_all(&(footer.len() as u32).to_le_bytes())?;
    out.write_all(MAGIC)
}

/// Where a column of a row group lies in the file.
struct Chunk {
    offset: usize,
    bytes: usize,
}

/// A page's header and its values.
fn page(leaf: &Leaf<'_>, rows: std::ops::Range<usize>) -> Vec<u8> {
    let mut values = Vec::new();
    rows.clone().for_each(|row| (leaf.push)(row, &mut values));
    let mut header = Thrift::default();
    header.i32(1, DATA_PAGE);
    header.i32(2, values.len() as i64);
    header.i32(3, values.len() as i64);
    header.open(5);
    header.i32(1, rows.len() as i64);
    header.i32(2, PLAIN);
    header.i32(3, RLE);
    header.i32(4, RLE);
    header.close();
    let mut page = header.finish();
    page.append(&mut values);
    page
}

/// `FileMetaData`.
fn footer(name: &str, rows: usize, leaves: &[Leaf<'_>], groups: &[(usize, Vec<Chunk>)]) -> Vec<u8> {
    let mut t = Thrift::default();
    t.i32(1, 1);
    t.list(2, Thrift::STRUCT, leaves.len() + 1);
    t.element(|root| {
        root.text(4, name);
        root.i32(5, leaves.len() as i64);
    });
    for leaf in leaves {
        let (physical, logical) = leaf.physical.numbers();
        t.element(|t| {
            t.i32(1, physical);
            t.i32(3, REQUIRED);
            t.text(4, &leaf.name);
            if let Some(logical) = logical {
                t.i32(6, logical);
            }
        });
    }
    t.i64(3, rows as i64);
    t.list(4, Thrift::STRUCT, groups.len());
    for (rows, chunks) in groups {
        t.element(|group| row_group(group, *rows, leaves, chunks));
    }
    t.text(6, concat!("thallus version ", env!("CARGO_PKG_VERSION")));
    t.finish()
}

fn row_group(t: &mut Thrift, rows: usize, leaves: &[Leaf<'_>], chunks: &[Chunk]) {
    t.list(1, Thrift::STRUCT, leaves.len());
    for (leaf, chunk) in leaves.iter().zip(chunks) {
        t.element(|t| {
            t.i64(2, chunk.offset as i64);
            t.open(3);
            column_metadata(t, rows, leaf, chunk);
            t.close();
        });
    }
    let bytes: usize = chunks.iter().map(|c| c.bytes).sum();
    t.i64(2, bytes as i64);
    t.i64(3, rows as i64);
}

fn column_metadata(t: &mut Thrift, rows: usize, leaf: &Leaf<'_>, chunk: &Chunk) {
    t.i32(1, leaf.physical.numbers().0);
    t.list(2, Thrift::I32, 1);
    t.value(PLAIN);
    t.list(3, Thrift::BINARY, 1);
    t.bytes(&leaf.name);
    t.i32(4, UNCOMPRESSED);
    t.i64(5, rows as i64);
    t.i64(6, chunk.bytes as i64);
    t.i64(7, chunk.bytes as i64);
    t.i64(9, chunk.offset as i64);
}

/// Thrift's compact protocol, as far as the metadata above needs it ("Thrift Compact protocol
/// encoding", Apache Thrift). Fields of a structure come with ascending numbers.
#[derive(Default)]
struct Thrift {
    bytes: Vec<u8>,
    last: u8,
    outer: Vec<u8>,
}

impl Thrift {
    const I32: u8 = 5;
    const I64: u8 = 6;
    const BINARY: u8 = 8;
    const LIST: u8 = 9;
    const STRUCT: u8 = 12;
    const STOP: u8 = 0;

    fn i32(&mut self, field: u8, value: i64) {
        self.field(field, Self::I32);
        self.value(value);
    }

    fn i64(&mut self, field: u8, value: i64) {
        self.field(field, Self::I64);
        self.value(value);
    }

    fn text(&mut self, field: u8, text: &str) {
        self.field(field, Self::BINARY);
        self.bytes(text);
    }

    /// Begins a list, whose elements follow.
    fn list(&mut self, field: u8, of: u8, length: usize) {
        self.field(field, Self::LIST);
        match length {
            0..15 => self.bytes.push((length as u8) << 4 | of),
            _ => {
                self.bytes.push(0xf0 | of);
                self.varint(length as u64);
            }
        }
    }

    /// A structure within a list.
    fn element(&mut self, fill: impl FnOnce(&mut Self)) {
        self.outer.push(self.last);
        self.last = 0;
        fill(self);
        self.close();
    }

    /// Begins a structure within a structure.
    fn open(&mut self, field: u8) {
        self.field(field, Self::STRUCT);
        self.outer.push(self.last);
        self.last = 0;
    }

    fn close(&mut self) {
        self.bytes.push(Self::STOP);
        self.last = self.outer.pop().unwrap_or(0);
    }

    fn finish(mut self) -> Vec<u8> {
        self.bytes.push(Self::STOP);
        self.bytes
    }

    fn field(&mut self, field: u8, kind: u8) {
        self.bytes.push((field - self.last) << 4 | kind);
        self.last = field;
    }

    fn value(&mut self, value: i64) {
        self.varint(((value << 1) ^ (value >> 63)) as u64);
    }

    fn bytes(&mut self, text: &str) {
        self.varint(text.len() as u64);
        self.bytes.extend_from_slice(text.as_bytes());
    }

    fn varint(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.bytes.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.bytes.push(value as u8);
    }
}
