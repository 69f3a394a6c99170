//! STL: binary, ASCII, and binary that claims to be ASCII.
//!
//! We read it ourselves and not with `stl_io`, which takes every file that begins with `solid` for
//! ASCII, wants it in lower case and in one solid, and takes four times as long (5.9 µs an ASCII
//! triangle, 0.67 µs a binary one). Facet normals and attribute bytes are passed over. ASCII is read as a stream,
//! because the text is three times as large as the triangles in it, and word by word: old files end their lines with
//! CR, and some have one line only.

use std::fmt;
use std::io::BufRead;

use crate::input::{quoted, without_mark};
use crate::substrate::Soup;

use super::Format::Stl;
use super::error::{LoadFault, Parsed};
use super::text::{finite, number};
use super::words::Words;
use super::{counted, exclusive_index, no_triangles};

const HEADER: usize = 80;
const FACETS_AT: usize = HEADER + 4;
const FACET: usize = 50;

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
fn looks_ascii(head: &[u8]) -> bool {
    let text = without_mark(head).trim_ascii_start();
    let solid = text
        .get(..5)
        .is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    // A binary header that begins with 'solid' has a facet count, and so a control byte, behind it; a text may
    // have one by accident, or a remark before its first word.
    let is_control = |&b: &u8| b == 0 || (b < 32 && !b.is_ascii_whitespace());
    (solid && !text.iter().any(is_control)) || has_vertex(text)
}

