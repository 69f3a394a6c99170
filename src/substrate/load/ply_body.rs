//! The numbers of a PLY file's body, in text or binary.

use super::counted;
use super::text::{integer, line_of, number, single};
use crate::ply::Scalar;

/// The numbers of a body, one after the other.
pub(super) trait Body: Clone {
    /// The next number; `None` when it is missing or malformed.
    fn real(&mut self, scalar: Scalar) -> Option<f64>;
    /// The next integer; `None` when it is missing or malformed.
    fn integer(&mut self, scalar: Scalar) -> Option<i64>;
    /// The next `count` integers, put behind others.
    fn integers(&mut self, scalar: Scalar, count: usize, out: &mut Vec<i64>) -> Option<()> {
        one_by_one(self, scalar, count, out)
    }
    /// Passes over `count` numbers.
    fn skip(&mut self, scalar: Scalar, count: usize) -> Option<()>;
    /// Bytes that are left.
    fn left(&self) -> usize;
    /// The most numbers of this type that can be left.
    fn most(&self, scalar: Scalar) -> usize;
    /// Where we are, in bytes from the beginning of the file.
    fn at(&self) -> usize;
    /// Words for a place.
    fn place_of(&self, at: usize) -> String;
    /// What is left, in words; none where nothing is.
    fn rest(&self) -> Option<String>;
    /// Says that a row of an element has been read.
    fn end_row(&mut self) {}
    /// The first row that has more than the header declares, where these are told apart by lines.
    fn overlong(&self, _rows: usize) -> Option<usize> {
        None
    }

    fn place(&self) -> String {
        self.place_of(self.at())
    }
}

fn one_by_one(
    body: &mut impl Body,
    scalar: Scalar,
    count: usize,
    out: &mut Vec<i64>,
) -> Option<()> {
    for _ in 0..count {
        out.push(body.integer(scalar)?);
    }
    Some(())
}

/// Those of a binary file.
#[derive(Clone)]
pub(super) struct Binary<'a, const BIG: bool> {
    pub(super) bytes: &'a [u8],
    pub(super) at: usize,
}

impl<const BIG: bool> Binary<'_, BIG> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let mut raw: [u8; N] = self.bytes.get(self.at..)?.get(..N)?.try_into().ok()?;
        self.at += N;
        if BIG {
            raw.reverse();
        }
        Some(raw)
    }

    /// The next `count` numbers of four bytes, which nearly all lists of corners are.
    fn words(&mut self, count: usize) -> Option<impl Iterator<Item = [u8; 4]>> {
        let raw = self.bytes.get(self.at..)?.get(..count.checked_mul(4)?)?;
        self.at += raw.len();
        Some(raw.as_chunks().0.iter().map(|&word| {
            let [a, b, c, d] = word;
            if BIG { [d, c, b, a] } else { word }
        }))
    }
}

impl<const BIG: bool> Body for Binary<'_, BIG> {
    fn real(&mut self, scalar: Scalar) -> Option<f64> {
        match scalar {
            Scalar::F32 => self.take().map(f32::from_le_bytes).map(f64::from),
            Scalar::F64 => self.take().map(f64::from_le_bytes),
            _ => self.integer(scalar).map(|value| value as f64),
        }
    }

    fn integer(&mut self, scalar: Scalar) -> Option<i64> {
        match scalar {
            Scalar::I8 => self.take().map(i8::from_le_bytes).map(i64::from),
            Scalar::U8 => self.take().map(u8::from_le_bytes).map(i64::from),
            Scalar::I16 => self.take().map(i16::from_le_bytes).map(i64::from),
            Scalar::U16 => self.take().map(u16::from_le_bytes).map(i64::from),
            Scalar::I32 => self.take().map(i32::from_le_bytes).map(i64::from),
            Scalar::U32 => self.take().map(u32::from_le_bytes).map(i64::from),
            Scalar::I64 => self.take().map(i64::from_le_bytes),
            Scalar::U64 => i64::try_from(u64::from_le_bytes(self.take()?)).ok(),
            Scalar::F32 | Scalar::F64 => None,
        }
    }

    fn integers(&mut self, scalar: Scalar, count: usize, out: &mut Vec<i64>) -> Option<()> {
        match scalar {
            Scalar::I32 => out.extend(self.words(count)?.map(i32::from_le_bytes).map(i64::from)),
            Scalar::U32 => out.extend(self.words(count)?.map(u32::from_le_bytes).map(i64::from)),
            _ => return one_by_one(self, scalar, count, out),
        }
        Some(())
    }

    fn skip(&mut self, scalar: Scalar, count: usize) -> Option<()> {
        let length = scalar
            .size()
            .checked_mul(count)
            .filter(|&length| length <= self.left())?;
        self.at += length;
        Some(())
    }

    fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    fn most(&self, scalar: Scalar) -> usize {
        self.left() / scalar.size()
    }

    fn at(&self) -> usize {
        self.at
    }

    fn place_of(&self, at: usize) -> String {
        format!("byte {at}")
    }

    fn rest(&self) -> Option<String> {
        let left = self.left();
        (left > 0).then(|| counted(left, "byte", "bytes"))
    }
}

