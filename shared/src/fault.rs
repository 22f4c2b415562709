//! Fault codes and modes as they appear in telemetry. Numbers are banded and never used twice.

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
    /// Why the controller left normal operation. Bands: 100 bus, 200 sensor, 300 actuator, 400 timing,
    /// 500 numeric, 600 command, 700 memory, 800 operator, 900 device.
    Fault: u16 {
        /// No fault.
        None = 0,
        /// An encoder's samples were lost or refused too often.
        EncoderLost = 101,
        /// The torque converter's samples were lost or refused too often.
        TorqueAdcLost = 102,
        /// The DAC did not acknowledge what was written.
        DacNotAcknowledged = 103,
        /// Not every sensor reported during boot.
        BootTimeout = 201,
        /// A brake's feedback contact did not follow its command in time.
        BrakeNotReleased = 301,
        /// An output pin could not be driven.
        PinNotDriven = 302,
        /// The operator's emergency stop is open.
        EmergencyStop = 801,
    }
}

codes! {
    /// Mode of the controller.
    Mode: u8 {
        /// Devices are being configured and have not all reported.
        Boot = 0,
        /// Ready: brakes set, torque off.
        Standby = 1,
        /// Torque is preloaded, brakes are opening.
        Arming = 2,
        /// Brakes open, the law holds a pose.
        Holding = 3,
        /// Brakes open, the law follows a trajectory.
        Moving = 4,
        /// Latched: brakes set, torque off.
        Safe = 5,
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
    }
}
