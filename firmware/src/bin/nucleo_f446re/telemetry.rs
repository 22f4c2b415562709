//! Records from the tick to the ST-LINK's serial port.
//!
//! A record waits in a queue until the idle loop has it noted and sends it as one COBS frame: [`shared::telemetry::Record`],
//! then the core clocks that the tick before took and the torque converter's clocks between the last two
//! ticks, both as 32-bit little-endian words. The line is slower than the ticks: every
//! [`TICKS_PER_FRAME`]th record is sent.

use core::cell::RefCell;

use cortex_m::interrupt::{self, Mutex};
use heapless::spsc::Queue;
use shared::telemetry::{RECORD_BYTES, Record};
use stm32f4::stm32f446::{Peripherals, usart1};

use crate::clocks::APB1_HZ;
use crate::wait::{TimedOut, until};

/// The ST-LINK's bridge follows any rate that its host asks for; this one is 0.2 % off.
pub const BAUD: u32 = 460_800;
/// 250 frames a second at 2 kHz, 0.7 of the line.
pub const TICKS_PER_FRAME: u32 = 8;

/// A byte takes 22 us; this is twice that.
const BYTE_POLLS: u32 = 750;
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

/// The serial port.
pub struct Serial {
    port: &'static usart1::RegisterBlock,
}

impl Serial {
    /// 8 data bits, no parity, one stop bit (RM0390, USART_CR1).
    pub fn start(p: &'static Peripherals) -> Self {
        let port = &p.USART2;
        // 16 times USARTDIV, rounded: mantissa and fraction in one (RM0390 section 25.4.4).
        const DIVIDER: u32 = (APB1_HZ + BAUD / 2) / BAUD;
        let set = const { ((DIVIDER >> 4) as u16, (DIVIDER & 15) as u8) };
        port.brr().write(|w| w.div_mantissa().set(set.0).div_fraction().set(set.1));
        port.cr1().write(|w| w.ue().enabled().te().enabled());
        Self { port }
    }

    /// Hands the oldest record to `note` and sends it if it is its turn; `false` if there is none.
    pub fn send_next(&self, note: impl FnOnce(&Record)) -> bool {
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
            let _ = self.send(encoded.into_iter().take(length).chain([0]));
        }
        true
    }

    /// Sends bytes until the line does not take one.
    pub fn send(&self, mut bytes: impl Iterator<Item = u8>) -> Result<(), TimedOut> {
        bytes.try_for_each(|byte| {
            until(BYTE_POLLS, || self.port.sr().read().txe().bit())?;
            self.port.dr().write(|w| w.dr().set(u16::from(byte)));
            Ok(())
        })
    }
}
