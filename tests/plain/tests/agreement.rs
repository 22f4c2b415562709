//! The plain versions compute what the firmware computes.

use firmware::config::{Config, Law};
use firmware::dynamics::Constants;
use firmware::law::{self, Coefficients};
use firmware::math::clamp_symmetric;
use nalgebra::Vector4;
use plain::{Adaptation, Command, Gains, Model, State, Terms};
use proptest::prelude::*;
use shared::arm::REFERENCE;

/// Largest error allowed, of the largest number in the row.
const TOLERANCE: f32 = 1e-4;

fn agree<'a>(
    name: &str,
    got: impl IntoIterator<Item = &'a f32>,
    want: impl IntoIterator<Item = &'a f32, IntoIter: Clone>,
) -> Result<(), TestCaseError> {
    let want = want.into_iter();
    let scale = want.clone().fold(0.0, |a: f32, b| if b.abs() > a { b.abs() } else { a });
    for (i, (got, want)) in got.into_iter().zip(want).enumerate() {
        let error = (got - want).abs();
        prop_assert!(error <= TOLERANCE * scale, "{name}[{i}]: {got} against {want} of {scale}");
    }
    Ok(())
}

/// Poses over the whole range of motion, at up to the speed limits, with errors that saturate no joint as a rule.
fn states() -> impl Strategy<Value = State> {
    let joints = |low: fn(usize) -> f64, high: fn(usize) -> f64| {
        let range = |j| low(j) as f32..high(j) as f32;
        (range(0), range(1), range(2), range(3)).prop_map(|(a, b, c, d)| Vector4::new(a, b, c, d))
    };
    let q = joints(|j| REFERENCE.limits[j].q_min, |j| REFERENCE.limits[j].q_max);
    let qd = joints(|j| -REFERENCE.limits[j].qd_max, |j| REFERENCE.limits[j].qd_max);
    let e1 = joints(|_| -1e-4, |_| 1e-4);
    let e1_dot = joints(|_| -1e-2, |_| 1e-2);
    let qdd_d = joints(|_| -1.0, |_| 1.0);
    (q, qd, e1, e1_dot, qdd_d).prop_map(|(q, qd, e1, e1_dot, qdd_d)| State {
        q,
        qd,
        e1,
        e1_dot,
        qdd_d,
    })
}

/// Estimates that reach the largest bound, so that some are projected and clamped.
fn estimates() -> impl Strategy<Value = Vector4<f32>> {
    let share = || prop_oneof![Just(-1.0f32), -1.0f32..1.0, Just(1.0f32)];
    (share(), share(), share(), share()).prop_map(|(a, b, c, d)| {
        Vector4::new(a, b, c, d).component_mul(&Vector4::from(Config::default().gains.d_max))
    })
}

fn plain_gains(config: &Config) -> Gains {
    Gains {
        k1: config.gains.k1.into(),
        k2: config.gains.k2.into(),
        adaptation: match config.gains.law {
            Law::PAPER_PSI => Adaptation::PaperPsi(config.gains.psi.into()),
            _ => Adaptation::InertiaWeighted(config.gains.wa_rad_s),
        },
        d_max: config.gains.d_max.into(),
        tau_max: config.joints.map(|j| j.tau_max).into(),
        tick_s: 1.0 / config.tick_hz as f32,
    }
}

fn firmware_command(config: &Config, s: &State, d_hat: &Vector4<f32>) -> Command {
    let coefficients = Coefficients::new(&config.gains, config.tick_hz as f32);
    let state = law::State { q: s.q, qd: s.qd, e1: s.e1, e1_dot: s.e1_dot, qdd_d: s.qdd_d };
    let wanted = law::evaluate(&coefficients, &Constants::new(&config.arm), &state, d_hat);
    let tau_max = config.joints.map(|j| j.tau_max).into();
    Command {
        torque: wanted.torque.zip_map(&tau_max, clamp_symmetric),
        d_hat: law::adapt(&coefficients, d_hat, &wanted.adaptation),
    }
}

proptest! {
    #[test]
    fn mass_and_bias_agree(s in states()) {
        let constants = Constants::new(&Config::default().arm);
        let want = constants.at(&s.q);
        let model = Model::new(&REFERENCE);
        for Terms { mass, bias } in
            [model.terms_by_crba(&s.q, &s.qd), model.terms_by_five_calls(&s.q, &s.qd)]
        {
            agree("M", &mass, &want.inertia_matrix())?;
            agree("C qd + G", &bias, &(want.coriolis(&s.qd) + want.gravity()))?;
        }
    }

    #[test]
    fn laws_agree(s in states(), d_hat in estimates()) {
        let model = Model::new(&REFERENCE);
        // From zero the step itself is compared, from elsewhere its projection and clamping.
        for (law, d_hat) in [Law::INERTIA_WEIGHTED, Law::PAPER_PSI]
            .into_iter()
            .flat_map(|law| [(law, Vector4::zeros()), (law, d_hat)])
        {
            let mut config = Config::default();
            config.gains.law = law;
            let want = firmware_command(&config, &s, &d_hat);
            let gains = plain_gains(&config);
            for got in [
                plain::control_by_crba(&model, &gains, &s, &d_hat),
                plain::control_by_five_calls(&model, &gains, &s, &d_hat),
            ] {
                agree("tau", &got.torque, &want.torque)?;
                agree("d_hat", &got.d_hat, &want.d_hat)?;
            }
        }
    }
}
