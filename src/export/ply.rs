//! `elements.ply`: binary little-endian, one vertex an element, in birth order.

use std::io::{self, Write};

use super::columns::{Column, Kind, attribute_columns, source_column};
use super::elements::Row;
use super::scene::Scene;
use super::{AgeColor, Elements};

/// What a 32-bit float rounds by at most, of its size.
pub(super) const HALF_ULP: f64 = 1.0 / (1 << 24) as f64;

/// Which columns float32 is too narrow for.
pub(super) struct Wide {
    pub(super) positions: bool,
    radius: bool,
}

impl Wide {
    /// Positions are `double` when float32's spacing at the farthest coordinate exceeds a
    /// hundredth of the radius (as UTM coordinates of a small rock do), or its range is too small.
    pub(super) fn of(elements: &Elements) -> Self {
        let farthest = elements
            .positions
            .iter()
            .flatten()
            .fold(0.0, |m: f64, x| m.max(x.abs()));
        let range = f64::from(f32::MIN_POSITIVE)..f64::from(f32::MAX);
        let radius = !elements.is_empty() && !range.contains(&elements.radius);
        let positions =
            radius || farthest >= range.end || farthest * HALF_ULP > elements.radius / 100.0;
        Self { positions, radius }
    }
}

pub(super) fn write(
    elements: &Elements,
    color: AgeColor<'_>,
    out: &mut dyn Write,
) -> io::Result<()> {
    write_columns(elements, &attribute_columns(elements), color, &[], out)
}

/// The same with all that is known about the elements, for another program.
pub(super) fn write_points(
    scene: &Scene,
    color: AgeColor<'_>,
    out: &mut dyn Write,
) -> io::Result<()> {
    let elements = &scene.elements;
    write_columns(elements, &all_columns(elements), color, &[], out)
}

/// The same with an edge from each parent to each child.
pub(super) fn write_curves(
    scene: &Scene,
    color: AgeColor<'_>,
    out: &mut dyn Write,
) -> io::Result<()> {
    let links = scene.streams.iter().flat_map(|s| s.windows(2));
    let edges: Vec<[u32; 2]> = links.map(|pair| [pair[0], pair[1]]).collect();
    let elements = &scene.elements;
    write_columns(elements, &all_columns(elements), color, &edges, out)
}

fn all_columns(elements: &Elements) -> Vec<Column<'_>> {
    let source = source_column(elements).into_iter();
    source.chain(attribute_columns(elements)).collect()
}

fn write_columns(
    elements: &Elements,
    attributes: &[Column<'_>],
    color: AgeColor<'_>,
    edges: &[[u32; 2]],
    out: &mut dyn Write,
) -> io::Result<()> {
    let wide = Wide::of(elements);
    out.write_all(header(elements.len(), &wide, attributes).as_bytes())?;
    if !edges.is_empty() {
        let count = edges.len();
        write!(
            out,
            "element edge {count}\nproperty int vertex1\nproperty int vertex2\n"
        )?;
    }
    out.write_all(b"end_header\n")?;
    let mut record = Vec::with_capacity(96);
    for (i, row) in elements.rows().enumerate() {
        record.clear();
        push_row(&mut record, &row, &wide);
        attributes.iter().for_each(|a| a.at(i).push(&mut record));
        record.extend_from_slice(&color(elements.age(i)));
        out.write_all(&record)?;
    }
    for ends in edges {
        out.write_all(ends.map(u32::to_le_bytes).as_flattened())?;
    }
    Ok(())
}

fn header(count: usize, wide: &Wide, attributes: &[Column<'_>]) -> String {
    let real = |wide| if wide { "double" } else { "float" };
    let (position, radius) = (real(wide.positions), real(wide.radius));
    let version = env!("CARGO_PKG_VERSION");
    let note = if wide.positions {
        "comment x y z are double: float would move elements by more than 1% of their radius\n"
    } else {
        ""
    };
    let attributes: String = attributes.iter().map(property).collect();
    format!(
        "ply\n\
         format binary_little_endian 1.0\n\
         comment thallus {version}: lichen elements in birth order\n\
         {note}\
         element vertex {count}\n\
         property {position} x\n\
         property {position} y\n\
         property {position} z\n\
         property float nx\n\
         property float ny\n\
         property float nz\n\
         property {radius} radius\n\
         property int birth\n\
         property int parent\n\
         property int colony\n\
         property int triangle\n\
         property float u\n\
         property float v\n\
         property float probability\n\
         {attributes}\
         property uchar red\n\
         property uchar green\n\
         property uchar blue\n"
    )
}

fn property(column: &Column<'_>) -> String {
    let kind = match column.kind {
        Kind::F64 => "double",
        Kind::F32 => "float",
        Kind::I32 => "int",
    };
    format!("property {kind} {}\n", column.name)
}

fn push_row(record: &mut Vec<u8>, row: &Row, wide: &Wide) {
    let real = |record: &mut Vec<u8>, x: f64, wide: bool| match wide {
        true => record.extend_from_slice(&x.to_le_bytes()),
        false => record.extend_from_slice(&(x as f32).to_le_bytes()),
    };
    row.position
        .iter()
        .for_each(|&x| real(record, x, wide.positions));
    row.normal
        .iter()
        .for_each(|x| record.extend_from_slice(&x.to_le_bytes()));
    real(record, row.radius, wide.radius);
    for index in [row.birth, row.parent, row.colony, row.triangle] {
        record.extend_from_slice(&index.to_le_bytes());
    }
    for x in [row.uv[0], row.uv[1], row.probability] {
        record.extend_from_slice(&x.to_le_bytes());
    }
}
