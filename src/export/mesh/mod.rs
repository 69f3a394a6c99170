//! A triangle mesh with colours and named attributes, and the formats that it is written in.

pub(super) mod glb;
mod obj;
mod ply;
mod stance;
mod textured;
pub(super) mod usda;
mod worn;

use std::io::{self, BufWriter, Write};
use std::path::Path;

use glam::DVec3;

pub use stance::Stance;
pub use textured::{
    MapImages, SurfaceLook, TexturedMaterial, TexturedMesh, TexturedObject, TexturedScene,
};

use super::ply::HALF_ULP;
use super::{Axes, Extension, Placement, UnknownFormat, UpAxis, by_extension, check_unit};

/// A number for each vertex.
#[derive(Clone, Debug, PartialEq)]
pub struct VertexAttribute {
    /// Its name in files: lower-case ASCII letters and underscores.
    pub name: &'static str,
    /// In the order of the vertices.
    pub values: Vec<f32>,
    /// Whether the values are lengths, which are scaled as positions are.
    pub is_length: bool,
}

/// Triangles with shared vertices. All columns have a row for each vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    /// What its object is called in GLB and OBJ: `lichen`, where it has no name.
    pub name: Option<String>,
    /// In the units and axes of the substrate's file until it is [placed](TriMesh::place).
    pub positions: Vec<[f64; 3]>,
    /// Unit vectors, outwards.
    pub normals: Vec<[f32; 3]>,
    /// sRGB.
    pub colors: Vec<[u8; 3]>,
    /// Whatever else is known of the vertices.
    pub attributes: Vec<VertexAttribute>,
    /// Numbers of vertices, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Which axis of `positions` points up.
    pub up: UpAxis,
    /// Where files with 32-bit positions and a translation put their own origin: none to choose by these positions
    /// alone. See [`TriMesh::lie_with`].
    pub fixed_origin: Option<[f64; 3]>,
}

/// What makes a mesh unfit to be written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A column is longer or shorter than `positions`.
    #[error("column '{column}' has {found} rows where there are {expected} vertices")]
    Ragged {
        /// Its name.
        column: &'static str,
        /// Its rows.
        found: usize,
        /// Rows of `positions`.
        expected: usize,
    },
    /// A triangle names a vertex that is not there.
    #[error("triangle {0} has a corner that is not a vertex")]
    Corner(usize),
    /// A coordinate that is not a finite number.
    #[error("vertex {0} is not at a finite place")]
    Place(usize),
    /// A direction or an attribute that is not a finite number.
    #[error("{column} of vertex {vertex} is not a finite number")]
    Value {
        /// Its column.
        column: &'static str,
        /// The vertex.
        vertex: usize,
    },
    /// An origin that is not finite.
    #[error("its origin is not at a finite place")]
    Origin,
    /// Lengths that attributes and most files cannot say.
    #[error("its lengths are beyond what 32-bit numbers hold: bring them nearer to 1 with --scale")]
    Range,
    /// More than files count.
    #[error("{0} vertices or triangles: files count them with 31 bits; make the mesh coarser")]
    TooMany(usize),
}

impl TriMesh {
    /// What its object is called, in a line.
    fn object(&self) -> String {
        let name = self.name.as_deref().unwrap_or("lichen");
        name.replace(char::is_control, " ")
    }
}

type WriteMesh = fn(&TriMesh, f64, &mut dyn Write) -> io::Result<()>;

/// A file format for triangle meshes.
#[derive(Clone, Copy, Debug)]
pub struct MeshFormat {
    /// Extension of its files, lower case, without the dot.
    pub extension: &'static str,
    /// What it is for, in words for the user.
    pub purpose: &'static str,
    /// Which way is up.
    pub axes: Axes,
    /// Whether its unit is the metre by specification.
    pub metres: bool,
    write: WriteMesh,
}

