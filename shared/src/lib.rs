#![no_std]
//! What both ends of the bus must agree on: the arm's parameters, the wire formats of its devices, the
//! telemetry record, commands, the operator link's frames and fault codes. No algorithm of either side lives here.

#[macro_use]
pub mod fault;

pub mod arm;
pub mod command;
pub mod crc32;
pub mod evidence;
pub mod link;
pub mod pil;
pub mod telemetry;
pub mod wire;
