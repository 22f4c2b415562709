//! Rigid-body dynamics M(q) qdd + C(q, qd) qd + G(q) = tau (paper Eq 2).
//!
//! The bias force C qd + G comes from the recursive Newton-Euler algorithm, M from composite bodies: the
//! outboard part of the arm is one rigid body for each joint, and its unit wrench is carried to the base.

use shared::arm::{Arm, GRAVITY_M_S2, Geometry, PAYLOAD};

use super::body::{Body, Motion, Wrench};
use super::chain::{self, BOOM, COLUMN, FOREARM, Frame, Frames, Pose, TELESCOPE};
use super::solve::Ldlt;
use super::{Joints, Matrix, Vector, add, dot};

/// The arm's rigid bodies and their dynamics.
#[derive(Clone, Debug)]
pub struct Model {
    geometry: Geometry,
    links: [Body; 4],
    bare_telescope: Body,
}

impl Model {
    /// The arm without a payload.
    pub fn new(arm: &Arm) -> Self {
        let links = arm.links.map(|link| Body::new(&link));
        Self { geometry: arm.geometry, links, bare_telescope: links[TELESCOPE] }
    }

    /// Holds a payload of this mass rigidly, shaped like [`PAYLOAD`]; 0 lets it go.
    pub fn set_payload(&mut self, mass_kg: f64) {
        let payload = Body::new(&PAYLOAD).scaled(mass_kg / PAYLOAD.mass_kg);
        self.links[TELESCOPE] = self.bare_telescope.plus(&payload);
    }

    /// Pose of the tip (Eq 1).
    pub fn forward(&self, q: &Joints) -> Pose {
        chain::forward(&self.geometry, q)
    }

    /// Position and velocity of the tip, world axes, m and m/s.
    pub fn tip(&self, q: &Joints, qd: &Joints) -> ([f64; 3], [f64; 3]) {
        chain::tip(&self.geometry, q, qd)
    }

    /// Geometric Jacobian at the tip in world axes: rows linear x, y, z, then angular x, y, z.
    pub fn jacobian(&self, q: &Joints) -> [Joints; 6] {
        chain::jacobian(&self.geometry, q)
    }

    /// Mass matrix M(q), kg m², kg m and kg.
    pub fn mass_matrix(&self, q: &Joints) -> [Joints; 4] {
        self.composite_mass(&Frames::new(&self.geometry, q))
    }

    /// C(q, qd) qd + G(q), N m and N.
    pub fn bias(&self, q: &Joints, qd: &Joints) -> Joints {
        self.inverse_dynamics(q, qd, &[0.0; 4])
    }

    /// C(q, qd) qd, N m and N.
    pub fn coriolis(&self, q: &Joints, qd: &Joints) -> Joints {
        self.newton_euler(&Frames::new(&self.geometry, q), qd, &[0.0; 4], 0.0)
    }

    /// G(q), N m and N.
    pub fn gravity(&self, q: &Joints) -> Joints {
        self.bias(q, &[0.0; 4])
    }

    /// Torque that moves the arm with this acceleration, N m and N.
    pub fn inverse_dynamics(&self, q: &Joints, qd: &Joints, qdd: &Joints) -> Joints {
        self.newton_euler(&Frames::new(&self.geometry, q), qd, qdd, GRAVITY_M_S2)
    }

    /// Acceleration under the torque tau - d, rad/s² and m/s².
    pub fn forward_dynamics(&self, q: &Joints, qd: &Joints, tau_minus_d: &Joints) -> Joints {
        self.at(q, qd, &[false; 4]).acceleration(tau_minus_d)
    }

    /// Factored mass matrix and bias of one state. Locked joints do not accelerate.
    pub(super) fn at(&self, q: &Joints, qd: &Joints, locked: &[bool; 4]) -> Dynamics {
        let frames = Frames::new(&self.geometry, q);
        let mut mass = self.composite_mass(&frames);
        for j in (0..4).filter(|&j| locked[j]) {
            mass.iter_mut().for_each(|row| row[j] = 0.0);
            mass[j] = [0.0; 4];
            mass[j][j] = 1.0;
        }
        Dynamics {
            mass: Ldlt::new(&mass),
            bias: self.newton_euler(&frames, qd, &[0.0; 4], GRAVITY_M_S2),
            locked: *locked,
        }
    }