/// Every format that triangle meshes are written in.
pub const MESH_FORMATS: &[MeshFormat] = &[
    MeshFormat {
        extension: "glb",
        purpose: "glTF with colours and attributes, in metres: Blender, game engines, viewers",
        axes: Axes::Fixed(UpAxis::Y),
        metres: true,
        write: |mesh, _, out| glb::write(mesh, out),
    },
    USDA,
    MeshFormat {
        extension: "usd",
        purpose: "the same under its other name",
        ..USDA
    },
    MeshFormat {
        extension: "ply",
        purpose: "binary, with colours and attributes: Blender, MeshLab, Python",
        axes: Axes::Usual(UpAxis::Z),
        metres: false,
        write: |mesh, _, out| ply::write(mesh, out),
    },
    MeshFormat {
        extension: "obj",
        purpose: "text, with colours but without attributes: nearly everything",
        axes: Axes::Usual(UpAxis::Y),
        metres: false,
        write: |mesh, _, out| obj::write(mesh, out),
    },
];

const USDA: MeshFormat = MeshFormat {
    extension: "usda",
    purpose: "USD with colours and attributes: Houdini, Blender, usdview",
    axes: Axes::Declared,
    metres: false,
    write: usda::write,
};

impl Extension for MeshFormat {
    fn extension(&self) -> &'static str {
        self.extension
    }
}

/// The format that a file's extension says, upper or lower case.
///
/// # Errors
/// When there is no extension or no such format; the message names those that there are.
pub fn mesh_format_of(path: &Path) -> Result<&'static MeshFormat, UnknownFormat> {
    by_extension(MESH_FORMATS, "meshes", path)
}

impl MeshFormat {
    /// Writes the mesh as it is placed, buffered: the same mesh gives the same bytes. USD says how
    /// many metres its unit is; glTF has metres by specification, so [place](TriMesh::place) other units by a scale,
    /// and the other formats have no unit.
    ///
    /// # Errors
    /// Those of `out`; `InvalidData` around a [`MeshError`] when the mesh is not sound;
    /// `InvalidInput` when the format cannot hold that much or has [another axis up](Self::axes), or the unit is no
    /// positive number of metres.
    pub fn write(
        &self,
        mesh: &TriMesh,
        meters_per_unit: f64,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        check_unit(meters_per_unit)?;
        mesh.check()
            .map_err(|e| io::Error::new(io::ErrorKind::InvalidData, e))?;
        if matches!(self.axes, Axes::Fixed(up) if up != mesh.up) {
            let problem = "the format has another axis up than the mesh: place the mesh first";
            return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
        }
        let mut out = BufWriter::with_capacity(1 << 16, out);
        (self.write)(mesh, meters_per_unit, &mut out)?;
        out.flush()
    }
}

/// Refuses what is no number.
fn finite<const N: usize>(column: &'static str, values: &[[f32; N]]) -> Result<(), MeshError> {
    let wrong = |value: &[f32; N]| value.iter().any(|x| !x.is_finite());
    match values.iter().position(wrong) {
        Some(vertex) => Err(MeshError::Value { column, vertex }),
        None => Ok(()),
    }
}

impl TriMesh {
    /// Checks what every file promises: columns of one length, finite numbers, places in the range of 32-bit
    /// ones, corners that are vertices, numbers that fit a signed 32-bit integer.
    ///
    /// # Errors
    /// The first that does not hold.
    pub fn check(&self) -> Result<(), MeshError> {
        let columns = [("normal", self.normals.len()), ("color", self.colors.len())];
        let named = self.attributes.iter().map(|a| (a.name, a.values.len()));
        self.check_with(columns.into_iter().chain(named))?;
        finite("normal", &self.normals)?;
        let mut named = self.attributes.iter();
        named.try_for_each(|a| finite(a.name, a.values.as_chunks::<1>().0))
    }

