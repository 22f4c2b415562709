//! The simulator's side of a run: plant, bench, operator and judge around any controller.

mod chronicle;
mod clock;
mod faults;
mod judge;
mod step;
mod tape;
mod verdict;

use std::cell::RefCell;
use std::rc::Rc;

use firmware::executive::Retained;
use shared::arm::{Arm, JOINTS};
use shared::command::Command;
use shared::pil::Release;
use shared::telemetry::Record;

pub use chronicle::{Event, Happening};
use clock::Clock;
pub use clock::Slot;
use faults::Faults;
use judge::Judge;
pub use tape::{Frame, Tape};

use crate::bench::Bench;
use crate::console::{Console, KEY};
use crate::faults::Interference;
use crate::operator::Operator;
use crate::path::Path;
use crate::plant::{Disturbance, Plant, Ratios};
use crate::run::arm_of;
use crate::scenario::{self, Scenario};

/// A controller that is handed its ticks one by one, wired to a [`Bench`].
pub trait Controller {
    /// Why a tick could not be done.
    type Error;

    /// One tick; the record is the one that came out of its telemetry queue.
    ///
    /// # Errors
    /// Where the controller itself could not be reached.
    fn tick(&mut self, release: &Release) -> Result<Record, Self::Error>;

    /// What it has said on the operator link since this was last asked.
    fn said(&mut self) -> Vec<u8>;
}

/// What a tick is said to have computed, cycles: about what the target takes.
const SPENT_CYCLES: u32 = 2_000;
/// Time granted on top of trajectory and settling: boot and opening the brakes.
const START_UP_S: f64 = 2.0;

/// Everything on the simulator's side of a run.
pub struct Session<'a> {
    scenario: &'a Scenario,
    arm: Arm,
    bench: Rc<RefCell<Bench>>,
    plant: Plant,
    clock: Clock,
    operator: Operator,
    console: Console,
    judge: Judge,
    tape: Option<Tape>,
    faults: Option<Faults>,
    /// Of the drives, N m and N.
    torque: [f64; JOINTS],
    /// Given for the next tick.
    command: Option<Command>,
    last: Record,
    /// On the operator link in the last tick.
    said: Vec<u8>,
    ticks: u64,
    /// The payload that waits on the way was picked up.
    picked_up: bool,
}

impl<'a> Session<'a> {
    /// A session at power-up; `keep_rows` asks for one row a tick.
    pub fn new(scenario: &'a Scenario, keep_rows: bool) -> Self {
        let arm = arm_of(scenario);
        let path = Path::of(scenario);
        let mut bench = Bench::new(&arm, scenario.encoders.skew_s, scenario.seed);
        bench.expect_faults(Interference::of(&scenario.faults, &arm, scenario.seed));
        let mut clock = Clock::new(1.0 / f64::from(scenario.tick_hz));
        Self {
            plant: plant_of(scenario, &arm),
            faults: Faults::of(scenario, &arm, &mut clock),
            clock,
            operator: Operator::new(scenario, path.command(&arm)),
            console: Console::new(KEY, challenge(scenario.seed), scenario.tick_hz),
            bench: Rc::new(RefCell::new(bench)),
            judge: Judge::new(scenario, path, keep_rows),
            tape: None,
            scenario,
            arm,
            torque: [0.0; JOINTS],
            command: None,
            last: Record::default(),
            said: Vec::new(),
            ticks: 0,
            picked_up: false,
        }
    }

    /// Keeps a [`Tape`] from now on.
    pub fn keep_tape(&mut self) {
        self.tape = Some(Tape::default());
    }

    /// The tape so far, if it is kept.
    pub fn tape(&self) -> Option<&Tape> {
        self.tape.as_ref()
    }

    /// The bench that the controller is to be wired to.
    pub fn bench(&self) -> Rc<RefCell<Bench>> {
        Rc::clone(&self.bench)
    }

    /// When t = 0 was after power-up, s, once it has come.
    pub fn start_s(&self) -> Option<f64> {
        self.clock.start_s()
    }

    /// What has happened so far; nothing is kept where the scenario has no faults.
    pub fn happenings(&self) -> &[Happening] {
        self.faults.as_ref().map_or(&[], |faults| faults.happenings())
    }

    /// The true arm.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// What the board kept over the loss of power: the pose that the arm stands in.
    pub fn retained(&self) -> Retained {
        let q0 = self.scenario.trajectory.q0;
        let code =
            |j: usize| ((q0[j] - self.arm.encoders[j].zero) / self.arm.encoders[j].lsb) as u32;
        Retained { parked: Some(std::array::from_fn(code)), crash: None }
    }

    /// Periods done and periods after which the run ends in any case.
    pub fn progress(&self) -> (u64, u64) {
        let s = self.scenario;
        let planned_s = s.duration_s + s.settle_s + START_UP_S;
        (self.clock.periods(), (planned_s * f64::from(s.tick_hz)) as u64)
    }

    /// Whether nothing more will come.
    pub fn is_over(&self) -> bool {
        let (done, planned) = self.progress();
        done >= planned || self.operator.is_over(&self.last)
    }

    /// The operator's console.
    pub fn console(&mut self) -> &mut Console {
        &mut self.console
    }

    /// Gives `command` with the next tick, whatever the operator would do.
    pub fn order(&mut self, command: Command) {
        self.command = Some(command);
    }

    /// The operator begins another session with the board, which has been reset.
    pub fn reconnect(&mut self) {
        self.console.start_over();
    }

    /// One tick of `controller` and of the plant after it, or one period in which a fault lets none come; gives
    /// the last record.
    ///
    /// # Errors
    /// The controller's.
    pub fn tick<C: Controller>(&mut self, controller: &mut C) -> Result<Record, C::Error> {
        let planned = self.clock.next_planned();
        if planned.is_none() {
            self.ask_operator();
        }
        self.inject();
        let step = planned.unwrap_or_else(|| {
            let slot = self.faults.as_mut().map_or(Slot::Regular, Faults::slot);
            self.clock.plan(slot)
        });
        if step.ticks {
            let release = self.release();
            let record = controller.tick(&release)?;
            self.take(record);
            self.hear(controller.said());
        }
        self.drive();
        self.note(step.ticks);
        self.pass(step);
        Ok(self.last)
    }
}

/// The console's challenge in a run with this seed.
fn challenge(seed: u64) -> [u8; 16] {
    bytemuck::cast([seed, !seed])
}

/// The arm at rest in its start pose, with what it carries.
fn plant_of(scenario: &Scenario, arm: &Arm) -> Plant {
    let ratios = match scenario.plant.disturbance {
        scenario::Disturbance::Fixed(r) => Ratios::Fixed(r),
        scenario::Disturbance::EachTick => Ratios::Redrawn(scenario.seed),
    };
    let disturbance = Disturbance::new(scenario.plant.friction, ratios);
    let (q0, substeps) = (scenario.trajectory.q0, scenario.plant.substeps);
    let mut plant = Plant::at_rest(arm, q0, disturbance, substeps);
    if scenario.plant.payload_kg > 0.0 {
        plant.set_payload(scenario.plant.payload_kg);
    }
    plant
}
