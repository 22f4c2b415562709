//! The arm as a chain of links, from the modified Denavit-Hartenberg table.

use core::f32::consts::FRAC_PI_2;

use nalgebra::{Matrix3, Vector3, Vector4};
use shared::arm::{Arm, GRAVITY_M_S2, Inertial, JOINTS};

/// How a joint moves its link: about or along the link's z axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Joint {
    Revolute,
    Prismatic,
}

/// A link, its joint and where the joint sits on its parent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Link {
    pub joint: Joint,
    /// Turn and offset of the joint in the parent's frame at q = 0.
    turn: Matrix3<f32>,
    offset_m: Vector3<f32>,
    pub mass_kg: f32,
    pub com_m: Vector3<f32>,
    /// Inertia tensor about the centre of mass, kg m².
    pub inertia_com: Matrix3<f32>,
    /// Inertia tensor about the frame's origin, kg m².
    pub inertia_origin: Matrix3<f32>,
}

/// The arm's links and gravity, rounded to `f32`.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    pub(crate) links: [Link; JOINTS],
    /// Gravity, m/s².
    pub gravity_m_s2: f32,
}

/// Placement of a link in its parent's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    /// Link axes to parent axes.
    pub rotation: Matrix3<f32>,
    pub origin_m: Vector3<f32>,
}

impl Model {
    /// The model of `arm` without a payload.
    pub fn new(arm: &Arm) -> Self {
        let g = &arm.geometry;
        let [column, boom, forearm, telescope] = &arm.links;
        let at = |x: f64, y: f64, z: f64| Vector3::new(x as f32, y as f32, z as f32);
        let none = Matrix3::identity();
        let upright = rotation_x(FRAC_PI_2);
        let back = rotation_z(2.0 * FRAC_PI_2);
        let aside = rotation_z(FRAC_PI_2);
        Self {
            links: [
                Link::new(Joint::Revolute, none, Vector3::zeros(), column),
                Link::new(Joint::Revolute, aside * upright, at(0.0, g.a1_m, g.d1_m), boom),
                Link::new(Joint::Revolute, none, at(g.a2_m, 0.0, g.d3_m), forearm),
                Link::new(Joint::Prismatic, upright * back, at(g.a3_m, 0.0, 0.0), telescope),
            ],
            gravity_m_s2: GRAVITY_M_S2 as f32,
        }
    }

    /// Frames of all links at the pose `q`, rad and m.
    #[inline]
    pub(crate) fn frames(&self, q: &Vector4<f32>) -> [Frame; JOINTS] {
        core::array::from_fn(|j| self.links[j].frame(q[j]))
    }
}

impl Link {
    fn new(joint: Joint, turn: Matrix3<f32>, offset_m: Vector3<f32>, body: &Inertial) -> Self {
        let mass_kg = body.mass_kg as f32;
        let com_m = Vector3::from(body.com_m.map(|c| c as f32));
        let [ixx, iyy, izz, ixy, ixz, iyz] = body.inertia_com_kg_m2.map(|i| i as f32);
        let inertia_com = Matrix3::new(ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz);
        let steiner = Matrix3::identity() * com_m.norm_squared() - com_m * com_m.transpose();
        let inertia_origin = inertia_com + steiner * mass_kg;
        Self { joint, turn, offset_m, mass_kg, com_m, inertia_com, inertia_origin }
    }

    #[inline]
    fn frame(&self, q: f32) -> Frame {
        match self.joint {
            Joint::Revolute => {
                Frame { rotation: self.turn * rotation_z(q), origin_m: self.offset_m }
            }
            Joint::Prismatic => {
                let origin_m = self.offset_m + self.turn * Vector3::new(0.0, 0.0, q);
                Frame { rotation: self.turn, origin_m }
            }
        }
    }
}

#[inline]
fn rotation_x(angle_rad: f32) -> Matrix3<f32> {
    let (s, c) = libm::sincosf(angle_rad);
    Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c)
}

#[inline]
fn rotation_z(angle_rad: f32) -> Matrix3<f32> {
    let (s, c) = libm::sincosf(angle_rad);
    Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)
}
