//! What crosses bus and pins, kept for comparison.

use std::fmt;

use super::{Device, Output};

/// One thing that crossed bus or pins.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Event {
    /// A chip-select frame.
    Transfer {
        /// Chip selected.
        device: Device,
        /// Bytes from the controller.
        mosi: Vec<u8>,
        /// Bytes to the controller.
        miso: Vec<u8>,
    },
    /// An output pin was driven.
    Pin {
        /// Which.
        pin: Output,
        /// Its level.
        high: bool,
    },
}

impl Event {
    /// Device or pin.
    pub fn place(&self) -> String {
        match self {
            Self::Transfer { device, .. } => format!("{device:?}"),
            Self::Pin { pin, .. } => format!("pin {pin:?}"),
        }
    }
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Transfer { device, mosi, miso } => {
                write!(f, "{device:?} sent {mosi:02x?}, received {miso:02x?}")
            }
            Self::Pin { pin, high } => write!(f, "{pin:?} {}", if *high { "high" } else { "low" }),
        }
    }
}
