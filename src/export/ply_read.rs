//! `elements.ply` back to [`Elements`].
//!
//! Other programs rewrite the file before it comes back: properties may be in any order and of any
//! number type, foreign ones are passed over, rows are sorted by `birth`, and ascii and big-endian
//! files are read too. What would change the meaning is refused: missing rows, integers that a
//! float cannot hold, radii that differ.

use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use super::Elements;
use super::ply_header::{self, TableHeader};
use crate::input::{Stream, quoted};
use crate::ply::{Encoding, Scalar};

/// Why a file could not be read as a table of elements: the file, the place in it and the cure.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {place}: {problem}", .file.display())]
pub struct ReadError {
    /// The file.
    pub file: PathBuf,
    /// Where in it.
    pub place: String,
    /// What is wrong there, and what to do.
    pub problem: String,
}

/// Reads the `elements.ply` of a run.
///
/// `source_triangle` is `None` unless the file has a property of that name.
///
/// # Errors
/// When the file cannot be opened, is malformed or cut off, or is not a table of elements.
pub fn read_elements(file: &Path) -> Result<Elements, ReadError> {
    let fail = |e: io::Error| error(file, "opening it", &e.to_string());
    if file.is_dir() {
        return Err(error(
            file,
            "opening it",
            "this is a folder; name the elements.ply in it",
        ));
    }
    let opened = Stream::open(file).map_err(fail)?;
    let length = opened.metadata().map_err(fail)?.len();
    let mut opened = BufReader::with_capacity(1 << 16, opened);
    read(file, &mut opened, length)
}

/// Reads elements from the bytes of an `elements.ply`; `file` is named in errors.
///
/// # Errors
/// As [`read_elements`].
pub fn parse_elements(file: &Path, bytes: &[u8]) -> Result<Elements, ReadError> {
    read(file, &mut &*bytes, bytes.len() as u64)
}

fn error(file: &Path, place: &str, problem: &str) -> ReadError {
    ReadError {
        file: file.to_owned(),
        place: place.to_owned(),
        problem: problem.to_owned(),
    }
}

/// Where in the file, and what is wrong.
type Fault = (String, String);

fn read(file: &Path, input: &mut dyn BufRead, size: u64) -> Result<Elements, ReadError> {
    read_table(input, size).map_err(|(place, problem)| error(file, &place, &problem))
}

fn read_table(input: &mut dyn BufRead, size: u64) -> Result<Elements, Fault> {
    let header = ply_header::read(input)
        .map_err(|fault| (format!("header, line {}", fault.line), fault.problem))?;
    let plan = Plan::of(&header).map_err(|problem| ("header".to_owned(), problem))?;
    let mut table = Table::reserved(header.count.min(size as usize / header.least.max(1)), &plan);
    match header.encoding {
        Encoding::Ascii => read_ascii(input, &header, &plan, &mut table)?,
        Encoding::LittleEndian => read_binary(input, &header, &plan, &mut table, false)?,
        Encoding::BigEndian => read_binary(input, &header, &plan, &mut table, true)?,
    }
    let elements = table
        .finish()
        .map_err(|problem| ("after the elements".to_owned(), problem))?;
    let unsound = |e| {
        let cure = "the file was damaged or changed; use it as `thallus grow` wrote it";
        ("contents".to_owned(), format!("{e}: {cure}"))
    };
    elements.check().map_err(unsound)?;
    Ok(elements)
}

/// The properties that make an element, in [`Values`]' order. The last two may be missing.
const NAMES: [&str; 15] = [
    "x",
    "y",
    "z",
    "nx",
    "ny",
    "nz",
    "radius",
    "parent",
    "colony",
    "triangle",
    "u",
    "v",
    "probability",
    "birth",
    "source_triangle",
];
const REQUIRED: usize = 13;
const RADIUS: usize = 6;
const PARENT: usize = 7;
const COLONY: usize = 8;
const TRIANGLE: usize = 9;
const BIRTH: usize = 13;
const SOURCE: usize = 14;

/// One element's numbers, by the index of their name in [`NAMES`].
type Values = [f64; NAMES.len()];

/// What to do with each property of a row.
struct Plan {
    /// For each property its type and which of [`NAMES`] it is, if any.
    steps: Vec<(Scalar, Option<usize>)>,
    /// For each of [`NAMES`] its type, if the file has it.
    found: [Option<Scalar>; NAMES.len()],
    /// Bytes of a row in a binary file.
    stride: usize,
}

impl Plan {
    fn of(header: &TableHeader) -> Result<Self, String> {
        let mut found = [None; NAMES.len()];
        let mut steps = Vec::new();
        for column in &header.columns {
            let name = NAMES.iter().position(|name| name.as_bytes() == column.name);
            if let Some(name) = name {
                found[name] = Some(column.scalar);
            }
            steps.push((column.scalar, name));
        }
        if let Some(missing) = found[..REQUIRED].iter().position(Option::is_none) {
            return Err(format!(
                "no property '{}', so this is not a table of elements; \
                 name the elements.ply that `thallus grow` wrote",
                NAMES[missing]
            ));
        }
        let stride = steps.iter().map(|(scalar, _)| scalar.size()).sum();
        Ok(Self {
            steps,
            found,
            stride,
        })
    }
}

