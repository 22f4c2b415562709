//! The transition table: every way from one mode to another, and no other.

use shared::fault::Mode;

/// Why a mode is left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Every device reported, and the arm is where it was parked.
    Ready,
    /// The operator arms.
    Arm,
    /// Every joint followed the test move.
    Free,
    /// The operator starts a trajectory.
    Start,
    /// The trajectory's end is reached.
    PathEnded,
    /// The operator jogs.
    Jog,
    /// The jog timed out or came to an end stop, and its path rate is zero.
    JogEnded,
    /// The operator or a monitor stops the arm.
    Stop,
    /// A monitor finds that torque cannot be trusted, or the model alone cannot hold the arm any longer.
    CutTorque,
    /// The path rate is zero, or not yet begun to rise.
    AtRest,
    /// The arm does not follow the path that it stops along.
    Astray,
    /// Every brake reports closed, and torque stayed on long enough after it.
    BrakesSet,
    /// The operator clears the stop.
    Clear,
    /// A joint moves in its brake.
    Slipped,
    /// The rest pose is reached.
    Lowered,
}

macro_rules! transitions {
    ($($from:ident: $($exit:ident -> $to:ident),+;)+) => {
        /// From, exit and to of every transition.
        pub const TRANSITIONS: &[(Mode, Exit, Mode)] =
            &[$($((Mode::$from, Exit::$exit, Mode::$to)),+),+];

        /// Where `exit` leads from `from`; `None` where there is no such way.
        pub(super) const fn next(from: Mode, exit: Exit) -> Option<Mode> {
            match (from, exit) {
                $($((Mode::$from, Exit::$exit) => Some(Mode::$to),)+)+
                _ => None,
            }
        }
    };
}

transitions! {
    Boot: Ready -> Standby;
    Standby: Arm -> Arming, Stop -> Latched, CutTorque -> Latched, Slipped -> Lowering;
    Arming: Free -> Holding, Stop -> BrakeHold, CutTorque -> TorqueOff;
    Holding: Start -> Moving, Jog -> Jogging, Stop -> BrakeHold, CutTorque -> TorqueOff;
    Moving: PathEnded -> Holding, Stop -> Stopping, CutTorque -> TorqueOff;
    Jogging: JogEnded -> Holding, Stop -> Stopping, CutTorque -> TorqueOff;
    Stopping: AtRest -> BrakeHold, Astray -> BrakeHold, CutTorque -> TorqueOff;
    BrakeHold: Astray -> BrakeHold, BrakesSet -> Latched, CutTorque -> TorqueOff;
    TorqueOff: BrakesSet -> Latched;
    Latched: Clear -> Boot, Slipped -> Lowering;
    Lowering: Lowered -> BrakeHold, AtRest -> BrakeHold, Stop -> Stopping, CutTorque -> TorqueOff;
}
