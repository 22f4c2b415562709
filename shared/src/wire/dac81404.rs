//! TI DAC81404, a quad 16-bit bipolar DAC: registers and SPI frames.
//!
//! Sources: DAC81404 data sheet SLASEH2A, Tables 8-2, 8-3 and 8-7; the error-checking cycles are quoted from
//! the sister part's sheet, DAC81416 SLASEO0B, Tables 8-4 to 8-6, which has the same serial interface.
//! SPI mode 1: SDIN is taken on falling SCLK edges, SDO changes on rising ones.

use crc::{CRC_8_SMBUS, Crc};

/// CRC-8 x⁸ + x² + x + 1, start value 0, no final XOR (SLASEO0B Section 8.5.3).
///
/// The sheet calls it CRC-8-ATM (HEC); the HEC's final XOR is not applied.
static CRC: Crc<u8> = Crc::<u8>::new(&CRC_8_SMBUS);

/// Output channels, A to D.
pub const CHANNELS: usize = 4;

/// Code of 0 V in a bipolar range: codes are straight binary from the negative end
/// (SLASEO0B Equation 1).
pub const MID_SCALE: u16 = 0x8000;

/// Register addresses (SLASEH2A Table 8-7).
pub mod register {
    /// No operation.
    pub const NOP: u8 = 0x00;
    /// Device and version number, read only.
    pub const DEVICEID: u8 = 0x01;
    /// Alarms, read only; see [`super::status`].
    pub const STATUS: u8 = 0x02;
    /// Interface and device power; see [`super::spiconfig`].
    pub const SPICONFIG: u8 = 0x03;
    /// Internal reference; see [`super::GENCONFIG_REFERENCE_OFF`].
    pub const GENCONFIG: u8 = 0x04;
    /// One bit a channel that follows [`BRDCAST`].
    pub const BRDCONFIG: u8 = 0x05;
    /// One bit a channel that waits for LDAC.
    pub const SYNCCONFIG: u8 = 0x06;
    /// One bit a channel that is powered down; the upper 12 bits read as ones.
    pub const DACPWDWN: u8 = 0x09;
    /// Output range, four bits a channel, write only.
    pub const DACRANGE: u8 = 0x0A;
    /// Self-clearing commands; see [`super::trigger`].
    pub const TRIGGER: u8 = 0x0E;
    /// One code for all channels enabled in [`BRDCONFIG`], write only.
    pub const BRDCAST: u8 = 0x0F;
    /// Code of channel A, write only.
    pub const DACA: u8 = 0x10;
    /// Code of channel B, write only.
    pub const DACB: u8 = 0x11;
    /// Code of channel C, write only.
    pub const DACC: u8 = 0x12;
    /// Code of channel D, write only.
    pub const DACD: u8 = 0x13;
}

/// Bits of [`register::STATUS`] (SLASEH2A, STATUS register).
pub mod status {
    /// The die passed 140 °C: the outputs are powered down.
    pub const TEMP_ALM: u16 = 1 << 0;
    /// A frame failed its CRC; stays until [`super::trigger::ALM_RESET`].
    pub const CRC_ALM: u16 = 1 << 2;
}

/// Bits of [`register::SPICONFIG`] (SLASEH2A, SPICONFIG register).
pub mod spiconfig {
    /// Value after reset: thermal and CRC alarms at the FAULT pin, SDO on, device powered down.
    pub const RESET: u16 = 0x0AA4;
    /// The whole device is powered down.
    pub const DEV_PWDWN: u16 = 1 << 5;
    /// Frames have 32 bits and a CRC.
    pub const CRC_EN: u16 = 1 << 4;
    /// SDO is driven.
    pub const SDO_EN: u16 = 1 << 2;
    /// Bits that can be written.
    pub const WRITABLE: u16 = 0x0E36;
}

/// Bits of [`register::TRIGGER`] (SLASEH2A, TRIGGER register).
pub mod trigger {
    /// Sets every buffer and active register to mid-scale (bipolar range) or zero (unipolar).
    pub const SOFT_CLR: u16 = 1 << 9;
    /// Clears latched alarms.
    pub const ALM_RESET: u16 = 1 << 8;
    /// Does what a falling edge of LDAC does.
    pub const SOFT_LDAC: u16 = 1 << 4;
    /// Field that resets the device.
    pub const SOFT_RESET_MASK: u16 = 0xF;
    /// Code of that field that resets the device.
    pub const SOFT_RESET: u16 = 0b1010;
}

/// [`register::GENCONFIG`]: the internal reference is powered down; the value after reset.
pub const GENCONFIG_REFERENCE_OFF: u16 = 1 << 14;

