//! Simulated devices at register level.

pub mod ads131m04;
pub mod dac81404;
pub mod encoder;
