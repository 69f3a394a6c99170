//! The table as columns of single numbers, for formats that know nothing wider.

use super::Elements;
use super::elements::Values;

/// A number as files type it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Scalar {
    F64(f64),
    F32(f32),
    I32(i32),
}

impl Scalar {
    /// As float32, exact for whole numbers up to 2²⁴.
    pub(super) fn single(self) -> f32 {
        match self {
            Self::F64(x) => x as f32,
            Self::F32(x) => x,
            Self::I32(x) => x as f32,
        }
    }

    pub(super) fn push(self, bytes: &mut Vec<u8>) {
        match self {
            Self::F64(x) => bytes.extend_from_slice(&x.to_le_bytes()),
            Self::F32(x) => bytes.extend_from_slice(&x.to_le_bytes()),
            Self::I32(x) => bytes.extend_from_slice(&x.to_le_bytes()),
        }
    }
}

/// The type of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    F64,
    F32,
    I32,
}

/// A named column. Its type does not depend on the values, so that tables can be concatenated.
pub(super) struct Column<'a> {
    pub(super) name: String,
    pub(super) kind: Kind,
    get: Box<dyn Fn(usize) -> Scalar + 'a>,
}

impl<'a> Column<'a> {
    fn f64(name: &str, get: impl Fn(usize) -> f64 + 'a) -> Self {
        Self::new(name, Kind::F64, move |i| Scalar::F64(get(i)))
    }

    fn f32(name: &str, get: impl Fn(usize) -> f32 + 'a) -> Self {
        Self::new(name, Kind::F32, move |i| Scalar::F32(get(i)))
    }

    fn i32(name: &str, get: impl Fn(usize) -> i32 + 'a) -> Self {
        Self::new(name, Kind::I32, move |i| Scalar::I32(get(i)))
    }

    fn new(name: &str, kind: Kind, get: impl Fn(usize) -> Scalar + 'a) -> Self {
        Self {
            name: name.to_owned(),
            kind,
            get: Box::new(get),
        }
    }

    /// The value of a row.
    pub(super) fn at(&self, row: usize) -> Scalar {
        (self.get)(row)
    }
}

/// Every column: x, y and z first, attributes last.
pub(super) fn columns(e: &Elements) -> Vec<Column<'_>> {
    let mut columns = vec![
        Column::f64("x", |i| e.positions[i][0]),
        Column::f64("y", |i| e.positions[i][1]),
        Column::f64("z", |i| e.positions[i][2]),
        Column::f32("nx", |i| e.normals[i][0]),
        Column::f32("ny", |i| e.normals[i][1]),
        Column::f32("nz", |i| e.normals[i][2]),
        Column::f64("radius", |_| e.radius),
        Column::i32("birth", |i| i as i32),
        Column::i32("parent", |i| e.parent[i]),
        Column::i32("colony", |i| e.colony[i] as i32),
        Column::i32("triangle", |i| e.triangle[i] as i32),
        Column::f32("u", |i| e.uv[i][0]),
        Column::f32("v", |i| e.uv[i][1]),
        Column::f32("probability", |i| e.probability[i]),
    ];
    columns.extend(source_column(e));
    columns.extend(attribute_columns(e));
    columns
}

/// The triangles' own numbers in the mesh file, where they are known.
pub(super) fn source_column(e: &Elements) -> Option<Column<'_>> {
    let source = e.source_triangle.as_ref()?;
    Some(Column::i32("source_triangle", |i| source[i] as i32))
}

/// The columns of the attributes alone.
pub(super) fn attribute_columns(e: &Elements) -> Vec<Column<'_>> {
    let mut columns = Vec::new();
    for attribute in &e.attributes {
        let name = attribute.name;
        match &attribute.values {
            Values::I32(values) => columns.push(Column::i32(name, |i| values[i])),
            Values::F32(values) => columns.push(Column::f32(name, |i| values[i])),
            Values::Quaternion(values) => {
                for (k, part) in ["x", "y", "z", "w"].into_iter().enumerate() {
                    let name = format!("{name}_{part}");
                    columns.push(Column::f32(&name, move |i| values[i][k]));
                }
            }
        }
    }
    columns
}
