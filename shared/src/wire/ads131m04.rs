//! SPI frames of the ADS131M04 (TI SBAS890D), a 24-bit converter with four simultaneous channels.
//!
//! A frame is six words of 24 bits each way (section 8.5.1.7). The host sends a command and its CRC; the
//! device answers the *previous* command, then sends four conversions and a CRC. Commands, registers and
//! CRCs fill the upper 16 bits of their word, the rest is zero (section 8.5.1.8).

use crc::{CRC_16_IBM_3740, Crc};

/// Size of a frame: response, four channels and CRC, 3 bytes each (section 8.5.1.7).
pub const FRAME_BYTES: usize = 18;

/// Bytes that the CRC of a received frame covers: everything before it (section 8.3.12).
const COVERED_BYTES: usize = 15;

/// CCITT polynomial 0x1021, seed 0xFFFF (section 8.3.12, Table 8-7).
static CRC_TABLE: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);

/// Highest code, at inputs of full scale and above (Table 8-10).
pub const CODE_MAX: i32 = 0x7F_FFFF;

/// Lowest code, at inputs of minus full scale and below (Table 8-10).
pub const CODE_MIN: i32 = -0x80_0000;

/// Command words and their answers (Table 8-11).
pub mod command {
    /// No operation; answered by the status register.
    pub const NULL: u16 = 0x0000;
    /// Reset to the register defaults; answered by [`RESET_DONE`].
    pub const RESET: u16 = 0x0011;
    /// Answer to the first frame after a reset.
    pub const RESET_DONE: u16 = 0xFF24;
    /// Stop converting; echoed.
    pub const STANDBY: u16 = 0x0022;
    /// Leave standby; echoed.
    pub const WAKEUP: u16 = 0x0033;
    /// From now on take only NULL, RREG and UNLOCK; echoed.
    pub const LOCK: u16 = 0x0555;
    /// Undo [`LOCK`]; echoed.
    pub const UNLOCK: u16 = 0x0655;
    /// Three bits that tell the register commands apart.
    pub const KIND: u16 = 0xE000;
    /// Kind of a register read.
    pub const RREG: u16 = 0xA000;
    /// Kind of a register write.
    pub const WREG: u16 = 0x6000;
    /// Kind of the answer to a register write.
    pub const WREG_DONE: u16 = 0x4000;

    /// Reads one register; answered by its content.
    pub const fn read(address: u8) -> u16 {
        RREG | (address as u16) << 7
    }

    /// Writes one register; answered by [`written`].
    pub const fn write(address: u8) -> u16 {
        WREG | (address as u16) << 7
    }

    /// Answer to [`write`].
    pub const fn written(address: u8) -> u16 {
        WREG_DONE | (address as u16) << 7
    }
}

/// Register addresses (Table 8-12).
pub mod register {
    /// Identity: 0x24 above a byte that may change (Table 8-14).
    pub const ID: u8 = 0x00;
    /// See [`super::status`].
    pub const STATUS: u8 = 0x01;
    /// See [`super::mode`].
    pub const MODE: u8 = 0x02;
    /// See [`super::clock`].
    pub const CLOCK: u8 = 0x03;
    /// Gains of the four channels, all 1 after reset (Table 8-18).
    pub const GAIN: u8 = 0x04;
    /// Global chop and current detection, both off after reset.
    pub const CFG: u8 = 0x06;
}

/// Bits of the STATUS register (Table 8-15).
pub mod status {
    /// The interface is locked.
    pub const LOCK: u16 = 1 << 15;
    /// The filters were restarted.
    pub const F_RESYNC: u16 = 1 << 14;
    /// The CRC of the last command did not match.
    pub const CRC_ERR: u16 = 1 << 12;
    /// A reset occurred and MODE has not been written since.
    pub const RESET: u16 = 1 << 10;
    /// Word length field.
    pub const WLENGTH: u16 = 0b11 << 8;
    /// Word length of 24 bits.
    pub const WLENGTH_24: u16 = 0b01 << 8;
    /// New data on all four channels.
    pub const DRDY: u16 = 0b1111;
}

/// Bits of the MODE register (Table 8-16).
pub mod mode {
    /// Check the CRC of commands.
    pub const RX_CRC_EN: u16 = 1 << 12;
    /// Set by a reset; writing 0 clears [`super::status::RESET`].
    pub const RESET: u16 = 1 << 10;
    /// Drop a frame that takes longer than 2¹⁵ clocks.
    pub const TIMEOUT: u16 = 1 << 4;
    /// Content after reset.
    pub const DEFAULT: u16 = 0x0510;
}

