//! The scenario's faults in a session: when they come by its clock, and what has come of them.

use shared::arm::{Arm, JOINTS};
use shared::telemetry::Record;

use super::START_UP_S;
use super::chronicle::{Chronicle, Event, Happening};
use super::clock::{Clock, Slot};
use crate::bench::Bench;
use crate::faults::{Injection, Injector, Kind, Told};
use crate::plant::Plant;
use crate::run;
use crate::scenario::Scenario;

/// Before the start it is this long before it at least, however late the start is, s.
const BEFORE_S: f64 = 1e-6;

/// See the module's documentation.
pub(super) struct Faults {
    injections: Vec<Injection>,
    injector: Injector,
    /// When t = 0 is expected after power-up, s.
    start_s: f64,
    chronicle: Chronicle,
}

impl Faults {
    /// The scenario's, if it has any. Times before the start are known only from a run without faults.
    pub fn of(scenario: &Scenario, arm: &Arm, clock: &mut Clock) -> Option<Self> {
        let injections = scenario.faults.clone();
        if injections.is_empty() {
            return None;
        }
        let latest_s = scenario.settle_s + START_UP_S;
        let wrap = injections.iter().find(|one| one.kind == Kind::CounterWrap);
        let is_early = |one: &Injection| one.at_s < 0.0 && one.at_s > -latest_s;
        let must_be_known = wrap.is_some() || injections.iter().any(is_early);
        let known_s = if must_be_known { run::start_s(scenario) } else { None };
        let start_s = known_s.unwrap_or(latest_s);
        if let Some(wrap) = wrap {
            clock.wrap_at(((start_s + wrap.at_s) * f64::from(scenario.tick_hz)).round());
        }
        let injector = Injector::new(&injections, arm);
        Some(Self { injections, injector, start_s, chronicle: Chronicle::default() })
    }

    /// Time since the start; before it, since when it is expected, s.
    fn time_s(&self, clock: &Clock) -> f64 {
        let expected = || (clock.true_s() - self.start_s).min(-BEFORE_S);
        clock.since_start_s().unwrap_or_else(expected)
    }

    /// Brings clock, bench and plant to what is wrong at this instant.
    pub fn inject(&mut self, clock: &mut Clock, bench: &mut Bench, plant: &mut Plant) {
        for edge in self.injector.advance(self.time_s(clock), bench, plant) {
            let event = if edge.begins { Event::Began } else { Event::Ended };
            self.chronicle.add(clock.true_s(), event(self.injections[edge.injection]));
        }
        clock.set_ratio(self.injector.clock_ratio());
    }

    /// How the tick comes that is due.
    pub fn slot(&mut self) -> Slot {
        self.injector.slot()
    }

    /// What the coming tick is told.
    pub fn tell(&mut self) -> Told {
        self.injector.tell()
    }

    /// What the torque transducers' channels get in place of `shares` of their full scale.
    pub fn sense(&self, clock: &Clock, shares: &mut [f64; JOINTS]) {
        self.injector.sense(self.time_s(clock), shares);
    }

    /// Takes note of what controller and hardware make of it.
    pub fn watch(&mut self, clock: &Clock, record: &Record, chain_closed: bool) {
        self.chronicle.watch(clock.true_s(), record, chain_closed);
    }

    /// What has happened so far.
    pub fn happenings(&self) -> &[Happening] {
        self.chronicle.happenings()
    }
}
