//! One run: the firmware under test closed around the plant through the simulated bus, tick by tick.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Instant;

use firmware::config::{ArmModel, Config, ConfigError};
use firmware::executive::{Executive, TickInput};
use heapless::spsc::Queue;
use shared::arm::{Arm, JOINTS, REFERENCE};
use shared::command::Command;
use shared::fault::{Fault, Mode, Refusal};
use shared::telemetry::Record;
use shared::wire::biss_c::LATCH_DELAY_S;
use thiserror::Error;

use crate::bench::{self, Bench, Motion};
use crate::metrics::Meter;
use crate::operator::Operator;
use crate::outcome::{Adaptation, Law, Outcome, TickRow};
use crate::path::Path;
use crate::plant::{Disturbance, Plant, Ratios};
use crate::scenario::{self, Scenario};
use crate::truth::Truth;

/// Why a run could not be done.
#[derive(Debug, Error)]
pub enum RunError {
    /// The controller refused its configuration.
    #[error("the controller refuses its configuration: {0}")]
    Config(ConfigError),
}

/// What a run keeps and whom it tells.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// Keep one row a tick.
    pub keep_rows: bool,
    /// Told the ticks done and the ticks planned, now and then.
    pub progress: &'a dyn Fn(u64, u64),
}

/// Ticks between two words to `progress`.
const PROGRESS_EVERY: u64 = 1_024;
/// Time granted on top of trajectory and settling: boot and opening the brakes.
const START_UP_S: f64 = 1.5;
/// Records that the queue between tick and idle loop holds, and one free place.
const QUEUE_LENGTH: usize = 8;

/// The arm with the scenario's encoders.
pub fn arm_of(scenario: &Scenario) -> Arm {
    let encoders = &scenario.encoders;
    REFERENCE.with_encoders(encoders.rotary_bits, encoders.linear_lsb_m)
}

/// The controller's configuration for a scenario.
pub fn config_of(scenario: &Scenario) -> Config {
    let c = &scenario.controller;
    let mut config = Config::for_arm(&arm_of(scenario), scenario.tick_hz);
    config.arm = ArmModel::new(
        &REFERENCE,
        scenario.model.mass_scale as f32,
        scenario.model.payload_kg as f32,
    );
    for (j, joint) in config.joints.iter_mut().enumerate() {
        joint.latch_offset_s = (LATCH_DELAY_S + j as f64 * scenario.encoders.skew_s) as f32;
    }
    let gains = &mut config.gains;
    gains.law = match (c.law, c.adaptation) {
        (Law::Pd, _) => firmware::config::Law::PD,
        (Law::Backstepping, Adaptation::Inertia) => firmware::config::Law::INERTIA_WEIGHTED,
        (Law::Backstepping, Adaptation::Paper) => firmware::config::Law::PAPER_PSI,
        (Law::Backstepping, Adaptation::None) => firmware::config::Law::FIXED_GAIN,
    };
    gains.k1 = [c.k1 as f32; JOINTS];
    gains.k2 = [c.k2 as f32; JOINTS];
    gains.kp = [c.kp as f32; JOINTS];
    gains.kd = [c.kd as f32; JOINTS];
    gains.wa_rad_s = c.wa as f32;
    gains.psi = c.psi.map(|p| p as f32);
    config
}

/// Runs `scenario` to its end or to the controller's safe mode.
///
/// # Errors
/// [`RunError::Config`] where the controller refuses the scenario's numbers.
pub fn run(scenario: &Scenario, options: Options<'_>) -> Result<Outcome, RunError> {
    let arm = arm_of(scenario);
    let bench = Rc::new(RefCell::new(Bench::new(&arm, scenario.encoders.skew_s, scenario.seed)));
    let config = config_of(scenario);
    let controller = Executive::new(&config, bench::wire(&bench)).map_err(RunError::Config)?;
    let mut session = Session::new(scenario, arm, bench, options.keep_rows);
    let started = Instant::now();
    session.until_done(controller, options.progress);
    let wall_s = started.elapsed().as_secs_f64();
    Ok(session.outcome(wall_s))
}

