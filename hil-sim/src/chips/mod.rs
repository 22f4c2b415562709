//! Simulated devices at register level.

pub mod ads131m04;
