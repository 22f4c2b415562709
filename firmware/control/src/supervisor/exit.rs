//! Whether the present mode is left, and by which exit.

use shared::arm::JOINTS;
use shared::fault::{Fault, Refusal};

use super::{ALL, Cause, Events, Exit, Follower, Mode, Reaction, Timing, clears};
use crate::monitor::Finding;
use crate::path::{Line, Rate, SetPoint};
use crate::planner::Order;

impl Mode {
    /// One tick on; says why an order had no effect.
    #[inline(never)]
    pub fn step(&mut self, timing: &Timing, events: &Events<'_>) -> Refusal {
        let answer = events.order.map_or(Ok(None), |order| self.obey(order, events));
        let (ordered, refusal) = match answer {
            Ok(exit) => (exit, Refusal::None),
            Err(refusal) => (None, refusal),
        };
        let finding = self.judged(timing, events);
        // A fault goes before an order, and an order before what would have come by itself.
        let exit = self.forced(finding).or(ordered).or_else(|| self.due(timing, events));
        if exit == Some(Exit::Stop) {
            // The path goes on in this tick, and is left from there.
            self.advance(timing, events);
        }
        match exit {
            Some(exit) => self.leave(exit, finding, timing, events),
            None => self.advance(timing, events),
        }
        refusal
    }

    /// The exit that an order asks for.
    fn obey(&mut self, order: &Order, events: &Events<'_>) -> Result<Option<Exit>, Refusal> {
        let allowed = |exit, yes, refusal| if yes { Ok(Some(exit)) } else { Err(refusal) };
        match (&mut *self, order) {
            (_, Order::Refused(refusal)) => Err(*refusal),
            // Taken by the executive, whatever the mode.
            (_, Order::SetGains(_))
            | (Self::Boot { complaint: Fault::ParkedPoseDiffers, .. }, Order::ConfirmPose) => {
                Ok(None)
            }
            (Self::Boot { .. }, _) => Err(Refusal::WrongMode),
            // On its way already: another stop takes no more time.
            (
                Self::Stopping { .. }
                | Self::BrakeHold { .. }
                | Self::TorqueOff { .. }
                | Self::Latched { .. },
                Order::Stop,
            ) => Ok(None),
            // Its brakes may still be set, and a path has none to open.
            (Self::Lowering { motion: None, .. }, Order::Stop) => Ok(Some(Exit::AtRest)),
            (_, Order::Stop) => Ok(Some(Exit::Stop)),
            (Self::Latched { cause, .. }, Order::Clear) if !clears(cause.finding.fault) => {
                Err(Refusal::LockedOut)
            }
            (Self::Latched { .. }, Order::Clear) => {
                allowed(Exit::Clear, events.stop_released, Refusal::EmergencyStop)
            }
            (Self::Standby { .. }, Order::Arm) => {
                allowed(Exit::Arm, events.stop_released, Refusal::EmergencyStop)
            }
            (Self::Holding { pose }, Order::Start(motion)) => {
                allowed(Exit::Start, motion.starts_at(pose), Refusal::OriginMismatch)
            }
            (Self::Holding { .. }, Order::Jog(_)) => Ok(Some(Exit::Jog)),
            (Self::Moving(_) | Self::Jogging { .. }, Order::Start(_)) => Err(Refusal::Busy),
            (Self::Jogging { line, follower, quiet }, Order::Jog(wanted)) => {
                // Another direction does not keep this one alive, and has to wait for its end.
                if follower.goal() == 1 && line.is_parallel_to(wanted) {
                    *quiet = 0;
                    Ok(None)
                } else {
                    Err(Refusal::Busy)
                }
            }
            (Self::Lowering { pose, motion, cause, .. }, Order::Lower(way)) => {
                if motion.is_none() && events.brakes.open | cause.isolated == ALL {
                    *motion = Some(way.moved_to(*pose));
                }
                Ok(None)
            }
            _ => Err(Refusal::WrongMode),
        }
    }

