//! The documents say what the code does.

mod faults;
mod link;
mod markdown;
mod scenarios;
mod supervisor;
mod thresholds;
mod values;
