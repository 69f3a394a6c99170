//! The only source of randomness.
//!
//! Random numbers are addressed, not drawn from a shared source: a [`Stream`] is named by
//! (seed, purpose, index), so walker 17 sees the same numbers whoever runs it and when. The
//! generator is ChaCha8 (rand's `ChaCha8Rng`, whose output is part of its contract).

use glam::DVec2;
use rand::SeedableRng;
use rand::rand_core::Rng;
use rand::rngs::ChaCha8Rng;

/// Everything that random numbers are used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// A walker's launch, steps and sticking; the index is the walker's number.
    Walker = 1,
    /// The place of a seed element; the index is the colony.
    SeedPlace = 2,
}

/// A stream of random numbers of its own.
pub struct Stream(ChaCha8Rng);

impl Stream {
    /// The stream for a purpose and index under a seed.
    pub fn new(seed: u64, purpose: Purpose, index: u64) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8..16].copy_from_slice(&(purpose as u64).to_le_bytes());
        let mut generator = ChaCha8Rng::from_seed(key);
        generator.set_stream(index);
        Self(generator)
    }

    /// Uniform in [0, 1), a multiple of 2⁻⁵³.
    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Uniform by area in the unit disc without its centre, by rejection from the square.
    pub fn in_unit_disc(&mut self) -> DVec2 {
        loop {
            let p = DVec2::new(2.0 * self.uniform() - 1.0, 2.0 * self.uniform() - 1.0);
            let length_sq = p.length_squared();
            if length_sq > 0.0 && length_sq <= 1.0 {
                return p;
            }
        }
    }
}
