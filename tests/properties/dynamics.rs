//! Properties 2 and 3 of the arm (Eq 3 and 4), through the firmware's own terms.

use firmware::JointVector;
use firmware::config::ArmModel;
use firmware::dynamics::Constants;
use proptest::prelude::*;
use shared::arm::{JOINTS, REFERENCE};

type Joints = [f64; JOINTS];

fn constants(payload_kg: f32) -> Constants {
    Constants::new(&ArmModel::new(&REFERENCE, 1.0, payload_kg))
}

/// M(q) in `f64`.
fn mass(constants: &Constants, q: &JointVector) -> [Joints; JOINTS] {
    let m = constants.at(q).inertia_matrix();
    std::array::from_fn(|i| std::array::from_fn(|j| f64::from(m[(i, j)])))
}

/// x^T M x.
fn form(m: &[Joints; JOINTS], x: &JointVector) -> f64 {
    let x: Joints = x.map(f64::from).into();
    m.iter().zip(x).map(|(row, xi)| xi * row.iter().zip(x).map(|(m, x)| m * x).sum::<f64>()).sum()
}

/// Pivots of Gaussian elimination: all positive exactly if a symmetric matrix is positive definite.
fn pivots(mut m: [Joints; JOINTS]) -> Joints {
    for k in 0..JOINTS {
        for i in k + 1..JOINTS {
            let factor = m[i][k] / m[k][k];
            let row = m[k];
            m[i].iter_mut().zip(row).for_each(|(x, y)| *x -= factor * y);
        }
    }
    std::array::from_fn(|k| m[k][k])
}

fn pose() -> impl Strategy<Value = JointVector> {
    let range = |j: usize| REFERENCE.limits[j].q_min as f32..REFERENCE.limits[j].q_max as f32;
    [range(0), range(1), range(2), range(3)].prop_map(JointVector::from)
}

fn speeds() -> impl Strategy<Value = JointVector> {
    let range = |j: usize| -REFERENCE.limits[j].qd_max as f32..REFERENCE.limits[j].qd_max as f32;
    [range(0), range(1), range(2), range(3)].prop_map(JointVector::from)
}

/// Slope at 0 from values at -2h, -h, h and 2h: fourth order, so a step well above `f32` rounding will do.
fn slope(f: impl Fn(f32) -> f64, h: f32) -> f64 {
    (8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * f64::from(h))
}

proptest! {
    #[test]
    fn inertia_matrix_is_symmetric_and_positive_definite(q in pose(), payload in 0.0f32..300.0) {
        let m = mass(&constants(payload), &q);
        for (i, row) in m.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                prop_assert_eq!(*entry, m[j][i]);
            }
        }
        let pivots = pivots(m);
        prop_assert!(pivots.iter().all(|&pivot| pivot > 1.0), "{pivots:?}");
    }

    /// x^T (Mdot - 2 C(q, qd)) x = 0 for any x. C(q, qd) x is the symmetric bilinear form whose squares
    /// are C(q, v) v, so it follows from two of those; x = qd is the balance of the kinetic energy.
    #[test]
    fn mdot_less_twice_c_is_skew(q in pose(), qd in speeds(), x in speeds(), load in 0.0f32..300.0) {
        let constants = constants(load);
        let terms = constants.at(&q);
        for x in [x, qd] {
            let c_x = (terms.coriolis(&(qd + x)) - terms.coriolis(&(qd - x))) / 4.0;
            let twice_c: f64 =
                x.iter().zip(c_x.iter()).map(|(x, c)| 2.0 * f64::from(*x) * f64::from(*c)).sum();
            let m_dot = slope(|t| form(&mass(&constants, &(q + qd * t)), &x), 0.1);
            let x_size = x.map(f64::from).norm();
            let scale = 1e4 * x_size * x_size * (qd.map(f64::from).norm() + 0.1);
            let error = (m_dot - twice_c).abs();
            prop_assert!(error < 3e-4 * scale, "{m_dot} W and {twice_c} W, {}", error / scale);
        }
    }
}
