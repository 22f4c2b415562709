//! The simulator's side of a run: plant, bench, operator and judge around any controller.

use std::cell::RefCell;
use std::rc::Rc;

use firmware::config::Safety;
use firmware::executive::Retained;
use shared::arm::{Arm, JOINTS};
use shared::command::Command;
use shared::fault::{Fault, Mode, Refusal};
use shared::pil::Release;
use shared::telemetry::Record;

use crate::bench::{Bench, Motion};
use crate::metrics::Meter;
use crate::operator::Operator;
use crate::outcome::{Adaptation, Law, Outcome, TickRow};
use crate::path::Path;
use crate::plant::{Disturbance, Plant, Ratios};
use crate::run::arm_of;
use crate::scenario::{self, Scenario};
use crate::truth::Truth;

/// A controller that is handed its ticks one by one, wired to a [`Bench`].
pub trait Controller {
    /// Why a tick could not be done.
    type Error;

    /// One tick; the record is the one that came out of its telemetry queue.
    ///
    /// # Errors
    /// Where the controller itself could not be reached.
    fn tick(&mut self, release: &Release) -> Result<Record, Self::Error>;
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
    path: Path,
    operator: Operator,
    meter: Meter,
    truth: Option<Truth>,
    rows: Vec<TickRow>,
    torque: [f64; JOINTS],
    last: Record,
    cycles: u32,
    ticks: u64,
}

impl<'a> Session<'a> {
    /// A session at power-up; `keep_rows` asks for one row a tick.
    pub fn new(scenario: &'a Scenario, keep_rows: bool) -> Self {
        let arm = arm_of(scenario);
        let path = Path::of(scenario);
        let ratios = match scenario.plant.disturbance {
            scenario::Disturbance::Fixed(r) => Ratios::Fixed(r),
            scenario::Disturbance::EachTick => Ratios::Redrawn(scenario.seed),
        };
        let disturbance = Disturbance::new(scenario.plant.friction, ratios);
        let q0 = scenario.trajectory.q0;
        let bench = Bench::new(&arm, scenario.encoders.skew_s, scenario.seed);
        Self {
            plant: Plant::at_rest(&arm, q0, disturbance, scenario.plant.substeps),
            operator: Operator::new(scenario, path.command(&arm)),
            bench: Rc::new(RefCell::new(bench)),
            truth: keep_rows.then(|| Truth::new(scenario)),
            scenario,
            arm,
            path,
            meter: Meter::default(),
            rows: Vec::new(),
            torque: [0.0; JOINTS],
            last: Record::default(),
            cycles: 0,
            ticks: 0,
        }
    }

    /// The bench that the controller is to be wired to.
    pub fn bench(&self) -> Rc<RefCell<Bench>> {
        Rc::clone(&self.bench)
    }

    /// What the board kept over the loss of power: the pose that the arm stands in.
    pub fn retained(&self) -> Retained {
        let q0 = self.scenario.trajectory.q0;
        let code = |j: usize| ((q0[j] - self.arm.encoders[j].zero) / self.arm.encoders[j].lsb) as u32;
        Retained { parked: Some(std::array::from_fn(code)) }
    }

    /// Ticks done and ticks after which the run ends in any case.
    pub fn progress(&self) -> (u64, u64) {
        let s = self.scenario;
        let planned_s = s.duration_s + s.settle_s + START_UP_S;
        (self.ticks, (planned_s * f64::from(s.tick_hz)) as u64)
    }

    /// Whether nothing more will come.
    pub fn is_over(&self) -> bool {
        let (done, planned) = self.progress();
        done >= planned || self.operator.is_over(&self.last)
    }

    /// One tick of `controller` and of the plant after it.
    ///
    /// # Errors
    /// The controller's.
    pub fn tick<C: Controller>(&mut self, controller: &mut C) -> Result<Record, C::Error> {
        let command = self.operator.command(&self.last);
        let release = self.before_tick(command);
        let record = controller.tick(&release)?;
        self.after_tick(record);
        Ok(record)
    }

    /// Puts the plant's state where the sensors latch it.
    fn before_tick(&mut self, command: Option<Command>) -> Release {
        if matches!(command, Some(Command::Start(_))) {
            self.plant.start_disturbance();
        }
        let motion = Motion {
            q: self.plant.q(),
            qd: self.plant.qd(),
            qdd: self.plant.acceleration(&self.torque),
        };
        let mut bench = self.bench.borrow_mut();
        bench.brake_open = self.plant.brake_released();
        bench.begin_tick(motion);
        Release {
            levels: bench.input_levels(),
            alive: true,
            cycles: self.cycles,
            spent: SPENT_CYCLES,
            conversions: bench.conversions(),
            command,
        }
    }

