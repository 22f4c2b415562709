//! A straight line in joint space, for jogging and for stopping from a measured speed.

use shared::arm::JOINTS;

use super::{Phase, Rate, SetPoint};

/// Position words `origin + velocity · phase`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Line {
    /// Position words at phase 0.
    pub origin: [u32; JOINTS],
    /// Word steps a tick at full rate, with 8 fractional bits.
    pub velocity_q8: [i32; JOINTS],
    /// The same in rad/s and m/s.
    pub velocity: [f32; JOINTS],
}

impl Line {
    /// Whether both lines lead the same way at the same speed.
    pub fn is_parallel_to(&self, other: &Self) -> bool {
        self.velocity_q8 == other.velocity_q8
    }

    /// Puts the set-point at `phase`, passed at `rate`, where it is wanted.
    #[inline(never)]
    pub fn place(&self, phase: Phase, rate: Rate, to: &mut SetPoint) {
        for j in 0..JOINTS {
            let velocity = i64::from(self.velocity_q8[j]);
            let whole = velocity.wrapping_mul(i64::from(phase.ticks)) >> 8;
            let rest = (velocity * i64::from(phase.fraction >> 8)) >> 32;
            to.position[j] = self.origin[j].wrapping_add((whole + rest) as u32);
            to.velocity[j] = self.velocity[j] * rate.value;
            to.acceleration[j] = self.velocity[j] * rate.slope_per_s;
        }
    }
}
