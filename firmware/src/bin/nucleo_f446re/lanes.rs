//! From samples of a port, four lines at once, to what four SPI ports would have read.

use shared::wire::biss_c::FRAME_BYTES;

/// Words that hold one sample a byte, first sample lowest, one sample a clock of the read.
pub const SAMPLE_WORDS: usize = 8 * FRAME_BYTES / 4;

/// The read on line `lane` (bit number in each sample, 0 to 7), most significant bit first.
pub fn frame(samples: &[u32; SAMPLE_WORDS], lane: u32) -> [u8; FRAME_BYTES] {
    let mut bytes = [0; FRAME_BYTES];
    let (pairs, _) = samples.as_chunks();
    for (byte, [first, second]) in bytes.iter_mut().zip(pairs) {
        *byte = (nibble(*first, lane) << 4 | nibble(*second, lane)) as u8;
    }
    bytes
}

/// Bit `lane` of four samples, the first one highest.
///
/// The product moves bits 0, 8, 16 and 24 to 27, 26, 25 and 24; its other terms stay below or overflow.
fn nibble(samples: u32, lane: u32) -> u32 {
    (samples.wrapping_shr(lane) & 0x0101_0101).wrapping_mul(0x0804_0201) >> 24
}
