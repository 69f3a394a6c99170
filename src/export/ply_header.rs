//! The header of a table of elements: that of a PLY file whose first element is the vertices, a number a property.

use std::io::{BufRead, Read};

use crate::input::quoted;
use crate::ply::{Element, Encoding, HeaderFault, Kind, Property, Scalar, read_header};

/// Longest header read: far above any real one, and a bound on what garbage can cost.
const MAX_HEADER: u64 = 1 << 20;

/// Most properties of a table.
const MOST_PROPERTIES: usize = 1024;

#[derive(Debug)]
pub(super) struct Column {
    pub(super) name: Vec<u8>,
    pub(super) scalar: Scalar,
}

#[derive(Debug)]
pub(super) struct TableHeader {
    pub(super) encoding: Encoding,
    /// Number of vertices that the file says it has.
    pub(super) count: usize,
    pub(super) columns: Vec<Column>,
    /// The fewest bytes that a row can take.
    pub(super) least: usize,
    /// Whether other elements follow the vertices.
    pub(super) more: bool,
    /// Lines that the header takes.
    pub(super) lines: usize,
}

/// Reads up to and with the line `end_header`.
pub(super) fn read(input: &mut dyn BufRead) -> Result<TableHeader, HeaderFault> {
    let mut limited = input.take(MAX_HEADER);
    let header = read_header(&mut limited).map_err(|fault| HeaderFault {
        problem: match (fault.line, limited.limit()) {
            (1, _) => format!(
                "this is no table of elements: {}; give the folder of a run, or its elements.ply",
                fault.problem
            ),
            (_, 0) => "no 'end_header' in the first MiB: this is not a PLY file".to_owned(),
            _ => fault.problem,
        },
        ..fault
    });
    let header = header?;
    let more = header.elements.len() > 1;
    let vertices = header.elements.into_iter().next();
    let vertices = vertices.ok_or(HeaderFault {
        line: header.lines,
        problem: "no line 'element vertex …' before it".to_owned(),
    })?;
    check(&vertices)?;
    let least = vertices.least_bytes(header.encoding);
    let columns = vertices.properties.into_iter().map(Column::of);
    Ok(TableHeader {
        encoding: header.encoding,
        count: vertices.count,
        columns: columns.collect::<Result<_, _>>()?,
        least,
        more,
        lines: header.lines,
    })
}

impl Column {
    fn of(property: Property) -> Result<Self, HeaderFault> {
        let Property { name, kind, line } = property;
        match kind {
            Kind::One(scalar) => Ok(Self { name, scalar }),
            Kind::List { .. } => Err(HeaderFault {
                line,
                problem: format!("{} is a list, which elements do not have", quoted(&name)),
            }),
        }
    }
}

/// Refuses what cannot be the vertices of a table.
fn check(element: &Element) -> Result<(), HeaderFault> {
    let fault = |line, problem| Err(HeaderFault { line, problem });
    if element.name != b"vertex" {
        let name = quoted(&element.name);
        return fault(element.line, format!("{name} comes before the vertices"));
    }
    if element.count > i32::MAX as usize {
        let problem = "the number of vertices is not one up to 2147483647";
        return fault(element.line, problem.to_owned());
    }
    let properties = &element.properties;
    if let Some(beyond) = properties.get(MOST_PROPERTIES) {
        let problem = format!("more than {MOST_PROPERTIES} properties");
        return fault(beyond.line, problem);
    }
    let is_second = |(at, one): &(usize, &Property)| element.position(&one.name) != Some(*at);
    match properties.iter().enumerate().find(is_second) {
        Some((_, twice)) => {
            let name = quoted(&twice.name);
            fault(twice.line, format!("property {name} is there twice"))
        }
        None => Ok(()),
    }
}
