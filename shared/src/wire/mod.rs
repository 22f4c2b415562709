//! Wire formats of the three kinds of device on the bus, with their checks.

pub mod ads131m04;
