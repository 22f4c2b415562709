//! Reference runs of the laws with perfect state, from an independent `f64` simulation.

use serde::Deserialize;

/// `data/closed_loop.json`.
#[derive(Debug, Deserialize)]
pub struct ClosedLoop {
    /// What all rows share.
    pub defaults: Defaults,
    /// One run each.
    pub rows: Vec<Row>,
}

/// What all rows share; SI units.
#[derive(Debug, Deserialize)]
pub struct Defaults {
    /// Duration, s.
    #[serde(rename = "tend")]
    pub duration_s: f64,
    /// K1 of every joint, 1/s.
    #[serde(rename = "K1")]
    pub k1: f64,
    /// K2 of every joint, 1/s.
    #[serde(rename = "K2")]
    pub k2: f64,
    /// Kp of the PD, 1/s².
    #[serde(rename = "Kp")]
    pub kp: f64,
    /// Kd of the PD, 1/s.
    #[serde(rename = "Kd")]
    pub kd: f64,
    /// Ratios of Eq 28.
    #[serde(rename = "rand")]
    pub ratios: [f64; 4],
    /// Viscous friction of Eq 27, N m s/rad and N s/m.
    pub friction: [f64; 4],
    /// Bound of the disturbance estimate, N m and N.
    #[serde(rename = "dmax")]
    pub d_max: [f64; 4],
    /// Constant diagonal psi.
    #[serde(rename = "psi_diag_wa100")]
    pub psi: [f64; 4],
}

/// One run and its metrics over ticks 0..=N.
#[derive(Debug, Deserialize)]
pub struct Row {
    /// What ran.
    pub name: String,
    /// Where it differs from the defaults.
    pub overrides: Overrides,
    /// Amplitude of the path, rad and m.
    #[serde(rename = "A")]
    pub amplitude: [f64; 4],
    /// Root mean square tip error along each world axis, m.
    pub rms: [f64; 3],
    /// Mean norm of the tip error, m.
    pub rse: f64,
    /// Highest error over highest speed, s.
    pub rho: f64,
    /// Highest norm of the tip error, m.
    #[serde(rename = "emax")]
    pub e_max: f64,
    /// Highest desired tip speed, m/s.
    #[serde(rename = "vmax")]
    pub v_max: f64,
    /// Disturbance estimate at the end, N m and N.
    #[serde(rename = "dhat_end")]
    pub d_hat_end: [f64; 4],
}

/// Settings of one run.
#[derive(Debug, Deserialize)]
pub struct Overrides {
    /// 0 quintic, 1 half sine.
    #[serde(rename = "traj")]
    pub profile: u8,
    /// 1 where the arm starts with the desired velocity.
    #[serde(rename = "vmatch")]
    pub starts_with_velocity: u8,
    /// Tick, s.
    #[serde(rename = "tick")]
    pub tick_s: f64,
    /// Runge-Kutta steps a tick.
    #[serde(rename = "nsub")]
    pub substeps: u32,
    /// wa² of the inertia-weighted law, 1/s².
    #[serde(rename = "psiM")]
    pub wa_squared: Option<f64>,
    /// Present where the constant diagonal psi adapts.
    #[serde(rename = "wa")]
    pub diagonal_wa: Option<f64>,
    /// 1 PD, 2 no adaptation.
    #[serde(rename = "ctrl")]
    pub controller: Option<u8>,
}

/// Reads the reference runs.
pub fn load() -> ClosedLoop {
    serde_json::from_str(include_str!("../data/closed_loop.json"))
        .expect("closed_loop.json is well formed")
}
