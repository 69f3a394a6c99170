//! Which format a file is in: its content says, its extension only suggests.

use std::path::Path;

use super::error::{LoadFault, Parsed};
use super::{Format, HEAD, obj, stl};
use crate::input::without_mark;
use crate::ply;

impl Format {
    /// The format that a file's name claims.
    pub fn by_name(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "obj" => Some(Self::Obj),
            "gltf" => Some(Self::Gltf),
            "glb" => Some(Self::Glb),
            "stl" => Some(Self::Stl),
            "ply" => Some(Self::Ply),
            _ => None,
        }
    }
}

/// Whether the file should be streamed as ASCII STL.
pub(super) fn is_ascii_stl(head: &[u8], length: u64, named: Option<Format>) -> bool {
    let ascii = stl::encoding(head, length) == stl::Encoding::Ascii;
    // A text that begins with the word 'solid' may be anything; without the name of an STL file it
    // must also go on like one.
    let goes_on = || {
        let text = head.to_ascii_lowercase();
        contains(&text, b"facet") || contains(&text, b"endsolid")
    };
    ascii && (named == Some(Format::Stl) || goes_on())
}

/// The format to read the bytes as.
///
/// # Errors
/// When neither the content nor the name fits a format.
pub(super) fn decide(bytes: &[u8], named: Option<Format>) -> Parsed<Format> {
    if bytes.trim_ascii().is_empty() {
        let found = if bytes.is_empty() {
            "the file is empty"
        } else {
            "the file is blank"
        };
        return unknown(found, "export or copy it again");
    }
    if let Some(format) = by_content(bytes) {
        return Ok(format);
    }
    if is_utf16(bytes) {
        return unknown(
            "this is UTF-16 text",
            "save it as UTF-8 or ASCII, in an editor or with `iconv -f UTF-16 -t UTF-8`",
        );
    }
    if bytes.starts_with(b"version https://git-lfs") {
        return unknown(
            "a git-LFS pointer, the mesh was not fetched",
            "run `git lfs pull`",
        );
    }
    let cure = "give it an OBJ, glTF, GLB, STL or PLY file, or export the model as one";
    if let Some(other) = recognised(bytes) {
        return unknown(other, cure);
    }
    let is_binary = bytes[..bytes.len().min(HEAD)].contains(&0);
    match named {
        Some(Format::Obj) if is_binary => unknown("this is not text, as OBJ is", cure),
        Some(Format::Obj) => Ok(Format::Obj),
        _ if !is_binary && obj::looks_like(bytes) => Ok(Format::Obj),
        Some(format) => Ok(format),
        None => unknown("neither its name nor its content is known", cure),
    }
}

/// The format that the content proves.
fn by_content(bytes: &[u8]) -> Option<Format> {
    let head = &bytes[..bytes.len().min(HEAD)];
    if head.starts_with(b"glTF") {
        return Some(Format::Glb);
    }
    if ply::is_begun(head) {
        return Some(Format::Ply);
    }
    if stl::is_exact_binary(head, bytes.len() as u64) {
        return Some(Format::Stl);
    }
    let text = without_mark(bytes).trim_ascii_start();
    (text.starts_with(b"{") && contains(text, b"\"asset\"")).then_some(Format::Gltf)
}

/// Whether it begins with the byte order mark of UTF-16 and a plain character.
fn is_utf16(bytes: &[u8]) -> bool {
    match bytes {
        [0xFF, 0xFE, plain, 0, ..] | [0xFE, 0xFF, 0, plain, ..] => plain.is_ascii() && *plain > 0,
        _ => false,
    }
}

/// A note where the name and the content disagree.
pub(super) fn misnamed(path: &Path, named: Option<Format>, format: Format) -> Option<String> {
    let named = named.filter(|named| *named != format)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    Some(format!(
        "{name} is named as {named} but holds {format}: read as {format}"
    ))
}

fn unknown<T>(found: &str, cure: &'static str) -> Parsed<T> {
    Err(LoadFault::UnknownFormat {
        found: found.into(),
        cure,
    })
}

/// A file of another kind that people try to load.
fn recognised(bytes: &[u8]) -> Option<&'static str> {
    const TAR: usize = 257;
    if bytes
        .get(TAR..)
        .is_some_and(|rest| rest.starts_with(b"ustar"))
    {
        return Some("this is a tar archive");
    }
    let bytes = without_mark(bytes);
    let known: [(&[u8], &str); 18] = [
        (b"Kaydara FBX", "this is FBX"),
        (b"; FBX", "this is FBX"),
        (b"BLENDER", "this is a Blender file"),
        (b"PXR-USDC", "this is USD"),
        (b"#usda", "this is USD"),
        (b"PK\x03\x04", "this is a ZIP archive"),
        (b"7z\xBC\xAF\x27\x1C", "this is a 7z archive"),
        (b"Rar!", "this is a RAR archive"),
        (b"\x1f\x8b", "this is compressed with gzip"),
        (
            b"\x28\xB5\x2F\xFD",
            "this is compressed with Zstandard, as Blender files are",
        ),
        (b"OFF", "this is OFF"),
        (b"COFF", "this is OFF"),
        (b"CNOFF", "this is OFF"),
        (b"NOFF", "this is OFF"),
        (b"ISO-10303-21", "this is STEP"),
        (b"#VRML", "this is VRML"),
        (b"LASF", "this is a LAS point cloud"),
        (b"<", "this is XML or HTML"),
    ];
    known
        .iter()
        .find(|(magic, _)| bytes.starts_with(magic))
        .map(|(_, what)| *what)
}

pub(super) fn contains(text: &[u8], word: &[u8]) -> bool {
    text.windows(word.len()).any(|window| window == word)
}
