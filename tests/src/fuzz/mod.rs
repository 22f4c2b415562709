//! Bodies of the fuzz targets, which the property tests share: each takes any bytes and panics where the product
//! would be wrong.

mod bus;
pub mod damage;
mod link;
pub mod running;
mod scenario;
pub mod storm;

pub use bus::{ads131m04, biss_c, dac81404};
pub use link::link;
pub use scenario::scenario;
