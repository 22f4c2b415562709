//! The supervisor's turn in a tick.

use core::mem::discriminant;

use shared::fault::{Fault, Refusal};

use super::{Core, TickInput};
use crate::memory::Health;
use crate::monitor::Finding;
use crate::planner::Order;
use crate::supervisor::{ALL, Brakes, Events, Mode};

/// What boot has come to.
#[derive(Clone, Copy)]
struct Readiness {
    ready: bool,
    /// What keeps it from ending, if that is known.
    complaint: Fault,
}

impl Readiness {
    /// Boot is over, or knows of nothing that keeps it from ending.
    const NONE: Self = Self { ready: false, complaint: Fault::None };
}

impl Core {
    /// Watches over operator and parameters: `contacts_open` has a bit for each open contact of the emergency
    /// stop. Says whether the mode has to decide ([`Core::decide`]); if not, it has gone on by itself.
    #[inline(always)]
    pub fn supervise(&mut self, input: &TickInput<'_>, contacts_open: u8) -> bool {
        self.silence = if input.alive { 0 } else { self.silence.saturating_add(1) };
        if contacts_open != 0 || self.contacts.open {
            self.judge_contacts(contacts_open);
        }
        match self.scrub.step(&mut self.memory) {
            Health::Good => {}
            Health::Lost => self.findings.raise(Finding::new(Fault::ParametersLost)),
            _ => self.findings.raise(Finding::new(Fault::ParameterFlipped)),
        }
        self.judged = self.findings.worst.fault;
        // Nothing to decide is the usual case, and the dearest tick is one of those.
        let quiet = input.order.is_none() && self.judged == Fault::None;
        let timing = &self.memory.thresholds.timing;
        !(quiet && self.silence <= timing.link && self.mode.glides(timing))
    }

    /// The mode's turn; `converters` says whether both are configured.
    #[cold]
    #[inline(never)]
    pub fn decide(&mut self, input: &TickInput<'_>, brakes: Brakes, converters: bool) {
        let boot = self.readiness(input.order, converters);
        // After a crash no boot has found the pose to be the parked one yet.
        let latched = matches!(self.mode, Mode::Latched { .. }) && self.adc_ready;
        let before = discriminant(&self.mode);
        let refusal = self.tell(input.order, brakes, Some(boot));
        if discriminant(&self.mode) != before {
            self.rewatch();
        }
        if input.order.is_some() {
            self.refusal = refusal;
        }
        if latched && matches!(self.mode, Mode::Boot { .. }) {
            self.parked = Some(self.codes());
        }
    }

    /// Reacts in the same tick to what was found after the supervisor's turn; whether it did.
    #[inline(always)]
    pub fn conclude(&mut self, driven: bool) -> bool {
        if !driven {
            self.findings.raise(Finding::new(Fault::PinNotDriven));
        }
        let found = self.findings.worst.fault != self.judged;
        if found {
            self.react();
        }
        found
    }

    /// Lets the mode react to what was found since its turn.
    #[cold]
    #[inline(never)]
    fn react(&mut self) {
        self.judged = self.findings.worst.fault;
        if self.judged == Fault::Oscillation {
            (self.trace.soft, self.spoilt) = (true, true);
        }
        self.tell(None, Brakes::default(), None);
    }

    /// A tick whose parameters' copies differ: one more step towards the good one. No sample is taken, so to the
    /// next tick more than one has passed. Of all orders it takes only a stop.
    #[cold]
    #[inline(never)]
    pub fn repair(&mut self, order: Option<&Order>, brakes: Brakes) {
        let lost = self.search.step(&mut self.memory) == Health::Lost;
        let fault = if lost { Fault::ParametersLost } else { Fault::ParameterFlipped };
        self.findings.raise(Finding::new(fault));
        self.judged = fault;
        let stop = order.filter(|order| matches!(order, Order::Stop));
        // What boot does between its ticks needs parameters.
        let turn = !matches!(self.mode, Mode::Boot { .. });
        let refusal = self.tell(stop, brakes, turn.then_some(Readiness::NONE));
        if order.is_some() {
            let busy = if lost { Refusal::LockedOut } else { Refusal::Busy };
            self.refusal = if stop.is_some() { refusal } else { busy };
        }
        self.acknowledged = false;
        self.rejected = 0;
    }

    /// Tells the mode how things stand: at its turn, with how far boot has come, or after it.
    #[inline(never)]
    fn tell(&mut self, order: Option<&Order>, brakes: Brakes, boot: Option<Readiness>) -> Refusal {
        let Readiness { ready, complaint } = boot.unwrap_or(Readiness::NONE);
        let codes = self.codes();
        let memory = &self.memory;
        let events = Events {
            order,
            observers: &memory.estimates.observers,
            scales: &memory.coefficients.scales,
            codes,
            brakes,
            stop_released: !self.contacts.open && !self.contacts.suspect,
            ready,
            complaint,
            finding: self.findings.worst,
            blind: self.blind,
            silence: self.silence,
        };
        let timing = &memory.thresholds.timing;
        if boot.is_some() {
            self.mode.step(timing, &events)
        } else {
            self.mode.react(timing, &events);
            Refusal::None
        }
    }

    #[cold]
    #[inline(never)]
    fn judge_contacts(&mut self, open: u8) {
        let contacts = &mut self.contacts;
        contacts.open = open != 0;
        contacts.differ = if matches!(open, 1 | 2) { contacts.differ.saturating_add(1) } else { 0 };
        contacts.suspect |= contacts.differ > self.memory.thresholds.timing.contacts;
        contacts.suspect &= open != 3;
        if contacts.open {
            let suspect = contacts.suspect;
            let fault = if suspect { Fault::EmergencyStopContacts } else { Fault::EmergencyStop };
            self.findings.raise(Finding::new(fault));
        }
    }

    /// How far boot has come.
    fn readiness(&mut self, order: Option<&Order>, converters: bool) -> Readiness {
        let Mode::Boot { ticks, complaint } = self.mode else {
            return Readiness::NONE;
        };
        // Nobody vouches for a pose that nobody has seen.
        self.pose_confirmed |=
            complaint == Fault::ParkedPoseDiffers && matches!(order, Some(Order::ConfirmPose));
        if self.findings.worst.fault == Fault::ParametersLost {
            return Readiness { ready: false, complaint: Fault::ParametersLost };
        }
        let lossless = self.buckets.iter().all(|bucket| bucket.level() == 0);
        // Full buckets overflow at the first loss, and only starting over makes such an encoder believed again.
        let seen = self.seen == ALL && self.blind == 0;
        if !(converters && seen && lossless) {
            let late = ticks >= self.memory.thresholds.timing.boot;
            let complaint = if late { Fault::BootTimeout } else { complaint };
            return Readiness { ready: false, complaint };
        }
        let complaint = self.pose_complaint();
        Readiness { ready: complaint == Fault::None, complaint }
    }

    /// What is wrong with the pose at power-up.
    fn pose_complaint(&self) -> Fault {
        let thresholds = &self.memory.thresholds;
        let codes = self.codes();
        let parked = self.parked.is_some_and(|parked| {
            let pairs = codes.iter().zip(&parked).zip(&thresholds.timing.parked);
            pairs.fold(true, |near, ((c, p), d)| near & (c.abs_diff(*p) <= *d))
        });
        if !thresholds.motion.contain(&codes) {
            Fault::PositionImpossible
        } else if !parked && !self.pose_confirmed {
            Fault::ParkedPoseDiffers
        } else {
            Fault::None
        }
    }
}
