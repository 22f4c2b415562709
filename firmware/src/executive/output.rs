//! What a tick does to pins, drives and telemetry.

use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::spi::SpiDevice;
use shared::arm::JOINTS;
use shared::fault::{Fault, Limit};
use shared::telemetry::Record;

use super::control::Control;
use super::{DAC, Executive, RecordSink};
use crate::JointVector;
use crate::supervisor::Levels;
use crate::math::round_to_i32;
use crate::memory::Health;
use crate::monitor::Finding;

/// DAC code of no torque, offset binary.
pub(super) const DAC_ZERO: u16 = 0x8000;
/// Codes from DAC mid-scale to full scale.
const DAC_HALF_SCALE: f32 = 32_768.0;
/// A tick that went through all its stages, and one that looked for the good copy of the parameters.
const WHOLE: [u32; 2] = [0x1_2345, 0x16];

impl<S: SpiDevice, O: OutputPin, I: InputPin> Executive<S, O, I> {
    /// Passes the last tick's torques on, if all four arrived.
    #[inline(always)]
    pub(super) fn update(&mut self) -> bool {
        self.stages = 1;
        self.turn ^= 1;
        if self.acknowledged { self.io.outputs.pulse_ldac() } else { self.io.outputs.rest_ldac() }
    }

    /// Drives the pins that decide about motion.
    #[inline(always)]
    pub(super) fn drive(&mut self, levels: Levels) -> bool {
        self.powered = levels.drives | levels.release << 4;
        self.io.outputs.drive(levels)
    }

    /// Encodes torques and writes them; LDAC of the next tick makes them act.
    #[inline(always)]
    pub(super) fn write(&mut self, torque: &JointVector) -> [u16; JOINTS] {
        self.stages = self.stages << 4 | 5;
        let scales = &self.memory.coefficients.codes_per_torque;
        let codes = torque.component_mul(scales).map(dac_code).into();
        if self.dac_ready {
            let answer = self.dac.write(&mut self.io.dac, codes);
            // Without a valid status the DAC may have been reset and echo codes that move nothing.
            self.acknowledged = answer.accepted && answer.status.is_some();
            if self.acknowledged {
                if self.leaking {
                    self.buckets[DAC].good();
                }
                self.trace.written = *torque;
            } else {
                self.write_failed(answer.reset);
            }
        }
        codes
    }

    #[cold]
    #[inline(never)]
    fn write_failed(&mut self, reset: bool) {
        self.miss(DAC, Fault::DacNotAcknowledged);
        if reset {
            self.findings.raise(Finding::new(Fault::DacReset));
        }
    }

    /// Reacts in the same tick to what was found after the supervisor's turn.
    #[inline(always)]
    pub(super) fn conclude(&mut self, driven: bool) {
        if !driven {
            self.findings.raise(Finding::new(Fault::PinNotDriven));
        }
        if self.findings.worst.fault != self.judged {
            self.react_and_drive();
        }
    }

    #[cold]
    #[inline(never)]
    fn react_and_drive(&mut self) {
        self.react();
        let levels = self.mode.levels(&self.memory.thresholds.timing);
        // A pin that fails again is found again in the next tick.
        self.drive(levels);
    }

    /// A tick whose parameters' copies differ: torque stays, one more step towards the good copy. No sample is
    /// taken, so to the next tick more than one has passed.
    #[cold]
    #[inline(never)]
    pub(super) fn repair(&mut self) -> Control {
        self.stages = self.stages << 4 | 6;
        let lost = self.memory.search(&mut self.search) == Health::Lost;
        let fault = if lost { Fault::ParametersLost } else { Fault::ParameterFlipped };
        self.findings.raise(Finding::new(fault));
        self.react_and_drive();
        self.acknowledged = false;
        let zero = JointVector::repeat(0.0);
        Control { torque: zero, e1: zero, qd: zero, e1_dot: zero, saturated: 0 }
    }

    /// Toggles the watchdog's pin when it is due, if the tick went through all its stages.
    #[inline(always)]
    pub(super) fn feed_watchdog(&mut self) {
        let (interval, left) = &mut self.feed;
        *left = left.wrapping_sub(1);
        if *left == 0 {
            *left = *interval;
            if WHOLE.contains(&self.stages) {
                self.fed = !self.fed;
                let _ = self.io.outputs.feed(self.fed);
            }
        }
    }

    /// Queues the tick's record; a full queue drops it and counts.
    #[inline(always)]
    pub(super) fn publish(
        &mut self,
        control: &Control,
        dac: [u16; JOINTS],
        records: &mut impl RecordSink,
    ) {
        let d_hat = self.memory.estimates.d_hat;
        let adaptation_bound = self.memory.coefficients.law.at_bound(&d_hat);
        if adaptation_bound != 0 {
            self.findings.limit(Limit::Adaptation);
        }
        let status = self.mode.status(&self.memory.thresholds.timing);
        let stopped = status.finding.fault != Fault::None;
        let finding = if stopped { status.finding } else { self.findings.worst };
        let kept = records.push(Record {
            tick: self.tick,
            mode: status.code as u8,
            refusal: self.refusal as u8,
            fault: finding.fault as u16,
            saturated: control.saturated,
            adaptation_bound,
            rejected: self.rejected,
            dropped: self.dropped,
            phase: status.phase,
            code: self.codes(),
            e1: control.e1.into(),
            qd: control.qd.into(),
            e1_dot: control.e1_dot.into(),
            dac,
            adc: self.adc.codes(),
            d_hat: d_hat.into(),
            limits: self.findings.limits | status.limits,
            joints: finding.joints,
            powered: self.powered,
            path_rate: status.path_rate,
            irregular: self.clock.irregular,
            bucket: self.fullest(),
        });
        if !kept {
            self.dropped = self.dropped.saturating_add(1);
        }
        self.tick = self.tick.wrapping_add(1);
    }

    /// Level of the fullest bucket, if any device failed in this tick.
    #[inline(always)]
    fn fullest(&self) -> u8 {
        if self.rejected == 0 { 0 } else { self.fullest_of_all() }
    }

    #[cold]
    #[inline(never)]
    fn fullest_of_all(&self) -> u8 {
        self.buckets.iter().fold(0, |most, b| if b.level() > most { b.level() } else { most })
    }
}

/// Torque in DAC codes; what is no number or out of range gives no torque.
#[inline(always)]
fn dac_code(codes: f32) -> u16 {
    let codes = if codes.abs() <= DAC_HALF_SCALE { codes } else { 0.0 };
    let code = round_to_i32(codes).wrapping_add(i32::from(DAC_ZERO));
    // Positive full scale itself is one code too many.
    (code - (code >> 16)) as u16
}
