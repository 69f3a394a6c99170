//! Small atomics side by side, read and written sixteen bytes at a time.
//!
//! One thread writes to them while others read. What a reader gets of several may be of different times: all that is
//! read here stays right then (see [`ElementIndex`](super::ElementIndex)).

use std::sync::atomic::{AtomicU8, AtomicU32};

use bytemuck::cast;
use wide::{f32x8, u8x16};

use super::field::CUBE;

/// A line of cache of small numbers.
pub(super) type Bytes = [AtomicU8; 64];

/// Eight places in space, axis by axis.
pub(super) type Floats = [AtomicU32; 24];

/// Atomics and nothing else, so that their bytes may be read while others write them.
trait Lanes {}

impl<const N: usize> Lanes for [AtomicU8; N] {}

impl<const N: usize> Lanes for [AtomicU32; N] {}

/// Twenty-four bytes, and eight that are 0.
#[inline(always)]
pub(super) fn three_halves(lanes: &[AtomicU8; 24]) -> [u8x16; 2] {
    [at::<_, 0>(lanes), half_at::<_, 16>(lanes)]
}

/// Eight bytes of 4³ from one on, two along each axis, as [`CUBE`] has them, and eight that are 0.
///
/// # Panics
/// When there are not so many from there on.
#[inline(always)]
pub(super) fn cube(lanes: &Bytes, first: usize) -> u8x16 {
    cube_at(lanes, first)
}

/// The first of eight bytes is before this.
#[cfg(any(test, all(target_arch = "x86_64", not(miri))))]
const FIRSTS: usize = 64 - CUBE[7];

#[inline(always)]
pub(super) fn bytes(lanes: &Bytes) -> [u8x16; 4] {
    [
        at::<_, 0>(lanes),
        at::<_, 16>(lanes),
        at::<_, 32>(lanes),
        at::<_, 48>(lanes),
    ]
}

#[inline(always)]
pub(super) fn set_bytes(lanes: &Bytes, [a, b, c, d]: [u8x16; 4]) {
    set_at::<0>(lanes, a);
    set_at::<16>(lanes, b);
    set_at::<32>(lanes, c);
    set_at::<48>(lanes, d);
}

/// The numbers along each axis, by their bits.
#[inline(always)]
pub(super) fn floats(lanes: &Floats) -> [f32x8; 3] {
    [
        cast([at::<_, 0>(lanes), at::<_, 16>(lanes)]),
        cast([at::<_, 32>(lanes), at::<_, 48>(lanes)]),
        cast([at::<_, 64>(lanes), at::<_, 80>(lanes)]),
    ]
}

#[cfg(all(target_arch = "x86_64", not(miri)))]
use instructions::{at, cube_at, half_at, set_at};
#[cfg(not(all(target_arch = "x86_64", not(miri))))]
use one_by_one::{at, cube_at, half_at, set_at};

/// By instructions for all sixteen bytes: none of the language's atomics is read or written by these.
#[cfg(all(target_arch = "x86_64", not(miri)))]
#[allow(unsafe_code)]
mod instructions {
    use std::arch::asm;
    use std::arch::x86_64::__m128i;

    use super::{Bytes, FIRSTS, Lanes, cast, u8x16};

    /// What an instruction reads of so many bytes of some atomics.
    macro_rules! read {
        ($instruction:literal, $bytes:literal of $lanes:ident from $from:ident) => {{
            const { assert!($from + $bytes <= size_of::<T>()) };
            let read: __m128i;
            // SAFETY: bytes of what a reference is to are read, and nothing else is touched. They are atomics
            // (`Lanes`), each of which the processor reads whole: so this does no more than to load them one by one,
            // relaxed.
            unsafe {
                asm!(
                    concat!($instruction, " {read}, [{lanes} + {from}]"),
                    lanes = in(reg) $lanes,
                    from = const $from,
                    read = lateout(xmm_reg) read,
                    options(pure, readonly, nostack, preserves_flags),
                );
            }
            cast(read)
        }};
    }

    #[inline(always)]
    pub(super) fn at<T: Lanes, const FROM: usize>(lanes: &T) -> u8x16 {
        read!("movdqu", 16 of lanes from FROM)
    }

    #[inline(always)]
    pub(super) fn half_at<T: Lanes, const FROM: usize>(lanes: &T) -> u8x16 {
        read!("movq", 8 of lanes from FROM)
    }

