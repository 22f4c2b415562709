//! The supervisor: which mode the controller is in, what its pins may do, and where its set-point is.
//!
//! A mode holds the data that belong to it alone. Each tick it either stays, or is left by one named
//! [`Exit`]; [`TRANSITIONS`] says where that leads. Every stop latches: only `Clear`, which configures and
//! checks all devices anew, and `Arm`, which starts from the measured pose, lead back to motion. The one
//! motion without an order is the lowering of an arm whose brake slips.

mod bump;
mod enter;
mod exit;
mod follow;
mod pins;
mod reaction;
mod status;
mod table;
mod timing;

use shared::arm::JOINTS;
use shared::fault::Fault;

pub use bump::Bump;
pub use follow::Follower;
pub use pins::{Brakes, Levels};
pub use reaction::{Reaction, clears};
pub use status::Status;
pub use table::{Exit, TRANSITIONS};
pub use timing::Timing;

use crate::estimator::{self, Observer};
use crate::monitor::Finding;
use crate::path::{Line, Motion, Path, Rate, SetPoint};
use crate::planner::Order;

/// Why the arm was stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cause {
    /// The fault and the joints that it names.
    pub finding: Finding,
    /// Joints without torque, their brakes set, one bit each.
    pub isolated: u8,
    /// Torque was cut, and does not come back by itself.
    pub cut: bool,
}

impl Cause {
    fn new(finding: Finding) -> Self {
        let reaction = Reaction::to(finding.fault);
        let isolated = if reaction == Reaction::Isolate { finding.joints } else { 0 };
        Self { finding, isolated, cut: reaction == Reaction::Sto }
    }
}

/// Present mode with what belongs to it alone.
// A tag of its own, a word wide: one in a field's unused values has to be worked out at each use, and a
// byte makes copies byte-wise.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mode {
    /// Devices are being configured.
    Boot {
        /// Ticks since reset, or since boot started over.
        ticks: u32,
        /// What keeps it from ending, once known.
        complaint: Fault,
    },
    /// Ready, brakes set, torque off.
    Standby {
        /// Codes that the brakes hold.
        codes: [u32; JOINTS],
    },
    /// Torque holds against the brakes, they open, then each joint shows that it is free.
    Arming {
        /// Ticks since the order.
        ticks: u32,
        /// Ticks since the last brake reported open, and the measured position words then.
        open: u32,
        /// Pose to hold, position words.
        pose: [u32; JOINTS],
        /// Where the test move began, position words.
        began: [u32; JOINTS],
    },
    /// Brakes open, holding a pose.
    Holding {
        /// Pose to hold, position words.
        pose: [u32; JOINTS],
    },
    /// Brakes open, following a trajectory.
    Moving(Motion),
    /// Brakes open, following a line while its order is repeated.
    Jogging {
        /// The line.
        line: Line,
        /// Place and rate on it.
        follower: Follower,
        /// Ticks since the last order.
        quiet: u32,
    },
    /// The path rate is on its way to zero.
    Stopping {
        /// The path.
        path: Path,
        /// Place and rate on it.
        follower: Follower,
        /// Why.
        cause: Cause,
    },
    /// At rest under torque, brakes set.
    BrakeHold {
        /// Pose to hold, position words.
        pose: [u32; JOINTS],
        /// Ticks since the brakes were told.
        ticks: u32,
        /// Ticks since the last of them reported closed.
        closed: u32,
        /// Why.
        cause: Cause,
    },
    /// Torque off, the brakes are setting.
    TorqueOff {
        /// Ticks since then.
        ticks: u32,
        /// Why.
        cause: Cause,
    },
    /// Brakes set, torque off, until cleared.
    Latched {
        /// Codes that the brakes hold.
        codes: [u32; JOINTS],
        /// Why.
        cause: Cause,
    },
    /// A brake slipped: torque is back, the brakes open, then the arm goes to its rest pose.
    Lowering {
        /// Ticks since torque came back.
        ticks: u32,
        /// Pose to hold until the way is planned, position words.
        pose: [u32; JOINTS],
        /// The way, once planned.
        motion: Option<Motion>,
        /// Why.
        cause: Cause,
    },
}

/// What the supervisor is told each tick.
#[derive(Clone, Copy, Debug)]
pub struct Events<'a> {
    /// Order that arrived, if any.
    pub order: Option<&'a Order>,
    /// Estimates: where the measured pose is.
    pub observers: &'a [Observer; JOINTS],
    /// Scales of the estimates.
    pub scales: &'a [estimator::Scale; JOINTS],
    /// Last believed codes.
    pub codes: [u32; JOINTS],
    /// Every sensor has reported, every converter is configured, the pose is believed.
    pub ready: bool,
    /// What keeps boot from ending.
    pub complaint: Fault,
    /// What the brakes report.
    pub brakes: Brakes,
    /// Both contacts of the emergency stop are closed, and have shown that they agree.
    pub stop_released: bool,
    /// The gravest thing that a monitor found this tick.
    pub finding: Finding,
    /// Joints that the model alone knows, one bit each.
    pub blind: u8,
    /// Ticks since the operator's last authentic frame.
    pub silence: u32,
}

