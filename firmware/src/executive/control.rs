//! Estimate, set-point, law and limits.

use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::spi::SpiDevice;
use shared::fault::{Fault, Limit};

use super::{Executive, TickInput};
use crate::JointVector;
use crate::law::{self, State};
use crate::math::clamp_symmetric;
use crate::monitor::{Finding, Motion};
use crate::path::SetPoint;
use crate::planner::Order;

/// What the law leaves for bus and telemetry.
#[derive(Clone, Copy, Debug)]
pub(super) struct Control {
    pub torque: JointVector,
    pub e1: JointVector,
    pub qd: JointVector,
    pub e1_dot: JointVector,
    pub saturated: u8,
}

/// Ticks after a torque at its limit in which joints do not follow the law's acceleration.
const LOOSE_TICKS: u8 = 4;

impl<S: SpiDevice, O: OutputPin, I: InputPin> Executive<S, O, I> {
    /// The torques of this tick.
    #[inline(always)]
    pub(super) fn control(&mut self, input: &TickInput<'_>) -> Control {
        self.stages = self.stages << 4 | 4;
        if let Some(Order::SetGains(_)) = input.order {
            self.set_gains(input);
        }
        match self.mode.set_point(&self.memory.live.thresholds.timing) {
            Some(set_point) => self.follow(&set_point),
            None => self.rest(),
        }
    }

    /// The law at the measured state, limited to what the drives may give.
    #[inline(always)]
    fn follow(&mut self, set_point: &SetPoint) -> Control {
        let mut state = self.state(set_point);
        let thresholds = &self.memory.live.thresholds;
        let observers = &self.memory.estimates.observers;
        let seen = Motion {
            position: [0, 1, 2, 3].map(|j: usize| observers[j].position),
            qd: state.qd.as_ref(),
            e1: state.e1.as_ref(),
            excused: self.mode.isolated(),
        };
        self.motions.judge(&thresholds.motion, &seen, &mut self.findings);
        let mut target = set_point.position;
        if self.findings.worst.fault == Fault::ErrorWindow && self.judged != Fault::ErrorWindow {
            (state, target) = self.recover(set_point);
        }

        let c = &self.memory.live.coefficients;
        let d_hat = self.memory.estimates.d_hat;
        let wanted = law::evaluate(&c.law, &c.dynamics, &state, &d_hat);
        let torque = wanted.torque.zip_map(&c.tau_max, clamp_symmetric);
        let saturated = wanted.torque.zip_map(&torque, |w, t| if w == t { 0.0 } else { 1.0 });
        if self.mode.adapts() && !self.fixed_gain && self.blind == 0 {
            // A joint at its torque limit learns nothing: its error is not the disturbance's.
            let step =
                wanted.adaptation.zip_map(&saturated, |s, at| if at == 0.0 { s } else { 0.0 });
            self.memory.estimates.d_hat = law::adapt(&c.law, &d_hat, &step);
        }
        let saturated = law::bits(saturated);
        self.remember(&state, target, &wanted.acceleration, saturated);
        let State { qd, e1, e1_dot, .. } = state;
        Control { torque, e1, qd, e1_dot, saturated }
    }

    /// Estimates against the set-point, in SI units.
    #[inline(always)]
    fn state(&self, set_point: &SetPoint) -> State {
        let c = &self.memory.live.coefficients.scales;
        let o = &self.memory.estimates.observers;
        let q = JointVector::from_fn(|j, _| o[j].position(&c[j]));
        let qd = JointVector::from_fn(|j, _| o[j].velocity(&c[j]));
        let e1 = JointVector::from_fn(|j, _| {
            o[j].position.wrapping_sub(set_point.position[j]) as i32 as f32 * c[j].step
        });
        let e1_dot = qd - JointVector::from(set_point.velocity);
        State { q, qd, e1, e1_dot, qdd_d: set_point.acceleration.into() }
    }

