//! Plant-in-the-loop harness: the arm in `f64`, its devices at register level, a mocked bus, scenarios,
//! metrics and reports. It knows the controller only by bytes on the bus, pins and telemetry.

pub mod bench;
pub mod campaign;
pub mod chips;
pub mod cli;
pub mod commands;
pub mod console;
pub mod faults;
pub mod metrics;
pub mod operator;
pub mod outcome;
pub mod path;
pub mod pil;
pub mod plant;
pub mod report;
pub mod run;
pub mod scenario;
pub mod session;
pub mod truth;
