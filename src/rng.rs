//! The only source of randomness in growth. Pictures and a skin's areoles take theirs from hashes of where they look.
//!
//! Random numbers are addressed, not drawn from a shared source: a [`Stream`] is named by
//! (seed, purpose, index), so walker 17 sees the same numbers whoever runs it and when. The
//! generator is xoshiro256++ (Blackman & Vigna 2021; rand's `Xoshiro256PlusPlus`), its 256 bits of
//! state filled from the name by SplitMix64, as its authors advise.

use std::hint::select_unpredictable;

use glam::DVec2;
use rand::SeedableRng;
use rand::rand_core::Rng;
use rand::rngs::Xoshiro256PlusPlus;

/// What growth uses random numbers for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// A walker's launch, steps and sticking; the index is the walker's number.
    Walker = 1,
    /// The place of a seed element; the index is the colony.
    SeedPlace = 2,
    /// Places looked at for how much of a surface lichen may grow on, whatever the seed.
    Habitat = 3,
}

/// A stream of random numbers of its own.
#[derive(Clone, Debug)]
pub struct Stream(Xoshiro256PlusPlus);

impl Stream {
    /// The stream for a purpose and index under a seed.
    ///
    /// Streams of one seed and purpose start from different states; others share one with
    /// probability 2⁻⁶⁴.
    pub fn new(seed: u64, purpose: Purpose, index: u64) -> Self {
        let under_seed = mix(seed).wrapping_add(purpose as u64);
        let name = mix(under_seed).wrapping_add(index);
        Self(Xoshiro256PlusPlus::seed_from_u64(mix(name)))
    }

    /// Uniform in [0, 1), a multiple of 2⁻⁵³.
    #[inline]
    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Uniform by area in the unit disc, by rejection from the square. Coordinates are odd
    /// multiples of 2⁻³², so the centre never comes.
    #[inline]
    pub fn in_unit_disc(&mut self) -> DVec2 {
        loop {
            // Two at a time: a place that falls outside is not to be foreseen, two in a row are rare.
            let [p, q] = [self.0.next_u64(), self.0.next_u64()].map(in_square);
            let [p_is_in, q_is_in] = [p, q].map(|p| p.length_squared() <= 1.0);
            if p_is_in | q_is_in {
                return DVec2::new(
                    select_unpredictable(p_is_in, p.x, q.x),
                    select_unpredictable(p_is_in, p.y, q.y),
                );
            }
        }
    }
}

/// A place in the square about the disc from 64 uniform bits.
#[inline(always)]
fn in_square(bits: u64) -> DVec2 {
    DVec2::new(centred(bits as u32), centred((bits >> 32) as u32))
}

/// A uniform number in (−1, 1) from 32 uniform bits.
#[inline]
fn centred(bits: u32) -> f64 {
    (f64::from(bits as i32) + 0.5) * (1.0 / (1u64 << 31) as f64)
}

/// One step of SplitMix64 (Steele, Lea & Flood 2014): a bijection that spreads every bit.
fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