/// All joints.
pub const ALL: u8 = 0b1111;

impl Mode {
    /// Mode at reset.
    pub const RESET: Self = Self::Boot { ticks: 0, complaint: Fault::None };

    /// Mode at a reset that followed a crash.
    pub fn latched(crash: Fault) -> Self {
        Self::Latched { codes: [0; JOINTS], cause: Cause::new(Finding::new(crash)) }
    }

    /// One tick along a trajectory or in place, if there is nothing to decide. Needs neither order nor finding.
    #[inline(always)]
    pub fn glides(&mut self, timing: &Timing) -> bool {
        match self {
            Self::Moving(motion) if !motion.is_over() => {
                motion.phase.ticks += 1;
                true
            }
            Self::Holding { .. } => true,
            Self::Stopping { follower, .. } if !follower.is_level(&timing.pace) => {
                follower.step();
                true
            }
            _ => false,
        }
    }

    /// Set-point of the law; `None` where no torque is wanted.
    pub fn set_point(&self, timing: &Timing) -> Option<SetPoint> {
        let mut set_point = SetPoint::default();
        self.place(timing, &mut set_point).then_some(set_point)
    }

    /// Puts the set-point of the law where it is wanted; `false` where no torque is.
    #[cold]
    #[inline(never)]
    pub fn place(&self, timing: &Timing, to: &mut SetPoint) -> bool {
        let pace = &timing.pace;
        match self {
            Self::Arming { open, pose, .. } => {
                *to = SetPoint::hold(*pose);
                timing.test.add(open.saturating_sub(timing.calm), ALL, to);
            }
            Self::Holding { pose }
            | Self::BrakeHold { pose, .. }
            | Self::Lowering { pose, motion: None, .. } => {
                *to = SetPoint::hold(*pose);
            }
            Self::Jogging { line, follower, .. } => {
                line.place(follower.phase(pace), follower.rate(pace), to);
            }
            Self::Stopping { path, follower, .. } => {
                path.place(follower.phase(pace), follower.rate(pace), to);
            }
            Self::Moving(motion) | Self::Lowering { motion: Some(motion), .. } => {
                motion.place(motion.phase, Rate::FULL, to);
            }
            Self::Boot { .. }
            | Self::Standby { .. }
            | Self::TorqueOff { .. }
            | Self::Latched { .. } => return false,
        }
        true
    }

    /// Whether the brakes are open and the set-point is followed, so that the arm's motion tells of
    /// disturbances.
    #[inline(always)]
    pub fn adapts(&self) -> bool {
        matches!(
            self,
            Self::Moving(_)
                | Self::Holding { .. }
                | Self::Jogging { .. }
                | Self::Stopping { .. }
                | Self::Lowering { motion: Some(_), .. }
        )
    }

    /// Joints that stand or hardly move for as long as this mode lasts, so that the watch motion has to move them; one
    /// bit each.
    #[cold]
    #[inline(never)]
    pub fn standing(&self, watch: &Bump) -> u8 {
        let (speed, times) = match self {
            Self::Holding { .. } => return ALL,
            Self::Moving(motion) | Self::Lowering { motion: Some(motion), .. } => motion.peak(),
            Self::Jogging { line, .. } => (&line.velocity, 1.0),
            _ => return 0,
        };
        watch.outdoes(speed, times)
    }

    /// Reacts to what was found after this mode's turn.
    #[cold]
    #[inline(never)]
    pub fn react(&mut self, timing: &Timing, events: &Events<'_>) {
        if let Some(exit) = self.forced(events.finding) {
            self.leave(exit, events.finding, timing, events);
        }
    }

    /// Time has passed by this many ticks more or less than one: the path goes with it.
    #[cold]
    #[inline(never)]
    pub fn catch_up(&mut self, ticks: f32) {
        if let Self::Moving(motion) = self {
            motion.phase = motion.phase.advanced(ticks);
        }
    }

    /// Joints without torque, one bit each.
    #[inline(always)]
    pub fn isolated(&self) -> u8 {
        self.cause().map_or(0, |cause| cause.isolated)
    }

    /// Why the arm was stopped, if it was.
    #[inline(always)]
    pub fn cause(&self) -> Option<&Cause> {
        match self {
            Self::Stopping { cause, .. }
            | Self::BrakeHold { cause, .. }
            | Self::TorqueOff { cause, .. }
            | Self::Latched { cause, .. }
            | Self::Lowering { cause, .. } => Some(cause),
            _ => None,
        }
    }
}
