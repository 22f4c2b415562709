//! One cell of the campaign: a variant in a pose, beside its twin and the run that it is measured against.

use shared::arm::JOINTS;
use shared::fault::{Fault, Mode, Refusal};

use super::bound::bound_m;
use super::measure::{self, Reaction, Track};
use super::pose::{PATH_S, Pose};
use super::row::{Acting, Drop, Expect, Sign, Variant};
use super::trial::{Ask, Order, Plan, Trial, run};
use crate::session::Event;
use shared::command::Command;

/// What a cell showed.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// What was done.
    pub reaction: Reaction,
    /// Ticks to the sign, if there had to be one and it came.
    pub detect_ticks: Option<u32>,
    /// Ticks to the reaction.
    pub react_ticks: Option<u32>,
    /// How far the tip sank, m.
    pub drop_m: f64,
    /// How far it might, m.
    pub bound_m: f64,
    /// The twin was stopped.
    pub twin_tripped: bool,
    /// The fault that was reported, and the joints that it names.
    pub fault: (Fault, u8),
    /// What fell short, each as a sentence.
    pub short: Vec<String>,
    /// Sinking of the tip and path rate over time from shortly before the fault on, for the picture.
    pub curve: Vec<(f64, f64, f64)>,
}

impl Verdict {
    /// Whether nothing fell short.
    pub fn passes(&self) -> bool {
        self.short.is_empty()
    }
}

const TIGHT_M: f64 = 5e-3;
const ZERO_M: f64 = 1e-4;

/// Runs and judges one cell.
pub fn judge(variant: &Variant, pose: &Pose, seed: u64) -> Verdict {
    let seeds = (0..u64::from(variant.runs)).map(|more| seed + more);
    let verdicts = seeds.map(|seed| Case { variant, pose, seed }.judge()).collect::<Vec<_>>();
    // The worst of several.
    let fails = verdicts.iter().position(|verdict| !verdict.passes()).unwrap_or(0);
    let mut verdict = verdicts[fails].clone();
    verdict.drop_m = verdicts.iter().map(|v| v.drop_m).fold(0.0, f64::max);
    verdict
}

struct Case<'a> {
    variant: &'a Variant,
    pose: &'a Pose,
    seed: u64,
}

