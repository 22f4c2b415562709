//! Firmware kinematics and dynamics in `f32` against Pinocchio and against the plant.

use firmware::JointVector;
use firmware::config::{ArmModel, Config};
use firmware::dynamics::Constants;
use firmware::{kinematics, ldlt};
use hil_sim::plant::Model;
use proptest::prelude::*;
use shared::arm::REFERENCE;
use tests::vectors;

/// Largest error allowed, of the largest number in the row.
const TOLERANCE: f64 = 2e-6;

fn joints(x: &[f64; 4]) -> JointVector {
    JointVector::from_fn(|j, _| x[j] as f32)
}

fn close(name: &str, got: impl IntoIterator<Item = f32>, want: &[f64], scale: f64) {
    for (i, (got, want)) in got.into_iter().zip(want).enumerate() {
        let (error, allowed) = ((f64::from(got) - want).abs(), TOLERANCE * scale);
        assert!(
            error <= allowed,
            "{name}[{i}]: {got} against {want}, off by {error:.2e}, allowed {allowed:.2e}"
        );
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |a, b| a.max(b.abs()))
}

fn reference() -> (ArmModel, Constants) {
    let arm = Config::default().arm;
    (arm, Constants::new(&arm))
}

#[test]
fn pose_and_jacobian_agree_with_the_reference() {
    let (arm, _) = reference();
    for state in vectors::load().states {
        let q = joints(&state.q);
        let pose = kinematics::forward(&arm.geometry, &q);
        close("position", pose.position_m.iter().copied(), &state.position_m, 6.0);
        close("rotation", pose.rotation.transpose().iter().copied(), &state.rotation, 1.0);
        let jacobian = kinematics::jacobian(&arm.geometry, &q).transpose();
        close("jacobian", jacobian.iter().copied(), &state.jacobian, largest(&state.jacobian));
    }
}

#[test]
fn dynamics_agree_with_the_reference() {
    let (_, constants) = reference();
    for state in vectors::load().states {
        let (q, qd, qdd) = (joints(&state.q), joints(&state.qd), joints(&state.qdd));
        let terms = constants.at(&q);
        close("M", terms.inertia_matrix().iter().copied(), &state.mass, largest(&state.mass));
        let gravity = terms.gravity();
        close("G", gravity.iter().copied(), &state.gravity, largest(&state.gravity));
        let coriolis = terms.coriolis(&qd);
        let scale = largest(&state.coriolis).max(1.0);
        close("C qd", coriolis.iter().copied(), &state.coriolis, scale);
        let torque = terms.inertia_times(&qdd) + coriolis + gravity;
        close("tau", torque.iter().copied(), &state.torque, largest(&state.torque));
    }
}

/// States over the whole range of motion at up to the speed limits.
fn states() -> impl Strategy<Value = ([f64; 4], [f64; 4], [f64; 4])> {
    let within = |low: fn(usize) -> f64, high: fn(usize) -> f64| {
        [low(0)..high(0), low(1)..high(1), low(2)..high(2), low(3)..high(3)]
    };
    let q = within(|j| REFERENCE.limits[j].q_min, |j| REFERENCE.limits[j].q_max);
    let qd = within(|j| -REFERENCE.limits[j].qd_max, |j| REFERENCE.limits[j].qd_max);
    (q, qd, [-1.0..1.0, -1.0..1.0, -1.0..1.0, -1.0..1.0])
}

/// Both sides see the same `f32` numbers.
fn rounded(x: [f64; 4]) -> [f64; 4] {
    x.map(|v| f64::from(v as f32))
}

proptest! {
    #[test]
    fn firmware_and_plant_agree_anywhere((q, qd, qdd) in states(), payload in 0.0..300.0f64) {
        let (q, qd, qdd) = (rounded(q), rounded(qd), rounded(qdd));
        let payload = f64::from(payload as f32);
        let constants = Constants::new(&ArmModel::new(&REFERENCE, 1.0, payload as f32));
        let mut plant = Model::new(&REFERENCE);
        plant.set_payload(payload);
        let terms = constants.at(&joints(&q));
        let mass: Vec<f64> = plant.mass_matrix(&q).into_iter().flatten().collect();
        close("M", terms.inertia_matrix().iter().copied(), &mass, largest(&mass));
        // Apart and on the scale of the terms they are summed from, which can cancel.
        let still = [0.0; 4];
        let gravity = plant.inverse_dynamics(&q, &still, &still);
        close("G", terms.gravity().iter().copied(), &gravity, largest(&gravity));
        let beyond_gravity = |qd, qdd| {
            let torque = plant.inverse_dynamics(&q, qd, qdd);
            [0, 1, 2, 3].map(|j| torque[j] - gravity[j])
        };
        let coriolis = terms.coriolis(&joints(&qd));
        let scale = largest(&mass) * largest(&qd).powi(2);
        close("C qd", coriolis.iter().copied(), &beyond_gravity(&qd, &still), scale);
        let inertial = terms.inertia_times(&joints(&qdd));
        let scale = largest(&mass) * largest(&qdd);
        close("M qdd", inertial.iter().copied(), &beyond_gravity(&still, &qdd), scale);
    }

    #[test]
    fn inertia_matrix_is_solved(( q, _, x) in states()) {
        let (_, constants) = reference();
        let terms = constants.at(&joints(&q));
        let x = joints(&x);
        let got = ldlt::solve(&terms.inertia_matrix(), &terms.inertia_times(&x));
        // M's condition number is about 100 here.
        prop_assert!((got - x).norm() < 2e-4 * x.norm().max(0.1), "{got} against {x}");
    }

    #[test]
    fn sine_and_cosine_agree_with_f64(x in -64.0f32..64.0) {
        let (s, c) = firmware::math::sin_cos(x);
        let (ws, wc) = f64::from(x).sin_cos();
        // 1.5 ulp of a number just below 1.
        prop_assert!((f64::from(s) - ws).abs() < 9e-8, "sin {x}: {s} against {ws}");
        prop_assert!((f64::from(c) - wc).abs() < 9e-8, "cos {x}: {c} against {wc}");
    }
}
