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

    /// Puts the set-point this many ticks after the motion began at `pose` where it is wanted.
    #[inline(never)]
    pub fn place(&self, pose: &[u32; JOINTS], tick: u32, to: &mut SetPoint) {
        // At its start and end x is 0 or 1 but for rounding, and the arm stands still.
        let inside = tick != 0 && tick < self.ticks;
        let x = if inside { tick as f32 * self.per_tick } else { 0.0 };
        let y = x * (1.0 - x);
        let (s, ds, dds) = (16.0 * y * y, 32.0 * y * (1.0 - 2.0 * x), 32.0 * (1.0 - 6.0 * y));
        let dds = if inside { dds } else { 0.0 };
        let (ds, dds) = (ds * self.per_s, dds * (self.per_s * self.per_s));
        for (j, origin) in pose.iter().enumerate() {
            to.position[j] = origin.wrapping_add_signed(round_to_i32(self.words[j] * s));
            to.velocity[j] = self.si[j] * ds;
            to.acceleration[j] = self.si[j] * dds;
        }
    }
}
