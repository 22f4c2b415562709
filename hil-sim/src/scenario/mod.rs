//! Scenarios: what arm, what motion, what controller, and what a run must achieve, as a TOML file.
//!
//! A file is read in two steps: `raw` keeps each value with its place in the text, `validate` turns it into
//! the plain values below or into one error that names file, line, field, value and allowed range.

mod accept;
pub mod bounds;
mod error;
mod fault;
mod raw;
mod read;
mod validate;

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;

use shared::arm::JOINTS;
use shared::command::Profile;
use shared::fault::Fault;

pub use self::accept::{Accept, Limits};
use self::error::Source;
pub use self::error::{Invalid, MAX_BYTES, ScenarioError};
use crate::faults::Injection;
use crate::outcome::{Adaptation, Law};

/// One validated scenario. Ranges stand in [`bounds`].
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// File name without its ending.
    pub name: String,
    /// One line for `hil-sim list`.
    pub summary: String,
    /// Control ticks a second, Hz.
    pub tick_hz: u32,
    /// Seed of every random number of the run.
    pub seed: u64,
    /// Duration of the trajectory, s.
    pub duration_s: f64,
    /// Time that the arm holds its start pose before the trajectory, s.
    pub settle_s: f64,
    /// The motion.
    pub trajectory: Motion,
    /// What the controller's model is told.
    pub model: Model,
    /// What the true arm carries and suffers.
    pub plant: Plant,
    /// Resolution and timing of the encoders.
    pub encoders: Encoders,
    /// Quality of the bus.
    pub bus: Bus,
    /// Law and gains.
    pub controller: Controller,
    /// Limits on the metrics.
    pub accept: Accept,
    /// Faults to be injected.
    pub faults: Vec<Injection>,
    /// Fault in which the run has to end, if it has to end in one.
    pub expect: Option<Fault>,
}

/// The joint-space path q_d = q0 + amplitude · s(t / duration).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Time law s.
    pub profile: Profile,
    /// Amplitude, rad (joint 4: m).
    pub amplitude: [f64; JOINTS],
    /// Start pose, rad (joint 4: m).
    pub q0: [f64; JOINTS],
    /// Asks the controller to accept a velocity step at the start.
    pub allow_velocity_step: bool,
}

/// What the controller's model is told; the plant stays nominal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// Factor on the masses and inertias of the links.
    pub mass_scale: f64,
    /// Payload that the model counts on, kg.
    pub payload_kg: f64,
}

/// What the true arm carries and suffers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plant {
    /// Payload from the start, kg.
    pub payload_kg: f64,
    /// Payload picked up on the way, if any, on top of the one from the start.
    pub payload: Option<Payload>,
    /// Viscous friction, N m s/rad (joint 4: N s/m).
    pub friction: [f64; JOINTS],
    /// Random vector of the disturbance (Eq 28).
    pub disturbance: Disturbance,
    /// RK4 steps a tick.
    pub substeps: u32,
}

/// A payload attached with the tip's own velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Payload {
    /// Mass, kg.
    pub kg: f64,
    /// Pick-up after the start of the trajectory, s.
    pub at_s: f64,
}

/// The vector r of the disturbance 30 sin(πt) r (Eq 28), each entry in [0, 1].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Disturbance {
    /// The same for the whole run.
    Fixed([f64; JOINTS]),
    /// Drawn again at each tick.
    EachTick,
}

/// Resolution and timing of the encoders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoders {
    /// Width of the rotary encoders' position word, bits.
    pub rotary_bits: u32,
    /// One count of the linear encoder, m.
    pub linear_lsb_m: f64,
    /// Time between the starts of successive encoder reads, s.
    pub skew_s: f64,
}

/// Quality of the bus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bus {
    /// Share of the answers to the controller in which one bit is flipped, from the end of boot on.
    pub error_share: f64,
}

/// Law and gains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Controller {
    /// Control law.
    pub law: Law,
    /// Adaptation of the backstepping law.
    pub adaptation: Adaptation,
    /// Backstepping gain K1, 1/s.
    pub k1: f64,
    /// Backstepping gain K2, 1/s.
    pub k2: f64,
    /// PD gain Kp (Eq 29), 1/s².
    pub kp: f64,
    /// PD gain Kd (Eq 29), 1/s.
    pub kd: f64,
    /// Rate of the inertia-weighted adaptation, rad/s.
    pub wa: f64,
    /// Diagonal of psi of the paper's adaptation (Eq 19).
    pub psi: [f64; JOINTS],
}

