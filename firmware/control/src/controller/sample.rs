//! What is believed of the samples.

use shared::arm::JOINTS;
use shared::fault::{Fault, Limit};

use super::{ADC, Core, DAC, TickInput};
use crate::estimator::Observer;
use crate::monitor::{Elapsed, Finding, Track};
use crate::supervisor::ALL;

impl Core {
    /// Begins the samples of a tick; says whether they come one tick after the last ones and of joints that all
    /// are known ([`Core::take`]), or how many ticks after ([`Core::take_after`]).
    #[inline(always)]
    pub fn start_sampling(&mut self, input: &TickInput<'_>) -> Elapsed {
        self.rejected = 0;
        let limits = &self.memory.thresholds.clock;
        let elapsed = self.clock.tick(limits, input.cycles, input.spent, &mut self.findings);
        let special = self.blind | (ALL & !self.seen);
        match elapsed {
            Elapsed::Regular if special != 0 => Elapsed::Irregular(1.0),
            Elapsed::Irregular(ticks) => {
                self.catch_up(ticks);
                elapsed
            }
            Elapsed::Regular => elapsed,
        }
    }

    /// Takes the sample of joint `j` one tick after the last.
    #[inline(always)]
    pub fn take(&mut self, j: usize, code: u32, warning: bool) {
        let expected = self.trace.wanted[self.turn & 1][j];
        let distance = self.tracks[j].distance(code, expected);
        if (!warning && self.is_plain(j, code, distance))
            || self.believes(j, code, warning, distance)
        {
            self.tracks[j].take(code);
            let c = &self.memory.coefficients;
            let observer = &mut self.memory.estimates.observers[j];
            observer.update(&c.observer, &c.scales[j], code);
        } else {
            self.go_without(j, 1.0);
        }
    }

    /// Whether the code of joint `j` is where it is expected and moves as it should; `j` is below `JOINTS`.
    #[inline(always)]
    fn is_plain(&mut self, j: usize, code: u32, distance: i32) -> bool {
        let window = self.memory.thresholds.encoder.tight[j];
        distance.wrapping_add_unsigned(window) as u32 <= 2 * window
            && !self.tracks[j].stands(code, self.trace.aim.position[j])
    }

    /// There is no sample of joint `j`, one tick after the last.
    #[cold]
    #[inline(never)]
    pub fn lose(&mut self, j: usize) {
        self.miss(j, Fault::EncoderLost);
        self.go_without(j, 1.0);
    }

    /// Takes the sample of joint `j`, code and warning, if there is one, `ticks` after the last.
    #[cold]
    #[inline(never)]
    pub fn take_after(&mut self, j: usize, sample: Option<(u32, bool)>, ticks: f32) {
        let j = j % JOINTS;
        let known = (self.seen & !self.blind) >> j & 1 != 0;
        let believed = match sample {
            None => {
                self.miss(j, Fault::EncoderLost);
                None
            }
            Some((code, warning)) => {
                // What acceleration leaves open grows with the square of the time.
                let distance =
                    self.tracks[j].distance_after(code, ticks) as f32 / (1.0 + ticks * ticks);
                let distance = distance as i32;
                let plain = known && !warning && self.is_plain(j, code, distance);
                (plain || self.believes(j, code, warning, distance)).then_some(code)
            }
        };
        let Some(code) = believed else {
            self.go_without(j, ticks);
            return;
        };
        self.tracks[j].take_after(code, ticks);
        let c = &self.memory.coefficients;
        let observer = &mut self.memory.estimates.observers[j];
        observer.coast(ticks, 0.0);
        observer.correct(&c.observer, &c.scales[j], code);
    }

    /// The path is a function of time: it goes on by as much as has passed.
    #[cold]
    #[inline(never)]
    fn catch_up(&mut self, ticks: f32) {
        if ticks != 1.0 {
            self.mode.catch_up(ticks - 1.0);
        }
    }

