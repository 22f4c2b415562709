//! Measured torque against the torque that the drives were told.
//!
//! A difference alone may be the transducer's fault: it warns, and stops the arm when it stays. With a speed
//! error beside it, or where nobody sees the joint, the drive is at fault. A drive that gives nothing leaves its joint limp, which its brake
//! can catch; one that gives something else has to lose its torque.

use bytemuck::{Pod, Zeroable};
use shared::arm::JOINTS;
use shared::fault::{Fault, Limit};

use super::{Finding, Findings};
use crate::JointVector;
use crate::config::Config;

/// Limits of the torque monitor, N m and N, rad/s and m/s.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TorqueLimits {
    /// Torque of one code of the converter.
    scale: [f32; JOINTS],
    warn: [f32; JOINTS],
    wrong: [f32; JOINTS],
    pub(crate) speed_error: [f32; JOINTS],
    /// Ticks after which a lasting difference stops the arm.
    lasting: u32,
}

/// A difference that lasts this long is the transducer's, s.
const LASTING_S: f32 = 0.040;
/// Ticks in a row that a wrong torque must move the joint.
const CONFIRMED: u8 = 3;
/// Ticks in a row that a torque must be nothing, or the opposite of its command, and ticks from the first wrong
/// sample to the last of them: the converter's filter takes three.
const PLAIN: u8 = 3;
const SETTLED: u32 = 8;
/// Shares of the warning threshold within which it must be so: 20 sigma, and what a command moves in the filter's time.
const NOTHING: f32 = 0.1;
const OPPOSITE: f32 = 0.5;
/// Codes of the converter's full scale.
const FULL_SCALE: f32 = 8_388_608.0;

impl TorqueLimits {
    /// For a validated configuration.
    #[inline(never)]
    pub fn set(&mut self, config: &Config) {
        let safety = &config.safety;
        for (scale, joint) in self.scale.iter_mut().zip(&config.joints) {
            *scale = joint.torque_full_scale / FULL_SCALE;
        }
        self.warn = safety.torque_warn;
        self.wrong = safety.torque_wrong;
        self.speed_error = safety.speed_error;
        self.lasting = (LASTING_S * config.tick_hz as f32) as u32;
    }
}

/// State of the monitor.
#[derive(Clone, Copy, Debug, Default)]
pub struct Torques {
    /// Ticks in a row with a wrong torque and a speed error.
    confirmed: [u8; JOINTS],
    /// Ticks in a row with a wrong torque.
    lasting: [u32; JOINTS],
    /// Ticks in a row in which it was nothing, or the opposite of its command.
    plain: [u8; JOINTS],
    /// One bit a joint whose torque was wrong at the last sample.
    pub suspect: u8,
}

impl Torques {
    /// Before the first sample.
    pub const NONE: Self = {
        let none = [0; JOINTS];
        Self { confirmed: none, lasting: [0; JOINTS], plain: none, suspect: 0 }
    };

    /// Compares one sample of all joints: codes of the converter, what the drives gave if they obeyed (N m
    /// and N), speed less its set-point (rad/s and m/s), and the joints that no encoder sees, one bit each.
    #[inline(always)]
    pub fn compare(
        &mut self,
        l: &TorqueLimits,
        codes: &[i32; JOINTS],
        applied: &JointVector,
        speed_error: &JointVector,
        blind: u8,
        findings: &mut Findings,
    ) {
        let off = |j: usize| (codes[j] as f32 * l.scale[j] - applied[j]).abs() > l.warn[j];
        if off(0) | off(1) | off(2) | off(3) | (self.suspect != 0) {
            self.judge_all(l, codes, applied, speed_error, blind, findings);
        }
    }

    #[cold]
    #[inline(never)]
    fn judge_all(
        &mut self,
        l: &TorqueLimits,
        codes: &[i32; JOINTS],
        applied: &JointVector,
        speed_error: &JointVector,
        blind: u8,
        findings: &mut Findings,
    ) {
        self.suspect = 0;
        for j in 0..JOINTS {
            let (warn, applied) = (l.warn[j], applied[j]);
            let measured = codes[j] as f32 * l.scale[j];
            let difference = (measured - applied).abs();
            if difference > warn {
                findings.limit(Limit::TorqueDrift);
            }
            if difference <= l.wrong[j] {
                (self.confirmed[j], self.lasting[j], self.plain[j]) = (0, 0, 0);
                continue;
            }
            self.suspect |= 1 << j;
            let lasting = self.lasting[j].saturating_add(1);
            // A torque that is nothing or the opposite from the start on is the drive's doing: a transducer that
            // drifts passes there later, if at all.
            let nothing = measured.abs() <= NOTHING * warn;
            let plain = nothing || (measured + applied).abs() <= OPPOSITE * warn;
            let plain_ticks = if plain { self.plain[j].saturating_add(1) } else { 0 };
            let plain = plain_ticks >= PLAIN && lasting <= SETTLED;
            let dead = if plain { nothing } else { measured.abs() <= l.wrong[j] };
            let moves = speed_error[j].abs() > l.speed_error[j] || blind >> j & 1 != 0;
            let confirmed = if moves { self.confirmed[j].saturating_add(1) } else { 0 };
            (self.confirmed[j], self.lasting[j], self.plain[j]) = (confirmed, lasting, plain_ticks);
            if plain || confirmed >= CONFIRMED {
                let fault = if dead { Fault::DriveLost } else { Fault::TorqueWrong };
                findings.raise(Finding::of_joint(fault, j));
            } else if lasting >= l.lasting {
                findings.raise(Finding::of_joint(Fault::TorqueDrift, j));
            }
        }
    }
}
