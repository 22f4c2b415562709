//! What a tick leaves: torques at the DAC, and its record.

use shared::arm::JOINTS;
use shared::fault::{Fault, Limit};
use shared::telemetry::Record;

use super::{Control, Core, DAC};
use crate::JointVector;
use crate::monitor::Finding;

impl Core {
    /// The DAC took the torques of this tick: LDAC of the next one makes them act.
    #[inline(always)]
    pub fn written(&mut self, torque: &JointVector) {
        self.acknowledged = true;
        self.trace.written = *torque;
        if self.leaking {
            self.dac_is_good();
        }
    }

    #[cold]
    fn dac_is_good(&mut self) {
        if let Some(bucket) = self.buckets.get_mut(DAC) {
            bucket.good();
        }
    }

    /// The DAC did not take them, and may have been reset.
    #[cold]
    #[inline(never)]
    pub fn not_written(&mut self, reset: bool) {
        self.acknowledged = false;
        self.miss(DAC, Fault::DacNotAcknowledged);
        if reset {
            self.findings.raise(Finding::new(Fault::DacReset));
        }
    }

    /// Whether the DAC took the torques of the last tick.
    #[inline(always)]
    pub fn is_acknowledged(&self) -> bool {
        self.acknowledged
    }

    /// Ends a tick with its record, given what the executive knows: codes of DAC and ADC, and drive enables with
    /// brake releases as driven.
    #[inline(always)]
    pub fn record(
        &mut self,
        control: &Control,
        dac: [u16; JOINTS],
        adc: [i32; JOINTS],
        powered: u8,
        to: &mut Record,
    ) {
        let d_hat = self.memory.estimates.d_hat;
        let adaptation_bound = self.memory.coefficients.law.at_bound(&d_hat);
        if adaptation_bound != 0 {
            self.findings.limit(Limit::Adaptation);
        }
        let status = self.mode.status(&self.memory.thresholds.timing);
        let stopped = status.finding.fault != Fault::None;
        let finding = if stopped { status.finding } else { self.findings.worst };
        let tick = self.tick;
        self.tick = tick.wrapping_add(1);
        *to = Record {
            tick,
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
            adc,
            d_hat: d_hat.into(),
            limits: self.findings.limits | status.limits,
            joints: finding.joints,
            powered,
            path_rate: status.path_rate,
            irregular: self.clock.irregular,
            bucket: if self.rejected == 0 { 0 } else { self.fullest() },
        };
    }

    /// Counts a record that found no room.
    #[cold]
    pub fn record_dropped(&mut self) {
        self.dropped = self.dropped.saturating_add(1);
    }

    /// Level of the fullest bucket.
    #[cold]
    #[inline(never)]
    fn fullest(&self) -> u8 {
        self.buckets.iter().fold(0, |most, b| if b.level() > most { b.level() } else { most })
    }
}
