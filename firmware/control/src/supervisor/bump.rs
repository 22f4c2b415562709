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

    /// Set-point this many ticks after the motion began at `pose`.
    #[inline(never)]
    pub fn set_point(&self, pose: &[u32; JOINTS], tick: u32) -> SetPoint {
        let mut set_point = SetPoint::hold(*pose);
        if tick == 0 || tick >= self.ticks {
            return set_point;
        }
        let x = tick as f32 * self.per_tick;
        let y = x * (1.0 - x);
        let (s, ds, dds) = (16.0 * y * y, 32.0 * y * (1.0 - 2.0 * x), 32.0 * (1.0 - 6.0 * y));
        let (ds, dds) = (ds * self.per_s, dds * (self.per_s * self.per_s));
        let amplitudes = self.words.iter().zip(&self.si);
        let slots = set_point.position.iter_mut().zip(&mut set_point.velocity);
        let slots = slots.zip(&mut set_point.acceleration);
        for (((position, velocity), acceleration), (words, si)) in slots.zip(amplitudes) {
            *position = position.wrapping_add_signed(round_to_i32(words * s));
            (*velocity, *acceleration) = (si * ds, si * dds);
        }
        set_point
    }
}
