//! The words of a text that is read as a stream, and the lines that they stand in.

use std::io::BufRead;

use super::error::{LoadFault, Parsed};

/// Bytes of a word that are kept: more is neither a number nor a keyword.
const LONGEST_WORD: usize = 64 * 1024;

/// Words between white space of any sort. A line ends with LF, CRLF, or CR alone.
pub(super) struct Words<R> {
    input: R,
    word: Vec<u8>,
    /// The number of the line that is being read, from 1.
    line: usize,
    /// Whether a line ended before this word, or it is the first.
    begins_line: bool,
    after_cr: bool,
}

impl<R: BufRead> Words<R> {
    pub(super) fn new(input: R) -> Self {
        Self {
            input,
            word: Vec::new(),
            line: 1,
            begins_line: true,
            after_cr: false,
        }
    }

    /// Goes on to the next word; false at the end of the text.
    pub(super) fn advance(&mut self) -> Parsed<bool> {
        self.begins_line = self.word.is_empty();
        self.word.clear();
        while self.take_from_chunk()? {}
        Ok(!self.word.is_empty())
    }

    pub(super) fn word(&self) -> &[u8] {
        &self.word
    }

    pub(super) fn line(&self) -> usize {
        self.line
    }

    pub(super) fn begins_line(&self) -> bool {
        self.begins_line
    }

    /// Takes what the chunk that is read has of the word; true when more of it may follow.
    fn take_from_chunk(&mut self) -> Parsed<bool> {
        let chunk = self.input.fill_buf().map_err(unreadable)?;
        if chunk.is_empty() {
            return Ok(false);
        }
        let is_word = |b: &u8| !b.is_ascii_whitespace();
        let start = match self.word.is_empty() {
            true => chunk.iter().position(is_word).unwrap_or(chunk.len()),
            false => 0,
        };
        let (space, rest) = chunk.split_at(start);
        let length = rest.iter().position(u8::is_ascii_whitespace);
        let word = &rest[..length.unwrap_or(rest.len())];
        let room = LONGEST_WORD.saturating_sub(self.word.len());
        self.word.extend_from_slice(&word[..word.len().min(room)]);
        for &byte in space {
            let ends = byte == b'\r' || (byte == b'\n' && !self.after_cr);
            self.line += usize::from(ends);
            self.begins_line |= ends;
            self.after_cr = byte == b'\r';
        }
        self.after_cr &= word.is_empty();
        let used = start + word.len();
        self.input.consume(used);
        Ok(length.is_none())
    }
}

fn unreadable(problem: std::io::Error) -> LoadFault {
    LoadFault::Unreadable {
        what: "the file".into(),
        problem,
        cure: "copy it to a local disk and try again",
    }
}
