//! Messages between the emulated board and the harness (processor in the loop).
//!
//! The harness opens each tick with a release; the board answers with pin changes and transfers as they
//! happen and closes the tick with its record. Only a transfer waits for an answer: a byte that is 0 unless the
//! bus failed, then as many bytes as it sent. Everything is little-endian.

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

/// Size of a release.
pub const RELEASE_BYTES: usize = 4 + 4 * 3 + POKES * POKE_BYTES + LINK_BYTES;

/// Bytes of the operator link that a release can carry: a heartbeat and a command.
pub const LINK_BYTES: usize = 2 * WIRE_BYTES;

/// Instead of a release: the board answers with [`TAG_STACK`] and ends the emulation.
pub const QUIT: [u8; RELEASE_BYTES] = [0xFF; RELEASE_BYTES];

/// Pokes that a release can carry.
pub const POKES: usize = 2;

const POKE_BYTES: usize = 8;

/// What a poke does to its word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Change {
    /// Flips the bits that the value has set.
    #[default]
    Xor = 0,
    /// Puts the value in the word's place.
    Set = 1,
}

/// A word of the controller's memory that a fault changes before the tick; the default changes nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Poke {
    /// First byte of the word in the memory image.
    pub offset: u16,
    /// What is done to it.
    pub change: Change,
    /// Bits to flip, or the new word.
    pub value: u32,
}

impl Poke {
    /// Changes nothing.
    pub const NONE: Self = Self { offset: 0, change: Change::Xor, value: 0 };

    /// Changes the word in `image`, if it lies inside.
    pub fn apply(&self, image: &mut [u8]) {
        let at = usize::from(self.offset);
        let Some(word) = image.get_mut(at..at + 4) else { return };
        for (byte, value) in word.iter_mut().zip(self.value.to_le_bytes()) {
            *byte = match self.change {
                Change::Xor => *byte ^ value,
                Change::Set => value,
            };
        }
    }

    fn to_bytes(self) -> [u8; POKE_BYTES] {
        let ([a, b], [c, d, e, f]) = (self.offset.to_le_bytes(), self.value.to_le_bytes());
        [a, b, self.change as u8, 0, c, d, e, f]
    }

    fn from_bytes([a, b, change, _, c, d, e, f]: [u8; POKE_BYTES]) -> Self {
        Self {
            offset: u16::from_le_bytes([a, b]),
            change: if change == Change::Set as u8 { Change::Set } else { Change::Xor },
            value: u32::from_le_bytes([c, d, e, f]),
        }
    }
}

/// What opens a tick: everything that a tick is told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Release {
    /// Levels of the input pins: brake feedbacks in bits 0 to 3, emergency stop contacts in 4 and 5.
    pub levels: u8,
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
    /// As many bytes of it.
    pub link_length: u8,
}

impl Release {
    /// All zero: nothing happened.
    pub const NONE: Self = Self {
        levels: 0,
        cycles: 0,
        spent: 0,
        conversions: 0,
        pokes: [Poke::NONE; POKES],
        link: [0; LINK_BYTES],
        link_length: 0,
    };

    /// Puts bytes on the operator link; what there is no room for is lost.
    pub fn with_link(mut self, bytes: &[u8]) -> Self {
        for (slot, byte) in self.link.iter_mut().zip(bytes) {
            *slot = *byte;
        }
        self.link_length = bytes.len().min(LINK_BYTES) as u8;
        self
    }

    /// What came on the operator link.
    pub fn link(&self) -> &[u8] {
        self.link.get(..usize::from(self.link_length)).unwrap_or(&self.link)
    }

    /// Encodes: levels, the link's length, 0, 0, the three counts, the pokes, the link's bytes.
    pub fn to_bytes(&self) -> [u8; RELEASE_BYTES] {
        let counts = [self.cycles, self.spent, self.conversions].map(u32::to_le_bytes);
        let pokes = self.pokes.map(Poke::to_bytes);
        let head = [self.levels, self.link_length, 0, 0];
        let head = head.into_iter().chain(counts.into_iter().flatten());
        let all = head.chain(pokes.into_iter().flatten()).chain(self.link);
        let mut bytes = [0; RELEASE_BYTES];
        for (slot, byte) in bytes.iter_mut().zip(all) {
            *slot = byte;
        }
        bytes
    }

    /// Decodes.
    pub fn from_bytes(bytes: &[u8; RELEASE_BYTES]) -> Self {
        let [levels, link_length, _, _, a @ ..] = bytes;
        let [c0, c1, c2, c3, s0, s1, s2, s3, n0, n1, n2, n3, a @ ..] = a;
        let [p0, p1, p2, p3, p4, p5, p6, p7, a @ ..] = a;
        let [q0, q1, q2, q3, q4, q5, q6, q7, link @ ..] = a;
        Self {
            levels: *levels,
            cycles: u32::from_le_bytes([*c0, *c1, *c2, *c3]),
            spent: u32::from_le_bytes([*s0, *s1, *s2, *s3]),
            conversions: u32::from_le_bytes([*n0, *n1, *n2, *n3]),
            pokes: [
                Poke::from_bytes([*p0, *p1, *p2, *p3, *p4, *p5, *p6, *p7]),
                Poke::from_bytes([*q0, *q1, *q2, *q3, *q4, *q5, *q6, *q7]),
            ],
            link: *link,
            link_length: *link_length,
        }
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
    fn a_release_survives_the_wire() {
        let release = Release {
            levels: 0x2A,
            cycles: 0x0102_0304,
            spent: 0x0506_0708,
            conversions: 0x090A_0B0C,
            pokes: [
                Poke { offset: 0x1234, change: Change::Set, value: 0x7FC0_0000 },
                Poke { offset: 8, change: Change::Xor, value: 1 << 31 },
            ],
            ..Release::default()
        }
        .with_link(&[1, 2, 3]);
        assert_eq!(release.link(), [1, 2, 3]);
        assert_eq!(Release::from_bytes(&release.to_bytes()), release);
        let default = Release::default();
        assert_eq!(Release::from_bytes(&default.to_bytes()), default);
    }

    #[test]
    fn pokes_flip_or_set_a_word_and_stay_inside_the_image() {
        let mut image = [0xFF; 10];
        Poke { offset: 4, change: Change::Xor, value: 0x8000_0001 }.apply(&mut image);
        assert_eq!(image, [0xFF, 0xFF, 0xFF, 0xFF, 0xFE, 0xFF, 0xFF, 0x7F, 0xFF, 0xFF]);
        Poke { offset: 0, change: Change::Set, value: 0x0403_0201 }.apply(&mut image);
        assert_eq!(image[..4], [1, 2, 3, 4]);
        let before = image;
        Poke::default().apply(&mut image);
        Poke { offset: 7, change: Change::Set, value: 0 }.apply(&mut image);
        Poke { offset: u16::MAX, change: Change::Set, value: 0 }.apply(&mut image);
        assert_eq!(image, before);
    }
}
