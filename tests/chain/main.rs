//! The whole chain through bytes: firmware, drivers, simulated chips and plant.

mod damage;
mod integration;
mod modes;
mod repeatability;
mod stops;
mod tracking;
mod watch;
