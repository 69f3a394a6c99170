//! Finished values to bytes: one file a format, a table of formats, and outputs that appear
//! complete or not at all.
//!
//! [`Elements`] is the finished table. Each of [`FORMATS`] turns it into bytes, streaming, as a
//! pure function: the same table gives the same bytes. [`read_elements`] takes `elements.ply`
//! back. A [`Scene`] is the table with what was measured on it, placed in the axes and units of the
//! program that it is for; each of [`SCENE_FORMATS`] writes it as points, instances or curves. A
//! [`TriMesh`] is written by each of [`MESH_FORMATS`].
//! [`Film`] takes the frames of a growing lichen into one file.
//! [`OutputDir`] and [`write_file_atomically`] put bytes on disk; [`discard_unfinished_files`] is for who cannot wait.
//!
//! Nothing here knows of growth or of runs.

mod atomic;
pub(crate) mod base64;
mod columns;
mod csv;
mod elements;
mod file_id;
mod film;
mod from_cluster;
mod glb;
mod gltf;
mod lobe;
mod mesh;
mod moment;
mod npy;
mod npz;
mod obj;
mod on_mesh;
mod output_dir;
mod output_error;
mod parquet;
mod ply;
mod ply_header;
mod ply_read;
mod pov;
mod rows;
mod scene;
mod scene_format;
mod table;
mod texture;
mod usda;

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

pub use crate::substrate::UpAxis;
pub use atomic::{discard_unfinished_files, write_file_atomically};
pub(crate) use elements::LENGTHS;
pub use elements::{Attribute, Elements, TableError, Values};
pub(crate) use file_id::FileId;
pub use film::{FILM_FORMATS, Film, FilmFormat};
pub(crate) use mesh::volume;
pub use mesh::{
    MESH_FORMATS, MapImages, MeshError, MeshFormat, Stance, SurfaceLook, TexturedMaterial,
    TexturedMesh, TexturedObject, TexturedScene, TriMesh, VertexAttribute, mesh_format_of,
};
pub use on_mesh::NotOnMesh;
pub use output_dir::OutputDir;
pub use output_error::OutputError;
pub use ply_read::{ReadError, parse_elements, read_elements};
pub use scene::{Placement, Scene};
pub use scene_format::{Axes, SCENE_FORMATS, SceneFormat, SceneFormatError, What};
pub use table::{Table, TableColumn, TableValues};
pub use texture::Texture;

/// Colour of an element from its age: 0 for the first born, 1 for the last.
pub type AgeColor<'a> = &'a dyn Fn(f32) -> [u8; 3];

type WriteElements = fn(&Elements, AgeColor<'_>, &mut dyn Write) -> io::Result<()>;

/// A file format for a table of elements.
#[derive(Clone, Copy, Debug)]
pub struct ElementFormat {
    /// Extension of its files, lower case, without the dot.
    pub extension: &'static str,
    /// What it is for, in words for the user.
    pub purpose: &'static str,
    write: WriteElements,
}

/// Every format that elements are written in.
pub const FORMATS: &[ElementFormat] = &[PLY, CSV, NPY, NPZ, PARQUET];

const PLY: ElementFormat = ElementFormat {
    extension: "ply",
    purpose: "points with every attribute: Blender, MeshLab, and thallus itself",
    write: ply::write,
};
const CSV: ElementFormat = ElementFormat {
    extension: "csv",
    purpose: "a header and one line an element: spreadsheets, pandas, R, Blender",
    write: csv::write,
};
const NPY: ElementFormat = ElementFormat {
    extension: "npy",
    purpose: "NumPy structured array, one record an element",
    write: npy::write,
};
const NPZ: ElementFormat = ElementFormat {
    extension: "npz",
    purpose: "NumPy archive, one array an attribute",
    write: npz::write,
};
const PARQUET: ElementFormat = ElementFormat {
    extension: "parquet",
    purpose: "Apache Parquet, one column an attribute: pandas, Polars, DuckDB, R",
    write: parquet::write,
};

/// A file name that says no known format.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {}; name the file with one of {}", .path.display(), says(.path, .of), .names)]
pub struct UnknownFormat {
    /// The name as given.
    pub path: PathBuf,
    /// What was to be written.
    of: &'static str,
    /// The extensions that it can be written with.
    names: String,
}

fn says(path: &Path, of: &str) -> String {
    match path.extension() {
        Some(extension) => format!("'.{}' is not a format for {of}", extension.display()),
        None => "the name has no extension to say the format".to_owned(),
    }
}

/// A row of a table of formats.
trait Extension {
    fn extension(&self) -> &'static str;
}

impl Extension for ElementFormat {
    fn extension(&self) -> &'static str {
        self.extension
    }
}

/// Extensions of formats, as a message lists them.
fn dotted<'a, F: Extension + 'a>(formats: impl Iterator<Item = &'a F>) -> String {
    let dotted: Vec<_> = formats.map(|f| format!(".{}", f.extension())).collect();
    dotted.join(", ")
}

/// The format of a table that a file's extension says, upper or lower case.
fn by_extension<F: Extension>(
    formats: &'static [F],
    of: &'static str,
    path: &Path,
) -> Result<&'static F, UnknownFormat> {
    let extension = path.extension().and_then(|e| e.to_str());
    let named = |f: &&F| extension.is_some_and(|e| e.eq_ignore_ascii_case(f.extension()));
    formats.iter().find(named).ok_or_else(|| UnknownFormat {
        path: path.to_owned(),
        of,
        names: dotted(formats.iter()),
    })
}

/// The format that a file's extension says, upper or lower case.
///
/// # Errors
/// When there is no extension or no such format; the message names those that there are.
pub fn format_of(path: &Path) -> Result<&'static ElementFormat, UnknownFormat> {
    by_extension(FORMATS, "elements", path)
}

/// Refuses a unit that has no length.
fn check_unit(meters_per_unit: f64) -> io::Result<()> {
    let is_length = meters_per_unit > 0.0 && meters_per_unit.is_finite();
    match is_length {
        true => Ok(()),
        false => Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            format!("a unit is a positive number of metres, not {meters_per_unit}"),
        )),
    }
}

impl ElementFormat {
    /// Writes the table, buffered, with memory that does not depend on its length.
    ///
    /// Only formats that carry colours (ply) call `color`.
    ///
    /// # Errors
    /// Those of `out`; `InvalidData` around a [`TableError`] when the table is not sound;
    /// `InvalidInput` when the format cannot hold that many elements.
    pub fn write(
        &self,
        elements: &Elements,
        color: AgeColor<'_>,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        elements
            .check()
            .map_err(|e| io::Error::new(io::ErrorKind::InvalidData, e))?;
        let mut out = BufWriter::with_capacity(1 << 16, out);
        (self.write)(elements, color, &mut out)?;
        out.flush()
    }
}
