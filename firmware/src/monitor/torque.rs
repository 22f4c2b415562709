//! Measured torque against the torque that the drives were told.
//!
//! A difference alone may be the transducer's fault: it warns, and stops the arm when it stays. With a speed
//! error beside it, the drive is at fault. A drive that gives nothing leaves its joint limp, which its brake
//! can catch; one that gives something else has to lose its torque.

use bytemuck::{Pod, Zeroable};
use shared::arm::JOINTS;
use shared::fault::{Fault, Limit};

use super::{Finding, Findings};
use crate::config::Config;

/// Limits of the torque monitor, N m and N, rad/s and m/s.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TorqueLimits {
    /// Torque of one code of the converter.
    scale: [f32; JOINTS],
    warn: [f32; JOINTS],
    wrong: [f32; JOINTS],
    speed_error: [f32; JOINTS],
    /// Ticks after which a lasting difference stops the arm.
    lasting: u32,
}

/// A difference that lasts this long is the transducer's, s.
const LASTING_S: f32 = 0.040;
/// Ticks in a row that a wrong torque must move the joint.
const CONFIRMED: u8 = 3;
/// Codes of the converter's full scale.
const FULL_SCALE: f32 = 8_388_608.0;

impl TorqueLimits {
    /// For a validated configuration.
    pub fn new(config: &Config) -> Self {
        let safety = &config.safety;
        Self {
            scale: config.joints.map(|j| j.torque_full_scale / FULL_SCALE),
            warn: safety.torque_warn,
            wrong: safety.torque_wrong,
            speed_error: safety.speed_error,
            lasting: (LASTING_S * config.tick_hz as f32) as u32,
        }
    }
}

/// State of the monitor.
#[derive(Clone, Copy, Debug, Default)]
pub struct Torques {
    /// Ticks in a row with a wrong torque and a speed error.
    confirmed: [u8; JOINTS],
    /// Ticks in a row with a wrong torque.
    lasting: [u32; JOINTS],
    /// One bit a joint whose torque was wrong at the last sample.
    pub suspect: u8,
}

/// What is compared at one sample.
#[derive(Clone, Copy, Debug)]
pub struct Comparison<'a> {
    /// Codes of the converter.
    pub codes: &'a [i32; JOINTS],
    /// What the drives gave if they obeyed, N m and N.
    pub applied: &'a [f32; JOINTS],
    /// Speed less its set-point, rad/s and m/s.
    pub speed_error: &'a [f32; JOINTS],
}

impl Torques {
    /// Compares one sample of all joints.
    #[inline(always)]
    pub fn compare(&mut self, l: &TorqueLimits, seen: &Comparison<'_>, findings: &mut Findings) {
        let mut suspect = 0;
        for j in 0..JOINTS {
            let difference = seen.codes[j] as f32 * l.scale[j] - seen.applied[j];
            if difference.abs() > l.warn[j] {
                suspect |= self.judge(l, j, seen, findings);
            }
        }
        if self.suspect != 0 {
            self.relax(suspect);
        }
        self.suspect = suspect;
    }

    /// Forgets the joints that are well again.
    #[cold]
    #[inline(never)]
    fn relax(&mut self, suspect: u8) {
        let joints = self.confirmed.iter_mut().zip(&mut self.lasting);
        for (j, (confirmed, lasting)) in joints.enumerate() {
            if suspect >> j & 1 == 0 {
                (*confirmed, *lasting) = (0, 0);
            }
        }
    }

    /// Judges the difference of joint `j`; gives its bit if the torque is wrong.
    #[cold]
    #[inline(never)]
    fn judge(
        &mut self,
        l: &TorqueLimits,
        j: usize,
        seen: &Comparison<'_>,
        findings: &mut Findings,
    ) -> u8 {
        findings.limit(Limit::TorqueDrift);
        let at = |values: &[f32; JOINTS]| values.get(j).copied().unwrap_or_default();
        let code = seen.codes.get(j).copied().unwrap_or_default();
        let (measured, applied) = (code as f32 * at(&l.scale), at(seen.applied));
        if (measured - applied).abs() <= at(&l.wrong) {
            return 0;
        }
        let moves = at(seen.speed_error).abs() > at(&l.speed_error);
        let (Some(confirmed), Some(lasting)) = (self.confirmed.get_mut(j), self.lasting.get_mut(j))
        else {
            return 0;
        };
        *lasting = lasting.saturating_add(1);
        *confirmed = if moves { confirmed.saturating_add(1) } else { 0 };
        if *confirmed >= CONFIRMED {
            let dead = measured.abs() <= at(&l.wrong);
            let fault = if dead { Fault::DriveLost } else { Fault::TorqueWrong };
            findings.raise(Finding::of_joint(fault, j));
        } else if *lasting >= l.lasting {
            findings.raise(Finding::of_joint(Fault::TorqueDrift, j));
        }
        1 << j
    }
}
