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

    /// Inside the bounds, clamping the projected sum is the same as clamping the sum.
    #[test]
    fn the_clamp_projects(share in share(), step in -1e5f32..1e5) {
        let c = Coefficients::new(&Config::default().gains, 2_000.0);
        let d_hat = JointVector::from(bounds()) * share;
        let next = law::adapt(&c, &d_hat, &JointVector::repeat(step));
        for j in 0..JOINTS {
            let bound = bounds()[j];
            let projected = d_hat[j] + law::project(d_hat[j], step, bound);
            prop_assert_eq!(next[j], projected.clamp(-bound, bound));
        }
    }

    /// (ii): beta_tilde^T (psi^-1 Proj(psi delta) - delta) <= 0 with beta_tilde = beta_hat - beta.
    #[test]
    fn the_projection_only_helps(
        estimate in proptest::array::uniform4(share()),
        truth in proptest::array::uniform4(share()),
        psi in proptest::array::uniform4(1.0f32..1e11),
        step in proptest::array::uniform4(prop_oneof![-1e3f32..1e3, -1e30f32..1e30]),
    ) {
        let mut sum = 0.0;
        for j in 0..JOINTS {
            let bound = bounds()[j];
            let beta_hat = estimate[j] * bound;
            let psi = f64::from(psi[j]);
            // psi delta is the step, so that no rounding stands between them.
            let delta = f64::from(step[j]) / psi;
            let projected = f64::from(law::project(beta_hat, step[j], bound)) / psi;
            sum += f64::from(beta_hat - truth[j] * bound) * (projected - delta);
        }
        prop_assert!(sum <= 0.0, "{sum}");
    }

    #[test]
    fn inside_the_bounds_the_projection_changes_nothing(
        share in -0.999f32..0.999, step in -1e30f32..1e30
    ) {
        let bound = bounds()[0];
        prop_assert_eq!(law::project(share * bound, step, bound), step);
    }
}

#[test]
fn a_step_outwards_from_the_edge_is_dropped_and_one_inwards_is_taken() {
    for edge in [-6_000.0f32, 6_000.0] {
        assert_eq!(law::project(edge, edge, 6_000.0), 0.0);
        assert_eq!(law::project(edge, -edge, 6_000.0), -edge);
    }
}
