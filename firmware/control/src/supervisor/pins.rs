//! What the supervisor asks of the pins, and what they tell it.

use super::{Mode, Timing};

/// Levels of the pins that decide about motion; joint 1 is bit 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Levels {
    /// Torque may flow at all.
    pub sto: bool,
    /// Drive enables.
    pub drives: u8,
    /// Brakes that are told to open.
    pub release: u8,
    /// DAC and ADC are out of reset.
    pub converters: bool,
}

impl Levels {
    /// Torque off, brakes set.
    pub const OFF: Self = Self { sto: false, drives: 0, release: 0, converters: true };
    /// As [`Self::OFF`], converters in reset.
    pub const RESET: Self = Self { converters: false, ..Self::OFF };
    /// Torque on against set brakes.
    pub const BRAKED: Self = Self { sto: true, drives: 0b1111, ..Self::OFF };
    /// Torque on, brakes open.
    pub const LIVE: Self = Self { release: 0b1111, ..Self::BRAKED };

    /// The same, but these joints have no torque and their brakes set.
    #[inline(always)]
    pub fn without(self, joints: u8) -> Self {
        Self { drives: self.drives & !joints, release: self.release & !joints, ..self }
    }
}

impl Mode {
    /// Pin levels that belong to this mode.
    #[inline(always)]
    pub fn levels(&self, timing: &Timing) -> Levels {
        if matches!(self, Self::Moving(_)) { Levels::LIVE } else { self.rare_levels(timing) }
    }

    /// The same where the mode is rarely [`Mode::Moving`].
    #[cold]
    #[inline(never)]
    pub fn rare_levels(&self, timing: &Timing) -> Levels {
        match self {
            Self::Moving(_) | Self::Holding { .. } | Self::Jogging { .. } => Levels::LIVE,
            Self::Boot { ticks, .. } if *ticks < timing.reset => Levels::RESET,
            Self::Boot { .. }
            | Self::Standby { .. }
            | Self::TorqueOff { .. }
            | Self::Latched { .. } => Levels::OFF,
            Self::Arming { ticks, .. } => lifted(*ticks, timing),
            Self::Lowering { ticks, cause, .. } => lifted(*ticks, timing).without(cause.isolated),
            Self::Stopping { cause, .. } => Levels::LIVE.without(cause.isolated),
            Self::BrakeHold { cause, .. } => Levels::BRAKED.without(cause.isolated),
        }
    }
}

/// Torque first, then the brakes.
fn lifted(ticks: u32, timing: &Timing) -> Levels {
    if ticks >= timing.preload { Levels::LIVE } else { Levels::BRAKED }
}

/// Feedback of the brakes, one bit each; joint 1 is bit 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Brakes {
    /// Those that report open.
    pub open: u8,
    /// Those that report closed.
    pub closed: u8,
}