    /// Judges the tick and lets its torques act until the next one.
    fn after_tick(&mut self, record: Record) {
        let dt_s = 1.0 / f64::from(self.scenario.tick_hz);
        let (fractions, release) = {
            let bench = self.bench.borrow();
            (bench.drive_commands(), bench.outputs.brake_release)
        };
        self.torque = std::array::from_fn(|j| fractions[j] * self.arm.drive_full_scale[j]);
        if self.last.mode == Mode::Boot as u8 && record.mode != Mode::Boot as u8 {
            self.spoil_bus();
        }
        if record.mode == Mode::Moving as u8 {
            self.judge(&record, dt_s);
            self.pick_up(record.phase, dt_s);
        }
        self.plant.set_brake_release(release);
        self.plant.step(self.torque, dt_s);
        let sensed = std::array::from_fn(|j| self.torque[j] / self.arm.torque_full_scale[j]);
        self.bench.borrow_mut().advance(dt_s, sensed);
        let clock_hz = f64::from(Safety::REFERENCE.clock_hz);
        self.cycles = self.cycles.wrapping_add((clock_hz * dt_s).round() as u32);
        self.last = record;
        self.ticks += 1;
    }

    /// Converters are configured: from now on the bus may err.
    fn spoil_bus(&mut self) {
        let error_share = self.scenario.bus.error_share;
        if error_share > 0.0 {
            self.bench.borrow_mut().make_noisy(error_share, self.scenario.seed);
        }
    }

    /// Attaches the payload when its time has come.
    fn pick_up(&mut self, phase: u32, dt_s: f64) {
        if let Some(payload) = self.scenario.plant.payload
            && phase == (payload.at_s / dt_s).round() as u32
        {
            self.plant.set_payload(payload.kg);
        }
    }

    fn judge(&mut self, record: &Record, dt_s: f64) {
        let t_s = f64::from(record.phase) * dt_s;
        let desired = self.path.at(t_s);
        let tip = self.plant.tip().position_m;
        let wanted = self.path.tip(&desired);
        let error = std::array::from_fn(|axis| tip[axis] - wanted.position_m[axis]);
        self.meter.add(&error, wanted.speed_m_s);
        if let Some(truth) = &self.truth {
            let (v, va, disturbance) = truth.at(&self.plant, &self.torque, &desired, record);
            self.rows.push(TickRow {
                t_s,
                q: self.plant.q(),
                qd: self.plant.qd(),
                q_d: desired.q,
                qd_d: desired.qd,
                tip_m: tip,
                tip_error_m: error,
                torque: self.torque,
                disturbance,
                v,
                va,
                record: *record,
            });
        }
    }

    /// What came of the run, which took `wall_s`.
    pub fn outcome(self, wall_s: f64) -> Outcome {
        let s = self.scenario;
        let (law, adaptation) = controller_of(s);
        let metrics = self.meter.metrics();
        let fault = Fault::from_number(self.last.fault).unwrap_or(Fault::None);
        let mut broken_limits =
            s.accept_for(law, adaptation).map_or(Vec::new(), |limits| limits.broken(&metrics));
        if !self.operator.has_finished(&self.last) {
            broken_limits.push("the trajectory did not reach its end".into());
        }
        if let Some(refusal) = Refusal::from_number(self.last.refusal)
            && refusal != Refusal::None
        {
            broken_limits.push(format!("the controller refused a command: {}", refusal.name()));
        }
        Outcome {
            scenario: s.name.clone(),
            law,
            adaptation,
            tick_hz: s.tick_hz,
            seed: s.seed,
            ticks: self.ticks,
            metrics,
            mode: Mode::from_number(self.last.mode).map_or("Unknown", Mode::name).into(),
            faults: if fault == Fault::None { Vec::new() } else { vec![fault.name().into()] },
            realtime_factor: self.ticks as f64 / f64::from(s.tick_hz) / wall_s,
            broken_limits,
            torque_limit: self.arm.limits.map(|l| l.tau_max),
            rows: self.rows,
        }
    }
}

/// Law and adaptation as reported: the PD adapts nothing.
fn controller_of(scenario: &Scenario) -> (Law, Adaptation) {
    let c = &scenario.controller;
    match c.law {
        Law::Pd => (Law::Pd, Adaptation::None),
        Law::Backstepping => (Law::Backstepping, c.adaptation),
    }
}
