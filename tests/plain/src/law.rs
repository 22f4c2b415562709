//! Adaptive backstepping on given dynamics: the firmware's law, with its two adaptations.
//!
//! tau = M (qdd_d - K1 e1' - K2 z) + C qd + G + d_hat with z = K1 e1 + e1', limited;
//! d_hat' = Proj(-wa² M z), or Proj(-psi M⁻¹ z).

use nalgebra::{Matrix4, Vector4};

use crate::{Model, Terms};

/// How the disturbance estimate adapts.
#[derive(Clone, Copy, Debug)]
pub enum Adaptation {
    /// psi = wa² M², with the bandwidth wa in rad/s.
    InertiaWeighted(f32),
    /// A constant diagonal psi; M⁻¹ z by Cholesky factorisation.
    PaperPsi(Vector4<f32>),
}

/// Gains and bounds of the law.
#[derive(Clone, Copy, Debug)]
pub struct Gains {
    /// Diagonal of K1, 1/s.
    pub k1: Vector4<f32>,
    /// Diagonal of K2, 1/s.
    pub k2: Vector4<f32>,
    /// Adaptation.
    pub adaptation: Adaptation,
    /// Bound of d_hat, N m and N.
    pub d_max: Vector4<f32>,
    /// Bound of the torque, N m and N.
    pub tau_max: Vector4<f32>,
    /// Time from tick to tick, s.
    pub tick_s: f32,
}

/// Measured state and set-point; rad and m, rad/s and m/s.
#[derive(Clone, Copy, Debug)]
pub struct State {
    /// Position.
    pub q: Vector4<f32>,
    /// Velocity.
    pub qd: Vector4<f32>,
    /// e1 = q - q_d.
    pub e1: Vector4<f32>,
    /// e1' = qd - qd_d.
    pub e1_dot: Vector4<f32>,
    /// qdd_d, rad/s² and m/s².
    pub qdd_d: Vector4<f32>,
}

/// Torque and the next disturbance estimate, N m and N.
#[derive(Clone, Copy, Debug)]
pub struct Command {
    /// tau within its limits.
    pub torque: Vector4<f32>,
    /// d_hat of the next tick.
    pub d_hat: Vector4<f32>,
}

/// The law on [`Model::terms_by_crba`].
#[inline]
pub fn control_by_crba(model: &Model, gains: &Gains, s: &State, d_hat: &Vector4<f32>) -> Command {
    control(&model.terms_by_crba(&s.q, &s.qd), gains, s, d_hat)
}

/// The law on [`Model::terms_by_five_calls`].
#[inline]
pub fn control_by_five_calls(
    model: &Model,
    gains: &Gains,
    s: &State,
    d_hat: &Vector4<f32>,
) -> Command {
    control(&model.terms_by_five_calls(&s.q, &s.qd), gains, s, d_hat)
}

#[inline]
fn control(terms: &Terms, gains: &Gains, s: &State, d_hat: &Vector4<f32>) -> Command {
    let z = gains.k1.component_mul(&s.e1) + s.e1_dot;
    let a = s.qdd_d - gains.k1.component_mul(&s.e1_dot) - gains.k2.component_mul(&z);
    let torque = terms.mass * a + terms.bias + d_hat;
    let step = adaptation(&gains.adaptation, &terms.mass, &z) * gains.tick_s;
    let next = d_hat.zip_zip_map(&step, &gains.d_max, |d, step, bound| {
        limited(d + projected(d, step, bound), bound)
    });
    Command { torque: torque.zip_map(&gains.tau_max, limited), d_hat: next }
}

/// d_hat' before projection.
#[inline]
fn adaptation(law: &Adaptation, mass: &Matrix4<f32>, z: &Vector4<f32>) -> Vector4<f32> {
    match law {
        Adaptation::InertiaWeighted(wa_rad_s) => mass * z * -(wa_rad_s * wa_rad_s),
        Adaptation::PaperPsi(psi) => {
            // An arm's M is positive definite: only a NaN has no factor.
            let delta = mass.cholesky().map_or_else(Vector4::zeros, |factor| factor.solve(z));
            -psi.component_mul(&delta)
        }
    }
}

/// Drops a step that would leave the bound from its edge.
#[inline]
fn projected(estimate: f32, step: f32, bound: f32) -> f32 {
    if (estimate >= bound && step > 0.0) || (estimate <= -bound && step < 0.0) { 0.0 } else { step }
}

#[inline]
fn limited(x: f32, bound: f32) -> f32 {
    if x > bound {
        bound
    } else if x < -bound {
        -bound
    } else {
        x
    }
}
