//! The whole chain through bytes: firmware, drivers, simulated chips and plant.

mod integration;
mod modes;
mod repeatability;
mod stops;
mod tracking;
mod watch;