/// Bits of the CLOCK register (Table 8-17).
pub mod clock {
    /// All four channels convert.
    pub const CHANNELS: u16 = 0b1111 << 8;
    /// Position of the 3-bit oversampling ratio; 0 is 128, each step doubles it.
    pub const OSR_SHIFT: u16 = 2;
    /// High-resolution power mode, the one for the full clock rate.
    pub const HIGH_RESOLUTION: u16 = 0b10;
    /// Content after reset: an oversampling ratio of 1024.
    pub const DEFAULT: u16 = 0x0F0E;
}

/// What the device sends in one frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Answer to the command of the frame before; after NULL the status register.
    pub response: u16,
    /// Conversions of channels 0 to 3; 2²³ codes are full scale (Equation 10).
    pub codes: [i32; 4],
}

/// Why a frame was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// The CRC does not match.
    Crc,
    /// A bit that is always zero is set.
    Padding,
}

/// The CRC of these bytes, as both ends compute it.
pub const fn checksum(bytes: &[u8]) -> u16 {
    CRC_TABLE.checksum(bytes)
}

/// A frame that sends `command`, with its CRC.
pub const fn request(command: u16) -> [u8; FRAME_BYTES] {
    let [c1, c0] = command.to_be_bytes();
    let [k1, k0] = checksum(&[c1, c0, 0]).to_be_bytes();
    [c1, c0, 0, k1, k0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]
}

/// A frame that writes one register; here the CRC follows the content (section 8.5.1.10.8).
pub const fn write_request(address: u8, content: u16) -> [u8; FRAME_BYTES] {
    let [c1, c0] = command::write(address).to_be_bytes();
    let [r1, r0] = content.to_be_bytes();
    let [k1, k0] = checksum(&[c1, c0, 0, r1, r0, 0]).to_be_bytes();
    [c1, c0, 0, r1, r0, 0, k1, k0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]
}

/// Takes a received frame apart.
#[inline(always)]
pub fn decode(bytes: &[u8; FRAME_BYTES]) -> Result<Frame, FrameError> {
    check(bytes)?;
    let [r1, r0, _, a2, a1, a0, b2, b1, b0, c2, c1, c0, d2, d1, d0, after, ..] = *bytes;
    // Each word is loaded with the byte that follows it, which the shift drops.
    let codes = [[a2, a1, a0, b2], [b2, b1, b0, c2], [c2, c1, c0, d2], [d2, d1, d0, after]];
    Ok(Frame {
        response: u16::from_be_bytes([r1, r0]),
        codes: codes.map(|word| i32::from_be_bytes(word) >> 8),
    })
}

/// Whether CRC and padding are as they must be; one copy of it serves every caller.
#[inline(never)]
fn check(bytes: &[u8; FRAME_BYTES]) -> Result<(), FrameError> {
    let [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, k1, k0, tail] = *bytes;
    let words = [[c, d, e, f], [g, h, i, j], [k, l, m, n], [o, k1, k0, 0]].map(u32::from_be_bytes);
    if remainder(u16::from_be_bytes([a, b]), words) != 0 {
        return Err(FrameError::Crc);
    }
    if c | tail != 0 {
        return Err(FrameError::Padding);
    }
    Ok(())
}

/// What division by the CRC's polynomial P leaves of a received frame, first 16 bits and the rest: 0 if the
/// CRC matches. A tick waits for it, and from a table byte by byte it would take twice as long.
///
/// P = x¹⁶ + x¹² + x⁵ + 1, and squaring doubles each exponent: P², P⁴ and P⁸ have four terms too. So a word
/// that stands at x¹²⁸, x⁹⁶, x⁶⁴ or x³² may be replaced by three shifted copies further down; what a copy
/// leaves above its place, `t` carries down in advance.
#[inline(always)]
const fn remainder(first: u16, [mut w3, mut w2, mut w1, mut w0]: [u32; 4]) -> u32 {
    // The seed inverts the first 16 bits. x¹²⁸ = x⁹⁶ + x⁴⁰ + 1.
    let t = !first as u32;
    w3 ^= t;
    w1 ^= t << 8;
    w0 ^= t;
    // x⁶⁴ = x⁴⁸ + x²⁰ + 1, here times x³².
    let t = w3 ^ w3 >> 16;
    w2 ^= t << 16 ^ t >> 12;
    w1 ^= t << 20 ^ t;
    let t = w2 ^ w2 >> 16;
    w1 ^= t << 16 ^ t >> 12;
    w0 ^= t << 20 ^ t;
    // x³² = x²⁴ + x¹⁰ + 1.
    let t = w1 ^ w1 >> 8;
    let t = t ^ t >> 16 ^ w1 >> 22;
    w0 ^= t << 24 ^ t << 10 ^ t;
    // x¹⁶ = x¹² + x⁵ + 1.
    let high = w0 >> 16;
    let t = high ^ high >> 4;
    let t = t ^ t >> 8 ^ high >> 11;
    (w0 ^ t << 12 ^ t << 5 ^ t) & 0xFFFF
}

