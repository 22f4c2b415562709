//! Messages between the emulated board and the harness (processor in the loop).
//!
//! The harness opens each tick with a release; the board answers with pin changes and transfers as they
//! happen and closes the tick with its record. Only a transfer waits for an answer: a byte that is 0 unless the
//! bus failed, then as many bytes as it sent. Everything is little-endian.

use bytemuck::{Pod, Zeroable};

use crate::arm::JOINTS;
use crate::link::WIRE_BYTES;

/// FIFO that the harness writes, in the emulator's working directory.
pub const TO_BOARD: &str = "to-board";
/// FIFO that the board writes, in the emulator's working directory.
pub const TO_HARNESS: &str = "to-harness";

/// Output pin: tag, pin number, level.
pub const TAG_PIN: u8 = 1;
/// Transfer: tag, device number, length, bytes to the device.
pub const TAG_TRANSFER: u8 = 2;
/// End of a tick: tag, encoded [`crate::telemetry::Record`].
pub const TAG_RECORD: u8 = 3;
/// Sent once before the first tick: tag, length as `u16`, coefficients.
pub const TAG_COEFFICIENTS: u8 = 4;
/// Instead of coefficients: the configuration was refused.
pub const TAG_REFUSED: u8 = 5;

/// Answer to [`QUIT`], the board's last message: tag, high-water mark of its stack as `u16` bytes, then its
/// [`crate::evidence::Image`].
pub const TAG_STACK: u8 = 6;
/// At any time, the board's last message before it resets itself and waits for its configuration: it took a hard
/// fault; tag, fault status register (Armv7-M ARM B3.2.15, CFSR) as `u32`.
pub const TAG_FAULT: u8 = 7;

/// What the board says on the operator link: tag, length, bytes.
pub const TAG_LINK: u8 = 8;

/// Longest transfer, bytes.
pub const TRANSFER_MAX: usize = 32;

/// Device numbers of the converters; encoders are 0 to 3.
pub const DEVICE_ADC: u8 = JOINTS as u8;
/// See [`DEVICE_ADC`].
pub const DEVICE_DAC: u8 = JOINTS as u8 + 1;

/// Output pin numbers; joint pins count up from these.
pub const PIN_LDAC: u8 = 0;
/// Drive enable of joint 1.
pub const PIN_DRIVE_ENABLE: u8 = 1;
/// Safe torque off.
pub const PIN_STO: u8 = 5;
/// Brake release of joint 1.
pub const PIN_BRAKE_RELEASE: u8 = 6;
/// DAC reset.
pub const PIN_DAC_RESET: u8 = 10;
/// ADC reset.
pub const PIN_ADC_RESET: u8 = 11;
/// Watchdog feed.
pub const PIN_WATCHDOG: u8 = 12;

/// All that a hard fault has to say of the pins: STO, drive enables and brake releases are low.
pub const ALL_OFF: [u8; 3 * (1 + 2 * JOINTS)] = {
    let mut messages = [0; 3 * (1 + 2 * JOINTS)];
    let mut i = 0;
    while i < 1 + 2 * JOINTS {
        // STO stands between drive enables and brake releases, and goes first.
        let pin =
            if i == 0 { PIN_STO } else { PIN_DRIVE_ENABLE + i as u8 - 1 + (i > JOINTS) as u8 };
        messages[3 * i] = TAG_PIN;
        messages[3 * i + 1] = pin;
        i += 1;
    }
    messages
};

/// Bytes of the operator link that a release can carry: a heartbeat and a command.
pub const LINK_BYTES: usize = (2 * WIRE_BYTES).next_multiple_of(4);

/// [`Release::request`]: run a tick.
pub const RUN: u8 = 0;
/// Instead: answer with [`TAG_STACK`] and end the emulation.
pub const QUIT: u8 = 1;
/// Instead: pass through the function `halt`, where a debugger can be waiting, and then wait for the next release.
pub const HALT: u8 = 2;

/// Pokes that a release can carry.
pub const POKES: usize = 2;

/// A word of the controller's memory that a fault changes before the tick; the default changes nothing.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Poke {
    /// First byte of the word in the memory image.
    pub offset: u32,
    /// Bits that become 0 first.
    pub clear: u32,
    /// Bits that flip then.
    pub flip: u32,
}

impl Poke {
    /// Flips `bits`.
    pub fn flip(offset: usize, bits: u32) -> Self {
        Self { offset: offset as u32, clear: 0, flip: bits }
    }

    /// Puts `value` in the word's place.
    pub fn set(offset: usize, value: u32) -> Self {
        Self { offset: offset as u32, clear: u32::MAX, flip: value }
    }

    /// Changes the word in `image`, if it lies inside.
    pub fn apply(&self, image: &mut [u32]) {
        if let Some(word) = image.get_mut((self.offset / 4) as usize) {
            *word = (*word & !self.clear) ^ self.flip;
        }
    }
}

/// What opens a tick: everything that a tick is told. Goes over the wire as it lies in memory.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Release {
    /// [`RUN`], [`QUIT`] or [`HALT`].
    pub request: u8,
    /// Levels of the input pins: brake feedbacks in bits 0 to 3, emergency stop contacts in 4 and 5.
    pub levels: u8,
    /// Bytes of `link` that are in use.
    pub link_length: u16,
    /// Cycle counter at the tick's start.
    pub cycles: u32,
    /// Cycles that the tick before took.
    pub spent: u32,
    /// Conversions of the torque converter so far.
    pub conversions: u32,
    /// What a fault does to the controller's memory before the tick.
    pub pokes: [Poke; POKES],
    /// What came on the operator link since the last tick.
    pub link: [u8; LINK_BYTES],
}

impl Release {
    /// Nothing happened.
    pub const NONE: Self = bytemuck::zeroed();

    /// No tick, but something else of the board.
    pub fn instead(request: u8) -> Self {
        Self { request, ..Self::NONE }
    }

    /// Puts bytes on the operator link; what there is no room for is lost.
    pub fn with_link(mut self, bytes: &[u8]) -> Self {
        for (slot, byte) in self.link.iter_mut().zip(bytes) {
            *slot = *byte;
        }
        self.link_length = bytes.len().min(LINK_BYTES) as u16;
        self
    }

    /// What came on the operator link.
    pub fn link(&self) -> &[u8] {
        self.link.get(..usize::from(self.link_length)).unwrap_or(&self.link)
    }
}

impl Default for Release {
    fn default() -> Self {
        Self::NONE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_release_carries_as_much_of_the_link_as_there_is_room_for() {
        assert_eq!(Release::default().with_link(&[1, 2, 3]).link(), [1, 2, 3]);
        let long = [7; LINK_BYTES + 1];
        assert_eq!(Release::default().with_link(&long).link(), [7; LINK_BYTES]);
        let garbled = Release { link_length: u16::MAX, ..Release::NONE };
        assert_eq!(garbled.link(), [0; LINK_BYTES]);
    }

    #[test]
    fn pokes_flip_or_set_a_word_and_stay_inside_the_image() {
        let mut image = [u32::MAX; 3];
        Poke::flip(4, 0x8000_0001).apply(&mut image);
        assert_eq!(image, [u32::MAX, 0x7FFF_FFFE, u32::MAX]);
        Poke::set(0, 0x0403_0201).apply(&mut image);
        assert_eq!(image[0], 0x0403_0201);
        let before = image;
        Poke::default().apply(&mut image);
        Poke::set(12, 0).apply(&mut image);
        Poke::set(usize::from(u16::MAX), 0).apply(&mut image);
        assert_eq!(image, before);
    }
}
