//! Eq 9 of the projection, for a diagonal psi.

use firmware::JointVector;
use firmware::config::Config;
use firmware::law::{self, Coefficients};
use proptest::prelude::*;
use shared::arm::JOINTS;

fn bounds() -> [f32; JOINTS] {
    Config::default().gains.d_max
}

/// A number within ±1, the edges among them.
fn share() -> impl Strategy<Value = f32> {
    prop_oneof![Just(-1.0f32), Just(1.0f32), -1.0f32..=1.0]
}

/// Steps small against the bounds, far beyond them, and everything an `f32` can hold.
fn step() -> impl Strategy<Value = f32> {
    prop_oneof![-100.0f32..100.0, -1e5f32..1e5, any::<f32>(), Just(f32::NAN), Just(f32::INFINITY)]
}

proptest! {
    /// (i): whatever is asked for, the estimate stays within its bounds, and inside it follows the steps.
    #[test]
    fn the_estimate_never_leaves_its_bounds(
        steps in proptest::collection::vec(proptest::array::uniform4(step()), 1..200)
    ) {
        let c = Coefficients::new(&Config::default().gains, 2_000.0);
        let mut d_hat = JointVector::zeros();
        for step in steps {
            let next = law::adapt(&c, &d_hat, &step.into());
            for j in 0..JOINTS {
                prop_assert!(next[j].abs() <= bounds()[j], "joint {j}: {}", next[j]);
                let free = d_hat[j] + step[j];
                if free.abs() < bounds()[j] && d_hat[j].abs() < bounds()[j] {
                    prop_assert_eq!(next[j], free);
                }
            }
            d_hat = next;
        }
    }

    /// (ii) for a discrete step: beta_tilde^T (psi^-1 Proj(psi delta) - delta) <= 0 with beta_tilde after it.
    #[test]
    fn the_projection_only_helps(
        estimate in proptest::array::uniform4(share()),
        truth in proptest::array::uniform4(share()),
        psi in proptest::array::uniform4(1.0f32..1e11),
        step in proptest::array::uniform4(prop_oneof![-1e4f32..1e4, -1e30f32..1e30]),
    ) {
        let mut sum = 0.0;
        for j in 0..JOINTS {
            let bound = bounds()[j];
            let before = estimate[j] * bound;
            let after = law::project(before, step[j], bound);
            let left_out = f64::from(after) - f64::from(before + step[j]);
            sum += f64::from(after - truth[j] * bound) * left_out / f64::from(psi[j]);
        }
        prop_assert!(sum <= 0.0, "{sum}");
    }

    /// (ii) as it is written, with beta_tilde before the step: from the edges, where Eq 8 has its cases.
    #[test]
    fn at_the_edges_the_projection_is_that_of_eq_8(
        up in proptest::array::uniform4(any::<bool>()),
        truth in proptest::array::uniform4(share()),
        psi in proptest::array::uniform4(1.0f32..1e11),
        step in proptest::array::uniform4(-1.0f32..=1.0),
    ) {
        let mut sum = 0.0;
        for j in 0..JOINTS {
            let bound = bounds()[j];
            let edge = if up[j] { bound } else { -bound };
            let (step, psi) = (step[j] * bound, f64::from(psi[j]));
            let taken = f64::from(law::project(edge, step, bound)) - f64::from(edge);
            let asked = f64::from(edge + step) - f64::from(edge);
            prop_assert_eq!(taken, if (step > 0.0) == up[j] { 0.0 } else { asked });
            sum += f64::from(edge - truth[j] * bound) * (taken - asked) / psi;
        }
        prop_assert!(sum <= 0.0, "{sum}");
    }
}
