//! Every kind of fault: what it does, where it can be, what its severity means. Parser, error texts, help and
//! injector read this one table.

use std::fmt;

use firmware::config::Config;
use firmware::memory::Coefficients;
use firmware::monitor::Thresholds;

use super::target::{
    BRAKE, CONTACT, DEVICES, ENCODER, ENCODERS, JOINT, ONE_JOINT, ONLY, PLACE, SENSORS, Target,
};
use crate::scenario::bounds::{Bounds, Kind as Form};

/// How long a fault lasts whose end is not given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Span {
    /// To the end of the run.
    Lasting,
    /// One tick.
    Once,
    /// It is there at power-up, and has no other time.
    PowerUp,
}

/// What a kind's severity means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Severity {
    /// Range; its reason says what the number is.
    pub bounds: Bounds<'static>,
    /// Value where none is given; `None` where one must be.
    pub default: Option<f64>,
}

const fn real(
    what: &'static str,
    unit: &'static str,
    (lo, hi): (f64, f64),
    default: Option<f64>,
) -> Option<Severity> {
    let bounds = Bounds { key: "fault.severity", lo, hi, unit, kind: Form::Real, why: what };
    Some(Severity { bounds, default })
}

const fn whole(what: &'static str, (lo, hi): (f64, f64), default: Option<f64>) -> Option<Severity> {
    let bounds = Bounds { key: "fault.severity", lo, hi, unit: "", kind: Form::Whole, why: what };
    Some(Severity { bounds, default })
}

/// A kind's row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Spec {
    /// The kind.
    pub kind: Kind,
    /// Its name in a scenario file.
    pub name: &'static str,
    /// Where such a fault can be.
    pub targets: &'static [Target],
    /// How long it lasts by itself.
    pub span: Span,
    /// What its severity means; `None` where it has none.
    pub severity: Option<Severity>,
    /// What it does.
    pub what: &'static str,
}

macro_rules! kinds {
    ($($kind:ident $name:literal $targets:ident $span:ident $severity:expr, $what:literal;)*) => {
        /// A kind of fault.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Kind { $(#[doc = $what] $kind,)* }

        /// Every kind, in the order of [`Kind`].
        pub const SPECS: &[Spec] = &[$(Spec {
            kind: Kind::$kind,
            name: $name,
            targets: $targets,
            span: Span::$span,
            severity: $severity,
            what: $what,
        },)*];
    };
}

const SHARE: (f64, f64) = (0.0, 1.0);
const EITHER: (f64, f64) = (0.0, 1.0);
const BITS: (f64, f64) = (1.0, 32.0);
const CONFIG_BITS: (f64, f64) = (0.0, (8 * size_of::<Config>() - 1) as f64);
/// Size of the largest place.
const PLACE_BYTES: usize = if size_of::<Thresholds>() > size_of::<Coefficients>() {
    size_of::<Thresholds>()
} else {
    size_of::<Coefficients>()
};
const PLACE_BITS: (f64, f64) = (0.0, (8 * PLACE_BYTES - 1) as f64);

