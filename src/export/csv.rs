//! CSV: a header and one line an element.
//!
//! Floats are the shortest text that reads back to the same number, always with a point, because
//! Blender takes a column's type from its first value. Positions and radius that came from float32
//! (each value fits it exactly) are written as the shortest text that reads back to that float32:
//! `0.1`, not `0.10000000149011612`.

use std::io::{self, Write};

use super::elements::Row;
use super::{AgeColor, Elements};

const HEADER: &str = "x,y,z,nx,ny,nz,radius,birth,parent,colony,triangle,u,v,probability";

pub(super) fn write(
    elements: &Elements,
    _color: AgeColor<'_>,
    out: &mut dyn Write,
) -> io::Result<()> {
    out.write_all(HEADER.as_bytes())?;
    let source = if elements.source_triangle.is_some() {
        ",source_triangle\n"
    } else {
        "\n"
    };
    out.write_all(source.as_bytes())?;
    let narrow = elements.positions.iter().flatten().all(|&x| is_single(x));
    let narrow_radius = is_single(elements.radius);
    let mut line = Vec::with_capacity(256);
    for row in elements.rows() {
        line.clear();
        push_line(&mut line, &row, narrow, narrow_radius)?;
        out.write_all(&line)?;
    }
    Ok(())
}

fn is_single(x: f64) -> bool {
    f64::from(x as f32) == x
}

fn push_line(line: &mut Vec<u8>, row: &Row, narrow: bool, narrow_radius: bool) -> io::Result<()> {
    for x in row.position {
        push_real(line, x, narrow)?;
    }
    for x in row.normal {
        push_real(line, x.into(), true)?;
    }
    push_real(line, row.radius, narrow_radius)?;
    write!(
        line,
        "{},{},{},{},",
        row.birth, row.parent, row.colony, row.triangle
    )?;
    for x in [row.uv[0], row.uv[1], row.probability] {
        push_real(line, x.into(), true)?;
    }
    match row.source_triangle {
        Some(triangle) => writeln!(line, "{triangle}"),
        None => {
            line.pop();
            writeln!(line)
        }
    }
}

/// Appends the number and a comma.
fn push_real(line: &mut Vec<u8>, x: f64, narrow: bool) -> io::Result<()> {
    let start = line.len();
    match narrow {
        true => write!(line, "{:?}", x as f32)?,
        false => write!(line, "{x:?}")?,
    }
    let text = &line[start..];
    if let (false, Some(e)) = (text.contains(&b'.'), text.iter().position(|&b| b == b'e')) {
        line.splice(start + e..start + e, *b".0");
    }
    line.push(b',');
    Ok(())
}
