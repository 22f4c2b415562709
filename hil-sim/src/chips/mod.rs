//! Simulated devices: converters and encoders at register level, and what guards torque in hardware.

pub mod ads131m04;
pub mod dac81404;
pub mod encoder;
pub mod stop_relay;
pub mod watchdog;
