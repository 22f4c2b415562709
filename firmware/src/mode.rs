//! Mode machine: boot until every sensor has reported, standby, arming, tracking, safe.
//!
//! ```text
//!        sensors report          Arm               brakes open
//!  Boot ---------------> Standby ---> Arming ------------------> Tracking
//!   |                      ^  |          |  | Stop                |  |  ^ Start
//!   | timeout              |  | fault    |  '------> Standby <----'  '--'
//!   '----------> Safe <----|--'          | no feedback, fault    |
//!                 ^  ^-----|-------------'                       | fault
//!                 '--------|-------------------------------------'
//! ```
//! Safe is left by a reset only.

use bytemuck::{Pod, Zeroable};
use shared::arm::JOINTS;
use shared::fault::{Fault, Mode as ModeCode, Refusal};

use crate::estimator::Observer;
use crate::io::Levels;
use crate::trajectory::{Motion, Order, SetPoint};

/// Present mode with what belongs to it alone.
// A tag of its own, a word wide: one in a field's unused values has to be worked out at each use, and a
// byte makes copies byte-wise.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mode {
    /// Devices are being configured.
    Boot {
        /// Ticks since reset.
        ticks: u32,
    },
    /// Ready, brakes set, torque off.
    Standby,
    /// Torque holds against the brakes, then they open.
    Arming {
        /// Ticks since the command.
        ticks: u32,
        /// Pose to hold, position words.
        pose: [u32; JOINTS],
    },
    /// Brakes open, holding a pose.
    Holding {
        /// Pose to hold, position words.
        pose: [u32; JOINTS],
    },
    /// Brakes open, following a trajectory.
    Moving(Motion),
    /// Latched: brakes set, torque off.
    Safe {
        /// Why.
        fault: Fault,
    },
}

/// Times of the machine in ticks.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Timing {
    /// Converters are held in reset this long.
    reset: u32,
    /// From reset to the first frame to a converter.
    settle: u32,
    /// Boot fails after this long.
    boot_timeout: u32,
    /// Torque is on this long before the brakes are told to open.
    preload: u32,
    /// Brakes must report open this long after the arm command.
    open_timeout: u32,
}

impl Timing {
    /// Times for `tick_hz`.
    pub fn new(tick_hz: u32) -> Self {
        let ticks = |ms: u32| ms * tick_hz / 1_000;
        Self {
            // Both converters want a reset pulse of micro-seconds and are ready after milli-seconds
            // (ADS131M04 section 8.4.1, DAC81404 section 7.4).
            reset: ticks(2),
            settle: ticks(12),
            boot_timeout: ticks(500),
            // The drives follow within a few ticks; 20 ms is far beyond that.
            preload: ticks(20),
            // A brake opens in 150 ms; half as much again is late.
            open_timeout: ticks(20 + 225),
        }
    }
}

/// What the machine is told each tick.
#[derive(Clone, Copy, Debug)]
pub struct Events<'a> {
    /// Order that arrived, if any.
    pub order: Option<&'a Order>,
    /// Where the measured pose is, for an order to arm.
    pub observers: &'a [Observer; JOINTS],
    /// Every sensor has reported and every converter is configured.
    pub ready: bool,
    /// All brakes report open.
    pub brakes_open: bool,
    /// What a monitor found this tick; [`Fault::None`] if nothing.
    pub fault: Fault,
}

impl Mode {
    /// Mode at reset.
    pub const RESET: Self = Self::Boot { ticks: 0 };

    /// One tick on; says why an order had no effect.
    #[inline(always)]
    pub fn step(&mut self, timing: &Timing, events: &Events<'_>) -> Refusal {
        if events.fault != Fault::None && !matches!(self, Self::Safe { .. }) {
            *self = Self::Safe { fault: events.fault };
        }
        let outcome = events.order.map(|order| self.obey(order, events.observers));
        if outcome == Some(Ok(())) {
            return Refusal::None;
        }
        self.advance(timing, events);
        outcome.and_then(Result::err).unwrap_or(Refusal::None)
    }

