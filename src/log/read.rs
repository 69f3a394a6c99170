//! A log read back.

use std::fs::File;
use std::io::{self, Cursor, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::LogError;
use super::block::{Block, LARGEST_BLOCK, MARKER, Outline, Seal};
use super::head::read_head;
use crate::cluster::Cluster;
use crate::growth::Counts;
use crate::input;
use crate::run::{Begun, GrowError, Recipe, Run, Settings, StopRule};
use crate::substrate::Substrate;

/// A log: whose it is, and the elements of its sound blocks.
#[derive(Clone, Debug)]
pub struct Log {
    /// The file.
    pub path: PathBuf,
    /// The recipe of the run that began it, with its stop rule. A run that went on for longer has passed that:
    /// [`Run::new`](crate::run::Run::new) wants a larger one then.
    pub recipe: Settings,
    /// The elements, and what they took.
    pub begun: Begun,
    /// Bytes up to the end of the last sound block.
    pub sound_bytes: u64,
    /// Bytes after them: a block that was not whole when the run was killed.
    pub torn_bytes: u64,
    /// Whether some of these bytes had been durable, and are damaged; only [`read_sound`](Self::read_sound) takes such
    /// logs.
    pub is_damaged: bool,
    /// The counts at each multiple of [`LARGEST_BLOCK`] elements.
    pub(super) marks: Vec<Counts>,
    /// Its head's: blocks of other logs are none of this.
    pub(super) seal: Seal,
}

impl Log {
    /// Reads a log. What a killed run left of its last block counts as torn.
    ///
    /// # Errors
    /// When it cannot be read, or is none of this version; [`LogError::Damaged`] when something
    /// that had been durable is damaged.
    pub fn read(path: &Path) -> Result<Self, LogError> {
        Self::read_from(path, open(path)?)
    }

    /// Reads a log that is in memory. `path` is what errors call it, and the file that
    /// [`LogWriter::open`](super::LogWriter::open) would go on with.
    ///
    /// # Errors
    /// When it is no log, or none of this version; [`LogError::Damaged`] when something that had been
    /// durable is damaged.
    pub fn parse(path: &Path, bytes: &[u8]) -> Result<Self, LogError> {
        Self::read_from(path, Cursor::new(bytes))
    }

    fn read_from(path: &Path, mut file: impl Read + Seek) -> Result<Self, LogError> {
        let log = Self::sound(path, &mut file)?;
        match log.is_damaged {
            false => Ok(log),
            true => Err(LogError::Damaged {
                path: path.to_owned(),
                at: log.sound_bytes,
                elements: log.begun.elements.len(),
            }),
        }
    }

    /// Reads a log up to the first damage, whatever comes after it.
    ///
    /// # Errors
    /// When it cannot be read, or is none of this version.
    pub fn read_sound(path: &Path) -> Result<Self, LogError> {
        Self::sound(path, &mut open(path)?)
    }

    fn sound(path: &Path, file: &mut (impl Read + Seek)) -> Result<Self, LogError> {
        let read = LogError::read(path);
        let length = file.seek(SeekFrom::End(0)).map_err(&read)?;
        file.rewind().map_err(&read)?;
        let head = read_head(path, file)?;
        let mut log = Self {
            path: path.to_owned(),
            recipe: head.recipe,
            begun: Begun::default(),
            sound_bytes: head.length,
            torn_bytes: 0,
            is_damaged: false,
            marks: Vec::new(),
            seal: head.seal,
        };
        while let Some(block) = Block::read(file, log.seal, log.sound_bytes).map_err(&read)? {
            if !log.take(block) {
                break;
            }
        }
        // A run that is under way may have added to it since.
        log.torn_bytes = length.saturating_sub(log.sound_bytes);
        log.is_damaged =
            log.torn_bytes > 0 && was_durable(file, log.seal, log.sound_bytes).map_err(&read)?;
        Ok(log)
    }

    /// Adds a block, if it is the next one.
    fn take(&mut self, block: Block) -> bool {
        let elements = &mut self.begun.elements;
        let follows = block.first == elements.len() as u64;
        if follows {
            elements.extend(block.elements);
            if elements.len().is_multiple_of(LARGEST_BLOCK) {
                self.marks.push(block.counts.clone());
            }
            self.begun.counts = block.counts;
            self.sound_bytes += block.length;
        }
        follows
    }

    /// Checks that this is the log of a run by this recipe, whatever its stop rule and wherever its
    /// mesh lies.
    ///
    /// # Errors
    /// [`LogError::Mesh`] or [`LogError::Recipe`], naming what differs.
    pub fn check(&self, recipe: &Recipe) -> Result<(), LogError> {
        self.check_mesh(&recipe.mesh.hash)?;
        let differences = self.recipe.differences(&Settings::from(recipe));
        match differences.is_empty() {
            true => Ok(()),
            false => Err(LogError::Recipe {
                path: self.path.clone(),
                differences: differences.join(", "),
            }),
        }
    }

    fn check_mesh(&self, hash: &str) -> Result<(), LogError> {
        let expected = self.recipe.mesh_hash.clone().unwrap_or_default();
        match expected == hash {
            true => Ok(()),
            false => Err(LogError::Mesh {
                path: self.path.clone(),
                found: hash.to_owned(),
                expected,
            }),
        }
    }

    /// The lichen that the run has grown, every element to the last bit, to be measured or drawn. However far it was
    /// to go, it is as far as it has come.
    ///
    /// The substrate is the run's: [`Log::recipe`] says from which file, with which
    /// [axis up](Substrate::with_up) and with which [mask](Substrate::with_mask).
    ///
    /// # Errors
    /// [`LogError::Mesh`] when it is another mesh; [`LogError::Run`] when it has another axis up or another mask, or
    /// the elements cannot be of such a run.
    pub fn cluster(&self, substrate: &Substrate) -> Result<Cluster, LogError> {
        self.check_mesh(substrate.mesh_hash())?;
        self.regrown(substrate).map_err(|problem| LogError::Run {
            path: self.path.clone(),
            problem: Box::new(problem),
        })
    }

    fn regrown(&self, substrate: &Substrate) -> Result<Cluster, GrowError> {
        // Settings that say neither would be resolved for whatever the substrate has.
        if !substrate.has_up(self.recipe.mesh_up) {
            return Err(GrowError::Up);
        }
        if substrate.mask().is_some() && self.recipe.mask_hash.is_none() {
            return Err(GrowError::Mask);
        }
        let mesh = self.recipe.mesh.as_deref().unwrap_or_default();
        let mut recipe = self.recipe.clone().resolve(substrate, mesh)?;
        // The run may have been extended beyond the size that its recipe began with.
        let elements = self.begun.elements.len().max(recipe.at.len());
        recipe.stop = StopRule::Elements(elements as u64);
        let run = Run::new(substrate, &recipe, self.begun.clone())?;
        Ok(run.into_cluster())
    }
}

fn open(path: &Path) -> Result<File, LogError> {
    input::regular(path).map_err(LogError::read(path))
}

/// How many elements a log has, by the heads of its blocks alone: at once, and no proof that they are sound.
///
/// # Errors
/// When it cannot be read, or is none of this version.
pub fn count_elements(path: &Path) -> Result<u64, LogError> {
    let read = LogError::read(path);
    let mut file = open(path)?;
    let length = file.metadata().map_err(&read)?.len();
    let mut at = read_head(path, &mut file)?.length;
    let mut elements = 0;
    while let Some(block) = Outline::read(&mut file, at).map_err(&read)? {
        at += block.length;
        if block.first != elements || at > length {
            break;
        }
        elements += block.number;
    }
    Ok(elements)
}

/// Whether the unsound bytes from `at` on had been durable once: a whole block among them was
/// written when what is at `at` was durable. If none was, they are of a write that never ended.
fn was_durable(file: &mut (impl Read + Seek), seal: Seal, at: u64) -> io::Result<bool> {
    const WINDOW: u64 = 1 << 20;
    let mut bytes = Vec::new();
    let mut from = at;
    loop {
        file.seek(SeekFrom::Start(from))?;
        bytes.clear();
        file.take(WINDOW).read_to_end(&mut bytes)?;
        let windows = bytes.windows(MARKER.len()).enumerate();
        for (i, _) in windows.filter(|(_, w)| *w == MARKER) {
            if is_block_after(file, seal, from + i as u64, at)? {
                return Ok(true);
            }
        }
        if (bytes.len() as u64) < WINDOW {
            return Ok(false);
        }
        from += WINDOW - (MARKER.len() as u64 - 1);
    }
}

/// Whether here is a whole block that was written when what is at `at` was durable. Its head is looked at first: what
/// looks like a marker may be there often, and a block is long to read.
fn is_block_after(
    file: &mut (impl Read + Seek),
    seal: Seal,
    here: u64,
    at: u64,
) -> io::Result<bool> {
    let head = Outline::read(file, here)?;
    Ok(head.is_some_and(|head| head.durable > at) && Block::read(file, seal, here)?.is_some())
}
