//! Estimate, set-point, law and limits.

use shared::arm::JOINTS;
use shared::fault::{Fault, Limit};

use super::{BACKUP_TICKS, Core, TickInput, zero};
use crate::JointVector;
use crate::law::{self, State};
use crate::math::clamp_symmetric;
use crate::memory::Gained;
use crate::monitor::Finding;
use crate::path::Rate;
use crate::planner::Order;
use crate::supervisor::{ALL, Mode};

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

/// Ticks after a speed error in which the load may still differ from what the law expects.
const DRIVEN_TICKS: u8 = 40;
/// Ticks after a torque at its limit in which joints do not follow the law's acceleration.
const LOOSE_TICKS: u8 = 4;

impl Core {
    /// The torques of this tick.
    #[inline(always)]
    pub fn control(&mut self, input: &TickInput<'_>) -> Control {
        let gained = match input.order {
            Some(Order::SetGains(gained)) => Some(gained),
            _ => None,
        };
        match &self.mode {
            Mode::Moving(motion) => {
                motion.place(motion.phase, Rate::FULL, &mut self.trace.aim);
                self.trace.adapts = true;
            }
            _ => self.aim(),
        }
        if self.trace.in_control {
            self.watch();
            self.follow(gained)
        } else {
            self.rest(gained)
        }
    }

    /// Puts the set-point of any mode where the law finds it.
    #[cold]
    #[inline(never)]
    fn aim(&mut self) {
        self.trace.adapts = self.mode.adapts();
        self.trace.isolated = self.mode.isolated();
        let controls = self.mode.place(&self.memory.thresholds.timing, &mut self.trace.aim);
        if self.trace.in_control && !controls {
            self.trace.forget();
        }
        self.trace.in_control = controls;
    }

    /// Moves joints that stand a little, so that their encoders show that they are alive. A round is never broken off,
    /// whatever the mode becomes.
    #[inline(always)]
    fn watch(&mut self) {
        let watch = &self.memory.thresholds.timing.watch;
        let trace = &mut self.trace;
        trace.watch += 1;
        if trace.watch >= watch.ticks {
            trace.watch = 0;
            trace.watched = self.mode.standing(watch);
        }
        if trace.watched != 0 {
            watch.add(trace.watch, trace.watched, &mut trace.aim);
        }
    }

    /// The mode has changed: it finds the watch motion on its way back, or begins one.
    #[cold]
    #[inline(never)]
    pub(super) fn rewatch(&mut self) {
        let watch = &self.memory.thresholds.timing.watch;
        let trace = &mut self.trace;
        trace.watch = if trace.watched == 0 { watch.ticks } else { watch.way_back(trace.watch) };
    }

    /// The law at the measured state, limited to what the drives may give.
    #[inline(always)]
    fn follow(&mut self, gained: Option<&Gained>) -> Control {
        if !self.memory.estimates.is_sound() {
            self.distrust();
        }
        let mut state = self.state();
        if let Some(gained) = gained {
            self.set_gains(gained, &state);
        }
        let far = self.motions.is_far(&self.memory.thresholds.motion, &state.e1);
        let astray = far && self.stray(&state.e1);
        let limits = &self.memory.thresholds.motion;
        let c = &self.memory.coefficients;
        let observers = &self.memory.estimates.observers;
        if self.motions.judge(limits, observers, &c.scales, &state.e1_dot, &mut self.findings) {
            self.trace.loose = DRIVEN_TICKS;
        }
        if (self.trace.isolated != 0) | self.trace.soft {
            self.ease(&mut state);
        }
        let d_hat = self.memory.estimates.d_hat;
        let wanted = law::evaluate(&c.law, &c.dynamics, &state, &d_hat);
        // Infinity and NaN stay what they are when multiplied by zero.
        let finite = wanted.torque.sum() * 0.0 == 0.0;
        if astray || !finite && self.blame() {
            return Control { torque: self.trace.written, ..Control::none() };
        }
        let c = &self.memory.coefficients;
        let torque = wanted.torque.zip_map(&c.tau_max, clamp_symmetric);
        let saturated = wanted.torque.zip_map(&torque, |w, t| if w == t { 0.0 } else { 1.0 });
        if self.trace.adapts & !self.spoilt {
            // A joint at its torque limit learns nothing: its error is not the disturbance's.
            let step =
                wanted.adaptation.zip_map(&saturated, |s, at| if at == 0.0 { s } else { 0.0 });
            let d_hat = law::adapt(&c.law, &d_hat, &step);
            self.memory.estimates.set_d_hat(d_hat);
        }
        let saturated = law::bits(saturated);
        self.remember(&state.e1_dot, &wanted.acceleration, saturated);
        let State { qd, e1, e1_dot, .. } = state;
        Control { torque, e1, qd, e1_dot, saturated }
    }

    /// Estimates against the set-point, in SI units.
    #[inline(always)]
    fn state(&self) -> State {
        let (q, qd, e1) = (zero(), zero(), zero());
        let mut state =
            State { q, qd, e1, e1_dot: zero(), qdd_d: self.trace.aim.acceleration.into() };
        let aim = &self.trace.aim;
        for j in 0..JOINTS {
            let scale = &self.memory.coefficients.scales[j];
            let observer = &self.memory.estimates.observers[j];
            let distance = observer.position.wrapping_sub(aim.position[j]) as i32;
            state.q[j] = observer.position(scale);
            state.qd[j] = observer.velocity(scale);
            state.e1[j] = distance as f32 * scale.step;
            state.e1_dot[j] = state.qd[j] - aim.velocity[j];
        }
        state
    }

