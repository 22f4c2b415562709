//! How the path rate changes: a cubic in time, so that acceleration starts and ends without a step.

use bytemuck::{Pod, Zeroable};

/// Path rate and its derivative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rate {
    /// 1 is full speed.
    pub value: f32,
    /// 1/s.
    pub slope_per_s: f32,
}

impl Rate {
    /// Following the path as planned.
    pub const FULL: Self = Self { value: 1.0, slope_per_s: 0.0 };
    /// Standing still.
    pub const ZERO: Self = Self { value: 0.0, slope_per_s: 0.0 };
}

/// A cubic Hermite segment from one rate to a level one, over the time of a stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    from: f32,
    /// Slope at the start, per duration of the ramp.
    slope: f32,
    to: f32,
}

/// What turns ticks into a ramp's parameter.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Pace {
    /// Duration, ticks.
    pub ticks: f32,
    /// 1 / duration, 1/ticks.
    pub per_tick: f32,
    /// 1 / duration, 1/s.
    pub per_s: f32,
}

impl Pace {
    /// For ramps of this duration.
    pub fn new(duration_s: f32, tick_hz: f32) -> Self {
        let ticks = duration_s * tick_hz;
        Self { ticks, per_tick: 1.0 / ticks, per_s: 1.0 / duration_s }
    }
}

impl Ramp {
    /// From the present rate to `to`.
    pub fn new(from: Rate, to: f32, pace: &Pace) -> Self {
        Self { from: from.value, slope: from.slope_per_s / pace.per_s, to }
    }

    /// Rate after `tick` ticks; past the end, the end.
    pub fn rate(&self, tick: u32, pace: &Pace) -> Rate {
        let x = tick as f32 * pace.per_tick;
        if x >= 1.0 {
            return Rate { value: self.to, slope_per_s: 0.0 };
        }
        let y = 1.0 - x;
        let step = x * x * (3.0 - 2.0 * x);
        let value = self.from + (self.to - self.from) * step + self.slope * x * y * y;
        let slope = (self.to - self.from) * 6.0 * x * y + self.slope * y * (1.0 - 3.0 * x);
        Rate { value, slope_per_s: slope * pace.per_s }
    }

    /// Ticks at full rate that the path advances in the first `tick` ticks of the ramp, which has not ended.
    pub fn advance(&self, tick: u32, pace: &Pace) -> f32 {
        let x = tick as f32 * pace.per_tick;
        let x2 = x * x;
        let step = x2 * x * (1.0 - 0.5 * x);
        let slope = x2 * (0.5 - x * (2.0 / 3.0 - 0.25 * x));
        let share = self.from * x + (self.to - self.from) * step + self.slope * slope;
        if share > 0.0 { share * pace.ticks } else { 0.0 }
    }
}
