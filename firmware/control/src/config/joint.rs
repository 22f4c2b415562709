//! One joint's encoder, drive, transducer and limits.

use core::slice;

use bytemuck::{Pod, Zeroable};
use shared::arm::Arm;
use shared::wire::biss_c::{LATCH_DELAY_S, Layout};

use super::check::Check;
use super::fields::Field;

/// One joint's encoder, drive, transducer and limits. SI units; joint 4 in m and N.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Joint {
    /// Range of motion.
    pub q_min: f32,
    /// Range of motion.
    pub q_max: f32,
    /// Highest speed of a trajectory.
    pub qd_max: f32,
    /// Highest torque command.
    pub tau_max: f32,
    /// Width of the encoder's position word.
    pub encoder_bits: u32,
    /// One encoder count.
    pub encoder_lsb: f32,
    /// Position at code 0.
    pub encoder_zero: f32,
    /// From the tick instant to the encoder's latch, s.
    pub latch_offset_s: f32,
    /// Drive torque at the DAC's positive full scale.
    pub drive_full_scale: f32,
    /// Measured torque at the ADC's positive full scale.
    pub torque_full_scale: f32,
}

/// Encoder counts a joint may span: positions are kept as 32-bit words with 6 fractional bits.
const SPAN_MAX_COUNTS: f32 = 67_108_864.0;
/// Counts a tick at the speed limit, with 6 fractional bits below the rounder's 2²² and a reserve of 2.
const STEP_MAX_COUNTS: f32 = 32_768.0;

/// Widths of position word that the frame has room for.
pub(super) const BITS_MIN: f32 = 12.0;
pub(super) const BITS_MAX: f32 = 32.0;

pub(super) const fn joint(arm: &Arm, j: usize) -> Joint {
    let limits = arm.limits[j];
    let encoder = arm.encoders[j];
    Joint {
        q_min: limits.q_min as f32,
        q_max: limits.q_max as f32,
        qd_max: limits.qd_max as f32,
        tau_max: limits.tau_max as f32,
        encoder_bits: encoder.bits,
        encoder_lsb: encoder.lsb as f32,
        encoder_zero: encoder.zero as f32,
        latch_offset_s: LATCH_DELAY_S as f32,
        drive_full_scale: arm.drive_full_scale[j] as f32,
        torque_full_scale: arm.torque_full_scale[j] as f32,
    }
}

impl Joint {
    #[inline(never)]
    pub(super) fn validate(&self, check: &mut Check, j: usize, tick_hz: f32) {
        check.group(
            const { Field::named("q_min") },
            j,
            bytemuck::cast_slice(slice::from_ref(self)),
        );
        let top = self.q_min;
        check.one(const { Field::named("q_max") }, j, self.q_max, top, 60.0);
        let bottom = self.q_max - SPAN_MAX_COUNTS * self.encoder_lsb;
        check.one(const { Field::named("encoder_zero") }, j, self.encoder_zero, bottom, top);
        let step_max = self.encoder_lsb * STEP_MAX_COUNTS * tick_hz;
        let step = const { Field::named("qd_max against encoder_lsb") };
        check.one(step, j, self.qd_max, 0.0, step_max);
        let (drive, sensor) = (self.drive_full_scale, self.torque_full_scale);
        check.one(const { Field::named("drive_full_scale") }, j, drive, self.tau_max, 2e6);
        check.one(const { Field::named("torque_full_scale") }, j, sensor, self.tau_max, 2e6);
    }
}

impl Joint {
    /// Layout of the encoder's frames; one that fits no frame for a width that validation refuses.
    #[inline(never)]
    pub fn layout(&self) -> Layout {
        Layout::new(self.encoder_bits).unwrap_or_default()
    }
}