    /// What is wrong: what a monitor found, or what only this mode can tell.
    fn judged(&self, timing: &Timing, events: &Events<'_>) -> Finding {
        if events.finding.fault != Fault::None {
            return events.finding;
        }
        match self {
            Self::Moving(_) | Self::Jogging { .. } if events.silence > timing.link => {
                Finding::new(Fault::LinkLost)
            }
            Self::Arming { ticks, open: 0, .. } if *ticks >= timing.preload + timing.brake_open => {
                Finding { fault: Fault::BrakeNotReleased, joints: ALL & !events.brakes.open }
            }
            Self::Arming { open, began, .. } if *open == timing.calm + timing.test.ticks / 2 => {
                match still(timing, began, events) {
                    0 => Finding::NONE,
                    joints => Finding { fault: Fault::BrakeNotFree, joints },
                }
            }
            _ => Finding::NONE,
        }
    }

    /// The exit that a fault forces.
    pub(super) fn forced(&mut self, finding: Finding) -> Option<Exit> {
        let reaction = Reaction::to(finding.fault);
        match self {
            Self::Boot { .. } => None,
            Self::TorqueOff { cause, .. } | Self::Latched { cause, .. } => {
                cause.refine(finding);
                None
            }
            // Stopping already: only what is graver counts.
            Self::Stopping { cause, .. } | Self::BrakeHold { cause, .. } => {
                if reaction == Reaction::Isolate {
                    cause.isolate(finding);
                }
                cause.refine(finding);
                match (reaction, finding.fault) {
                    (Reaction::Sto, _) => Some(Exit::CutTorque),
                    // Only the brakes are left.
                    (_, Fault::ErrorWindow) => Some(Exit::Astray),
                    _ => None,
                }
            }
            Self::Lowering { .. } if is_emergency(finding.fault) => Some(Exit::CutTorque),
            Self::Lowering { motion: None, .. } if reaction < Reaction::Sto => {
                (reaction != Reaction::None).then_some(Exit::AtRest)
            }
            _ => match reaction {
                Reaction::None => None,
                Reaction::Sto => Some(Exit::CutTorque),
                Reaction::Ss1 | Reaction::Isolate => Some(Exit::Stop),
            },
        }
    }

    /// The exit that is due by itself.
    fn due(&self, timing: &Timing, events: &Events<'_>) -> Option<Exit> {
        match self {
            Self::Boot { .. } => events.ready.then_some(Exit::Ready),
            Self::Standby { codes } => slips(timing, codes, events).then_some(Exit::Slipped),
            Self::Arming { open, .. } => {
                (*open >= timing.calm + timing.test.ticks).then_some(Exit::Free)
            }
            Self::Holding { .. } => None,
            Self::Moving(motion) => motion.is_over().then_some(Exit::PathEnded),
            Self::Jogging { follower, .. } => {
                let ended = follower.goal() == 0 && follower.is_level(&timing.pace);
                ended.then_some(Exit::JogEnded)
            }
            Self::Stopping { follower, .. } => {
                follower.is_level(&timing.pace).then_some(Exit::AtRest)
            }
            Self::BrakeHold { ticks, closed, .. } => {
                // The model alone holds the arm no longer than the brakes should take.
                let spent = events.blind != 0 && *ticks > timing.brake_set;
                let set = (*closed > timing.torque_tail).then_some(Exit::BrakesSet);
                set.or(spent.then_some(Exit::CutTorque))
            }
            Self::TorqueOff { ticks, .. } => (events.brakes.closed == ALL
                || *ticks > timing.brake_set)
                .then_some(Exit::BrakesSet),
            Self::Latched { codes, cause } => {
                (!cause.cut && slips(timing, codes, events)).then_some(Exit::Slipped)
            }
            Self::Lowering { motion, .. } => {
                motion.is_some_and(|motion| motion.is_over()).then_some(Exit::Lowered)
            }
        }
    }

