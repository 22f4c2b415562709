//! The arm in `f64`: recursive Newton-Euler, composite bodies, friction, disturbance and brakes.
//!
//! SI units; joint 4 is prismatic, so its position is in m and its "torque" a force in N.

mod body;
mod brake;
mod chain;
mod disturbance;
mod model;
mod simulation;
mod solve;

pub use brake::{BRAKE_CLOSE_S, BRAKE_OPEN_S, BrakeFault};
pub use chain::Pose;
pub use disturbance::{Disturbance, FRICTION, RATIOS, Ratios};
pub use model::Model;
pub use simulation::Plant;

use shared::arm::JOINTS;

/// One value a joint.
pub type Joints = [f64; JOINTS];

type Vector = [f64; 3];
type Matrix = [Joints; JOINTS];

fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn scale(k: f64, v: Vector) -> Vector {
    v.map(|x| k * x)
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `y + k x` joint by joint.
fn ahead(y: &Joints, k: f64, x: &Joints) -> Joints {
    core::array::from_fn(|j| y[j] + k * x[j])
}
