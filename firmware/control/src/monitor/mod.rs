//! What watches over sensors, drives, time and memory. Each monitor keeps its own state and says what it found
//! as a [`Finding`]; the supervisor decides what becomes of it.

mod bucket;
mod clock;
mod encoder;
mod motion;
mod thresholds;
mod torque;

use shared::fault::{Fault, Limit};

pub use bucket::Bucket;
pub use clock::{Clock, Elapsed};
pub use encoder::Track;
pub use motion::Motions;
pub use thresholds::Thresholds;
pub use torque::Torques;

use crate::supervisor::Reaction;

/// A fault with the joints that it names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Finding {
    /// What is wrong.
    pub fault: Fault,
    /// One bit a joint.
    pub joints: u8,
}

impl Finding {
    /// Nothing is wrong.
    pub const NONE: Self = Self { fault: Fault::None, joints: 0 };

    /// A fault of no joint in particular.
    pub const fn new(fault: Fault) -> Self {
        Self { fault, joints: 0 }
    }

    /// A fault of joint `j`.
    pub const fn of_joint(fault: Fault, j: usize) -> Self {
        Self { fault, joints: 1 << j }
    }
}

/// What one tick's monitors found: the gravest fault, and what limits the arm without stopping it.
#[derive(Clone, Copy, Debug)]
pub struct Findings {
    /// The gravest; of equals the first, with the joints of all that are the same.
    pub worst: Finding,
    /// What that asks for.
    reaction: Reaction,
    /// One bit a [`Limit`].
    pub limits: u16,
}

impl Findings {
    /// Nothing found.
    pub const NONE: Self = Self { worst: Finding::NONE, reaction: Reaction::None, limits: 0 };

    /// Adds a fault.
    #[cold]
    #[inline(never)]
    pub fn raise(&mut self, finding: Finding) {
        if finding.fault == self.worst.fault {
            self.worst.joints |= finding.joints;
            return;
        }
        let reaction = Reaction::to(finding.fault);
        if reaction > self.reaction {
            (self.worst, self.reaction) = (finding, reaction);
        }
    }

    /// Adds a limit.
    #[inline(always)]
    pub fn limit(&mut self, limit: Limit) {
        self.limits |= 1 << limit as u8;
    }
}