type Controller = Executive<
    bench::Handle<bench::Device>,
    bench::Handle<bench::Output>,
    bench::Handle<bench::Input>,
>;

/// Everything on the simulator's side of a run.
struct Session<'a> {
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
    ticks: u64,
}

impl<'a> Session<'a> {
    fn new(scenario: &'a Scenario, arm: Arm, bench: Rc<RefCell<Bench>>, keep_rows: bool) -> Self {
        let path = Path::of(scenario);
        let plant_of = &scenario.plant;
        let ratios = match plant_of.disturbance {
            scenario::Disturbance::Fixed(r) => Ratios::Fixed(r),
            scenario::Disturbance::EachTick => Ratios::Redrawn(scenario.seed),
        };
        let disturbance = Disturbance::new(plant_of.friction, ratios);
        let plant = Plant::at_rest(&arm, scenario.trajectory.q0, disturbance, plant_of.substeps);
        let truth = keep_rows.then(|| Truth::new(scenario));
        Self {
            operator: Operator::new(scenario, path.command(&arm)),
            scenario,
            arm,
            bench,
            plant,
            path,
            meter: Meter::default(),
            truth,
            rows: Vec::new(),
            torque: [0.0; JOINTS],
            last: Record::default(),
            ticks: 0,
        }
    }

    fn until_done(&mut self, mut controller: Controller, progress: &dyn Fn(u64, u64)) {
        let mut queue = Queue::<Record, QUEUE_LENGTH>::new();
        let (mut records, mut idle) = queue.split();
        let planned = self.planned_ticks();
        while self.ticks < planned {
            let command = self.operator.command(&self.last);
            self.before_tick(command);
            controller.tick(&TickInput { command }, &mut records);
            if let Some(record) = idle.dequeue() {
                self.after_tick(record);
            }
            if self.ticks.is_multiple_of(PROGRESS_EVERY) {
                progress(self.ticks, planned);
            }
            if self.operator.is_over(&self.last) {
                break;
            }
        }
        progress(planned, planned);
    }

    fn planned_ticks(&self) -> u64 {
        let s = self.scenario;
        ((s.duration_s + s.settle_s + START_UP_S) * f64::from(s.tick_hz)) as u64
    }

    /// Puts the plant's state where the sensors latch it.
    fn before_tick(&mut self, command: Option<Command>) {
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
    }

    /// Judges the tick and lets its torques act until the next one.
    fn after_tick(&mut self, record: Record) {
        let dt_s = 1.0 / f64::from(self.scenario.tick_hz);
        let (fractions, release) = {
            let bench = self.bench.borrow();
            (bench.drive_commands(), bench.outputs.brake_release)
        };
        self.torque = std::array::from_fn(|j| fractions[j] * self.arm.drive_full_scale[j]);
        if record.mode == Mode::Moving as u8 {
            self.judge(&record, dt_s);
            self.pick_up(record.phase, dt_s);
        }
        self.plant.set_brake_release(release);
        self.plant.step(self.torque, dt_s);
        let sensed = std::array::from_fn(|j| self.torque[j] / self.arm.torque_full_scale[j]);
        self.bench.borrow_mut().advance(dt_s, sensed);
        self.last = record;
        self.ticks += 1;
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
        let desired = self.path.at(f64::from(record.phase) * dt_s);
        let tip = self.plant.tip().position_m;
        let wanted = self.path.tip(&desired);
        let error = std::array::from_fn(|axis| tip[axis] - wanted.position_m[axis]);
        self.meter.add(&error, wanted.speed_m_s);
        if let Some(truth) = &self.truth {
            let (v, va, disturbance) = truth.at(&self.plant, &self.torque, &desired, record);
            self.rows.push(TickRow {
                t_s: f64::from(record.phase) * dt_s,
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

    fn outcome(self, wall_s: f64) -> Outcome {
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
