//! Plausibility of an encoder's codes: where the next one has to be, and whether they stand still while the
//! set-point moves.
//!
//! The next code is expected at the last one plus the last step plus what the law's acceleration adds to it
//! (`law::Wanted`). What neither command nor model foresees is bounded by an acceleration, so the window is
//! a few counts wide, whatever the speed. A code that stands still is judged by the set-point and never by
//! the observer that it feeds: that one would come to rest with it.

use crate::estimator::{FRACTION_BITS, Observer};
use crate::math::round_to_i32;

/// A code within this of an earlier one has not moved, counts: both may be one off.
const STILL_COUNTS: u32 = 2;
/// Way of the set-point that a code follows at last, counts: [`STILL_COUNTS`], one of rounding, and as much again.
const NEAR_COUNTS: u32 = 6;
const NEAR: u32 = NEAR_COUNTS << FRACTION_BITS;
/// Ticks within which [`MANY`] implausible samples condemn an encoder.
const RECENT_TICKS: u32 = 10;
/// See [`RECENT_TICKS`].
const MANY: usize = 3;

/// History of one encoder's codes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Track {
    /// Last believed code, or where the model has it since.
    pub code: u32,
    /// Counts from tick to tick.
    step: i32,
    /// Code and set-point when the code last moved.
    still: (u32, u32),
    /// Ticks for which the set-point has been further away than then.
    stalled: u32,
    /// Ticks of the last implausible samples.
    rejected: [u32; MANY - 1],
    /// The last code that was off was too far up.
    above: bool,
}

impl Track {
    /// Of an encoder that gave no sample yet.
    pub const NONE: Self =
        Self { code: 0, step: 0, still: (0, 0), stalled: 0, rejected: [0; MANY - 1], above: false };

    /// At rest at `code`.
    pub fn at_rest(code: u32) -> Self {
        Self { code, still: (code, code << FRACTION_BITS), ..Self::default() }
    }

    /// How far `code` is from where it is expected after a regular tick, counts; `acceleration` in word steps a
    /// tick².
    #[inline(always)]
    pub fn distance(&self, code: u32, acceleration: f32) -> i32 {
        code.wrapping_sub(self.code)
            .wrapping_sub(self.step as u32)
            .wrapping_sub(counts(acceleration) as u32) as i32
    }

    /// The same after `ticks` of them.
    pub fn distance_after(&self, code: u32, ticks: f32) -> i32 {
        let way = (self.step as f32 * ticks) as i32;
        code.wrapping_sub(self.code).wrapping_sub(way as u32) as i32
    }

    /// Takes a code that came after a regular tick.
    #[inline(always)]
    pub fn take(&mut self, code: u32) {
        self.step = code.wrapping_sub(self.code) as i32;
        self.code = code;
    }

    /// Takes a code that came after `ticks`.
    pub fn take_after(&mut self, code: u32, ticks: f32) {
        // A step measured over a fraction of a tick would be mostly rounding.
        if ticks > 0.5 {
            let step = code.wrapping_sub(self.code) as i32 as f32 / ticks;
            self.step = step as i32;
        }
        self.code = code;
    }

    /// Goes on by the model where there is no sample to believe.
    pub fn coast(&mut self, ticks: f32, acceleration: f32) {
        self.step = self.step.wrapping_add(counts(acceleration * ticks));
        let way = (self.step as f32 * ticks) as i32;
        self.code = self.code.wrapping_add(way as u32);
    }

    /// Goes on from an estimate.
    pub fn follow(&mut self, estimate: &Observer) {
        self.code = estimate.position >> FRACTION_BITS;
        self.step = counts(estimate.velocity);
    }

    /// The estimate that this history alone gives.
    pub fn observer(&self) -> Observer {
        let words = self.step as f32 * (1 << FRACTION_BITS) as f32;
        Observer { position: self.code << FRACTION_BITS, velocity: words }
    }

    /// Whether `code` stands still and the set-point, a position word, is somewhere else by now.
    #[inline(always)]
    pub fn stands(&mut self, code: u32, set_point: u32) -> bool {
        let (still, since) = self.still;
        if code.wrapping_sub(still).wrapping_add(STILL_COUNTS) > 2 * STILL_COUNTS {
            self.still = (code, set_point);
            self.stalled = 0;
            return false;
        }
        set_point.wrapping_sub(since).wrapping_add(NEAR) > 2 * NEAR
    }

