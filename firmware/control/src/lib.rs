#![no_std]
//! What the controller computes, whatever it is wired to: the estimator, paths, the closed-form dynamics, the laws,
//! the supervisor and its monitors, the planner. The same source on the host and on a Cortex-M4F.
//!
//! Joint 4 is prismatic: wherever a vector over the joints is in rad, rad/s and N m, its last component is in
//! m, m/s and N.
//!
//! Outside the tick size counts and not speed, so this package is optimised for size; what a tick executes is
//! `inline(always)` and takes on the optimisation of whoever calls it.

pub mod config;
pub mod controller;
pub mod dynamics;
pub mod estimator;
pub mod evidence;
pub mod kinematics;
pub mod law;
pub mod ldlt;
pub mod link;
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
