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

#[derive(Clone, Copy, Debug)]
struct Brake {
    /// 0 closed, 1 open.
    stroke: f64,
    grip: Grip,
    /// Highest friction, N m or N.
    holding: f64,
}

impl Brake {
    fn advance(&mut self, release: bool, dt_s: f64, qd: f64) {
        let travel = if release { dt_s / BRAKE_OPEN_S } else { -dt_s / BRAKE_CLOSE_S };
        self.stroke = (self.stroke + travel).clamp(0.0, 1.0);
        if self.stroke > 1.0 - STROKE_ROUNDING {
            self.grip = Grip::Open;
        } else if self.stroke < STROKE_ROUNDING && self.grip == Grip::Open {
            self.grip =
                if qd == 0.0 { Grip::Stuck } else { Grip::Sliding { direction: qd.signum() } };
        }
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
            holding: HOLDING_RATIO * limit.tau_max,
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

    /// Feedback contacts, closed while the brake is off.
    pub fn released(&self) -> [bool; JOINTS] {
        self.0.map(|brake| brake.grip == Grip::Open)
    }

    /// Joints that stand still in their brake.
    pub fn locked(&self) -> [bool; JOINTS] {
        self.0.map(|brake| brake.grip == Grip::Stuck)
    }

    /// Torque of the sliding brakes on their joints, N m and N.
    pub fn drag(&self) -> Joints {
        self.0.map(|brake| match brake.grip {
            Grip::Sliding { direction } => -direction * brake.holding,
            Grip::Open | Grip::Stuck => 0.0,
        })
    }

    /// Lets go the stuck brakes that would have to give more than they can; `needed` is the torque that
    /// keeps each joint at rest, N m and N.
    pub fn break_away(&mut self, needed: &Joints) {
        for (brake, needed) in self.0.iter_mut().zip(needed) {
            if brake.grip == Grip::Stuck && needed.abs() > brake.holding {
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
mod tests {
    use super::*;
    use shared::arm::REFERENCE;

    const STILL: Joints = [0.0; 4];

    /// Ticks at this rate until the feedback of joint 2 changes.
    fn ticks_until(brakes: &mut Brakes, released: bool, hz: f64) -> u32 {
        (1..10_000)
            .find(|_| {
                brakes.advance(&[released; 4], 1.0 / hz, &STILL);
                brakes.released()[1] == released
            })
            .unwrap()
    }

    #[test]
    fn opening_takes_150_ms_and_closing_100_ms_at_every_rate() {
        for hz in [1000.0, 2000.0, 4000.0, 8000.0] {
            let mut brakes = Brakes::closed(&REFERENCE.limits);
            assert_eq!(ticks_until(&mut brakes, true, hz), (0.150 * hz) as u32);
            assert_eq!(ticks_until(&mut brakes, false, hz), (0.100 * hz) as u32);
        }
    }

    #[test]
    fn command_withdrawn_half_way_leaves_the_grip_as_it_was() {
        let mut brakes = Brakes::closed(&REFERENCE.limits);
        brakes.advance(&[true; 4], 0.149, &STILL);
        brakes.advance(&[false; 4], 0.010, &STILL);
        assert_eq!(brakes.locked(), [true; 4]);
        let mut brakes = Brakes::open(&REFERENCE.limits);
        brakes.advance(&[false; 4], 0.099, &STILL);
        brakes.advance(&[true; 4], 0.010, &STILL);
        assert_eq!(brakes.released(), [true; 4]);
    }

    #[test]
    fn closing_on_motion_slides_against_it_with_one_and_a_half_times_the_limit() {
        let mut brakes = Brakes::open(&REFERENCE.limits);
        brakes.advance(&[false, false, false, true], 0.100, &[0.1, -0.1, 0.0, 0.1]);
        assert_eq!(brakes.drag(), [-45_000.0, 180_000.0, 0.0, 0.0]);
        assert_eq!(brakes.locked(), [false, false, true, false]);
    }

    #[test]
    fn overloaded_brake_slides_in_the_direction_of_the_load() {
        let mut brakes = Brakes::closed(&REFERENCE.limits);
        brakes.break_away(&[44_999.0, 180_001.0, -105_001.0, 0.0]);
        assert_eq!(brakes.locked(), [true, false, false, true]);
        assert_eq!(brakes.drag(), [0.0, 180_000.0, -105_000.0, 0.0]);
    }

    #[test]
    fn first_of_two_stops_is_found_with_its_share() {
        let mut brakes = Brakes::open(&REFERENCE.limits);
        let before = [0.3, -0.2, 0.1, 0.0];
        brakes.advance(&[false; 4], 0.100, &before);
        assert_eq!(brakes.first_stop(&before, &[0.1, -0.1, 0.05, 0.0]), None);
        assert_eq!(brakes.first_stop(&before, &[-0.1, 0.2, 0.05, 0.0]), Some((1, 0.5)));
    }
}
