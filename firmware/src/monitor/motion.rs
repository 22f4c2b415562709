//! Speed, range of motion and distance to the set-point.

use bytemuck::{Pod, Zeroable};
use shared::arm::JOINTS;
use shared::fault::Fault;

use super::{Finding, Findings};
use crate::config::Config;
use crate::estimator::FRACTION_BITS;

/// Limits of the motion monitor; joint 4 in m.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct MotionLimits {
    /// Range of motion with its overtravel, position words.
    lowest: [u32; JOINTS],
    highest: [u32; JOINTS],
    /// Speed, rad/s and m/s.
    speed: [f32; JOINTS],
    /// Position error that must not last.
    tracking: [f32; JOINTS],
    /// Ticks that it may last.
    lasting: u32,
    /// Position error that cannot be.
    window: [f32; JOINTS],
}

impl MotionLimits {
    /// For a validated configuration.
    pub fn new(config: &Config) -> Self {
        let safety = &config.safety;
        let mut limits = Self {
            lowest: [0; JOINTS],
            highest: [u32::MAX; JOINTS],
            speed: config.joints.map(|j| j.qd_max * safety.overspeed),
            tracking: safety.tracking,
            lasting: (safety.tracking_s * config.tick_hz as f32) as u32,
            window: safety.error_window,
        };
        let slots = limits.lowest.iter_mut().zip(&mut limits.highest);
        for ((joint, over), (lowest, highest)) in config.joints.iter().zip(safety.overtravel).zip(slots)
        {
            let words = |q: f32| (q - joint.encoder_zero) / joint.encoder_lsb * WORDS;
            // The casts stop at what a word can hold.
            *lowest = words(joint.q_min - over) as u32;
            *highest = words(joint.q_max + over) as u32;
        }
        limits
    }
}

impl MotionLimits {
    /// Whether each joint is where it can be.
    pub fn contain(&self, codes: &[u32; JOINTS]) -> bool {
        let ranges = self.lowest.iter().zip(&self.highest);
        codes.iter().zip(ranges).all(|(&code, (&lowest, &highest))| {
            code <= highest >> FRACTION_BITS && code << FRACTION_BITS >= lowest
        })
    }
}

const WORDS: f32 = (1 << FRACTION_BITS) as f32;
/// Ticks in a row that a joint must be too fast.
const FAST_TICKS: u8 = 3;

/// State of the monitor.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motions {
    fast: u8,
    astray: u32,
}

/// What is judged.
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a> {
    /// Position words.
    pub position: [u32; JOINTS],
    /// Speed, rad/s and m/s.
    pub qd: &'a [f32; JOINTS],
    /// Position less its set-point, rad and m.
    pub e1: &'a [f32; JOINTS],
    /// Joints that are not expected to follow the set-point, one bit each.
    pub excused: u8,
}

impl Motions {
    /// Judges one tick under control.
    #[inline(always)]
    pub fn judge(&mut self, l: &MotionLimits, m: &Motion<'_>, findings: &mut Findings) {
        let (mut fast, mut astray, mut out) = (0_u8, 0_u8, 0_u8);
        for j in 0..JOINTS {
            let bit = 1 << j;
            fast |= if m.qd[j].abs() > l.speed[j] { bit } else { 0 };
            astray |= if m.e1[j].abs() > l.tracking[j] { bit } else { 0 };
            let past = m.position[j].wrapping_sub(l.lowest[j]);
            out |= if past > l.highest[j].wrapping_sub(l.lowest[j]) { bit } else { 0 };
        }
        if fast | astray | out != 0 {
            self.suspect([fast, astray & !m.excused, out], l, m, findings);
        } else {
            (self.fast, self.astray) = (0, 0);
        }
    }

    #[cold]
    #[inline(never)]
    fn suspect(
        &mut self,
        [fast, astray, out]: [u8; 3],
        l: &MotionLimits,
        m: &Motion<'_>,
        findings: &mut Findings,
    ) {
        let errors = m.e1.iter().zip(&l.window).enumerate();
        let far = errors.fold(0, |far, (j, (e1, w))| if e1.abs() > *w { far | 1 << j } else { far });
        let far = far & astray;
        self.fast = if fast != 0 { self.fast.saturating_add(1) } else { 0 };
        self.astray = if astray != 0 { self.astray.saturating_add(1) } else { 0 };
        if self.fast >= FAST_TICKS {
            findings.raise(Finding { fault: Fault::Overspeed, joints: fast });
        }
        if self.astray >= l.lasting {
            findings.raise(Finding { fault: Fault::TrackingError, joints: astray });
        }
        if far != 0 {
            findings.raise(Finding { fault: Fault::ErrorWindow, joints: far });
        }
        if out != 0 {
            findings.raise(Finding { fault: Fault::PositionLimit, joints: out });
        }
    }
}
