#![no_std]
//! Controller of a four-joint hydraulic lifting arm: fixed-step, heap-free, the same source on the host
//! and on a Cortex-M4F.
//!
//! [`executive::Executive::tick`] is the only entry. Joint 4 is prismatic: wherever a vector over the
//! joints is in rad, rad/s and N m, its last component is in m, m/s and N.

pub mod drivers;
pub mod executive;
pub mod io;

pub use control::{
    JointMatrix, JointVector, config, controller, dynamics, estimator, evidence, kinematics, law,
    ldlt, link, math, memory, monitor, path, planner, supervisor,
};
