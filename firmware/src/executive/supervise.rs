//! The supervisor's turn in a tick: devices during boot, then the mode.

use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::spi::SpiDevice;
use shared::arm::JOINTS;
use shared::fault::Fault;

use super::{Executive, TickInput, Trace};
use crate::JointVector;
use crate::drivers::Progress;
use crate::drivers::ads131m04::Ads131m04;
use crate::drivers::dac81404::Dac81404;
use crate::memory::Health;
use crate::monitor::{Bucket, Finding, Motions, Torques};
use crate::planner::Order;
use crate::supervisor::{ALL, Events, Mode, Timing};

/// What boot has come to.
#[derive(Clone, Copy)]
struct Readiness {
    ready: bool,
    /// What keeps it from ending, if that is known.
    complaint: Fault,
}

impl<S: SpiDevice, O: OutputPin, I: InputPin> Executive<S, O, I> {
    /// Configures converters during boot and moves the mode.
    #[inline(always)]
    pub(super) fn supervise(&mut self, input: &TickInput<'_>) {
        self.stages = self.stages << 4 | 3;
        self.watch_operator(input.alive);
        match self.scrub.step(&mut self.memory) {
            Health::Good => {}
            Health::Lost => self.findings.raise(Finding::new(Fault::ParametersLost)),
            _ => self.findings.raise(Finding::new(Fault::ParameterFlipped)),
        }
        self.judged = self.findings.worst.fault;
        // Nothing to decide is the usual case, and the dearest tick is one of those.
        let quiet = input.order.is_none() && self.judged == Fault::None;
        let link = self.memory.thresholds.timing.link;
        if !(quiet && self.silence <= link && self.mode.glides()) {
            self.decide(input);
        }
    }

    /// The mode's turn.
    #[cold]
    #[inline(never)]
    fn decide(&mut self, input: &TickInput<'_>) {
        let boot = if matches!(self.mode, Mode::Boot { .. }) {
            self.boot(input)
        } else {
            Readiness { ready: false, complaint: Fault::None }
        };
        let latched = matches!(self.mode, Mode::Latched { .. });
        let refusal = self.with_events(input.order, boot, Mode::step);
        if input.order.is_some() {
            self.refusal = refusal;
        }
        if latched && matches!(self.mode, Mode::Boot { .. }) {
            self.retained.parked = Some(self.codes());
            self.pose_confirmed = false;
        }
    }

    /// Lets the mode react to what was found since its turn.
    #[cold]
    #[inline(never)]
    pub(super) fn react(&mut self) {
        self.judged = self.findings.worst.fault;
        let boot = Readiness { ready: false, complaint: Fault::None };
        self.with_events(None, boot, Mode::react);
    }

    /// Tells the mode how things stand.
    fn with_events<T>(
        &mut self,
        order: Option<&Order>,
        boot: Readiness,
        tell: impl FnOnce(&mut Mode, &Timing, &Events<'_>) -> T,
    ) -> T {
        let codes = self.codes();
        let brakes = self.io.inputs.brakes();
        let memory = &self.memory;
        let events = Events {
            order,
            observers: &memory.estimates.observers,
            scales: &memory.coefficients.scales,
            codes,
            brakes,
            stop_released: !self.contacts.open && !self.contacts.suspect,
            ready: boot.ready,
            complaint: boot.complaint,
            finding: self.findings.worst,
            blind: self.blind,
            silence: self.silence,
        };
        tell(&mut self.mode, &memory.thresholds.timing, &events)
    }

    /// Last believed codes.
    #[inline(always)]
    pub(super) fn codes(&self) -> [u32; JOINTS] {
        let [a, b, c, d] = &self.tracks;
        [a.code, b.code, c.code, d.code]
    }

    /// Emergency stop and operator link.
    #[inline(always)]
    fn watch_operator(&mut self, alive: bool) {
        self.silence = if alive { 0 } else { self.silence.saturating_add(1) };
        let open = self.io.inputs.contacts_open();
        if open != 0 || self.contacts.open {
            self.judge_contacts(open);
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

    /// One tick of boot.
    #[cold]
    #[inline(never)]
    fn boot(&mut self, input: &TickInput<'_>) -> Readiness {
        let Mode::Boot { ticks, complaint } = self.mode else {
            return Readiness { ready: false, complaint: Fault::None };
        };
        if ticks == 0 {
            self.start_over();
        }
        if self.mode.converters_awake(&self.memory.thresholds.timing) {
            self.boot_converters(input.conversions);
        }
        self.pose_confirmed |= matches!(input.order, Some(Order::ConfirmPose));
        let devices = self.adc_ready
            && self.dac_ready
            && self.seen == ALL
            && self.buckets.iter().all(|bucket| bucket.level() == 0);
        if !devices {
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
        let parked = self.retained.parked.is_some_and(|parked| {
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

    /// Forgets everything about the devices, which are in reset now.
    fn start_over(&mut self) {
        self.adc = Ads131m04::new();
        self.dac = Dac81404::new();
        (self.adc_ready, self.dac_ready, self.acknowledged) = (false, false, false);
        (self.seen, self.blind, self.may_adapt) = (0, 0, true);
        for bucket in &mut self.buckets {
            *bucket = Bucket::FULL;
        }
        self.leaking = true;
        self.memory.estimates.d_hat = JointVector::repeat(0.0);
        self.torques = Torques::default();
        self.motions = Motions::default();
        self.trace = Trace::NONE;
    }

    /// One boot step of each converter.
    fn boot_converters(&mut self, conversions: u32) {
        if !self.adc_ready && self.adc.boot_step(&mut self.io.adc) == Progress::Ready {
            self.adc_ready = true;
            self.clock.restart(conversions);
        }
        if !self.dac_ready {
            self.dac_ready = self.dac.boot_step(&mut self.io.dac) == Progress::Ready;
        }
    }
}
