//! From the file as written to checked values, the defaults filled in.

use shared::arm::{JOINTS, Q0, REFERENCE};
use toml::Spanned;

use super::accept::{Accept, Limits};
use super::bounds::{self, Bounds, Kind};
use super::error::{ScenarioError, Source};
use super::raw::{
    Leaf, Raw, RawAccept, RawController, RawEncoders, RawLimits, RawModel, RawPayload, RawPlant,
    RawProfile, RawTrajectory,
};
use super::read::names;
use super::{Bus, Controller, Disturbance, Encoders, Model, Motion, Payload, Plant, Scenario};
use crate::outcome::{Adaptation, Law};
use crate::plant;

type Checked<T> = Result<T, ScenarioError>;

const EACH_TICK: &str = "each-tick";

impl Source<'_> {
    pub fn scenario(&self, raw: &Raw, name: String) -> Checked<Scenario> {
        let duration_s = self.number(&raw.duration_s, &bounds::DURATION_S, 10.0)?;
        Ok(Scenario {
            name,
            summary: self.line(&raw.summary, "summary")?,
            tick_hz: self.number(&raw.tick_hz, &bounds::TICK_HZ, 2000.0)? as u32,
            seed: self.number(&raw.seed, &bounds::SEED, 1.0)? as u64,
            duration_s,
            settle_s: self.number(&raw.settle_s, &bounds::SETTLE_S, 0.5)?,
            trajectory: self.motion(raw.trajectory.as_ref())?,
            model: self.model(&raw.model)?,
            plant: self.plant(&raw.plant, duration_s)?,
            encoders: self.encoders(&raw.encoders)?,
            bus: Bus { error_share: self.number(&raw.bus.error_share, &bounds::ERROR_SHARE, 0.0)? },
            controller: self.controller(&raw.controller)?,
            accept: self.accept(&raw.accept)?,
            faults: self.faults(&raw.fault, duration_s)?,
            expect: self.expected(&raw.expect.fault)?,
        })
    }

    fn motion(&self, raw: Option<&Spanned<RawTrajectory>>) -> Checked<Motion> {
        let Some(raw) = raw else {
            let allowed = "a table with profile and amplitude";
            let label = format!("needed in this file: {allowed}");
            return Err(self.error(&(0..0), "`[trajectory]` is missing", label, ""));
        };
        let (at, raw) = (raw.span(), raw.get_ref());
        self.given(&raw.profile, "trajectory.profile", &at, &names::<RawProfile>())?;
        self.given(&raw.amplitude, "trajectory.amplitude", &at, "four numbers, rad (joint 4: m)")?;
        let q0 = self.four(&raw.q0, &reach("trajectory.q0", [0.0; JOINTS], LIMITS_WHY), Q0)?;
        let amplitudes = reach("trajectory.amplitude", q0, PATH_WHY);
        Ok(Motion {
            profile: self.choice(&raw.profile, "trajectory.profile", RawProfile::Quintic)?.into(),
            amplitude: self.four(&raw.amplitude, &amplitudes, [0.0; JOINTS])?,
            q0,
            allow_velocity_step: self
                .flag(&raw.allow_velocity_step, "trajectory.allow_velocity_step")?,
        })
    }

    fn model(&self, raw: &RawModel) -> Checked<Model> {
        Ok(Model {
            mass_scale: self.number(&raw.mass_scale, &bounds::MASS_SCALE, 1.0)?,
            payload_kg: self.number(&raw.payload_kg, &bounds::MODEL_PAYLOAD_KG, 0.0)?,
        })
    }

    fn plant(&self, raw: &RawPlant, duration_s: f64) -> Checked<Plant> {
        Ok(Plant {
            payload_kg: self.number(&raw.payload_kg, &bounds::PLANT_PAYLOAD_KG, 0.0)?,
            payload: raw.payload.as_ref().map(|raw| self.payload(raw, duration_s)).transpose()?,
            friction: self.four(&raw.friction, &[bounds::FRICTION; JOINTS], plant::FRICTION)?,
            disturbance: self.disturbance(&raw.disturbance)?,
            substeps: self.number(&raw.substeps, &bounds::SUBSTEPS, 1.0)? as u32,
        })
    }

    fn payload(&self, raw: &Spanned<RawPayload>, duration_s: f64) -> Checked<Payload> {
        let at_s = Bounds { hi: duration_s, ..bounds::PAYLOAD_AT_S };
        let table = raw.span();
        Ok(Payload {
            kg: self.required_number(&raw.get_ref().kg, &bounds::PAYLOAD_KG, &table)?,
            at_s: self.required_number(&raw.get_ref().at_s, &at_s, &table)?,
        })
    }

    fn disturbance(&self, leaf: &Leaf) -> Checked<Disturbance> {
        if let Some(written) = leaf
            && let Some(word) = written.get_ref().as_str()
        {
            let at = written.span();
            let message = || format!("`plant.disturbance` = {} is not known", self.quoted(&at));
            let label = || format!("allowed: \"{EACH_TICK}\" or {}", bounds::DISTURBANCE);
            return match word {
                EACH_TICK => Ok(Disturbance::EachTick),
                _ => Err(self.error(&at, message(), label(), "")),
            };
        }
        self.four(leaf, &[bounds::DISTURBANCE; JOINTS], plant::RATIOS).map(Disturbance::Fixed)
    }

    fn encoders(&self, raw: &RawEncoders) -> Checked<Encoders> {
        Ok(Encoders {
            rotary_bits: self.number(&raw.rotary_bits, &bounds::ROTARY_BITS, 26.0)? as u32,
            linear_lsb_m: self.number(&raw.linear_lsb_m, &bounds::LINEAR_LSB_M, 50e-9)?,
            skew_s: self.number(&raw.skew_s, &bounds::SKEW_S, 10e-6)?,
        })
    }

    fn controller(&self, raw: &RawController) -> Checked<Controller> {
        let psi = [7.6e10, 4.9e10, 1.85e10, 4.1e8];
        Ok(Controller {
            law: self.choice(&raw.law, "controller.law", Law::Backstepping)?,
            adaptation: self.choice(
                &raw.adaptation,
                "controller.adaptation",
                Adaptation::Inertia,
            )?,
            k1: self.number(&raw.k1, &bounds::K1, 200.0)?,
            k2: self.number(&raw.k2, &bounds::K2, 200.0)?,
            kp: self.number(&raw.kp, &bounds::KP, 9000.0)?,
            kd: self.number(&raw.kd, &bounds::KD, 80.0)?,
            wa: self.number(&raw.wa, &bounds::WA, 100.0)?,
            psi: self.four(&raw.psi, &[bounds::PSI; JOINTS], psi)?,
        })
    }

    fn accept(&self, raw: &RawAccept) -> Checked<Accept> {
        let limits = |raw: &Option<RawLimits>, controller: &str| {
            raw.as_ref().map(|raw| self.limits(raw, controller)).transpose()
        };
        Ok(Accept {
            backstepping_inertia: limits(&raw.backstepping_inertia, "backstepping-inertia")?,
            backstepping_paper: limits(&raw.backstepping_paper, "backstepping-paper")?,
            backstepping_none: limits(&raw.backstepping_none, "backstepping-none")?,
            pd: limits(&raw.pd, "pd")?,
        })
    }

    fn limits(&self, raw: &RawLimits, controller: &str) -> Checked<Limits> {
        let limit = |leaf: &Leaf, bounds: &Bounds| {
            let key = bounds.key.replace('*', controller);
            let bounds = Bounds { key: &key, ..*bounds };
            leaf.as_ref().map(|_| self.number(leaf, &bounds, bounds.hi)).transpose()
        };
        Ok(Limits {
            rse_m: limit(&raw.rse_m, &bounds::RSE_M)?,
            e_max_m: limit(&raw.e_max_m, &bounds::E_MAX_M)?,
            rho_s: limit(&raw.rho_s, &bounds::RHO_S)?,
            rms_m: limit(&raw.rms_m, &bounds::RMS_M)?,
        })
    }
}

const LIMITS_WHY: &str = "the arm must start within its joint limits";
const PATH_WHY: &str = "q0 + amplitude must stay within the joint limits";

/// What each joint has left from `from` to its limits; both profiles stay between 0 and the amplitude.
fn reach<'a>(key: &'a str, from: [f64; JOINTS], why: &'a str) -> [Bounds<'a>; JOINTS] {
    std::array::from_fn(|joint| Bounds {
        key,
        lo: REFERENCE.limits[joint].q_min - from[joint],
        hi: REFERENCE.limits[joint].q_max - from[joint],
        unit: if joint + 1 == JOINTS { "m" } else { "rad" },
        kind: Kind::Real,
        why,
    })
}
