//! Estimate, set-point, law and limits.

use shared::fault::{Fault, Limit};

use super::{Core, TickInput, Trace, zero};
use crate::JointVector;
use crate::law::{self, State};
use crate::math::clamp_symmetric;
use crate::memory::Gained;
use crate::monitor::Finding;
use crate::path::SetPoint;
use crate::planner::Order;
use crate::supervisor::Mode;

/// What the law leaves for bus and telemetry.
#[derive(Clone, Copy, Debug)]
pub struct Control {
    /// Torque command, N m and N.
    pub torque: JointVector,
    /// Position error q - q_d, rad and m.
    pub e1: JointVector,
    /// Velocity estimate, rad/s and m/s.
    pub qd: JointVector,
    /// Velocity error, rad/s and m/s.
    pub e1_dot: JointVector,
    /// One bit a joint whose torque is at its limit.
    pub saturated: u8,
}

impl Control {
    /// No torque, and nothing to report of a law.
    #[inline(always)]
    pub fn none() -> Self {
        Self { torque: zero(), e1: zero(), qd: zero(), e1_dot: zero(), saturated: 0 }
    }
}

/// Ticks after a torque at its limit in which joints do not follow the law's acceleration.
const LOOSE_TICKS: u8 = 4;

impl Core {
    /// The torques of this tick.
    #[inline(always)]
    pub fn control(&mut self, input: &TickInput<'_>) -> Control {
        if let Some(Order::SetGains(gained)) = input.order {
            self.set_gains(gained);
        }
        match &self.mode {
            Mode::Moving(motion) => {
                self.trace.aim = motion.set_point();
                self.trace.adapts = true;
            }
            _ => self.aim(),
        }
        if self.trace.in_control { self.follow() } else { self.rest() }
    }

    /// Puts the set-point of any mode where the law finds it.
    #[cold]
    #[inline(never)]
    fn aim(&mut self) {
        self.trace.adapts = self.mode.adapts();
        let set_point = self.mode.set_point(&self.memory.thresholds.timing);
        self.trace.in_control = set_point.is_some();
        if let Some(set_point) = set_point {
            self.trace.aim = set_point;
        }
    }

    /// The law at the measured state, limited to what the drives may give.
    #[inline(always)]
    fn follow(&mut self) -> Control {
        let state = self.state();
        let c = &self.memory.coefficients;
        let limits = &self.memory.thresholds.motion;
        let observers = &self.memory.estimates.observers;
        self.motions.judge_error(limits, state.e1, self.mode.isolated(), &mut self.findings);
        self.motions.judge_motion(limits, observers, &c.scales, &mut self.findings);

        let d_hat = self.memory.estimates.d_hat;
        let wanted = law::evaluate(&c.law, &c.dynamics, &state, &d_hat);
        let mut torque = wanted.torque.zip_map(&c.tau_max, clamp_symmetric);
        let saturated = wanted.torque.zip_map(&torque, |w, t| if w == t { 0.0 } else { 1.0 });
        let fault = self.findings.worst.fault;
        // Infinity and NaN stay what they are when multiplied by zero.
        let finite = wanted.torque.sum() * 0.0 == 0.0;
        if !finite || (fault != self.judged && fault == Fault::ErrorWindow) {
            torque = self.distrust(finite);
        } else if self.trace.adapts & !self.spoilt {
            // A joint at its torque limit learns nothing: its error is not the disturbance's.
            let step =
                wanted.adaptation.zip_map(&saturated, |s, at| if at == 0.0 { s } else { 0.0 });
            self.memory.estimates.d_hat = law::adapt(&c.law, &d_hat, &step);
        }
        let saturated = law::bits(saturated);
        self.remember(&state.e1_dot, &wanted.acceleration, saturated);
        let State { qd, e1, e1_dot, .. } = state;
        Control { torque, e1, qd, e1_dot, saturated }
    }

    /// Estimates against the set-point, in SI units.
    #[inline(always)]
    fn state(&self) -> State {
        let c = &self.memory.coefficients.scales;
        let o = &self.memory.estimates.observers;
        let aim = &self.trace.aim;
        let q = JointVector::from_fn(|j, _| o[j].position(&c[j]));
        let qd = JointVector::from_fn(|j, _| o[j].velocity(&c[j]));
        let e1 = JointVector::from_fn(|j, _| {
            o[j].position.wrapping_sub(aim.position[j]) as i32 as f32 * c[j].step
        });
        let e1_dot = qd - JointVector::from(aim.velocity);
        State { q, qd, e1, e1_dot, qdd_d: aim.acceleration.into() }
    }

    /// What the next ticks' monitors compare with.
    #[inline(always)]
    fn remember(&mut self, e1_dot: &JointVector, acceleration: &JointVector, saturated: u8) {
        let per = &self.memory.thresholds.encoder.per_acceleration;
        let trace = &mut self.trace;
        trace.wanted[self.turn & 1] = acceleration.component_mul(&JointVector::from(*per));
        trace.speed_error = *e1_dot;
        // One joint a tick: it is wanted only after an estimate was no number.
        let j = (self.tick & 3) as usize;
        trace.d_hat[j] = self.memory.estimates.d_hat[j];
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
        let observers = &self.memory.estimates.observers;
        let (written, acting) = (self.trace.written, self.trace.acting);
        let aim = SetPoint::hold(observers.map(|o| o.position));
        self.trace = Trace { written, acting, aim, ..Trace::NONE };
        let scales = &self.memory.coefficients.scales;
        let mut qd = zero();
        for ((slot, observer), scale) in qd.iter_mut().zip(observers).zip(scales) {
            *slot = observer.velocity(scale);
        }
        Control { qd, ..Control::none() }
    }

    /// Estimates that are no numbers, or further from the set-point than anything explains, start anew from the
    /// encoders. Gives the torque to go on with in this tick: that of the last one.
    #[cold]
    #[inline(never)]
    fn distrust(&mut self, finite: bool) -> JointVector {
        let estimates = &mut self.memory.estimates;
        for (observer, track) in estimates.observers.iter_mut().zip(&self.tracks) {
            *observer = track.observer();
        }
        if !finite {
            if !estimates.d_hat.iter().all(|d| d.is_finite()) {
                estimates.d_hat = self.trace.d_hat;
            }
            self.spoilt = true;
            self.findings.raise(Finding::new(Fault::NotFinite));
        }
        self.trace.written
    }

    /// Takes new gains; the disturbance estimate takes up what they would change in torque.
    #[cold]
    #[inline(never)]
    fn set_gains(&mut self, gained: &Gained) {
        let before = self.memory.coefficients.law;
        self.memory.gain(gained);
        self.aim();
        if self.trace.in_control {
            let state = self.state();
            let c = &self.memory.coefficients;
            let change = before.acceleration(&state) - c.law.acceleration(&state);
            // Gravity cancels.
            let (rest, at) = (zero(), &c.dynamics);
            let step = at.torque(&state.q, &rest, &change) - at.torque(&state.q, &rest, &rest);
            let d_hat = &mut self.memory.estimates.d_hat;
            *d_hat = law::adapt(&c.law, d_hat, &step);
        }
    }
}
