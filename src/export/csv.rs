//! CSV: a header and one line an element.
//!
//! Floats are the shortest text that reads back to the same number, always with a point, because
//! Blender takes a column's type from its first value. Positions and radius that came from float32
//! (each value fits it exactly) are written as the shortest text that reads back to that float32:
//! `0.1`, not `0.10000000149011612`.

use std::io::{self, Write};

use super::columns::{Scalar, columns};
use super::{AgeColor, Elements};

pub(super) fn write(
    elements: &Elements,
    _color: AgeColor<'_>,
    out: &mut dyn Write,
) -> io::Result<()> {
    let columns = columns(elements);
    let names: Vec<&str> = columns.iter().map(|c| c.name.as_str()).collect();
    writeln!(out, "{}", names.join(","))?;
    let narrow_position = elements.positions.iter().flatten().all(|&x| is_single(x));
    let narrow_radius = is_single(elements.radius);
    let narrow = |name: &str| match name {
        "radius" => narrow_radius,
        _ => narrow_position,
    };
    let narrow: Vec<bool> = names.into_iter().map(narrow).collect();
    let mut line = Vec::with_capacity(256);
    for row in 0..elements.len() {
        line.clear();
        for (column, &narrow) in columns.iter().zip(&narrow) {
            push(&mut line, column.at(row), narrow)?;
        }
        line.pop();
        line.push(b'\n');
        out.write_all(&line)?;
    }
    Ok(())
}

fn is_single(x: f64) -> bool {
    f64::from(x as f32) == x
}

/// Appends the number and a comma; a `narrow` f64 as the float32 that it is.
fn push(line: &mut Vec<u8>, value: Scalar, narrow: bool) -> io::Result<()> {
    let start = line.len();
    match value {
        Scalar::I32(x) => write!(line, "{x}")?,
        Scalar::F32(x) => write!(line, "{x:?}")?,
        Scalar::F64(x) if narrow => write!(line, "{:?}", x as f32)?,
        Scalar::F64(x) => write!(line, "{x:?}")?,
    }
    let text = &line[start..];
    if let (false, Some(e)) = (text.contains(&b'.'), text.iter().position(|&b| b == b'e')) {
        line.splice(start + e..start + e, *b".0");
    }
    line.push(b',');
    Ok(())
}
