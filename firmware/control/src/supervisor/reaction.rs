//! What each fault leads to.

use shared::fault::Fault;

/// From the mildest to the gravest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reaction {
    /// None.
    None,
    /// Stop along the path, set the brakes, then switch torque off (SS1).
    Ss1,
    /// The joints named lose their torque and get their brakes at once, the others stop (SS1).
    Isolate,
    /// Torque off and all brakes at once (STO).
    Sto,
}

impl Reaction {
    /// The reaction to `fault`: torque is cut only where it cannot be trusted.
    pub const fn to(fault: Fault) -> Self {
        match fault {
            Fault::None => Self::None,
            Fault::DriveLost => Self::Isolate,
            Fault::DacNotAcknowledged
            | Fault::DacReset
            | Fault::PinNotDriven
            | Fault::TorqueWrong
            | Fault::Overspeed
            | Fault::TickHung
            | Fault::ParametersLost
            | Fault::HardFault
            | Fault::StackOverflow => Self::Sto,
            _ => Self::Ss1,
        }
    }
}

/// Whether an operator's order clears the fault; the others need service and a power cycle.
pub const fn clears(fault: Fault) -> bool {
    !matches!(fault, Fault::BrakeSlipped | Fault::ParametersLost)
}
