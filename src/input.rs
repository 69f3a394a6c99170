//! Files that are read. Opening a named pipe waits for somebody to write into it, which may be for ever:
//! what needs a file on a disk refuses pipes, and what takes any text refuses those that nobody writes into.

use std::fs::{self, File, FileType};
use std::io::{self, ErrorKind, Read};
use std::path::Path;
use std::thread;
use std::time::Duration;

/// Bytes of the longest text: recipes, grids, cameras, colour maps and curves are a page or two.
const LONGEST_TEXT: u64 = 16 << 20;

/// What is wrong with what may have no end, as /dev/zero.
const DEVICE: &str = "this is a device, not a regular file: name a file on a disk";

/// Between two looks into a pipe that is empty.
const PAUSE: Duration = Duration::from_millis(2);

/// Opens a file that has an end and can be read twice: no folder, pipe or device.
///
/// # Errors
/// When it is something else, or the system refuses.
pub fn regular(path: &Path) -> io::Result<File> {
    let kind = fs::metadata(path)?.file_type();
    if kind.is_file() {
        return File::open(path);
    }
    let problem = match (kind.is_dir(), is_pipe(kind)) {
        (true, _) => "this is a folder, not a regular file: name the file in it",
        (_, true) => {
            "this is a pipe, not a regular file: save what comes through it to a file, and name that"
        }
        _ => DEVICE,
    };
    Err(io::Error::new(ErrorKind::InvalidInput, problem))
}

/// All of a file that [`regular`] opens.
///
/// # Errors
/// As that, and when the system refuses to read.
pub fn regular_bytes(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    regular(path)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// What programs on Windows put before a text in UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";

/// All of a text, which may come through a pipe, without a byte order mark.
///
/// # Errors
/// When the system refuses, the text is not UTF-8 or no page, or nobody writes into the pipe.
pub fn text(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    let mut limited = Stream::open(path)?.take(LONGEST_TEXT);
    limited
        .read_to_string(&mut text)
        .map_err(|e| match e.kind() {
            ErrorKind::InvalidData => {
                io::Error::new(e.kind(), "it is not text: this is another file")
            }
            _ => e,
        })?;
    match limited.limit() {
        0 => Err(io::Error::new(
            ErrorKind::InvalidData,
            "it is longer than 16 MiB: this is another file",
        )),
        _ if text.as_bytes().starts_with(BYTE_ORDER_MARK) => {
            Ok(text.split_off(BYTE_ORDER_MARK.len()))
        }
        _ => Ok(text),
    }
}

/// All of a file, which may come through a pipe. Devices are refused: some have no end.
///
/// # Errors
/// When it is a device, the system refuses, or nobody writes into the pipe.
pub fn bytes(path: &Path) -> io::Result<Vec<u8>> {
    let kind = fs::metadata(path)?.file_type();
    if !(kind.is_file() || kind.is_dir() || is_pipe(kind)) {
        return Err(io::Error::new(ErrorKind::InvalidInput, DEVICE));
    }
    let mut bytes = Vec::new();
    Stream::open(path)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The bytes of a text behind its byte order mark, if it has one.
pub(crate) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes)
}

/// Longest excerpt of a file that a message quotes, in bytes.
const QUOTE: usize = 40;

/// A token made fit for a message: printable and short.
pub(crate) fn quoted(token: &[u8]) -> String {
    let shown = String::from_utf8_lossy(&token[..token.len().min(QUOTE)]);
    let clean: String = shown
        .chars()
        .map(|c| if c.is_control() { '\u{fffd}' } else { c })
        .collect();
    let dots = if token.len() > QUOTE { "..." } else { "" };
    format!("'{clean}{dots}'")
}

/// A file, or a pipe that somebody writes into.
#[derive(Debug)]
pub struct Stream {
    file: File,
    is_pipe: bool,
    any: bool,
}

impl Stream {
    /// Opens it, and does not wait for a writer.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn open(path: &Path) -> io::Result<Self> {
        let file = open_at_once(path)?;
        let is_pipe = is_pipe(file.metadata()?.file_type());
        Ok(Self {
            file,
            is_pipe,
            any: false,
        })
    }

    /// What the system knows about it.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn metadata(&self) -> io::Result<fs::Metadata> {
        self.file.metadata()
    }
}

impl Read for Stream {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            match self.file.read(buffer) {
                Err(wait) if wait.kind() == ErrorKind::WouldBlock => thread::sleep(PAUSE),
                Ok(0) if self.is_pipe && !self.any => return Err(nobody_writes()),
                read => {
                    self.any |= read.as_ref().is_ok_and(|&n| n > 0);
                    return read;
                }
            }
        }
    }
}

fn nobody_writes() -> io::Error {
    let problem =
        "this is a pipe that nothing writes into: start what writes first, or name a regular file";
    io::Error::new(ErrorKind::UnexpectedEof, problem)
}

#[cfg(unix)]
fn open_at_once(path: &Path) -> io::Result<File> {
    use std::os::unix::fs::OpenOptionsExt;
    let mut options = File::options();
    options.read(true).custom_flags(libc::O_NONBLOCK).open(path)
}

/// Of a folder Windows would say that access is denied.
#[cfg(not(unix))]
fn open_at_once(path: &Path) -> io::Result<File> {
    match path.is_dir() {
        true => Err(ErrorKind::IsADirectory.into()),
        false => File::open(path),
    }
}

#[cfg(unix)]
fn is_pipe(kind: FileType) -> bool {
    std::os::unix::fs::FileTypeExt::is_fifo(&kind)
}

#[cfg(not(unix))]
fn is_pipe(_: FileType) -> bool {
    false
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    /// `/dev/zero` would fill the memory here, were it read.
    #[test]
    fn devices_are_refused_unread() {
        for read in [bytes, regular_bytes] {
            let refused = read(Path::new("/dev/null")).unwrap_err();
            assert_eq!(refused.to_string(), DEVICE);
        }
        assert!(bytes(Path::new("Cargo.toml")).is_ok());
    }
}