/// Puts a frame together as the device does; codes keep their lower 24 bits.
pub fn encode(frame: &Frame) -> [u8; FRAME_BYTES] {
    let [r1, r0] = frame.response.to_be_bytes();
    let [a, b, c, d] = frame.codes.map(i32::to_be_bytes);
    let mut bytes = [
        r1, r0, 0, a[1], a[2], a[3], b[1], b[2], b[3], c[1], c[2], c[3], d[1], d[2], d[3], 0, 0, 0,
    ];
    let [k1, k0] = checksum(&bytes[..COVERED_BYTES]).to_be_bytes();
    bytes[COVERED_BYTES] = k1;
    bytes[COVERED_BYTES + 1] = k0;
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The CRC bit by bit, as the sheet's polynomial and seed define it.
    fn bitwise(bytes: &[u8]) -> u16 {
        bytes.iter().fold(0xFFFF, |crc, byte| {
            (0..8).fold(crc ^ u16::from(*byte) << 8, |crc, _| {
                if crc & 0x8000 == 0 { crc << 1 } else { crc << 1 ^ 0x1021 }
            })
        })
    }

    fn flipped(mut bytes: [u8; FRAME_BYTES], bit: usize) -> [u8; FRAME_BYTES] {
        bytes[bit / 8] ^= 0x80 >> (bit % 8);
        bytes
    }

    /// Captured from a locked device: TI E2E, data converters forum, thread 1011774.
    #[test]
    fn decodes_a_frame_of_a_real_device() {
        let mut bytes = [0; FRAME_BYTES];
        bytes[0] = 0x81;
        bytes[15] = 0xB4;
        bytes[16] = 0x2D;
        let frame = Frame { response: status::LOCK | status::WLENGTH_24, codes: [0; 4] };
        assert_eq!(decode(&bytes), Ok(frame));
        assert_eq!(encode(&frame), bytes);
    }

    /// Words of the sheet's Table 8-11 with the addresses of Table 8-12 filled in.
    #[test]
    fn requests_carry_command_content_and_crc() {
        let null = request(command::NULL);
        assert_eq!(null[3..5], bitwise(&[0, 0, 0]).to_be_bytes());
        let read = request(command::read(register::CLOCK));
        assert_eq!(read[..3], [0xA1, 0x80, 0]);
        let write = write_request(register::MODE, 0x1110);
        assert_eq!(write[..6], [0x61, 0x00, 0, 0x11, 0x10, 0]);
        assert_eq!(write[6..8], bitwise(&write[..6]).to_be_bytes());
        assert_eq!(command::written(register::MODE), 0x4100);
    }

    #[test]
    fn codes_keep_their_sign() {
        let frame = Frame { response: 0, codes: [CODE_MAX, CODE_MIN, -1, 1] };
        assert_eq!(encode(&frame)[3..15], [0x7F, 255, 255, 0x80, 0, 0, 255, 255, 255, 0, 0, 1]);
        assert_eq!(decode(&encode(&frame)), Ok(frame));
    }

    #[test]
    fn dead_lines_are_refused() {
        assert!(decode(&[0x00; FRAME_BYTES]).is_err());
        assert!(decode(&[0xFF; FRAME_BYTES]).is_err());
    }

    #[test]
    fn every_flip_of_one_or_two_bits_is_refused() {
        let frame = Frame { response: 0x810F, codes: [0x12_3456, -0x65_4321, 7, -7] };
        let bytes = encode(&frame);
        for first in 0..8 * FRAME_BYTES {
            let once = flipped(bytes, first);
            assert!(decode(&once).is_err(), "bit {first}");
            for second in 0..first {
                assert!(decode(&flipped(once, second)).is_err(), "bits {second} and {first}");
            }
        }
    }

    proptest! {
        #[test]
        fn frames_survive_the_wire(response: u16, codes in [CODE_MIN..=CODE_MAX, CODE_MIN..=CODE_MAX, CODE_MIN..=CODE_MAX, CODE_MIN..=CODE_MAX]) {
            let frame = Frame { response, codes };
            let bytes = encode(&frame);
            prop_assert_eq!(bitwise(&bytes[..15]).to_be_bytes(), [bytes[15], bytes[16]]);
            prop_assert_eq!(decode(&bytes), Ok(frame));
        }

        #[test]
        fn any_bytes_are_decoded_or_refused(bytes: [u8; FRAME_BYTES]) {
            if let Ok(frame) = decode(&bytes) {
                prop_assert_eq!(encode(&frame), bytes);
            }
        }
    }
}