/// [`register::SYNCCONFIG`], [`register::BRDCONFIG`]: all four channels.
pub const ALL_CHANNELS: u16 = 0xF;

/// [`register::DACRANGE`]: ±10 V (code 0110) on all four channels (SLASEH2A, DACRANGE register).
pub const RANGE_10_V: u16 = 0x6666;

const READ: u8 = 1 << 7;
const CRC_ERROR: u8 = 1 << 6;
const ADDRESS: u8 = 0x3F;

/// What the host sends: bit 31 R/W, bit 30 zero, 29..24 address, 23..8 data, 7..0 CRC (SLASEO0B Table 8-4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Read instead of write.
    pub read: bool,
    /// Register address, six bits.
    pub address: u8,
    /// Value to write; without meaning in a read.
    pub data: u16,
}

impl Frame {
    /// Writes `data` into a register.
    pub const fn write(address: u8, data: u16) -> Self {
        Self { read: false, address, data }
    }

    /// Asks for a register; the answer comes with the next frame.
    pub const fn read(address: u8) -> Self {
        Self { read: true, address, data: 0 }
    }

    /// The 24-bit frame that the device expects while CRC-EN is clear (SLASEH2A Table 8-2).
    pub const fn to_bytes_without_crc(&self) -> [u8; 3] {
        let [high, low] = self.data.to_be_bytes();
        [(self.read as u8) << 7 | self.address & ADDRESS, high, low]
    }

    /// The 32-bit frame that the device expects while CRC-EN is set.
    #[inline(always)]
    pub const fn to_bytes(&self) -> [u8; 4] {
        append_crc(self.to_bytes_without_crc())
    }

    /// Decodes a 24-bit frame.
    pub fn from_bytes_without_crc([head, high, low]: [u8; 3]) -> Self {
        Self {
            read: head & READ != 0,
            address: head & ADDRESS,
            data: u16::from_be_bytes([high, low]),
        }
    }

    /// Decodes a 32-bit frame; `None` where the CRC does not fit.
    pub fn from_bytes(bytes: [u8; 4]) -> Option<Self> {
        let [head, high, low, _] = bytes;
        crc_fits(bytes).then(|| Self::from_bytes_without_crc([head, high, low]))
    }

    /// Whether `answer`, shifted out during the next frame, says that the device took this write;
    /// see [`is_echo`].
    pub fn is_echoed_by(&self, answer: [u8; 4]) -> bool {
        is_echo(self.to_bytes(), answer)
    }
}

/// Whether `answer`, shifted out during the frame after `sent`, says that the device took that write.
///
/// Address and data must be echoed and the CRC-error bit be clear. R/W and CRC of the echo are not
/// looked at: every other bit is known beforehand, and a DAC81416 was seen to send a wrong CRC with the
/// echo of a write, while its CRC was right with a read (TI E2E thread 1021390).
pub const fn is_echo(sent: [u8; 4], answer: [u8; 4]) -> bool {
    // Native order: no byte has to move.
    (u32::from_ne_bytes(sent) ^ u32::from_ne_bytes(answer)) & ECHOED == 0
}

/// Bits of an answer that [`is_echo`] compares: CRC-ERROR (zero in what is sent), address and data.
const ECHOED: u32 = u32::from_ne_bytes([!READ, 0xFF, 0xFF, 0]);

/// What the device answers during the next frame (SLASEO0B Tables 8-5 and 8-6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Answer {
    /// The frame was a read.
    pub read: bool,
    /// The frame failed its CRC and was ignored.
    pub crc_error: bool,
    /// The frame's address.
    pub address: u8,
    /// Content of the register that was read, or the data that were written.
    pub data: u16,
}

impl Answer {
    /// Encodes the answer with its CRC; the first three bytes are the 24-bit answer.
    pub fn to_bytes(&self) -> [u8; 4] {
        let [high, low] = self.data.to_be_bytes();
        let head =
            u8::from(self.read) << 7 | u8::from(self.crc_error) << 6 | self.address & ADDRESS;
        append_crc([head, high, low])
    }

    /// Decodes an answer; `None` where the CRC does not fit.
    pub fn from_bytes(bytes: [u8; 4]) -> Option<Self> {
        let [head, high, low, _] = bytes;
        crc_fits(bytes).then_some(Self {
            read: head & READ != 0,
            crc_error: head & CRC_ERROR != 0,
            address: head & ADDRESS,
            data: u16::from_be_bytes([high, low]),
        })
    }

    /// The content of register `address`, if this answers a read of it without error.
    pub fn content_of(&self, address: u8) -> Option<u16> {
        (self.read && !self.crc_error && self.address == address).then_some(self.data)
    }
}

