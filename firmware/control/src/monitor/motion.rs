//! Speed, range of motion and distance to the set-point.

use bytemuck::{Pod, Zeroable};
use shared::arm::JOINTS;
use shared::fault::Fault;

use super::{Finding, Findings};
use crate::JointVector;
use crate::config::Config;
use crate::estimator::{self, FRACTION_BITS, Observer, Scale};
use crate::math::max;

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
    /// Speed error that counts as swinging, half a count a tick more than the configured one: that is what
    /// quantisation leaves of a speed. And ticks within which it must come back.
    swing: [f32; JOINTS],
    period: u32,
}

impl MotionLimits {
    /// For a validated configuration.
    #[inline(never)]
    pub fn set(&mut self, config: &Config) {
        let (safety, tick_hz) = (&config.safety, config.tick_hz as f32);
        self.tracking = safety.tracking;
        self.lasting = (safety.tracking_s * tick_hz) as u32;
        self.window = safety.error_window;
        self.period = (SWING_S * tick_hz) as u32;
        let noise = estimator::Gains::new(config.gains.observer_rad_s, tick_hz).l2;
        for (j, joint) in config.joints.iter().enumerate() {
            self.speed[j] = joint.qd_max * safety.overspeed;
            self.swing[j] = safety.swing[j] + 2.0 * noise * joint.encoder_lsb * tick_hz;
            // The casts stop at what a word can hold.
            let words = |q: f32| ((q - joint.encoder_zero) / joint.encoder_lsb * WORDS) as u32;
            let over = safety.overtravel[j];
            self.lowest[j] = words(joint.q_min - over);
            self.span[j] = words(joint.q_max + over).wrapping_sub(self.lowest[j]);
        }
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

/// Half a period of the slowest swinging that is told, s: the laws' own dynamics are faster.
const SWING_S: f32 = 0.05;
const WORDS: f32 = (1 << FRACTION_BITS) as f32;
/// Multiple of a swinging joint's least speed error that only a load explains.
const DRIVEN: f32 = 3.0;
/// Rounds in a row that a joint must be too fast.
const FAST_ROUNDS: u8 = 2;

/// State of the monitor.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motions {
    /// Ticks so far: the joints have their turns to be judged, each every fourth.
    turn: usize,
    fast: [u8; JOINTS],
    swings: [Swing; JOINTS],
    astray: u32,
}

impl Motions {
    /// Before the first tick.
    pub const NONE: Self = {
        let swing = Swing { since: 0, turns: 0, forward: false, peak: 0.0, before: 0.0 };
        Self { turn: 0, fast: [0; JOINTS], swings: [swing; JOINTS], astray: 0 }
    };

    /// Whether a joint is away from its set-point, rad and m, so that [`Motions::judge_error`] has to look into it.
    #[inline(always)]
    pub fn is_far(&mut self, l: &MotionLimits, e1: &JointVector) -> bool {
        let far = |j: usize| e1[j].abs() > l.tracking[j];
        let any = far(0) | far(1) | far(2) | far(3);
        if !any {
            // A joint that swings is near its set-point in between.
            self.astray = self.astray.saturating_sub(1);
        }
        any
    }

    /// Judges the distance to the set-point, rad and m, under control; joints in `excused` need not follow it.
    /// Whether it is more than control can explain.
    pub fn judge_error(
        &mut self,
        l: &MotionLimits,
        e1: &JointVector,
        excused: u8,
        findings: &mut Findings,
    ) -> bool {
        let astray = beyond(e1, &l.tracking) & !excused;
        let impossible = beyond(e1, &l.window) & !excused;
        self.astray = if astray != 0 { self.astray.saturating_add(1) } else { 0 };
        if self.astray >= l.lasting {
            findings.raise(Finding { fault: Fault::TrackingError, joints: astray });
        }
        if impossible != 0 {
            findings.raise(Finding { fault: Fault::ErrorWindow, joints: impossible });
        }
        impossible != 0
    }

    /// Judges speed, range and swinging of the joint whose turn it is; whether something drives it away.
    #[inline(always)]
    pub fn judge(
        &mut self,
        l: &MotionLimits,
        observers: &[Observer; JOINTS],
        scales: &[Scale; JOINTS],
        e1_dot: &JointVector,
        findings: &mut Findings,
    ) -> bool {
        let j = self.turn % JOINTS;
        self.turn = self.turn.wrapping_add(1);
        let past = observers[j].position.wrapping_sub(l.lowest[j]) > l.span[j];
        let fast = observers[j].velocity(&scales[j]).abs() > l.speed[j];
        let swings = e1_dot[j].abs() > l.swing[j];
        if past | fast | swings | (self.fast[j] != 0) {
            return self.suspect(j, (past, fast), e1_dot[j], l, findings);
        }
        false
    }

    #[cold]
    #[inline(never)]
    fn suspect(
        &mut self,
        j: usize,
        (past, fast): (bool, bool),
        e1_dot: f32,
        l: &MotionLimits,
        findings: &mut Findings,
    ) -> bool {
        if past {
            findings.raise(Finding::of_joint(Fault::PositionLimit, j));
        }
        if let Some(rounds) = self.fast.get_mut(j) {
            *rounds = if fast { rounds.saturating_add(1) } else { 0 };
            if *rounds >= FAST_ROUNDS {
                findings.raise(Finding::of_joint(Fault::Overspeed, j));
            }
        }
        let (Some(swing), Some(limit)) = (self.swings.get_mut(j), l.swing.get(j)) else {
            return false;
        };
        // An infinite speed is a damaged estimate, which is told elsewhere, and no swinging.
        if !e1_dot.is_finite() {
            return false;
        }
        if e1_dot.abs() > *limit && swing.turns(e1_dot, self.turn, l.period) {
            findings.raise(Finding::of_joint(Fault::Oscillation, j));
        }
        e1_dot.abs() > DRIVEN * limit
    }
}

/// Swinging of one joint about its set-point.
#[derive(Clone, Copy, Debug, Default)]
struct Swing {
    /// When it last turned.
    since: usize,
    /// Turns, each soon after the one before and after a half swing that did not die away.
    turns: u8,
    forward: bool,
    /// Highest error of this half swing and of the one before, rad/s and m/s.
    peak: f32,
    before: f32,
}

/// A joint that has turned this often swings: what a step of the load sets off has died down by then.
const TURNS: u8 = 6;
/// Share of the half swing before that one must reach to count: what a step of the set-point sets off rings down faster.
const LASTS: f32 = 0.85;

impl Swing {
    /// Takes a fast error at `tick`; `true` if it has turned too often, each time within `period`.
    fn turns(&mut self, e1_dot: f32, tick: usize, period: u32) -> bool {
        let forward = e1_dot > 0.0;
        let late = tick.wrapping_sub(self.since) > period as usize;
        if late {
            self.turns = 0;
        }
        if late || forward != self.forward {
            let lasts = self.peak >= LASTS * self.before;
            self.turns = if lasts && !late { self.turns.saturating_add(1) } else { self.turns };
            (self.before, self.peak, self.since) = (self.peak, 0.0, tick);
        }
        self.peak = max(self.peak, e1_dot.abs());
        self.forward = forward;
        self.turns >= TURNS
    }
}

/// Joints whose error is beyond its limit, one bit each.
fn beyond(e1: &JointVector, limits: &[f32; JOINTS]) -> u8 {
    let bit = |j: usize| u8::from(e1[j].abs() > limits[j]) << j;
    bit(0) | bit(1) | bit(2) | bit(3)
}