macro_rules! shipped {
    ($($name:literal),*) => {
        [$(($name, include_str!(concat!("../../scenarios/", $name, ".toml")))),*]
    };
}

/// Name and text of each scenario inside the program.
const SHIPPED: [(&str, &str); 6] = shipped![
    "paper",
    "velocity-mismatch",
    "payload",
    "coarse-encoders",
    "noisy-bus",
    "stuck-encoder"
];

/// How alike two names must be (Jaro-Winkler) before one is offered for the other.
const LIKENESS: f64 = 0.8;

impl Scenario {
    /// Name and summary of each shipped scenario.
    pub fn shipped() -> impl Iterator<Item = (&'static str, String)> {
        SHIPPED
            .iter()
            .filter_map(|(name, text)| Some((*name, Self::parse(name, text).ok()?.summary)))
    }

    /// Loads a shipped scenario by its name, else a file by its path.
    ///
    /// # Errors
    /// See [`ScenarioError`].
    pub fn load(name_or_path: &str) -> Result<Self, ScenarioError> {
        match SHIPPED.iter().find(|(name, _)| *name == name_or_path) {
            Some((name, text)) => Self::parse(&format!("{name}.toml"), text),
            None => Self::parse(name_or_path, &read(name_or_path)?),
        }
    }

    /// Parses a scenario's text; `source_name` is its name in errors, and without directories and ending
    /// that of the scenario.
    ///
    /// # Errors
    /// [`ScenarioError::Invalid`] with the first thing wrong.
    pub fn parse(source_name: &str, text: &str) -> Result<Self, ScenarioError> {
        let source = Source { name: source_name, text };
        let raw = toml::from_str(text).map_err(|error| {
            let at = error.span().unwrap_or_default();
            source.error(&at, error.message(), "here", "")
        })?;
        let stem = Path::new(source_name).file_stem().and_then(|stem| stem.to_str());
        source.scenario(&raw, stem.unwrap_or(source_name).to_owned())
    }

    /// Limits that a run with this controller must keep, if the scenario sets any.
    pub fn accept_for(&self, law: Law, adaptation: Adaptation) -> Option<&Limits> {
        self.accept.of(law, adaptation)
    }
}

/// A file's text, never more than [`MAX_BYTES`] of it.
fn read(path: &str) -> Result<String, ScenarioError> {
    let unreadable = |cause| ScenarioError::Unreadable { path: path.into(), cause };
    let file = File::open(path).map_err(|cause| match cause.kind() {
        ErrorKind::NotFound => missing(path),
        _ => unreadable(cause),
    })?;
    let mut bytes = Vec::new();
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(ScenarioError::TooLarge { path: path.into() });
    }
    String::from_utf8(bytes).map_err(|error| {
        let (good, bad) = error.as_bytes().split_at(error.utf8_error().valid_up_to());
        let line = 1 + good.iter().filter(|byte| **byte == b'\n').count();
        let byte = bad.first().copied().unwrap_or_default();
        ScenarioError::NotUtf8 { path: path.into(), line, byte }
    })
}

/// The error for something that is neither a shipped name nor a file.
fn missing(asked: &str) -> ScenarioError {
    let path = Path::new(asked);
    let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or(asked);
    let likeness = |name: &str| strsim::jaro_winkler(name, stem);
    let names = SHIPPED.map(|(name, _)| name);
    let closest = names
        .into_iter()
        .max_by(|a, b| likeness(a).total_cmp(&likeness(b)))
        .filter(|name| likeness(name) >= LIKENESS);
    let question = closest.map(|name| format!("did you mean `{name}`? ")).unwrap_or_default();
    let help =
        format!("{question}shipped scenarios: {}; or give the path of a file", names.join(", "));
    if path.extension().is_some() || path.components().count() > 1 {
        ScenarioError::NotFound { path: path.into(), help }
    } else {
        ScenarioError::UnknownName { name: asked.to_owned(), help }
    }
}
