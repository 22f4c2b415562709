//! From which tick on a fault's condition is complete and can be observed, by what the harness knows.

use firmware::config::{Gains, Safety};
use shared::arm::{JOINTS, REFERENCE};
use shared::wire::biss_c::LATCH_DELAY_S;

use super::measure;
use super::trial::{TICK_HZ, TICK_S, Trial};
use super::witness::ADC;
use crate::session::Frame;

/// When something is the case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Condition {
    /// The fault has begun.
    Begun,
    /// So many ticks after that.
    After(u32),
    /// So many seconds after that.
    Later(f64),
    /// It has begun, whether the controller ticks or not.
    BegunAnyhow,
    /// The loss bucket of the device with this index is full.
    BucketFull(usize),
    /// The code of a joint's encoder has stood still over the motion of [`STILL_COUNTS`]; so many ticks more.
    Still(usize, u32),
    /// Codes of a joint's encoder were wrong three times in ten ticks.
    Doubtful(usize),
    /// So many ticks came late.
    Late(u32),
    /// A drive gives another torque than it is told for as long as the torque converter's filter takes.
    TorqueWrong(usize),
    /// A drive is told to give all the torque that it may.
    TorqueAtLimit,
    /// A joint is further from its set-point than it may be for long.
    Astray,
    /// A joint has moved by this much, rad or m.
    Moved(usize, f64),
    /// The brakes were told to open this long ago, s.
    Released(f64),
    /// All brakes have reported open for this long, s.
    Opened(f64),
    /// A disturbance estimate is at its bound.
    AdaptationBound,
    /// Never.
    Never,
}

/// Motion over which a code must not stand still, counts.
const STILL_COUNTS: f64 = 8.0;
/// Quantisation of code and model, counts.
const NOISE_COUNTS: f64 = 2.0;
/// Between the latches of two encoders, s.
const SKEW_S: f64 = 10e-6;

impl Condition {
    /// Index of the first step at whose entry it is the case; the fault began at step `begun`.
    pub fn index(self, trial: &Trial, begun: usize) -> Option<usize> {
        let frames = &trial.frames;
        let ticked = |from: usize| trial.ticked_from(from);
        match self {
            Self::Begun => ticked(begun),
            Self::After(ticks) => ticked(begun + ticks as usize),
            Self::Later(s) => {
                let due_s = frames[begun].true_s + s - 0.1 * TICK_S;
                ticked((begun..frames.len()).find(|i| frames[*i].true_s >= due_s)?)
            }
            Self::BegunAnyhow => Some(begun),
            Self::BucketFull(device) => bucket_full(trial, begun, device),
            Self::Still(j, more) => ticked(still(trial, begun, j)? + more as usize),
            Self::Doubtful(j) => doubtful(trial, begun, j),
            Self::Late(count) => late(trial, begun, count),
            Self::TorqueWrong(j) => torque_wrong(trial, begun, j),
            Self::TorqueAtLimit => (begun..frames.len()).find(|i| torque_at_limit(&frames[*i])),
            Self::Astray => (begun..frames.len()).find(|i| astray(&frames[*i])),
            Self::Moved(j, way) => {
                let from = frames[begun].q[j];
                (begun..frames.len()).find(|i| (frames[*i].q[j] - from).abs() > way)
            }
            Self::Released(s) => {
                lasting(trial, s, |i| frames[i].pins.brake_release == [true; JOINTS])
            }
            Self::Opened(s) => lasting(trial, s, |i| trial.brakes_open[i] == [true; JOINTS]),
            Self::AdaptationBound => {
                let full = |i: &usize| {
                    let learnt = frames[*i].record.d_hat.iter().zip(Gains::DEFAULT.d_max);
                    learnt.into_iter().any(|(d, bound)| d.abs() >= bound)
                };
                (begun..frames.len()).find(full)
            }
            Self::Never => None,
        }
    }
}

/// First step that comes `s` after the first one at which something is so.
fn lasting(trial: &Trial, s: f64, so: impl Fn(usize) -> bool) -> Option<usize> {
    let first = (0..trial.frames.len()).find(|i| so(*i))?;
    trial.ticked_from(first + (s * f64::from(TICK_HZ)).round() as usize)
}

/// Leaky bucket: a loss adds two, a good sample takes one, six are too many.
fn bucket_full(trial: &Trial, begun: usize, device: usize) -> Option<usize> {
    let mut level = 0u32;
    (begun..trial.frames.len()).filter(|i| trial.frames[*i].ticked).find(|i| {
        level = if is_lost(trial, *i, device) { level + 2 } else { level.saturating_sub(1) };
        level >= 6
    })
}

