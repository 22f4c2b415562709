//! BiSS-C frames against independent implementations, and what the CRC finds.

use proptest::prelude::*;
use shared::wire::biss_c::{FrameError, Layout, Word};

const WIDTHS: [u32; 4] = [18, 20, 26, 32];

fn layout(bits: u32) -> Layout {
    Layout::new(bits).unwrap()
}

fn word(position: u32, error: bool, warning: bool) -> Word {
    Word { position, error, warning }
}

/// Bit-serial shift register as drawn in encoder manuals (Lika AMM80, section 6): x⁶ + x + 1, inverted.
fn crc6_bitwise(data: u64, bits: u32) -> u64 {
    let register = (0..bits).rev().fold(0u64, |register, bit| {
        let feedback = (register >> 5 ^ data >> bit) & 1;
        (register << 1 & 0x3F) ^ (feedback * 0b11)
    });
    !register & 0x3F
}

/// A read assembled bit by bit as text, in the order of the data sheet's diagram.
fn frame_by_text(bits: u32, word: Word) -> [u8; 8] {
    let n = bits as usize;
    let data =
        format!("{:0n$b}{}{}", word.position, u8::from(!word.error), u8::from(!word.warning));
    let crc = crc6_bitwise(u64::from_str_radix(&data, 2).unwrap(), bits + 2);
    let text = format!("11{}10{data}{crc:06b}{}", "0".repeat(20), "0".repeat(32 - n));
    u64::from_str_radix(&text, 2).unwrap().to_be_bytes()
}

fn flipped(frame: [u8; 8], mask: u64) -> [u8; 8] {
    (u64::from_be_bytes(frame) ^ mask).to_be_bytes()
}

/// A position width, a word of that width and its read.
fn reads() -> impl Strategy<Value = (u32, Word, [u8; 8])> {
    (8..=32u32, any::<u32>(), any::<bool>(), any::<bool>()).prop_map(|(bits, raw, e, w)| {
        let word = word(raw >> (32 - bits), e, w);
        (bits, word, layout(bits).encode(word))
    })
}

/// CRCs by the six-bits-at-a-time table that RLS publishes (application note CRCD01).
#[test]
fn golden_frames() {
    let golden = [
        (32, word(0, false, false), 0xC000_0200_0000_00FA_u64),
        (32, word(0xFFFF_FFFF, false, false), 0xC000_02FF_FFFF_FFDA),
        (32, word(0x1234_5678, false, false), 0xC000_0212_3456_78C5),
        (32, word(0x1234_5678, true, false), 0xC000_0212_3456_7843),
        (26, word(0x02AA_AAAA, false, true), 0xC000_02AA_AAAA_AA40),
        (18, word(0x0002_DEAD, false, false), 0xC000_02B7_AB7C_8000),
        (20, word(0x0008_9ABC, false, false), 0xC000_0289_ABCE_D000),
    ];
    for (bits, word, frame) in golden {
        assert_eq!(layout(bits).encode(word), frame.to_be_bytes(), "{word:?}");
        assert_eq!(layout(bits).decode(&frame.to_be_bytes()), Ok(word));
    }
}

#[test]
fn widths_outside_the_word_are_refused() {
    assert_eq!(Layout::new(7), None);
    assert_eq!(Layout::new(33), None);
}

#[test]
fn a_dead_line_is_a_framing_error() {
    for bits in 8..=32 {
        for level in [0x00, 0xFF] {
            assert_eq!(layout(bits).decode(&[level; 8]), Err(FrameError::Framing));
        }
    }
}

#[test]
fn every_one_and_two_bit_error_is_found() {
    for bits in WIDTHS {
        let covered = !0u64 << (32 - bits) & !0 >> 24;
        for seed in [0u32, 0x2DEA_DBEE, u32::MAX] {
            let frame = layout(bits).encode(word(seed >> (32 - bits), false, seed == 0));
            for (i, j) in (0..64).flat_map(|i| (i..64).map(move |j| (i, j))) {
                let mask = 1u64 << i | 1 << j;
                let expected =
                    if mask & !covered == 0 { FrameError::Crc } else { FrameError::Framing };
                assert_eq!(layout(bits).decode(&flipped(frame, mask)), Err(expected));
            }
        }
    }
}

#[test]
fn every_burst_up_to_the_crc_length_is_found() {
    for bits in WIDTHS {
        let frame = layout(bits).encode(word(0x1_2345, false, false));
        for (burst, shift) in (1u64..64).flat_map(|burst| (0..59).map(move |s| (burst, s))) {
            assert!(layout(bits).decode(&flipped(frame, burst << shift)).is_err());
        }
    }
}

/// The Hamming distance is 3: of the 9880 triples in a 32-bit word's read, 163 pass.
#[test]
fn some_three_bit_errors_pass() {
    let layout = layout(32);
    let frame = layout.encode(word(0x1234_5678, false, false));
    let mut passed = 0;
    for i in 0..40 {
        for j in 0..i {
            for k in 0..j {
                let mask = 1u64 << i | 1 << j | 1 << k;
                passed += u32::from(layout.decode(&flipped(frame, mask)).is_ok());
            }
        }
    }
    assert_eq!(passed, 163);
}

/// All 2¹⁶ contents of an 8-bit word's read: exactly one in 64 passes.
#[test]
fn one_in_64_of_random_contents_passes() {
    let layout = layout(8);
    let header = u64::from_be_bytes(layout.encode(word(0, false, false))) >> 40 << 40;
    let passed = (0..1u64 << 16)
        .filter(|content| layout.decode(&(header | content << 24).to_be_bytes()).is_ok())
        .count();
    assert_eq!(passed, 1 << 10);
}

proptest! {
    #[test]
    fn encodes_like_the_diagram((bits, word, frame) in reads()) {
        prop_assert_eq!(frame, frame_by_text(bits, word));
    }

    #[test]
    fn round_trip((bits, word, frame) in reads()) {
        prop_assert_eq!(layout(bits).decode(&frame), Ok(word));
    }

    #[test]
    fn bits_beyond_the_width_are_ignored(bits in 8..=31u32, raw: u32) {
        let narrow = raw & ((1 << bits) - 1);
        let layout = layout(bits);
        prop_assert_eq!(layout.encode(word(raw, false, false)), layout.encode(word(narrow, false, false)));
    }

    #[test]
    fn a_changed_fixed_bit_is_a_framing_error((bits, _, frame) in reads(), mask: u64, shift in 0..64u32) {
        let mask = mask >> shift;
        let fixed = mask & (!0 << 40 | ((1 << (32 - bits)) - 1));
        prop_assume!(fixed != 0);
        prop_assert_eq!(layout(bits).decode(&flipped(frame, mask)), Err(FrameError::Framing));
    }

    #[test]
    fn arbitrary_bytes_decode_to_an_error_or_to_their_only_word(bits in 8..=32u32, content: [u8; 8], framed: bool) {
        let layout = layout(bits);
        let mut frame = content;
        if framed {
            frame[..3].copy_from_slice(&[0xC0, 0x00, 0x02]);
        }
        if let Ok(word) = layout.decode(&frame) {
            prop_assert_eq!(layout.encode(word), frame);
        }
    }
}
