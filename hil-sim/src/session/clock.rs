//! Time of a run: true time, the board's clock, and the steps from one tick to the next.

use std::collections::VecDeque;

use firmware::config::Safety;

/// How the tick of one period comes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Slot {
    /// In time.
    Regular,
    /// This many periods after the one before it. Below 2 the next one is in time again, else it comes one
    /// period later.
    Late(f64),
    /// Not at all.
    Missing,
    /// Twice.
    Double,
}

/// A tick or none, and the time until the next step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The controller ticks at the step's start.
    pub ticks: bool,
    /// Duration by the board's clock, periods.
    pub lasts: f64,
}

/// From the first of two ticks to the second, periods.
const DOUBLE_AFTER: f64 = 0.05;

/// A part of a step may be this much longer than a period, periods.
const STRETCH: f64 = 0.05;

/// See the module's documentation.
#[derive(Clone, Debug)]
pub struct Clock {
    /// Nominal period, s.
    tick_s: f64,
    /// What is left of a period that is not regular.
    planned: VecDeque<Step>,
    /// Board's clock over its nominal rate.
    ratio: f64,
    /// Since power-up by the board's clock, periods.
    periods: f64,
    /// Since power-up, s.
    true_s: f64,
    cycles: u32,
    /// Periods and true time at t = 0.
    start: Option<(f64, f64)>,
}

impl Clock {
    /// At power-up, for nominal periods of `tick_s`.
    pub fn new(tick_s: f64) -> Self {
        Self {
            tick_s,
            planned: VecDeque::new(),
            ratio: 1.0,
            periods: 0.0,
            true_s: 0.0,
            cycles: 0,
            start: None,
        }
    }

    /// The next step of the present period, if it is not over.
    pub fn next_planned(&mut self) -> Option<Step> {
        self.planned.pop_front()
    }

    /// Begins a period; gives its first step.
    pub fn plan(&mut self, slot: Slot) -> Step {
        let step = |ticks, lasts| Step { ticks, lasts };
        match slot {
            Slot::Regular => return step(true, 1.0),
            Slot::Missing => return step(false, 1.0),
            Slot::Double => {
                self.planned.extend([step(true, DOUBLE_AFTER), step(true, 1.0 - DOUBLE_AFTER)]);
            }
            Slot::Late(periods) => {
                let delay = (periods - 1.0).max(0.0);
                let whole = delay.floor();
                self.planned.extend((0..whole as u64).map(|_| step(false, 1.0)));
                if delay > whole {
                    self.planned.push_back(step(false, delay - whole));
                }
                let left = if delay < 1.0 { 1.0 - delay } else { 1.0 };
                self.planned.push_back(step(true, left));
            }
        }
        self.next_planned().unwrap_or(step(true, 1.0))
    }

    /// Lets the board's clock run at this multiple of its nominal rate from now on.
    pub fn set_ratio(&mut self, ratio: f64) {
        self.ratio = ratio;
    }

    /// Lets the cycle counter wrap in the middle of the period before the one that begins `periods` after
    /// power-up.
    pub fn wrap_at(&mut self, periods: f64) {
        self.cycles = (self.cycles_in(0.5) - self.cycles_in(periods)) as u32;
    }

    /// Equal parts of a step, about one period or less each: their number and true duration, s.
    pub fn parts(&self, step: Step) -> (u32, f64) {
        let periods = step.lasts / self.ratio;
        let parts = (periods - STRETCH).ceil().max(1.0);
        (parts as u32, periods * self.tick_s / parts)
    }

    /// Lets a step pass.
    pub fn pass(&mut self, step: Step) {
        self.periods += step.lasts;
        self.true_s += step.lasts * self.tick_s / self.ratio;
        self.cycles = self.cycles.wrapping_add(self.cycles_in(step.lasts) as u32);
    }

    /// Makes this instant t = 0.
    pub fn start(&mut self) {
        self.start = Some((self.periods, self.true_s));
    }

    /// Whole periods since power-up.
    pub fn periods(&self) -> u64 {
        self.periods as u64
    }

    /// Since power-up, s.
    pub fn true_s(&self) -> f64 {
        self.true_s
    }

    /// From power-up to t = 0, s, once it has come.
    pub fn start_s(&self) -> Option<f64> {
        self.start.map(|(_, true_s)| true_s)
    }

    /// Since t = 0, s, once it has come.
    pub fn since_start_s(&self) -> Option<f64> {
        self.start.map(|(_, true_s)| self.true_s - true_s)
    }

    /// The same by the board's clock, by which the controller moves along its path.
    pub fn path_s(&self) -> Option<f64> {
        self.start.map(|(periods, _)| (self.periods - periods) * self.tick_s)
    }

    /// The board's cycle counter.
    pub fn cycles(&self) -> u32 {
        self.cycles
    }

    /// Cycles in this many periods.
    pub fn cycles_in(&self, periods: f64) -> i64 {
        (f64::from(Safety::REFERENCE.clock_hz) * (periods * self.tick_s)).round() as i64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TICK_S: f64 = 0.5e-3;

    /// Instants of the ticks, periods, over these slots.
    fn ticks(slots: &[Slot]) -> Vec<f64> {
        let mut clock = Clock::new(TICK_S);
        let mut ticks = Vec::new();
        for slot in slots {
            let mut step = Some(clock.plan(*slot));
            while let Some(now) = step {
                if now.ticks {
                    ticks.push((clock.periods * 100.0).round() / 100.0);
                }
                clock.pass(now);
                step = clock.next_planned();
            }
        }
        ticks
    }

    #[test]
    fn ticks_come_when_the_slots_say() {
        use Slot::{Double, Late, Missing, Regular};
        assert_eq!(ticks(&[Regular, Regular]), [0.0, 1.0]);
        assert_eq!(ticks(&[Regular, Late(1.2), Regular]), [0.0, 1.2, 2.0]);
        assert_eq!(ticks(&[Regular, Late(5.0), Regular]), [0.0, 5.0, 6.0]);
        assert_eq!(ticks(&[Regular, Late(2.5), Regular]), [0.0, 2.5, 3.5]);
        assert_eq!(ticks(&[Regular, Missing, Regular]), [0.0, 2.0]);
        assert_eq!(ticks(&[Double, Regular]), [0.0, 0.05, 1.0]);
    }

    #[test]
    fn a_fast_clock_makes_true_periods_short_and_leaves_the_counter_alone() {
        let mut clock = Clock::new(TICK_S);
        clock.set_ratio(1.25);
        let step = clock.plan(Slot::Regular);
        assert_eq!(clock.parts(step), (1, 0.4e-3));
        clock.pass(step);
        assert_eq!((clock.true_s(), clock.cycles()), (0.4e-3, 84_000));
        clock.set_ratio(0.5);
        assert_eq!(clock.parts(step), (2, 0.5e-3));
    }

    #[test]
    fn the_counter_wraps_in_the_period_before_the_one_named() {
        let mut clock = Clock::new(TICK_S);
        clock.wrap_at(3.0);
        let mut counts = Vec::new();
        for _ in 0..5 {
            counts.push(clock.cycles());
            let step = clock.plan(Slot::Regular);
            clock.pass(step);
        }
        assert!(counts[1] < counts[2] && counts[2] > counts[3] && counts[3] < counts[4]);
    }
}
