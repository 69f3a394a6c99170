//! `EXT_meshopt_compression` and `KHR_meshopt_compression` buffer views, decoded by the `meshopt`
//! crate.
//!
//! The C++ decoders stop at the end of malformed data, but assert their preconditions: those are
//! checked here first.

use ::meshopt::encoding::{
    decode_filter_exp, decode_filter_oct, decode_filter_quat, decode_index_buffer,
    decode_index_sequence, decode_vertex_buffer,
};

use super::gltf_schema::Compressed;

/// Most bytes that one compressed byte can stand for: a vertex block spends two bits a channel on
/// up to 256 equal bytes.
const BEST_RATIO: usize = 1024;
/// Allowed in addition, so that tiny views of tiny data pass.
const SLACK: usize = 1 << 16;

/// Widest vertex that the codec knows, in bytes.
const WIDEST: usize = 256;

/// Decodes a view to `count * byte_stride` bytes, which may be as many as there is `room` for.
///
/// # Errors
/// In words, when the description is impossible or the data malformed.
pub(super) fn decode(view: &Compressed, data: &[u8], room: usize) -> Result<Vec<u8>, String> {
    let (count, stride) = (view.count, view.byte_stride);
    let size = count.saturating_mul(stride);
    if size > data.len().saturating_mul(BEST_RATIO).saturating_add(SLACK) {
        return Err(format!(
            "{} bytes cannot hold {count} elements of {stride} bytes",
            data.len()
        ));
    }
    if size > room {
        return Err(format!(
            "{count} elements of {stride} bytes, and {room} bytes is all that its compressed data may still unfold to"
        ));
    }
    if count == 0 {
        return Ok(Vec::new());
    }
    let filter = view.filter.as_deref().unwrap_or("NONE");
    match (view.mode.as_ref(), stride) {
        ("ATTRIBUTES", 4..=WIDEST) if stride % 4 == 0 => attributes(data, count, stride, filter),
        ("TRIANGLES", 2) if count % 3 == 0 => {
            bytes(decode_index_buffer::<u16>(data, count), |i| i.to_le_bytes())
        }
        ("TRIANGLES", 4) if count % 3 == 0 => {
            bytes(decode_index_buffer::<u32>(data, count), |i| i.to_le_bytes())
        }
        ("INDICES", 2) => bytes(decode_index_sequence::<u16>(data, count), |i| {
            i.to_le_bytes()
        }),
        ("INDICES", 4) => bytes(decode_index_sequence::<u32>(data, count), |i| {
            i.to_le_bytes()
        }),
        (mode, _) => Err(format!(
            "mode {mode} with {count} elements of {stride} bytes is invalid"
        )),
    }
}

fn bytes<T: Copy, const N: usize>(
    decoded: ::meshopt::Result<Vec<T>>,
    to_bytes: impl Fn(T) -> [u8; N],
) -> Result<Vec<u8>, String> {
    let values = decoded.map_err(|e| e.to_string())?;
    Ok(values.iter().flat_map(|&value| to_bytes(value)).collect())
}

/// A vertex of `N` 32-bit words: the decoder wants a type of the stride's size.
#[derive(Clone, Copy)]
struct Words<const N: usize>([u32; N]);

impl<const N: usize> Default for Words<N> {
    fn default() -> Self {
        Self([0; N])
    }
}

/// Calls `vertices::<stride / 4>`.
macro_rules! by_words {
    ($words:expr, $call:ident $args:tt, $($n:literal)*) => {
        match $words {
            $($n => $call::<$n> $args,)*
            words => Err(format!("vertices of {words} words are not supported")),
        }
    };
}

fn attributes(data: &[u8], count: usize, stride: usize, filter: &str) -> Result<Vec<u8>, String> {
    by_words!(stride / 4, vertices(data, count, filter),
        1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32
        33 34 35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62
        63 64)
}

fn vertices<const N: usize>(data: &[u8], count: usize, filter: &str) -> Result<Vec<u8>, String> {
    let decoded = decode_vertex_buffer::<Words<N>>(data, count).map_err(|e| e.to_string())?;
    let mut words: Vec<[u32; N]> = decoded.into_iter().map(|vertex| vertex.0).collect();
    match (filter, N) {
        ("NONE", _) => {}
        ("EXPONENTIAL", _) => decode_filter_exp(&mut words),
        ("QUATERNION", 2) => filter_shorts(&mut words, decode_filter_quat),
        ("OCTAHEDRAL", 2) => filter_shorts(&mut words, decode_filter_oct),
        ("OCTAHEDRAL", 1) => filter_bytes(&mut words),
        _ => {
            return Err(format!(
                "filter {filter} on {} bytes is not supported",
                4 * N
            ));
        }
    }
    Ok(words
        .iter()
        .flatten()
        .flat_map(|word| word.to_le_bytes())
        .collect())
}

/// Applies a filter of four 16-bit components to vertices of two words.
fn filter_shorts<const N: usize>(words: &mut [[u32; N]], filter: impl Fn(&mut [[i16; 4]])) {
    let half = |word: u32, shift: u32| (word >> shift) as u16 as i16;
    let pack = |low: i16, high: i16| u32::from(low as u16) | u32::from(high as u16) << 16;
    let mut shorts: Vec<[i16; 4]> = words
        .iter()
        .map(|w| [half(w[0], 0), half(w[0], 16), half(w[1], 0), half(w[1], 16)])
        .collect();
    filter(&mut shorts);
    for (word, [x, y, z, w]) in words.iter_mut().zip(shorts) {
        word[0] = pack(x, y);
        word[1] = pack(z, w);
    }
}

/// Applies the octahedral filter to vertices of four 8-bit components.
fn filter_bytes<const N: usize>(words: &mut [[u32; N]]) {
    let mut small: Vec<[i8; 4]> = words
        .iter()
        .map(|w| w[0].to_le_bytes().map(|b| b as i8))
        .collect();
    decode_filter_oct(&mut small);
    for (word, components) in words.iter_mut().zip(small) {
        word[0] = u32::from_le_bytes(components.map(|c| c as u8));
    }
}
