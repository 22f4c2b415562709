//! Drivers of the devices on the bus, generic over `embedded-hal` and advanced once a tick.

pub mod dac81404;

/// How far a device's configuration has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// More steps are needed.
    Busy,
    /// Configured, and read back as configured.
    Ready,
    /// The bus failed or the device did not answer as expected; it needs a reset and a new driver.
    Failed,
}
