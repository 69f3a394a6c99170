//! What a log begins with: magic, format, version of the program, the recipe, CRC-32.
//!
//! The whole recipe is kept and not its hash alone, so that a log of another run can be refused by
//! naming what differs.

use std::io::{self, Read};
use std::path::Path;

use super::LogError;
use super::block::{Seal, fill};
use crate::run::{Recipe, Settings};

const MAGIC: [u8; 8] = *b"\x89thallog";

/// Grows when old programs could not read a log any more. The head keeps its layout in all formats, so that each
/// program can tell a log of another format from one that is damaged.
const FORMAT: u32 = 2;

/// A recipe is a page of text; what is longer than this is damaged.
const LONGEST: usize = 1 << 20;

/// The head of a log, which is a log without elements.
pub fn head(recipe: &Recipe) -> Vec<u8> {
    sealed_head(recipe).0
}

/// The same, and what ties the blocks that follow to it.
pub(super) fn sealed_head(recipe: &Recipe) -> (Vec<u8>, Seal) {
    let mut bytes = MAGIC.to_vec();
    bytes.extend_from_slice(&FORMAT.to_le_bytes());
    for text in [env!("CARGO_PKG_VERSION"), &recipe.to_toml()] {
        bytes.extend_from_slice(&(text.len() as u32).to_le_bytes());
        bytes.extend_from_slice(text.as_bytes());
    }
    let checksum = crc32fast::hash(&bytes);
    bytes.extend_from_slice(&checksum.to_le_bytes());
    (bytes, Seal(checksum))
}

/// A head that was read.
pub(super) struct Head {
    pub(super) recipe: Settings,
    /// Its length in bytes.
    pub(super) length: u64,
    pub(super) seal: Seal,
}

/// Reads a head.
pub(super) fn read_head(path: &Path, file: &mut impl Read) -> Result<Head, LogError> {
    let read = LogError::read(path);
    let damaged = || LogError::Head(path.to_owned());
    let mut reader = HeadReader {
        file,
        bytes: Vec::new(),
    };
    if reader.take(8).map_err(&read)? != Some(&MAGIC) {
        return Err(LogError::NoLog(path.to_owned()));
    }
    let format = reader.number().map_err(&read)?.ok_or_else(damaged)?;
    let texts = reader.texts().map_err(&read)?;
    // The checksum first: a damaged format or version is no other one.
    let seal = reader.seal().map_err(&read)?.ok_or_else(damaged)?;
    let [Some(version), Some(text)] = texts else {
        return Err(damaged());
    };
    if format != FORMAT || version != env!("CARGO_PKG_VERSION") {
        return Err(other_version(path, version, format));
    }
    Ok(Head {
        recipe: Settings::from_toml(&text).map_err(|_| damaged())?,
        length: reader.bytes.len() as u64,
        seal,
    })
}

fn other_version(path: &Path, version: String, format: u32) -> LogError {
    LogError::Version {
        path: path.to_owned(),
        found: match format {
            FORMAT => version,
            _ => format!("{version} with log format {format}"),
        },
    }
}

/// Reads a head part by part and keeps what it read. Of a part that is not there, as the file ends before, it
/// gives none; an error of the system is no damage, and the log may be sound.
struct HeadReader<'a, R> {
    file: &'a mut R,
    bytes: Vec<u8>,
}

impl<R: Read> HeadReader<'_, R> {
    fn take(&mut self, length: usize) -> io::Result<Option<&[u8]>> {
        let start = self.bytes.len();
        self.bytes.resize(start + length, 0);
        let is_there = fill(self.file, &mut self.bytes[start..])?;
        Ok(is_there.then(|| &self.bytes[start..]))
    }

    fn number(&mut self) -> io::Result<Option<u32>> {
        let bytes = self.take(4)?.and_then(|bytes| bytes.try_into().ok());
        Ok(bytes.map(u32::from_le_bytes))
    }

    /// The version, and the text of the recipe.
    fn texts(&mut self) -> io::Result<[Option<String>; 2]> {
        let version = self.text()?;
        let recipe = match version {
            Some(_) => self.text()?,
            None => None,
        };
        Ok([version, recipe])
    }

    fn text(&mut self) -> io::Result<Option<String>> {
        let length = self.number()?.map(|length| length as usize);
        let Some(length) = length.filter(|&length| length <= LONGEST) else {
            return Ok(None);
        };
        let bytes = self.take(length)?.map(<[u8]>::to_vec);
        Ok(bytes.and_then(|bytes| String::from_utf8(bytes).ok()))
    }

    /// The checksum that comes next, if it is that of what was read.
    fn seal(&mut self) -> io::Result<Option<Seal>> {
        let expected = crc32fast::hash(&self.bytes);
        let found = self.number()?.filter(|found| *found == expected);
        Ok(found.map(Seal))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::substrate::Substrate;

    /// A disk that fails after what it has.
    struct Failing;

    impl Read for Failing {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            Err(io::Error::other("stale file handle"))
        }
    }

    #[test]
    fn a_disk_that_fails_is_no_damage() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes/plane.obj");
        let plane = Substrate::load(&file).unwrap();
        let recipe = Settings::default().resolve(&plane, "plane.obj").unwrap();
        let head = head(&recipe);
        let read = |file: &mut dyn Read| read_head(Path::new("run.log"), &mut { file });
        for length in 0..head.len() {
            let there = &head[..length];
            let failed = read(&mut there.chain(Failing));
            let failed = failed.map(|head| head.length);
            assert!(matches!(failed, Err(LogError::Read { .. })), "{length}");
            let ends = read(&mut { there });
            let is_damaged = matches!(ends, Err(LogError::NoLog(_) | LogError::Head(_)));
            assert!(is_damaged, "{length}");
        }
        let whole = read(&mut &head[..]).unwrap();
        assert_eq!(whole.length, head.len() as u64);
        assert_eq!(whole.seal, sealed_head(&recipe).1);
    }
}
