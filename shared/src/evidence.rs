//! What is kept of the time before a stop, as it lies in memory that survives a reset and as it is read back.
//!
//! The image is little-endian, without padding, and read in chunks of [`CHUNK_BYTES`]; the last one is filled up
//! with zeros.

use bytemuck::{Pod, Zeroable};

use crate::arm::JOINTS;
use crate::fault::Fault;
use crate::telemetry::Record;

/// Ticks kept at full rate.
pub const FULL_ENTRIES: usize = 64;
/// Entries of the thinned ring: 2 s at [`THIN_HZ`].
pub const THIN_ENTRIES: usize = 100;
/// Rate of the thinned ring, Hz.
pub const THIN_HZ: u32 = 50;
/// Errors kept.
pub const ERRORS: usize = 16;
/// Size of a chunk.
pub const CHUNK_BYTES: usize = 36;
/// Marks an image that somebody wrote; its last byte is the layout's version.
pub const MAGIC: u32 = u32::from_be_bytes(*b"EVI\x02");

/// One tick, made small.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Entry {
    /// See [`Record::tick`].
    pub tick: u32,
    /// See [`Record::fault`].
    pub fault: u16,
    /// See [`Record::mode`].
    pub mode: u8,
    /// See [`Record::joints`].
    pub joints: u8,
    /// See [`Record::limits`].
    pub limits: u16,
    /// See [`Record::rejected`].
    pub rejected: u8,
    /// See [`Record::powered`].
    pub powered: u8,
    /// See [`Record::path_rate`].
    pub path_rate: u16,
    /// See [`Record::bucket`].
    pub bucket: u8,
    /// See [`Record::saturated`].
    pub saturated: u8,
    /// See [`Record::code`].
    pub code: [u32; JOINTS],
    /// See [`Record::e1`].
    pub e1: [f32; JOINTS],
    /// See [`Record::dac`].
    pub dac: [u16; JOINTS],
    /// The upper 16 bits of [`Record::adc`].
    pub adc: [i16; JOINTS],
}

impl From<&Record> for Entry {
    fn from(r: &Record) -> Self {
        Self {
            tick: r.tick,
            fault: r.fault,
            mode: r.mode,
            joints: r.joints,
            limits: r.limits,
            rejected: r.rejected,
            powered: r.powered,
            path_rate: r.path_rate,
            bucket: r.bucket,
            saturated: r.saturated,
            code: r.code,
            e1: r.e1,
            dac: r.dac,
            adc: r.adc.map(|code| (code >> 8) as i16),
        }
    }
}

/// One error: a fault that was not there in the tick before.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct ErrorEntry {
    /// Tick of its first sight.
    pub tick: u32,
    /// [`crate::fault::Fault`] number.
    pub fault: u16,
    /// [`crate::fault::Mode`] number at the end of that tick.
    pub mode: u8,
    /// One bit a joint that it names.
    pub joints: u8,
}

/// The whole image.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Image {
    /// [`MAGIC`].
    pub magic: u32,
    /// Boots since the image was first written.
    pub boots: u32,
    /// Fault that ended the last run by a reset, [`crate::fault::Fault`] number; 0 if none did.
    pub crash: u32,
    /// Its fault status register (Armv7-M ARM B3.2.15, CFSR).
    pub crash_status: u32,
    /// Tick that froze the full-rate ring; meaningful while `frozen` is 1.
    pub trigger: u32,
    /// 1 while the full-rate ring stands still.
    pub frozen: u32,
    /// 1 while the thinned ring stands still.
    pub closed: u32,
    /// Entries written so far to the full-rate ring; the next goes to this modulo [`FULL_ENTRIES`].
    pub full_count: u32,
    /// Likewise of the thinned ring, modulo [`THIN_ENTRIES`].
    pub thin_count: u32,
    /// Errors seen so far; the first [`ERRORS`] are kept.
    pub error_count: u32,
    /// Encoder codes of the pose in which the brakes last took over, see [`Self::parked_pose`].
    pub parked: [u32; JOINTS],
    /// The complement of each of them: a pose that was only half written is none.
    pub parked_check: [u32; JOINTS],
    /// See [`ErrorEntry`].
    pub errors: [ErrorEntry; ERRORS],
    /// Full-rate ring.
    pub full: [Entry; FULL_ENTRIES],
    /// Thinned ring.
    pub thin: [Entry; THIN_ENTRIES],
}

/// What the evidence may take of static RAM, bytes.
pub const IMAGE_MAX_BYTES: usize = 12 * 1024;
const _: () = assert!(size_of::<Image>() <= IMAGE_MAX_BYTES);

/// Chunks of an image.
pub const CHUNKS: usize = size_of::<Image>().div_ceil(CHUNK_BYTES);

impl Image {
    /// Whether somebody wrote this, or it is what RAM holds at power-up. A check sum over counts that change with
    /// every tick would not fit them where a crash comes between the two, so magic and ranges have to do: chance
    /// gets them right once in 2^170.
    pub fn is_valid(&self) -> bool {
        let counts = [
            (self.frozen, 2),
            (self.closed, 2),
            (self.full_count, 2 * FULL_ENTRIES as u32),
            (self.thin_count, 2 * THIN_ENTRIES as u32),
        ];
        self.magic == MAGIC && counts.iter().all(|(count, end)| count < end)
    }

    /// Fault that ended the last run by a reset, if one did.
    pub fn crash_fault(&self) -> Option<Fault> {
        let crashes = [Fault::HardFault, Fault::StackOverflow, Fault::TickHung];
        crashes.into_iter().find(|fault| *fault as u32 == self.crash)
    }

    /// Encoder codes of the pose in which the brakes last took over, if one was written whole.
    pub fn parked_pose(&self) -> Option<[u32; JOINTS]> {
        let mut pairs = self.parked.iter().zip(&self.parked_check);
        pairs.all(|(code, check)| *code == !*check).then_some(self.parked)
    }

    /// A piece of the image; `None` past its end.
    pub fn chunk(&self, index: usize) -> Option<[u8; CHUNK_BYTES]> {
        let bytes = bytemuck::bytes_of(self);
        let rest = bytes.get(index.checked_mul(CHUNK_BYTES)?..).filter(|rest| !rest.is_empty())?;
        let mut chunk = [0; CHUNK_BYTES];
        for (slot, byte) in chunk.iter_mut().zip(rest) {
            *slot = *byte;
        }
        Some(chunk)
    }

    /// The full-rate ring, oldest first.
    pub fn full_in_order(&self) -> impl Iterator<Item = &Entry> {
        in_order(&self.full, self.full_count)
    }

    /// The thinned ring, oldest first.
    pub fn thin_in_order(&self) -> impl Iterator<Item = &Entry> {
        in_order(&self.thin, self.thin_count)
    }

    /// The errors kept, in their order.
    pub fn errors_in_order(&self) -> impl Iterator<Item = &ErrorEntry> {
        self.errors.iter().take(self.error_count as usize)
    }
}

fn in_order<const N: usize>(ring: &[Entry; N], count: u32) -> impl Iterator<Item = &Entry> {
    let count = count as usize;
    let oldest = if count < N { 0 } else { count % N };
    let kept = if count < N { count } else { N };
    ring.iter().cycle().skip(oldest).take(kept)
}