impl Case<'_> {
    fn path_s(&self) -> f64 {
        self.variant.path_s.unwrap_or(PATH_S)
    }

    /// When the fault comes, s after the path's start.
    fn middle_s(&self) -> f64 {
        if self.variant.path_s.is_some() { 0.0 } else { 0.5 * PATH_S }
    }

    fn plan(&self, faults: &[crate::faults::Injection], orders: &[&[Order]], whole: bool) -> Plan {
        let middle_s = self.middle_s();
        let pose = self.variant.pose.as_ref().unwrap_or(self.pose);
        let mut scenario = pose.scenario(self.path_s(), self.seed);
        scenario.faults = faults.iter().map(|one| one.at(one.at_s + middle_s)).collect();
        let mut orders = orders.concat();
        orders.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
        for order in &mut orders {
            order.at_s += middle_s;
        }
        Plan { scenario, orders, whole }
    }

    fn judge(&self) -> Verdict {
        let v = self.variant;
        let stops = matches!(
            v.expect,
            Expect::Ss1 | Expect::Sto | Expect::Hardware | Expect::Isolate(_) | Expect::Lower
        );
        let plan = self.plan(&v.faults, &[&v.orders, &v.wrong], !stops);
        match run(&plan) {
            Ok(trial) => self.judge_trial(&plan, &trial),
            Err(error) => self.judge_refusal(error.to_string()),
        }
    }

    fn judge_refusal(&self, told: String) -> Verdict {
        let wanted = self.variant.expect == Expect::NoConfiguration;
        let short = if wanted { Vec::new() } else { vec![format!("did not run: {told}")] };
        Verdict {
            reaction: Reaction::NoConfiguration,
            detect_ticks: None,
            react_ticks: None,
            drop_m: 0.0,
            bound_m: TIGHT_M,
            twin_tripped: self.twin_trips(),
            fault: (Fault::None, 0),
            short,
            curve: Vec::new(),
        }
    }

    fn judge_trial(&self, plan: &Plan, trial: &Trial) -> Verdict {
        let v = self.variant;
        let mut short = Vec::new();
        let Some(begun) = self.begun(trial) else {
            return self.not_begun(trial);
        };
        let observable = v.observable.index(trial, begun);
        let due = v
            .react
            .iter()
            .filter_map(|(condition, ticks)| Some((condition.index(trial, begun)?, *ticks)));
        let due = due.collect::<Vec<_>>();
        let onset = due.iter().map(|(index, _)| *index).min();
        let limit = onset.and_then(|onset| {
            due.iter().map(|(i, ticks)| trial.ticks(onset, *i) - 1 + ticks).min()
        });

        let begun = if v.expect == Expect::NoGo { armed(trial).unwrap_or(begun) } else { begun };
        let never_armed = trial.start.is_none() && matches!(v.expect, Expect::NoArm);
        let (reaction, reacted) =
            if never_armed { (Reaction::NoArm, None) } else { measure::reaction(trial, begun) };
        let react_ticks = onset.and_then(|onset| {
            reacted.map(|at| if at < onset { 0 } else { trial.ticks(onset, at) })
        });
        let sign = measure::sign(trial, begun, v.sign);
        let detect_ticks = observable
            .and_then(|from| sign.map(|at| if at < from { 0 } else { trial.ticks(from, at) }));

        // A condition that never came about asks for nothing.
        let asked = observable.is_some() && onset.is_some();
        self.judge_sign(asked, sign.is_some(), detect_ticks, &mut short);
        self.judge_reaction(asked, reaction, react_ticks.zip(limit), trial, begun, &mut short);
        let from = onset.unwrap_or(begun);
        let reference = self.reference(trial, begun, from, reaction);
        let drop_m = measure::drop_m(trial, begun.min(from), &reference, v.by_ticks);
        let bound_m = match v.drop {
            Drop::Tight => TIGHT_M,
            Drop::Zero => ZERO_M,
            Drop::Bound(_) if reaction == Reaction::None => TIGHT_M,
            Drop::Bound(acting) => {
                self.bound(plan, trial, from, limit.unwrap_or(0), acting, &reference)
            }
        };
        if !(drop_m <= bound_m) {
            short.push(format!(
                "the tip sank {:.3} mm, at most {:.3}",
                drop_m * 1e3,
                bound_m * 1e3
            ));
        }
        let again = reacted.is_some_and(|at| measure::moved_again(trial, at));
        if v.orders.is_empty() && again && reaction != Reaction::Lower {
            short.push("the arm moved again without a new arm".into());
        }
        let astray_m = measure::astray_m(trial, begun.min(from), &reference, v.by_ticks);
        if v.drop == Drop::Zero && !(astray_m <= ZERO_M) {
            short.push(format!("the tip is {:.3} mm away from its path", astray_m * 1e3));
        }
        if let Some(complaint) = v.check.and_then(|check| check(trial, from)) {
            short.push(complaint);
        }
        let twin_tripped = self.twin_trips();
        if twin_tripped {
            short.push("the twin tripped".into());
        }
        let curve = curve(trial, from, &reference, v.by_ticks);
        Verdict {
            reaction,
            detect_ticks,
            react_ticks,
            drop_m,
            bound_m,
            twin_tripped,
            fault: measure::reported(trial),
            short,
            curve,
        }
    }

    /// Step at which the fault begins: that of the first injection, or of the first wrong order.
    fn begun(&self, trial: &Trial) -> Option<usize> {
        let middle_s = self.middle_s();
        let began = trial.events.iter().find(|(_, event)| matches!(event, Event::Began(_)));
        match began {
            Some((true_s, _)) => {
                let early = |f: &crate::session::Frame| f.true_s < true_s - 1e-6;
                Some(trial.frames.partition_point(early).clamp(1, trial.frames.len() - 1))
            }
            None if !self.variant.faults.is_empty() => None,
            None => {
                let first =
                    self.variant.wrong.iter().map(|order| order.at_s).fold(f64::INFINITY, f64::min);
                trial.start?;
                let at_s = if first.is_finite() { first } else { 0.0 };
                Some(trial.index_at(middle_s + at_s))
            }
        }
    }

    fn not_begun(&self, trial: &Trial) -> Verdict {
        Verdict {
            reaction: Reaction::None,
            detect_ticks: None,
            react_ticks: None,
            drop_m: 0.0,
            bound_m: TIGHT_M,
            twin_tripped: self.twin_trips(),
            fault: measure::reported(trial),
            short: vec!["the run did not come as far as the fault".into()],
            curve: Vec::new(),
        }
    }

    fn judge_sign(&self, asked: bool, shown: bool, ticks: Option<u32>, short: &mut Vec<String>) {
        let v = self.variant;
        if !asked || v.sign == Sign::Nothing || v.expect == Expect::NoConfiguration {
            return;
        }
        match ticks {
            Some(ticks) if ticks <= v.detect => {}
            Some(ticks) => short.push(format!("noticed after {ticks} ticks, at most {}", v.detect)),
            None if !shown => short.push(format!("not noticed: no {}", told(v.sign))),
            None => {}
        }
    }

    fn judge_reaction(
        &self,
        asked: bool,
        reaction: Reaction,
        ticks: Option<(u32, u32)>,
        trial: &Trial,
        begun: usize,
        short: &mut Vec<String>,
    ) {
        let (named, joints) = measure::reported(trial);
        let wanted: &[Reaction] = match &self.variant.expect {
            Expect::Tolerate | Expect::Harmless | Expect::Refuse(_) => &[Reaction::None],
            _ if !asked => &[Reaction::None, Reaction::Ss1, Reaction::Isolate, Reaction::Sto],
            Expect::Ss1 => &[Reaction::Ss1],
            Expect::Sto => &[Reaction::Sto],
            Expect::Hardware => &[Reaction::Hardware],
            Expect::Isolate(_) => &[Reaction::Isolate],
            Expect::Ss1OrNone => &[Reaction::None, Reaction::Ss1],
            Expect::NoArm => &[Reaction::NoArm],
            Expect::NoConfiguration => &[Reaction::NoConfiguration],
            Expect::NoGo => &[Reaction::Ss1],
            Expect::Lower => &[Reaction::Lower],
        };
        let orders_stop =
            self.variant.orders.iter().any(|order| matches!(order.ask, Ask::Plain(Command::Stop)));
        if !wanted.contains(&reaction) && !(orders_stop && wanted == [Reaction::None]) {
            short.push(format!(
                "reaction {} ({}), not {}",
                reaction.name(),
                named.name(),
                wanted[0].name()
            ));
        }
        if let Some((ticks, limit)) = ticks
            && asked
            && !matches!(
                self.variant.expect,
                Expect::Tolerate | Expect::Harmless | Expect::Refuse(_)
            )
            && ticks > limit
        {
            short.push(format!("reacted after {ticks} ticks, at most {limit}"));
        }
        match &self.variant.expect {
            Expect::Isolate(j) if asked && joints >> j & 1 == 0 => {
                short.push(format!("joint {} is not named", j + 1));
            }
            Expect::Refuse(reasons) => self.judge_order(reasons, trial, begun, short),
            Expect::NoArm if released(trial, 0) => short.push("a brake was released".into()),
            _ => {}
        }
    }

    fn judge_order(
        &self,
        reasons: &[Refusal],
        trial: &Trial,
        begun: usize,
        short: &mut Vec<String>,
    ) {
        let told = trial.frames[begun].record.refusal;
        let told = Refusal::from_number(told).unwrap_or(Refusal::None);
        if !reasons.contains(&told) {
            short.push(format!("refused with {}, not {}", told.name(), reasons[0].name()));
        }
    }

    /// The tip without the fault: along the path, or stopped along it where the condition was complete.
    fn reference(&self, trial: &Trial, begun: usize, from: usize, reaction: Reaction) -> Track {
        let v = self.variant;
        if trial.start.is_none_or(|start| begun < start) {
            return Track::at_rest(trial.frames[0].tip_m);
        }
        if v.expect == Expect::Lower {
            return Track::at_rest(trial.frames[begun].tip_m);
        }
        let goes_on = matches!(reaction, Reaction::None) || !v.orders.is_empty();
        let at_s = trial.frames[from].true_s - trial.start_s.unwrap_or(0.0) - self.middle_s();
        let stop = [Order { at_s, ask: Ask::Plain(Command::Stop) }];
        let orders: &[Order] = if goes_on { &[] } else { &stop };
        match run(&self.plan(&[], &[&v.orders, orders], true)) {
            Ok(run) => Track::of(&run),
            Err(_) => Track::at_rest([f64::NAN; 3]),
        }
    }

    fn bound(
        &self,
        plan: &Plan,
        trial: &Trial,
        from: usize,
        limit: u32,
        acting: Acting,
        reference: &Track,
    ) -> f64 {
        let bound = bound_m(trial, from, limit, acting, &plan.scenario, reference);
        bound.max(ZERO_M)
    }

    /// Whether the twin is stopped, or shows a sign that only the fault may.
    fn twin_trips(&self) -> bool {
        let v = self.variant;
        let plan = self.plan(&v.twin, &[&v.orders], true);
        let Ok(trial) = run(&plan) else { return true };
        let Some(start) = trial.start else { return true };
        let stopped = measure::first_stop(&trial, start).is_some();
        let alarmed = matches!(v.sign, Sign::Limited(_))
            && !v.twin.is_empty()
            && v.expect == Expect::Tolerate
            && measure::sign(&trial, start.max(1), v.sign).is_some();
        (stopped && v.orders.is_empty()) || alarmed
    }
}

