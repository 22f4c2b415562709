//! Judges one cell of the campaign.

use std::path::Path;

use shared::arm::JOINTS;
use shared::command::Command;
use shared::fault::{Mode, Refusal};

use super::bound::bound_m;
use super::case::Case;
use super::measure::{self, Reaction, Track};
use super::pose::Pose;
use super::row::{Drop, Expect, Sign, Variant};
use super::trial::{Ask, Plan, Trial, run};
use super::verdict::{self, TIGHT_M, Verdict, ZERO_M};
use crate::pil::Crash;

/// Runs and judges one cell.
pub fn judge(variant: &Variant, pose: &Pose, seed: u64, image: &Path) -> Verdict {
    if let Some(crash) = variant.crash {
        return broken_down(&Case { variant, pose, seed }, crash, image);
    }
    let seeds = (0..u64::from(variant.runs)).map(|more| seed + more);
    let verdicts = seeds.map(|seed| once(&Case { variant, pose, seed })).collect::<Vec<_>>();
    // The worst of several.
    let fails = verdicts.iter().position(|verdict| !verdict.passes()).unwrap_or(0);
    let drop_m = verdicts.iter().map(|v| v.drop_m).fold(0.0, f64::max);
    Verdict { drop_m, ..verdicts[fails].clone() }
}

fn once(case: &Case<'_>) -> Verdict {
    let plan = case.faulty();
    let verdict = match run(&plan) {
        Ok(trial) => match case.begun(&trial) {
            Some(begun) => measured(case, &plan, &trial, begun),
            None => Verdict::not_run("it did not come as far as the fault"),
        },
        Err(error) => refused(case.variant, &error.to_string()),
    };
    beside_twin(case, verdict)
}

/// The verdict with what the twin did.
fn beside_twin(case: &Case<'_>, mut verdict: Verdict) -> Verdict {
    verdict.twin_tripped = case.twin_trips();
    if verdict.twin_tripped {
        verdict.short.push("the twin tripped".into());
    }
    verdict
}

/// The emulated board breaks down.
fn broken_down(case: &Case<'_>, crash: Crash, image: &Path) -> Verdict {
    match case.broken_down(crash, image) {
        Ok((plan, trial, begun)) => beside_twin(case, measured(case, &plan, &trial, begun)),
        Err(error) => Verdict::not_run(&error.to_string()),
    }
}

fn refused(variant: &Variant, told: &str) -> Verdict {
    let verdict = Verdict { reaction: Reaction::NoConfiguration, ..Verdict::not_run(told) };
    match variant.expect {
        Expect::NoConfiguration => Verdict { short: Vec::new(), ..verdict },
        _ => verdict,
    }
}

/// When things happened in a run.
struct Times {
    /// Step at which the fault begins; of one that shows in arming, that at which arming begins.
    begun: usize,
    /// Step from which on the reaction is due, if it ever is.
    onset: Option<usize>,
    /// Ticks in which it is due.
    limit: u32,
    reaction: Reaction,
    /// Step that shows the reaction.
    reacted: Option<usize>,
    react_ticks: Option<u32>,
    /// The sign came, and after so many ticks.
    shown: bool,
    detect_ticks: Option<u32>,
    /// The fault came about so that something is asked for.
    asked: bool,
}

impl Times {
    fn of(v: &Variant, trial: &Trial, begun: usize) -> Self {
        let due = v.react.iter();
        let due = due.filter_map(|(when, ticks)| Some((when.index(trial, begun)?, *ticks)));
        let due = due.collect::<Vec<_>>();
        let observable = v.observable.index(trial, begun);
        let onset = due.iter().map(|(at, _)| *at).min();
        let limit =
            onset.and_then(|onset| due.iter().map(|(at, t)| trial.ticks(onset, *at) - 1 + t).min());
        let longest = v.react.iter().map(|(_, ticks)| *ticks).max();
        let begun = if v.expect == Expect::NoGo { armed(trial).unwrap_or(begun) } else { begun };
        let (reaction, reacted) = match v.expect {
            Expect::NoArm if trial.start.is_none() => (Reaction::NoArm, None),
            _ => measure::reaction(trial, begun),
        };
        let sign = measure::sign(trial, begun, v.sign);
        let ticks = |from: Option<usize>, to: Option<usize>| {
            let (from, to) = (from?, to?);
            Some(if to < from { 0 } else { trial.ticks(from, to) })
        };
        Self {
            begun,
            onset,
            limit: limit.or(longest).unwrap_or(0),
            reaction,
            reacted,
            react_ticks: ticks(onset, reacted),
            shown: sign.is_some(),
            detect_ticks: ticks(observable, sign),
            asked: observable.is_some() && onset.is_some(),
        }
    }
}

/// First step of arming.
fn armed(trial: &Trial) -> Option<usize> {
    trial.frames.iter().position(|f| f.record.mode == Mode::Arming as u8)
}

