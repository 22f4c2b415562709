//! Reading the sensors, and what is believed of them.

use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::spi::SpiDevice;
use shared::arm::JOINTS;
use shared::fault::{Fault, Limit};

use super::{ADC, DAC, Executive, TickInput};
use crate::drivers::encoder::{self, Sample};
use crate::drivers::SampleError;
use crate::monitor::{Elapsed, Finding, Track, Verdict};
use crate::supervisor::ALL;

impl<S: SpiDevice, O: OutputPin, I: InputPin> Executive<S, O, I> {
    /// Reads encoders, in joint order as their latch offsets assume, and the torque converter.
    #[inline(always)]
    pub(super) fn sample(&mut self, input: &TickInput<'_>) {
        self.stages = self.stages << 4 | 2;
        self.rejected = 0;
        let limits = &self.memory.thresholds.clock;
        let elapsed = self.clock.tick(limits, input.cycles, input.spent, &mut self.findings);
        let special = self.blind | (ALL & !self.seen);
        match elapsed {
            Elapsed::Regular if special == 0 => {
                // Written out: with constant indices no address is computed.
                self.sample_joint(0);
                self.sample_joint(1);
                self.sample_joint(2);
                self.sample_joint(3);
            }
            Elapsed::Regular => self.sample_after(1.0),
            Elapsed::Irregular(ticks) => self.sample_after(ticks),
        }
        if self.adc_ready {
            self.sample_torque(input);
        } else {
            self.trace.acting = self.trace.written;
        }
        if self.leaking {
            self.drain();
        }
    }

    /// Reads the encoder of joint `j` and advances its observer by one tick.
    #[inline(always)]
    fn sample_joint(&mut self, j: usize) {
        let read = encoder::read(&mut self.io.encoders[j], &self.layouts[j]);
        if let Ok(sample) = read {
            let window = self.memory.thresholds.encoder.tight[j];
            let expected = self.trace.wanted[self.turn & 1][j];
            let distance = self.tracks[j].distance(sample.code, expected);
            let plain = distance.wrapping_add_unsigned(window) as u32 <= 2 * window
                && !sample.warning
                && !self.tracks[j].is_stuck(sample.code, self.trace.aim.position[j]);
            if plain || self.believes(j, &sample, distance) {
                self.tracks[j].take(sample.code);
                let c = &self.memory.coefficients;
                let observer = &mut self.memory.estimates.observers[j];
                observer.update(&c.observer, &c.scales[j], sample.code);
                return;
            }
        }
        self.go_without(j, read.err(), 1.0);
    }

