//! What a run shows: when the fault was noticed, what the reaction was and when it began, and how far the tip sank.

use shared::arm::{JOINTS, REFERENCE};
use shared::fault::{Fault, Mode};

use super::row::Sign;
use super::trial::{TICK_S, Trial, is_safe, is_still};
use crate::plant::Model;
use crate::session::Frame;

/// What a controller, or the hardware, did about a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reaction {
    /// Nothing was stopped.
    None,
    /// Stop along the path, brakes, torque off.
    Ss1,
    /// A joint lost its torque at once, the others stopped along the path.
    Isolate,
    /// Torque off and brakes at once.
    Sto,
    /// The hardware did that.
    Hardware,
    /// Torque came back to lower the arm.
    Lower,
    /// The arm was never armed.
    NoArm,
    /// The configuration was refused.
    NoConfiguration,
}

impl Reaction {
    /// As tables call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Ss1 => "SS1",
            Self::Isolate => "isolate",
            Self::Sto => "STO",
            Self::Hardware => "hardware STO",
            Self::Lower => "lowering",
            Self::NoArm => "no arm",
            Self::NoConfiguration => "configuration refused",
        }
    }
}

fn mode(frame: &Frame) -> Option<Mode> {
    Mode::from_number(frame.record.mode)
}

/// Whether any stop shows in this step.
fn stops(frame: &Frame) -> bool {
    let stopped = matches!(
        mode(frame),
        Some(Mode::Stopping | Mode::BrakeHold | Mode::TorqueOff | Mode::Latched | Mode::Lowering)
    );
    stopped || !frame.chain_closed
}

/// First step at or after `from` that shows a stop.
pub fn first_stop(trial: &Trial, from: usize) -> Option<usize> {
    (from..trial.frames.len()).find(|i| stops(&trial.frames[*i]))
}

/// The reaction that begins at or after `from`, and the first step that shows it.
pub fn reaction(trial: &Trial, from: usize) -> (Reaction, Option<usize>) {
    let frames = &trial.frames;
    if let Some(lowers) = (from..frames.len()).find(|i| mode(&frames[*i]) == Some(Mode::Lowering)) {
        return (Reaction::Lower, Some(lowers));
    }
    let Some(first) = first_stop(trial, from) else { return (Reaction::None, None) };
    let frame = &frames[first];
    if !frame.chain_closed && frame.pins.sto {
        return (Reaction::Hardware, Some(first));
    }
    let cut = |frame: &Frame| !frame.pins.sto;
    if cut(frame) && mode(frame) != Some(Mode::Latched) {
        return (Reaction::Sto, Some(first));
    }
    // Torque was cut later although the stop had not brought the arm to rest: as good as at once, and late.
    let rest = frames[first..].iter().take_while(|f| !cut(f)).count();
    let ended = frames.get(first + rest);
    let alone = frame.pins.drive_enable != [true; JOINTS];
    let kind = if alone { Reaction::Isolate } else { Reaction::Ss1 };
    match ended {
        Some(frame) if !is_still(frame) => (Reaction::Sto, Some(first + rest)),
        _ => (kind, Some(first)),
    }
}

/// First step at or after `from` that shows the sign.
pub fn sign(trial: &Trial, from: usize, sign: Sign) -> Option<usize> {
    let counted = trial.frames.get(from.checked_sub(1)?).map_or(0, |f| f.record.irregular);
    let refused = trial.frames[from - 1].record.refusal;
    let shows = |f: &Frame| match sign {
        Sign::Fault(faults) => faults.iter().any(|fault| f.record.fault == *fault as u16),
        Sign::Rejected(device) => f.record.rejected >> device & 1 != 0,
        Sign::Limited(limit) => f.record.limits >> limit as u16 & 1 != 0,
        Sign::Irregular => f.record.irregular != counted,
        Sign::Refused => f.record.refusal != refused,
        Sign::Chain => !f.chain_closed,
        Sign::Nothing => false,
    };
    let ticked = |f: &Frame| f.ticked || sign == Sign::Chain;
    (from..trial.frames.len()).find(|i| ticked(&trial.frames[*i]) && shows(&trial.frames[*i]))
}

/// Places of a tip over time since the path's start, step by step, world axes, m.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    tips: Vec<[f64; 3]>,
}

