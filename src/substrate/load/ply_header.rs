//! The header of a PLY file: elements, their properties, and how the body is written.

use super::Format::Ply;
use super::error::{LoadFault, Parsed};
use super::text::quoted;

/// How the body is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// A number's type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
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
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

/// What a property holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    One(Scalar),
    List { count: Scalar, item: Scalar },
}

#[derive(Debug)]
pub(super) struct Property {
    pub(super) name: Vec<u8>,
    pub(super) kind: Kind,
}

#[derive(Debug)]
pub(super) struct Element {
    pub(super) name: Vec<u8>,
    pub(super) count: usize,
    pub(super) properties: Vec<Property>,
}

impl Element {
    /// The fewest bytes that one row can take in the body.
    pub(super) fn least_bytes(&self, encoding: Encoding) -> usize {
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
    pub(super) fn position(&self, name: &[u8]) -> Option<usize> {
        self.properties
            .iter()
            .position(|property| property.name == name)
    }

    /// The number of the list that holds vertex indices: by name, or the only list of integers.
    pub(super) fn index_list(&self) -> Option<usize> {
        let named = self
            .position(b"vertex_indices")
            .or_else(|| self.position(b"vertex_index"));
        named.filter(|&at| self.is_index_list(at)).or_else(|| {
            let mut lists = (0..self.properties.len()).filter(|&at| self.is_index_list(at));
            lists.next().filter(|_| lists.next().is_none())
        })
    }

    fn is_index_list(&self, at: usize) -> bool {
        matches!(self.properties[at].kind, Kind::List { item, .. } if item.is_integer())
    }
}

/// The first line.
const MAGIC: &[u8] = b"ply";

#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Where the body begins, in bytes from the beginning of the file.
    pub(super) body: usize,
}

/// Reads the header.
pub(super) fn read(bytes: &[u8]) -> Parsed<Header> {
    if !is_begun(bytes) {
        return Err(fault(1, "the first line is not 'ply'".into()));
    }
    // Where a lone CR ends the first line it ends all, and a body may begin with LF.
    let first = bytes.iter().position(|b| b"\r\n".contains(b)).unwrap_or(0);
    let line_end = match bytes[first..] {
        [b'\r', b'\n', ..] | [b'\n', ..] => b'\n',
        _ => b'\r',
    };
    let mut parser = Parser {
        encoding: None,
        elements: Vec::new(),
    };
    let mut at = bytes.len() - without_mark(bytes).len();
    for number in 1.. {
        let rest = &bytes[at..];
        let Some(length) = rest.iter().position(|&b| b == line_end) else {
            return Err(fault(number, "the header has no end_header".into()));
        };
        at += length + 1;
        let line = rest[..length].trim_ascii();
        if line == b"end_header" {
            break;
        }
        parser
            .line(line)
            .map_err(|problem| fault(number, problem))?;
    }
    let encoding = parser
        .encoding
        .ok_or_else(|| fault(2, "there is no format line".into()))?;
    Ok(Header {
        encoding,
        elements: parser.elements,
        body: at,
    })
}

/// Whether a file begins as PLY does. Some programs write the first word in capitals.
pub(super) fn is_begun(bytes: &[u8]) -> bool {
    let Some((first, rest)) = without_mark(bytes).split_at_checked(MAGIC.len()) else {
        return false;
    };
    let mut after = rest.iter().filter(|b| !matches!(b, b' ' | b'\t'));
    first.eq_ignore_ascii_case(MAGIC) && after.next().is_some_and(|b| b"\r\n".contains(b))
}

fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes)
}

fn fault(line: usize, problem: String) -> LoadFault {
    let cure = "correct the header or export the file again";
    LoadFault::malformed(Ply, format!("line {line}"), problem, cure)
}

fn is_keyword(word: &[u8]) -> bool {
    [&b"format"[..], b"element", b"property"].contains(&word)
}

struct Parser {
    encoding: Option<Encoding>,
    elements: Vec<Element>,
}

impl Parser {
    fn line(&mut self, line: &[u8]) -> Result<(), String> {
        let words: Vec<&[u8]> = line
            .split(u8::is_ascii_whitespace)
            .filter(|word| !word.is_empty())
            .collect();
        match words[..] {
            [] | [b"comment" | b"obj_info", ..] => Ok(()),
            [word] if word.eq_ignore_ascii_case(MAGIC) => Ok(()),
            [b"format", encoding, ..] => self.format(encoding),
            [b"element", name, count] => self.element(name, count),
            // Blender writes names with spaces in them as they are.
            [b"property", b"list", count, item, _, ..] => {
                self.list(count, item, &name(&words[4..]))
            }
            [b"property", scalar, _, ..] => {
                let kind = Kind::One(scalar_named(scalar)?);
                self.property(&name(&words[2..]), kind)
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

    fn element(&mut self, name: &[u8], count: &[u8]) -> Result<(), String> {
        let count = std::str::from_utf8(count)
            .ok()
            .and_then(|digits| digits.parse().ok());
        let count = count.ok_or_else(|| format!("element {} has no valid count", quoted(name)))?;
        self.elements.push(Element {
            name: name.to_vec(),
            count,
            properties: Vec::new(),
        });
        Ok(())
    }

    fn list(&mut self, count: &[u8], item: &[u8], name: &[u8]) -> Result<(), String> {
        let (count, item) = (scalar_named(count)?, scalar_named(item)?);
        if !count.is_integer() {
            return Err(format!(
                "the length of list {} must be an integer",
                quoted(name)
            ));
        }
        self.property(name, Kind::List { count, item })
    }

    fn property(&mut self, name: &[u8], kind: Kind) -> Result<(), String> {
        let element = self
            .elements
            .last_mut()
            .ok_or("a property stands before any element")?;
        element.properties.push(Property {
            name: name.to_vec(),
            kind,
        });
        Ok(())
    }
}

/// A name of several words.
fn name(words: &[&[u8]]) -> Vec<u8> {
    words.join(&b' ')
}

fn scalar_named(name: &[u8]) -> Result<Scalar, String> {
    Scalar::from_name(name).ok_or_else(|| format!("type {} is unknown", quoted(name)))
}