fn read_binary(
    input: &mut dyn BufRead,
    header: &TableHeader,
    plan: &Plan,
    table: &mut Table,
    big: bool,
) -> Result<(), Fault> {
    let mut record = vec![0; plan.stride];
    for row in 0..header.count {
        let place = || format!("element {row} of {}", header.count);
        input
            .read_exact(&mut record)
            .map_err(|e| (place(), unreadable(&e)))?;
        let mut values = [0.0; NAMES.len()];
        let mut rest = &mut record[..];
        for &(scalar, name) in &plan.steps {
            let (bytes, after) = rest.split_at_mut(scalar.size());
            rest = after;
            if big {
                bytes.reverse();
            }
            if let Some(name) = name {
                values[name] = decode(scalar, bytes);
            }
        }
        table
            .push(&values, plan)
            .map_err(|problem| (place(), problem))?;
    }
    let mut byte = [0];
    match input.read(&mut byte) {
        Ok(1..) if !header.more => Err(surplus()),
        Ok(_) => Ok(()),
        Err(e) => Err(("after the elements".to_owned(), e.to_string())),
    }
}

/// The number in [`Scalar::size`] little-endian bytes; `f64` holds each exactly that a table may have.
fn decode(scalar: Scalar, bytes: &[u8]) -> f64 {
    let mut wide = [0; 8];
    wide[..bytes.len()].copy_from_slice(bytes);
    let low = u64::from_le_bytes(wide);
    match scalar {
        Scalar::I8 => f64::from(low as i8),
        Scalar::U8 | Scalar::U16 | Scalar::U32 | Scalar::U64 => low as f64,
        Scalar::I16 => f64::from(low as i16),
        Scalar::I32 => f64::from(low as i32),
        Scalar::I64 => low as i64 as f64,
        Scalar::F32 => f64::from(f32::from_bits(low as u32)),
        Scalar::F64 => f64::from_bits(low),
    }
}

/// The number that a word of an ascii file stands for.
fn parse(scalar: Scalar, word: &str) -> Option<f64> {
    match scalar {
        Scalar::F32 => word.parse::<f32>().ok().map(f64::from),
        _ => word.parse().ok(),
    }
}

fn surplus() -> Fault {
    let problem = "there is more than the header declares: the file was damaged, \
                   perhaps by a transfer in text mode; copy it again";
    ("after the elements".to_owned(), problem.to_owned())
}

fn unreadable(e: &io::Error) -> String {
    match e.kind() {
        io::ErrorKind::UnexpectedEof => {
            "the file ends here: it was cut off; copy or grow it again".to_owned()
        }
        _ => e.to_string(),
    }
}

fn read_ascii(
    input: &mut dyn BufRead,
    header: &TableHeader,
    plan: &Plan,
    table: &mut Table,
) -> Result<(), Fault> {
    let mut line = Vec::new();
    let mut number = header.lines;
    let mut rows = 0;
    while rows < header.count || !header.more {
        number += 1;
        let place = || format!("line {number}");
        if !next_line(input, &mut line).map_err(|e| (place(), unreadable(&e)))? {
            break;
        }
        let text = String::from_utf8_lossy(&line);
        if text.trim().is_empty() {
            continue;
        }
        if rows == header.count {
            return Err(surplus());
        }
        let values = ascii_row(&text, plan).map_err(|problem| (place(), problem))?;
        table
            .push(&values, plan)
            .map_err(|problem| (place(), problem))?;
        rows += 1;
    }
    if rows < header.count {
        let place = format!("element {rows} of {}", header.count);
        return Err((place, unreadable(&io::ErrorKind::UnexpectedEof.into())));
    }
    Ok(())
}

/// Reads one line of bounded length; false at the end of the file.
fn next_line(input: &mut dyn BufRead, line: &mut Vec<u8>) -> io::Result<bool> {
    const MAX_LINE: u64 = 1 << 20;
    line.clear();
    let read = input.take(MAX_LINE).read_until(b'\n', line)?;
    if read as u64 == MAX_LINE {
        return Err(io::Error::other(
            "a line of more than a MiB: this is not a PLY file",
        ));
    }
    Ok(read > 0)
}

fn ascii_row(text: &str, plan: &Plan) -> Result<Values, String> {
    let mut values = [0.0; NAMES.len()];
    let mut words = text.split_ascii_whitespace();
    for &(scalar, name) in &plan.steps {
        let word = words.next().ok_or_else(|| {
            let (found, needed) = (text.split_ascii_whitespace().count(), plan.steps.len());
            format!("{found} values where the header declares {needed}: the file was cut off")
        })?;
        let value = parse(scalar, word)
            .ok_or_else(|| format!("{} is not a number; correct it", quoted(word.as_bytes())))?;
        if let Some(name) = name {
            values[name] = value;
        }
    }
    if words.next().is_some() {
        let declared = plan.steps.len();
        return Err(format!(
            "more than the {declared} values that the header declares"
        ));
    }
    // A number without its last digits is still a number.
    if !text.ends_with('\n') {
        let problem = "the line has no end, so the file may be cut off; copy it again, \
                       or end its last line if it is whole";
        return Err(problem.to_owned());
    }
    Ok(values)
}