    /// What the next ticks' monitors compare with.
    #[inline(always)]
    fn remember(&mut self, e1_dot: &JointVector, acceleration: &JointVector, saturated: u8) {
        let per = &self.memory.thresholds.encoder.per_acceleration;
        let trace = &mut self.trace;
        trace.wanted[self.turn & 1] = acceleration.component_mul(&JointVector::from(*per));
        trace.speed_error = *e1_dot;
        if self.tick & (BACKUP_TICKS - 1) == 0 {
            trace.d_old = trace.d_mid;
            trace.d_mid = self.memory.estimates.d_hat;
        }
        if saturated != 0 {
            self.findings.limit(Limit::Torque);
            trace.loose = if trace.loose > LOOSE_TICKS { trace.loose } else { LOOSE_TICKS };
        } else if trace.loose != 0 {
            trace.loose -= 1;
        }
    }

    /// No torque, and nothing to report of a law.
    #[cold]
    #[inline(never)]
    fn rest(&mut self, gained: Option<&Gained>) -> Control {
        if let Some(gained) = gained {
            self.memory.gain(gained);
        }
        if !self.memory.estimates.is_sound() {
            self.distrust();
        }
        let speeds = self.memory.estimates.observers.iter().map(|observer| observer.velocity);
        if speeds.fold(0.0, |sum, v| sum + v * 0.0) != 0.0 {
            self.damage();
        }
        let mut control = Control::none();
        for j in 0..JOINTS {
            let observer = &self.memory.estimates.observers[j];
            self.trace.aim.position[j] = observer.position;
            control.qd[j] = observer.velocity(&self.memory.coefficients.scales[j]);
        }
        control
    }

    /// Looks into estimates that are far from the set-point; whether this tick has to do without the law.
    #[cold]
    #[inline(never)]
    fn stray(&mut self, e1: &JointVector) -> bool {
        let damaged = self.damage();
        let limits = &self.memory.thresholds.motion;
        damaged || self.motions.judge_error(limits, e1, self.trace.isolated, &mut self.findings)
    }

    /// Looks for what made the law's torques no numbers, which this tick has to do without. Where estimates are sound it
    /// is the set-point, and a stop from there would be none either.
    #[cold]
    #[inline(never)]
    fn blame(&mut self) -> bool {
        if !self.damage() {
            self.findings.raise(Finding { fault: Fault::ErrorWindow, joints: ALL });
        }
        self.spoilt = true;
        true
    }

    /// Mends damaged estimates, and tells of them; whether there were any.
    fn damage(&mut self) -> bool {
        let joints = self.mend();
        if joints != 0 {
            self.findings.raise(Finding { fault: Fault::NotFinite, joints });
            self.spoilt = true;
        }
        joints != 0
    }

    /// Estimates that are no numbers, or not what the codes say that they are made of, start anew from those.
    fn mend(&mut self) -> u8 {
        let mut damaged = 0;
        let estimates = self.memory.estimates.observers.iter_mut().zip(&self.tracks);
        for (j, (observer, track)) in estimates.enumerate() {
            if !observer.is_of(&track.observer()) {
                *observer = track.observer();
                damaged |= 1 << j;
            }
        }
        damaged
    }

    /// A disturbance estimate that is not what the last tick left is what it was before.
    #[cold]
    #[inline(never)]
    fn distrust(&mut self) {
        self.memory.estimates.set_d_hat(self.trace.d_old);
        self.findings.raise(Finding::new(Fault::NotFinite));
        self.spoilt = true;
    }

    /// Joints without torque are nobody's to move: the law takes them to be where they shall be, so that the others
    /// do not answer an acceleration that never comes. Where the arm swings, both gains of the law are halved.
    #[cold]
    #[inline(never)]
    fn ease(&self, state: &mut State) {
        let (p, d) = if self.trace.soft { (0.25, 0.5) } else { (1.0, 1.0) };
        for j in 0..JOINTS {
            let isolated = self.trace.isolated >> j & 1 != 0;
            state.e1[j] = if isolated { 0.0 } else { state.e1[j] * p };
            state.e1_dot[j] = if isolated { 0.0 } else { state.e1_dot[j] * d };
            state.qdd_d[j] = if isolated { 0.0 } else { state.qdd_d[j] };
        }
    }

    /// Takes new gains under control; the disturbance estimate takes up what they would change in torque.
    #[cold]
    #[inline(never)]
    fn set_gains(&mut self, gained: &Gained, state: &State) {
        let before = self.memory.coefficients.law;
        self.memory.gain(gained);
        let c = &self.memory.coefficients;
        let change = c.law.less_than(&before, &state.e1, &state.e1_dot);
        // Gravity cancels.
        let torque = |change| c.dynamics.torque(&state.q, &zero(), change);
        let step = torque(&change) - torque(&zero());
        let d_hat = law::adapt(&c.law, &self.memory.estimates.d_hat, &step);
        self.memory.estimates.set_d_hat(d_hat);
    }
}
