//! Product tests: shared loaders of reference data.
