//! What a run leaves behind: one row a tick, the metrics of the paper's Section 4, and the verdict.

use serde::Serialize;
use shared::arm::JOINTS;
use shared::evidence::Image;
use shared::telemetry::Record;

use crate::session::Happening;

/// Control law of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, serde::Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Law {
    /// Adaptive robust backstepping (Eq 17 to 20).
    Backstepping,
    /// Computed-torque PD (Eq 29).
    Pd,
}

/// Adaptation of the backstepping law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, serde::Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Adaptation {
    /// psi = wa² M².
    Inertia,
    /// Constant diagonal psi, as printed.
    Paper,
    /// Fixed gains only.
    None,
}

/// Truth, set-point and telemetry of one tick of the judged motion.
#[derive(Clone, Copy, Debug)]
pub struct TickRow {
    /// Time since the trajectory started, s.
    pub t_s: f64,
    /// True joint positions, rad and m.
    pub q: [f64; JOINTS],
    /// True joint speeds, rad/s and m/s.
    pub qd: [f64; JOINTS],
    /// Desired joint positions in `f64`.
    pub q_d: [f64; JOINTS],
    /// Desired joint speeds in `f64`.
    pub qd_d: [f64; JOINTS],
    /// True tip position, world axes, m.
    pub tip_m: [f64; 3],
    /// Tip position less its desired position, world axes, m.
    pub tip_error_m: [f64; 3],
    /// Torque that the drives apply from this tick on, N m and N.
    pub torque: [f64; JOINTS],
    /// True disturbance (friction, Eq 28 and unmodelled load), N m and N.
    pub disturbance: [f64; JOINTS],
    /// V = zᵀz / 2 (Eq 21) of the true state.
    pub v: f64,
    /// Va of Eq 25 with the law's psi; equals `v` where nothing adapts.
    pub va: f64,
    /// The controller's record of this tick.
    pub record: Record,
}

/// Metrics of Section 4 over ticks 0..=N of the trajectory, against the true plant state; not a number, and `null` in
/// JSON, where there is nothing to measure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Metrics {
    /// Root mean square tip error along each world axis, m.
    pub rms_m: [f64; 3],
    /// Mean norm of the tip error, m.
    pub rse_m: f64,
    /// Highest error over highest speed, s.
    pub rho_s: f64,
    /// Highest norm of the tip error, m.
    pub e_max_m: f64,
    /// Highest desired tip speed, m/s.
    pub v_max_m_s: f64,
}

impl Metrics {
    /// Of a run that never came to its trajectory.
    pub const NONE: Self = Self {
        rms_m: [f64::NAN; 3],
        rse_m: f64::NAN,
        rho_s: f64::NAN,
        e_max_m: f64::NAN,
        v_max_m_s: f64::NAN,
    };

    /// A figure in four digits, or a dash where there was nothing to measure.
    pub fn figure(value: f64) -> String {
        if value.is_nan() { "-".into() } else { format!("{value:.4e}") }
    }

    /// The same of a speed, whose size is known beforehand.
    pub fn speed(value: f64) -> String {
        if value.is_nan() { "-".into() } else { format!("{value:.4}") }
    }
}

/// One finished run.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// Scenario name.
    pub scenario: String,
    /// Law.
    pub law: Law,
    /// Adaptation; `None` with the PD.
    pub adaptation: Adaptation,
    /// Tick rate, Hz.
    pub tick_hz: u32,
    /// Seed of every random number of the run.
    pub seed: u64,
    /// Ticks from reset to the end.
    pub ticks: u64,
    /// Metrics of Section 4.
    #[serde(flatten)]
    pub metrics: Metrics,
    /// Controller's mode at the end.
    pub mode: String,
    /// Names of the faults that were latched.
    pub faults: Vec<String>,
    /// Simulated time over wall-clock time.
    pub realtime_factor: f64,
    /// Broken `[accept]` limits, each as a sentence.
    pub broken_limits: Vec<String>,
    /// Fault in which the run had to end, if it had to.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected: Option<String>,
    /// From power-up to the trajectory's start, s, where something is listed as having happened.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start_s: Option<f64>,
    /// What happened, where faults were injected.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub happenings: Vec<Happening>,
    /// Torque limits, N m and N.
    #[serde(skip)]
    pub torque_limit: [f64; JOINTS],
    /// One row a tick of the trajectory; empty unless the run was asked to keep them.
    #[serde(skip)]
    pub rows: Vec<TickRow>,
    /// What the controller kept of a run that ended in a fault.
    #[serde(skip)]
    pub evidence: Option<Box<Image>>,
}

impl Outcome {
    /// Whether the run ended without a fault, or in the one that it had to end in, and within its limits.
    pub fn is_good(&self) -> bool {
        self.faults.iter().eq(&self.expected) && self.broken_limits.is_empty()
    }

    /// Takes what the controller kept, if there was anything to keep it for.
    pub fn keep_evidence(&mut self, image: &Image) {
        let told = image.frozen != 0 || image.error_count > 0;
        self.evidence = told.then(|| Box::new(*image));
    }

    /// How tables and legends call this run's controller.
    pub fn label(&self) -> &'static str {
        match (self.law, self.adaptation) {
            (Law::Pd, _) => "PD (Eq 29)",
            (Law::Backstepping, Adaptation::Inertia) => "backstepping, inertia-weighted",
            (Law::Backstepping, Adaptation::Paper) => "backstepping, paper's psi",
            (Law::Backstepping, Adaptation::None) => "backstepping, no adaptation",
        }
    }
}
