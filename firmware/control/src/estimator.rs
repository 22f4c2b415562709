//! Position and velocity of a joint from its encoder, by a two-state tracking observer.
//!
//! Positions are 32-bit words: encoder counts with [`FRACTION_BITS`] fractional bits. An `f32` position
//! would have an ulp of 4.8e-7 m at 4 m; the difference of two such words is exact.

use crate::config::Joint;
use crate::math::round_to_i32;
use bytemuck::{Pod, Zeroable};

/// Fractional bits of a position word.
pub const FRACTION_BITS: u32 = 6;

/// Weight of one position word step, counts.
pub(crate) const STEP: f32 = 1.0 / (1 << FRACTION_BITS) as f32;

/// Innovation gains, the same for all joints.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Gains {
    /// On the position.
    l1: f32,
    /// On the velocity, per tick.
    pub(crate) l2: f32,
}

impl Gains {
    /// Critically damped: both discrete poles at exp(-omega / tick_hz).
    pub fn new(omega_rad_s: f32, tick_hz: f32) -> Self {
        let pole = libm::expf(-omega_rad_s / tick_hz);
        Self { l1: 1.0 - pole * pole, l2: (1.0 - pole) * (1.0 - pole) }
    }
}

/// One joint's encoder in SI units.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Scale {
    /// Latch instant after the tick instant, ticks.
    latch_offset: f32,
    /// Position word step, rad or m.
    pub step: f32,
    /// Position at word 0, rad or m.
    zero: f32,
    /// Velocity of one word step a tick, rad/s or m/s.
    rate: f32,
}

impl Scale {
    /// Scale of `joint` at `tick_hz`.
    pub fn new(joint: &Joint, tick_hz: f32) -> Self {
        let step = joint.encoder_lsb * STEP;
        Self {
            latch_offset: joint.latch_offset_s * tick_hz,
            step,
            zero: joint.encoder_zero,
            rate: step * tick_hz,
        }
    }
}

impl Scale {
    /// Word steps a tick at this velocity, rad/s or m/s.
    pub fn words(&self, velocity: f32) -> f32 {
        velocity / self.rate
    }
}

/// More than the observer ever lies behind the codes, word steps: at 0.6 rad/s a joint passes 3200 counts a tick.
const FILTERED: u32 = 8_192 << FRACTION_BITS;

/// State of one joint's observer.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Observer {
    /// Position word at the tick instant.
    pub position: u32,
    /// Velocity in word steps a tick.
    pub velocity: f32,
}

impl Observer {
    /// An arm at rest at encoder code `code`.
    pub fn at_rest(code: u32) -> Self {
        Self { position: code << FRACTION_BITS, velocity: 0.0 }
    }

    /// Advances by one tick and corrects with the sample.
    ///
    /// The sample was latched `latch_offset` after the tick instant; the velocity carries it back.
    #[inline(always)]
    pub fn update(&mut self, gains: &Gains, scale: &Scale, code: u32) {
        self.position = self.position.wrapping_add_signed(round_to_i32(self.velocity));
        self.correct(gains, scale, code);
    }

    /// The correction alone.
    #[inline(always)]
    pub fn correct(&mut self, gains: &Gains, scale: &Scale, code: u32) {
        let difference = (code << FRACTION_BITS).wrapping_sub(self.position) as i32;
        let innovation = difference as f32 - self.velocity * scale.latch_offset;
        self.position = self.position.wrapping_add_signed(round_to_i32(gains.l1 * innovation));
        self.velocity += gains.l2 * innovation;
    }

    /// Advances by `ticks` without a sample, at the acceleration that the model expects, word steps a tick².
    pub fn coast(&mut self, ticks: f32, acceleration: f32) {
        self.velocity += acceleration * ticks;
        let way = self.velocity * ticks;
        let half = if way < 0.0 { -0.5 } else { 0.5 };
        self.position = self.position.wrapping_add_signed((way + half) as i32);
    }

    /// Whether this can be an estimate of what `codes` say: the two differ by filtering only.
    pub fn is_of(&self, codes: &Self) -> bool {
        let distance = self.position.wrapping_sub(codes.position) as i32;
        distance.unsigned_abs() < FILTERED
            && (self.velocity - codes.velocity).abs() < FILTERED as f32
    }

    /// Velocity, rad/s or m/s.
    #[inline(always)]
    pub fn velocity(&self, scale: &Scale) -> f32 {
        self.velocity * scale.rate
    }

    /// Position rounded to `f32`, for the dynamics, rad or m.
    #[inline(always)]
    pub fn position(&self, scale: &Scale) -> f32 {
        self.position as f32 * scale.step + scale.zero
    }
}
