//! Keeps what led to a stop: the last ticks at full rate, frozen at the trigger; a thinned ring that goes on until
//! torque is off; the first errors. Fed with records outside the tick.
//!
//! The image lies in memory that a reset does not clear, so it may hold anything at power-up.

use shared::arm::JOINTS;
use shared::evidence::{
    ERRORS, Entry, ErrorEntry, FULL_ENTRIES, Image, MAGIC, THIN_ENTRIES, THIN_HZ,
};
use shared::fault::{Fault, Mode};
use shared::telemetry::Record;

use crate::controller::Retained;

/// Writes one image.
#[derive(Clone, Copy, Debug)]
pub struct Recorder {
    /// Ticks from one entry of the thinned ring to the next.
    interval: u32,
    /// Fault of the last record.
    last: u16,
    /// The arm was ready since boot: its pose is believed.
    was_ready: bool,
}

impl Recorder {
    /// Takes over what `image` holds, or clears it if nobody wrote it. A run that ended in a crash is closed: it
    /// stopped without a record that says so. Gives what the controller has to know of it.
    #[inline(never)]
    pub fn new(image: &mut Image, tick_hz: u32) -> (Self, Retained) {
        if !image.is_valid() {
            bytemuck::write_zeroes(image);
            image.magic = MAGIC;
        }
        image.boots = image.boots.wrapping_add(1);
        let interval = tick_hz / THIN_HZ;
        let interval = if interval > 0 { interval } else { 1 };
        let retained = Retained { parked: image.parked_pose(), crash: image.crash_fault() };
        let last = retained.crash.map_or(0, |crash| close(image, crash as u16));
        (Self { interval, last, was_ready: false }, retained)
    }

    /// Takes the record of a tick.
    #[inline(never)]
    pub fn note(&mut self, image: &mut Image, record: &Record) {
        if record.mode == Mode::Arming as u8 && image.frozen != 0 {
            clear(image);
        }
        if record.fault != self.last && record.fault != Fault::None as u16 {
            let Record { tick, fault, mode, joints, .. } = *record;
            note_error(image, ErrorEntry { tick, fault, mode, joints });
        }
        self.last = record.fault;
        if image.frozen == 0 {
            put(&mut image.full, &mut image.full_count, record);
            if is_stop(record) {
                (image.frozen, image.trigger) = (1, record.tick);
            }
        }
        if image.closed == 0 && record.tick.is_multiple_of(self.interval) {
            put(&mut image.thin, &mut image.thin_count, record);
        }
        // A brake that slips brings torque back, and the ring goes on.
        image.closed = u32::from(image.frozen != 0 && record.powered & 0b1111 == 0);
        let is_ready = record.mode == Mode::Standby as u8;
        self.was_ready |= is_ready;
        if self.was_ready && (is_ready || record.mode == Mode::Latched as u8) {
            park(image, record.code);
        }
    }
}

/// Freezes what a crash has ended, unless a stop did before; the crash counts as an error of its last tick.
fn close(image: &mut Image, fault: u16) -> u16 {
    let last = (image.full_count as usize).wrapping_sub(1) % FULL_ENTRIES;
    let (tick, mode) = image.full.get(last).map_or((0, 0), |entry| (entry.tick, entry.mode));
    if image.frozen == 0 {
        (image.frozen, image.trigger) = (1, tick);
    }
    image.closed = 1;
    let last = image.errors.get((image.error_count as usize).wrapping_sub(1));
    if last.is_none_or(|error| error.fault != fault) {
        note_error(image, ErrorEntry { tick, fault, mode, joints: 0 });
    }
    fault
}

fn note_error(image: &mut Image, error: ErrorEntry) {
    if let Some(slot) = image.errors.get_mut(image.error_count as usize) {
        *slot = error;
    }
    image.error_count = image.error_count.saturating_add(1);
}

/// Begins anew; boots and the parked pose stay.
fn clear(image: &mut Image) {
    (image.trigger, image.frozen, image.closed) = (0, 0, 0);
    (image.full_count, image.thin_count, image.error_count) = (0, 0, 0);
    (image.crash, image.crash_status) = (0, 0);
}

