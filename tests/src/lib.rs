//! Product tests: shared loaders of reference data, and a controller on its bench.

pub mod closed_loop;
pub mod mdh;
pub mod rig;
pub mod vectors;
