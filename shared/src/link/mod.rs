//! The operator link's frames: what is on the wire, and what their payloads mean. `docs/link.md` tells how they are
//! used. All words are little-endian.

mod payload;
mod receiver;

use bytemuck::{Pod, Zeroable};

pub use payload::{
    Answer, Counters, Evidence, Hello, Query, QueryKind, State, Versions, Welcome, session_message,
};
pub use receiver::Receiver;

use crate::crc32::crc32;
use crate::fault::LinkRefusal;

codes! {
    /// What a frame is. Below 0x40 the operator's, the board's from there.
    Kind: u8 {
        /// Asks for a session; coded with the operator's key, all that follows with the session's.
        Hello = 0x01,
        /// The operator is there.
        Heartbeat = 0x02,
        /// A [`crate::command::Command`].
        Command = 0x03,
        /// Asks for a [`State`], [`Versions`], [`Counters`] or [`Evidence`].
        Query = 0x04,
        /// Stop: needs neither session nor code, and no counter.
        Stop = 0x05,
        /// Answer to a Hello.
        Welcome = 0x41,
        /// What became of a command or a stop, or why a frame had no effect.
        Answer = 0x42,
        /// See [`State`].
        State = 0x43,
        /// See [`Versions`].
        Versions = 0x44,
        /// See [`Counters`].
        Counters = 0x45,
        /// See [`Evidence`].
        Evidence = 0x46,
    }
}

/// Version of frames and payloads.
pub const VERSION: u8 = 1;
/// Size of a frame.
pub const FRAME_BYTES: usize = size_of::<Frame>();
/// Leading bytes that the code covers.
pub const CODED_BYTES: usize = 48;
/// Size of a payload.
pub const PAYLOAD_BYTES: usize = 4 * PAYLOAD_WORDS;
const PAYLOAD_WORDS: usize = 10;
/// Size of a frame on the wire: a zero, COBS with one byte more, a zero.
pub const WIRE_BYTES: usize = FRAME_BYTES + 3;
const _: () = assert!(FRAME_BYTES == 68 && cobs::max_encoding_length(FRAME_BYTES) == 69);

/// A key of operator or session.
pub type Key = [u8; 32];
/// Truncated HMAC-SHA256.
pub type Code = [u8; 16];

/// The key of a board that has not been given one; it does not arm.
pub const DEFAULT_KEY: Key = [0; 32];

/// A frame as it lies between the zeros once COBS is undone.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Frame {
    /// A [`Kind`].
    pub kind: u8,
    /// [`VERSION`].
    pub version: u8,
    /// Zero.
    pub reserved: [u8; 2],
    /// Rises with every frame that one side sends in a session.
    pub counter: u32,
    /// What the kind says.
    pub payload: [u32; PAYLOAD_WORDS],
    /// HMAC-SHA256 over all before it, its first half.
    pub code: Code,
    /// CRC-32 over all before it.
    pub crc: u32,
}

impl Frame {
    /// Without code and CRC.
    pub fn new(kind: Kind, counter: u32, payload: impl Pod) -> Self {
        const { assert!(PAYLOAD_BYTES == 40) };
        Self {
            kind: kind as u8,
            version: VERSION,
            reserved: [0; 2],
            counter,
            payload: bytemuck::cast(payload),
            code: [0; 16],
            crc: 0,
        }
    }

    /// Its payload, whatever it is read as.
    pub fn payload<P: Pod>(&self) -> P {
        bytemuck::cast(self.payload)
    }

    /// What the code covers.
    pub fn coded(&self) -> &[u8] {
        bytemuck::bytes_of(self).get(..CODED_BYTES).unwrap_or_default()
    }

    /// CRC-32 of what it covers.
    fn sum(&self) -> u32 {
        crc32(bytemuck::bytes_of(self).get(..FRAME_BYTES - 4).unwrap_or_default())
    }

    /// Puts the CRC in its place.
    pub fn seal(&mut self) {
        self.crc = self.sum();
    }

    /// What kind of frame this is, if it is well-formed.
    ///
    /// # Errors
    /// The first check that fails, of CRC, version, reserved bytes and kind.
    #[inline(never)]
    pub fn check(&self) -> Result<Kind, LinkRefusal> {
        if self.crc != self.sum() {
            Err(LinkRefusal::Damaged)
        } else if self.version != VERSION {
            Err(LinkRefusal::Version)
        } else if self.reserved != [0; 2] {
            Err(LinkRefusal::Reserved)
        } else {
            Kind::from_number(self.kind).ok_or(LinkRefusal::Kind)
        }
    }

    /// The frame on the wire: COBS between two zeros. The leading one ends whatever garbage came before.
    #[inline(never)]
    pub fn to_wire(&self) -> [u8; WIRE_BYTES] {
        let mut wire = [0; WIRE_BYTES];
        if let Some(room) = wire.get_mut(1..) {
            let mut encoder = cobs::CobsEncoder::new(room);
            // There is room enough.
            let _ = encoder.push(bytemuck::bytes_of(self));
            encoder.finalize();
        }
        wire
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sealed() -> Frame {
        let mut frame = Frame::new(Kind::Heartbeat, 7, [0_u8; 40]);
        frame.code = [0xA5; 16];
        frame.seal();
        frame
    }

    #[test]
    fn layout_is_that_of_the_document() {
        let frame = Frame { payload: [0x0403_0201; 10], ..sealed() };
        let bytes: [u8; FRAME_BYTES] = bytemuck::cast(frame);
        assert_eq!(bytes[..12], [2, 1, 0, 0, 7, 0, 0, 0, 1, 2, 3, 4]);
        assert_eq!(bytes[48..64], [0xA5; 16]);
        assert_eq!(frame.coded().len(), CODED_BYTES);
    }

    #[test]
    fn each_check_refuses_with_its_own_reason() {
        let refusal = |change: fn(&mut Frame)| {
            let mut frame = sealed();
            change(&mut frame);
            frame.seal();
            frame.check()
        };
        assert_eq!(sealed().check(), Ok(Kind::Heartbeat));
        assert_eq!(refusal(|f| f.version = 2), Err(LinkRefusal::Version));
        assert_eq!(refusal(|f| f.reserved[1] = 1), Err(LinkRefusal::Reserved));
        assert_eq!(refusal(|f| f.kind = 0), Err(LinkRefusal::Kind));
        let damaged = Frame { counter: 8, ..sealed() };
        assert_eq!(damaged.check(), Err(LinkRefusal::Damaged));
    }
}
