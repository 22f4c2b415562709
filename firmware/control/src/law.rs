//! Control laws: adaptive robust backstepping (Eq 10 to 20) and the PD of Eq 29.
//!
//! Plant: M qdd + C qd + G = tau - d. With e1 = q - q_d and z = K1 e1 + e1':
//!
//! tau_d = M (qdd_d - K1 e1' - K2 z) + C qd + G + d_hat,  d_hat' = Proj(-psi delta).
//!
//! With this sign, and not the printed one, d_hat estimates d itself. Two adaptations:
//! - **paper**: delta = M⁻¹ z with a constant diagonal psi; Va' <= 0 follows as in Section 3.3.
//! - **inertia-weighted**: psi = wa² M², so d_hat' = Proj(-wa² M z). Every direction adapts at the same
//!   rate and nothing is solved or divided. The proof holds for a constant psi; since M moves slowly
//!   against wa, here it is a local argument.

use bytemuck::{Pod, Zeroable};
use shared::arm::JOINTS;

use crate::config::{Gains, Law};
use crate::dynamics::{Constants, Terms};
use crate::ldlt;
use crate::math::clamp_symmetric;
use crate::{JointMatrix, JointVector};

/// Gains turned into what a tick uses.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Coefficients {
    /// Which law.
    law: Law,
    /// K1, or the PD's Kd.
    k1: JointVector,
    /// K2, or the PD's Kp.
    k2: JointVector,
    /// -T psi for the constant diagonal, -T wa² in every place for the inertia-weighted law.
    rate: JointVector,
    d_max: JointVector,
}

impl Coefficients {
    /// Coefficients for one tick of 1 / `tick_hz`.
    pub fn new(gains: &Gains, tick_hz: f32) -> Self {
        let rate = match gains.law {
            Law::INERTIA_WEIGHTED => JointVector::repeat(gains.wa_rad_s * gains.wa_rad_s),
            Law::PAPER_PSI => JointVector::from(gains.psi),
            _ => JointVector::repeat(0.0),
        };
        let (k1, k2) = match gains.law {
            Law::PD => (gains.kd, gains.kp),
            _ => (gains.k1, gains.k2),
        };
        Self {
            law: gains.law,
            k1: k1.into(),
            k2: k2.into(),
            rate: rate / -tick_hz,
            d_max: gains.d_max.into(),
        }
    }
}

/// Measured state and set-point of one tick.
#[derive(Clone, Copy, Debug)]
pub struct State {
    /// Position, rad and m.
    pub q: JointVector,
    /// Velocity, rad/s and m/s.
    pub qd: JointVector,
    /// e1 = q - q_d.
    pub e1: JointVector,
    /// e1' = qd - qd_d.
    pub e1_dot: JointVector,
    /// qdd_d, rad/s² and m/s².
    pub qdd_d: JointVector,
}

/// What the law makes of one tick.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// tau_d before limits, N m and N.
    pub torque: JointVector,
    /// The joint acceleration that this torque is to cause, rad/s² and m/s²: the model's prediction.
    pub acceleration: JointVector,
    /// T · (-psi delta): the unprojected step of d_hat, N m and N.
    pub adaptation: JointVector,
}

impl Coefficients {
    /// What these gains in place of those `before` take off the acceleration that the law asks for, rad/s² and m/s²:
    /// they show in nothing else.
    pub fn less_than(&self, before: &Self, e1: &JointVector, e1_dot: &JointVector) -> JointVector {
        let mut less = JointVector::repeat(0.0);
        for j in 0..JOINTS {
            let (now, then) = (self.stiffness(j), before.stiffness(j));
            less[j] = (now.0 - then.0) * e1[j] + (now.1 - then.1) * e1_dot[j];
        }
        less
    }

    /// The law's factors of e1 and of e1' for joint `j`.
    #[inline(always)]
    fn stiffness(&self, j: usize) -> (f32, f32) {
        let (k1, k2) = (self.k1[j], self.k2[j]);
        if self.law == Law::PD { (k2, k1) } else { (k1 * k2, k1 + k2) }
    }
}

/// Evaluates the law. `d_hat` is the estimate before this tick's step (Eq 18 uses d_hat_k); the PD has none.
#[inline(always)]
pub fn evaluate(c: &Coefficients, arm: &Constants, s: &State, d_hat: &JointVector) -> Wanted {
    let terms = arm.at(&s.q);
    let bias = terms.coriolis(&s.qd) + terms.gravity();
    // To choose between z and e1 further down would cost the other laws the registers of both.
    if c.law == Law::PD {
        let acceleration = s.qdd_d - c.k1.component_mul(&s.e1_dot) - c.k2.component_mul(&s.e1);
        let torque = terms.inertia_times(&acceleration) + bias;
        return Wanted { torque, acceleration, adaptation: zero() };
    }
    let z = c.k1.component_mul(&s.e1) + s.e1_dot;
    let acceleration = s.qdd_d - c.k1.component_mul(&s.e1_dot) - c.k2.component_mul(&z);
    Wanted {
        torque: terms.inertia_times(&acceleration) + bias + d_hat,
        acceleration,
        adaptation: c.rate.component_mul(&delta(c.law, &terms, &z)),
    }
}

/// No number but zeros.
#[inline(always)]
fn zero() -> JointVector {
    JointVector::new(0.0, 0.0, 0.0, 0.0)
}

/// The adaptive function: M z or M⁻¹ z; nothing where nothing adapts.
#[inline(always)]
fn delta(law: Law, terms: &Terms<'_>, z: &JointVector) -> JointVector {
    match law {
        Law::INERTIA_WEIGHTED => terms.inertia_times(z),
        Law::PAPER_PSI => {
            let m: JointMatrix = terms.inertia_matrix();
            ldlt::solve(&m, z)
        }
        _ => zero(),
    }
}

/// Eq 8: a step that would leave ±`bound` from its edge is dropped.
#[inline(always)]
pub fn project(estimate: f32, step: f32, bound: f32) -> f32 {
    let outward = (estimate >= bound && step > 0.0) || (estimate <= -bound && step < 0.0);
    if outward { 0.0 } else { step }
}

/// d_hat one tick on. The clamp that a discrete step needs anyway drops at the edge just what [`project`]
/// drops, so the tick saves the comparisons.
#[inline(always)]
pub fn adapt(c: &Coefficients, d_hat: &JointVector, step: &JointVector) -> JointVector {
    d_hat.zip_zip_map(step, &c.d_max, |d, step, bound| clamp_symmetric(d + step, bound))
}

impl Coefficients {
    /// One bit a joint whose estimate sits at its bound.
    #[inline(always)]
    pub fn at_bound(&self, d_hat: &JointVector) -> u8 {
        bits(d_hat.zip_map(&self.d_max, |d, bound| f32::from(d.abs() >= bound)))
    }
}

/// Non-zero components as bits, joint 1 lowest.
#[inline(always)]
pub fn bits(flags: JointVector) -> u8 {
    let flag = |f: f32, bit: u8| if f == 0.0 { 0 } else { bit };
    flag(flags.x, 1) | flag(flags.y, 2) | flag(flags.z, 4) | flag(flags.w, 8)
}
