//! Decoders of the bus: what they take is what would be sent.

use shared::arm::REFERENCE;
use shared::wire::{ads131m04, biss_c, dac81404};

fn first<const N: usize>(bytes: &[u8]) -> [u8; N] {
    std::array::from_fn(|i| bytes.get(i).copied().unwrap_or_default())
}

/// An encoder's frame, for each width of the arm's encoders.
pub fn biss_c(bytes: &[u8]) {
    let frame: [u8; biss_c::FRAME_BYTES] = first(bytes);
    for bits in [REFERENCE.encoders[0].bits, REFERENCE.encoders[3].bits] {
        let layout = biss_c::Layout::new(bits).expect("a width that a head has");
        if let Ok(word) = layout.decode(&frame) {
            assert_eq!(layout.decode(&layout.encode(word)), Ok(word));
            assert!(bits == 32 || word.position >> bits == 0);
        }
    }
}

/// A frame of the torque converter.
pub fn ads131m04(bytes: &[u8]) {
    let bytes: [u8; ads131m04::FRAME_BYTES] = first(bytes);
    if let Ok(frame) = ads131m04::decode(&bytes) {
        assert_eq!(ads131m04::decode(&ads131m04::encode(&frame)), Ok(frame));
        assert!(frame.codes.iter().all(|code| (-(1 << 23)..1 << 23).contains(code)));
    }
}

/// A frame of the DAC, as command and as answer.
pub fn dac81404(bytes: &[u8]) {
    let bytes: [u8; 4] = first(bytes);
    if let Some(frame) = dac81404::Frame::from_bytes(bytes) {
        assert_eq!(dac81404::Frame::from_bytes(frame.to_bytes()), Some(frame));
    }
    if let Some(answer) = dac81404::Answer::from_bytes(bytes) {
        assert_eq!(dac81404::Answer::from_bytes(answer.to_bytes()), Some(answer));
    }
}
