//! A small motion of every joint out and back, along 16 x² (1 - x)².

use bytemuck::{Pod, Zeroable};
use shared::arm::JOINTS;

use crate::config::Joint;
use crate::estimator::FRACTION_BITS;
use crate::math::round_to_i32;
use crate::path::SetPoint;

/// Duration and amplitudes of such a motion.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Bump {
    /// Duration, and its inverse.
    pub ticks: u32,
    per_tick: f32,
    per_s: f32,
    /// Amplitude in position words, and in rad and m.
    pub(super) words: [f32; JOINTS],
    si: [f32; JOINTS],
}

impl Bump {
    /// Of these amplitudes, rad and m.
    #[inline(never)]
    pub fn set(
        &mut self,
        duration_s: f32,
        tick_hz: f32,
        amplitude: &[f32; JOINTS],
        joints: &[Joint; JOINTS],
    ) {
        self.ticks = (duration_s * tick_hz + 0.5) as u32;
        self.per_tick = 1.0 / (duration_s * tick_hz);
        self.per_s = 1.0 / duration_s;
        self.si = *amplitude;
        for ((words, a), joint) in self.words.iter_mut().zip(amplitude).zip(joints) {
            *words = a / joint.encoder_lsb * (1 << FRACTION_BITS) as f32;
        }
    }

    /// One tick on, where such motions follow each other.
    #[inline(always)]
    pub fn advance(&self, tick: &mut u32) {
        *tick = if *tick < self.ticks { *tick + 1 } else { 1 };
    }

    /// The tick at which the motion is where it is at `tick`, but on its way back; 0 before it has begun.
    pub fn way_back(&self, tick: u32) -> u32 {
        let mirrored = self.ticks.saturating_sub(tick);
        if tick == 0 || tick > mirrored { tick } else { mirrored }
    }

    /// Adds the motion, this many ticks after it began, to a set-point.
    #[inline(never)]
    pub fn add(&self, tick: u32, to: &mut SetPoint) {
        if tick == 0 || tick >= self.ticks {
            return;
        }
        let x = tick as f32 * self.per_tick;
        let y = x * (1.0 - x);
        let (s, ds, dds) = (16.0 * y * y, 32.0 * y * (1.0 - 2.0 * x), 32.0 * (1.0 - 6.0 * y));
        let (ds, dds) = (ds * self.per_s, dds * (self.per_s * self.per_s));
        for j in 0..JOINTS {
            let way = round_to_i32(self.words[j] * s);
            to.position[j] = to.position[j].wrapping_add_signed(way);
            to.velocity[j] += self.si[j] * ds;
            to.acceleration[j] += self.si[j] * dds;
        }
    }
}
