//! What the payloads mean.

use bytemuck::{Pod, Zeroable};

use super::PAYLOAD_BYTES;
use crate::arm::JOINTS;
use crate::evidence::CHUNK_BYTES;
use crate::telemetry::Record;

/// Asks for a session.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Hello {
    /// Random, of the operator's making, never used twice.
    pub challenge: [u8; 16],
    /// Zero.
    pub reserved: [u8; 24],
}

/// Offers a session.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Welcome {
    /// The operator's challenge.
    pub challenge: [u8; 16],
    /// Boots of the board so far.
    pub boots: u32,
    /// Hellos that it has taken since boot.
    pub hellos: u32,
    /// Zero.
    pub reserved: [u8; 16],
}

/// What the session's key is the HMAC-SHA256 of, under the operator's key: a label, the challenge, and the board's
/// nonce, which never comes twice. A frame's code covers 48 bytes and these are 32, so neither passes for the other.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct SessionMessage {
    label: [u8; 8],
    challenge: [u8; 16],
    boots: u32,
    hellos: u32,
}

/// See [`Welcome`]: the message that makes a session's key.
pub fn session_message(challenge: [u8; 16], boots: u32, hellos: u32) -> [u8; 32] {
    bytemuck::cast(SessionMessage { label: *b"lift-ses", challenge, boots, hellos })
}

/// What became of a frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Answer {
    /// [`super::Kind`] of the frame that this answers, as far as it could be read.
    pub kind: u8,
    /// Number of a [`crate::fault::LinkRefusal`] or [`crate::fault::Refusal`]; 0 if it had its effect.
    pub reason: u8,
    /// Zero.
    pub reserved: [u8; 2],
    /// Counter of that frame.
    pub counter: u32,
    /// Zero.
    pub rest: [u32; 8],
}

codes! {
    /// What a query asks for.
    QueryKind: u8 {
        /// [`State`].
        State = 1,
        /// [`Versions`].
        Versions = 2,
        /// [`Counters`].
        Counters = 3,
        /// [`Evidence`].
        Evidence = 4,
    }
}

/// Asks for something.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Query {
    /// A [`QueryKind`].
    pub what: u8,
    /// Which evidence; there is one, 0.
    pub section: u8,
    /// Which piece of it.
    pub index: u16,
    /// Zero.
    pub rest: [u32; 9],
}

/// Mode and fault as of the last tick; see [`Record`] for each.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[expect(missing_docs, reason = "the record's fields")]
pub struct State {
    pub tick: u32,
    pub mode: u8,
    pub refusal: u8,
    pub fault: u16,
    pub limits: u16,
    pub joints: u8,
    pub powered: u8,
    pub phase: u32,
    pub path_rate: u16,
    pub irregular: u8,
    pub bucket: u8,
    pub code: [u32; JOINTS],
    pub rejected: u8,
    pub saturated: u8,
    pub adaptation_bound: u8,
    pub dropped: u8,
}

impl From<&Record> for State {
    fn from(r: &Record) -> Self {
        Self {
            tick: r.tick,
            mode: r.mode,
            refusal: r.refusal,
            fault: r.fault,
            limits: r.limits,
            joints: r.joints,
            powered: r.powered,
            phase: r.phase,
            path_rate: r.path_rate,
            irregular: r.irregular,
            bucket: r.bucket,
            code: r.code,
            rejected: r.rejected,
            saturated: r.saturated,
            adaptation_bound: r.adaptation_bound,
            dropped: r.dropped,
        }
    }
}

/// What runs on the board.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Versions {
    /// Major, minor and patch version of the firmware.
    pub firmware: [u16; 3],
    /// 1 if the operator's key is the default one.
    pub default_key: u8,
    /// Zero.
    pub reserved: u8,
    /// CRC-32 of the configuration: the parameters' version.
    pub parameters: u32,
    /// Ticks a second.
    pub tick_hz: u32,
    /// Pieces of evidence.
    pub pieces: u32,
    /// Boots so far.
    pub boots: u32,
    /// Zero.
    pub rest: [u32; 4],
}

/// Frames since boot, by what became of them; each stops at its highest value.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Counters {
    /// Taken, stops and Hellos included.
    pub taken: u32,
    /// Stops.
    pub stops: u32,
    /// Hellos taken.
    pub hellos: u32,
    /// Refused for length, CRC, version, reserved bytes or kind.
    pub malformed: u32,
    /// Refused for want of a session or for a wrong code.
    pub unauthentic: u32,
    /// Refused as repetitions.
    pub stale: u32,
    /// Authentic frames without a meaning.
    pub meaningless: u32,
    /// Orders given to the tick.
    pub orders: u32,
    /// Orders that planning or the tick refused.
    pub refused: u32,
    /// Zero.
    pub reserved: u32,
}

/// A piece of the evidence.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Evidence {
    /// Zero.
    pub reserved: u8,
    /// As asked for.
    pub section: u8,
    /// As asked for.
    pub index: u16,
    /// The piece.
    pub bytes: [u8; CHUNK_BYTES],
}

const _: () = assert!(
    size_of::<Hello>() == PAYLOAD_BYTES
        && size_of::<Welcome>() == PAYLOAD_BYTES
        && size_of::<Answer>() == PAYLOAD_BYTES
        && size_of::<Query>() == PAYLOAD_BYTES
        && size_of::<State>() == PAYLOAD_BYTES
        && size_of::<Versions>() == PAYLOAD_BYTES
        && size_of::<Counters>() == PAYLOAD_BYTES
        && size_of::<Evidence>() == PAYLOAD_BYTES
);