fn measured(case: &Case<'_>, plan: &Plan, trial: &Trial, begun: usize) -> Verdict {
    let v = case.variant;
    let times = Times::of(v, trial, begun);
    // A stop before the fault had come about counts from itself.
    let from = times.onset.into_iter().chain(times.reacted).min().unwrap_or(begun);
    let reference = case.reference(trial, begun, from, times.reaction != Reaction::None);
    let drop_m = measure::drop_m(trial, begun.min(from), &reference, v.by_ticks);
    let limp = !matches!(times.reaction, Reaction::None | Reaction::Ss1);
    let bound_m = match v.drop {
        Drop::Zero => ZERO_M,
        Drop::Bound(acting) if limp => {
            bound_m(trial, from, times.limit, acting, &plan.scenario, &reference).max(ZERO_M)
        }
        Drop::Tight | Drop::Bound(_) => TIGHT_M,
    };
    let complaints = [
        of_sign(v, &times),
        of_reaction(v, &times, trial),
        of_time(v, &times),
        of_expectation(v, &times, trial),
        of_drop(drop_m, bound_m),
        of_distance(v, trial, begun.min(from), &reference),
        of_motion(v, &times, trial),
        v.check.and_then(|check| check(trial, from)),
    ];
    Verdict {
        reaction: times.reaction,
        detect_ticks: times.detect_ticks,
        react_ticks: times.react_ticks,
        drop_m,
        bound_m,
        twin_tripped: false,
        fault: measure::reported(trial).0,
        short: complaints.into_iter().flatten().collect(),
        curve: verdict::curve(trial, from, &reference, v.by_ticks),
    }
}

fn of_sign(v: &Variant, times: &Times) -> Option<String> {
    if !times.asked || v.sign == Sign::Nothing {
        return None;
    }
    match times.detect_ticks {
        _ if !times.shown => Some(format!("not noticed: no {}", v.sign)),
        Some(ticks) if ticks > v.detect => {
            Some(format!("noticed after {ticks} ticks, at most {}", v.detect))
        }
        _ => None,
    }
}

/// What may come of a fault.
fn wanted(expect: &Expect, asked: bool) -> &'static [Reaction] {
    match expect {
        Expect::Tolerate | Expect::Harmless | Expect::Refuse(_) => &[Reaction::None],
        Expect::Ss1OrNone => &[Reaction::None, Reaction::Ss1],
        // Where the fault never came about, no reaction is right and any stop is safe.
        _ if !asked => &[Reaction::None, Reaction::Ss1, Reaction::Isolate, Reaction::Sto],
        Expect::Ss1 | Expect::NoGo => &[Reaction::Ss1],
        Expect::Sto => &[Reaction::Sto],
        Expect::Hardware => &[Reaction::Hardware],
        Expect::Isolate(_) => &[Reaction::Isolate],
        Expect::NoArm => &[Reaction::NoArm],
        Expect::NoConfiguration => &[Reaction::NoConfiguration],
        Expect::Lower => &[Reaction::Lower],
    }
}

fn of_reaction(v: &Variant, times: &Times, trial: &Trial) -> Option<String> {
    let wanted = wanted(&v.expect, times.asked);
    let ordered = v.orders.iter().any(|o| matches!(o.ask, Ask::Plain(Command::Stop)));
    let fine = wanted.contains(&times.reaction) || ordered && wanted == [Reaction::None];
    let (fault, _) = measure::reported(trial);
    let told = || {
        let (got, due) = (times.reaction.name(), wanted[0].name());
        format!("reaction {got} ({}), not {due}", fault.name())
    };
    (!fine).then(told)
}

fn of_time(v: &Variant, times: &Times) -> Option<String> {
    let free = matches!(v.expect, Expect::Tolerate | Expect::Harmless | Expect::Refuse(_));
    let late = times.react_ticks.filter(|ticks| *ticks > times.limit);
    let late = late.filter(|_| times.asked && !free);
    late.map(|ticks| format!("reacted after {ticks} ticks, at most {}", times.limit))
}

fn of_expectation(v: &Variant, times: &Times, trial: &Trial) -> Option<String> {
    match &v.expect {
        Expect::Isolate(j) if times.asked && measure::reported(trial).1 >> j & 1 == 0 => {
            Some(format!("joint {} is not named", j + 1))
        }
        Expect::Refuse(reasons) => {
            let told = Refusal::from_number(trial.frames[times.begun].record.refusal);
            let told = told.unwrap_or(Refusal::None);
            let due = reasons[0].name();
            (!reasons.contains(&told)).then(|| format!("refused with {}, not {due}", told.name()))
        }
        Expect::NoArm => {
            let mut frames = trial.frames.iter();
            let released = frames.any(|f| f.pins.brake_release != [false; JOINTS]);
            released.then(|| "a brake was released".into())
        }
        _ => None,
    }
}

fn of_drop(drop_m: f64, bound_m: f64) -> Option<String> {
    let keeps = drop_m <= bound_m;
    let [drop, bound] = [drop_m, bound_m].map(|m| m * 1e3);
    (!keeps).then(|| format!("the tip sank {drop:.3} mm, at most {bound:.3}"))
}

fn of_distance(v: &Variant, trial: &Trial, from: usize, reference: &Track) -> Option<String> {
    if v.drop != Drop::Zero {
        return None;
    }
    let astray_m = measure::astray_m(trial, from, reference, v.by_ticks);
    let keeps = astray_m <= ZERO_M;
    (!keeps).then(|| format!("the tip is {:.3} mm away from its path", astray_m * 1e3))
}

fn of_motion(v: &Variant, times: &Times, trial: &Trial) -> Option<String> {
    let again = times.reacted.is_some_and(|at| measure::moved_again(trial, at));
    let allowed = !v.orders.is_empty() || times.reaction == Reaction::Lower;
    (again && !allowed).then(|| "the arm moved again without a new arm".into())
}

#[cfg(test)]
mod tests;
