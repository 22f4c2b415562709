//! What the supervisor asks of the pins, and what they tell it.

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

/// Feedback of the brakes, one bit each; joint 1 is bit 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Brakes {
    /// Those that report open.
    pub open: u8,
    /// Those that report closed.
    pub closed: u8,
}
