//! Small atomics side by side, read and written sixteen bytes at a time.
//!
//! One thread writes to them while others read. What a reader gets of several may be of different times: all that is
//! read here stays right then (see [`ElementIndex`](super::ElementIndex)).

use std::sync::atomic::{AtomicU8, AtomicU32, Ordering};

use bytemuck::cast;
use wide::{f32x8, u8x16};

#[inline(always)]
pub(super) fn bytes(lanes: &[AtomicU8; 16]) -> u8x16 {
    sixteen::load_bytes(lanes)
}

/// Eight bytes, and eight that are 0.
#[inline(always)]
pub(super) fn half(lanes: &[AtomicU8; 8]) -> u8x16 {
    sixteen::load_half(lanes)
}

#[inline(always)]
pub(super) fn set_bytes(lanes: &[AtomicU8; 16], bytes: u8x16) {
    sixteen::store_bytes(lanes, bytes);
}

/// Eight numbers, by their bits.
#[inline(always)]
pub(super) fn floats(lanes: &[[AtomicU32; 4]; 2]) -> f32x8 {
    cast([0, 1].map(|half| sixteen::load_numbers(&lanes[half])))
}

/// Sets a lane to a number.
#[inline(always)]
pub(super) fn set_float(lanes: &[[AtomicU32; 4]; 2], lane: usize, number: f32) {
    lanes.as_flattened()[lane].store(number.to_bits(), Ordering::Relaxed);
}

/// By instructions for all sixteen bytes, which no atomic of the language is read or written by.
#[cfg(all(target_arch = "x86_64", not(miri)))]
#[allow(unsafe_code)]
mod sixteen {
    use std::arch::asm;
    use std::arch::x86_64::__m128i;

    use super::{AtomicU8, AtomicU32, cast, u8x16};

    #[inline(always)]
    pub(super) fn load_bytes(lanes: &[AtomicU8; 16]) -> u8x16 {
        load(lanes)
    }

    #[inline(always)]
    pub(super) fn load_numbers(lanes: &[AtomicU32; 4]) -> u8x16 {
        load(lanes)
    }

    #[inline(always)]
    pub(super) fn load_half(lanes: &[AtomicU8; 8]) -> u8x16 {
        let bytes: __m128i;
        // SAFETY: as `load`, with eight bytes.
        unsafe {
            asm!(
                "movq {bytes}, qword ptr [{lanes}]",
                lanes = in(reg) lanes,
                bytes = lateout(xmm_reg) bytes,
                options(pure, readonly, nostack, preserves_flags),
            );
        }
        cast(bytes)
    }

    #[inline(always)]
    fn load<T>(lanes: &T) -> u8x16 {
        const { assert!(size_of::<T>() == 16) };
        let bytes: __m128i;
        // SAFETY: sixteen bytes that a reference is to are read, and nothing else is touched. They are atomics, each of
        // which the processor reads whole: so this does no more than to load them one by one, relaxed.
        unsafe {
            asm!(
                "movdqu {bytes}, xmmword ptr [{lanes}]",
                lanes = in(reg) lanes,
                bytes = lateout(xmm_reg) bytes,
                options(pure, readonly, nostack, preserves_flags),
            );
        }
        cast(bytes)
    }

    #[inline(always)]
    pub(super) fn store_bytes(lanes: &[AtomicU8; 16], bytes: u8x16) {
        let bytes: __m128i = cast(bytes);
        // SAFETY: sixteen atomics that a reference is to are written, and nothing else is touched: no more than to store
        // them one by one, relaxed.
        unsafe {
            asm!(
                "movdqu xmmword ptr [{lanes}], {bytes}",
                lanes = in(reg) lanes,
                bytes = in(xmm_reg) bytes,
                options(nostack, preserves_flags),
            );
        }
    }
}

/// One by one.
#[cfg(not(all(target_arch = "x86_64", not(miri))))]
mod sixteen {
    use super::{AtomicU8, AtomicU32, Ordering, cast, u8x16};

    pub(super) fn load_bytes(lanes: &[AtomicU8; 16]) -> u8x16 {
        u8x16::new(std::array::from_fn(|i| lanes[i].load(Ordering::Relaxed)))
    }

    pub(super) fn load_half(lanes: &[AtomicU8; 8]) -> u8x16 {
        let byte = |i: usize| lanes.get(i).map_or(0, |lane| lane.load(Ordering::Relaxed));
        u8x16::new(std::array::from_fn(byte))
    }

    pub(super) fn load_numbers(lanes: &[AtomicU32; 4]) -> u8x16 {
        let numbers: [u32; 4] = std::array::from_fn(|i| lanes[i].load(Ordering::Relaxed));
        cast(numbers)
    }

    pub(super) fn store_bytes(lanes: &[AtomicU8; 16], bytes: u8x16) {
        for (lane, byte) in lanes.iter().zip(bytes.to_array()) {
            lane.store(byte, Ordering::Relaxed);
        }
    }
}
