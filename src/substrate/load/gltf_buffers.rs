//! glTF buffers and buffer views: where the bytes come from, fetched only when asked for.

use std::cell::{Cell, OnceCell};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::error::{LoadFault, Parsed};
use super::gltf_schema::{Buffer, BufferView, Compressed, Root};
use super::{Format, meshopt};
use crate::input;

/// What to do about a file whose structure is wrong.
pub(super) const EXPORT_AGAIN: &str = "export the file again";

/// Decoded bytes that a file may have for each of its own, and in addition. One compressed byte can stand for a
/// thousand, and many views for the same bytes.
const MOST_DECODED: (usize, usize) = (64, 1 << 27);

/// The bytes of a document's buffers and views, each fetched or decoded once.
pub(super) struct Buffers<'a> {
    root: &'a Root<'a>,
    format: Format,
    /// The binary chunk of a GLB file.
    chunk: Option<&'a [u8]>,
    base: Option<&'a Path>,
    fetched: Vec<OnceCell<Vec<u8>>>,
    decoded: Vec<OnceCell<Vec<u8>>>,
    /// Which of them triangles are read from, and whether something else is being read.
    of_triangles: Vec<Cell<bool>>,
    reads_looks: Cell<bool>,
}

/// The bytes of a buffer view, decompressed.
#[derive(Clone, Copy)]
pub(super) struct View<'v> {
    pub(super) bytes: &'v [u8],
    /// Bytes from one element to the next where the view says so.
    pub(super) stride: Option<usize>,
}

impl<'a> Buffers<'a> {
    pub(super) fn new(
        root: &'a Root<'a>,
        format: Format,
        chunk: Option<&'a [u8]>,
        base: Option<&'a Path>,
    ) -> Self {
        Self {
            root,
            format,
            chunk,
            base,
            fetched: root.buffers.iter().map(|_| OnceCell::new()).collect(),
            decoded: root.buffer_views.iter().map(|_| OnceCell::new()).collect(),
            of_triangles: vec![Cell::new(false); root.buffers.len()],
            reads_looks: Cell::new(false),
        }
    }

    /// Whether what is read from now on is only for the looks of a mesh.
    pub(super) fn read_looks(&self, reads_looks: bool) {
        self.reads_looks.set(reads_looks);
    }

    /// Feeds the external files that triangles were read from to the hash, in the document's order: so it is the same
    /// with looks and without.
    pub(super) fn hash_external(&self, hasher: &mut blake3::Hasher) {
        let fetched = self.fetched.iter().zip(&self.of_triangles);
        for (buffer, (bytes, of_triangles)) in self.root.buffers.iter().zip(fetched) {
            let external = buffer.uri.as_ref().is_some_and(|uri| !is_data(&uri.0));
            if let Some(bytes) = bytes.get().filter(|_| external && of_triangles.get()) {
                hasher.update(bytes);
            }
        }
    }

    /// The bytes that were read: what they decode to says nothing of how much a file has.
    fn bytes_read(&self) -> usize {
        let fetched = self.fetched.iter().filter_map(OnceCell::get);
        self.chunk.map_or(0, <[u8]>::len) + fetched.map(Vec::len).sum::<usize>()
    }

    /// An upper bound on how many vertices and corners the bytes that were read can hold: a compressed triangle takes
    /// one.
    pub(super) fn most_elements(&self) -> usize {
        self.bytes_read().saturating_mul(3)
    }

    /// How many bytes the next view may decode to.
    fn room(&self) -> usize {
        let (for_each, more) = MOST_DECODED;
        let allowed = self
            .bytes_read()
            .saturating_mul(for_each)
            .saturating_add(more);
        let decoded = self.decoded.iter().filter_map(OnceCell::get);
        allowed.saturating_sub(decoded.map(Vec::len).sum())
    }

