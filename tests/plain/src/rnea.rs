//! Recursive Newton-Euler algorithm in link coordinates (Craig, Introduction to Robotics, 6.5).

use nalgebra::{Vector3, Vector4};
use shared::arm::JOINTS;

use crate::model::{Frame, Joint, Link, Model};

/// Force and torque on a link, about the origin of its frame, N and N m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wrench {
    pub force: Vector3<f32>,
    pub torque: Vector3<f32>,
}

impl Wrench {
    /// The same wrench in the parent's frame and about its origin.
    #[inline]
    pub fn to_parent(self, frame: &Frame) -> Self {
        let force = frame.rotation * self.force;
        let torque = frame.rotation * self.torque + frame.origin_m.cross(&force);
        Self { force, torque }
    }

    /// What the joint has to bear of it.
    #[inline]
    pub fn effort(&self, joint: Joint) -> f32 {
        match joint {
            Joint::Revolute => self.torque.z,
            Joint::Prismatic => self.force.z,
        }
    }
}

/// Motion of a link in its own axes.
#[derive(Clone, Copy)]
struct Motion {
    /// Angular velocity, rad/s.
    omega: Vector3<f32>,
    /// Angular acceleration, rad/s².
    alpha: Vector3<f32>,
    /// Acceleration of the frame's origin less gravity, m/s².
    acceleration: Vector3<f32>,
}

impl Motion {
    /// Acceleration of a point fixed to the link, m/s².
    #[inline]
    fn at(&self, point_m: &Vector3<f32>) -> Vector3<f32> {
        self.acceleration + self.alpha.cross(point_m) + self.omega.cross(&self.omega.cross(point_m))
    }

    /// Motion of the link that `frame` places on this one.
    #[inline]
    fn child(&self, frame: &Frame, joint: Joint, qd: f32, qdd: f32) -> Self {
        let omega = frame.rotation.tr_mul(&self.omega);
        let alpha = frame.rotation.tr_mul(&self.alpha);
        let acceleration = frame.rotation.tr_mul(&self.at(&frame.origin_m));
        let rate = Vector3::new(0.0, 0.0, qd);
        let rate_dot = Vector3::new(0.0, 0.0, qdd);
        match joint {
            Joint::Revolute => Self {
                omega: omega + rate,
                alpha: alpha + omega.cross(&rate) + rate_dot,
                acceleration,
            },
            Joint::Prismatic => Self {
                omega,
                alpha,
                acceleration: acceleration + omega.cross(&rate) * 2.0 + rate_dot,
            },
        }
    }

    /// Wrench that moves the link like this.
    #[inline]
    fn wrench(&self, link: &Link) -> Wrench {
        let force = self.at(&link.com_m) * link.mass_kg;
        let torque = link.inertia_com * self.alpha
            + self.omega.cross(&(link.inertia_com * self.omega))
            + link.com_m.cross(&force);
        Wrench { force, torque }
    }
}

impl Model {
    /// Joint torques for speeds `qd` and accelerations `qdd`, N m and N.
    #[inline]
    pub(crate) fn newton_euler(
        &self,
        frames: &[Frame; JOINTS],
        qd: &Vector4<f32>,
        qdd: &Vector4<f32>,
        gravity_m_s2: f32,
    ) -> Vector4<f32> {
        let mut motion = Motion {
            omega: Vector3::zeros(),
            alpha: Vector3::zeros(),
            acceleration: Vector3::new(0.0, 0.0, gravity_m_s2),
        };
        let mut wrenches: [Wrench; JOINTS] = core::array::from_fn(|j| {
            let link = &self.links[j];
            motion = motion.child(&frames[j], link.joint, qd[j], qdd[j]);
            motion.wrench(link)
        });
        for j in (1..JOINTS).rev() {
            let carried = wrenches[j].to_parent(&frames[j]);
            wrenches[j - 1].force += carried.force;
            wrenches[j - 1].torque += carried.torque;
        }
        Vector4::from_fn(|j, _| wrenches[j].effort(self.links[j].joint))
    }
}