    /// Carries out an order, or says why not.
    #[inline(never)]
    fn obey(&mut self, order: &Order, observers: &[Observer; JOINTS]) -> Result<(), Refusal> {
        match (&*self, order) {
            (Self::Boot { .. } | Self::Safe { .. }, _) => return Err(Refusal::WrongMode),
            (_, Order::Stop) => *self = Self::Standby,
            (_, Order::Refused(refusal)) => return Err(*refusal),
            (Self::Standby, Order::Arm) => {
                *self = Self::Arming { ticks: 0, pose: observers.map(|o| o.position) };
            }
            (Self::Holding { pose }, Order::Start(motion)) if motion.starts_at(pose) => {
                *self = Self::Moving(motion.begun());
            }
            (Self::Holding { .. }, Order::Start(_)) => return Err(Refusal::OriginMismatch),
            (Self::Moving(_), Order::Start(_)) => return Err(Refusal::Busy),
            (_, Order::Arm | Order::Start(_)) => return Err(Refusal::WrongMode),
        }
        Ok(())
    }

    /// One tick on without an order.
    #[inline(always)]
    fn advance(&mut self, timing: &Timing, events: &Events<'_>) {
        match self {
            Self::Boot { .. } if events.ready => *self = Self::Standby,
            Self::Boot { ticks } if *ticks >= timing.boot_timeout => {
                *self = Self::Safe { fault: Fault::BootTimeout };
            }
            Self::Arming { pose, .. } if events.brakes_open => {
                *self = Self::Holding { pose: *pose };
            }
            Self::Arming { ticks, .. } if *ticks >= timing.open_timeout => {
                *self = Self::Safe { fault: Fault::BrakeNotReleased };
            }
            Self::Boot { ticks } | Self::Arming { ticks, .. } => *ticks += 1,
            Self::Moving(motion) if motion.is_over() => {
                *self = Self::Holding { pose: motion.set_point().position };
            }
            Self::Moving(motion) => motion.phase += 1,
            Self::Standby | Self::Holding { .. } | Self::Safe { .. } => {}
        }
    }

    /// Pin levels that belong to this mode.
    pub fn levels(&self, timing: &Timing) -> Levels {
        match self {
            Self::Boot { ticks } if *ticks < timing.reset => Levels::RESET,
            Self::Boot { .. } | Self::Standby | Self::Safe { .. } => Levels::OFF,
            Self::Arming { ticks, .. } => {
                Levels { torque: true, release: *ticks >= timing.preload, converters: true }
            }
            Self::Holding { .. } | Self::Moving(_) => {
                Levels { torque: true, release: true, converters: true }
            }
        }
    }

    /// Whether the converters may be spoken to.
    pub fn converters_awake(&self, timing: &Timing) -> bool {
        !matches!(self, Self::Boot { ticks } if *ticks < timing.settle)
    }

    /// Set-point of the law; `None` where no torque is wanted.
    #[inline(always)]
    pub fn set_point(&self) -> Option<SetPoint> {
        match self {
            Self::Boot { .. } | Self::Standby | Self::Safe { .. } => None,
            Self::Arming { pose, .. } | Self::Holding { pose } => Some(SetPoint::hold(*pose)),
            Self::Moving(motion) => Some(motion.set_point()),
        }
    }

    /// Whether the brakes are open, so that the arm's motion tells of disturbances.
    pub fn adapts(&self) -> bool {
        matches!(self, Self::Holding { .. } | Self::Moving(_))
    }

    /// Ticks since the trajectory started; 0 without one.
    pub fn phase(&self) -> u32 {
        match self {
            Self::Moving(motion) => motion.phase,
            _ => 0,
        }
    }

    /// Mode number for telemetry.
    pub fn code(&self) -> ModeCode {
        match self {
            Self::Boot { .. } => ModeCode::Boot,
            Self::Standby => ModeCode::Standby,
            Self::Arming { .. } => ModeCode::Arming,
            Self::Holding { .. } => ModeCode::Holding,
            Self::Moving(_) => ModeCode::Moving,
            Self::Safe { .. } => ModeCode::Safe,
        }
    }

    /// The latched fault.
    pub fn fault(&self) -> Fault {
        match self {
            Self::Safe { fault } => *fault,
            _ => Fault::None,
        }
    }
}
