//! STL: binary, ASCII, and binary that claims to be ASCII.
//!
//! We read it ourselves and not with `stl_io`, which takes every file that begins with `solid` for
//! ASCII, wants it in lower case and in one solid, and takes four times as long (5.9 µs an ASCII
//! triangle, 0.67 µs a binary one). Facet normals and attribute bytes are passed over. ASCII is read as a stream, because
//! the text is three times as large as the triangles in it.

use std::io::BufRead;

use crate::substrate::Soup;

use super::Format::Stl;
use super::error::{LoadFault, Parsed};
use super::text::{finite, number, quoted};
use super::{exclusive_index, no_triangles};

const HEADER: usize = 80;
const FACETS_AT: usize = HEADER + 4;
const FACET: usize = 50;
/// Longest line of ASCII STL that is kept: a solid's name may be anything.
const LONGEST_LINE: usize = 64 * 1024;

/// How the facets are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Binary,
}

/// The number of facets that a binary header promises, if the file is long enough to have one.
fn promised(head: &[u8]) -> Option<u64> {
    let count = head.get(HEADER..FACETS_AT)?.try_into().ok()?;
    Some(u64::from(u32::from_le_bytes(count)))
}

/// Whether a file with this beginning and length is binary STL to the byte.
pub(super) fn is_exact_binary(head: &[u8], length: u64) -> bool {
    promised(head).is_some_and(|n| n > 0 && FACETS_AT as u64 + FACET as u64 * n == length)
}

/// Whether the beginning reads like ASCII STL.
pub(super) fn looks_ascii(head: &[u8]) -> bool {
    let text = head
        .strip_prefix(b"\xEF\xBB\xBF")
        .unwrap_or(head)
        .trim_ascii_start();
    let solid = text
        .get(..5)
        .is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    // A binary header that begins with 'solid' has a facet count, and so a control byte, behind it.
    solid
        && !text
            .iter()
            .any(|&b| b == 0 || (b < 32 && !b.is_ascii_whitespace()))
}

/// Decides how a file that is taken for STL is written; the exact size outweighs the first word.
pub(super) fn encoding(head: &[u8], length: u64) -> Encoding {
    if is_exact_binary(head, length) || !looks_ascii(head) {
        Encoding::Binary
    } else {
        Encoding::Ascii
    }
}

/// Reads an STL file's bytes.
pub(super) fn parse(bytes: &[u8]) -> Parsed<Soup> {
    match encoding(&bytes[..bytes.len().min(super::HEAD)], bytes.len() as u64) {
        Encoding::Binary => parse_binary(bytes),
        Encoding::Ascii => parse_ascii(bytes),
    }
}

fn parse_binary(bytes: &[u8]) -> Parsed<Soup> {
    let Some(promised) = promised(bytes) else {
        return Err(LoadFault::malformed(
            Stl,
            format!("byte {}", bytes.len()),
            format!("the file ends within the {FACETS_AT}-byte header"),
            "export or copy the file again",
        ));
    };
    let body = &bytes[FACETS_AT..];
    let present = (body.len() / FACET) as u64;
    if promised > present {
        return Err(LoadFault::malformed(
            Stl,
            format!("byte {HEADER}"),
            format!("the header promises {promised} facets, the file holds {present}"),
            "it was cut short or is not STL: export or copy it again",
        ));
    }
    // Some programs leave a wrong count behind; whole facets to the last byte are facets all the same.
    let miscounted = promised < present && body.len().is_multiple_of(FACET);
    let facets = if miscounted { present } else { promised } as usize;
    if facets == 0 {
        return Err(no_triangles(0, &[]));
    }
    exclusive_index(facets.saturating_mul(3), Stl)?;
    let mut soup = read_facets(&body[..facets * FACET])?;
    let trailing = body.len() - facets * FACET;
    if trailing > 0 {
        soup.notes
            .push(format!("{trailing} bytes after the last facet ignored"));
    }
    if miscounted {
        soup.notes.push(format!(
            "the header promises {promised} facets, the file holds {present}: all are read"
        ));
    }
    Ok(soup)
}

fn read_facets(body: &[u8]) -> Parsed<Soup> {
    let count = body.len() / FACET;
    let mut positions = Vec::with_capacity(count * 3);
    for (facet, record) in body.chunks_exact(FACET).enumerate() {
        for corner in record[12..48].chunks_exact(12) {
            let position = std::array::from_fn(|axis| {
                let at = 4 * axis;
                let raw = [corner[at], corner[at + 1], corner[at + 2], corner[at + 3]];
                f64::from(f32::from_le_bytes(raw))
            });
            let place = || format!("facet {facet} (byte {})", FACETS_AT + facet * FACET);
            positions.push(finite(position, Stl, place)?);
        }
    }
    Ok(unshared(positions, Vec::new()))
}

