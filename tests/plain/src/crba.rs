//! Composite-rigid-body algorithm (Featherstone, Rigid Body Dynamics Algorithms, 6.2).

use nalgebra::{Matrix3, Matrix4, Vector3};
use shared::arm::JOINTS;

use crate::model::{Frame, Joint, Link, Model};
use crate::rnea::Wrench;

/// A rigid body made of all links from one joint outward, in that link's frame.
#[derive(Clone, Copy)]
struct Composite {
    mass_kg: f32,
    /// Mass times centre of mass, kg m.
    moment: Vector3<f32>,
    /// Inertia tensor about the frame's origin, kg m².
    inertia: Matrix3<f32>,
}

impl Composite {
    #[inline]
    fn of(link: &Link) -> Self {
        Self {
            mass_kg: link.mass_kg,
            moment: link.com_m * link.mass_kg,
            inertia: link.inertia_origin,
        }
    }

    /// This body together with `child`, which `frame` places on it.
    #[inline]
    fn carrying(&self, child: &Self, frame: &Frame) -> Self {
        let moment = frame.rotation * child.moment;
        let inertia = frame.rotation * child.inertia * frame.rotation.transpose();
        let p = &frame.origin_m;
        let shift = p * p.transpose() * child.mass_kg + p * moment.transpose();
        let spread = child.mass_kg * p.norm_squared() + 2.0 * p.dot(&moment);
        Self {
            mass_kg: self.mass_kg + child.mass_kg,
            moment: self.moment + moment + p * child.mass_kg,
            inertia: self.inertia + inertia + Matrix3::identity() * spread
                - shift
                - moment * p.transpose(),
        }
    }

    /// Wrench that accelerates the resting body by one unit of `joint`.
    #[inline]
    fn unit_wrench(&self, joint: Joint) -> Wrench {
        let axis = Vector3::z();
        match joint {
            Joint::Revolute => {
                Wrench { force: axis.cross(&self.moment), torque: self.inertia * axis }
            }
            Joint::Prismatic => {
                Wrench { force: axis * self.mass_kg, torque: self.moment.cross(&axis) }
            }
        }
    }
}

impl Model {
    /// M(q) from the link frames at q.
    #[inline]
    pub(crate) fn composite_mass(&self, frames: &[Frame; JOINTS]) -> Matrix4<f32> {
        let mut bodies = self.links.each_ref().map(Composite::of);
        for j in (1..JOINTS).rev() {
            bodies[j - 1] = bodies[j - 1].carrying(&bodies[j], &frames[j]);
        }
        let mut mass = Matrix4::zeros();
        for j in 0..JOINTS {
            let mut wrench = bodies[j].unit_wrench(self.links[j].joint);
            mass[(j, j)] = wrench.effort(self.links[j].joint);
            for i in (0..j).rev() {
                wrench = wrench.to_parent(&frames[i + 1]);
                mass[(i, j)] = wrench.effort(self.links[i].joint);
                mass[(j, i)] = mass[(i, j)];
            }
        }
        mass
    }
}