/// Those of a text file.
#[derive(Clone)]
pub(super) struct Ascii<'a> {
    bytes: &'a [u8],
    /// Where the body begins.
    start: usize,
    at: usize,
    /// Whether the next row begins a line.
    begins_line: bool,
    /// Where the first row ends that begins a line and does not end it.
    overlong: Option<usize>,
}

impl<'a> Ascii<'a> {
    pub(super) fn new(bytes: &'a [u8], start: usize) -> Self {
        Self {
            bytes,
            start,
            at: start,
            begins_line: true,
            overlong: None,
        }
    }

    /// Those with anything in them.
    fn lines(&self) -> usize {
        let lines = self.bytes[self.start..].split(|b| b"\r\n".contains(b));
        lines.filter(|line| !line.trim_ascii().is_empty()).count()
    }

    fn token(&mut self) -> Option<&'a [u8]> {
        let rest = &self.bytes[self.at..];
        let start = rest.iter().position(|b| !b.is_ascii_whitespace())?;
        let rest = &rest[start..];
        let length = rest
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(rest.len());
        self.at += start + length;
        Some(&rest[..length])
    }
}

impl Body for Ascii<'_> {
    fn real(&mut self, scalar: Scalar) -> Option<f64> {
        let token = self.token()?;
        if scalar == Scalar::F32 {
            single(token)
        } else {
            number(token)
        }
    }

    fn integer(&mut self, _: Scalar) -> Option<i64> {
        let token = self.token()?;
        // Some writers print integers as reals.
        integer(token).or_else(|| {
            let real = number(token)?;
            (real.trunc() == real && real.abs() < 1e15).then_some(real as i64)
        })
    }

    fn skip(&mut self, _: Scalar, count: usize) -> Option<()> {
        for _ in 0..count {
            self.token()?;
        }
        Some(())
    }

    fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    fn most(&self, _: Scalar) -> usize {
        self.left().div_ceil(2)
    }

    fn at(&self) -> usize {
        self.at
    }

    fn place_of(&self, at: usize) -> String {
        format!("line {}", line_of(self.bytes, at))
    }

    fn rest(&self) -> Option<String> {
        let mut rest = self.clone();
        let words = std::iter::from_fn(|| rest.token()).count();
        (words > 0).then(|| counted(words, "word", "words"))
    }

    fn end_row(&mut self) {
        let next = self.bytes[self.at..].iter().find(|b| !b" \t".contains(b));
        let ends_line = next.is_none_or(|b| b"\r\n".contains(b));
        if self.begins_line && !ends_line && self.overlong.is_none() {
            self.overlong = Some(self.at);
        }
        self.begins_line = ends_line;
    }

    /// Lines mean nothing in PLY, and some files wrap them anywhere. But where there is one for each row, and what is
    /// in them does not come out even, that is what their writer meant.
    fn overlong(&self, rows: usize) -> Option<usize> {
        self.overlong.filter(|_| self.lines() == rows)
    }
}
