//! The operator link between a console and the board's station: what is taken, what is refused and why.

mod rig;
mod sessions;
mod silence;
mod station;
