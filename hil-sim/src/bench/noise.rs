//! Bit errors on the bus.

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

/// Bit errors on the way to the controller.
#[derive(Clone)]
pub(super) struct Noise {
    error_share: f64,
    generator: Xoshiro256PlusPlus,
}

impl Noise {
    /// Hits `error_share` of the answers.
    pub(super) fn new(error_share: f64, seed: u64) -> Self {
        Self { error_share, generator: Xoshiro256PlusPlus::seed_from_u64(seed) }
    }

    /// Flips one bit, now and then.
    pub(super) fn disturb(&mut self, miso: &mut [u8]) {
        let draw = self.generator.next_u64();
        // The upper half decides whether, the lower half where.
        let hit = (draw >> 32) as f64 / 4_294_967_296.0 < self.error_share;
        let bits = 8 * miso.len() as u64;
        if hit && bits > 0 {
            let bit = ((draw & 0xFFFF_FFFF) * bits) >> 32;
            miso[(bit / 8) as usize] ^= 1 << (bit % 8);
        }
    }
}
