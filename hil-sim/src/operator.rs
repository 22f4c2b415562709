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
    Started,
}

/// Operator of one run.
#[derive(Clone, Copy, Debug)]
pub struct Operator {
    step: Step,
    settle_ticks: u32,
    trajectory: Trajectory,
}

impl Operator {
    /// Will start `trajectory` once the arm has held still for the scenario's settling time.
    pub fn new(scenario: &Scenario, trajectory: Trajectory) -> Self {
        let settle_ticks = (scenario.settle_s * f64::from(scenario.tick_hz)).round() as u32;
        Self { step: Step::Boot, settle_ticks, trajectory }
    }

    /// The command for the coming tick, after the record of the last one.
    pub fn command(&mut self, last: &Record) -> Option<Command> {
        let mode = Mode::from_number(last.mode)?;
        let (step, command) = match (self.step, mode) {
            (Step::Boot, Mode::Standby) => (Step::Armed, Some(Command::Arm)),
            (Step::Armed, Mode::Holding) => (Step::Settling(self.settle_ticks), None),
            (Step::Settling(0), _) => (Step::Started, Some(Command::Start(self.trajectory))),
            (Step::Settling(left), _) => (Step::Settling(left - 1), None),
            (step, _) => (step, None),
        };
        self.step = step;
        command
    }

    /// Whether the trajectory has come to its end.
    pub fn has_finished(&self, last: &Record) -> bool {
        self.step == Step::Started
            && last.mode == Mode::Moving as u8
            && last.phase == self.trajectory.duration_ticks
    }

    /// Whether nothing more will come of this run: finished, safe, or refused.
    pub fn is_over(&self, last: &Record) -> bool {
        self.has_finished(last) || last.mode == Mode::Latched as u8 || last.refusal != 0
    }
}