/// The soup in which every triangle has three vertices of its own.
fn unshared(positions: Vec<[f64; 3]>, notes: Vec<String>) -> Soup {
    let triangles = (0..positions.len() as u32 / 3)
        .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
        .collect();
    Soup {
        positions,
        triangles,
        notes,
    }
}

/// Reads ASCII STL, any number of solids, in any case and with any white space.
pub(super) fn parse_ascii(mut input: impl BufRead) -> Parsed<Soup> {
    let mut facets = AsciiFacets::default();
    let mut line = Vec::new();
    while next_line(&mut input, &mut line)? {
        facets.line += 1;
        facets.statement(&line)?;
    }
    facets.finish()
}

/// Reads one line, at most [`LONGEST_LINE`] bytes of it; false at the end.
fn next_line(input: &mut impl BufRead, line: &mut Vec<u8>) -> Parsed<bool> {
    line.clear();
    let mut any = false;
    loop {
        let chunk = input.fill_buf().map_err(|source| LoadFault::Unreadable {
            what: "the file".into(),
            source,
            cure: "copy it to a local disk and try again",
        })?;
        if chunk.is_empty() {
            return Ok(any);
        }
        any = true;
        let end = chunk.iter().position(|&b| b == b'\n');
        let taken = end.unwrap_or(chunk.len());
        let room = LONGEST_LINE - line.len().min(LONGEST_LINE);
        line.extend_from_slice(&chunk[..taken.min(room)]);
        input.consume(taken + usize::from(end.is_some()));
        if end.is_some() {
            return Ok(true);
        }
    }
}

#[derive(Default)]
struct AsciiFacets {
    line: usize,
    solids: usize,
    skipped: usize,
    /// Corners of the loop that is open.
    open: usize,
    positions: Vec<[f64; 3]>,
}

impl AsciiFacets {
    fn statement(&mut self, line: &[u8]) -> Parsed<()> {
        let mut words = line
            .split(u8::is_ascii_whitespace)
            .filter(|word| !word.is_empty());
        let Some(first) = words.next() else {
            return Ok(());
        };
        if first.eq_ignore_ascii_case(b"vertex") {
            return self.vertex(words);
        }
        if first.eq_ignore_ascii_case(b"endloop") || first.eq_ignore_ascii_case(b"endfacet") {
            return self.close();
        }
        if first
            .strip_prefix(b"\xEF\xBB\xBF")
            .unwrap_or(first)
            .eq_ignore_ascii_case(b"solid")
        {
            self.solids += 1;
            return Ok(());
        }
        let known: [&[u8]; 4] = [b"facet", b"outer", b"endsolid", b"end"];
        if known.iter().any(|word| first.eq_ignore_ascii_case(word)) {
            return Ok(());
        }
        self.skipped += 1;
        Ok(())
    }

    fn vertex<'a>(&mut self, mut words: impl Iterator<Item = &'a [u8]>) -> Parsed<()> {
        let mut position = [0.0; 3];
        for coordinate in &mut position {
            let word = words.next().unwrap_or_default();
            *coordinate = number(word).ok_or_else(|| {
                self.fault(format!(
                    "a vertex needs three numbers, not {}",
                    quoted(word)
                ))
            })?;
        }
        let line = self.line;
        self.positions
            .push(finite(position, Stl, || format!("line {line}"))?);
        self.open += 1;
        if self.open > 3 {
            return Err(self.fault("a facet has more than three vertices".into()));
        }
        exclusive_index(self.positions.len(), Stl)
    }

    fn close(&mut self) -> Parsed<()> {
        match std::mem::take(&mut self.open) {
            0 | 3 => Ok(()),
            n => Err(self.fault(format!("a facet ends after {n} vertices, not three"))),
        }
    }

    fn fault(&self, problem: String) -> LoadFault {
        let place = format!("line {}", self.line);
        LoadFault::malformed(
            Stl,
            place,
            problem,
            "correct the line or export the file again",
        )
    }

    fn finish(mut self) -> Parsed<Soup> {
        if self.open != 0 {
            return Err(self.fault("the file ends within a facet".into()));
        }
        if self.positions.is_empty() {
            return Err(no_triangles(0, &[]));
        }
        let mut notes = Vec::new();
        if self.solids > 1 {
            notes.push(format!("{} solids read as one mesh", self.solids));
        }
        if self.skipped > 0 {
            notes.push(format!("{} lines that are not STL ignored", self.skipped));
        }
        self.positions.shrink_to_fit();
        Ok(unshared(self.positions, notes))
    }
}