    /// Takes a sample of the torque converter, whose codes no rail has clipped; the time is that of the tick.
    #[inline(always)]
    pub fn take_torque(&mut self, codes: &[i32; 4], input: &TickInput<'_>) {
        let limits = &self.memory.thresholds;
        self.clock.compare(&limits.clock, input.conversions, &mut self.findings);
        if self.trace.in_control {
            self.torques.compare(
                &limits.torque,
                codes,
                &self.trace.acting,
                &self.trace.speed_error,
                self.blind,
                &mut self.findings,
            );
        }
    }

    /// A register of the torque converter, read back with a good check sum, is not what was written.
    #[cold]
    pub fn adc_misconfigured(&mut self) {
        self.miss(ADC, Fault::AdcConfiguration);
        self.findings.raise(Finding::new(Fault::AdcConfiguration));
    }

    /// A command to the torque converter was refused.
    #[cold]
    pub fn adc_refused(&mut self) {
        self.findings.limit(Limit::AdcCommand);
    }

    /// Ends the samples of a tick.
    #[inline(always)]
    pub fn end_sampling(&mut self) {
        // What LDAC passed on at this tick's start shows at the next one.
        if self.acknowledged {
            self.trace.acting = self.trace.written;
        }
        if self.leaking {
            self.drain();
        }
    }

    /// Counts this tick's good samples of devices that have lost some.
    #[cold]
    #[inline(never)]
    fn drain(&mut self) {
        let mut level = 0;
        let rejected = self.rejected;
        for (index, bucket) in self.buckets.iter_mut().enumerate() {
            // The DAC's turn comes with its write, a converter's once it is configured.
            let sampled =
                index < JOINTS && self.seen >> index & 1 != 0 || index == ADC && self.adc_ready;
            if sampled && rejected >> index & 1 == 0 {
                bucket.good();
            }
            level |= bucket.level();
        }
        self.leaking = level != 0;
        let [now, before] = self.implausible;
        if now.count_ones() > 1 && before.count_ones() > 1 {
            self.findings.raise(Finding { fault: Fault::EncodersSwapped, joints: now });
        }
        self.implausible = [0, now];
    }

    /// Whether the code of joint `j`, which stands while the set-point is somewhere else by now, has to follow it.
    #[inline(always)]
    fn is_stuck(&mut self, j: usize) -> bool {
        let (track, aim) = (&mut self.tracks[j], &self.trace.aim);
        // A joint that is driven away, or swings, stands still at times while the set-point goes on.
        let driven = self.trace.soft || self.trace.loose != 0 || self.trace.isolated != 0;
        if driven || !self.mode.adapts() {
            track.excuse(aim.position[j]);
            return false;
        }
        let limits = &self.memory.thresholds.encoder;
        // While the set-point accelerates, joints lag behind it.
        let lag = aim.acceleration[j].abs() * limits.per_acceleration[j] * limits.lag;
        track.is_stuck(aim.position[j], limits.stuck + lag as u32, limits.patience)
    }

    /// A closer look at the code of joint `j`, which is `distance` counts from where it is expected.
    #[cold]
    #[inline(never)]
    fn believes(&mut self, j: usize, code: u32, warning: bool, distance: i32) -> bool {
        let j = j % JOINTS;
        let bit = 1 << j;
        if warning {
            self.findings.limit(Limit::EncoderWarning);
        }
        if self.blind & bit != 0 {
            return false;
        }
        let track = &mut self.tracks[j];
        if self.seen & bit == 0 {
            self.seen |= bit;
            *track = Track::at_rest(code);
            self.memory.estimates.observers[j] = track.observer();
            return true;
        }
        if track.stands(code, self.trace.aim.position[j]) && self.is_stuck(j) {
            self.miss(j, Fault::EncoderStuck);
            return false;
        }
        if distance.unsigned_abs() <= self.memory.thresholds.encoder.tight[j] {
            return true;
        }
        let loose = self.is_loose();
        let track = &mut self.tracks[j];
        // Where joints need not follow the law, it does not say where to expect them either; what was coasted
        // over since the last believed sample grows with the square of the ticks.
        let ticks = 1 + u32::from(self.buckets[j].level()) / 2;
        let wide = self.memory.thresholds.encoder.wide[j] * ticks * ticks;
        let possible = loose && track.distance(code, 0.0).unsigned_abs() <= wide;
        // A load drives a joint one way; codes that are off to either side in turn are no motion.
        let driven = self.torques.suspect != 0 || self.trace.isolated != 0;
        let turns = track.turns(distance > 0) && !driven;
        let condemned = (turns || !possible) && track.reject(self.tick.wrapping_add(1));
        if possible && !condemned {
            return true;
        }
        if !loose {
            self.implausible[0] |= bit;
        }
        if condemned {
            self.condemn(j, Fault::EncoderImplausible);
        }
        self.miss(j, Fault::EncoderImplausible);
        false
    }

