//! A small motion of every joint out and back, along 16 x² (1 - x)².

use bytemuck::{Pod, Zeroable};
use shared::arm::JOINTS;

use crate::config::Joint;
use crate::estimator::FRACTION_BITS;
use crate::math::round_to_i32;
use crate::path::SetPoint;

/// A joint at this many amplitudes a second or less hardly moves; the motion itself reaches 31, 16 / (3 √3) in its
/// 100 ms.
const SLOW_PER_S: f32 = 80.0;

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

    /// The tick at which the motion is where it is at `tick`, but on its way back.
    pub fn way_back(&self, tick: u32) -> u32 {
        let mirrored = self.ticks.saturating_sub(tick);
        if tick > mirrored { tick } else { mirrored }
    }

    /// Joints that hardly move beside this motion, given their highest speeds as `speed` times `times`, rad/s and m/s;
    /// one bit each.
    pub fn outdoes(&self, speed: &[f32; JOINTS], times: f32) -> u8 {
        let slow = |j: usize| speed[j].abs() * times <= self.si[j] * SLOW_PER_S;
        (0..JOINTS).fold(0, |bits, j| bits | u8::from(slow(j)) << j)
    }

    /// Adds the motion of these joints, this many ticks after it began, to a set-point.
    #[inline(never)]
    pub fn add(&self, tick: u32, joints: u8, to: &mut SetPoint) {
        if tick == 0 || tick >= self.ticks {
            return;
        }
        let x = tick as f32 * self.per_tick;
        let y = x * (1.0 - x);
        let (s, ds, dds) = (16.0 * y * y, 32.0 * y * (1.0 - 2.0 * x), 32.0 * (1.0 - 6.0 * y));
        let (ds, dds) = (ds * self.per_s, dds * (self.per_s * self.per_s));
        for j in 0..JOINTS {
            if joints >> j & 1 == 0 {
                continue;
            }
            let way = round_to_i32(self.words[j] * s);
            to.position[j] = to.position[j].wrapping_add_signed(way);
            to.velocity[j] += self.si[j] * ds;
            to.acceleration[j] += self.si[j] * dds;
        }
    }
}