/// Put together as one word: bytes placed one by one cost more.
#[inline(always)]
const fn append_crc(payload: [u8; 3]) -> [u8; 4] {
    let [head, high, low] = payload;
    let crc = CRC.checksum(&payload);
    ((head as u32) << 24 | (high as u32) << 16 | (low as u32) << 8 | crc as u32).to_be_bytes()
}

fn crc_fits([head, high, low, crc]: [u8; 4]) -> bool {
    CRC.checksum(&[head, high, low]) == crc
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Polynomial division bit by bit over the whole word, most significant bit first.
    fn remainder_of(bytes: [u8; 4]) -> u8 {
        let mut word = u32::from_be_bytes(bytes);
        for shift in (8..32).rev() {
            if word & 1 << shift != 0 {
                word ^= 0x107 << (shift - 8);
            }
        }
        word as u8
    }

    fn flip(bytes: [u8; 4], mask: u32) -> [u8; 4] {
        (u32::from_be_bytes(bytes) ^ mask).to_be_bytes()
    }

    #[test]
    fn frames_of_the_vendors_forum() {
        // TI E2E thread 1021390 (DAC81416): SYNCCONFIG written with 0, then read.
        assert_eq!(Frame::write(register::SYNCCONFIG, 0).to_bytes(), [0x06, 0x00, 0x00, 0x7D]);
        assert_eq!(Frame::read(register::SYNCCONFIG).to_bytes(), [0x86, 0x00, 0x00, 0x76]);
        // TI E2E thread 1235803 (DAC81404): SPICONFIG 0A84h wakes the device.
        let woken = spiconfig::RESET & !spiconfig::DEV_PWDWN;
        let frame = Frame::write(register::SPICONFIG, woken);
        assert_eq!(frame.to_bytes_without_crc(), [0x03, 0x0A, 0x84]);
    }

    #[test]
    fn every_pattern_of_up_to_three_flips_is_detected() {
        let sent = Frame::write(register::DACC, 0xA5C3).to_bytes();
        let answered = Answer { data: 0x5A3C, address: register::DACD, ..Answer::default() };
        for a in 0..32 {
            for b in a..32 {
                for c in b..32 {
                    let mask: u32 = 1 << a | 1 << b | 1 << c;
                    assert_eq!(Frame::from_bytes(flip(sent, mask)), None, "{mask:08x}");
                    assert_eq!(Answer::from_bytes(flip(answered.to_bytes(), mask)), None);
                }
            }
        }
    }

    #[test]
    fn a_dead_bus_echoes_nothing() {
        let frame = Frame::write(register::DACA, 0);
        assert!(!frame.is_echoed_by([0; 4]));
        assert!(!frame.is_echoed_by([0xFF; 4]));
        for dead in [[0; 4], [0xFF; 4]] {
            let content = Answer::from_bytes(dead).and_then(|a| a.content_of(register::STATUS));
            assert_eq!(content, None);
        }
    }

    proptest! {
        #[test]
        fn frames_survive_the_wire(read: bool, address in 0..64u8, data: u16) {
            let frame = Frame { read, address, data };
            let bytes = frame.to_bytes();
            prop_assert_eq!(remainder_of(bytes), 0);
            prop_assert_eq!(Frame::from_bytes(bytes), Some(frame));
            let short = frame.to_bytes_without_crc();
            prop_assert_eq!(&short[..], &bytes[..3]);
            prop_assert_eq!(Frame::from_bytes_without_crc(short), frame);
        }

        #[test]
        fn answers_survive_the_wire(read: bool, crc_error: bool, address in 0..64u8, data: u16) {
            let answer = Answer { read, crc_error, address, data };
            prop_assert_eq!(remainder_of(answer.to_bytes()), 0);
            prop_assert_eq!(Answer::from_bytes(answer.to_bytes()), Some(answer));
        }

        #[test]
        fn arbitrary_bytes_are_judged_by_their_remainder(bytes: [u8; 4]) {
            let fits = remainder_of(bytes) == 0;
            prop_assert_eq!(Frame::from_bytes(bytes).is_some(), fits);
            prop_assert_eq!(Answer::from_bytes(bytes).is_some(), fits);
        }

        #[test]
        fn an_echo_is_address_data_and_no_error(address in 0..64u8, data: u16, bit in 0..32u32) {
            let frame = Frame::write(address, data);
            let echo = Answer { address, data, ..Answer::default() }.to_bytes();
            prop_assert!(frame.is_echoed_by(echo));
            let checked = (8..31).contains(&bit);
            prop_assert_eq!(frame.is_echoed_by(flip(echo, 1 << bit)), !checked);
        }
    }
}
