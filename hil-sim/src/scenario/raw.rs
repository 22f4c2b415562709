//! The scenario file as written: every value keeps its place in the text and is still unchecked.

use clap::ValueEnum;
use serde::Deserialize;
use shared::command::Profile;
use toml::{Spanned, Value};

/// A value as written, or nothing where the key is absent.
pub(super) type Leaf = Option<Spanned<Value>>;

#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Raw {
    pub summary: Leaf,
    pub tick_hz: Leaf,
    pub seed: Leaf,
    pub duration_s: Leaf,
    pub settle_s: Leaf,
    pub trajectory: Option<Spanned<RawTrajectory>>,
    pub model: RawModel,
    pub plant: RawPlant,
    pub encoders: RawEncoders,
    pub bus: RawBus,
    pub controller: RawController,
    pub accept: RawAccept,
    pub fault: Vec<Spanned<RawFault>>,
    pub expect: RawExpect,
}

#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields, expecting = "a table")]
pub(super) struct RawTrajectory {
    pub profile: Leaf,
    pub amplitude: Leaf,
    pub q0: Leaf,
    pub allow_velocity_step: Leaf,
}

#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields, expecting = "a table")]
pub(super) struct RawModel {
    pub mass_scale: Leaf,
    pub payload_kg: Leaf,
}

#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields, expecting = "a table")]
pub(super) struct RawPlant {
    pub payload_kg: Leaf,
    pub payload: Option<Spanned<RawPayload>>,
    pub friction: Leaf,
    pub disturbance: Leaf,
    pub substeps: Leaf,
}

#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields, expecting = "a table")]
pub(super) struct RawPayload {
    pub kg: Leaf,
    pub at_s: Leaf,
}

#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields, expecting = "a table")]
pub(super) struct RawEncoders {
    pub rotary_bits: Leaf,
    pub linear_lsb_m: Leaf,
    pub skew_s: Leaf,
}

#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields, expecting = "a table")]
pub(super) struct RawBus {
    pub error_share: Leaf,
}

#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields, expecting = "a table")]
pub(super) struct RawController {
    pub law: Leaf,
    pub adaptation: Leaf,
    pub k1: Leaf,
    pub k2: Leaf,
    pub kp: Leaf,
    pub kd: Leaf,
    pub wa: Leaf,
    pub psi: Leaf,
}

#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case", expecting = "a table")]
pub(super) struct RawAccept {
    pub backstepping_inertia: Option<RawLimits>,
    pub backstepping_paper: Option<RawLimits>,
    pub backstepping_none: Option<RawLimits>,
    pub pd: Option<RawLimits>,
}

#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields, expecting = "a table")]
pub(super) struct RawLimits {
    pub rse_m: Leaf,
    pub e_max_m: Leaf,
    pub rho_s: Leaf,
    pub rms_m: Leaf,
}

#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields, expecting = "a table")]
pub(super) struct RawFault {
    pub kind: Leaf,
    pub target: Leaf,
    pub at_s: Leaf,
    pub for_s: Leaf,
    pub severity: Leaf,
}

#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields, expecting = "a table")]
pub(super) struct RawExpect {
    pub fault: Leaf,
}

/// Names of [`Profile`] in a file.
#[derive(Clone, Copy, ValueEnum)]
pub(super) enum RawProfile {
    Quintic,
    HalfSine,
}

impl From<RawProfile> for Profile {
    fn from(raw: RawProfile) -> Self {
        match raw {
            RawProfile::Quintic => Self::Quintic,
            RawProfile::HalfSine => Self::HalfSine,
        }
    }
}
