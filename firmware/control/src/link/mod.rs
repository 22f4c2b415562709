//! The board's end of the operator link, outside the tick: codes and sessions, and the station that turns frames
//! into orders.

mod code;
mod session;
mod station;

pub use session::Access;
pub use station::{Archive, Served, Station};
