//! The finished table of elements, a column an attribute.

use std::ops::RangeInclusive;

/// Lengths whose squares are numbers, and what they are divided by too.
pub(crate) const LENGTHS: RangeInclusive<f64> = 1e-150..=1e150;

/// Elements in birth order: row i was born i-th.
///
/// All columns have the same length. Lengths and positions are in the mesh file's own units
/// and axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Elements {
    /// Radius of every element. Files repeat it in each row.
    pub radius: f64,
    /// Centres, on the surface.
    pub positions: Vec<[f64; 3]>,
    /// Unit normals of the surface at the centres.
    pub normals: Vec<[f32; 3]>,
    /// Birth index of the element that this one stuck to; −1 for a seed.
    pub parent: Vec<i32>,
    /// Which seed's descendants it belongs to.
    pub colony: Vec<u32>,
    /// Triangle that holds the centre, by its [canonical
    /// number](crate::substrate::Substrate::canonical_triangle). That is not the number that a
    /// [`SurfacePoint`](crate::substrate::SurfacePoint) has: [`places_on`](Self::places_on) gives those.
    pub triangle: Vec<u32>,
    /// Barycentric weights of that triangle's second and third corner.
    pub uv: Vec<[f32; 2]>,
    /// Sticking probability at joining: P_s, times the factor of a grey mask.
    pub probability: Vec<f32>,
    /// Number of the triangle in the mesh file, from 0. Not in `elements.ply`; the other formats
    /// have it when it is known.
    pub source_triangle: Option<Vec<u32>>,
    /// Columns beyond these, in the order in which files have them.
    pub attributes: Vec<Attribute>,
}

/// A named column, one value an element.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    /// Name in files: an identifier that no other column has.
    pub name: &'static str,
    /// The values.
    pub values: Values,
}

/// The values of an [`Attribute`].
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Whole numbers.
    I32(Vec<i32>),
    /// Numbers.
    F32(Vec<f32>),
    /// Unit quaternions x, y, z, w. Tables have four columns, `NAME_x` to `NAME_w`.
    Quaternion(Vec<[f32; 4]>),
}

impl Values {
    /// Number of rows.
    pub fn len(&self) -> usize {
        match self {
            Self::I32(column) => column.len(),
            Self::F32(column) => column.len(),
            Self::Quaternion(column) => column.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn is_finite(&self, row: usize) -> bool {
        match self {
            Self::I32(_) => true,
            Self::F32(column) => column[row].is_finite(),
            Self::Quaternion(column) => column[row].iter().all(|x| x.is_finite()),
        }
    }
}

/// What is wrong with a value, as the end of a sentence.
pub(super) const INFINITE: &str = "is not a finite number";

/// What makes a table unfit to be written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TableError {
    /// A column is longer or shorter than `positions`.
    #[error("column '{column}' has {found} rows where there are {expected} elements")]
    Ragged {
        /// Its name.
        column: &'static str,
        /// Its rows.
        found: usize,
        /// Rows of `positions`.
        expected: usize,
    },
    /// More elements than a signed 32-bit birth index counts.
    #[error("{0} elements: files number them with 32 bits, which end at 2147483647")]
    TooMany(usize),
    /// The radius is not from 1e-150 to 1e150.
    #[error(
        "the radius must be a positive number, and from 1e-150 to 1e150 to be measured: take another unit"
    )]
    Radius,
    /// A row holds what no element can.
    #[error("element {element}: {column} {problem}")]
    Value {
        /// Birth index.
        element: usize,
        /// Column.
        column: &'static str,
        /// What is wrong, as the end of a sentence.
        problem: &'static str,
    },
    /// The origin of a [`Scene`](super::Scene) is not finite.
    #[error("its origin is not at a finite place")]
    Origin,
    /// A stream of a [`Scene`](super::Scene) has an element that is none.
    #[error("stream {0} leads through an element that there is not")]
    Stream(usize),
}

/// One element with its values as files type them.
pub(super) struct Row {
    pub(super) position: [f64; 3],
    pub(super) normal: [f32; 3],
    pub(super) radius: f64,
    pub(super) birth: i32,
    pub(super) parent: i32,
    pub(super) colony: i32,
    pub(super) triangle: i32,
    pub(super) uv: [f32; 2],
    pub(super) probability: f32,
    pub(super) source_triangle: Option<i32>,
}