fn is_lost(trial: &Trial, i: usize, device: usize) -> bool {
    let seen = &trial.seen[i];
    let lost = seen.lost >> device & 1 != 0;
    match device {
        ADC => lost || seen.torque.is_none(),
        j if j < JOINTS => lost || seen.codes[j].is_none(),
        _ => lost,
    }
}

/// The code that an encoder should have given, counts.
fn true_code(trial: &Trial, i: usize, j: usize) -> f64 {
    let (frame, encoder) = (&trial.frames[i], &REFERENCE.encoders[j]);
    let latch_s = LATCH_DELAY_S + j as f64 * SKEW_S;
    (frame.q[j] + frame.qd[j] * latch_s - encoder.zero) / encoder.lsb
}

fn still(trial: &Trial, begun: usize, j: usize) -> Option<usize> {
    let code = |i: usize| trial.seen[i].codes[j].map(f64::from);
    let mut last = (code(begun.checked_sub(1)?)?, true_code(trial, begun - 1, j));
    for i in (begun..trial.frames.len()).filter(|i| trial.frames[*i].ticked) {
        let (now, place) = (code(i)?, true_code(trial, i, j));
        if (now - last.0).abs() > 1.0 {
            last = (now, place);
        } else if (place - last.1).abs() > STILL_COUNTS {
            return Some(i);
        }
    }
    None
}

/// A code is wrong that is further off than what must not stand still, noise, and the way that a load unknown to the
/// model can move the joint in one tick.
fn doubtful(trial: &Trial, begun: usize, j: usize) -> Option<usize> {
    let unforeseen = f64::from(Safety::REFERENCE.unforeseen[j]);
    let way_counts = unforeseen * TICK_S * TICK_S / REFERENCE.encoders[j].lsb;
    let window = STILL_COUNTS + NOISE_COUNTS + way_counts;
    let wrong = |i: &usize| {
        let code = trial.seen[*i].codes[j].map(f64::from);
        code.is_some_and(|code| (code - true_code(trial, *i, j)).abs() > window)
    };
    let all = (begun..trial.frames.len()).filter(wrong).collect::<Vec<_>>();
    all.windows(3).find(|three| three[2] - three[0] < 10).map(|three| three[2])
}

fn late(trial: &Trial, begun: usize, count: u32) -> Option<usize> {
    let ticked = (begun.saturating_sub(1)..trial.frames.len()).filter(|i| trial.frames[*i].ticked);
    let ticked = ticked.collect::<Vec<_>>();
    let gap = |pair: &&[usize]| trial.frames[pair[1]].true_s - trial.frames[pair[0]].true_s;
    let late = ticked.windows(2).filter(|pair| gap(pair) > 1.1 * TICK_S).nth(count as usize - 1);
    late.map(|pair| pair[1])
}

/// The torque is off by more than what counts as wrong. The converter shows in a tick what acted in the step before it.
fn torque_wrong(trial: &Trial, begun: usize, j: usize) -> Option<usize> {
    let torque_wrong = f64::from(Safety::REFERENCE.torque_wrong[j]);
    let wrong = |i: usize| {
        let (frame, before) = (&trial.frames[i], &trial.frames[i - 1]);
        let told = REFERENCE.commanded(j, before.record.dac[j]);
        (frame.torque[j] - told).abs() > torque_wrong
    };
    let stopped = measure::first_stop(trial, begun).unwrap_or(trial.frames.len());
    // The converter's filter does not show one that comes and goes.
    let lasts = |first: &usize| (*first..stopped.min(first + FILTER_TICKS)).all(wrong);
    trial.ticked_from((begun..stopped).find(lasts)? + 1)
}

fn torque_at_limit(frame: &Frame) -> bool {
    let told = |j: usize| REFERENCE.commanded(j, frame.record.dac[j]);
    (0..JOINTS).any(|j| told(j).abs() >= REFERENCE.limits[j].tau_max)
}

fn astray(frame: &Frame) -> bool {
    let wanted = measure::set_point(frame);
    let off = |j: usize| (frame.q[j] - wanted[j]).abs();
    (0..JOINTS).any(|j| off(j) > f64::from(Safety::REFERENCE.tracking[j]))
}

/// Ticks that the torque converter's filter takes.
const FILTER_TICKS: usize = 3;

#[cfg(test)]
mod tests;