    /// The bytes of view `index`.
    pub(super) fn view(&self, index: usize) -> Parsed<View<'_>> {
        let place = format!("bufferView {index}");
        let view = self.root.buffer_views.get(index).ok_or_else(|| {
            let count = self.root.buffer_views.len();
            self.fault(
                &place,
                format!("there is no such view, the file has {count}"),
            )
        })?;
        match meshopt_of(view) {
            Some((extension, compressed)) => self.compressed(index, view, extension, compressed),
            None => self.plain(view, &place),
        }
    }

    fn plain(&self, view: &BufferView, place: &str) -> Parsed<View<'_>> {
        let bytes = self.range(view.buffer, view.byte_offset, view.byte_length, place)?;
        Ok(View {
            bytes,
            stride: view.byte_stride.filter(|&stride| stride > 0),
        })
    }

    /// Decodes a compressed view; where that fails, takes its fallback if there really is one.
    fn compressed(
        &self,
        index: usize,
        view: &BufferView,
        extension: &str,
        compressed: &Compressed,
    ) -> Parsed<View<'_>> {
        let place = format!("bufferView {index} ({extension})");
        let stride = Some(compressed.byte_stride);
        if let Some(bytes) = self.decoded[index].get() {
            self.note_use(compressed.buffer);
            return Ok(View { bytes, stride });
        }
        let source = self.range(
            compressed.buffer,
            compressed.byte_offset,
            compressed.byte_length,
            &place,
        );
        let decoded = source.and_then(|data| {
            meshopt::decode(compressed, data, self.room()).map_err(|problem| LoadFault::Malformed {
                format: self.format,
                place: place.clone(),
                problem,
                cure: format!("export the file again, without {extension} if it persists"),
            })
        });
        match decoded {
            Ok(bytes) => Ok(View {
                bytes: self.decoded[index].get_or_init(|| bytes),
                stride,
            }),
            Err(fault) => self.plain(view, &place).map_err(|_| fault),
        }
    }

    fn range(&self, buffer: usize, offset: usize, length: usize, place: &str) -> Parsed<&[u8]> {
        let bytes = self.buffer(buffer, place)?;
        let end = offset.checked_add(length).filter(|&end| end <= bytes.len());
        end.map(|end| &bytes[offset..end]).ok_or_else(|| {
            let held = bytes.len();
            let problem = format!(
                "{length} bytes from {offset} reach beyond buffer {buffer}, which has {held}"
            );
            self.fault(place, problem)
        })
    }

    fn note_use(&self, buffer: usize) {
        if let Some(of_triangles) = self.of_triangles.get(buffer) {
            of_triangles.set(of_triangles.get() || !self.reads_looks.get());
        }
    }

    fn buffer(&self, index: usize, place: &str) -> Parsed<&[u8]> {
        self.note_use(index);
        let Some(buffer) = self.root.buffers.get(index) else {
            return Err(self.fault(place, format!("there is no buffer {index}")));
        };
        let bytes = match (&buffer.uri, self.chunk) {
            (None, Some(chunk)) if index == 0 => chunk,
            (None, _) => return Err(self.fault(place, format!("buffer {index} has no data"))),
            (Some(uri), _) => match self.fetched[index].get() {
                Some(bytes) => bytes,
                None => {
                    let bytes = self.fetch(index, buffer, &uri.0)?;
                    self.fetched[index].get_or_init(|| bytes)
                }
            },
        };
        if bytes.len() < buffer.byte_length {
            let (held, promised) = (bytes.len(), buffer.byte_length);
            let problem = format!("{promised} bytes are promised, {held} are there");
            return Err(LoadFault::malformed(
                self.format,
                format!("buffer {index}"),
                problem,
                "it was cut short: export or copy it again",
            ));
        }
        Ok(bytes)
    }

    fn fetch(&self, index: usize, buffer: &Buffer, uri: &str) -> Parsed<Vec<u8>> {
        let place = format!("buffer {index}");
        if is_data(uri) {
            return decode_data_uri(uri).map_err(|problem| self.fault(&place, problem.into()));
        }
        let path = self.local_path(uri).map_err(|problem| {
            let cure = "put the buffer file beside the glTF file, or export as GLB";
            LoadFault::malformed(self.format, place.clone(), problem, cure)
        })?;
        read_up_to(&path, buffer.byte_length).map_err(|problem| LoadFault::Unreadable {
            what: format!("{place} ({})", path.display()),
            problem,
            cure: "copy the buffer file beside the glTF file, or export as GLB",
        })
    }

    /// The whole of something outside the buffers, as an image: a data URI or a file beside the
    /// document, with the file's path.
    pub(super) fn outside(&self, uri: &str) -> Result<(Vec<u8>, Option<PathBuf>), String> {
        if is_data(uri) {
            let decoded = decode_data_uri(uri).map_err(str::to_owned)?;
            return Ok((decoded, None));
        }
        let path = self.local_path(uri)?;
        match input::regular_bytes(&path) {
            Ok(bytes) => Ok((bytes, Some(path))),
            Err(e) => Err(format!("{}: {e}", path.display())),
        }
    }

    fn local_path(&self, uri: &str) -> Result<PathBuf, String> {
        let has_scheme = uri
            .split(['/', '?', '#'])
            .next()
            .is_some_and(|s| s.contains(':'));
        if has_scheme {
            return Err(format!("its data lies elsewhere ({})", shortened(uri)));
        }
        let base = self
            .base
            .ok_or("it needs an external file, which memory does not have")?;
        // Some programs write a file's name as it is, which may have a percent sign, or as Windows has it.
        let decoded = decode_percent(uri);
        let names = [decoded.as_deref(), Some(uri)].into_iter().flatten();
        let with_slashes = names.clone().map(|name| name.replace('\\', "/"));
        let mut files = names.map(str::to_owned).chain(with_slashes);
        let there = files
            .find(|name| base.join(name).is_file())
            .or(decoded.clone());
        let name = there.ok_or_else(|| format!("bad name {}", shortened(uri)))?;
        Ok(base.join(name))
    }

    fn fault(&self, place: &str, problem: String) -> LoadFault {
        LoadFault::malformed(self.format, place, problem, EXPORT_AGAIN)
    }
}

