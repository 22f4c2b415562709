//! Four spring-set brakes: they take time to open and to close, hold by stiction and slow by Coulomb friction.

use shared::arm::{JOINTS, JointLimits};

use super::Joints;

/// Time from the release command until a brake is open, s.
pub const BRAKE_OPEN_S: f64 = 0.150;

/// Time from the loss of the release command until a brake bites, s.
pub const BRAKE_CLOSE_S: f64 = 0.100;

/// Friction of a brake over the torque limit of its joint.
const HOLDING_RATIO: f64 = 1.5;

/// Share of the stroke that the sum of its steps may miss by rounding.
const STROKE_ROUNDING: f64 = 1e-9;

/// What the lining does. It keeps biting until fully open and stays off until fully closed.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Grip {
    Open,
    /// Slides with this sign of speed.
    Sliding {
        direction: f64,
    },
    Stuck,
}

/// What is wrong with a brake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrakeFault {
    /// It opens no further, although told.
    pub jammed: bool,
    /// It closes no further, although told.
    pub stuck_open: bool,
    /// Level at which the feedback contact sticks, `true` is open; `None` where it tells the truth.
    pub contact: Option<bool>,
    /// Share of the friction that is left, 0 to 1.
    pub holding: f64,
}

impl BrakeFault {
    /// A sound brake.
    pub const NONE: Self = Self { jammed: false, stuck_open: false, contact: None, holding: 1.0 };
}

#[derive(Clone, Copy, Debug)]
struct Brake {
    /// 0 closed, 1 open.
    stroke: f64,
    grip: Grip,
    /// Highest friction of a sound lining, N m or N.
    friction: f64,
    fault: BrakeFault,
}

impl Brake {
    fn advance(&mut self, release: bool, dt_s: f64, qd: f64) {
        let travel = match release {
            true if self.fault.jammed => 0.0,
            true => dt_s / BRAKE_OPEN_S,
            false if self.fault.stuck_open => 0.0,
            false => -dt_s / BRAKE_CLOSE_S,
        };
        self.stroke = (self.stroke + travel).clamp(0.0, 1.0);
        if self.stroke > 1.0 - STROKE_ROUNDING {
            self.grip = Grip::Open;
        } else if self.stroke < STROKE_ROUNDING && self.grip == Grip::Open {
            self.grip =
                if qd == 0.0 { Grip::Stuck } else { Grip::Sliding { direction: qd.signum() } };
        }
    }

    /// Highest friction, N m or N.
    fn holding(&self) -> f64 {
        self.friction * self.fault.holding
    }
}

/// The brakes of all joints.
#[derive(Clone, Debug)]
pub(super) struct Brakes([Brake; JOINTS]);

impl Brakes {
    /// All closed and holding.
    pub fn closed(limits: &[JointLimits; JOINTS]) -> Self {
        Self(limits.map(|limit| Brake {
            stroke: 0.0,
            grip: Grip::Stuck,
            friction: HOLDING_RATIO * limit.tau_max,
            fault: BrakeFault::NONE,
        }))
    }

    /// All open.
    pub fn open(limits: &[JointLimits; JOINTS]) -> Self {
        Self(Self::closed(limits).0.map(|brake| Brake { stroke: 1.0, grip: Grip::Open, ..brake }))
    }

    /// Moves the linings; a brake that closes on a moving joint starts to slide.
    pub fn advance(&mut self, release: &[bool; JOINTS], dt_s: f64, qd: &Joints) {
        for ((brake, &release), &qd) in self.0.iter_mut().zip(release).zip(qd) {
            brake.advance(release, dt_s, qd);
        }
    }

    /// Makes the brake of a joint faulty, or sound again.
    pub fn set_fault(&mut self, joint: usize, fault: BrakeFault) {
        self.0[joint].fault = fault;
    }

    /// Feedback contacts, closed while the brake is off.
    pub fn released(&self) -> [bool; JOINTS] {
        self.0.map(|brake| brake.fault.contact.unwrap_or(brake.grip == Grip::Open))
    }

    /// Joints that stand still in their brake.
    pub fn locked(&self) -> [bool; JOINTS] {
        self.0.map(|brake| brake.grip == Grip::Stuck)
    }

    /// Torque of the sliding brakes on their joints, N m and N.
    pub fn drag(&self) -> Joints {
        self.0.map(|brake| match brake.grip {
            Grip::Sliding { direction } => -direction * brake.holding(),
            Grip::Open | Grip::Stuck => 0.0,
        })
    }

    /// Lets go the stuck brakes that would have to give more than they can; `needed` is the torque that
    /// keeps each joint at rest, N m and N.
    pub fn break_away(&mut self, needed: &Joints) {
        for (brake, needed) in self.0.iter_mut().zip(needed) {
            if brake.grip == Grip::Stuck && needed.abs() > brake.holding() {
                brake.grip = Grip::Sliding { direction: -needed.signum() };
            }
        }
    }

    /// The sliding joint that comes to rest first between two speeds, and the share of the interval that
    /// passes until then.
    pub fn first_stop(&self, before: &Joints, after: &Joints) -> Option<(usize, f64)> {
        let mut first: Option<(usize, f64)> = None;
        for (j, brake) in self.0.iter().enumerate() {
            if let Grip::Sliding { direction } = brake.grip {
                let (start, end) = (direction * before[j], direction * after[j]);
                let share = if start > 0.0 { start / (start - end) } else { 0.0 };
                if end <= 0.0 && first.is_none_or(|(_, earliest)| share < earliest) {
                    first = Some((j, share));
                }
            }
        }
        first
    }

    /// A sliding joint has come to rest.
    pub fn stick(&mut self, joint: usize) {
        self.0[joint].grip = Grip::Stuck;
    }
}

#[cfg(test)]
mod tests;
