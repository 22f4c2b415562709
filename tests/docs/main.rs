//! The documents say what the code does.

mod faults;
mod markdown;
mod scenarios;
mod supervisor;
mod thresholds;
mod values;
