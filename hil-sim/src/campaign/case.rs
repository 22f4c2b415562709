//! The runs of one cell: with the fault, its twin, and the one that the tip is compared with.

use shared::command::Command;

use std::path::Path;

use super::measure::{self, Track};
use super::pose::{PATH_S, Pose};
use super::row::{Expect, Sign, Variant};
use super::trial::{Ask, Order, Plan, Trial, run};
use crate::faults::Injection;
use crate::pil::{self, Crash, Crashed, PilError};
use crate::session::{Event, Frame};

/// The brakes take a tenth of a second, and the arm stands still for a second, s.
const AFTER_CRASH_S: f64 = 1.5;

/// A variant in a pose with a seed.
#[derive(Clone, Copy)]
pub struct Case<'a> {
    /// The way.
    pub variant: &'a Variant,
    /// The pose.
    pub pose: &'a Pose,
    /// Of everything random.
    pub seed: u64,
}

impl Case<'_> {
    /// When the fault comes, s after the path's start: in the pose, or along a path of its own.
    fn fault_s(&self) -> f64 {
        if self.variant.path_s.is_some() { 0.0 } else { 0.5 * PATH_S }
    }

    fn plan(&self, faults: &[Injection], orders: &[&[Order]], whole: bool) -> Plan {
        let fault_s = self.fault_s();
        let pose = self.variant.pose.as_ref().unwrap_or(self.pose);
        let mut scenario = pose.scenario(self.variant.path_s.unwrap_or(PATH_S), self.seed);
        scenario.faults = faults.iter().map(|one| one.at(one.at_s + fault_s)).collect();
        let mut orders = orders.concat();
        orders.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
        for order in &mut orders {
            order.at_s += fault_s;
        }
        Plan { scenario, orders, whole }
    }

    /// The run with the fault.
    pub fn faulty(&self) -> Plan {
        let v = self.variant;
        let stops = matches!(
            v.expect,
            Expect::Ss1 | Expect::Sto | Expect::Hardware | Expect::Isolate(_) | Expect::Lower
        );
        self.plan(&v.faults, &[&v.orders, &v.wrong], !stops)
    }

    /// The run in which the emulated board breaks down in the pose, and the step at which it does.
    ///
    /// # Errors
    /// Where there is no image, no emulator, or it fails.
    pub fn broken_down(
        &self,
        crash: Crash,
        image: &Path,
    ) -> Result<(Plan, Trial, usize), PilError> {
        let plan = self.plan(&[], &[], false);
        let Crashed { tape, at, .. } =
            pil::crash(&plan.scenario, image, crash, self.fault_s(), AFTER_CRASH_S)?;
        let trial = Trial::of_tape(tape);
        Ok((plan, trial, at))
    }

    /// Step at which the fault begins: that of the first injection, or of the first wrong order.
    pub fn begun(&self, trial: &Trial) -> Option<usize> {
        let v = self.variant;
        let began = trial.events.iter().find(|(_, event)| matches!(event, Event::Began(_)));
        if let Some((true_s, _)) = began {
            let early = |f: &Frame| f.true_s < true_s - 1e-6;
            return Some(trial.frames.partition_point(early).clamp(1, trial.frames.len() - 1));
        }
        if !v.faults.is_empty() {
            return None;
        }
        let first = v.wrong.iter().map(|order| order.at_s).reduce(f64::min);
        trial.start.map(|_| trial.index_at(self.fault_s() + first.unwrap_or(0.0)))
    }

    /// The tip without the fault: along the path, or stopped along it from step `from` on.
    pub fn reference(&self, trial: &Trial, begun: usize, from: usize, stopped: bool) -> Track {
        let v = self.variant;
        if trial.start.is_none_or(|start| begun < start) {
            return Track::at_rest(trial.frames[0].tip_m);
        }
        if v.expect == Expect::Lower {
            return Track::at_rest(trial.frames[begun].tip_m);
        }
        let at_s = trial.frames[from].true_s - trial.start_s.unwrap_or(0.0) - self.fault_s();
        let stop = [Order { at_s, ask: Ask::Plain(Command::Stop) }];
        let orders: &[Order] = if stopped && v.orders.is_empty() { &stop } else { &[] };
        match run(&self.plan(&[], &[&v.orders, orders], true)) {
            Ok(run) => Track::of(&run),
            Err(_) => Track::at_rest([f64::NAN; 3]),
        }
    }

    /// Whether the twin is stopped, or shows a warning that only the fault may.
    pub fn twin_trips(&self) -> bool {
        let v = self.variant;
        let Ok(trial) = run(&self.plan(&v.twin, &[&v.orders], true)) else { return true };
        let Some(start) = trial.start else { return true };
        let stopped = v.orders.is_empty() && measure::first_stop(&trial, start).is_some();
        let warns = matches!(v.sign, Sign::Limited(_)) && v.expect == Expect::Tolerate;
        stopped || warns && measure::sign(&trial, start.max(1), v.sign).is_some()
    }
}
