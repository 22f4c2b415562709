//! What a tick does to pins and drives.

use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::spi::SpiDevice;
use shared::arm::JOINTS;

use super::{Control, Executive, TickInput};
use crate::JointVector;
use crate::math::round_to_i32;

/// DAC code of no torque, offset binary.
const DAC_ZERO: u16 = 0x8000;
/// Codes from DAC mid-scale to full scale.
const DAC_HALF_SCALE: f32 = 32_768.0;
/// A tick that went through all its stages, and one that looked for the good copy of the parameters.
const WHOLE: [u32; 2] = [0x1_2345, 0x16];

impl<S: SpiDevice, O: OutputPin, I: InputPin> Executive<'_, S, O, I> {
    /// Passes the last tick's torques on, if all four arrived.
    #[inline(always)]
    pub(super) fn update(&mut self) -> bool {
        self.stages = 1;
        let outputs = &mut self.io.outputs;
        if self.core.is_acknowledged() { outputs.pulse_ldac() } else { outputs.rest_ldac() }
    }

    /// Drives the pins that decide about motion.
    #[inline(always)]
    pub(super) fn drive(&mut self) -> bool {
        let levels = self.core.mode().levels(&self.core.memory().thresholds.timing);
        self.powered = levels.drives | levels.release << 4;
        self.io.outputs.drive(levels)
    }

    /// After a reaction; a pin that fails now is found in the next tick.
    #[cold]
    #[inline(never)]
    pub(super) fn drive_again(&mut self) {
        let levels = self.core.mode().rare_levels(&self.core.memory().thresholds.timing);
        self.powered = levels.drives | levels.release << 4;
        self.io.outputs.drive_rare(levels);
    }

    /// Encodes torques and writes them; LDAC of the next tick makes them act.
    #[inline(always)]
    pub(super) fn write(&mut self, torque: &JointVector) -> [u16; JOINTS] {
        self.stages = self.stages << 4 | 5;
        let scales = &self.core.memory().coefficients.codes_per_torque;
        let codes = torque.component_mul(scales).map(dac_code).into();
        if self.dac_ready {
            let answer = self.dac.write(&mut self.io.dac, codes);
            // Without a valid status the DAC may have been reset and echo codes that move nothing. After a spoilt
            // write none can come: it answers that write's question.
            let known = answer.status.is_some() || !(answer.reset || self.core.is_acknowledged());
            if answer.accepted && known {
                self.core.written(torque);
            } else {
                self.core.not_written(answer.reset);
            }
        }
        codes
    }

    /// A tick whose parameters' copies differ: torque stays as it is, and nothing was sampled or computed.
    #[inline(always)]
    pub(super) fn repair(&mut self, input: &TickInput<'_>) -> (Control, [u16; JOINTS]) {
        self.stages = self.stages << 4 | 6;
        let brakes = self.io.inputs.brakes();
        self.core.repair(input.order, brakes);
        self.drive_again();
        (Control::none(), [DAC_ZERO; JOINTS])
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
}

/// Torque in DAC codes; what is no number or out of range gives no torque.
#[inline(always)]
fn dac_code(codes: f32) -> u16 {
    let codes = if codes.abs() <= DAC_HALF_SCALE { codes } else { 0.0 };
    let code = round_to_i32(codes).wrapping_add(i32::from(DAC_ZERO));
    // Positive full scale itself is one code too many.
    (code - (code >> 16)) as u16
}
