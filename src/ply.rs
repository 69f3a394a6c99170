//! The header of a PLY file (Turk 1994): elements, their properties, and how the body is written.
//!
//! Meshes and tables of elements come in it, both of them from other programs: what one of these writes, both
//! readers understand.

use std::io::{self, BufRead, Read};

use crate::input::{quoted, without_mark};

/// How the body is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// A number's type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Scalar {
    fn from_name(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"int64" | b"long" => Self::I64,
            b"uint64" | b"ulong" => Self::U64,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes in a binary body.
    pub(crate) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    pub(crate) fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

/// What a property holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    One(Scalar),
    List { count: Scalar, item: Scalar },
}

#[derive(Debug)]
pub(crate) struct Property {
    pub(crate) name: Vec<u8>,
    pub(crate) kind: Kind,
    /// Where it is declared.
    pub(crate) line: usize,
}

#[derive(Debug)]
pub(crate) struct Element {
    pub(crate) name: Vec<u8>,
    pub(crate) count: usize,
    pub(crate) properties: Vec<Property>,
    /// Where it is declared.
    pub(crate) line: usize,
}

impl Element {
    /// The fewest bytes that one row can take in the body.
    pub(crate) fn least_bytes(&self, encoding: Encoding) -> usize {
        let sizes = self
            .properties
            .iter()
            .map(|property| match (encoding, property.kind) {
                // A digit and what separates it from the next.
                (Encoding::Ascii, _) => 2,
                (_, Kind::One(scalar) | Kind::List { count: scalar, .. }) => scalar.size(),
            });
        sizes.sum()
    }

    /// The number of the property called `name`.
    pub(crate) fn position(&self, name: &[u8]) -> Option<usize> {
        self.properties
            .iter()
            .position(|property| property.name == name)
    }
}

/// The first line.
const MAGIC: &[u8] = b"ply";

/// The first line is shorter, byte order mark and all.
const LONGEST_FIRST: u64 = 64;

#[derive(Debug)]
pub(crate) struct Header {
    pub(crate) encoding: Encoding,
    pub(crate) elements: Vec<Element>,
    /// Lines that it takes.
    pub(crate) lines: usize,
}

/// What is wrong with a header.
#[derive(Debug)]
pub(crate) struct HeaderFault {
    /// The line, from 1.
    pub(crate) line: usize,
    pub(crate) problem: String,
}

/// Reads up to where the body begins.
pub(crate) fn read_header(input: &mut dyn BufRead) -> Result<Header, HeaderFault> {
    let at = |line: usize| move |problem: String| HeaderFault { line, problem };
    let line_end = first_line(input).map_err(at(1))?;
    let mut draft = Draft::default();
    let mut number = 1;
    loop {
        number += 1;
        let line = next_line(input, line_end).map_err(at(number))?;
        let line = line.trim_ascii();
        if line == b"end_header" {
            return draft.finish(number).map_err(at(2));
        }
        draft.line(line, number).map_err(at(number))?;
    }
}

/// Whether a file begins as PLY does. Some programs write the first word in capitals.
pub(crate) fn is_begun(bytes: &[u8]) -> bool {
    let Some((first, rest)) = without_mark(bytes).split_at_checked(MAGIC.len()) else {
        return false;
    };
    let mut after = rest.iter().filter(|b| !matches!(b, b' ' | b'\t'));
    first.eq_ignore_ascii_case(MAGIC) && after.next().is_some_and(|b| b"\r\n".contains(b))
}

/// Reads the first line, and says what ends them all: a lone CR if it ends this one, and a body may begin with LF.
fn first_line(input: &mut dyn BufRead) -> Result<u8, String> {
    let mut line = Vec::new();
    for byte in (&mut *input).take(LONGEST_FIRST).bytes() {
        line.push(byte.map_err(words)?);
        if line.ends_with(b"\r") || line.ends_with(b"\n") {
            break;
        }
    }
    if !is_begun(&line) {
        return Err("the first line is not 'ply'".to_owned());
    }
    let is_lone = line.ends_with(b"\r") && !input.fill_buf().map_err(words)?.starts_with(b"\n");
    if is_lone {
        return Ok(b'\r');
    }
    input.consume(usize::from(line.ends_with(b"\r")));
    Ok(b'\n')
}

