//! Wire formats of the three kinds of device on the bus, with their checks.

pub mod ads131m04;
pub mod biss_c;
pub mod dac81404;
