//! Simulated devices at register level.

pub mod dac81404;
