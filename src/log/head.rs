//! What a log begins with: magic, format, version of the program, the recipe, CRC-32.
//!
//! The whole recipe is kept and not its hash alone, so that a log of another run can be refused by
//! naming what differs.

use std::io::Read;
use std::path::Path;

use super::LogError;
use crate::run::{Recipe, Settings};

const MAGIC: [u8; 8] = *b"\x89thallog";

/// Grows when old programs could not read a log any more.
const FORMAT: u32 = 1;

/// A recipe is a page of text; what is longer than this is damaged.
const LONGEST: usize = 1 << 20;

/// The head of a log, which is a log without elements.
pub fn head(recipe: &Recipe) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend_from_slice(&FORMAT.to_le_bytes());
    for text in [env!("CARGO_PKG_VERSION"), &recipe.to_toml()] {
        bytes.extend_from_slice(&(text.len() as u32).to_le_bytes());
        bytes.extend_from_slice(text.as_bytes());
    }
    let checksum = crc32fast::hash(&bytes);
    bytes.extend_from_slice(&checksum.to_le_bytes());
    bytes
}

/// Reads a head: the recipe and the head's length.
pub(super) fn read_head(path: &Path, file: &mut impl Read) -> Result<(Settings, u64), LogError> {
    let damaged = || LogError::Head(path.to_owned());
    let mut reader = HeadReader {
        file,
        bytes: Vec::new(),
    };
    let magic = reader
        .take(8)
        .ok_or_else(|| LogError::NoLog(path.to_owned()))?;
    if magic != MAGIC {
        return Err(LogError::NoLog(path.to_owned()));
    }
    let format = reader.number().ok_or_else(damaged)?;
    let version = (format == FORMAT).then(|| reader.text()).flatten();
    let text = version.as_ref().and_then(|_| reader.text());
    // The checksum first: a damaged version is no other version.
    if format == FORMAT && !reader.is_sound() {
        return Err(damaged());
    }
    let length = reader.bytes.len() as u64;
    match version {
        Some(version) if version == env!("CARGO_PKG_VERSION") => {
            let settings = text.and_then(|text| Settings::from_toml(&text).ok());
            Ok((settings.ok_or_else(damaged)?, length))
        }
        version => Err(LogError::Version {
            path: path.to_owned(),
            found: version.unwrap_or_else(|| format!("with log format {format}")),
        }),
    }
}

/// Reads a head part by part and keeps what it read.
struct HeadReader<'a, R> {
    file: &'a mut R,
    bytes: Vec<u8>,
}

impl<R: Read> HeadReader<'_, R> {
    fn take(&mut self, length: usize) -> Option<&[u8]> {
        let start = self.bytes.len();
        self.bytes.resize(start + length, 0);
        self.file.read_exact(&mut self.bytes[start..]).ok()?;
        Some(&self.bytes[start..])
    }

    fn number(&mut self) -> Option<u32> {
        let bytes = self.take(4)?.try_into().ok()?;
        Some(u32::from_le_bytes(bytes))
    }

    fn text(&mut self) -> Option<String> {
        let length = self.number()? as usize;
        let bytes = (length <= LONGEST).then(|| self.take(length)).flatten()?;
        String::from_utf8(bytes.to_vec()).ok()
    }

    /// Whether the checksum that comes next is that of what was read.
    fn is_sound(&mut self) -> bool {
        let expected = crc32fast::hash(&self.bytes);
        self.number() == Some(expected)
    }
}
