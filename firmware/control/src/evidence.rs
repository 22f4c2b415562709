//! Keeps what led to a stop: the last ticks at full rate, frozen at the trigger; a thinned ring that goes on until
//! torque is off; the first errors. Fed with records outside the tick.
//!
//! The image lies in memory that a reset does not clear, so it may hold anything at power-up.

use bytemuck::Zeroable;
use shared::evidence::{
    CHUNK_BYTES, ERRORS, Entry, ErrorEntry, FULL_ENTRIES, Image, MAGIC, THIN_ENTRIES, THIN_HZ,
};
use shared::fault::{Fault, Mode};
use shared::telemetry::Record;

/// Writes one image.
pub struct Recorder<'a> {
    image: &'a mut Image,
    /// Ticks from one entry of the thinned ring to the next.
    interval: u32,
    /// Fault of the last record.
    last: u16,
}

impl<'a> Recorder<'a> {
    /// Takes over what `image` holds, or clears it if it was never written.
    pub fn new(image: &'a mut Image, tick_hz: u32) -> Self {
        if image.magic != MAGIC {
            *image = Image::zeroed();
            image.magic = MAGIC;
        }
        image.boots = image.boots.wrapping_add(1);
        let interval = tick_hz / THIN_HZ;
        Self { image, interval: if interval > 0 { interval } else { 1 }, last: 0 }
    }

    /// Takes the record of a tick.
    pub fn note(&mut self, record: &Record) {
        let arms = record.mode == Mode::Arming as u8;
        if arms && self.image.frozen != 0 {
            self.clear();
        }
        let news = record.fault != self.last && record.fault != Fault::None as u16;
        self.last = record.fault;
        if news {
            self.note_error(record);
        }
        if self.image.frozen == 0 {
            put(&mut self.image.full, &mut self.image.full_count, record);
            if is_stop(record) {
                (self.image.frozen, self.image.trigger) = (1, record.tick);
            }
        }
        if self.image.closed == 0 && record.tick.is_multiple_of(self.interval) {
            put(&mut self.image.thin, &mut self.image.thin_count, record);
        }
        if self.image.frozen != 0 && record.powered & 0b1111 == 0 {
            self.image.closed = 1;
        }
    }

    /// A piece of the image for reading back.
    pub fn chunk(&self, index: usize) -> Option<[u8; CHUNK_BYTES]> {
        self.image.chunk(index)
    }

    /// The image itself.
    pub fn image(&self) -> &Image {
        self.image
    }

    fn note_error(&mut self, record: &Record) {
        let Record { tick, fault, mode, joints, .. } = *record;
        if let Some(slot) = self.image.errors.get_mut(self.image.error_count as usize) {
            *slot = ErrorEntry { tick, fault, mode, joints };
        }
        self.image.error_count = self.image.error_count.saturating_add(1);
    }

    /// Begins anew; boots and the last crash stay.
    fn clear(&mut self) {
        let image = &mut *self.image;
        (image.trigger, image.frozen, image.closed) = (0, 0, 0);
        (image.full_count, image.thin_count, image.error_count) = (0, 0, 0);
        (image.crash, image.crash_status) = (0, 0);
    }
}

/// Whether this record is of an arm that was stopped.
fn is_stop(record: &Record) -> bool {
    const STOPS: [Mode; 5] =
        [Mode::Stopping, Mode::BrakeHold, Mode::TorqueOff, Mode::Latched, Mode::Lowering];
    STOPS.iter().any(|mode| record.mode == *mode as u8)
}

fn put<const N: usize>(ring: &mut [Entry; N], count: &mut u32, record: &Record) {
    if let Some(slot) = ring.get_mut(*count as usize % N) {
        *slot = Entry::from(record);
    }
    // Once around, so that the count never wraps in the middle of a ring.
    *count = if *count as usize + 1 < 2 * N { *count + 1 } else { N as u32 };
}

const _: () = assert!(FULL_ENTRIES > 0 && THIN_ENTRIES > 0 && ERRORS > 0);

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec::Vec;

    use super::*;

    fn record(tick: u32, mode: Mode, fault: Fault) -> Record {
        let powered = if mode == Mode::Latched { 0 } else { 0xFF };
        Record { tick, mode: mode as u8, fault: fault as u16, powered, ..Record::default() }
    }

    /// 1000 ticks of motion, 300 of stopping, then latched.
    fn run(recorder: &mut Recorder<'_>) {
        let mode = |tick| match tick {
            0..1_000 => (Mode::Moving, Fault::None),
            1_000..1_300 => (Mode::Stopping, Fault::EncoderStuck),
            _ => (Mode::Latched, Fault::EncoderStuck),
        };
        for tick in 0..3_000 {
            let (mode, fault) = mode(tick);
            recorder.note(&record(tick, mode, fault));
        }
    }

    #[test]
    fn the_full_ring_ends_at_the_trigger_and_the_thin_one_with_torque() {
        let mut image = Image::zeroed();
        let mut recorder = Recorder::new(&mut image, 2_000);
        run(&mut recorder);
        let full: Vec<u32> = image.full_in_order().map(|e| e.tick).collect();
        assert_eq!(full, (937..=1_000).collect::<Vec<_>>());
        let thin: Vec<u32> = image.thin_in_order().map(|e| e.tick).collect();
        assert_eq!(thin, (0..1_300).step_by(40).collect::<Vec<_>>());
        let errors: Vec<_> = image.errors_in_order().copied().collect();
        let fault = Fault::EncoderStuck as u16;
        assert_eq!(errors, [ErrorEntry { tick: 1_000, fault, mode: 7, joints: 0 }]);
    }

    #[test]
    fn evidence_survives_a_new_recorder_and_goes_with_the_next_arming() {
        let mut image = Image::zeroed();
        run(&mut Recorder::new(&mut image, 2_000));
        let kept = image;
        let mut recorder = Recorder::new(&mut image, 2_000);
        recorder.note(&record(0, Mode::Boot, Fault::None));
        recorder.note(&record(40, Mode::Standby, Fault::None));
        assert_eq!((image.full, image.trigger, image.boots), (kept.full, kept.trigger, 2));
        let mut recorder = Recorder::new(&mut image, 2_000);
        recorder.note(&record(80, Mode::Arming, Fault::None));
        assert_eq!((image.frozen, image.full_count, image.error_count), (0, 1, 0));
    }

    #[test]
    fn garbage_at_power_up_is_cleared_and_no_count_leads_outside() {
        let mut image = Image::zeroed();
        bytemuck::bytes_of_mut(&mut image).fill(0xA5);
        image.magic = MAGIC;
        run(&mut Recorder::new(&mut image, 1_000));
        bytemuck::bytes_of_mut(&mut image).fill(0xA5);
        Recorder::new(&mut image, 1_000);
        assert_eq!((image.magic, image.boots, image.full_count), (MAGIC, 1, 0));
    }

    #[test]
    fn chunks_make_up_the_image() {
        let mut image = Image::zeroed();
        run(&mut Recorder::new(&mut image, 8_000));
        let chunks: Vec<u8> =
            (0..shared::evidence::CHUNKS).flat_map(|i| image.chunk(i).unwrap()).collect();
        let bytes = bytemuck::bytes_of(&image);
        assert_eq!(&chunks[..bytes.len()], bytes);
        assert_eq!(image.chunk(shared::evidence::CHUNKS), None);
    }
}
