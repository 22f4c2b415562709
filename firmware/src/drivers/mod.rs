//! Drivers of the devices on the bus, over `embedded-hal` traits.

pub mod ads131m04;

/// Why a device gave no usable sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleError {
    /// The bus itself reported an error.
    Bus,
    /// The frame is not shaped as it must be.
    Framing,
    /// The checksum does not match.
    Crc,
    /// The device answers, and says that it must not be trusted.
    Device,
    /// The device has nothing newer than what was read before.
    Stale,
}
