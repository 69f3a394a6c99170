//! Mesh files to [`Soup`], one file a format.
//!
//! The content decides the format where the extension lies. A file is read once; the parsers work
//! on its bytes, except ASCII STL, which is read as a stream. Nothing is allocated on the word of
//! a header: every count is first held against the bytes that are there.

mod detect;
mod error;
mod gltf;
mod gltf_accessor;
mod gltf_buffers;
mod gltf_material;
mod gltf_morph;
mod gltf_primitive;
mod gltf_schema;
mod gltf_skin;
mod meshopt;
mod mtl;
mod obj;
mod ply;
mod ply_body;
mod polygon;
mod stl;
mod text;
mod udim;
mod words;

use std::fmt;
use std::io::{self, BufReader, Read, Seek};
use std::path::Path;

use crate::input::{self, quoted};
use crate::substrate::{Soup, Texturing};

use error::Parsed;
pub use error::{LoadError, LoadFault};
pub use udim::udim_mark;

/// Bytes from the beginning of a file that are enough to tell its format, OBJ excepted.
const HEAD: usize = 1024;

/// A mesh file's format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// Wavefront OBJ.
    Obj,
    /// glTF 2.0, the JSON form.
    Gltf,
    /// glTF 2.0, the binary container.
    Glb,
    /// STL, ASCII or binary.
    Stl,
    /// PLY, ASCII or binary of either byte order.
    Ply,
}

impl fmt::Display for Format {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Self::Obj => "OBJ",
            Self::Gltf => "glTF",
            Self::Glb => "GLB",
            Self::Stl => "STL",
            Self::Ply => "PLY",
        })
    }
}

/// What [`load_soup`] or [`parse_soup`] read.
#[derive(Clone, Debug, PartialEq)]
pub struct Loaded {
    /// The triangles.
    pub soup: Soup,
    /// BLAKE3 in hexadecimal of the file's bytes, followed by those of every external buffer file
    /// that its triangles are read from, in the order of glTF's `buffers`. Equal hashes mean equal
    /// meshes, wherever they lie.
    pub hash: String,
    /// What its content turned out to be, or, of bytes, what it was said to be.
    pub format: Format,
    /// Whether its text, or an OBJ file's libraries, speak of materials that are seen through: [`load_textured`] tells
    /// which.
    pub speaks_of_openings: bool,
}

/// Reads a mesh file of any supported format.
///
/// # Errors
/// When the file (or a buffer file that its triangles need) cannot be read, is malformed, needs an
/// extension that is not supported, or holds no triangles. The error names the file, the place in
/// it and the cure.
pub fn load_soup(path: &Path) -> Result<Loaded, LoadError> {
    load(path, None).map_err(|fault| LoadError::in_file(path, fault))
}

/// Reads a mesh file of any supported format, with what it says about textures.
///
/// # Errors
/// As [`load_soup`], and when texture coordinates are malformed. A material, its library or an image that cannot be
/// read is a note.
pub fn load_textured(path: &Path) -> Result<(Loaded, Texturing), LoadError> {
    let mut texturing = Texturing::default();
    let loaded = load(path, Some(&mut texturing));
    let loaded = loaded.map_err(|fault| LoadError::in_file(path, fault))?;
    Ok((loaded, texturing))
}

/// Reads a mesh from memory, as [`load_soup`] reads one from a file: with the same hash, so that a lichen on
/// the one is a lichen on the other. The format is taken on trust.
///
/// `base` is the folder in which glTF looks for its buffer files; without it they are refused.
///
/// # Errors
/// As [`load_soup`], without the file's name.
pub fn parse_soup(bytes: &[u8], format: Format, base: Option<&Path>) -> Result<Loaded, LoadError> {
    parse_loaded(bytes, format, base, None).map_err(LoadError::from)
}

/// Reads a mesh from memory, with what it says about textures.
///
/// `base` is the folder in which glTF looks for its buffer files, and glTF and OBJ for images and material
/// libraries. Without it buffer files are refused, and the others are notes.
///
/// # Errors
/// As [`load_textured`], without the file's name.
pub fn parse_textured(
    bytes: &[u8],
    format: Format,
    base: Option<&Path>,
) -> Result<(Loaded, Texturing), LoadError> {
    let mut texturing = Texturing::default();
    let loaded = parse_loaded(bytes, format, base, Some(&mut texturing))?;
    Ok((loaded, texturing))
}

