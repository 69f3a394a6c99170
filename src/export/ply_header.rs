//! The header of a PLY file whose first element is the vertices.

use std::io::{BufRead, Read};

/// Longest header read: far above any real one, and a bound on what garbage can cost.
const MAX_HEADER: u64 = 1 << 20;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Little,
    Big,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The number in [`Scalar::size`] little-endian bytes; `f64` holds each of them exactly.
    pub(super) fn decode(self, bytes: &[u8]) -> f64 {
        let mut wide = [0; 8];
        wide[..bytes.len()].copy_from_slice(bytes);
        let low = u64::from_le_bytes(wide);
        match self {
            Self::I8 => f64::from(low as i8),
            Self::U8 | Self::U16 | Self::U32 => low as f64,
            Self::I16 => f64::from(low as i16),
            Self::I32 => f64::from(low as i32),
            Self::F32 => f64::from(f32::from_bits(low as u32)),
            Self::F64 => f64::from_bits(low),
        }
    }

    /// The number that a word of an ascii file stands for.
    pub(super) fn parse(self, word: &str) -> Option<f64> {
        match self {
            Self::F32 => word.parse::<f32>().ok().map(f64::from),
            _ => word.parse().ok(),
        }
    }
}

#[derive(Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) scalar: Scalar,
}

#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    /// Number of vertices that the file says it has.
    pub(super) count: usize,
    pub(super) properties: Vec<Property>,
    /// Whether other elements follow the vertices.
    pub(super) more: bool,
    /// Lines that the header takes.
    pub(super) lines: usize,
}

/// A line (from 1; 0 when there is none to name) and what is wrong with it.
pub(super) type HeaderError = (usize, String);

/// Reads up to and with the line `end_header`.
pub(super) fn read_header(input: &mut dyn BufRead) -> Result<Header, HeaderError> {
    let mut lines = Lines {
        input: input.take(MAX_HEADER),
        number: 0,
    };
    if lines.next()? != "ply" {
        return Err((
            1,
            "this is no table of elements: its first line is not 'ply'; give the folder of a run, or its elements.ply".to_owned(),
        ));
    }
    let mut draft = Draft::default();
    loop {
        let line = lines.next()?;
        if line == "end_header" {
            return draft.finish(lines.number);
        }
        draft
            .line(&line)
            .map_err(|problem| (lines.number, problem))?;
    }
}

struct Lines<'a> {
    input: std::io::Take<&'a mut dyn BufRead>,
    number: usize,
}

impl Lines<'_> {
    fn next(&mut self) -> Result<String, HeaderError> {
        self.number += 1;
        let fail = |problem: &str| (self.number, problem.to_owned());
        let mut line = Vec::new();
        self.input
            .read_until(b'\n', &mut line)
            .map_err(|e| (self.number, e.to_string()))?;
        if line.pop() != Some(b'\n') {
            return Err(fail(if self.input.limit() == 0 {
                "no 'end_header' in the first MiB: this is not a PLY file"
            } else {
                "the file ends inside its header: it was cut off"
            }));
        }
        let text = String::from_utf8_lossy(&line);
        Ok(text.trim_end().to_owned())
    }
}

#[derive(Default)]
struct Draft {
    encoding: Option<Encoding>,
    count: Option<usize>,
    properties: Vec<Property>,
    more: bool,
}

impl Draft {
    fn line(&mut self, line: &str) -> Result<(), String> {
        let words: Vec<_> = line.split_ascii_whitespace().collect();
        match words[..] {
            [] | ["comment" | "obj_info", ..] => Ok(()),
            ["format", name, "1.0"] => self.format(name),
            ["element", name, count] => self.element(name, count),
            ["property", ..] if self.more => Ok(()),
            ["property", "list", .., name] => {
                Err(format!("'{name}' is a list, which elements do not have"))
            }
            ["property", kind, name] => self.property(kind, name),
            _ => Err(format!("'{}' is not understood", shortened(line))),
        }
    }

    fn format(&mut self, name: &str) -> Result<(), String> {
        self.encoding = Some(match name {
            "ascii" => Encoding::Ascii,
            "binary_little_endian" => Encoding::Little,
            "binary_big_endian" => Encoding::Big,
            _ => return Err(format!("'{}' is not a PLY encoding", shortened(name))),
        });
        Ok(())
    }

    fn element(&mut self, name: &str, count: &str) -> Result<(), String> {
        if self.count.is_some() {
            self.more = true;
            return Ok(());
        }
        if name != "vertex" {
            return Err(format!("'{}' comes before the vertices", shortened(name)));
        }
        let limit = i32::MAX as usize;
        let count = count.parse().ok().filter(|&count: &usize| count <= limit);
        self.count = Some(count.ok_or("the number of vertices is not one up to 2147483647")?);
        Ok(())
    }

    fn property(&mut self, kind: &str, name: &str) -> Result<(), String> {
        let scalar = Scalar::named(kind)
            .ok_or_else(|| format!("'{}' is not a PLY type", shortened(kind)))?;
        if self.count.is_none() {
            return Err(format!(
                "property '{}' comes before any element",
                shortened(name)
            ));
        }
        if self.properties.iter().any(|p| p.name == name) {
            return Err(format!("property '{}' is there twice", shortened(name)));
        }
        if self.properties.len() == 1024 {
            return Err("more than 1024 properties".to_owned());
        }
        self.properties.push(Property {
            name: name.to_owned(),
            scalar,
        });
        Ok(())
    }

    fn finish(self, lines: usize) -> Result<Header, HeaderError> {
        let missing = |what: &str| (0, format!("no line '{what}'"));
        Ok(Header {
            encoding: self.encoding.ok_or_else(|| missing("format … 1.0"))?,
            count: self.count.ok_or_else(|| missing("element vertex …"))?,
            properties: self.properties,
            more: self.more,
            lines,
        })
    }
}

/// Enough of a text to recognize it by, without its control characters.
pub(super) fn shortened(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).take(40).collect()
}