    /// What the next tick's monitors compare with.
    #[inline(always)]
    fn remember(
        &mut self,
        state: &State,
        target: [u32; shared::arm::JOINTS],
        acceleration: &JointVector,
        saturated: u8,
    ) {
        let per = &self.memory.live.thresholds.encoder.per_acceleration;
        let trace = &mut self.trace;
        let wanted = JointVector::from_fn(|j, _| acceleration[j] * per[j]);
        trace.expected = [trace.expected[1], (trace.wanted + wanted) * 0.5];
        trace.wanted = wanted;
        trace.target = target;
        trace.speed_error = state.e1_dot;
        trace.in_control = true;
        trace.d_hat = self.memory.estimates.d_hat;
        if saturated != 0 {
            self.findings.limit(Limit::Torque);
            trace.loose = LOOSE_TICKS;
        } else if trace.loose != 0 {
            trace.loose -= 1;
        }
    }

    /// No torque, and nothing to report of a law.
    #[cold]
    #[inline(never)]
    fn rest(&mut self) -> Control {
        let zero = JointVector::repeat(0.0);
        let observers = &self.memory.estimates.observers;
        let torque = self.trace.torque;
        let target = observers.map(|o| o.position);
        self.trace = super::Trace { torque, target, ..super::Trace::NONE };
        let c = &self.memory.live.coefficients.scales;
        let mut qd = zero;
        for ((slot, observer), scale) in qd.iter_mut().zip(observers).zip(c) {
            *slot = observer.velocity(scale);
        }
        Control { torque: zero, e1: zero, qd, e1_dot: zero, saturated: 0 }
    }

    /// A position error that nothing explains: estimates and set-point start anew from the encoders.
    #[cold]
    #[inline(never)]
    fn recover(&mut self, set_point: &SetPoint) -> (State, [u32; shared::arm::JOINTS]) {
        for (observer, track) in self.memory.estimates.observers.iter_mut().zip(&self.tracks) {
            *observer = track.observer();
        }
        self.react();
        let now = self.mode.set_point(&self.memory.live.thresholds.timing);
        let now = now.unwrap_or(*set_point);
        (self.state(&now), now.position)
    }

    /// Estimates that are no numbers are replaced before anything uses them.
    #[inline(always)]
    pub(super) fn check_estimates(&mut self) {
        let e = &self.memory.estimates;
        let [a, b, c, d] = &e.observers;
        let speeds = (a.velocity + b.velocity) + (c.velocity + d.velocity);
        // Infinity and NaN stay what they are when multiplied by zero; a sum that overflows is wrong too.
        if (speeds + e.d_hat.sum()) * 0.0 != 0.0 {
            self.replace_estimates();
        }
    }

    #[cold]
    #[inline(never)]
    fn replace_estimates(&mut self) {
        let estimates = &mut self.memory.estimates;
        for (observer, track) in estimates.observers.iter_mut().zip(&self.tracks) {
            if !observer.velocity.is_finite() {
                *observer = track.observer();
            }
        }
        if !estimates.d_hat.iter().all(|d| d.is_finite()) {
            estimates.d_hat = self.trace.d_hat;
        }
        self.fixed_gain = true;
        self.findings.raise(Finding::new(Fault::NotFinite));
    }

    /// Takes new gains; the disturbance estimate takes up what they would change in torque.
    #[cold]
    #[inline(never)]
    fn set_gains(&mut self, input: &TickInput<'_>) {
        let Some(Order::SetGains(gained)) = input.order else { return };
        let set_point = self.mode.set_point(&self.memory.live.thresholds.timing);
        let before = self.memory.live.coefficients.law;
        self.memory.gain(gained);
        if let Some(set_point) = set_point {
            let state = self.state(&set_point);
            let c = &self.memory.live.coefficients;
            let change = before.acceleration(&state) - c.law.acceleration(&state);
            let step = c.dynamics.at(&state.q).inertia_times(&change);
            let d_hat = &mut self.memory.estimates.d_hat;
            *d_hat = law::adapt(&c.law, d_hat, &step);
        }
    }
}