    /// Whether a code that stands has let the set-point get away for more than `ticks`, or by more than `far`, word
    /// steps.
    pub fn is_stuck(&mut self, set_point: u32, far: u32, ticks: u32) -> bool {
        let (still, since) = self.still;
        let way = set_point.wrapping_sub(since);
        let error = |of: u32| (of.wrapping_sub(still << FRACTION_BITS) as i32).unsigned_abs();
        // A joint whose error fades may stand for long; that of a dead encoder grows.
        let grows = error(set_point) > error(since) + NEAR;
        self.stalled = if grows { self.stalled + 1 } else { 0 };
        self.stalled > ticks || way.wrapping_add(far) > 2 * far
    }

    /// The set-point may have moved without the joint so far.
    pub fn excuse(&mut self, set_point: u32) {
        self.still = (self.code, set_point);
        self.stalled = 0;
    }

    /// Takes the side to which a code is off; `true` if it is another than the last time.
    pub fn turns(&mut self, above: bool) -> bool {
        core::mem::replace(&mut self.above, above) != above
    }

    /// Counts an implausible sample; `true` if there have been too many of late.
    pub fn reject(&mut self, tick: u32) -> bool {
        let [last, before] = self.rejected;
        self.rejected = [tick, last];
        // Ticks count from 1 here, so that the zeros of a new history are none.
        before != 0 && tick.wrapping_sub(before) < RECENT_TICKS
    }
}

/// Word steps as counts.
#[inline(always)]
fn counts(words: f32) -> i32 {
    round_to_i32(words * (1.0 / (1 << FRACTION_BITS) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moving() -> Track {
        let mut track = Track::at_rest(1_000);
        track.take(1_500);
        track
    }

    #[test]
    fn a_steady_motion_is_expected_to_go_on() {
        let track = moving();
        assert_eq!(track.distance(2_000, 0.0), 0);
        assert_eq!(track.distance(2_000, 640.0), -10);
        assert_eq!(track.distance(1_500, 0.0), -500);
        assert_eq!(track.distance_after(2_100, 1.2), 0);
    }

    #[test]
    fn coasting_follows_speed_and_acceleration() {
        let mut track = moving();
        track.coast(1.0, 640.0);
        assert_eq!((track.code, track.step), (2_010, 510));
        track.coast(2.0, 0.0);
        assert_eq!(track.code, 3_030);
        assert_eq!(track.observer().velocity, 510.0 * 64.0);
    }

    /// Position word this many counts above 1000.
    fn moved(counts: i32) -> u32 {
        1_000_u32.wrapping_add_signed(counts) << FRACTION_BITS
    }

    #[test]
    fn only_a_code_that_the_set_point_leaves_stands() {
        let mut track = Track::at_rest(1_000);
        assert!(!track.stands(1_001, moved(6)));
        assert!(track.stands(998, moved(7)));
        assert!(track.stands(1_002, moved(-7)));
        assert!(!track.stands(1_003, moved(9)));
        assert!(!track.stands(1_004, moved(15)));
        assert!(track.stands(1_003, moved(16)));
    }

    #[test]
    fn a_code_that_stands_far_behind_or_for_long_is_stuck() {
        let mut track = Track::at_rest(1_000);
        let far = 40 << FRACTION_BITS;
        assert!(!track.is_stuck(moved(40), far, 9));
        assert!(track.is_stuck(moved(41), far, 9));
        assert!(track.is_stuck(moved(-41), far, 9));
        assert!((4..=9).all(|_| !track.is_stuck(moved(7), far, 9)));
        assert!(track.is_stuck(moved(7), far, 9));
        assert!(!track.stands(1_003, moved(7)));
        assert!(!track.is_stuck(moved(14), far, 9));
    }

    #[test]
    fn three_in_ten_ticks_condemn() {
        let mut track = moving();
        assert_eq!([5, 15, 24, 34, 42].map(|tick| track.reject(tick)), [false; 5]);
        assert!(track.reject(43));
        let mut track = moving();
        assert_eq!([1, 5, 10].map(|tick| track.reject(tick)), [false, false, true]);
    }
}
