//! Product tests: shared loaders of reference data.

pub mod mdh;
pub mod vectors;
