//! Speed, range of motion and distance to the set-point.

use bytemuck::{Pod, Zeroable};
use shared::arm::JOINTS;
use shared::fault::Fault;

use super::{Finding, Findings};
use crate::JointVector;
use crate::config::Config;
use crate::estimator::{FRACTION_BITS, Observer, Scale};

/// Limits of the motion monitor; joint 4 in m.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct MotionLimits {
    /// Range of motion with its overtravel, position words.
    lowest: [u32; JOINTS],
    span: [u32; JOINTS],
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
    #[inline(never)]
    pub fn new(config: &Config) -> Self {
        let safety = &config.safety;
        let mut limits = Self {
            lowest: [0; JOINTS],
            span: [0; JOINTS],
            speed: config.joints.map(|j| j.qd_max * safety.overspeed),
            tracking: safety.tracking,
            lasting: (safety.tracking_s * config.tick_hz as f32) as u32,
            window: safety.error_window,
        };
        for (j, (joint, over)) in config.joints.iter().zip(safety.overtravel).enumerate() {
            // The casts stop at what a word can hold.
            let words = |q: f32| ((q - joint.encoder_zero) / joint.encoder_lsb * WORDS) as u32;
            limits.lowest[j] = words(joint.q_min - over);
            limits.span[j] = words(joint.q_max + over).wrapping_sub(limits.lowest[j]);
        }
        limits
    }
}

impl MotionLimits {
    /// Whether each joint is where it can be.
    pub fn contain(&self, codes: &[u32; JOINTS]) -> bool {
        let ranges = self.lowest.iter().zip(&self.span);
        codes.iter().zip(ranges).all(|(&code, (&lowest, &span))| {
            // A code beyond what a word holds is far outside.
            code < 1 << (32 - FRACTION_BITS) && (code << FRACTION_BITS).wrapping_sub(lowest) <= span
        })
    }
}

const WORDS: f32 = (1 << FRACTION_BITS) as f32;
/// Rounds in a row that a joint must be too fast.
const FAST_ROUNDS: u8 = 2;

/// State of the monitor.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motions {
    /// Joint whose speed and range are judged at this tick: each has its turn every fourth.
    turn: usize,
    fast: [u8; JOINTS],
    astray: u32,
}

impl Motions {
    /// Before the first tick.
    pub const NONE: Self = Self { turn: 0, fast: [0; JOINTS], astray: 0 };

    /// Judges the distance to the set-point, rad and m, under control; joints in `excused` need not follow it.
    // By value: what a cold path takes by reference has to live in memory.
    #[inline(always)]
    pub fn judge_error(
        &mut self,
        l: &MotionLimits,
        e1: JointVector,
        excused: u8,
        findings: &mut Findings,
    ) {
        let far = |j: usize| e1[j].abs() > l.tracking[j];
        if far(0) | far(1) | far(2) | far(3) {
            self.lose(l, e1, excused, findings);
        } else {
            self.astray = 0;
        }
    }

    /// Judges speed and range of the joint whose turn it is.
    #[inline(always)]
    pub fn judge_motion(
        &mut self,
        l: &MotionLimits,
        observers: &[Observer; JOINTS],
        scales: &[Scale; JOINTS],
        findings: &mut Findings,
    ) {
        let j = self.turn % JOINTS;
        self.turn = j + 1;
        let past = observers[j].position.wrapping_sub(l.lowest[j]) > l.span[j];
        let fast = observers[j].velocity(&scales[j]).abs() > l.speed[j];
        if past | fast | (self.fast[j] != 0) {
            self.suspect(j, past, fast, findings);
        }
    }

    /// The arm is away from its set-point.
    #[cold]
    #[inline(never)]
    fn lose(&mut self, l: &MotionLimits, e1: JointVector, excused: u8, findings: &mut Findings) {
        let astray = beyond(&e1, &l.tracking) & !excused;
        self.astray = if astray != 0 { self.astray.saturating_add(1) } else { 0 };
        if self.astray >= l.lasting {
            findings.raise(Finding { fault: Fault::TrackingError, joints: astray });
        }
        let impossible = beyond(&e1, &l.window) & !excused;
        if impossible != 0 {
            findings.raise(Finding { fault: Fault::ErrorWindow, joints: impossible });
        }
    }

    #[cold]
    #[inline(never)]
    fn suspect(&mut self, j: usize, out: bool, fast: bool, findings: &mut Findings) {
        if out {
            findings.raise(Finding::of_joint(Fault::PositionLimit, j));
        }
        let Some(rounds) = self.fast.get_mut(j) else { return };
        *rounds = if fast { rounds.saturating_add(1) } else { 0 };
        if *rounds >= FAST_ROUNDS {
            findings.raise(Finding::of_joint(Fault::Overspeed, j));
        }
    }
}

/// Joints whose error is beyond its limit, one bit each.
fn beyond(e1: &JointVector, limits: &[f32; JOINTS]) -> u8 {
    let mut bits = 0;
    for (j, (e1, limit)) in e1.iter().zip(limits).enumerate() {
        bits |= u8::from(e1.abs() > *limit) << j;
    }
    bits
}
