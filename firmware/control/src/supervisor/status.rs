//! What telemetry says of a mode.

use shared::fault::{Limit, Mode as ModeCode};
use shared::telemetry::PATH_RATE_ONE;

use super::{Mode, Timing};
use crate::monitor::Finding;

/// What telemetry says of a mode.
#[derive(Clone, Copy, Debug)]
pub struct Status {
    /// Mode number.
    pub code: ModeCode,
    /// The latched fault, or what keeps boot from ending.
    pub finding: Finding,
    /// Ticks since the trajectory started; 0 without one.
    pub phase: u32,
    /// Path rate, 1 is [`PATH_RATE_ONE`].
    pub path_rate: u16,
    /// One bit a [`Limit`].
    pub limits: u16,
}

impl Mode {
    /// What telemetry says of this mode.
    #[inline(always)]
    pub fn status(&self, timing: &Timing) -> Status {
        match self {
            Self::Moving(motion) => Status {
                code: ModeCode::Moving,
                finding: Finding::NONE,
                phase: motion.phase.ticks,
                path_rate: PATH_RATE_ONE,
                limits: 0,
            },
            _ => self.rare_status(timing),
        }
    }

    #[cold]
    #[inline(never)]
    fn rare_status(&self, timing: &Timing) -> Status {
        let finding = self.cause().map_or(Finding::NONE, |cause| cause.finding);
        let code = self.code();
        let mut status = Status { code, finding, phase: 0, path_rate: 0, limits: 0 };
        let mut rate = 0.0;
        match self {
            Self::Boot { complaint, .. } => status.finding = Finding::new(*complaint),
            Self::Jogging { follower, quiet, .. } => {
                rate = follower.rate(&timing.pace).value;
                if follower.goal() == 0 && *quiet <= timing.jog {
                    status.limits = 1 << Limit::SoftPosition as u16;
                }
            }
            Self::Stopping { follower, .. } => rate = follower.rate(&timing.pace).value,
            Self::BrakeHold { ticks, closed: 0, .. } if *ticks > timing.brake_set => {
                status.limits = 1 << Limit::BrakeFeedback as u16;
            }
            Self::Lowering { motion: Some(motion), .. } => {
                (status.phase, rate) = (motion.phase.ticks, 1.0);
            }
            _ => {}
        }
        status.path_rate = (rate * f32::from(PATH_RATE_ONE)) as u16;
        status
    }

    /// Mode number for telemetry.
    #[inline(always)]
    pub fn code(&self) -> ModeCode {
        match self {
            Self::Boot { .. } => ModeCode::Boot,
            Self::Standby { .. } => ModeCode::Standby,
            Self::Arming { .. } => ModeCode::Arming,
            Self::Holding { .. } => ModeCode::Holding,
            Self::Moving(_) => ModeCode::Moving,
            Self::Jogging { .. } => ModeCode::Jogging,
            Self::Stopping { .. } => ModeCode::Stopping,
            Self::BrakeHold { .. } => ModeCode::BrakeHold,
            Self::TorqueOff { .. } => ModeCode::TorqueOff,
            Self::Latched { .. } => ModeCode::Latched,
            Self::Lowering { .. } => ModeCode::Lowering,
        }
    }
}