    /// One tick on in the same mode.
    fn advance(&mut self, timing: &Timing, events: &Events<'_>) {
        match self {
            Self::Boot { ticks, complaint } => {
                *ticks = if *ticks < timing.boot { *ticks + 1 } else { 0 };
                *complaint = events.complaint;
            }
            Self::Arming { ticks, open, began, .. } => {
                *ticks += 1;
                *open = if events.brakes.open == ALL { *open + 1 } else { 0 };
                if *open <= timing.calm {
                    *began = events.observers.map(|o| o.position);
                }
            }
            Self::Moving(motion) => motion.phase.ticks += 1,
            Self::Jogging { line, follower, quiet } => {
                follower.step();
                *quiet += 1;
                let ends = *quiet > timing.jog || leads_out(line, follower, timing);
                if follower.goal() == 1 && ends {
                    follower.turn(0, &timing.pace);
                }
            }
            Self::Stopping { follower, .. } => follower.step(),
            Self::BrakeHold { ticks, closed, .. } => {
                *ticks = ticks.saturating_add(1);
                *closed = if events.brakes.closed == ALL { *closed + 1 } else { 0 };
            }
            Self::TorqueOff { ticks, .. } => *ticks = ticks.saturating_add(1),
            Self::Lowering { ticks, motion, .. } => {
                *ticks = ticks.saturating_add(1);
                if let Some(motion) = motion {
                    motion.phase.ticks += 1;
                }
            }
            // Letting go of the emergency stop must move nothing, whatever the arm did meanwhile.
            Self::Standby { codes } | Self::Latched { codes, .. } if !events.stop_released => {
                *codes = events.codes;
            }
            Self::Standby { .. } | Self::Latched { .. } | Self::Holding { .. } => {}
        }
    }
}

impl Cause {
    /// A contact that stays open alone is another fault than a pressed emergency stop; what needs service is not hidden
    /// by what does not.
    fn refine(&mut self, finding: Finding) {
        let emergency = self.finding.fault == Fault::EmergencyStop && is_emergency(finding.fault);
        if emergency || !clears(finding.fault) {
            *self = Self { isolated: self.isolated, cut: self.cut || !emergency, finding };
        }
    }

    /// Further joints lose their torque.
    fn isolate(&mut self, finding: Finding) {
        if clears(self.finding.fault) {
            self.finding = finding;
        }
        self.isolated |= finding.joints;
    }
}

fn is_emergency(fault: Fault) -> bool {
    matches!(fault, Fault::EmergencyStop | Fault::EmergencyStopContacts)
}

/// Joints that did not go along with the first half of the test move, one bit each.
fn still(timing: &Timing, began: &[u32; JOINTS], events: &Events<'_>) -> u8 {
    let pairs = began.iter().zip(events.observers).zip(&timing.test.words).enumerate();
    pairs.fold(0, |still, (j, ((began, now), due))| {
        let way = now.position.wrapping_sub(*began) as i32 as f32;
        if way > 0.5 * due { still } else { still | 1 << j }
    })
}

/// Whether a joint moved in its brake, and may be lowered.
fn slips(timing: &Timing, codes: &[u32; JOINTS], events: &Events<'_>) -> bool {
    let moved = codes.iter().zip(&events.codes).zip(&timing.slip);
    let any = moved.fold(false, |any, ((then, now), slip)| {
        any | (now.wrapping_sub(*then).wrapping_add(*slip) > 2 * slip)
    });
    any && events.stop_released && events.blind == 0
}

/// Whether a jog would pass the range of motion if it were stopped now.
#[inline(never)]
fn leads_out(line: &Line, follower: &Follower, timing: &Timing) -> bool {
    let pace = &timing.pace;
    let mut place = SetPoint::default();
    line.place(follower.phase(pace), Rate::FULL, &mut place);
    // A stop takes as much way as half its duration at full rate; two ticks for the decision.
    let ahead = i64::from(pace.ticks as u32 / 2 + 2);
    let ranges = timing.lowest.iter().zip(&timing.highest);
    place.position.iter().zip(&line.velocity_q8).zip(ranges).any(
        |((&at, &velocity), (&low, &high))| {
            let way = (i64::from(velocity) * ahead) >> 8;
            let end = i64::from(at) + way;
            (way > 0 && end > i64::from(high)) || (way < 0 && end < i64::from(low))
        },
    )
}
