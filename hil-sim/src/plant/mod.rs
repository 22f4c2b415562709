//! The arm in `f64` by recursive Newton-Euler and Jacobians.
