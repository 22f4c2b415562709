//! What came of a run.

use shared::fault::{Fault, Mode, Refusal};

use super::Session;
use crate::outcome::{Adaptation, Law, Outcome};
use crate::scenario::Scenario;

impl Session<'_> {
    /// What came of the run, which took `wall_s`.
    pub fn outcome(self, wall_s: f64) -> Outcome {
        let s = self.scenario;
        let (law, adaptation) = controller_of(s);
        let metrics = self.judge.metrics();
        let fault = Fault::from_number(self.last.fault).unwrap_or(Fault::None);
        let mut broken_limits =
            s.accept_for(law, adaptation).map_or(Vec::new(), |limits| limits.broken(&metrics));
        let unmet = s.expect.filter(|expected| *expected != fault);
        if let Some(expected) = unmet {
            broken_limits.push(format!("the run did not end in the fault {}", expected.name()));
        }
        if s.expect.is_none() && !self.operator.has_finished(&self.last) {
            broken_limits.push("the trajectory did not reach its end".into());
        }
        if let Some(refusal) = Refusal::from_number(self.last.refusal)
            && refusal != Refusal::None
        {
            broken_limits.push(format!("the controller refused a command: {}", refusal.name()));
        }
        Outcome {
            scenario: s.name.clone(),
            law,
            adaptation,
            tick_hz: s.tick_hz,
            seed: s.seed,
            ticks: self.ticks,
            metrics,
            mode: Mode::from_number(self.last.mode).map_or("Unknown", Mode::name).into(),
            faults: if fault == Fault::None { Vec::new() } else { vec![fault.name().into()] },
            realtime_factor: self.clock.true_s() / wall_s,
            broken_limits,
            expected: s.expect.map(|fault| fault.name().into()),
            start_s: self.clock.start_s().filter(|_| !self.happenings().is_empty()),
            happenings: self.happenings().to_vec(),
            torque_limit: self.arm.limits.map(|l| l.tau_max),
            rows: self.judge.into_rows(),
            evidence: None,
        }
    }
}

/// Law and adaptation as reported: the PD adapts nothing.
fn controller_of(scenario: &Scenario) -> (Law, Adaptation) {
    let c = &scenario.controller;
    match c.law {
        Law::Pd => (Law::Pd, Adaptation::None),
        Law::Backstepping => (Law::Backstepping, c.adaptation),
    }
}