fn parse_loaded(
    bytes: &[u8],
    format: Format,
    base: Option<&Path>,
    texturing: Option<&mut Texturing>,
) -> Parsed<Loaded> {
    let mut hasher = blake3::Hasher::new();
    hasher.update(bytes);
    let soup = parse(bytes, format, base, &mut hasher, texturing)?;
    Ok(Loaded {
        soup,
        hash: hasher.finalize().to_hex().to_string(),
        format,
        speaks_of_openings: match format {
            Format::Gltf => gltf_material::speaks_of_openings(bytes),
            Format::Glb => gltf::json_of(bytes).is_some_and(gltf_material::speaks_of_openings),
            Format::Obj => obj::speaks_of_openings(bytes, base),
            Format::Stl | Format::Ply => false,
        },
    })
}

fn parse(
    bytes: &[u8],
    format: Format,
    base: Option<&Path>,
    hasher: &mut blake3::Hasher,
    texturing: Option<&mut Texturing>,
) -> Parsed<Soup> {
    match format {
        Format::Obj => obj::parse(bytes, base, texturing),
        Format::Gltf => gltf::parse_gltf(bytes, base, hasher, texturing),
        Format::Glb => gltf::parse_glb(bytes, base, hasher, texturing),
        Format::Stl => stl::parse(bytes),
        Format::Ply => ply::parse(bytes, texturing),
    }
}

fn load(path: &Path, texturing: Option<&mut Texturing>) -> Parsed<Loaded> {
    let unreadable = |problem: io::Error| LoadFault::Unreadable {
        what: "the file".into(),
        cure: match problem.kind() {
            io::ErrorKind::InvalidInput => "check the path",
            _ => "check the path and the permissions",
        },
        problem,
    };
    let mut file = input::regular(path).map_err(unreadable)?;
    let length = file.metadata().map_err(unreadable)?.len();
    let mut head = Vec::with_capacity(HEAD);
    file.by_ref()
        .take(HEAD as u64)
        .read_to_end(&mut head)
        .map_err(unreadable)?;
    file.rewind().map_err(unreadable)?;

    let named = Format::by_name(path);
    let mut loaded = if detect::is_ascii_stl(&head, length, named) {
        stream_stl(file)?
    } else {
        let mut bytes = Vec::with_capacity(usize::try_from(length).unwrap_or(0));
        file.read_to_end(&mut bytes).map_err(unreadable)?;
        let format = detect::decide(&bytes, named)?;
        parse_loaded(&bytes, format, path.parent(), texturing)?
    };
    let misnamed = detect::misnamed(path, named, loaded.format);
    loaded.soup.notes.extend(misnamed);
    Ok(loaded)
}

fn stream_stl(file: impl Read) -> Parsed<Loaded> {
    let mut hasher = blake3::Hasher::new();
    let hashing = HashingReader {
        file: BufReader::new(file),
        hasher: &mut hasher,
    };
    let soup = stl::parse_ascii(BufReader::with_capacity(1 << 16, hashing))?;
    Ok(Loaded {
        soup,
        hash: hasher.finalize().to_hex().to_string(),
        format: Format::Stl,
        speaks_of_openings: false,
    })
}

/// Hashes what is read through it.
struct HashingReader<'a, R> {
    file: R,
    hasher: &'a mut blake3::Hasher,
}

impl<R: Read> Read for HashingReader<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(buffer)?;
        self.hasher.update(&buffer[..count]);
        Ok(count)
    }
}

/// The error for a file without triangles, saying what it holds instead.
fn no_triangles(points: usize, passed_over: &[String]) -> LoadFault {
    let mut held = passed_over.to_vec();
    if points > 0 && held.is_empty() {
        held.push(counted(points, "point", "points"));
    }
    let held = match held.len() {
        0 => "the file holds neither vertices nor faces".into(),
        _ => format!("the file holds only {}", held.join(", ")),
    };
    LoadFault::NoTriangles { held }
}

/// Refuses bytes that are no image of a kind that is read.
fn encoded_image(bytes: Vec<u8>) -> Result<Vec<u8>, String> {
    let is_known = bytes.starts_with(b"\x89PNG") || bytes.starts_with(b"\xff\xd8");
    let start = quoted(&bytes[..bytes.len().min(12)]);
    is_known
        .then_some(bytes)
        .ok_or_else(|| format!("it is neither PNG nor JPEG (it begins with {start})"))
}

/// A number with its noun.
pub(super) fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

/// Refuses more vertices than a `u32` can count.
fn exclusive_index(vertices: usize, format: Format) -> Parsed<()> {
    if u32::try_from(vertices).is_ok() {
        return Ok(());
    }
    Err(LoadFault::malformed(
        format,
        "the whole file",
        format!("{vertices} vertices are more than 32-bit indices can name"),
        "simplify the mesh",
    ))
}