    /// The second row of each layer is four bytes on, the second layer sixteen.
    #[inline(always)]
    pub(super) fn cube_at(lanes: &Bytes, first: usize) -> u8x16 {
        const FIRST_ROWS: [u64; 2] = [0xffff_0000_ffff, 0];
        const SECOND_ROWS: [u64; 2] = [0xffff_0000_ffff_0000, 0];
        assert!(first < FIRSTS);
        let (read, above): (__m128i, __m128i);
        // SAFETY: as above; the last of the bytes, 21 after the first, is one of the lanes.
        unsafe {
            asm!(
                "movq {read}, qword ptr [{first}]",
                "movq {above}, qword ptr [{first} + 14]",
                first = in(reg) lanes.as_ptr().add(first),
                read = out(xmm_reg) read,
                above = lateout(xmm_reg) above,
                options(pure, readonly, nostack, preserves_flags),
            );
        }
        let [read, above]: [u8x16; 2] = [read, above].map(cast);
        let [first_rows, second_rows]: [u8x16; 2] = [FIRST_ROWS, SECOND_ROWS].map(cast);
        read & first_rows | above & second_rows
    }

    #[inline(always)]
    pub(super) fn set_at<const FROM: usize>(lanes: &Bytes, bytes: u8x16) {
        const { assert!(FROM + 16 <= size_of::<Bytes>()) };
        let bytes: __m128i = cast(bytes);
        // SAFETY: sixteen of the atomics that a reference is to are written, and nothing else is touched: no more than
        // to store them one by one, relaxed.
        unsafe {
            asm!(
                "movdqu xmmword ptr [{lanes} + {from}], {bytes}",
                lanes = in(reg) lanes,
                from = const FROM,
                bytes = in(xmm_reg) bytes,
                options(nostack, preserves_flags),
            );
        }
    }
}

/// One by one.
#[cfg(any(test, not(all(target_arch = "x86_64", not(miri)))))]
mod one_by_one {
    use std::sync::atomic::Ordering;

    use super::{AtomicU8, AtomicU32, Bytes, CUBE, Lanes, cast, u8x16};

    /// Sixteen bytes or less from a place on.
    pub(super) trait OneByOne: Lanes {
        fn from(&self, place: usize) -> [u8; 16];
    }

    impl<const N: usize> OneByOne for [AtomicU8; N] {
        fn from(&self, place: usize) -> [u8; 16] {
            let byte = |i: usize| {
                self.get(place + i)
                    .map_or(0, |lane| lane.load(Ordering::Relaxed))
            };
            std::array::from_fn(byte)
        }
    }

    impl<const N: usize> OneByOne for [AtomicU32; N] {
        fn from(&self, place: usize) -> [u8; 16] {
            let number = |i: usize| self[place / 4 + i].load(Ordering::Relaxed);
            cast::<[u32; 4], _>(std::array::from_fn(number))
        }
    }

    pub(super) fn at<T: OneByOne, const FROM: usize>(lanes: &T) -> u8x16 {
        u8x16::new(lanes.from(FROM))
    }

    pub(super) fn half_at<T: OneByOne, const FROM: usize>(lanes: &T) -> u8x16 {
        let [a, b, c, d, e, f, g, h, ..] = lanes.from(FROM);
        u8x16::new([a, b, c, d, e, f, g, h, 0, 0, 0, 0, 0, 0, 0, 0])
    }

    pub(super) fn cube_at(lanes: &Bytes, first: usize) -> u8x16 {
        let bytes = CUBE.map(|step| lanes[first + step].load(Ordering::Relaxed));
        cast([u64::from_le_bytes(bytes), 0])
    }

    pub(super) fn set_at<const FROM: usize>(lanes: &Bytes, bytes: u8x16) {
        for (lane, byte) in lanes[FROM..].iter().zip(bytes.to_array()) {
            lane.store(byte, Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_at_once_is_one_by_one() {
        let lanes: Bytes = std::array::from_fn(|i| AtomicU8::new(3 * i as u8 + 1));
        let numbers: Floats = std::array::from_fn(|i| AtomicU32::new((1.5 * i as f32).to_bits()));
        let some: [AtomicU8; 24] = std::array::from_fn(|i| AtomicU8::new(7 * i as u8));
        assert_eq!(bytes(&lanes)[2], one_by_one::at::<_, 32>(&lanes));
        let expected = [
            one_by_one::at::<_, 0>(&some),
            one_by_one::half_at::<_, 16>(&some),
        ];
        assert_eq!(three_halves(&some), expected);
        for (axis, found) in floats(&numbers).into_iter().enumerate() {
            let expected = std::array::from_fn(|i| 1.5 * (8 * axis + i) as f32);
            assert_eq!(found.to_array(), expected);
        }
        for first in 0..FIRSTS {
            assert_eq!(cube(&lanes, first), one_by_one::cube_at(&lanes, first));
        }
        let turned = bytes(&lanes).map(|bytes| !bytes);
        set_bytes(&lanes, turned);
        assert_eq!(bytes(&lanes), turned);
        one_by_one::set_at::<16>(&lanes, turned[0]);
        assert_eq!(bytes(&lanes), [turned[0], turned[0], turned[2], turned[3]]);
    }
}
