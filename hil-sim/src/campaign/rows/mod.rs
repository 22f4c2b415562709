//! The fault table: 27 rows, each with the ways in which its fault is injected and what must come of them.

mod actuator;
mod bus;
mod command;
mod device;
mod load;
mod memory;
mod numeric;
mod pairs;
mod sensor;
mod timing;

pub use pairs::pairs;

use super::pose::Pose;
use super::row::{Row, Variant};

/// Ways in a pose, or why it makes no sense there.
type Ways = Result<Vec<Variant>, &'static str>;

/// Every row, in its order.
pub const ROWS: [Row; 27] = [
    Row { number: 1, title: "flipped bits", variants: bus::flips },
    Row { number: 2, title: "lost frames", variants: bus::losses },
    Row { number: 3, title: "repeated frames", variants: bus::repeats },
    Row { number: 4, title: "swapped encoders", variants: bus::swaps },
    Row { number: 5, title: "dead line", variants: bus::dead },
    Row { number: 6, title: "stuck encoder", variants: sensor::stuck },
    Row { number: 7, title: "jumps", variants: sensor::jumps },
    Row { number: 8, title: "drifting torque channel", variants: sensor::drift },
    Row { number: 9, title: "device's own alarms", variants: sensor::alarms },
    Row { number: 10, title: "old samples", variants: sensor::old },
    Row { number: 11, title: "sensor missing at boot", variants: sensor::missing },
    Row { number: 12, title: "lost drive enable", variants: actuator::enable_lost },
    Row { number: 13, title: "wrong torque", variants: actuator::wrong_torque },
    Row { number: 14, title: "brake does not release", variants: actuator::jammed },
    Row { number: 15, title: "brake slips", variants: actuator::slips },
    Row { number: 16, title: "unknown load", variants: load::load },
    Row { number: 17, title: "late ticks", variants: timing::late },
    Row { number: 18, title: "hung tick, early kick", variants: timing::watchdog },
    Row { number: 19, title: "counter, ticks and clock", variants: timing::clock },
    Row { number: 20, title: "estimates", variants: numeric::estimates },
    Row { number: 21, title: "extreme numbers", variants: numeric::extremes },
    Row { number: 22, title: "bad commands", variants: command::bad },
    Row { number: 23, title: "commands at the wrong time", variants: command::untimely },
    Row { number: 24, title: "flipped parameters", variants: memory::flips },
    Row { number: 25, title: "hard fault, stack overflow", variants: memory::crash },
    Row { number: 26, title: "emergency stop", variants: device::emergency_stop },
    Row { number: 27, title: "device resets", variants: device::resets },
];

/// Poses in which a row that concerns boot is run: the arm stands in its brakes whatever it was to do later.
fn parked(pose: &Pose, ways: Vec<Variant>) -> Ways {
    match pose.name.as_str() {
        "rest" | "reach" => Ok(ways),
        _ => Err("the arm stands in its brakes; speed has no meaning"),
    }
}
