//! Software in the loop: the firmware library as part of this program, closed around the plant.

use std::cell::RefCell;
use std::convert::Infallible;
use std::rc::Rc;
use std::time::Instant;

use firmware::config::{ArmModel, Config, ConfigError, Law as FirmwareLaw};
use firmware::controller::Core;
use firmware::evidence::Recorder;
use firmware::executive::{Executive, Retained, TickInput};
use firmware::link::{Access, Station};
use shared::arm::{Arm, JOINTS, REFERENCE};
use shared::evidence::Image;
use shared::pil::Release;
use shared::telemetry::Record;
use shared::wire::biss_c::LATCH_DELAY_S;
use thiserror::Error;

use crate::bench::{self, Bench};
use crate::console::{KEY, Line};
use crate::faults::flip_configuration;
use crate::outcome::{Adaptation, Law, Outcome};
use crate::scenario::Scenario;
use crate::session::{Controller, Session};

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

/// The arm with the scenario's encoders.
pub fn arm_of(scenario: &Scenario) -> Arm {
    let encoders = &scenario.encoders;
    REFERENCE.with_encoders(encoders.rotary_bits, encoders.linear_lsb_m)
}

/// The controller's configuration for a scenario.
pub fn config_of(scenario: &Scenario) -> Config {
    let c = &scenario.controller;
    let mut config = Config::for_arm(&arm_of(scenario), scenario.tick_hz);
    let model = &scenario.model;
    config.arm = ArmModel::new(&REFERENCE, model.mass_scale as f32, model.payload_kg as f32);
    for (j, joint) in config.joints.iter_mut().enumerate() {
        joint.latch_offset_s = (LATCH_DELAY_S + j as f64 * scenario.encoders.skew_s) as f32;
    }
    let gains = &mut config.gains;
    gains.law = match (c.law, c.adaptation) {
        (Law::Pd, _) => FirmwareLaw::PD,
        (Law::Backstepping, Adaptation::Inertia) => FirmwareLaw::INERTIA_WEIGHTED,
        (Law::Backstepping, Adaptation::Paper) => FirmwareLaw::PAPER_PSI,
        (Law::Backstepping, Adaptation::None) => FirmwareLaw::FIXED_GAIN,
    };
    gains.k1 = [c.k1 as f32; JOINTS];
    gains.k2 = [c.k2 as f32; JOINTS];
    gains.kp = [c.kp as f32; JOINTS];
    gains.kd = [c.kd as f32; JOINTS];
    gains.wa_rad_s = c.wa as f32;
    gains.psi = c.psi.map(|p| p as f32);
    config
}

/// A configuration with the check sum that it is kept with.
#[derive(Clone, Copy, Debug)]
pub struct Kept {
    /// The configuration.
    pub config: Config,
    /// Made of it when it was stored.
    pub crc: u32,
}

impl From<&Config> for Kept {
    fn from(config: &Config) -> Self {
        Self { config: *config, crc: config.crc() }
    }
}

/// The controller's configuration as the board finds it: a scenario's faults may have flipped bits of it.
pub fn kept_of(scenario: &Scenario) -> Kept {
    let mut kept = Kept::from(&config_of(scenario));
    flip_configuration(&mut kept.config, &scenario.faults);
    kept
}

/// Who may command the boards of this harness, and their boots before power-up.
pub const ACCESS: Access = Access { key: KEY, boots: 0 };

/// The firmware library wired to a bench, with its end of the operator link.
pub struct Software<'m> {
    executive: Executive<
        'm,
        bench::Handle<bench::Device>,
        bench::Handle<bench::Output>,
        bench::Handle<bench::Input>,
    >,
    station: Station,
    line: Line,
    recorder: Recorder,
    evidence: Box<Image>,
}

impl<'m> Software<'m> {
    /// Builds the controller.
    ///
    /// # Errors
    /// [`RunError::Config`] where it refuses the configuration.
    pub fn new(
        kept: impl Into<Kept>,
        bench: &Rc<RefCell<Bench>>,
        retained: Retained,
        core: &'m mut Core,
    ) -> Result<Self, RunError> {
        let Kept { config, crc } = kept.into();
        let mut executive = Executive::new(bench::wire(bench), core);
        executive.configure(&config, crc, &retained).map_err(RunError::Config)?;
        let mut evidence: Box<Image> = Box::new(bytemuck::zeroed());
        let (recorder, _) = Recorder::new(&mut evidence, config.tick_hz);
        let access = Access { boots: ACCESS.boots.wrapping_add(evidence.boots), ..ACCESS };
        let (mut station, line) = (Station::new(), Line::default());
        station.configure(&config, &access);
        Ok(Self { executive, station, line, recorder, evidence })
    }

    /// What is kept of the run so far.
    pub fn evidence(&self) -> &Image {
        &self.evidence
    }

    /// What the configuration became, for comparison with another build.
    pub fn parameter_bytes(&self) -> Vec<u8> {
        self.executive.parameter_bytes().concat()
    }
}

impl Controller for Software<'_> {
    type Error = Infallible;

    fn tick(&mut self, release: &Release) -> Result<Record, Infallible> {
        for poke in &release.pokes {
            poke.apply(self.executive.memory().as_words_mut());
        }
        self.line.deliver(release.link());
        self.station.serve(&mut self.line, &*self.evidence);
        let served = self.station.served();
        let input = TickInput {
            order: served.order(),
            alive: served.alive,
            cycles: release.cycles,
            spent: release.spent,
            conversions: release.conversions,
        };
        let record = *self.executive.tick(&input);
        self.recorder.note(&mut self.evidence, &record);
        self.station.taken(record.refusal);
        self.station.note(&record);
        Ok(record)
    }

    fn said(&mut self) -> Vec<u8> {
        self.line.take()
    }
}

/// When t = 0 comes after power-up if all is well, s; `None` where it does not.
pub fn start_s(scenario: &Scenario) -> Option<f64> {
    let well = Scenario { faults: Vec::new(), ..scenario.clone() };
    let mut session = Session::new(&well, false);
    let (config, bench, retained) = (config_of(&well), session.bench(), session.retained());
    let mut core = Core::new();
    let mut controller = Software::new(&config, &bench, retained, &mut core).ok()?;
    while session.start_s().is_none() && !session.is_over() {
        let Ok(_) = session.tick(&mut controller);
    }
    session.start_s()
}

/// Runs `scenario` to its end or to the controller's safe mode.
///
/// # Errors
/// [`RunError::Config`] where the controller refuses the scenario's numbers.
pub fn run(scenario: &Scenario, options: Options<'_>) -> Result<Outcome, RunError> {
    let mut session = Session::new(scenario, options.keep_rows);
    let mut core = Core::new();
    let mut controller =
        Software::new(kept_of(scenario), &session.bench(), session.retained(), &mut core)?;
    let started = Instant::now();
    while !session.is_over() {
        let Ok(_) = session.tick(&mut controller);
        let (done, planned) = session.progress();
        if done.is_multiple_of(PROGRESS_EVERY) {
            (options.progress)(done, planned);
        }
    }
    let mut outcome = session.outcome(started.elapsed().as_secs_f64());
    outcome.keep_evidence(controller.evidence());
    Ok(outcome)
}
