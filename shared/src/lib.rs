#![no_std]
//! What both ends of the bus must agree on: the arm's parameters, the wire formats of its devices, the
//! telemetry record, commands and fault codes. No algorithm of either side lives here.

pub mod arm;
pub mod command;
pub mod crc32;
pub mod evidence;
pub mod fault;
pub mod pil;
pub mod telemetry;
pub mod wire;
