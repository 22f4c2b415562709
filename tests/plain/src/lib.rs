#![no_std]
//! The controller's law written the plain way: generic recursions over `nalgebra` and `libm`, in `f32`.
//!
//! Two versions share this model of the arm and the law itself, and differ in how they come by M and
//! C qd + G:
//! - [`control_by_crba`]: the composite-rigid-body algorithm for M and one recursive Newton-Euler pass for
//!   the bias, over link frames computed once;
//! - [`control_by_five_calls`]: five calls of inverse dynamics, one a column of M and one for the bias.
//!
//! They are the yardstick of the benchmark on the host and of cycle counts on the target, so they build
//! for both. Joint 4 is prismatic: the last component of a joint vector is in m, m/s or N.

mod crba;
mod law;
mod model;
mod rnea;

pub use law::{Adaptation, Command, Gains, State, control_by_crba, control_by_five_calls};
pub use model::Model;

use nalgebra::{Matrix4, Vector4};

/// What the law needs to know about the dynamics at one state.
#[derive(Clone, Copy, Debug)]
pub struct Terms {
    /// M(q), kg m² (row and column 4: kg m and kg).
    pub mass: Matrix4<f32>,
    /// C(q, qd) qd + G(q), N m and N.
    pub bias: Vector4<f32>,
}

impl Model {
    /// M by composite bodies and the bias by one Newton-Euler pass, over shared link frames.
    #[inline]
    pub fn terms_by_crba(&self, q: &Vector4<f32>, qd: &Vector4<f32>) -> Terms {
        let frames = self.frames(q);
        Terms {
            mass: self.composite_mass(&frames),
            bias: self.newton_euler(&frames, qd, &Vector4::zeros(), self.gravity_m_s2),
        }
    }

    /// M column by column from unit accelerations at rest without gravity, and the bias: five calls.
    #[inline]
    pub fn terms_by_five_calls(&self, q: &Vector4<f32>, qd: &Vector4<f32>) -> Terms {
        let rest = Vector4::zeros();
        let column = |qdd| self.inverse_dynamics(q, &rest, &qdd, 0.0);
        Terms {
            mass: Matrix4::from_columns(&[
                column(Vector4::x()),
                column(Vector4::y()),
                column(Vector4::z()),
                column(Vector4::w()),
            ]),
            bias: self.inverse_dynamics(q, qd, &rest, self.gravity_m_s2),
        }
    }

    /// Torque for the acceleration `qdd` under `gravity_m_s2`, N m and N.
    #[inline]
    pub fn inverse_dynamics(
        &self,
        q: &Vector4<f32>,
        qd: &Vector4<f32>,
        qdd: &Vector4<f32>,
        gravity_m_s2: f32,
    ) -> Vector4<f32> {
        self.newton_euler(&self.frames(q), qd, qdd, gravity_m_s2)
    }
}
