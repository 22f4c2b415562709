//! BiSS-C (unidirectional) read of a Renishaw RESOLUTE encoder as eight SPI bytes.
//!
//! Sources: [R] Renishaw data sheet L-9709-9005-03-F "BiSS C-mode (unidirectional) for RESOLUTE encoders";
//! [B] iC-Haus "BiSS Interface, Protocol Description (BiSS C)", Rev C6.
//!
//! The SPI clock is MA in mode 3 (idle high, sampled on rising edges), sent most significant bit first:
//!
//! | clocks | content | source |
//! |---|---|---|
//! | 2 | 1 1: SLO is idle until the second rising edge | [R] request cycle, step 3 |
//! | [`ACK_CLOCKS`] | 0: acknowledge, the head computes | [R] Ack, timing table |
//! | 1 | 1: start | [R] Start and "0" |
//! | 1 | 0: unidirectional, so no control data | [R] Start and "0" |
//! | n | position, binary | [R] Position |
//! | 1 | error, active low | [R] Error |
//! | 1 | warning, active low | [R] Warning |
//! | 6 | CRC over position, error and warning, inverted | [R] CRC |
//! | 32 - n | 0: SLO stays low until the timeout | [R] Timeout, [B] p. 6 |

use crc::{Algorithm, Crc};

/// Size of one read.
pub const FRAME_BYTES: usize = 8;

/// MA clock. At 1 MHz the longest Ack and a 32-bit word fill [`FRAME_BYTES`] exactly, and the cable may be
/// 20 m long without line delay compensation ([R] line delay table; 0.25 to 10 MHz are allowed).
pub const MA_HZ: u32 = 1_000_000;

/// Length of Ack: 20 µs at most ([R] timing table). The sheet gives no lower bound; a head whose Ack is
/// shorter at [`MA_HZ`] needs its own length here.
pub const ACK_CLOCKS: u32 = 20;

/// Time from the first falling edge of MA to the sampling moment: half a clock to the first rising edge,
/// then 4.000 ± 0.025 µs ([R] timing table).
pub const LATCH_DELAY_S: f64 = 0.5 / MA_HZ as f64 + 4.0e-6;

/// The 24 clocks before the position: idle, Ack, start and "0".
const HEADER: u32 = 0b11 << (ACK_CLOCKS + 2) | 0b10;

const NOT_ERROR: u32 = 1 << 7;
const NOT_WARNING: u32 = 1 << 6;
const CRC_MASK: u8 = 0x3F;

/// x⁶ + x + 1, start value 0, most significant bit first, inverted ([R] CRC; [B] p. 8 CRC checking).
const CRC6: Crc<u8> = Crc::<u8>::new(&Algorithm {
    width: 6,
    poly: 0x03,
    init: 0x00,
    refin: false,
    refout: false,
    xorout: CRC_MASK,
    check: 0x2E,
    residue: 0x02,
});

/// What an encoder reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Word {
    /// Position code, counts.
    pub position: u32,
    /// The head distrusts the position, or is too hot ([R] Error).
    pub error: bool,
    /// Scale or reading window should be cleaned; says nothing about the position ([R] Warning).
    pub warning: bool,
}

/// Why a read is not a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// A bit outside position, status and CRC has the wrong level.
    Framing,
    /// Position, status and CRC do not belong together.
    Crc,
}

/// Where the fields of one encoder's read are. The default fits no encoder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Layout {
    /// Clocks after the CRC, 0 to 24.
    trailing: u32,
    /// Ones over these clocks.
    trailing_mask: u32,
    /// CRC of every intact read from the position on, its own CRC field included.
    residue: u8,
}

impl Layout {
    /// Layout for a position of 8 to 32 bits; `None` for other widths. RESOLUTE heads have 18, 26 or 32
    /// bits ([R] Position; 36 is not supported here). From 8 bits on, status and CRC lie in the last four
    /// bytes.
    pub const fn new(position_bits: u32) -> Option<Self> {
        if position_bits < 8 || position_bits > 32 {
            return None;
        }
        let trailing = 32 - position_bits;
        // A codeword is divisible by the polynomial and stays so when shifted, so only the inversion of
        // its CRC field is left over.
        let [_, _, _, inversion @ ..] = ((CRC_MASK as u64) << trailing).to_be_bytes();
        let residue = CRC6.checksum(&inversion);
        Some(Self { trailing, trailing_mask: (1 << trailing) - 1, residue })
    }

    /// The bytes that an encoder sends; bits of `position` beyond the layout's width are ignored.
    pub fn encode(&self, word: Word) -> [u8; FRAME_BYTES] {
        let position = u64::from(word.position << self.trailing >> self.trailing);
        let data = position << 2 | u64::from(!word.error) << 1 | u64::from(!word.warning);
        let crc = CRC6.checksum(&data.to_be_bytes());
        let codeword = data << 6 | u64::from(crc);
        (u64::from(HEADER) << 40 | codeword << self.trailing).to_be_bytes()
    }

    /// Checks every bit of a read. All errors of one or two bits and all bursts of up to six bits are found;
    /// of arbitrary errors behind an intact header, one in 64 is not.
    #[inline(always)]
    pub fn decode(&self, frame: &[u8; FRAME_BYTES]) -> Result<Word, FrameError> {
        let [b0, b1, b2, b3, b4, b5, b6, b7] = *frame;
        let high = u32::from_be_bytes([b0, b1, b2, b3]);
        let low = u32::from_be_bytes([b4, b5, b6, b7]);
        if (high >> 8 ^ HEADER) | (low & self.trailing_mask) != 0 {
            return Err(FrameError::Framing);
        }
        if CRC6.checksum(&[b3, b4, b5, b6, b7]) != self.residue {
            return Err(FrameError::Crc);
        }
        let status = low >> self.trailing;
        Ok(Word {
            position: (high << 24 | low >> 8) >> self.trailing,
            error: status & NOT_ERROR == 0,
            warning: status & NOT_WARNING == 0,
        })
    }
}
