//! What a mode starts with.

use shared::arm::JOINTS;
use shared::fault::{Fault, Mode as ModeCode};

use super::table::next;
use super::{Cause, Events, Exit, Follower, Mode, Timing};
use crate::monitor::Finding;
use crate::path::{Line, Path, Phase, Rate};
use crate::planner::Order;

impl Mode {
    /// Leaves this mode by `exit`; the table says where to.
    pub(super) fn leave(
        &mut self,
        exit: Exit,
        finding: Finding,
        timing: &Timing,
        events: &Events<'_>,
    ) {
        let Some(to) = next(self.code(), exit) else { return };
        let measured = events.observers.map(|o| o.position);
        let cause = self.cause_of(exit, finding, events);
        let pose = |mode: &Self| {
            // A set-point that no control error explains is not trusted either.
            let trusted = finding.fault != Fault::ErrorWindow;
            let set_point = mode.set_point(timing).filter(|_| trusted);
            set_point.map_or(measured, |set_point| set_point.position)
        };
        *self = match to {
            ModeCode::Boot => Self::RESET,
            ModeCode::Standby => Self::Standby { codes: events.codes },
            ModeCode::Arming => Self::Arming { ticks: 0, open: 0, pose: measured, began: measured },
            ModeCode::Holding => Self::Holding { pose: pose(self) },
            ModeCode::Moving => match events.order {
                Some(Order::Start(motion)) => Self::Moving(motion.begun()),
                _ => return,
            },
            ModeCode::Jogging => match events.order {
                Some(Order::Jog(line)) => {
                    let path = Path::Line(Line { origin: pose(self), ..*line });
                    let follower = from_rest(path, timing);
                    Self::Jogging { follower, quiet: 0 }
                }
                _ => return,
            },
            ModeCode::Stopping => {
                Self::Stopping { follower: self.stop(finding, timing, events), cause }
            }
            ModeCode::BrakeHold => {
                Self::BrakeHold { pose: pose(self), ticks: 0, closed: 0, cause }
            }
            ModeCode::TorqueOff => Self::TorqueOff { ticks: 0, cause },
            ModeCode::Latched => Self::Latched { codes: events.codes, cause },
            ModeCode::Lowering => Self::Lowering { ticks: 0, pose: measured, motion: None, cause },
        };
    }

    /// Why the arm stops, or stopped.
    fn cause_of(&self, exit: Exit, finding: Finding, events: &Events<'_>) -> Cause {
        let found = match exit {
            Exit::Stop if finding.fault == Fault::None => Finding::new(Fault::OperatorStop),
            Exit::Slipped => Finding { fault: Fault::BrakeSlipped, joints: self.slipping(events) },
            _ => finding,
        };
        match self.cause() {
            // A stop that becomes graver names the graver fault; one that goes on keeps its own.
            Some(cause) if found.fault == Fault::None => *cause,
            Some(cause) => Cause { isolated: cause.isolated, ..Cause::new(found) },
            None => Cause::new(found),
        }
    }

    /// Joints that moved most in their brakes, one bit each.
    fn slipping(&self, events: &Events<'_>) -> u8 {
        let (Self::Standby { codes } | Self::Latched { codes, .. }) = self else { return 0 };
        let moved = codes.iter().zip(&events.codes).enumerate();
        moved.fold(0, |bits, (j, (then, now))| {
            if now.wrapping_sub(*then).wrapping_add(1) > 2 { bits | 1 << j } else { bits }
        })
    }

    /// The way down to rest from the present motion.
    fn stop(&self, finding: Finding, timing: &Timing, events: &Events<'_>) -> Follower {
        let pace = timing.pace();
        match self {
            // Where the set-point cannot be trusted, the stop goes on from what is measured.
            _ if finding.fault == Fault::ErrorWindow => {
                Follower::new(Path::Line(measured(events)), Phase::default(), Rate::FULL, 0, &pace)
            }
            Self::Moving(motion) => {
                Follower::new(Path::Curve(*motion), motion.phase, Rate::FULL, 0, &pace)
            }
            Self::Jogging { follower, .. } => follower.turned(0, &pace),
            _ => from_rest(Path::Line(measured(events)), timing),
        }
    }
}

fn from_rest(path: Path, timing: &Timing) -> Follower {
    Follower::new(path, Phase::default(), Rate::ZERO, 1, &timing.pace())
}

/// The line along which the arm moves right now.
fn measured(events: &Events<'_>) -> Line {
    let mut line = Line::default();
    let estimates = events.observers.iter().zip(events.scales);
    for (j, (observer, scale)) in estimates.enumerate().take(JOINTS) {
        line.origin[j] = observer.position;
        line.velocity_q8[j] = (observer.velocity * 256.0) as i32;
        line.velocity[j] = observer.velocity(scale);
    }
    line
}
