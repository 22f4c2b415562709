//! Kinematics: the link frames of paper Table 1 (modified Denavit-Hartenberg).
//!
//! Each frame follows from its parent by an offset, a fixed turn and the joint's own motion about or along
//! z. Every alpha of the table is 0 or pi/2, so the fixed turns only swap axes and signs:
//!
//! | joint | rows | fixed turn | offset |
//! |---|---|---|---|
//! | 1 | 1 | none | 0 |
//! | 2 | 1', 2 | Rz(pi/2) Rx(pi/2) | (0, a1, d1) |
//! | 3 | 3 | none | (a2, 0, d3) |
//! | 4 | 4 | Rx(pi/2) Rz(pi) | (a3, -q4, 0) |

use shared::arm::Geometry;

use super::body::Second;
use super::{Joints, Vector, add, cross, dot, scale};

pub(super) const COLUMN: usize = 0;
pub(super) const BOOM: usize = 1;
pub(super) const FOREARM: usize = 2;
pub(super) const TELESCOPE: usize = 3;

/// Where the tip is and how the telescope is turned, in world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Position, m.
    pub position_m: Vector,
    /// Rotation matrix, rows first: telescope frame to world axes.
    pub rotation: [Vector; 3],
}

impl Pose {
    /// The z axis, about or along which a joint moves.
    fn axis(&self) -> Vector {
        [self.rotation[0][2], self.rotation[1][2], self.rotation[2][2]]
    }

    /// Velocity of the tip at `tip_m` where joint `j`, whose frame this is, moves at unit speed.
    fn push(&self, j: usize, tip_m: Vector) -> Vector {
        let arm_m = core::array::from_fn(|i| tip_m[i] - self.position_m[i]);
        if j == TELESCOPE { self.axis() } else { cross(self.axis(), arm_m) }
    }

    fn then<const J: usize>(&self, frame: &Frame<J>) -> Self {
        let columns =
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| frame.rotate(axis));
        Self {
            position_m: add(self.position_m, self.rotation.map(|row| dot(row, frame.origin_m))),
            rotation: self.rotation.map(|row| columns.map(|column| dot(row, column))),
        }
    }
}

/// Placement of link frame `J` in its parent's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame<const J: usize> {
    pub origin_m: Vector,
    sin: f64,
    cos: f64,
}

impl<const J: usize> Frame<J> {
    fn hinge(origin_m: Vector, angle_rad: f64) -> Self {
        let (sin, cos) = angle_rad.sin_cos();
        Self { origin_m, sin, cos }
    }

    /// A vector of this frame in the parent's axes.
    pub fn rotate(&self, [x, y, z]: Vector) -> Vector {
        match J {
            BOOM => [z, self.cos * x - self.sin * y, self.sin * x + self.cos * y],
            TELESCOPE => [-x, -z, -y],
            _ => [self.cos * x - self.sin * y, self.sin * x + self.cos * y, z],
        }
    }

    /// A vector of the parent's frame in this frame's axes.
    pub fn unrotate(&self, [x, y, z]: Vector) -> Vector {
        match J {
            BOOM => [self.cos * y + self.sin * z, self.cos * z - self.sin * y, x],
            TELESCOPE => [-x, -z, -y],
            _ => [self.cos * x + self.sin * y, self.cos * y - self.sin * x, z],
        }
    }

    /// Second moments of this frame in the parent's axes.
    pub fn rotate_second(&self, s: &Second) -> Second {
        if J == TELESCOPE {
            return Second { xx: s.xx, yy: s.zz, zz: s.yy, xy: s.xz, xz: s.xy, yz: s.yz };
        }
        let (sin, cos) = (self.sin, self.cos);
        let (along, across) = (cos * s.xx - sin * s.xy, cos * s.xy - sin * s.yy);
        let (xx, xy) = (cos * along - sin * across, sin * along + cos * across);
        let yy = s.xx + s.yy - xx;
        let (xz, yz) = (cos * s.xz - sin * s.yz, sin * s.xz + cos * s.yz);
        match J {
            BOOM => Second { xx: s.zz, yy: xx, zz: yy, xy: xz, xz: yz, yz: xy },
            _ => Second { xx, yy, zz: s.zz, xy, xz, yz },
        }
    }
}

/// The frames that the dynamics need: axis 1 is vertical, so nothing there depends on q1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frames {
    pub boom: Frame<BOOM>,
    pub forearm: Frame<FOREARM>,
    pub telescope: Frame<TELESCOPE>,
}

impl Frames {
    pub fn new(g: &Geometry, q: &Joints) -> Self {
        Self {
            boom: Frame::hinge([0.0, g.a1_m, g.d1_m], q[BOOM]),
            forearm: Frame::hinge([g.a2_m, 0.0, g.d3_m], q[FOREARM]),
            telescope: Frame { origin_m: [g.a3_m, -q[TELESCOPE], 0.0], sin: 0.0, cos: 1.0 },
        }
    }

    /// World poses of the four link frames.
    fn poses(&self, q: &Joints) -> [Pose; 4] {
        let world =
            Pose { position_m: [0.0; 3], rotation: [[1., 0., 0.], [0., 1., 0.], [0., 0., 1.]] };
        let column = world.then(&Frame::<COLUMN>::hinge([0.0; 3], q[COLUMN]));
        let boom = column.then(&self.boom);
        let forearm = boom.then(&self.forearm);
        [column, boom, forearm, forearm.then(&self.telescope)]
    }
}

/// Pose of the tip, the origin of the telescope's frame.
pub(super) fn forward(g: &Geometry, q: &Joints) -> Pose {
    Frames::new(g, q).poses(q)[TELESCOPE]
}

/// Position and velocity of the tip, world axes, m and m/s.
pub(super) fn tip(g: &Geometry, q: &Joints, qd: &Joints) -> (Vector, Vector) {
    let poses = Frames::new(g, q).poses(q);
    let tip_m = poses[TELESCOPE].position_m;
    let velocity_m_s = poses
        .iter()
        .enumerate()
        .fold([0.0; 3], |sum, (j, pose)| add(sum, scale(qd[j], pose.push(j, tip_m))));
    (tip_m, velocity_m_s)
}

/// Geometric Jacobian at the tip in world axes: rows linear x, y, z, then angular x, y, z.
pub(super) fn jacobian(g: &Geometry, q: &Joints) -> [Joints; 6] {
    let poses = Frames::new(g, q).poses(q);
    let tip_m = poses[TELESCOPE].position_m;
    let mut rows = [[0.0; 4]; 6];
    for (j, pose) in poses.iter().enumerate() {
        let linear = pose.push(j, tip_m);
        let angular = if j == TELESCOPE { [0.0; 3] } else { pose.axis() };
        for i in 0..3 {
            rows[i][j] = linear[i];
            rows[i + 3][j] = angular[i];
        }
    }
    rows
}
