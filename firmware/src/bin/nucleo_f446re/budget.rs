//! Which tick rates this board offers: what a tick spends on the wires and the core may take half of it.

use shared::wire::ads131m04;

use crate::bus::PORT_DIVISOR;
use crate::clocks::{APB1_HZ, APB2_HZ};
use crate::encoders::READ_NS;

/// Gap between two bytes of a polled port, ns: 40 clocks of reading status and data. An estimate.
const GAP_NS: u32 = 240;
/// Chip select down and up around a frame, ns. An estimate.
const SELECT_NS: u32 = 400;
/// A frame of the DAC with its CRC.
const DAC_FRAME_BYTES: usize = 4;
/// Computation, ns: 10 000 core clocks. The tick was measured at up to 6 086 modelled cycles on the
/// emulated board; the rest is for this board's own drivers and wait states of the flash. Telemetry carries what it took.
const COMPUTE_NS: u32 = 60_000;

/// Duration of one frame, ns.
const fn frame_ns(bytes: usize, clock_hz: u32) -> u32 {
    bytes as u32 * (8_000_000 / (clock_hz / 1_000) + GAP_NS) + SELECT_NS
}

/// Wire and computation of one tick, ns: encoders, two frames of the torque converter, five of the DAC.
const TICK_NS: u32 = READ_NS
    + 2 * frame_ns(ads131m04::FRAME_BYTES, APB2_HZ / PORT_DIVISOR)
    + 5 * frame_ns(DAC_FRAME_BYTES, APB1_HZ / PORT_DIVISOR)
    + COMPUTE_NS;

/// Ticks a second.
pub const TICK_HZ: u32 = 2_000;

const _: () = assert!(
    TICK_NS <= 1_000_000_000 / TICK_HZ / 2,
    "at this tick rate, wire and computation take more than half a tick"
);