/// First step of arming.
fn armed(trial: &Trial) -> Option<usize> {
    trial.frames.iter().position(|f| f.record.mode == Mode::Arming as u8)
}

/// Whether any brake is released at or after step `from`.
fn released(trial: &Trial, from: usize) -> bool {
    trial.frames[from..].iter().any(|f| f.pins.brake_release != [false; JOINTS])
}

fn told(sign: Sign) -> String {
    match sign {
        Sign::Fault(faults) => {
            format!("fault {}", faults.iter().map(|f| f.name()).collect::<Vec<_>>().join(" or "))
        }
        Sign::Rejected(_) => "rejected sample".into(),
        Sign::Limited(limit) => format!("limit {}", limit.name()),
        Sign::Irregular => "count of irregular ticks".into(),
        Sign::Refused => "refusal".into(),
        Sign::Chain => "open safety chain".into(),
        Sign::Nothing => "sign".into(),
    }
}

/// Before the fault, s.
const BEFORE_S: f64 = 0.1;
/// Longest stretch of a picture, s.
const SHOWN_S: f64 = 2.0;
/// One point in so many ticks is drawn.
const EVERY: usize = 4;

/// Time since the fault, sinking, path rate.
fn curve(trial: &Trial, from: usize, reference: &Track, by_ticks: bool) -> Vec<(f64, f64, f64)> {
    let first = from.saturating_sub((BEFORE_S / super::trial::TICK_S) as usize);
    let sinking = measure::sinking(trial, first, reference, by_ticks);
    let points = trial.frames[first..].iter().zip(sinking).step_by(EVERY);
    let zero_s = trial.frames[from].true_s;
    points
        .map(|(frame, sinking)| {
            let rate =
                f64::from(frame.record.path_rate) / f64::from(shared::telemetry::PATH_RATE_ONE);
            (frame.true_s - zero_s, sinking, rate)
        })
        .take_while(|(t_s, _, _)| *t_s < SHOWN_S)
        .collect()
}
