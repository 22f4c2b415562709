//! Modes, faults, limits and refusals as they appear in telemetry. Numbers are never used twice.

macro_rules! codes {
    ($(#[$meta:meta])* $name:ident: $repr:ty { $($(#[$doc:meta])* $variant:ident = $value:literal,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr($repr)]
        pub enum $name { $($(#[$doc])* $variant = $value,)* }

        impl $name {
            /// Every code.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)*];

            /// The code with this number, if there is one.
            pub const fn from_number(number: $repr) -> Option<Self> {
                match number { $($value => Some(Self::$variant),)* _ => None }
            }

            /// The code's name.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => stringify!($variant),)* }
            }
        }
    };
}

codes! {
    /// Why the controller stopped. Bands: 100 bus, 200 sensor, 300 actuator, 400 timing, 500 numeric,
    /// 700 memory, 800 operator, 900 device. `docs/faults.md` has an entry for each.
    Fault: u16 {
        /// No fault.
        None = 0,
        /// An encoder's samples were lost or refused by their check too often.
        EncoderLost = 101,
        /// The torque converter's samples were lost or refused too often.
        TorqueAdcLost = 102,
        /// The DAC did not acknowledge what was written.
        DacNotAcknowledged = 103,
        /// Two encoders jumped in the same tick, twice running.
        EncodersSwapped = 104,
        /// Not every sensor reported during boot.
        BootTimeout = 201,
        /// An encoder's code stands still while the set-point moves.
        EncoderStuck = 202,
        /// An encoder's samples are where the joint cannot be.
        EncoderImplausible = 203,
        /// A torque channel drifted away from the torque command.
        TorqueDrift = 204,
        /// The pose at power-up is not the one that was parked in.
        ParkedPoseDiffers = 205,
        /// A position at power-up lies outside the range of motion.
        PositionImpossible = 206,
        /// A brake's feedback contact did not follow its release in time.
        BrakeNotReleased = 301,
        /// An output pin could not be driven.
        PinNotDriven = 302,
        /// A drive gives no torque.
        DriveLost = 303,
        /// A drive gives another torque than it is told.
        TorqueWrong = 304,
        /// A joint is faster than it may be.
        Overspeed = 305,
        /// A joint did not follow the test move, although its brake reports open.
        BrakeNotFree = 306,
        /// A joint moved in its set brake.
        BrakeSlipped = 307,
        /// The arm stayed away from its set-point for too long.
        TrackingError = 308,
        /// A joint came too near to its end stop.
        PositionLimit = 309,
        /// A joint swings about its set-point.
        Oscillation = 310,
        /// Ticks came too late.
        TickLate = 401,
        /// Ticks took longer than their budget.
        TickOverBudget = 402,
        /// A tick did not end, and the board's own watchdog reset it; kept over the reset.
        TickHung = 403,
        /// An estimate was no number, or not what its sensor says; it was replaced.
        NotFinite = 501,
        /// The distance to the set-point is beyond anything that control can cause.
        ErrorWindow = 502,
        /// A parameter's two copies differed; the check sum says which is good.
        ParameterFlipped = 701,
        /// Neither copy of the parameters is good.
        ParametersLost = 702,
        /// The processor took a hard fault; kept over the reset.
        HardFault = 703,
        /// The stack overflowed; kept over the reset.
        StackOverflow = 704,
        /// The operator's emergency stop is open.
        EmergencyStop = 801,
        /// The two contacts of the emergency stop disagree.
        EmergencyStopContacts = 802,
        /// The operator link fell silent while the arm was moving.
        LinkLost = 803,
        /// The operator stopped the arm.
        OperatorStop = 804,
        /// The torque converter was reset.
        AdcReset = 901,
        /// The DAC was reset.
        DacReset = 902,
        /// The torque converter's configuration is not what was written.
        AdcConfiguration = 903,
    }
}

codes! {
    /// What holds performance back without stopping the arm; bit `n` of a record's `limits` is code `n`.
    Limit: u8 {
        /// A torque command sits at its limit.
        Torque = 0,
        /// A disturbance estimate sits at its bound.
        Adaptation = 1,
        /// Jogging is held back from an end stop.
        SoftPosition = 2,
        /// An encoder wants its scale or window cleaned.
        EncoderWarning = 3,
        /// A torque channel drifts, not yet too far.
        TorqueDrift = 4,
        /// The board's clock and the torque converter's differ.
        ClockDrift = 5,
        /// A tick came late, early, was missing, or took longer than its budget.
        TickTiming = 6,
        /// A brake was told to set and does not report it: torque holds.
        BrakeFeedback = 7,
        /// A sample of this tick, or the DAC's answer, could not be used.
        SampleRejected = 8,
        /// The torque converter refused a command.
        AdcCommand = 9,
    }
}

codes! {
    /// Mode of the controller.
    Mode: u8 {
        /// Devices are being configured and have not all reported.
        Boot = 0,
        /// Ready: brakes set, torque off.
        Standby = 1,
        /// Torque is preloaded, brakes are opening, then each joint shows in a test move that it is free.
        Arming = 2,
        /// Brakes open, the law holds a pose.
        Holding = 3,
        /// Brakes open, the law follows a trajectory.
        Moving = 4,
        /// Latched: brakes set, torque off.
        Latched = 5,
        /// Brakes open, the law follows a hand-held command.
        Jogging = 6,
        /// The path rate is being brought to zero (SS1).
        Stopping = 7,
        /// At rest under torque until the brakes have set.
        BrakeHold = 8,
        /// Torque is off and the brakes are setting (STO).
        TorqueOff = 9,
        /// A brake slipped: the arm is taken to its rest pose under torque.
        Lowering = 10,
    }
}

codes! {
    /// Why a command had no effect.
    Refusal: u8 {
        /// The last command was taken, or there was none.
        None = 0,
        /// The mode does not allow the command.
        WrongMode = 1,
        /// A trajectory is already running.
        Busy = 2,
        /// The trajectory's origin is not the present set-point.
        OriginMismatch = 3,
        /// The trajectory leaves the range of motion.
        OutOfRange = 4,
        /// The trajectory is faster than the speed limit allows.
        TooFast = 5,
        /// The trajectory starts with a velocity step and the command does not allow one.
        VelocityStep = 6,
        /// The duration is zero or longer than the phase counter can hold.
        BadDuration = 7,
        /// With the rated payload, a stop from this speed would take more torque than there is.
        NotStoppable = 8,
        /// A value is not a finite number.
        NotFinite = 9,
        /// A contact of the emergency stop is open.
        EmergencyStop = 10,
        /// The fault needs service: it is cleared by a power cycle only.
        LockedOut = 11,
        /// The operator's key is the default one.
        DefaultKey = 12,
        /// There is no gain of that name.
        UnknownGain = 13,
        /// A gain is out of its range.
        GainOutOfRange = 14,
        /// The gain belongs to another law than the one that runs.
        OtherLaw = 15,
    }
}

codes! {
    /// Why a frame of the operator link had no effect. From 100 on, so that an answer's reason is either one of
    /// these or a [`Refusal`].
    LinkRefusal: u8 {
        /// It is longer or shorter than a frame.
        Length = 101,
        /// Its CRC-32 is wrong.
        Damaged = 102,
        /// It is of another version of the link.
        Version = 103,
        /// Its kind is unknown, or not for the board.
        Kind = 104,
        /// Bytes that must be zero are not.
        Reserved = 105,
        /// There is no session: a Hello has to come first.
        NoSession = 106,
        /// Its code was made with another key.
        BadCode = 107,
        /// Its counter is not above that of the last frame taken: a repetition.
        Stale = 108,
        /// Its payload is no command or query.
        Malformed = 109,
        /// There is no such piece of evidence.
        NoSuchPiece = 110,
        /// No new session before the next boot: their number is used up.
        SessionsUsedUp = 111,
    }
}