/// Reads what a buffer may use of a file: no more than it says.
fn read_up_to(path: &Path, length: usize) -> std::io::Result<Vec<u8>> {
    let file: File = input::regular(path)?;
    let held = file.metadata()?.len().min(length as u64);
    let mut bytes = Vec::with_capacity(usize::try_from(held).unwrap_or(0));
    file.take(length as u64).read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn meshopt_of<'v>(view: &'v BufferView) -> Option<(&'static str, &'v Compressed<'v>)> {
    let extensions = &view.extensions;
    let ext = extensions
        .ext_meshopt
        .as_ref()
        .map(|c| ("EXT_meshopt_compression", c));
    ext.or(extensions
        .khr_meshopt
        .as_ref()
        .map(|c| ("KHR_meshopt_compression", c)))
}

fn is_data(uri: &str) -> bool {
    uri.get(..5)
        .is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:"))
}

fn shortened(uri: &str) -> String {
    uri.chars().take(60).collect()
}

/// The payload of `data:...;base64,...`, or of `data:...,...` with percent signs (RFC 2397).
fn decode_data_uri(uri: &str) -> Result<Vec<u8>, &'static str> {
    const NOT_PERCENT: &str = "a percent sign in its data URI is not followed by two digits";
    let (head, payload) = uri.split_once(',').ok_or("its data URI has no comma")?;
    let mut parameters = head.split(';').skip(1);
    let is_base64 = parameters.any(|one| one.trim().eq_ignore_ascii_case("base64"));
    let decoded;
    let bytes = match payload.contains('%') {
        true => {
            decoded = percent_bytes(payload).ok_or(NOT_PERCENT)?;
            &decoded
        }
        false => payload.as_bytes(),
    };
    match is_base64 {
        true => decode_base64(bytes).ok_or("its data URI is not valid base64"),
        false => Ok(bytes.to_vec()),
    }
}

/// RFC 4648 section 4; white space and missing padding are tolerated, as browsers do.
fn decode_base64(text: &[u8]) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut held) = (0_u32, 0_u32);
    let end = text
        .iter()
        .rposition(|&b| b != b'=')
        .map_or(0, |last| last + 1);
    for &symbol in &text[..end] {
        let value = match symbol {
            b'A'..=b'Z' => symbol - b'A',
            b'a'..=b'z' => symbol - b'a' + 26,
            b'0'..=b'9' => symbol - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            _ if symbol.is_ascii_whitespace() => continue,
            _ => return None,
        };
        bits = bits << 6 | u32::from(value);
        held += 6;
        if held >= 8 {
            held -= 8;
            out.push((bits >> held) as u8);
        }
    }
    (held < 6).then_some(out)
}

/// The name that a URI means.
fn decode_percent(uri: &str) -> Option<String> {
    let name = String::from_utf8(percent_bytes(uri)?).ok();
    name.filter(|name| !name.contains('\0'))
}

/// RFC 3986 section 2.1.
fn percent_bytes(uri: &str) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        rest = tail;
        if *first != b'%' {
            out.push(*first);
            continue;
        }
        let digits = std::str::from_utf8(tail.get(..2)?).ok()?;
        out.push(u8::from_str_radix(digits, 16).ok()?);
        rest = &tail[2..];
    }
    Some(out)
}
