//! All limits of the monitors and times of the supervisor, in ticks, counts and codes. `config::Safety` says
//! where each comes from.

use bytemuck::{Pod, Zeroable};
use shared::arm::JOINTS;

use super::clock::ClockLimits;
use super::motion::MotionLimits;
use super::torque::TorqueLimits;
use crate::config::{Config, Law};
use crate::estimator::FRACTION_BITS;
use crate::supervisor::Timing;

/// How far a code may be from where it is expected, counts.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct EncoderLimits {
    /// Under control.
    pub tight: [u32; JOINTS],
    /// Where a joint may be limp, dragged or braked.
    pub wide: [u32; JOINTS],
    /// Motion of the set-point that a code must follow, word steps.
    pub stuck: u32,
    /// Ticks within which it must follow any motion at all.
    pub patience: u32,
    /// Ticks² of the set-point's acceleration that it may lag behind.
    pub lag: f32,
    /// Word steps a tick² for 1 rad/s² and 1 m/s².
    pub per_acceleration: [f32; JOINTS],
}

/// Quantisation of three codes and the step of the model: half a count each, twice the middle one, and the
/// rounding of two predictions; doubled.
const QUANTISATION: f32 = 8.0;
/// A joint lags behind its set-point by some counts while the law learns its load, so that where it turns the set-point
/// is back by twice as many before the joint moves again; the PD lags by up to 600.
const fn stuck_counts(law: Law) -> u32 {
    match law {
        Law::PD => 1_024,
        _ => 40,
    }
}
/// The delay of 1.5 ticks over the law's 0.2 a tick is 7.5, twice that where a joint turns, and a fourfold margin.
const LAG_TICKS2: f32 = 64.0;
/// A quarter of the watch motion, and five time constants of the law's 200 rad/s.
const STALLED_S: f32 = 0.025;
/// The other laws let errors grow while they learn a load, or for good.
const fn patience_ticks(law: Law, tick_hz: f32) -> u32 {
    match law {
        Law::INERTIA_WEIGHTED => (STALLED_S * tick_hz) as u32,
        _ => u32::MAX,
    }
}
const WORDS: f32 = (1 << FRACTION_BITS) as f32;

impl EncoderLimits {
    /// For a validated configuration.
    #[inline(never)]
    pub fn set(&mut self, config: &Config) {
        let (safety, tick_hz) = (&config.safety, config.tick_hz as f32);
        self.stuck = stuck_counts(config.gains.law) << FRACTION_BITS;
        self.patience = patience_ticks(config.gains.law, tick_hz);
        self.lag = LAG_TICKS2;
        for (j, joint) in config.joints.iter().enumerate() {
            // An acceleration moves the next code by its way in one tick squared.
            let window =
                |a: f32| (QUANTISATION + a / (tick_hz * tick_hz * joint.encoder_lsb)) as u32;
            self.tight[j] = window(safety.unforeseen[j]);
            self.wide[j] = window(safety.violent[j]);
            self.per_acceleration[j] = WORDS / (tick_hz * tick_hz * joint.encoder_lsb);
        }
    }
}

/// See the module's documentation.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Thresholds {
    /// Plausibility of codes.
    pub encoder: EncoderLimits,
    /// Torque against its command.
    pub torque: TorqueLimits,
    /// Speed, range, distance.
    pub motion: MotionLimits,
    /// Time.
    pub clock: ClockLimits,
    /// Times of the supervisor.
    pub timing: Timing,
}

impl Thresholds {
    /// For a validated configuration; filled group by group, so that a small stack is enough.
    #[inline(never)]
    pub fn set(&mut self, config: &Config) {
        self.encoder.set(config);
        self.torque.set(config);
        self.motion.set(config);
        self.clock.set(config);
        self.timing.set(config);
    }
}
