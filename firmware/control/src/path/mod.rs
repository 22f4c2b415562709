//! Paths that the set-point follows, and the rate at which it does.
//!
//! A path gives a set-point for each [`Phase`]. At full rate the phase advances by one tick a tick; a
//! [`Ramp`] takes the rate down to zero and up again without leaving the path.

mod line;
mod motion;
mod ramp;
mod shape;

use shared::arm::JOINTS;

pub use line::Line;
pub use motion::{DURATION_MAX, Motion};
pub use ramp::{Pace, Ramp, Rate};
pub(crate) use shape::Shaped;

/// Set-point of one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SetPoint {
    /// Desired position words.
    pub position: [u32; JOINTS],
    /// Desired velocity, rad/s and m/s.
    pub velocity: [f32; JOINTS],
    /// Desired acceleration, rad/s² and m/s².
    pub acceleration: [f32; JOINTS],
}

impl SetPoint {
    /// Standing still at `position`.
    #[inline(always)]
    pub fn hold(position: [u32; JOINTS]) -> Self {
        Self { position, ..Self::default() }
    }
}

/// How far along a path, in ticks at full rate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Phase {
    /// Whole ticks.
    pub ticks: u32,
    /// The rest, with 32 fractional bits.
    pub fraction: u32,
}

impl Phase {
    /// `ticks` further on, not before the start; a fraction with 24 significant bits.
    pub fn advanced(self, ticks: f32) -> Self {
        // Backwards is whole ticks back and the rest forward.
        let back = if ticks < 0.0 { -ticks as u32 + 1 } else { 0 };
        let Some(start) = self.ticks.checked_sub(back) else { return Self::default() };
        let ticks = ticks + back as f32;
        let whole = ticks as u32;
        let rest = ((ticks - whole as f32) * TWO_POW_32) as u32;
        let (fraction, carry) = self.fraction.overflowing_add(rest);
        let ticks = start.saturating_add(whole).saturating_add(u32::from(carry));
        Self { ticks, fraction }
    }
}

const TWO_POW_32: f32 = 4_294_967_296.0;

/// What a stop follows down to rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Path {
    /// A trajectory.
    Curve(Motion),
    /// A straight line.
    Line(Line),
}

impl Path {
    /// Puts the set-point at `phase`, passed at `rate`, where it is wanted.
    pub fn place(&self, phase: Phase, rate: Rate, to: &mut SetPoint) {
        match self {
            Self::Curve(motion) => motion.place(phase, rate, to),
            Self::Line(line) => line.place(phase, rate, to),
        }
    }
}
