#![no_std]
//! Controller of a four-joint hydraulic lifting arm: fixed-step, heap-free, the same source on the host
//! and on a Cortex-M4F.
//!
//! [`executive::Executive::tick`] is the only entry. Joint 4 is prismatic: wherever a vector over the
//! joints is in rad, rad/s and N m, its last component is in m, m/s and N.

pub mod config;
pub mod drivers;
pub mod dynamics;
pub mod estimator;
pub mod evidence;
pub mod executive;
pub mod io;
pub mod kinematics;
pub mod law;
pub mod ldlt;
pub mod math;
pub mod memory;
pub mod monitor;
pub mod path;
pub mod planner;
pub mod supervisor;

/// One number a joint.
pub type JointVector = nalgebra::Vector4<f32>;

/// A matrix over the joints.
pub type JointMatrix = nalgebra::Matrix4<f32>;