impl Track {
    /// Of a run without faults in its clock.
    pub fn of(trial: &Trial) -> Self {
        let start = trial.start.unwrap_or(0);
        Self { tips: trial.frames[start..].iter().map(|f| f.tip_m).collect() }
    }

    /// Standing still.
    pub fn at_rest(tip_m: [f64; 3]) -> Self {
        Self { tips: vec![tip_m] }
    }

    /// Place at `t_s`, between two steps on the straight line, m.
    pub fn tip(&self, t_s: f64) -> [f64; 3] {
        let place = (t_s / TICK_S).max(0.0);
        let (i, rest) = (place.floor() as usize, place.fract());
        let last = self.tips.len().saturating_sub(1);
        let at = |i: usize| self.tips.get(i.min(last)).copied().unwrap_or([f64::NAN; 3]);
        let (a, b) = (at(i), at(i + 1));
        std::array::from_fn(|axis| a[axis] + rest * (b[axis] - a[axis]))
    }

    /// Height at `t_s`, m.
    pub fn height(&self, t_s: f64) -> f64 {
        self.tip(t_s)[2]
    }
}

/// Time of step `i` on the reference's scale, s; `by_ticks` compares step with step.
fn time_s(trial: &Trial, i: usize, by_ticks: bool) -> f64 {
    match by_ticks {
        true => i.saturating_sub(trial.start.unwrap_or(0)) as f64 * TICK_S,
        false => trial.frames[i].true_s - trial.start_s.unwrap_or(0.0),
    }
}

/// How far the tip is below `reference` at each step from `from` on, m. An arm that is lowered has a path of its own,
/// and is measured against its end afterwards.
pub fn sinking<'a>(
    trial: &'a Trial,
    from: usize,
    reference: &'a Track,
    by_ticks: bool,
) -> impl Iterator<Item = f64> + 'a {
    let mut lowered = None;
    (from..trial.frames.len()).map(move |i| {
        let frame = &trial.frames[i];
        lowered = wanted_height(frame).or(lowered);
        let height = || reference.height(time_s(trial, i, by_ticks));
        lowered.unwrap_or_else(height) - frame.tip_m[2]
    })
}

/// Longest distance of the tip from `reference`, in any direction, m.
pub fn astray_m(trial: &Trial, from: usize, reference: &Track, by_ticks: bool) -> f64 {
    let distance = |i: usize| {
        let (tip, wanted) = (trial.frames[i].tip_m, reference.tip(time_s(trial, i, by_ticks)));
        tip.iter().zip(wanted).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
    };
    (from..trial.frames.len()).map(distance).fold(0.0, f64::max)
}

/// On its way to the rest pose the tip has a path of its own: that of the set-point.
fn wanted_height(frame: &Frame) -> Option<f64> {
    let lowers = mode(frame) == Some(Mode::Lowering) && frame.pins.brake_release == [true; JOINTS];
    lowers.then(|| Model::new(&REFERENCE).tip(&set_point(frame), &[0.0; JOINTS]).0[2])
}

/// Where the joints are to be, by code and error of the controller's record, rad and m.
pub fn set_point(frame: &Frame) -> [f64; JOINTS] {
    std::array::from_fn(|j| {
        let encoder = &REFERENCE.encoders[j];
        let measured = f64::from(frame.record.code[j]) * encoder.lsb + encoder.zero;
        measured - f64::from(frame.record.e1[j])
    })
}

/// Highest of that, at least 0, m.
pub fn drop_m(trial: &Trial, from: usize, reference: &Track, by_ticks: bool) -> f64 {
    sinking(trial, from, reference, by_ticks).fold(0.0, f64::max)
}

/// Whether the arm moved, or could, after it had come to rest in its brakes at or after step `from`.
pub fn moved_again(trial: &Trial, from: usize) -> bool {
    let rests = |f: &Frame| is_safe(f) && is_still(f);
    let first = (from..trial.frames.len()).find(|i| rests(&trial.frames[*i]));
    first.is_some_and(|first| trial.frames[first..].iter().any(|f| !rests(f)))
}

/// The fault that was reported last, and the joints that it names.
pub fn reported(trial: &Trial) -> (Fault, u8) {
    let last = trial.frames.iter().rev().find(|f| f.record.fault != 0);
    let fault = last.and_then(|f| Fault::from_number(f.record.fault)).unwrap_or(Fault::None);
    (fault, last.map_or(0, |f| f.record.joints))
}

#[cfg(test)]
mod tests;
