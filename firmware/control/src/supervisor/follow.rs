//! Following a path at a rate that changes: jogging and stopping.

use crate::path::{Pace, Phase, Ramp, Rate};

/// Place on a path, and the rate at which it is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Follower {
    /// Where the ramp began.
    base: Phase,
    ramp: Ramp,
    /// Rate that the ramp leads to: 0 or 1.
    goal: u32,
    /// Ticks since then; past the ramp's end the rate is level.
    tick: u32,
}

impl Follower {
    /// At `phase` and `rate`, on the way to the rate `goal`, 0 or 1.
    pub fn new(base: Phase, rate: Rate, goal: u32, pace: &Pace) -> Self {
        Self { base, ramp: Ramp::new(rate, goal as f32, pace), goal, tick: 0 }
    }

    /// At the start of a path and at rest, on the way to full rate.
    pub fn from_rest(pace: &Pace) -> Self {
        Self::new(Phase::default(), Rate::ZERO, 1, pace)
    }

    /// Turns to the rate `goal` from here.
    #[inline(never)]
    pub fn turn(&mut self, goal: u32, pace: &Pace) {
        *self = Self::new(self.phase(pace), self.rate(pace), goal, pace);
    }

    /// Where the rate is going.
    pub fn goal(&self) -> u32 {
        self.goal
    }

    /// One tick on.
    pub fn step(&mut self) {
        self.tick = self.tick.saturating_add(1);
    }

    /// Present path rate.
    #[inline(never)]
    pub fn rate(&self, pace: &Pace) -> Rate {
        self.ramp.rate(self.tick, pace)
    }

    /// Whether the ramp has ended.
    pub fn is_level(&self, pace: &Pace) -> bool {
        self.tick >= pace.ticks as u32
    }

    /// Present place on the path.
    #[inline(never)]
    pub fn phase(&self, pace: &Pace) -> Phase {
        let ramp = pace.ticks as u32;
        let (on_ramp, after) = match self.tick.checked_sub(ramp) {
            Some(after) => (ramp, after),
            None => (self.tick, 0),
        };
        let mut phase = self.base.advanced(self.ramp.advance(on_ramp, pace));
        phase.ticks = phase.ticks.saturating_add(after.saturating_mul(self.goal));
        phase
    }
}
