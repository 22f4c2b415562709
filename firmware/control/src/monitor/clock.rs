//! Time as the tick is told it: the period between ticks, what a tick costs, and the torque converter's clock
//! as a second opinion.

use bytemuck::{Pod, Zeroable};
use shared::fault::{Fault, Limit};

use super::{Bucket, Finding, Findings};
use crate::config::Config;

/// Limits of the clock monitor.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ClockLimits {
    /// Cycles from tick to tick.
    period: u32,
    /// A tick this far from its time, cycles, is regular.
    jitter: u32,
    /// 1 / period.
    per_cycle: f32,
    /// Cycles that a tick may compute.
    budget: u32,
    /// Cycles over which conversions are counted.
    window: u32,
    /// Conversions a cycle.
    conversions: f32,
}

/// Share of a period by which a regular tick may be early or late.
const JITTER: f32 = 0.02;
/// Length of the window in which conversions are counted, s: a clock 2 % off is told within two of them.
const WINDOW_S: f32 = 0.09;
/// Share of the conversions in a window that may be missing or too many.
const DRIFT: f32 = 0.01;

impl ClockLimits {
    /// For a validated configuration.
    #[inline(never)]
    pub fn set(&mut self, config: &Config) {
        let safety = &config.safety;
        let tick_hz = config.tick_hz as f32;
        let clock_hz = safety.clock_hz as f32;
        let period = clock_hz / tick_hz;
        *self = Self {
            period: period as u32,
            jitter: (period * JITTER) as u32,
            per_cycle: 1.0 / period,
            budget: (period * safety.budget) as u32,
            window: (clock_hz * WINDOW_S) as u32,
            conversions: safety.conversions_hz / clock_hz,
        };
    }
}

/// Time since the last tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Elapsed {
    /// One tick.
    Regular,
    /// This many ticks.
    Irregular(f32),
}

/// More than this many ticks at once stop the arm; fewer are counted.
const LATE_MAX: f32 = 3.0;
/// The observers coast no further than this at once, ticks.
const COAST_MAX: f32 = 16.0;

/// State of the clock monitor.
#[derive(Clone, Copy, Debug, Default)]
pub struct Clock {
    /// Cycle counter at the last tick that was taken.
    last: u32,
    started: bool,
    late: Bucket,
    over_budget: Bucket,
    /// Ticks that came late, early or not at all, modulo 256.
    pub irregular: u8,
    /// Cycles and conversions at the start of the window.
    window: u32,
    conversions: u32,
    drifts: bool,
}

impl Clock {
    /// Before the first tick.
    pub const NONE: Self = Self {
        last: 0,
        started: false,
        late: Bucket::EMPTY,
        over_budget: Bucket::EMPTY,
        irregular: 0,
        window: 0,
        conversions: 0,
        drifts: false,
    };

    /// Takes the cycle counter at a tick's start, and what the tick before it computed.
    #[inline(always)]
    pub fn tick(
        &mut self,
        limits: &ClockLimits,
        now: u32,
        spent: u32,
        findings: &mut Findings,
    ) -> Elapsed {
        let passed = now.wrapping_sub(self.last);
        self.last = now;
        if spent > limits.budget {
            self.overrun(findings);
        } else {
            self.over_budget.good();
        }
        // One comparison for both sides.
        if passed.wrapping_sub(limits.period).wrapping_add(limits.jitter) <= 2 * limits.jitter {
            self.late.good();
            return Elapsed::Regular;
        }
        self.irregular(passed as f32 * limits.per_cycle, findings)
    }

    #[cold]
    #[inline(never)]
    fn irregular(&mut self, ticks: f32, findings: &mut Findings) -> Elapsed {
        if !self.started {
            self.started = true;
            return Elapsed::Regular;
        }
        self.irregular = self.irregular.wrapping_add(1);
        findings.limit(Limit::TickTiming);
        // An early tick follows a late one on the grid, or is doubled; it counts, but is no loss.
        if ticks > 1.0 && (self.late.miss() || ticks > LATE_MAX) {
            findings.raise(Finding::new(Fault::TickLate));
        }
        Elapsed::Irregular(if ticks < COAST_MAX { ticks } else { COAST_MAX })
    }

    #[cold]
    #[inline(never)]
    fn overrun(&mut self, findings: &mut Findings) {
        findings.limit(Limit::TickTiming);
        if self.over_budget.miss() {
            findings.raise(Finding::new(Fault::TickOverBudget));
        }
    }

    /// Compares the board's clock with the converter's, by `conversions` so far.
    #[inline(always)]
    pub fn compare(&mut self, limits: &ClockLimits, conversions: u32, findings: &mut Findings) {
        if self.last.wrapping_sub(self.window) >= limits.window {
            self.judge(limits, conversions);
        }
        if self.drifts {
            findings.limit(Limit::ClockDrift);
        }
    }

    #[cold]
    #[inline(never)]
    fn judge(&mut self, limits: &ClockLimits, conversions: u32) {
        let counted = conversions.wrapping_sub(self.conversions) as f32;
        let due = self.last.wrapping_sub(self.window) as f32 * limits.conversions;
        self.drifts = (counted - due).abs() > due * DRIFT;
        self.restart(conversions);
    }

    /// Counts anew from here: the converter was not running.
    pub fn restart(&mut self, conversions: u32) {
        self.window = self.last;
        self.conversions = conversions;
    }
}
