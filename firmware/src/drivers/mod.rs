//! Drivers of the devices on the bus, generic over `embedded-hal` and advanced once a tick.

pub mod ads131m04;
pub mod dac81404;
pub mod encoder;

/// Why a device's sample cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleError {
    /// The bus itself reported an error.
    Bus,
    /// A bit with a fixed level has the other one.
    Framing,
    /// The check sum does not fit the contents.
    Crc,
    /// The device itself marks its sample as wrong.
    Device,
    /// The device was reset and has lost its configuration.
    Reset,
    /// The device's configuration is not what was written.
    Configuration,
    /// Nothing new since the last sample.
    Stale,
}

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
