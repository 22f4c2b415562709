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

/// Coefficients of one joint's observer and scales.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Coefficients {
    /// Innovation gain of the position.
    l1: f32,
    /// Innovation gain of the velocity, per tick.
    l2: f32,
    /// Latch instant after the tick instant, ticks.
    latch_offset: f32,
    /// Position word step, rad or m.
    pub(crate) step: f32,
    /// Position at word 0, rad or m.
    zero: f32,
    /// Velocity of one word step a tick, rad/s or m/s.
    rate: f32,
}

impl Coefficients {
    /// Critically damped: both discrete poles at exp(-omega / tick_hz).
    pub fn new(joint: &Joint, omega_rad_s: f32, tick_hz: f32) -> Self {
        let pole = libm::expf(-omega_rad_s / tick_hz);
        let step = joint.encoder_lsb * STEP;
        Self {
            l1: 1.0 - pole * pole,
            l2: (1.0 - pole) * (1.0 - pole),
            latch_offset: joint.latch_offset_s * tick_hz,
            step,
            zero: joint.encoder_zero,
            rate: step * tick_hz,
        }
    }
}

/// State of one joint's observer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observer {
    /// Position word at the tick instant.
    pub position: u32,
    /// Velocity in word steps a tick.
    velocity: f32,
}

impl Observer {
    /// An arm at rest at encoder code `code`.
    pub fn at_rest(code: u32) -> Self {
        Self { position: code << FRACTION_BITS, velocity: 0.0 }
    }

    /// Advances by one tick and corrects with the sample, if there is one.
    ///
    /// The sample was latched `latch_offset` after the tick instant; the velocity carries it back.
    #[inline(always)]
    pub fn update(&mut self, c: &Coefficients, code: Option<u32>) {
        self.position = self.position.wrapping_add_signed(round_to_i32(self.velocity));
        if let Some(code) = code {
            let difference = (code << FRACTION_BITS).wrapping_sub(self.position) as i32;
            let innovation = difference as f32 - self.velocity * c.latch_offset;
            self.position = self.position.wrapping_add_signed(round_to_i32(c.l1 * innovation));
            self.velocity += c.l2 * innovation;
        }
    }

    /// Velocity, rad/s or m/s.
    #[inline(always)]
    pub fn velocity(&self, c: &Coefficients) -> f32 {
        self.velocity * c.rate
    }

    /// Position rounded to `f32`, for the dynamics, rad or m.
    #[inline(always)]
    pub fn position(&self, c: &Coefficients) -> f32 {
        self.position as f32 * c.step + c.zero
    }
}