impl Elements {
    /// Number of elements.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Checks what every file promises: columns of one length, finite numbers, a positive radius
    /// (unless empty), lengths that can be measured, from 1e-150 to 1e150, parents born before their children, and
    /// indices that fit a signed 32-bit integer.
    ///
    /// # Errors
    /// The first that does not hold.
    pub fn check(&self) -> Result<(), TableError> {
        self.check_lengths()?;
        if !(LENGTHS.contains(&self.radius) || self.is_empty()) {
            return Err(TableError::Radius);
        }
        (0..self.len()).try_for_each(|i| self.check_row(i))
    }

    fn check_lengths(&self) -> Result<(), TableError> {
        let expected = self.len();
        let source = self.source_triangle.as_ref().map_or(expected, Vec::len);
        let lengths = [
            ("normal", self.normals.len()),
            ("parent", self.parent.len()),
            ("colony", self.colony.len()),
            ("triangle", self.triangle.len()),
            ("uv", self.uv.len()),
            ("probability", self.probability.len()),
            ("source_triangle", source),
        ];
        let attributes = self.attributes.iter().map(|a| (a.name, a.values.len()));
        let ragged = |&(_, length): &(&str, usize)| length != expected;
        if let Some((column, found)) = lengths.into_iter().chain(attributes).find(ragged) {
            return Err(TableError::Ragged {
                column,
                found,
                expected,
            });
        }
        if i32::try_from(expected).is_err() {
            return Err(TableError::TooMany(expected));
        }
        Ok(())
    }

    fn check_row(&self, element: usize) -> Result<(), TableError> {
        const UNBORN: &str = "must be -1 or an element that was born before";
        const FAR: &str = "is beyond 1e150, where nothing can be measured: take another unit";
        const WIDE: &str = "is beyond 2147483647, the last that files can say";
        let fail = |column, problem| {
            Err(TableError::Value {
                element,
                column,
                problem,
            })
        };
        let position = &self.positions[element];
        let finite = |values: &[f32]| values.iter().all(|x| x.is_finite());
        let numbers = [
            ("position", position.iter().all(|x| x.is_finite())),
            ("normal", finite(&self.normals[element])),
            ("uv", finite(&self.uv[element])),
            ("probability", finite(&[self.probability[element]])),
        ];
        let others = self.attributes.iter();
        let others = others.map(|a| (a.name, a.values.is_finite(element)));
        if let Some((column, _)) = numbers
            .into_iter()
            .chain(others)
            .find(|(_, is_one)| !is_one)
        {
            return fail(column, INFINITE);
        }
        if position.iter().any(|x| x.abs() > *LENGTHS.end()) {
            return fail("position", FAR);
        }
        let parent = self.parent[element];
        if parent < -1 || i64::from(parent) >= element as i64 {
            return fail("parent", UNBORN);
        }
        let fits = |index: u32| i32::try_from(index).is_ok();
        let source = self
            .source_triangle
            .as_ref()
            .map_or(0, |column| column[element]);
        match [self.colony[element], self.triangle[element], source].map(fits) {
            [false, ..] => fail("colony", WIDE),
            [_, false, _] => fail("triangle", WIDE),
            [_, _, false] => fail("source_triangle", WIDE),
            _ => Ok(()),
        }
    }

    /// Age of an element for colouring: 0 for the first born, 1 for the last.
    pub fn age(&self, element: usize) -> f32 {
        let last = self.len().saturating_sub(1).max(1);
        (element as f64 / last as f64) as f32
    }

    /// The rows of a table that [`Elements::check`] accepts.
    pub(super) fn rows(&self) -> impl Iterator<Item = Row> {
        (0..self.len()).map(|i| Row {
            position: self.positions[i],
            normal: self.normals[i],
            radius: self.radius,
            birth: i as i32,
            parent: self.parent[i],
            colony: self.colony[i] as i32,
            triangle: self.triangle[i] as i32,
            uv: self.uv[i],
            probability: self.probability[i],
            source_triangle: self.source_triangle.as_ref().map(|column| column[i] as i32),
        })
    }
}