/// The brakes hold this pose.
fn park(image: &mut Image, codes: [u32; JOINTS]) {
    image.parked = codes;
    image.parked_check = codes.map(|code| !code);
}

/// Whether this record is of an arm that was stopped.
fn is_stop(record: &Record) -> bool {
    const STOPS: [Mode; 5] =
        [Mode::Stopping, Mode::BrakeHold, Mode::TorqueOff, Mode::Latched, Mode::Lowering];
    STOPS.iter().any(|mode| record.mode == *mode as u8)
}

#[inline(never)]
fn put(ring: &mut [Entry], count: &mut u32, record: &Record) {
    let length = ring.len() as u32;
    let place = if *count < length { *count } else { count.wrapping_sub(length) };
    if let Some(slot) = ring.get_mut(place as usize) {
        *slot = Entry::from(record);
    }
    // Once around, so that the count never wraps in the middle of a ring.
    *count = if *count + 1 < 2 * length { *count + 1 } else { length };
}

const _: () = assert!(FULL_ENTRIES > 0 && THIN_ENTRIES > 0 && ERRORS > 0);

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec::Vec;

    use bytemuck::Zeroable;

    use super::*;

    fn record(tick: u32, mode: Mode, fault: Fault) -> Record {
        let powered = if mode == Mode::Latched { 0 } else { 0xFF };
        Record { tick, mode: mode as u8, fault: fault as u16, powered, ..Record::default() }
    }

    /// 1000 ticks of motion, 300 of stopping, then latched.
    fn run(image: &mut Image, tick_hz: u32) {
        let mode = |tick| match tick {
            0..1_000 => (Mode::Moving, Fault::None),
            1_000..1_300 => (Mode::Stopping, Fault::EncoderStuck),
            _ => (Mode::Latched, Fault::EncoderStuck),
        };
        let mut recorder = Recorder::new(image, tick_hz).0;
        for tick in 0..3_000 {
            let (mode, fault) = mode(tick);
            recorder.note(image, &record(tick, mode, fault));
        }
    }

    #[test]
    fn the_full_ring_ends_at_the_trigger_and_the_thin_one_with_torque() {
        let mut image = Image::zeroed();
        run(&mut image, 2_000);
        let full: Vec<u32> = image.full_in_order().map(|e| e.tick).collect();
        assert_eq!(full, (937..=1_000).collect::<Vec<_>>());
        let thin: Vec<u32> = image.thin_in_order().map(|e| e.tick).collect();
        assert_eq!(thin, (0..1_300).step_by(40).collect::<Vec<_>>());
        let errors: Vec<_> = image.errors_in_order().copied().collect();
        let fault = Fault::EncoderStuck as u16;
        assert_eq!(errors, [ErrorEntry { tick: 1_000, fault, mode: 7, joints: 0 }]);
    }

    #[test]
    fn the_thin_ring_goes_on_while_an_arm_is_lowered() {
        let mut image = Image::zeroed();
        run(&mut image, 2_000);
        let mut recorder = Recorder::new(&mut image, 2_000).0;
        for tick in 3_000..4_000 {
            let mode = if tick < 3_600 { Mode::Lowering } else { Mode::Latched };
            recorder.note(&mut image, &record(tick, mode, Fault::BrakeSlipped));
        }
        let late = image.thin_in_order().map(|e| e.tick).filter(|&tick| tick >= 3_000);
        assert_eq!(late.collect::<Vec<_>>(), (3_040..=3_600).step_by(40).collect::<Vec<_>>());
        assert_eq!(image.trigger, 1_000);
    }

    #[test]
    fn a_ring_that_has_gone_round_many_times_is_in_order() {
        let mut image = Image::zeroed();
        let mut recorder = Recorder::new(&mut image, 1_000).0;
        for tick in 0..10_000 {
            recorder.note(&mut image, &record(tick, Mode::Holding, Fault::None));
        }
        let full: Vec<u32> = image.full_in_order().map(|e| e.tick).collect();
        assert_eq!(full, (9_936..10_000).collect::<Vec<_>>());
        let thin: Vec<u32> = image.thin_in_order().map(|e| e.tick).collect();
        assert_eq!(thin, (8_000..10_000).step_by(20).collect::<Vec<_>>());
    }

    #[test]
    fn evidence_survives_a_new_recorder_and_goes_with_the_next_arming() {
        let mut image = Image::zeroed();
        run(&mut image, 2_000);
        let kept = image;
        let mut recorder = Recorder::new(&mut image, 2_000).0;
        recorder.note(&mut image, &record(0, Mode::Boot, Fault::None));
        recorder.note(&mut image, &record(40, Mode::Standby, Fault::None));
        assert_eq!((image.full, image.trigger, image.boots), (kept.full, kept.trigger, 2));
        recorder.note(&mut image, &record(80, Mode::Arming, Fault::None));
        assert_eq!((image.frozen, image.full_count, image.error_count), (0, 1, 0));
    }

    #[test]
    fn a_crash_ends_the_rings_and_is_an_error_until_the_next_arming() {
        let mut image = Image::zeroed();
        let mut recorder = Recorder::new(&mut image, 2_000).0;
        for tick in 0..500 {
            recorder.note(&mut image, &record(tick, Mode::Moving, Fault::None));
        }
        image.crash = Fault::StackOverflow as u32;
        // The second boot finds the same crash, and counts it once.
        for _ in 0..2 {
            let (mut recorder, retained) = Recorder::new(&mut image, 2_000);
            assert_eq!(retained.crash, Some(Fault::StackOverflow));
            for tick in 0..100 {
                recorder.note(&mut image, &record(tick, Mode::Latched, Fault::StackOverflow));
            }
        }
        assert_eq!((image.frozen, image.closed, image.trigger), (1, 1, 499));
        assert_eq!(image.full_in_order().last().map(|e| e.tick), Some(499));
        let fault = Fault::StackOverflow as u16;
        let errors: Vec<_> = image.errors_in_order().copied().collect();
        assert_eq!(errors, [ErrorEntry { tick: 499, fault, mode: 4, joints: 0 }]);
        let mut recorder = Recorder::new(&mut image, 2_000).0;
        recorder.note(&mut image, &record(9, Mode::Arming, Fault::None));
        assert_eq!(Recorder::new(&mut image, 2_000).1.crash, None);
    }

    #[test]
    fn a_pose_is_parked_only_where_it_is_believed_and_written_whole() {
        let mut image = Image::zeroed();
        let mut recorder = Recorder::new(&mut image, 2_000).0;
        let mut note = |mode, code| {
            let record = Record { code: [code; JOINTS], ..record(0, mode, Fault::None) };
            recorder.note(&mut image, &record);
            image.parked_pose()
        };
        assert_eq!(note(Mode::Latched, 1), None);
        assert_eq!(note(Mode::Boot, 2), None);
        assert_eq!(note(Mode::Standby, 3), Some([3; JOINTS]));
        assert_eq!(note(Mode::Holding, 4), Some([3; JOINTS]));
        assert_eq!(note(Mode::Latched, 5), Some([5; JOINTS]));
        assert_eq!(Recorder::new(&mut image, 2_000).1.parked, Some([5; JOINTS]));
        image.parked[2] = 6;
        assert_eq!(Recorder::new(&mut image, 2_000).1.parked, None);
    }

    #[test]
    fn garbage_at_power_up_is_cleared_and_no_count_leads_outside() {
        let mut image = Image::zeroed();
        bytemuck::bytes_of_mut(&mut image).fill(0xA5);
        image.magic = MAGIC;
        run(&mut image, 1_000);
        assert_eq!((image.boots, image.full_count), (1, FULL_ENTRIES as u32 + 1_001 % 64));
        image.full_count = 2 * FULL_ENTRIES as u32;
        Recorder::new(&mut image, 1_000);
        assert_eq!((image.magic, image.boots, image.full_count), (MAGIC, 1, 0));
    }

    #[test]
    fn chunks_make_up_the_image() {
        let mut image = Image::zeroed();
        run(&mut image, 8_000);
        let chunks: Vec<u8> =
            (0..shared::evidence::CHUNKS).flat_map(|i| image.chunk(i).unwrap()).collect();
        let bytes = bytemuck::bytes_of(&image);
        assert_eq!(&chunks[..bytes.len()], bytes);
        assert_eq!(image.chunk(shared::evidence::CHUNKS), None);
    }
}
