//! Messages between the emulated board and the harness (processor in the loop).
//!
//! The harness opens each tick with a release; the board answers with pin changes and transfers as they
//! happen and closes the tick with its record. Only a transfer waits for an answer, as many bytes as it
//! sent. Everything is little-endian.

use crate::arm::JOINTS;
use crate::command::{COMMAND_BYTES, Command};

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

/// Answer to [`QUIT`], the board's last message: tag, high-water mark of its stack as `u16` bytes.
pub const TAG_STACK: u8 = 6;
/// At any time, the board's last message: it took a hard fault; tag, fault status register (Armv7-M ARM B3.2.15,
/// CFSR) as `u32`.
pub const TAG_FAULT: u8 = 7;

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

/// Size of a release.
pub const RELEASE_BYTES: usize = 4 + 4 * 3 + COMMAND_BYTES;

/// Instead of a release: the board answers with [`TAG_STACK`] and ends the emulation.
pub const QUIT: [u8; RELEASE_BYTES] = [0xFF; RELEASE_BYTES];

/// What opens a tick: everything that a tick is told.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Release {
    /// Levels of the input pins: brake feedbacks in bits 0 to 3, emergency stop contacts in 4 and 5.
    pub levels: u8,
    /// An authentic frame of the operator came since the last tick.
    pub alive: bool,
    /// Cycle counter at the tick's start.
    pub cycles: u32,
    /// Cycles that the tick before took.
    pub spent: u32,
    /// Conversions of the torque converter so far.
    pub conversions: u32,
    /// Command that arrived since the last tick.
    pub command: Option<Command>,
}

impl Release {
    /// Encodes: levels, flags, 0, 0, the three counts, the command.
    pub fn to_bytes(&self) -> [u8; RELEASE_BYTES] {
        let flags = u8::from(self.command.is_some()) | u8::from(self.alive) << 1;
        let counts = [self.cycles, self.spent, self.conversions].map(u32::to_le_bytes);
        let command = self.command.map_or([0; COMMAND_BYTES], |command| command.to_bytes());
        let all = [self.levels, flags, 0, 0].into_iter().chain(counts.into_iter().flatten());
        let mut bytes = [0; RELEASE_BYTES];
        for (slot, byte) in bytes.iter_mut().zip(all.chain(command)) {
            *slot = byte;
        }
        bytes
    }

    /// Decodes; a command that is none is dropped.
    pub fn from_bytes(bytes: &[u8; RELEASE_BYTES]) -> Self {
        let [levels, flags, _, _, a @ ..] = bytes;
        let [c0, c1, c2, c3, s0, s1, s2, s3, n0, n1, n2, n3, command @ ..] = a;
        let command = if flags & 1 == 0 { None } else { Command::from_bytes(command) };
        Self {
            levels: *levels,
            alive: flags & 2 != 0,
            cycles: u32::from_le_bytes([*c0, *c1, *c2, *c3]),
            spent: u32::from_le_bytes([*s0, *s1, *s2, *s3]),
            conversions: u32::from_le_bytes([*n0, *n1, *n2, *n3]),
            command,
        }
    }
}