    /// Checks the same of places, triangles and columns of these names and lengths.
    fn check_with(
        &self,
        columns: impl IntoIterator<Item = (&'static str, usize)>,
    ) -> Result<(), MeshError> {
        let expected = self.positions.len();
        for (column, found) in columns {
            if found != expected {
                return Err(MeshError::Ragged {
                    column,
                    found,
                    expected,
                });
            }
        }
        let most = expected.max(self.triangles.len());
        if i32::try_from(most).is_err() {
            return Err(MeshError::TooMany(most));
        }
        let finite = |p: &[f64; 3]| p.iter().all(|x| x.is_finite());
        if let Some(vertex) = self.positions.iter().position(|p| !finite(p)) {
            return Err(MeshError::Place(vertex));
        }
        if !self.fits_single() {
            return Err(MeshError::Range);
        }
        if !self.fixed_origin.iter().flatten().all(|x| x.is_finite()) {
            return Err(MeshError::Origin);
        }
        let there = |t: &[u32; 3]| t.iter().all(|&v| (v as usize) < expected);
        let stray = self.triangles.iter().position(|t| !there(t));
        stray.map_or(Ok(()), |triangle| Err(MeshError::Corner(triangle)))
    }

    /// Whether float32, which attributes and most formats have, can say its places and tell them apart,
    /// with room for sums of them: what a scene is asked too.
    fn fits_single(&self) -> bool {
        let range = f64::from(f32::MIN_POSITIVE)..f64::from(f32::MAX) / 16.0;
        let [low, high] = self.bounds();
        let size = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
        let mut ends = low.iter().chain(&high);
        (size == 0.0 || size >= range.start) && ends.all(|x| x.abs() < range.end)
    }

    /// Turns and scales the mesh into the axes and units of a file.
    pub fn place(&mut self, placement: &Placement) {
        let turned = self.positions.iter_mut();
        turned.for_each(|p| *p = placement.point(*p));
        let turned = self.normals.iter_mut();
        turned.for_each(|n| *n = placement.turn(*n));
        let lengths = self.attributes.iter_mut().filter(|a| a.is_length);
        let scaled = |x: &mut f32| *x = (f64::from(*x) * placement.scale) as f32;
        lengths.for_each(|a| a.values.iter_mut().for_each(scaled));
        self.fixed_origin = self.fixed_origin.map(|origin| placement.point(origin));
        self.up = placement.to;
    }

    /// Gives it the origin in files that another mesh has: so the frames of an animation have one, whatever there is in
    /// each.
    pub fn lie_with(&mut self, whole: &TriMesh) {
        self.fixed_origin = Some(whole.origin());
    }

    /// What files with float32 positions and a translation store positions relative to.
    pub(super) fn origin(&self) -> [f64; 3] {
        if let Some(origin) = self.fixed_origin {
            return origin;
        }
        let [low, high] = self.bounds();
        match self.needs_doubles() {
            true => [0, 1, 2].map(|k| 0.5 * low[k] + 0.5 * high[k]),
            false => [0.0; 3],
        }
    }

    /// Lower and upper corner of the bounding box; zeros when there are no vertices.
    pub fn bounds(&self) -> [[f64; 3]; 2] {
        bounds(self.positions.iter().copied())
    }

    /// What it holds, in cubes of its unit, if it is closed; less than 0 if its triangles look inwards.
    ///
    /// # Panics
    /// When a corner is no vertex.
    pub fn volume(&self) -> f64 {
        volume(&self.positions, &self.triangles)
    }

    fn needs_doubles(&self) -> bool {
        needs_doubles(self.bounds())
    }
}

/// The same of closed triangles with these corners.
pub(crate) fn volume(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> f64 {
    let origin = positions.first().map_or(DVec3::ZERO, |&p| p.into());
    let corner = |v: u32| DVec3::from(positions[v as usize]) - origin;
    let six_times = |&[a, b, c]: &[u32; 3]| corner(a).cross(corner(b)).dot(corner(c));
    triangles.iter().map(six_times).sum::<f64>() / 6.0
}

/// Lower and upper corner of the box about places; zeros when there are none.
fn bounds(places: impl Iterator<Item = [f64; 3]>) -> [[f64; 3]; 2] {
    let join = |[low, high]: [[f64; 3]; 2], [a, b]: [[f64; 3]; 2]| {
        let low = [0, 1, 2].map(|k| low[k].min(a[k]));
        [low, [0, 1, 2].map(|k| high[k].max(b[k]))]
    };
    places.map(|p| [p; 2]).reduce(join).unwrap_or_default()
}

/// Whether float32 would move vertices between these corners by more than a millionth of the mesh's size, as it does
/// where a small mesh lies far from its origin.
fn needs_doubles([low, high]: [[f64; 3]; 2]) -> bool {
    let size = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
    let ends = low.iter().chain(&high);
    let farthest = ends.fold(0.0, |m: f64, x| m.max(x.abs()));
    farthest * HALF_ULP > size * 1e-6 || farthest > f64::from(f32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(size: f64) -> TriMesh {
        TriMesh {
            positions: vec![[0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0]],
            normals: vec![[0.0, 0.0, 1.0]; 3],
            colors: vec![[9; 3]; 3],
            triangles: vec![[0, 1, 2]],
            ..TriMesh::default()
        }
    }

    fn textured(size: f64) -> TexturedMesh {
        let colors = Vec::new();
        TexturedMesh {
            shape: TriMesh {
                colors,
                ..triangle(size)
            },
            uvs: vec![[0.0; 2]; 3],
            tangents: vec![[1.0, 0.0, 0.0, 1.0]; 3],
            ..TexturedMesh::default()
        }
    }

    #[test]
    fn numbers_that_are_none_are_refused() {
        let mut mesh = triangle(1.0);
        mesh.attributes = vec![VertexAttribute {
            name: "density",
            values: vec![0.5; 3],
            is_length: false,
        }];
        assert_eq!(mesh.check(), Ok(()));
        let at = |column, vertex| Err(MeshError::Value { column, vertex });
        mesh.attributes[0].values[2] = f32::NAN;
        assert_eq!(mesh.check(), at("density", 2));
        mesh.normals[1][0] = f32::INFINITY;
        assert_eq!(mesh.check(), at("normal", 1));
    }

    fn write_glb(mesh: &TexturedMesh, out: &mut Vec<u8>) -> io::Result<()> {
        let mut scene = TexturedScene::default();
        let object = TexturedObject::default();
        scene.add(TexturedMaterial::default(), vec![(object, mesh.clone())]);
        scene.write_glb(out)
    }

    fn said(written: io::Result<()>, out: &[u8]) -> Option<String> {
        let error = written.err()?;
        assert_eq!(error.kind(), io::ErrorKind::InvalidData);
        assert!(out.is_empty(), "nothing is begun");
        Some(error.to_string())
    }

    #[test]
    fn lengths_that_float32_cannot_say_are_refused() {
        for (size, fits) in [
            (1e-60, false),
            (1e-30, true),
            (1e30, true),
            (1e38, false),
            (1e40, false),
        ] {
            let mut found = Vec::new();
            for format in MESH_FORMATS {
                let mut out = Vec::new();
                let written = format.write(&triangle(size), 1.0, &mut out);
                found.push(said(written, &out));
            }
            let mut out = Vec::new();
            let written = write_glb(&textured(size), &mut out);
            found.push(said(written, &out));
            let is_right = |said: &Option<String>| match said {
                None => fits,
                Some(said) => !fits && said.contains("32-bit") && said.contains("--scale"),
            };
            assert!(found.iter().all(is_right), "{size}: {found:?}");
        }
    }

    /// A format that is y-up by specification cannot say that this is not.
    #[test]
    fn meshes_with_another_axis_up_are_refused_where_a_file_cannot_say_so() {
        let mut mesh = triangle(1.0);
        mesh.up = UpAxis::Z;
        for format in MESH_FORMATS {
            let mut out = Vec::new();
            let written = format.write(&mesh, 1.0, &mut out).map_err(|e| e.kind());
            let refused = Err(io::ErrorKind::InvalidInput);
            let expected = if format.extension == "glb" {
                refused
            } else {
                Ok(())
            };
            assert_eq!((written, out.is_empty()), (expected, expected.is_err()));
        }
    }

    #[test]
    fn textured_meshes_are_checked_column_by_column() {
        let mut mesh = textured(1.0);
        mesh.uvs.pop();
        let mut out = Vec::new();
        let written = write_glb(&mesh, &mut out);
        assert!(said(written, &out).is_some_and(|said| said.contains("'uv' has 2 rows")));
        let [mut normal, mut uv, mut tangent] = [1.0; 3].map(textured);
        normal.shape.normals[1][2] = f32::NAN;
        uv.uvs[1][0] = f32::INFINITY;
        tangent.tangents[1][3] = f32::NAN;
        for (column, mesh) in [("normal", normal), ("uv", uv), ("tangent", tangent)] {
            assert_eq!(mesh.check(), Err(MeshError::Value { column, vertex: 1 }));
        }
    }

    /// Empty meshes, and those of one place, are in range.
    #[test]
    fn meshes_without_a_size_are_sound() {
        assert_eq!(TriMesh::default().check(), Ok(()));
        assert_eq!(triangle(0.0).check(), Ok(()));
    }
}
