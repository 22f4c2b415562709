//! Simulated devices at register level.

pub mod encoder;