/// The table as it fills up, in the file's order.
struct Table {
    elements: Elements,
    births: Vec<u32>,
    /// Whether any row so far is out of birth order.
    shuffled: bool,
}

impl Table {
    fn reserved(rows: usize, plan: &Plan) -> Self {
        let source = plan.found[SOURCE].map(|_| Vec::with_capacity(rows));
        let elements = Elements {
            radius: 0.0,
            positions: Vec::with_capacity(rows),
            normals: Vec::with_capacity(rows),
            parent: Vec::with_capacity(rows),
            colony: Vec::with_capacity(rows),
            triangle: Vec::with_capacity(rows),
            uv: Vec::with_capacity(rows),
            probability: Vec::with_capacity(rows),
            source_triangle: source,
            attributes: Vec::new(),
        };
        Self {
            elements,
            births: Vec::with_capacity(rows),
            shuffled: false,
        }
    }

    fn push(&mut self, values: &Values, plan: &Plan) -> Result<(), String> {
        let row = self.births.len();
        let index = |name: usize| whole(values[name], name, plan.found[name]);
        let birth = if plan.found[BIRTH].is_some() {
            index(BIRTH)?
        } else {
            row as u32
        };
        self.radius(values[RADIUS])?;
        self.shuffled |= birth as usize != row;
        self.births.push(birth);
        let [x, y, z, nx, ny, nz, .., u, v, probability, _, _] = *values;
        let table = &mut self.elements;
        table.positions.push([x, y, z]);
        table.normals.push([nx, ny, nz].map(|n| n as f32));
        table.parent.push(match values[PARENT] {
            -1.0 => -1,
            _ => index(PARENT)? as i32,
        });
        table.colony.push(index(COLONY)?);
        table.triangle.push(index(TRIANGLE)?);
        table.uv.push([u as f32, v as f32]);
        table.probability.push(probability as f32);
        if let Some(source) = &mut table.source_triangle {
            source.push(index(SOURCE)?);
        }
        Ok(())
    }

    fn radius(&mut self, radius: f64) -> Result<(), String> {
        if !(radius.is_finite() && radius > 0.0) {
            return Err(format!(
                "radius is {radius}, which is not a positive number"
            ));
        }
        if self.births.is_empty() {
            self.elements.radius = radius;
        }
        if self.elements.radius == radius {
            return Ok(());
        }
        let first = self.elements.radius;
        Err(format!(
            "radius {radius} where the first element has {first}: all must be the same"
        ))
    }

    fn finish(self) -> Result<Elements, String> {
        if !self.shuffled {
            return Ok(self.elements);
        }
        let order = inverse(&self.births)?;
        let e = self.elements;
        Ok(Elements {
            radius: e.radius,
            positions: sorted(&e.positions, &order),
            normals: sorted(&e.normals, &order),
            parent: sorted(&e.parent, &order),
            colony: sorted(&e.colony, &order),
            triangle: sorted(&e.triangle, &order),
            uv: sorted(&e.uv, &order),
            probability: sorted(&e.probability, &order),
            source_triangle: e.source_triangle.map(|column| sorted(&column, &order)),
            attributes: Vec::new(),
        })
    }
}

/// A value that must be a whole number from 0, of the property `NAMES[name]`.
fn whole(value: f64, name: usize, scalar: Option<Scalar>) -> Result<u32, String> {
    const FLOAT_EXACT: f64 = (1 << 24) as f64;
    let name = NAMES[name];
    if scalar == Some(Scalar::F32) && value >= FLOAT_EXACT {
        return Err(format!(
            "{name} is {value}, of type float, which confuses whole numbers from 16777216 on; \
             write it as int"
        ));
    }
    if value.fract() != 0.0 || !(0.0..=f64::from(i32::MAX)).contains(&value) {
        let other = match name == NAMES[PARENT] {
            true => "neither -1 nor",
            false => "not",
        };
        return Err(format!(
            "{name} is {value}, which is {other} a whole number from 0 to 2147483647"
        ));
    }
    Ok(value as u32)
}

/// For each birth index the row that has it.
fn inverse(births: &[u32]) -> Result<Vec<u32>, String> {
    const NONE: u32 = u32::MAX;
    let mut rows = vec![NONE; births.len()];
    for (row, &birth) in births.iter().enumerate() {
        match rows.get_mut(birth as usize) {
            Some(slot) if *slot == NONE => *slot = row as u32,
            Some(_) => return Err(format!("two elements have birth {birth}")),
            None => {}
        }
    }
    match rows.iter().position(|&row| row == NONE) {
        None => Ok(rows),
        Some(birth) => Err(format!(
            "no element has birth {birth}: some were removed; use the file as `thallus grow` wrote it"
        )),
    }
}

fn sorted<T: Copy>(column: &[T], order: &[u32]) -> Vec<T> {
    order.iter().map(|&row| column[row as usize]).collect()
}
