//! Frames out of a stream of bytes.

use bytemuck::Zeroable;
use cobs::{DecodeResult, DecoderState};

use super::{FRAME_BYTES, Frame, Kind};
use crate::fault::LinkRefusal;

/// Takes a stream byte by byte. Whatever comes in, the frame after the next zero is received whole.
#[derive(Debug)]
pub struct Receiver {
    state: DecoderState,
    frame: Frame,
    /// Bytes of the frame so far; may pass its size.
    length: usize,
}

impl Receiver {
    /// At the start of a stream.
    pub fn new() -> Self {
        Self { state: DecoderState::Idle, frame: Frame::zeroed(), length: 0 }
    }

    /// The last frame that was complete.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Takes a byte. At the end of a frame says of which kind it is, or what is wrong with it.
    #[inline(never)]
    pub fn feed(&mut self, byte: u8) -> Option<Result<Kind, LinkRefusal>> {
        match self.state.feed(byte) {
            Ok(DecodeResult::NoData) => None,
            Ok(DecodeResult::DataStart) => {
                self.length = 0;
                None
            }
            Ok(DecodeResult::DataContinue(byte)) => {
                if let Some(slot) = bytemuck::bytes_of_mut(&mut self.frame).get_mut(self.length) {
                    *slot = byte;
                }
                self.length = self.length.saturating_add(1);
                None
            }
            Ok(DecodeResult::DataComplete) if self.length == FRAME_BYTES => {
                Some(self.frame.check())
            }
            Ok(DecodeResult::DataComplete) | Err(_) => Some(Err(LinkRefusal::Length)),
        }
    }
}

impl Default for Receiver {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec::Vec;

    use proptest::prelude::*;

    use super::*;
    use crate::link::WIRE_BYTES;

    fn frame(payload: [u32; 10], counter: u32) -> Frame {
        let mut frame = Frame::new(Kind::Command, counter, payload);
        frame.seal();
        frame
    }

    fn received(receiver: &mut Receiver, bytes: &[u8]) -> Vec<Result<Frame, LinkRefusal>> {
        let kinds = bytes.iter().filter_map(|byte| {
            let kind = receiver.feed(*byte)?;
            Some(kind.map(|_| *receiver.frame()))
        });
        kinds.collect()
    }

    proptest! {
        #[test]
        fn any_frame_survives_the_wire(payload: [u32; 10], counter: u32) {
            let frame = frame(payload, counter);
            let wire = frame.to_wire();
            prop_assert!(wire[0] == 0 && wire[WIRE_BYTES - 1] == 0);
            prop_assert!(!wire[1..WIRE_BYTES - 1].contains(&0));
            prop_assert_eq!(received(&mut Receiver::new(), &wire), [Ok(frame)]);
        }

        #[test]
        fn a_frame_after_any_garbage_is_received(garbage: Vec<u8>, payload: [u32; 10]) {
            let frame = frame(payload, 1);
            let mut receiver = Receiver::new();
            received(&mut receiver, &garbage);
            let all = received(&mut receiver, &frame.to_wire());
            prop_assert_eq!(all.last(), Some(&Ok(frame)));
        }
    }

    #[test]
    fn a_frame_of_another_length_is_refused_at_its_end() {
        let refused = |bytes: &[u8]| {
            let mut wire = std::vec![0; bytes.len() + 4];
            let end = cobs::encode(bytes, &mut wire[1..]);
            wire.truncate(1 + end);
            wire.push(0);
            received(&mut Receiver::new(), &wire)
        };
        for length in [1, FRAME_BYTES - 1, FRAME_BYTES + 1, 253, 254, 255, 600] {
            assert_eq!(refused(&std::vec![7; length]), [Err(LinkRefusal::Length)], "{length}");
        }
        assert_eq!(received(&mut Receiver::new(), &[0, 9, 1, 0]), [Err(LinkRefusal::Length)]);
        assert_eq!(received(&mut Receiver::new(), &[0, 0, 0]), []);
    }
}
