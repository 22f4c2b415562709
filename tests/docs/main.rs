//! The documents say what the code does.

mod markdown;
mod supervisor;
mod thresholds;
mod values;