    /// Counts this tick's good samples of devices that have lost some.
    #[cold]
    #[inline(never)]
    fn drain(&mut self) {
        let mut level = 0;
        let rejected = self.rejected;
        for (index, bucket) in self.buckets.iter_mut().enumerate() {
            // The DAC's turn comes with its write, a converter's once it is configured.
            let sampled = index < JOINTS && self.seen >> index & 1 != 0 || index == ADC && self.adc_ready;
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

    /// A closer look at the code of joint `j`, which is `distance` counts from where it is expected.
    #[cold]
    #[inline(never)]
    fn believes(&mut self, j: usize, sample: &Sample, distance: i32) -> bool {
        let (bit, code) = (1 << j, sample.code);
        if sample.warning {
            self.findings.limit(Limit::EncoderWarning);
        }
        if self.blind & bit != 0 {
            return false;
        }
        let Some(track) = self.tracks.get_mut(j) else { return false };
        if self.seen & bit == 0 {
            self.seen |= bit;
            *track = Track::at_rest(code);
            if let Some(observer) = self.memory.estimates.observers.get_mut(j) {
                *observer = track.observer();
            }
            return true;
        }
        let window = &self.memory.thresholds.encoder;
        let loose = !self.trace.in_control
            || self.trace.loose != 0
            || self.torques.suspect != 0
            || self.mode.isolated() != 0;
        let windows = if loose { &window.wide } else { &window.tight };
        let Some(window) = windows.get(j).copied() else { return false };
        let target = self.trace.aim.position.get(j).copied().unwrap_or_default();
        let verdict = if track.is_stuck(code, target) && self.mode.follows() {
            Verdict::Stuck
        } else if distance.unsigned_abs() > window {
            Verdict::Implausible
        } else {
            Verdict::Good
        };
        match verdict {
            Verdict::Good => return true,
            Verdict::Stuck => self.miss(j, Fault::EncoderStuck),
            Verdict::Implausible => {
                self.implausible[0] |= bit;
                if track.reject(self.tick.wrapping_add(1)) {
                    self.condemn(j, Fault::EncoderImplausible);
                }
                self.miss(j, Fault::EncoderImplausible);
            }
        }
        false
    }

    /// Acceleration that the law wanted two ticks ago, word steps a tick².
    fn expected(&self, j: usize) -> f32 {
        let [even, odd] = &self.trace.wanted;
        let wanted = if self.turn == 0 { even } else { odd };
        wanted.get(j).copied().unwrap_or_default()
    }

    /// Counts a lost or refused sample of joint `j` and goes on by the model.
    #[cold]
    #[inline(never)]
    fn go_without(&mut self, j: usize, error: Option<SampleError>, ticks: f32) {
        if error.is_some() {
            self.miss(j, Fault::EncoderLost);
        }
        let expected = self.expected(j);
        if let Some(track) = self.tracks.get_mut(j) {
            track.coast(ticks, expected);
        }
        if let Some(observer) = self.memory.estimates.observers.get_mut(j) {
            observer.coast(ticks, expected);
        }
    }

    /// As [`Self::sample_joint`] for all joints, `ticks` after the last samples.
    #[cold]
    #[inline(never)]
    fn sample_after(&mut self, ticks: f32) {
        // The path is a function of time.
        if ticks != 1.0 {
            self.mode.catch_up(ticks - 1.0);
        }
        for j in 0..JOINTS {
            let (Some(port), Some(layout)) = (self.io.encoders.get_mut(j), self.layouts.get(j))
            else {
                continue;
            };
            let read = encoder::read(port, layout);
            let believed = read.ok().filter(|sample| {
                let distance = self
                    .tracks
                    .get(j)
                    .map_or(0, |track| track.distance_after(sample.code, ticks));
                // What acceleration leaves open grows with the square of the time.
                let distance = distance as f32 / (1.0 + ticks * ticks);
                self.believes(j, sample, distance as i32)
            });
            let (Some(sample), Some(track)) = (believed, self.tracks.get_mut(j)) else {
                self.go_without(j, read.err(), ticks);
                continue;
            };
            track.take_after(sample.code, ticks);
            let c = &self.memory.coefficients;
            let observers = self.memory.estimates.observers.iter_mut().zip(&c.scales);
            if let Some((observer, scale)) = observers.into_iter().nth(j) {
                observer.coast(ticks, 0.0);
                observer.correct(&c.observer, scale, sample.code);
            }
        }
    }

    /// Reads the torque converter and compares torque with its command.
    #[inline(always)]
    fn sample_torque(&mut self, input: &TickInput<'_>) {
        let limits = &self.memory.thresholds;
        self.clock.compare(&limits.clock, input.conversions, &mut self.findings);
        match self.adc.sample(&mut self.io.adc) {
            Ok(sample) if sample.overrange == 0 => {
                if sample.command_refused {
                    self.findings.limit(Limit::AdcCommand);
                }
                if self.trace.in_control {
                    self.torques.compare(
                        &limits.torque,
                        &sample.codes,
                        &self.trace.acting,
                        &self.trace.speed_error,
                        &mut self.findings,
                    );
                }
            }
            Ok(_) => self.miss(ADC, Fault::TorqueAdcLost),
            Err(SampleError::Reset) => self.miss(ADC, Fault::AdcReset),
            Err(SampleError::Configuration) => self.miss(ADC, Fault::AdcConfiguration),
            Err(_) => self.miss(ADC, Fault::TorqueAdcLost),
        }
        // What LDAC passed on at this tick's start shows at the next one.
        if self.acknowledged {
            self.trace.acting = self.trace.written;
        }
    }

    /// Counts a failure of device `index`; too many are `fault`.
    #[cold]
    #[inline(never)]
    pub(super) fn miss(&mut self, index: usize, fault: Fault) {
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
            self.blind |= 1 << j;
            self.may_adapt = false;
            self.findings.raise(Finding::of_joint(fault, j));
        }
    }
}
