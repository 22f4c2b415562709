//! The record that every tick leaves behind, as explicit little-endian bytes without padding.

use crate::arm::JOINTS;

/// Size of an encoded record.
pub const RECORD_BYTES: usize = 4 * RECORD_WORDS;

const RECORD_WORDS: usize = 32;

/// Everything a tick knew and decided. Joint 4 is in m, m/s and N.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Record {
    /// Ticks since reset, modulo 2³².
    pub tick: u32,
    /// [`crate::fault::Mode`] number.
    pub mode: u8,
    /// [`crate::fault::Refusal`] number of the last command.
    pub refusal: u8,
    /// [`crate::fault::Fault`] number that is latched.
    pub fault: u16,
    /// One bit a joint whose torque command sits at its limit.
    pub saturated: u8,
    /// One bit a joint whose disturbance estimate sits at its bound.
    pub adaptation_bound: u8,
    /// One bit a sample that this tick could not use: encoders 0 to 3, torque converter 4, DAC 5.
    pub rejected: u8,
    /// Records that the full queue dropped so far, saturating.
    pub dropped: u8,
    /// Ticks since the trajectory started.
    pub phase: u32,
    /// Last accepted encoder codes.
    pub code: [u32; JOINTS],
    /// Position error e1 = q - q_d, rad or m.
    pub e1: [f32; JOINTS],
    /// Velocity estimate, rad/s or m/s.
    pub qd: [f32; JOINTS],
    /// Velocity error, rad/s or m/s.
    pub e1_dot: [f32; JOINTS],
    /// Torque command as DAC codes, offset binary.
    pub dac: [u16; JOINTS],
    /// Last accepted ADC codes, sign-extended.
    pub adc: [i32; JOINTS],
    /// Disturbance estimate, N m or N.
    pub d_hat: [f32; JOINTS],
    /// One bit a [`crate::fault::Limit`] that holds the arm back.
    pub limits: u16,
    /// One bit a joint that the fault names.
    pub joints: u8,
    /// Drive enables in bits 0 to 3, brake releases in bits 4 to 7, as driven by this tick.
    pub powered: u8,
    /// Rate at which the path is followed, 1 is [`PATH_RATE_ONE`].
    pub path_rate: u16,
    /// Ticks so far that came late, early or not at all, modulo 256.
    pub irregular: u8,
    /// Highest level of all devices' loss buckets.
    pub bucket: u8,
}

/// [`Record::path_rate`] at full speed.
pub const PATH_RATE_ONE: u16 = 1 << 15;

impl Record {
    /// The record as little-endian words in field order, small fields packed lowest first.
    pub fn to_words(&self) -> [u32; RECORD_WORDS] {
        let mut words = [0; RECORD_WORDS];
        words[0] = self.tick;
        words[1] =
            u32::from(self.mode) | u32::from(self.refusal) << 8 | u32::from(self.fault) << 16;
        words[2] = u32::from_le_bytes([
            self.saturated,
            self.adaptation_bound,
            self.rejected,
            self.dropped,
        ]);
        words[3] = self.phase;
        for j in 0..JOINTS {
            words[4 + j] = self.code[j];
            words[8 + j] = self.e1[j].to_bits();
            words[12 + j] = self.qd[j].to_bits();
            words[16 + j] = self.e1_dot[j].to_bits();
            words[20 + j] = self.adc[j] as u32;
            words[24 + j] = self.d_hat[j].to_bits();
        }
        words[28] = u32::from(self.dac[0]) | u32::from(self.dac[1]) << 16;
        words[29] = u32::from(self.dac[2]) | u32::from(self.dac[3]) << 16;
        words[30] =
            u32::from(self.limits) | u32::from(self.joints) << 16 | u32::from(self.powered) << 24;
        words[31] = u32::from(self.path_rate)
            | u32::from(self.irregular) << 16
            | u32::from(self.bucket) << 24;
        words
    }

    /// Encodes the record.
    pub fn to_bytes(&self) -> [u8; RECORD_BYTES] {
        let mut bytes = [0; RECORD_BYTES];
        for (slot, word) in bytes.chunks_exact_mut(4).zip(self.to_words()) {
            slot.copy_from_slice(&word.to_le_bytes());
        }
        bytes
    }

    /// Decodes a record; every byte pattern is one.
    pub fn from_bytes(bytes: &[u8; RECORD_BYTES]) -> Self {
        let word = |i: usize| {
            u32::from_le_bytes([bytes[4 * i], bytes[4 * i + 1], bytes[4 * i + 2], bytes[4 * i + 3]])
        };
        let words = |first: usize| core::array::from_fn(|j| word(first + j));
        let floats = |first: usize| core::array::from_fn(|j| f32::from_bits(word(first + j)));
        let [saturated, adaptation_bound, rejected, dropped] = word(2).to_le_bytes();
        Self {
            tick: word(0),
            mode: word(1) as u8,
            refusal: (word(1) >> 8) as u8,
            fault: (word(1) >> 16) as u16,
            saturated,
            adaptation_bound,
            rejected,
            dropped,
            phase: word(3),
            code: words(4),
            e1: floats(8),
            qd: floats(12),
            e1_dot: floats(16),
            adc: core::array::from_fn(|j| word(20 + j) as i32),
            d_hat: floats(24),
            dac: core::array::from_fn(|j| (word(28 + j / 2) >> (16 * (j % 2))) as u16),
            limits: word(30) as u16,
            joints: (word(30) >> 16) as u8,
            powered: (word(30) >> 24) as u8,
            path_rate: word(31) as u16,
            irregular: (word(31) >> 16) as u8,
            bucket: (word(31) >> 24) as u8,
        }
    }
}