kinds! {
    // Bus.
    BitFlips "bit-flips" DEVICES Lasting whole("bits flipped in each frame", BITS, Some(1.0)),
        "Bits are flipped in each answer, to the DAC in each frame of either direction.";
    Burst "burst" DEVICES Lasting whole("length in bits", BITS, Some(6.0)),
        "A burst spoils each answer, to the DAC each frame of either direction.";
    Mutation "mutation" DEVICES Lasting real("share of answers whose check sum fits", "", SHARE, Some(0.0)),
        "Answers have random contents, an encoder's behind a good header.";
    FrameLoss "frame-loss" DEVICES Lasting real("share of ticks", "", SHARE, Some(1.0)),
        "A device's frames are lost: it sees nothing, the bus driver reports an error.";
    Repeat "repeat" DEVICES Lasting None,
        "The answers of the last good tick come again and again.";
    Swap "swap" ENCODER Lasting whole("number of the other encoder", (1.0, 4.0), None),
        "Two encoders are exchanged.";
    Dead "dead" DEVICES Lasting whole("0 all zeros, 1 all ones, 2 a bus error", (0.0, 2.0), Some(2.0)),
        "The line is dead.";
    // Sensors.
    StuckEncoder "stuck-encoder" ENCODERS Lasting None,
        "The code stands still within one count.";
    Jump "jump" ENCODERS Once real("size", "rad (joint 4: m)", (-1.0, 1.0), Some(1e-3)),
        "The position is off by a jump.";
    TorqueDrift "torque-drift" JOINT Lasting real("rate", "N m/s (joint 4: N/s)", (-1e6, 1e6), Some(1e3)),
        "The torque transducer drifts.";
    ErrorBit "error-bit" ENCODERS Lasting None,
        "The encoder distrusts its position.";
    WarningBit "warning-bit" ENCODERS Lasting None,
        "The encoder wants to be cleaned.";
    Overrange "overrange" JOINT Lasting None,
        "The torque channel is clipped.";
    LateSamples "late-samples" ENCODERS Lasting whole("age in ticks", (1.0, 50.0), Some(5.0)),
        "Codes are old.";
    HalfRate "half-rate" ENCODERS Lasting None,
        "Every other code is that of the tick before.";
    SampleJitter "sample-jitter" ENCODERS Lasting real("half width", "s", (0.0, 1e-4), Some(1e-5)),
        "The code is latched too early or too late, uniformly random.";
    Zeros "zeros" SENSORS Lasting None,
        "Codes are zero, the check sum fits.";
    Missing "missing" DEVICES Lasting None,
        "Nobody answers: the line stays high.";
    // Actuators.
    EnableLost "enable-lost" JOINT Lasting None,
        "The drive gives nothing.";
    TorqueStuck "torque-stuck" JOINT Lasting real("share of full scale", "", (-1.0, 1.0), Some(1.0)),
        "While enabled the drive gives this torque whatever it is told.";
    TorqueInverted "torque-inverted" JOINT Lasting None,
        "The drive gives the opposite torque.";
    TorqueLimit "torque-limit" JOINT Lasting real("share of the torque limit", "", SHARE, Some(0.5)),
        "The drive saturates early.";
    BrakeJammed "brake-jammed" BRAKE Lasting whole("0 its contact tells, 1 it reports open", EITHER, Some(0.0)),
        "The brake does not open.";
    BrakeSlip "brake-slip" BRAKE Lasting real("share of its friction that is left", "", SHARE, Some(0.0)),
        "The brake slips.";
    BrakeNoFeedback "brake-no-feedback" BRAKE Lasting whole("0 it reports closed, 1 it reports open", EITHER, Some(0.0)),
        "The brake's contact sticks.";
    BrakeStuckOpen "brake-stuck-open" BRAKE Lasting None,
        "The brake does not set.";
    Payload "payload" ONLY Lasting real("added", "kg", (-600.0, 2_000.0), None),
        "A payload is added that the controller does not know.";
    PayloadDrop "payload-drop" ONLY Once None,
        "All payload falls off.";
    // Time.
    LateTick "late-tick" ONLY Once real("from the tick before", "ticks", (1.0, 1000.0), Some(1.2)),
        "The tick is late; the next is in time, or one tick later if this took 2 or more. Repeated: every \
         other one.";
    MissingTick "missing-tick" ONLY Once None,
        "The tick does not come.";
    DoubleTick "double-tick" ONLY Once None,
        "A second tick comes 5 % of a tick after the first.";
    Hang "hang" ONLY Lasting None,
        "No tick comes any more.";
    EarlyKick "early-kick" ONLY Once None,
        "A falling edge more reaches the watchdog, at the first tick that is too early for one.";
    ClockOff "clock-off" ONLY Lasting real("board's clock over its nominal rate", "", (0.5, 2.0), Some(1.02)),
        "The board's clock is off.";
    CounterWrap "counter-wrap" ONLY Once None,
        "The cycle counter wraps in the tick before.";
    OverBudget "over-budget" ONLY Once real("computing time reported", "ticks", (0.0, 100.0), Some(0.6)),
        "Ticks compute for too long.";
    // Numbers and memory.
    NonFinite "non-finite" ONE_JOINT Once whole("0 the speed, 1 the disturbance", EITHER, Some(0.0)),
        "An estimate is no number.";
    HugeError "huge-error" ONE_JOINT Once whole("bit of the position word", (20.0, 31.0), Some(30.0)),
        "A high bit of the estimated position flips.";
    DHat "d-hat" ONE_JOINT Once real("its value", "N m (joint 4: N)", (-1e9, 1e9), None),
        "The disturbance estimate is driven.";
    Flip "flip" PLACE Once whole("number of the bit", PLACE_BITS, Some(0.0)),
        "A bit of a parameter flips.";
    ConfigFlip "config-flip" ONLY PowerUp whole("number of the bit", CONFIG_BITS, Some(0.0)),
        "A bit of the configuration has flipped since its check sum was made.";
    // Operator.
    EStop "e-stop" ONLY Lasting None,
        "The emergency stop is pressed.";
    WireBroken "wire-broken" CONTACT Lasting None,
        "A contact of the emergency stop is open.";
    ContactsDiffer "contacts-differ" CONTACT Lasting None,
        "The emergency stop is pressed and this contact stays closed.";
    LinkSilent "link-silent" ONLY Lasting None,
        "No frame comes from the operator.";
    // Devices.
    AdcReset "adc-reset" ONLY Once None,
        "The torque converter is reset.";
    DacReset "dac-reset" ONLY Once None,
        "The DAC is reset.";
}

impl Kind {
    /// Its row of the table.
    pub fn spec(self) -> &'static Spec {
        &SPECS[self as usize]
    }

    /// The kind with this name in a scenario file.
    pub fn named(name: &str) -> Option<Self> {
        SPECS.iter().find(|spec| spec.name == name).map(|spec| spec.kind)
    }

    /// Range of its severity at `target`.
    pub fn severity(self, target: Target) -> Option<Severity> {
        let mut severity = self.spec().severity?;
        if let Target::Place(place) = target {
            severity.bounds.hi = (8 * place.bytes().len() - 1) as f64;
        }
        Some(severity)
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.spec().name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_stand_in_the_order_of_their_kinds_and_names_are_unique() {
        for (i, spec) in SPECS.iter().enumerate() {
            assert_eq!(spec.kind as usize, i);
            assert_eq!(Kind::named(spec.name), Some(spec.kind));
        }
    }

    #[test]
    fn bits_named_by_the_table_are_those_of_the_largest_place() {
        let hi = |target: &Target| Kind::Flip.severity(*target).map_or(0.0, |s| s.bounds.hi);
        let largest = PLACE.iter().map(hi).fold(0.0, f64::max);
        assert_eq!(Kind::Flip.spec().severity.map(|s| s.bounds.hi), Some(largest));
    }

    #[test]
    fn defaults_lie_in_their_ranges() {
        for spec in SPECS {
            for target in spec.targets {
                let Some(severity) = spec.kind.severity(*target) else { continue };
                let default = severity.default.unwrap_or(severity.bounds.lo);
                assert!(severity.bounds.contains(default), "{} on {target}", spec.name);
            }
        }
    }
}