/// Whether a loop begins in the text, with a number of its first vertex: other files have only the words, in their
/// headers and comments.
fn has_vertex(text: &[u8]) -> bool {
    let words = text.split(u8::is_ascii_whitespace);
    let words: Vec<&[u8]> = words.filter(|word| !word.is_empty()).collect();
    words.windows(4).any(|words| {
        let keywords = [&b"outer"[..], b"loop", b"vertex"];
        let mut begins = keywords.iter().zip(words);
        begins.all(|(keyword, word)| keyword.eq_ignore_ascii_case(word))
            && number(words[3]).is_some()
    })
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
    let miscounted = promised < present
        && body.len().is_multiple_of(FACET)
        && goes_on(body, promised as usize * FACET);
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

/// Whether what follows these facets is more of them, and not what a program adds about the mesh: within a hundred
/// times as far from the origin as the facets are.
fn goes_on(body: &[u8], at: usize) -> bool {
    const FARTHER: f64 = 100.0;
    let reach = |records: &[u8]| {
        let all = records.chunks_exact(FACET).flat_map(corners_of);
        all.flatten().map(f64::abs).reduce(f64::max)
    };
    let (facets, rest) = body.split_at(at);
    match (reach(facets), reach(rest)) {
        (Some(facets), Some(rest)) if facets > 0.0 => rest <= FARTHER * facets,
        _ => true,
    }
}

/// The corners of a binary facet.
fn corners_of(record: &[u8]) -> impl Iterator<Item = [f64; 3]> {
    record[12..48].chunks_exact(12).map(|corner| {
        std::array::from_fn(|axis| {
            let at = 4 * axis;
            let raw = [corner[at], corner[at + 1], corner[at + 2], corner[at + 3]];
            f64::from(f32::from_le_bytes(raw))
        })
    })
}

fn read_facets(body: &[u8]) -> Parsed<Soup> {
    let count = body.len() / FACET;
    let mut positions = Vec::with_capacity(count * 3);
    for (facet, record) in body.chunks_exact(FACET).enumerate() {
        for position in corners_of(record) {
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
pub(super) fn parse_ascii(input: impl BufRead) -> Parsed<Soup> {
    let mut facets = AsciiFacets::new(Words::new(input));
    while facets.words.advance()? {
        facets.word()?;
    }
    facets.finish()
}

/// What ASCII STL is made of, besides names and numbers.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Keyword {
    Solid,
    EndSolid,
    End,
    Facet,
    Normal,
    Loop,
    Vertex,
    Close,
}

impl Keyword {
    fn of(word: &[u8]) -> Option<Self> {
        const KEYWORDS: [(&[u8], Keyword); 10] = [
            (b"vertex", Keyword::Vertex),
            (b"facet", Keyword::Facet),
            (b"normal", Keyword::Normal),
            (b"outer", Keyword::Loop),
            (b"loop", Keyword::Loop),
            (b"endloop", Keyword::Close),
            (b"endfacet", Keyword::Close),
            (b"solid", Keyword::Solid),
            (b"endsolid", Keyword::EndSolid),
            (b"end", Keyword::End),
        ];
        let word = without_mark(word);
        let mut known = KEYWORDS.iter();
        let found = known.find(|(name, _)| word.eq_ignore_ascii_case(name));
        found.map(|(_, keyword)| *keyword)
    }
}

/// Where a statement is, after its first word.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Rest {
    /// It goes on to the next keyword.
    Ours,
    /// It began with `end`, and what ends comes next.
    Ends,
    /// It is a name or is not STL: it may have any word, and goes on to the end of the line, or to
    /// `facet normal` where everything stands on one line.
    Anything,
    /// The same, after `facet`.
    AnythingThenFacet,
}

struct AsciiFacets<R> {
    words: Words<R>,
    rest: Rest,
    begun: usize,
    ended: usize,
    skipped: usize,
    /// Facets that have ended, and those of them that were no triangles.
    facets: usize,
    short: usize,
    /// Corners of the loop that is open.
    open: usize,
    /// Where the last corner was.
    last: Place,
    positions: Vec<[f64; 3]>,
}

impl<R: BufRead> AsciiFacets<R> {
    fn new(words: Words<R>) -> Self {
        Self {
            words,
            rest: Rest::Ours,
            begun: 0,
            ended: 0,
            skipped: 0,
            facets: 0,
            short: 0,
            open: 0,
            last: Place { line: 1, facet: 0 },
            positions: Vec::new(),
        }
    }

    fn word(&mut self) -> Parsed<()> {
        let keyword = Keyword::of(self.words.word());
        if self.words.begins_line() {
            let unknown = keyword.is_none() && number(self.words.word()).is_none();
            self.skipped += usize::from(unknown);
            self.rest = if unknown { Rest::Anything } else { Rest::Ours };
        }
        match (self.rest, keyword) {
            (Rest::Ours, Some(keyword)) => return self.statement(keyword),
            (Rest::Ends, Some(Keyword::Loop | Keyword::Facet)) => {
                return self.statement(Keyword::Close);
            }
            (Rest::Ends, Some(Keyword::Solid)) => return self.statement(Keyword::EndSolid),
            (Rest::Ours, None) => {}
            (Rest::AnythingThenFacet, Some(Keyword::Normal)) => self.rest = Rest::Ours,
            (_, Some(Keyword::Facet)) => self.rest = Rest::AnythingThenFacet,
            _ => self.rest = Rest::Anything,
        }
        Ok(())
    }

    fn statement(&mut self, keyword: Keyword) -> Parsed<()> {
        self.rest = Rest::Ours;
        match keyword {
            Keyword::Vertex => return self.vertex(),
            Keyword::Close => {
                self.close();
                return Ok(());
            }
            Keyword::Facet | Keyword::Normal | Keyword::Loop => return Ok(()),
            Keyword::Solid => self.begun += 1,
            Keyword::EndSolid => self.ended += 1,
            Keyword::End => {
                self.rest = Rest::Ends;
                return Ok(());
            }
        }
        self.rest = Rest::Anything;
        Ok(())
    }

    fn vertex(&mut self) -> Parsed<()> {
        let place = self.place();
        self.last = place;
        let mut position = [0.0; 3];
        for coordinate in &mut position {
            self.words.advance()?;
            let word = self.words.word();
            *coordinate = number(word).ok_or_else(|| {
                let problem = format!("a vertex needs three numbers, not {}", quoted(word));
                fault(place, problem)
            })?;
        }
        self.positions
            .push(finite(position, Stl, || place.to_string())?);
        self.open += 1;
        if self.open > 3 {
            return Err(fault(place, "a facet has more than three vertices".into()));
        }
        exclusive_index(self.positions.len(), Stl)
    }

    /// Some programs write edges and points of a mesh as facets of two vertices or one.
    fn close(&mut self) {
        let corners = std::mem::take(&mut self.open);
        self.facets += usize::from(corners > 0);
        if corners < 3 {
            self.short += usize::from(corners > 0);
            self.positions.truncate(self.positions.len() - corners);
        }
    }

    fn place(&self) -> Place {
        Place {
            line: self.words.line(),
            facet: self.facets,
        }
    }

    fn short_facets(&self) -> Option<String> {
        let one = "facet of fewer than three vertices";
        let many = "facets of fewer than three vertices";
        (self.short > 0).then(|| counted(self.short, one, many))
    }

    fn finish(mut self) -> Parsed<Soup> {
        if self.open != 0 {
            let problem = "the file ends within a facet".into();
            return Err(fault(self.last, problem));
        }
        if self.ended < self.begun {
            return Err(LoadFault::malformed(
                Stl,
                self.place().to_string(),
                "the file ends without endsolid",
                "it was cut short: export or copy it again, or write endsolid at its end if nothing is missing",
            ));
        }
        let short = self.short_facets();
        if self.positions.is_empty() {
            return Err(no_triangles(0, short.as_slice()));
        }
        let mut notes = Vec::new();
        // On one line the name after `endsolid` hides the next `solid`.
        let solids = self.begun.max(self.ended);
        if solids > 1 {
            notes.push(format!("{solids} solids read as one mesh"));
        }
        notes.extend(short.map(|facets| format!("{facets} ignored")));
        if self.skipped > 0 {
            let lines = "lines that are not STL";
            let lines = counted(self.skipped, "line that is not STL", lines);
            notes.push(format!("{lines} ignored"));
        }
        self.positions.shrink_to_fit();
        Ok(unshared(self.positions, notes))
    }
}

/// A place in ASCII STL. All of it may stand on one line.
#[derive(Clone, Copy)]
struct Place {
    line: usize,
    /// From 0.
    facet: usize,
}

impl fmt::Display for Place {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "line {} (facet {})", self.line, self.facet)
    }
}

fn fault(place: Place, problem: String) -> LoadFault {
    let cure = "correct the facet or export the file again";
    LoadFault::malformed(Stl, place.to_string(), problem, cure)
}
