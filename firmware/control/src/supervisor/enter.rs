//! What a mode starts with.

use shared::arm::JOINTS;
use shared::fault::{Fault, Mode as ModeCode};

use super::table::next;
use super::{Cause, Events, Exit, Follower, Mode, Timing, clears};
use crate::monitor::Finding;
use crate::path::{Line, Path, Phase, Rate, SetPoint};
use crate::planner::Order;

impl Mode {
    /// Leaves this mode by `exit`; the table says where to.
    #[inline(never)]
    pub(super) fn leave(
        &mut self,
        exit: Exit,
        finding: Finding,
        timing: &Timing,
        events: &Events<'_>,
    ) {
        let Some(to) = next(self.code(), exit) else { return };
        let codes = events.codes;
        match to {
            ModeCode::Boot => *self = Self::RESET,
            ModeCode::Standby => *self = Self::Standby { codes },
            ModeCode::Arming => {
                let pose = measured(events);
                *self = Self::Arming { ticks: 0, open: 0, pose, began: pose };
            }
            ModeCode::Holding => {
                *self = Self::Holding { pose: self.pose(finding, timing, events) };
            }
            ModeCode::Moving => {
                if let Some(Order::Start(motion)) = events.order {
                    *self = Self::Moving(motion.begun());
                }
            }
            ModeCode::Jogging => self.jog(finding, timing, events),
            _ => self.stop(to, self.cause_of(exit, finding, events), finding, timing, events),
        }
    }

    #[inline(never)]
    fn jog(&mut self, finding: Finding, timing: &Timing, events: &Events<'_>) {
        if let Some(Order::Jog(line)) = events.order {
            let origin = self.pose(finding, timing, events);
            let follower = Follower::from_rest(&timing.pace);
            *self = Self::Jogging { line: Line { origin, ..*line }, follower, quiet: 0 };
        }
    }

    /// Enters one of the modes that a stop goes through.
    fn stop(
        &mut self,
        to: ModeCode,
        cause: Cause,
        finding: Finding,
        timing: &Timing,
        events: &Events<'_>,
    ) {
        match to {
            ModeCode::Stopping => self.slow_down(cause, finding, timing, events),
            ModeCode::BrakeHold => {
                let pose = self.pose(finding, timing, events);
                let (ticks, closed) = match self {
                    Self::BrakeHold { ticks, closed, .. } => (*ticks, *closed),
                    _ => (0, 0),
                };
                *self = Self::BrakeHold { pose, ticks, closed, cause };
            }
            ModeCode::TorqueOff => *self = Self::TorqueOff { ticks: 0, cause },
            ModeCode::Latched => *self = Self::Latched { codes: events.codes, cause },
            _ => {
                let pose = measured(events);
                *self = Self::Lowering { ticks: 0, pose, motion: None, cause };
            }
        }
    }

    /// The set-point's position words, or the measured ones where there is none.
    #[inline(never)]
    fn pose(&self, finding: Finding, timing: &Timing, events: &Events<'_>) -> [u32; JOINTS] {
        // A set-point that no control error explains is not trusted either.
        let trusted = finding.fault != Fault::ErrorWindow;
        let mut at = SetPoint::default();
        if self.place(timing, &mut at) && trusted { at.position } else { measured(events) }
    }

    /// Why the arm stops, or stopped.
    #[inline(never)]
    fn cause_of(&self, exit: Exit, finding: Finding, events: &Events<'_>) -> Cause {
        let found = match exit {
            Exit::Stop if finding.fault == Fault::None => Finding::new(Fault::OperatorStop),
            Exit::Stop | Exit::CutTorque => finding,
            Exit::Slipped => Finding { fault: Fault::BrakeSlipped, joints: self.slipping(events) },
            _ => Finding::NONE,
        };
        let mut new = Cause::new(found);
        new.cut |= exit == Exit::CutTorque;
        match self.cause() {
            // A stop that becomes graver names the graver fault; one that goes on keeps its own, and what locks the
            // arm out stays.
            Some(cause) => {
                let goes_on = found.fault == Fault::None || !clears(cause.finding.fault);
                Cause {
                    finding: if goes_on { cause.finding } else { found },
                    isolated: cause.isolated | new.isolated,
                    cut: cause.cut | new.cut,
                }
            }
            None => new,
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

    /// Goes down to rest from the present motion.
    #[inline(never)]
    fn slow_down(&mut self, cause: Cause, finding: Finding, timing: &Timing, events: &Events<'_>) {
        let pace = &timing.pace;
        let (path, follower) = match self {
            Self::Moving(motion) | Self::Lowering { motion: Some(motion), .. }
                if finding.fault != Fault::ErrorWindow =>
            {
                (Path::Curve(*motion), Follower::new(motion.phase, Rate::FULL, 0, pace))
            }
            Self::Jogging { line, follower, .. } if finding.fault != Fault::ErrorWindow => {
                if follower.goal() != 0 {
                    follower.turn(0, pace);
                }
                (Path::Line(*line), *follower)
            }
            // Where the set-point cannot be trusted, the stop goes on from what is measured.
            _ => {
                let follower = Follower::new(Phase::default(), Rate::FULL, 0, pace);
                (Path::Line(onward(events)), follower)
            }
        };
        *self = Self::Stopping { path, follower, cause };
    }
}

/// Where the arm is, position words.
fn measured(events: &Events<'_>) -> [u32; JOINTS] {
    let [a, b, c, d] = events.observers;
    [a.position, b.position, c.position, d.position]
}

/// The line along which the arm moves right now.
#[inline(never)]
fn onward(events: &Events<'_>) -> Line {
    let mut line = Line { origin: measured(events), ..Line::default() };
    let estimates = events.observers.iter().zip(events.scales);
    for (j, (observer, scale)) in estimates.enumerate().take(JOINTS) {
        line.velocity_q8[j] = (observer.velocity * 256.0) as i32;
        line.velocity[j] = observer.velocity(scale);
    }
    line
}
