//! Pose of the tip and its Jacobian in closed form (Eq 1 with its signs mended), world axes.

use nalgebra::{Matrix3, SMatrix, Vector3};

use crate::JointVector;
use crate::config::Geometry;
use crate::math::sin_cos;

/// Position and orientation of frame 4 in the base frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Tip position, m.
    pub position_m: Vector3<f32>,
    /// Rotation matrix, base from tip.
    pub rotation: Matrix3<f32>,
}

/// Sines, cosines and in-plane coordinates that pose and Jacobian share.
struct Plane {
    s1: f32,
    c1: f32,
    sw: f32,
    cw: f32,
    /// Radius and height from the boom pin's column axis, m.
    x: f32,
    z: f32,
    /// Height of the tip over the boom pin and over the elbow, radius likewise, m.
    z2: f32,
    x2: f32,
    z3: f32,
    x3: f32,
}

impl Plane {
    fn at(g: &Geometry, q: &JointVector) -> Self {
        let (s1, c1) = sin_cos(q.x);
        let (s2, c2) = sin_cos(q.y);
        let (sw, cw) = sin_cos(q.y + q.z);
        let x3 = g.a3_m * cw + q.w * sw;
        let z3 = g.a3_m * sw - q.w * cw;
        let x2 = x3 + g.a2_m * c2;
        let z2 = z3 + g.a2_m * s2;
        Self { s1, c1, sw, cw, x: x2 + g.a1_m, z: z2 + g.d1_m, z2, x2, z3, x3 }
    }
}

/// Tip pose at `q`.
pub fn forward(g: &Geometry, q: &JointVector) -> Pose {
    let p = Plane::at(g, q);
    #[rustfmt::skip]
    let rotation = Matrix3::new(
        p.s1 * p.cw, -p.c1, -p.s1 * p.sw,
        -p.c1 * p.cw, -p.s1, p.c1 * p.sw,
        -p.sw, 0.0, -p.cw,
    );
    let position_m = Vector3::new(-p.s1 * p.x + p.c1 * g.d3_m, p.c1 * p.x + p.s1 * g.d3_m, p.z);
    Pose { position_m, rotation }
}

/// Jacobian at `q`: rows vx, vy, vz, ωx, ωy, ωz of the tip in world axes, one column a joint.
pub fn jacobian(g: &Geometry, q: &JointVector) -> SMatrix<f32, 6, 4> {
    let p = Plane::at(g, q);
    let (s1, c1) = (p.s1, p.c1);
    #[rustfmt::skip]
    let rows = SMatrix::<f32, 6, 4>::new(
        -c1 * p.x - s1 * g.d3_m, s1 * p.z2, s1 * p.z3, -s1 * p.sw,
        -s1 * p.x + c1 * g.d3_m, -c1 * p.z2, -c1 * p.z3, c1 * p.sw,
        0.0, p.x2, p.x3, -p.cw,
        0.0, c1, c1, 0.0,
        0.0, s1, s1, 0.0,
        1.0, 0.0, 0.0, 0.0,
    );
    rows
}
