//! Reading the sensors, and what is believed of them.

use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::spi::SpiDevice;
use shared::arm::JOINTS;
use shared::fault::{Fault, Limit};

use super::{ADC, DAC, Executive, TickInput};
use crate::drivers::encoder::{self, Sample};
use crate::drivers::SampleError;
use crate::monitor::{Comparison, Elapsed, Finding, Track, Verdict};
use crate::supervisor::ALL;

impl<S: SpiDevice, O: OutputPin, I: InputPin> Executive<S, O, I> {
    /// Reads encoders, in joint order as their latch offsets assume, and the torque converter.
    #[inline(always)]
    pub(super) fn sample(&mut self, input: &TickInput<'_>) {
        self.stages = self.stages << 4 | 2;
        self.rejected = 0;
        self.implausible = [0, self.implausible[0]];
        let limits = &self.memory.live.thresholds.clock;
        let elapsed = self.clock.tick(limits, input.cycles, input.spent, &mut self.findings);
        self.check_estimates();
        match elapsed {
            Elapsed::Regular => {
                // Written out: with constant indices no address is computed.
                self.sample_joint(0);
                self.sample_joint(1);
                self.sample_joint(2);
                self.sample_joint(3);
            }
            Elapsed::Irregular(ticks) => self.sample_after(ticks),
        }
        let [now, before] = self.implausible;
        if now != 0 && now.count_ones() > 1 && before.count_ones() > 1 {
            self.findings.raise(Finding { fault: Fault::EncodersSwapped, joints: now });
        }
        if self.adc_ready {
            self.sample_torque(input);
        }
    }

    /// Reads the encoder of joint `j` and advances its observer by one tick.
    #[inline(always)]
    fn sample_joint(&mut self, j: usize) {
        let read = encoder::read(&mut self.io.encoders[j], &self.layouts[j]);
        let expected = self.trace.expected[0][j];
        if let Ok(sample) = read {
            let window = self.memory.live.thresholds.encoder.tight[j];
            let distance = self.tracks[j].distance(sample.code, expected);
            let plain = distance.wrapping_add_unsigned(window) as u32 <= 2 * window
                && !self.is_unusual(j, sample.warning)
                && !self.tracks[j].is_stuck(sample.code, self.trace.target[j]);
            if plain || self.believes(j, &sample, distance) {
                self.tracks[j].take(sample.code);
                self.buckets[j].good();
                let c = &self.memory.live.coefficients;
                let observer = &mut self.memory.estimates.observers[j];
                observer.update(&c.observer, &c.scales[j], sample.code);
                return;
            }
        }
        self.go_without(j, read.err(), 1.0);
    }

    /// Whether a sample needs a closer look whatever its code.
    #[inline(always)]
    fn is_unusual(&self, j: usize, warning: bool) -> bool {
        warning || (self.blind | (ALL & !self.seen)) >> j & 1 != 0
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
        let window = &self.memory.live.thresholds.encoder;
        let loose = !self.trace.in_control
            || self.trace.loose != 0
            || self.torques.suspect != 0
            || self.mode.isolated() != 0;
        let windows = if loose { &window.wide } else { &window.tight };
        let Some(window) = windows.get(j).copied() else { return false };
        let target = self.trace.target.get(j).copied().unwrap_or_default();
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

    /// Counts a lost or refused sample of joint `j` and goes on by the model.
    #[cold]
    #[inline(never)]
    fn go_without(&mut self, j: usize, error: Option<SampleError>, ticks: f32) {
        if error.is_some() {
            self.miss(j, Fault::EncoderLost);
        }
        let expected = self.trace.expected[0].get(j).copied().unwrap_or_default();
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
        self.mode.catch_up(ticks - 1.0);
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
            let c = &self.memory.live.coefficients;
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
        let limits = &self.memory.live.thresholds;
        self.clock.compare(&limits.clock, input.conversions, &mut self.findings);
        match self.adc.sample(&mut self.io.adc) {
            Ok(sample) if sample.overrange == 0 => {
                self.buckets[ADC].good();
                if sample.command_refused {
                    self.findings.limit(Limit::AdcCommand);
                }
                if self.trace.in_control {
                    let [_, _, acted] = &self.trace.torque;
                    let seen = Comparison {
                        codes: &sample.codes,
                        applied: acted.as_ref(),
                        speed_error: self.trace.speed_error.as_ref(),
                    };
                    self.torques.compare(&limits.torque, &seen, &mut self.findings);
                }
            }
            Ok(_) => self.miss(ADC, Fault::TorqueAdcLost),
            Err(SampleError::Reset) => self.miss(ADC, Fault::AdcReset),
            Err(SampleError::Configuration) => self.miss(ADC, Fault::AdcConfiguration),
            Err(_) => self.miss(ADC, Fault::TorqueAdcLost),
        }
    }

    /// Counts a failure of device `index`; too many are `fault`.
    #[cold]
    #[inline(never)]
    pub(super) fn miss(&mut self, index: usize, fault: Fault) {
        self.rejected |= 1 << index;
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
            self.findings.raise(Finding::of_joint(fault, j));
        }
    }
}
