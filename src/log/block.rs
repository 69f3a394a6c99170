//! A block of elements as bytes, little-endian: marker, number of elements, age of the first, bytes
//! of the log that were durable before, counts after the last birth, the elements, CRC-32 of the log's head and of this.

use std::io::{self, Read, Seek, SeekFrom};

use glam::DVec3;

use crate::cluster::Element;
use crate::growth::{COUNTS, Counts};
use crate::substrate::SurfacePoint;

/// Elements of a block at most. Blocks end at the multiples of this number, if not sooner.
pub const LARGEST_BLOCK: usize = 1 << 16;

/// What a block begins with: no number that a lichen is likely to hold.
pub(super) const MARKER: [u8; 8] = *b"\xf5\xb1ock\r\n\xfe";

/// Bytes before the elements, of an element, and after the elements.
pub(super) const HEAD: usize = 8 + 4 + 8 + 8 + 8 * COUNTS;
const ELEMENT: usize = 60;
const CHECKSUM: usize = 4;

/// What ties blocks to the head of their log: its checksum. Runs of other recipes have others, and blocks of theirs are
/// none of this log, however sound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Seal(pub(super) u32);

impl Seal {
    fn checksum(self, content: &[u8]) -> u32 {
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(&self.0.to_le_bytes());
        hasher.update(content);
        hasher.finalize()
    }
}

/// A block that is being filled.
#[derive(Debug)]
pub(super) struct Draft {
    bytes: Vec<u8>,
    first: u64,
}

impl Draft {
    /// Empty, for elements from this age on.
    pub(super) fn new(first: u64) -> Self {
        Self {
            bytes: vec![0; HEAD],
            first,
        }
    }

    /// How many elements it has.
    pub(super) fn len(&self) -> usize {
        (self.bytes.len() - HEAD) / ELEMENT
    }

    pub(super) fn push(&mut self, element: &Element) {
        let Element {
            at,
            position,
            parent,
            colony,
            probability,
        } = element;
        let mut bytes = [0; ELEMENT];
        let (whole, real) = bytes.split_at_mut(12);
        put(whole, [at.triangle, *parent, *colony].map(u32::to_le_bytes));
        let numbers = [at.u, at.v, position.x, position.y, position.z, *probability];
        put(real, numbers.map(f64::to_le_bytes));
        self.bytes.extend_from_slice(&bytes);
    }

    /// The block's bytes, of the log with this seal; `durable` is the length of the log that a power failure cannot
    /// touch.
    pub(super) fn close(mut self, seal: Seal, durable: u64, counts: &Counts) -> Vec<u8> {
        let number = self.len() as u32;
        let (marker, rest) = self.bytes[..HEAD].split_at_mut(8);
        marker.copy_from_slice(&MARKER);
        let (count, rest) = rest.split_at_mut(4);
        count.copy_from_slice(&number.to_le_bytes());
        let (places, rest) = rest.split_at_mut(16);
        put(places, [self.first, durable].map(u64::to_le_bytes));
        put(rest, counts.numbers().map(u64::to_le_bytes));
        let checksum = seal.checksum(&self.bytes);
        self.bytes.extend_from_slice(&checksum.to_le_bytes());
        self.bytes
    }
}

/// A block that was read and found whole.
pub(super) struct Block {
    pub(super) first: u64,
    pub(super) counts: Counts,
    pub(super) elements: Vec<Element>,
    /// Its length in bytes.
    pub(super) length: u64,
}

impl Block {
    /// Reads the block that begins `at` this byte, if a whole one of the log with this seal does.
    pub(super) fn read(
        file: &mut (impl Read + Seek),
        seal: Seal,
        at: u64,
    ) -> io::Result<Option<Self>> {
        file.seek(SeekFrom::Start(at))?;
        let mut bytes = vec![0; HEAD];
        if !fill(file, &mut bytes)? || bytes[..8] != MARKER {
            return Ok(None);
        }
        let number = u32::from_le_bytes(array(&bytes[8..12])) as usize;
        if number == 0 || number > LARGEST_BLOCK {
            return Ok(None);
        }
        bytes.resize(HEAD + number * ELEMENT + CHECKSUM, 0);
        let whole = fill(file, &mut bytes[HEAD..])?;
        Ok(whole.then(|| Self::parse(&bytes, seal)).flatten())
    }

    fn parse(bytes: &[u8], seal: Seal) -> Option<Self> {
        let (content, checksum) = bytes.split_at(bytes.len() - CHECKSUM);
        if seal.checksum(content) != u32::from_le_bytes(array(checksum)) {
            return None;
        }
        let number = |at: usize| u64::from_le_bytes(array(&content[at..at + 8]));
        let counts = std::array::from_fn(|i| number(28 + 8 * i));
        Some(Self {
            first: number(12),
            counts: Counts::from_numbers(counts),
            elements: content[HEAD..].chunks_exact(ELEMENT).map(element).collect(),
            length: bytes.len() as u64,
        })
    }
}

/// What the head of a block says, whether or not the rest is sound.
pub(super) struct Outline {
    pub(super) first: u64,
    pub(super) durable: u64,
    pub(super) number: u64,
    /// Its length in bytes.
    pub(super) length: u64,
}

impl Outline {
    /// Reads the head of the block that begins `at` this byte, if one does.
    pub(super) fn read(file: &mut (impl Read + Seek), at: u64) -> io::Result<Option<Self>> {
        file.seek(SeekFrom::Start(at))?;
        let mut head = [0; HEAD];
        let whole = fill(file, &mut head)?;
        Ok(whole.then(|| Self::parse(&head)).flatten())
    }

    fn parse(head: &[u8; HEAD]) -> Option<Self> {
        let number = u32::from_le_bytes(array(&head[8..12])) as usize;
        let sensible = head[..8] == MARKER && (1..=LARGEST_BLOCK).contains(&number);
        sensible.then(|| Self {
            first: u64::from_le_bytes(array(&head[12..20])),
            durable: u64::from_le_bytes(array(&head[20..28])),
            number: number as u64,
            length: (HEAD + number * ELEMENT + CHECKSUM) as u64,
        })
    }
}

/// Fills a buffer, or says that the file ends before.
pub(super) fn fill(file: &mut impl Read, buffer: &mut [u8]) -> io::Result<bool> {
    match file.read_exact(buffer) {
        Ok(()) => Ok(true),
        Err(e) if e.kind() == io::ErrorKind::UnexpectedEof => Ok(false),
        Err(e) => Err(e),
    }
}

fn element(bytes: &[u8]) -> Element {
    let whole = |i: usize| u32::from_le_bytes(array(&bytes[4 * i..4 * i + 4]));
    let real = |i: usize| f64::from_le_bytes(array(&bytes[12 + 8 * i..20 + 8 * i]));
    Element {
        at: SurfacePoint {
            triangle: whole(0),
            u: real(0),
            v: real(1),
        },
        position: DVec3::new(real(2), real(3), real(4)),
        parent: whole(1),
        colony: whole(2),
        probability: real(5),
    }
}

fn array<const N: usize>(bytes: &[u8]) -> [u8; N] {
    std::array::from_fn(|i| bytes[i])
}

/// Numbers one after the other into a slice that has just room for them.
fn put<const SIZE: usize, const N: usize>(to: &mut [u8], numbers: [[u8; SIZE]; N]) {
    to.copy_from_slice(numbers.as_flattened());
}
