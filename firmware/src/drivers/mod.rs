//! Drivers of the devices on the bus, generic over embedded-hal.

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
}