    /// Whether joints may move in other ways than the law wants: not under control, against a brake, at a torque limit, with a
    /// torque that differs from its command, without torque, swinging, or while something drives them away.
    fn is_loose(&self) -> bool {
        !self.trace.in_control
            || self.trace.loose != 0
            || self.torques.suspect != 0
            || self.trace.isolated != 0
            || self.trace.soft
            || !self.mode.adapts()
            || self.is_driven()
    }

    /// Whether something drives a joint away.
    fn is_driven(&self) -> bool {
        let limits = &self.memory.thresholds.torque.speed_error;
        self.trace.speed_error.iter().zip(limits).any(|(v, limit)| v.abs() > *limit)
    }

    /// Acceleration that the law wanted two ticks ago, word steps a tick².
    fn expected(&self, j: usize) -> f32 {
        let [even, odd] = &self.trace.wanted;
        let wanted = if self.turn == 0 { even } else { odd };
        wanted.get(j).copied().unwrap_or_default()
    }

    /// Goes on by the model where there is no sample of joint `j` to believe.
    #[cold]
    #[inline(never)]
    fn go_without(&mut self, j: usize, ticks: f32) {
        let expected = if self.torques.suspect == 0 { self.expected(j) } else { 0.0 };
        if let Some(track) = self.tracks.get_mut(j) {
            track.coast(ticks, expected);
        }
        if let Some(observer) = self.memory.estimates.observers.get_mut(j) {
            observer.coast(ticks, expected);
        }
    }

    /// Counts a failure of device `index`; too many are `fault`.
    #[cold]
    #[inline(never)]
    pub fn miss(&mut self, index: usize, fault: Fault) {
        self.rejected |= 1 << index;
        self.leaking = true;
        self.findings.limit(Limit::SampleRejected);
        if self.buckets.get_mut(index).is_some_and(|bucket| bucket.miss()) {
            match index {
                ADC | DAC => self.findings.raise(Finding::new(fault)),
                _ => self.condemn(index, fault),
            }
        }
    }

    /// From here on the model alone says where joint `j` is.
    fn condemn(&mut self, j: usize, fault: Fault) {
        // Before its first sample a joint has no estimate that could go on.
        if self.seen >> j & 1 != 0 {
            self.go_blind(j);
            self.findings.raise(Finding::of_joint(fault, j));
        }
    }

    /// What the samples of joint `j` have done to the estimates is undone: it is taken to be where the law had it,
    /// and the disturbance to be what it was before.
    #[cold]
    #[inline(never)]
    pub fn go_blind(&mut self, j: usize) {
        if self.blind >> j & 1 != 0 {
            return;
        }
        self.blind |= 1 << j;
        self.spoilt = true;
        if !self.trace.in_control {
            return;
        }
        let j = j % JOINTS;
        let (aim, scale) = (&self.trace.aim, &self.memory.coefficients.scales[j]);
        let velocity = scale.words(aim.velocity[j]);
        let estimate = Observer { position: aim.position[j], velocity };
        self.tracks[j].follow(&estimate);
        let estimates = &mut self.memory.estimates;
        estimates.observers[j] = estimate;
        estimates.set_d_hat(self.trace.d_old);
    }
}
