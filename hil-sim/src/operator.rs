//! The person at the command port: arms, waits, starts the trajectory, and is done at its end.

use shared::command::{Command, Trajectory};
use shared::fault::Mode;
use shared::telemetry::Record;

use crate::scenario::Scenario;

/// What has been asked for so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    Boot,
    Armed,
    /// Holding, with the ticks left to wait.
    Settling(u32),
    /// The trajectory was started.
    Started,
    /// There is no trajectory: the arm rests for so many ticks more.
    Resting(u32),
}

/// Operator of one run.
#[derive(Clone, Copy, Debug)]
pub struct Operator {
    step: Step,
    settle_ticks: u32,
    trajectory: Trajectory,
    /// The trajectory leads nowhere and is not started.
    rests: bool,
}

impl Operator {
    /// Will start `trajectory` once the arm has held still for the scenario's settling time. One that leads
    /// nowhere is waited for at rest instead.
    pub fn new(scenario: &Scenario, trajectory: Trajectory) -> Self {
        let settle_ticks = (scenario.settle_s * f64::from(scenario.tick_hz)).round() as u32;
        let rests = scenario.trajectory.amplitude.iter().all(|a| *a == 0.0);
        Self { step: Step::Boot, settle_ticks, trajectory, rests }
    }

    /// The command for the coming tick, after the record of the last one.
    pub fn command(&mut self, last: &Record) -> Option<Command> {
        let mode = Mode::from_number(last.mode)?;
        let (step, command) = match (self.step, mode) {
            (Step::Boot, Mode::Standby) => (Step::Armed, Some(Command::Arm)),
            (Step::Armed, Mode::Holding) => (Step::Settling(self.settle_ticks), None),
            (Step::Settling(0), _) if self.rests => {
                (Step::Resting(self.trajectory.duration_ticks), None)
            }
            (Step::Settling(0), _) => (Step::Started, Some(Command::Start(self.trajectory))),
            (Step::Settling(left), _) => (Step::Settling(left - 1), None),
            (Step::Resting(left), _) => (Step::Resting(left.saturating_sub(1)), None),
            (step, _) => (step, None),
        };
        self.step = step;
        command
    }

    /// Whether the coming tick is at t = 0 or later: the trajectory has been asked for, or the settling time
    /// is over and there is none.
    pub fn has_begun(&self) -> bool {
        matches!(self.step, Step::Started | Step::Resting(_))
    }

    /// Whether the arm is where the trajectory has it, or at rest if there is none.
    pub fn is_served(&self, last: &Record) -> bool {
        let mode = if self.rests { Mode::Holding } else { Mode::Moving };
        self.has_begun() && last.mode == mode as u8
    }

    /// Whether the trajectory, or the time at rest, has come to its end.
    pub fn has_finished(&self, last: &Record) -> bool {
        let at_end = match self.step {
            Step::Resting(left) => left == 0,
            _ => last.phase == self.trajectory.duration_ticks,
        };
        at_end && self.is_served(last)
    }

    /// Whether nothing more will come of this run: finished, safe, or refused.
    pub fn is_over(&self, last: &Record) -> bool {
        self.has_finished(last) || last.mode == Mode::Latched as u8 || last.refusal != 0
    }
}
