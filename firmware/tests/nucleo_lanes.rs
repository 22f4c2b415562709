//! The Nucleo board's four encoder lines, sampled together, against the words that went out.

#[path = "../src/bin/nucleo_f446re/lanes.rs"]
mod lanes;

use lanes::SAMPLE_WORDS;
use proptest::prelude::*;
use shared::wire::biss_c::{FRAME_BYTES, Layout, Word};

/// What DMA leaves in memory: clock by clock one byte, line 0 lowest, other pins above.
fn sampled(frames: &[[u8; FRAME_BYTES]; 4], others: u8) -> [u32; SAMPLE_WORDS] {
    let mut words = [0; SAMPLE_WORDS];
    for clock in 0..8 * FRAME_BYTES {
        let bit = |frame: &[u8; FRAME_BYTES]| frame[clock / 8] >> (7 - clock % 8) & 1;
        let lines = frames.iter().enumerate().map(|(line, f)| bit(f) << line).sum::<u8>();
        words[clock / 4] |= u32::from(others & 0xF0 | lines) << (8 * (clock % 4));
    }
    words
}

proptest! {
    #[test]
    fn each_line_carries_its_own_word(positions: [u32; 4], others: u8) {
        let layout = Layout::new(32).unwrap();
        let sent = positions.map(|position| Word { position, error: false, warning: true });
        let samples = sampled(&sent.map(|word| layout.encode(word)), others);
        for (line, word) in (0..).zip(sent) {
            prop_assert_eq!(layout.decode(&lanes::frame(&samples, line)), Ok(word));
        }
    }
}