    #[inline(always)]
    fn newton_euler(&self, frames: &Frames, qd: &Joints, qdd: &Joints, g_m_s2: f64) -> Joints {
        let column = Motion {
            rate_rad_s: [0.0, 0.0, qd[COLUMN]],
            rate_dot_rad_s2: [0.0, 0.0, qdd[COLUMN]],
            acceleration_m_s2: [0.0, 0.0, g_m_s2],
        };
        let column_field = column.field();
        let boom = follow(&frames.boom, &column, &column_field, qd[BOOM], qdd[BOOM]);
        let boom_field = boom.field();
        let forearm = follow(&frames.forearm, &boom, &boom_field, qd[FOREARM], qdd[FOREARM]);
        let forearm_field = forearm.field();
        let telescope =
            follow(&frames.telescope, &forearm, &forearm_field, qd[TELESCOPE], qdd[TELESCOPE]);

        let [body_1, body_2, body_3, body_4] = &self.links;
        let on_4 = body_4.wrench(&telescope, &telescope.field());
        let on_3 = body_3.wrench(&forearm, &forearm_field).plus(&on_4.to_parent(&frames.telescope));
        let on_2 = body_2.wrench(&boom, &boom_field).plus(&on_3.to_parent(&frames.forearm));
        let on_1 = body_1.wrench(&column, &column_field).plus(&on_2.to_parent(&frames.boom));
        [
            on_1.effort::<COLUMN>(),
            on_2.effort::<BOOM>(),
            on_3.effort::<FOREARM>(),
            on_4.effort::<TELESCOPE>(),
        ]
    }

    #[inline(always)]
    fn composite_mass(&self, frames: &Frames) -> Matrix {
        let [body_1, body_2, body_3, body_4] = &self.links;
        let from_3 = body_3.plus(&body_4.to_parent(&frames.telescope));
        let from_2 = body_2.plus(&from_3.to_parent(&frames.forearm));
        let from_1 = body_1.plus(&from_2.to_parent(&frames.boom));

        let wrench_4 = body_4.unit_wrench::<TELESCOPE>();
        let wrench_3 = from_3.unit_wrench::<FOREARM>();
        let wrench_2 = from_2.unit_wrench::<BOOM>();
        let m00 = from_1.unit_wrench::<COLUMN>().effort::<COLUMN>();
        let m11 = wrench_2.effort::<BOOM>();
        let m01 = wrench_2.to_parent(&frames.boom).effort::<COLUMN>();
        let [m02, m12] = down_from_forearm(frames, wrench_3);
        let on_3 = wrench_4.to_parent(&frames.telescope);
        let [m03, m13] = down_from_forearm(frames, on_3);
        let (m22, m23) = (wrench_3.effort::<FOREARM>(), on_3.effort::<FOREARM>());
        [
            [m00, m01, m02, m03],
            [m01, m11, m12, m13],
            [m02, m12, m22, m23],
            [m03, m13, m23, body_4.mass_kg],
        ]
    }
}

/// Efforts of joints 1 and 2 against a wrench in the forearm's frame.
fn down_from_forearm(frames: &Frames, wrench: Wrench) -> [f64; 2] {
    let on_2 = wrench.to_parent(&frames.forearm);
    [on_2.to_parent(&frames.boom).effort::<COLUMN>(), on_2.effort::<BOOM>()]
}

/// Motion of link `J` from that of its parent and of its own joint.
#[inline(always)]
fn follow<const J: usize>(
    frame: &Frame<J>,
    parent: &Motion,
    parent_field: &[Vector; 3],
    qd: f64,
    qdd: f64,
) -> Motion {
    let carried_rad_s = frame.unrotate(parent.rate_rad_s);
    let carried_rad_s2 = frame.unrotate(parent.rate_dot_rad_s2);
    let [x, y, z] = carried_rad_s;
    let at_origin = parent_field.map(|row| dot(row, frame.origin_m));
    let carried_m_s2 = frame.unrotate(add(parent.acceleration_m_s2, at_origin));
    if J == TELESCOPE {
        let coriolis = [2.0 * y * qd, -2.0 * x * qd, qdd];
        Motion {
            rate_rad_s: carried_rad_s,
            rate_dot_rad_s2: carried_rad_s2,
            acceleration_m_s2: add(carried_m_s2, coriolis),
        }
    } else {
        Motion {
            rate_rad_s: [x, y, z + qd],
            rate_dot_rad_s2: add(carried_rad_s2, [y * qd, -x * qd, qdd]),
            acceleration_m_s2: carried_m_s2,
        }
    }
}

/// The equations of motion at one state, ready to be solved.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dynamics {
    mass: Ldlt,
    bias: Joints,
    pub locked: [bool; 4],
}

impl Dynamics {
    /// Acceleration under a joint torque, bias excluded; zero where locked.
    pub fn acceleration(&self, torque: &Joints) -> Joints {
        let net =
            core::array::from_fn(|j| if self.locked[j] { 0.0 } else { torque[j] - self.bias[j] });
        self.mass.solve(&net)
    }
}
