//! Appends births to a log while a run goes.

use std::fs::{File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

use super::block::{Draft, LARGEST_BLOCK, Seal};
use super::head::sealed_head;
use super::rhythm::{Rhythm, Waiting};
use super::{Log, write_whole};
use crate::cluster::{Cluster, Element};
use crate::export::{FileId, OutputError, write_file_atomically};
use crate::growth::Counts;
use crate::run::{Begun, Observer, Progress, Recipe, Settings};

/// An observer that appends every birth to a log and makes it durable.
///
/// Blocks are written and flushed to the disk every two seconds (more often at the start of a run)
/// or every [`LARGEST_BLOCK`] elements, but not so often that it takes more than a hundredth
/// of the time: after a flush that took a second the next comes 100 seconds later at the soonest, unless what
/// waits would fill memory, and after one that took much longer than those before it two minutes later.
///
/// When the disk refuses, or a birth is not the next one of this log, it ends the run. Nothing says so but
/// [`LogWriter::finish`]: call it when the run has ended. A writer that is dropped without writes what waits,
/// and an error then is lost.
#[derive(Debug)]
#[must_use = "births are logged by giving it to a run, and `finish` says whether they were"]
pub struct LogWriter {
    path: PathBuf,
    /// None once it is closed.
    file: Option<File>,
    /// Keeps the number of a closed file from being given to another; on Windows it would keep the file open.
    held: Option<File>,
    id: FileId,
    /// Length that a power failure cannot touch.
    durable: u64,
    /// Length: more than that until what is not sound is cut off.
    length: u64,
    /// Elements in it.
    durable_elements: u64,
    /// Whole blocks that are not written yet.
    blocks: Vec<u8>,
    draft: Draft,
    seal: Seal,
    /// Age of the next element.
    next: u64,
    counts: Counts,
    marks: Vec<Counts>,
    rhythm: Rhythm,
    failed: Option<OutputError>,
    /// The last flush failed: trying again when dropped is no use.
    refused: bool,
}

impl LogWriter {
    /// Begins the log of a run by this recipe: its head is written, durably, so that the run can be killed
    /// from here on. For [`Begun::default`].
    ///
    /// # Errors
    /// [`OutputError::FileExists`] when something is there, which may be another run's log; when the system
    /// refuses.
    pub fn create(path: &Path, recipe: &Recipe) -> Result<Self, OutputError> {
        let started = Instant::now();
        let (head, seal) = sealed_head(recipe);
        write_file_atomically(path, false, |out| out.write_all(&head))?;
        let log = Log {
            path: path.to_owned(),
            recipe: Settings::from(recipe),
            begun: Begun::default(),
            sound_bytes: head.len() as u64,
            torn_bytes: 0,
            is_damaged: false,
            marks: Vec::new(),
            seal,
        };
        Ok(Self::reopened(log, started)?.0)
    }

    /// Opens a log to go on after its last sound block, and gives what there is, for
    /// [`Run::new`](crate::run::Run::new). [`Log::check`] says whether it is of that recipe. What comes after
    /// that block is cut off when something is first written, or [`LogWriter::finish`] is called.
    ///
    /// # Errors
    /// When the system refuses, or the file has become shorter than what was read of it.
    pub fn open(log: Log) -> Result<(Self, Begun), OutputError> {
        Self::reopened(log, Instant::now())
    }

    fn reopened(log: Log, started: Instant) -> Result<(Self, Begun), OutputError> {
        let (file, id, length) = reopen(&log.path).map_err(failure(&log.path))?;
        if length < log.sound_bytes {
            let cut = "the file was cut since it was read: read it again";
            return Err(failure(&log.path)(io::Error::other(cut)));
        }
        let next = log.begun.elements.len() as u64;
        let writer = Self {
            path: log.path,
            file: Some(file),
            held: None,
            id,
            durable: log.sound_bytes,
            length,
            durable_elements: next,
            blocks: Vec::new(),
            draft: Draft::new(next),
            seal: log.seal,
            next,
            counts: log.begun.counts.clone(),
            marks: log.marks,
            rhythm: Rhythm::new(started, Instant::now()),
            failed: None,
            refused: false,
        };
        Ok((writer, log.begun))
    }

    /// Elements that are durable.
    pub fn durable_elements(&self) -> u64 {
        self.durable_elements
    }

    /// Writes what is still waiting. This is how one learns of an error, which is told once: of a writer that failed
    /// nothing more is to be expected, and a later call says only whether what waits could be written.
    ///
    /// # Errors
    /// Why the log could not be written, now or before.
    pub fn finish(&mut self) -> Result<(), OutputError> {
        match self.failed.take() {
            Some(error) => Err(error),
            None => self.flush(),
        }
    }

    /// [Finishes](Self::finish) it and lets another file take its place, which on some file systems of Windows none can
    /// while it is open. Nothing more can be logged.
    ///
    /// # Errors
    /// As [`LogWriter::finish`]; the file stays open then.
    pub fn close(&mut self) -> Result<(), OutputError> {
        self.finish()?;
        self.held = self.file.take().filter(|_| !cfg!(windows));
        Ok(())
    }

    /// The finished log of a whole run, as it is whenever and however often the run was stopped.
    ///
    /// # Errors
    /// Those of `out`.
    ///
    /// # Panics
    /// When the cluster is not the one whose births this has seen.
    pub fn write_whole(
        &self,
        recipe: &Recipe,
        cluster: &Cluster,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        assert_eq!(cluster.len() as u64, self.next, "the cluster of this log");
        let mut counts = self.marks.clone();
        if !cluster.len().is_multiple_of(LARGEST_BLOCK) {
            counts.push(self.counts.clone());
        }
        write_whole(recipe, cluster.elements(), &counts, out)
    }

    /// A birth that does not follow the elements of this log. Its run has others, and a log of both could not
    /// be gone on with.
    fn stranger(&self, number: u64) -> OutputError {
        let said = format!(
            "the run is at its element {number}, and the log has {}: begin the run with what \
             LogWriter::open gave",
            self.next
        );
        failure(&self.path)(io::Error::new(io::ErrorKind::InvalidInput, said))
    }

    fn append(&mut self, element: &Element, counts: &Counts) {
        self.draft.push(element);
        self.next += 1;
        self.counts.clone_from(counts);
        if self.next.is_multiple_of(LARGEST_BLOCK as u64) {
            self.marks.push(counts.clone());
            self.close_block();
        }
    }

    fn close_block(&mut self) {
        if self.draft.len() > 0 {
            let draft = std::mem::replace(&mut self.draft, Draft::new(self.next));
            let block = draft.close(self.seal, self.durable, &self.counts);
            self.blocks.extend_from_slice(&block);
        }
    }

    fn is_due(&self) -> bool {
        let waiting = Waiting {
            elements: self.next - self.durable_elements,
            bytes: self.blocks.len(),
        };
        self.rhythm.is_due(Instant::now(), waiting)
    }

    /// Writes what waits and makes it durable.
    fn flush(&mut self) -> Result<(), OutputError> {
        let flushed = self.write_waiting();
        self.refused = flushed.is_err();
        flushed
    }

    fn write_waiting(&mut self) -> Result<(), OutputError> {
        if self.file.is_none() && self.next == self.durable_elements {
            return Ok(());
        }
        self.close_block();
        self.check_place().map_err(failure(&self.path))?;
        let started = Instant::now();
        if let Err(e) = self.write_blocks() {
            // So that the tail is not torn for the next run; it would cope.
            let _ = self.cut();
            return Err(failure(&self.path)(e));
        }
        self.durable += self.blocks.len() as u64;
        self.length = self.durable;
        self.durable_elements = self.next;
        self.blocks.clear();
        self.rhythm.flushed(started, Instant::now());
        Ok(())
    }

    fn write_blocks(&mut self) -> io::Result<()> {
        if self.length > self.durable {
            self.cut()?;
        }
        let mut file = self.file()?;
        file.seek(SeekFrom::Start(self.durable))?;
        file.write_all(&self.blocks)?;
        file.sync_data()
    }

    fn file(&self) -> io::Result<&File> {
        let closed = || io::Error::new(io::ErrorKind::NotFound, "the log is closed");
        self.file.as_ref().ok_or_else(closed)
    }

    /// Takes off what is not sound.
    fn cut(&mut self) -> io::Result<()> {
        self.file()?.set_len(self.durable)?;
        self.length = self.durable;
        Ok(())
    }

    /// Whether the log is still where it was opened; an error where that cannot be told.
    ///
    /// # Errors
    /// Those of the system.
    pub fn is_in_place(&self) -> io::Result<bool> {
        self.id.is_still_at(&self.path)
    }

    /// A file that was removed can be written, and is lost when it is closed. One that another program writes
    /// is no log any more; where no locks are, that may be another run.
    fn check_place(&self) -> io::Result<()> {
        let file = self.file()?;
        if !self.is_in_place()? {
            let moved =
                "the file or its folder was moved, replaced or removed while the run went on";
            return Err(io::Error::new(io::ErrorKind::NotFound, moved));
        }
        match file.metadata()?.len() == self.length {
            true => Ok(()),
            false => Err(io::Error::other(
                "something else wrote into the file while the run went on",
            )),
        }
    }
}

impl Observer for LogWriter {
    fn born(&mut self, element: &Element, progress: &Progress) -> ControlFlow<()> {
        if self.failed.is_some() {
            return ControlFlow::Break(());
        }
        if progress.elements != self.next + 1 {
            self.failed = Some(self.stranger(progress.elements));
            return ControlFlow::Break(());
        }
        self.append(element, &progress.counts);
        if self.is_due() {
            self.failed = self.flush().err();
        }
        match self.failed {
            Some(_) => ControlFlow::Break(()),
            None => ControlFlow::Continue(()),
        }
    }
}

impl Drop for LogWriter {
    /// Nobody asked how it ended, so there is nobody to tell of an error.
    fn drop(&mut self) {
        if self.next > self.durable_elements && !self.refused {
            let _ = self.flush();
        }
    }
}

/// The file, which one it is, and its length. Appending, two that write the same log both make it longer, which is
/// seen; but Windows cuts nothing off files that are open to append.
fn reopen(path: &Path) -> io::Result<(File, FileId, u64)> {
    let mut options = OpenOptions::new();
    let file = options.write(true).append(cfg!(unix)).open(path)?;
    file.sync_all()?;
    let (id, length) = (FileId::of(&file)?, file.metadata()?.len());
    Ok((file, id, length))
}

fn failure(path: &Path) -> impl FnOnce(io::Error) -> OutputError {
    let path = path.to_owned();
    move |problem| OutputError::Io {
        path,
        doing: "writing",
        problem,
    }
}
