//! Records from the tick to the serial port.
//!
//! A record waits in a queue until the idle loop has it noted and sends it as one COBS frame: [`shared::telemetry::Record`],
//! then the core clocks that the tick before took and the torque converter's clocks between the last two
//! ticks, both as 32-bit little-endian words. The line is slower than the ticks, and the operator's too: every
//! [`TICKS_PER_FRAME`]th record is sent.

use core::cell::RefCell;

use cortex_m::interrupt::{self, Mutex};
use heapless::spsc::Queue;
use shared::telemetry::{RECORD_BYTES, Record};

use crate::serial::Serial;

/// 125 frames a second at 2 kHz, 0.35 of the line.
pub const TICKS_PER_FRAME: u32 = 16;

const FRAME_BYTES: usize = RECORD_BYTES + 8;

/// What is sent of one tick.
struct Entry {
    record: Record,
    measured: Measured,
}

/// What the board measures; the controller itself reads no clock.
#[derive(Clone, Copy, Default)]
pub struct Measured {
    /// Core clocks from the interrupt's entry to the end of the last tick.
    pub tick_clocks: u32,
    /// Clocks of the torque converter between the last two ticks: 8.192 MHz over the tick rate, unless one
    /// of the two oscillators is off.
    pub adc_clocks: u32,
}

/// A frame takes the line about six ticks, in which records wait. Its capacity is known wherever it is used, which a [`heapless::spsc::Producer`] hides.
static QUEUE: Mutex<RefCell<Queue<Entry, 16>>> = Mutex::new(RefCell::new(Queue::new()));

/// The tick's end of the queue.
#[derive(Default)]
pub struct Outbox {
    /// Goes with the next record.
    pub measured: Measured,
}

impl Outbox {
    /// Queues a record with what was measured; `false` if there is no room.
    pub fn push(&mut self, record: &Record) -> bool {
        let entry = Entry { record: *record, measured: self.measured };
        interrupt::free(|section| {
            let queue = QUEUE.borrow(section).try_borrow_mut();
            queue.is_ok_and(|mut queue| queue.enqueue(entry).is_ok())
        })
    }
}

/// Hands the oldest record to `note` and sends it if it is its turn; `false` if there is none.
pub fn send_next(serial: &Serial, note: impl FnOnce(&Record)) -> bool {
    let oldest = interrupt::free(|section| {
        let queue = QUEUE.borrow(section).try_borrow_mut();
        queue.ok().and_then(|mut queue| queue.dequeue())
    });
    let Some(Entry { record, measured }) = oldest else {
        return false;
    };
    note(&record);
    if !record.tick.is_multiple_of(TICKS_PER_FRAME) {
        return true;
    }
    let mut frame = [0; FRAME_BYTES];
    let words = [measured.tick_clocks, measured.adc_clocks].map(u32::to_le_bytes);
    let bytes = record.to_bytes().into_iter().chain(words.into_iter().flatten());
    for (slot, byte) in frame.iter_mut().zip(bytes) {
        *slot = byte;
    }
    // A frame that the line does not take is lost; its receiver sees the gap in the ticks.
    let mut encoded = [0; cobs::max_encoding_length(FRAME_BYTES)];
    if let Ok(length) = cobs::try_encode(&frame, &mut encoded) {
        let _ = serial.send(encoded.into_iter().take(length).chain([0]));
    }
    true
}