/// A line without its end.
fn next_line(input: &mut dyn BufRead, line_end: u8) -> Result<Vec<u8>, String> {
    let mut line = Vec::new();
    input.read_until(line_end, &mut line).map_err(words)?;
    match line.pop() == Some(line_end) {
        true => Ok(line),
        false => Err("the header has no end_header".to_owned()),
    }
}

fn words(error: io::Error) -> String {
    error.to_string()
}

fn is_keyword(word: &[u8]) -> bool {
    [&b"format"[..], b"element", b"property"].contains(&word)
}

#[derive(Default)]
struct Draft {
    encoding: Option<Encoding>,
    elements: Vec<Element>,
}

impl Draft {
    fn line(&mut self, line: &[u8], number: usize) -> Result<(), String> {
        let words: Vec<&[u8]> = line
            .split(u8::is_ascii_whitespace)
            .filter(|word| !word.is_empty())
            .collect();
        match words[..] {
            [] | [b"comment" | b"obj_info", ..] => Ok(()),
            [b"format", encoding, ..] => self.format(encoding),
            [b"element", name, count] => self.element(name, count, number),
            // Blender writes names with spaces in them as they are.
            [b"property", b"list", count, item, _, ..] => {
                let name = name(&words[4..]);
                let kind = list(count, item, &name)?;
                self.property(name, kind, number)
            }
            [b"property", scalar, _, ..] => {
                let kind = Kind::One(scalar_named(scalar)?);
                self.property(name(&words[2..]), kind, number)
            }
            // Nothing else may stand before the elements, so it is a comment, as an early Blender wrote them.
            [word, ..] if self.is_before_elements() && !is_keyword(word) => Ok(()),
            _ => Err(format!("{} is not a header line", quoted(line))),
        }
    }

    fn is_before_elements(&self) -> bool {
        self.encoding.is_some() && self.elements.is_empty()
    }

    fn format(&mut self, name: &[u8]) -> Result<(), String> {
        self.encoding = Some(match name {
            b"ascii" => Encoding::Ascii,
            b"binary_little_endian" => Encoding::LittleEndian,
            b"binary_big_endian" => Encoding::BigEndian,
            _ => return Err(format!("format {} is unknown", quoted(name))),
        });
        Ok(())
    }

    fn element(&mut self, name: &[u8], count: &[u8], line: usize) -> Result<(), String> {
        let count = std::str::from_utf8(count)
            .ok()
            .and_then(|digits| digits.parse().ok());
        let count = count.ok_or_else(|| format!("element {} has no valid count", quoted(name)))?;
        self.elements.push(Element {
            name: name.to_vec(),
            count,
            properties: Vec::new(),
            line,
        });
        Ok(())
    }

    fn property(&mut self, name: Vec<u8>, kind: Kind, line: usize) -> Result<(), String> {
        let element = self
            .elements
            .last_mut()
            .ok_or("a property stands before any element")?;
        element.properties.push(Property { name, kind, line });
        Ok(())
    }

    fn finish(self, lines: usize) -> Result<Header, String> {
        Ok(Header {
            encoding: self.encoding.ok_or("there is no format line")?,
            elements: self.elements,
            lines,
        })
    }
}

/// A name of several words.
fn name(words: &[&[u8]]) -> Vec<u8> {
    words.join(&b' ')
}

fn list(count: &[u8], item: &[u8], name: &[u8]) -> Result<Kind, String> {
    let (count, item) = (scalar_named(count)?, scalar_named(item)?);
    match count.is_integer() {
        true => Ok(Kind::List { count, item }),
        false => Err(format!(
            "the length of list {} must be an integer",
            quoted(name)
        )),
    }
}

fn scalar_named(name: &[u8]) -> Result<Scalar, String> {
    Scalar::from_name(name).ok_or_else(|| format!("type {} is unknown", quoted(name)))
}
