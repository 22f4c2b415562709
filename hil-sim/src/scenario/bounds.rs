//! The allowed range of every number in a scenario file, each written once: parser, error texts, command
//! line and tests read it here.

use std::fmt;

/// What a number has to look like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Any finite number.
    Real,
    /// An integer, written without point or exponent.
    Whole,
    /// Four finite numbers, one a joint.
    Four,
}

/// Closed range of one key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds<'a> {
    /// Path of the key; `*` stands for the controller of an `[accept]` table.
    pub key: &'a str,
    /// Lowest allowed value.
    pub lo: f64,
    /// Highest allowed value.
    pub hi: f64,
    /// Unit, empty where there is none.
    pub unit: &'a str,
    /// Form of the value.
    pub kind: Kind,
    /// Why the range ends where it does; empty where it needs no reason.
    pub why: &'a str,
}

impl Bounds<'_> {
    /// Whether a value lies in the range; never for NaN.
    pub fn contains(&self, value: f64) -> bool {
        self.lo <= value && value <= self.hi
    }

    /// Reads a whole number of the command line.
    ///
    /// # Errors
    /// A sentence with the allowed range and its reason.
    pub fn parse_whole(&self, text: &str) -> Result<u64, String> {
        match text.parse::<u64>() {
            Ok(value) if self.contains(value as f64) => Ok(value),
            _ if self.why.is_empty() => Err(format!("allowed: {self}")),
            _ => Err(format!("allowed: {self}; {}", self.why)),
        }
    }
}

impl fmt::Display for Bounds<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let form = match self.kind {
            Kind::Real => "a number",
            Kind::Whole => "a whole number",
            Kind::Four => "four numbers, each",
        };
        let (lo, hi) = match self.kind {
            Kind::Whole => (self.lo.to_string(), self.hi.to_string()),
            Kind::Real | Kind::Four => (short(self.lo), short(self.hi)),
        };
        write!(f, "{form} from {lo} to {hi}")?;
        if self.unit.is_empty() { Ok(()) } else { write!(f, " {}", self.unit) }
    }
}

/// At most six significant digits, with an exponent where that is shorter.
fn short(value: f64) -> String {
    let rounded = format!("{value:.5e}").parse().unwrap_or(value);
    if rounded == 0.0 || (1e-3..1e6).contains(&rounded.abs()) {
        rounded.to_string()
    } else {
        format!("{rounded:e}")
    }
}

macro_rules! bounds {
    ($($name:ident: $key:literal, $kind:ident, $lo:literal, $hi:literal, $unit:literal, $why:literal;)*) => {
        $(
            #[doc = concat!("`", $key, "`: ", $lo, " to ", $hi, " ", $unit, ". ", $why)]
            pub const $name: Bounds<'static> =
                Bounds { key: $key, lo: $lo, hi: $hi, unit: $unit, kind: Kind::$kind, why: $why };
        )*
        /// Every range of this module.
        pub const ALL: &[Bounds<'static>] = &[$($name),*];
    };
}

bounds! {
    TICK_HZ: "tick_hz", Whole, 1000.0, 8000.0, "Hz",
        "below 1000 Hz the delay of the digital chain comes near the stability edge (a limit cycle was \
         measured at 500 Hz), above 8000 Hz a tick's frames no longer fit on the bus";
    SEED: "seed", Whole, 0.0, 9_007_199_254_740_991.0, "",
        "above 2^53 JSON reports could not keep it exactly";
    DURATION_S: "duration_s", Real, 1.0, 60.0, "s", "";
    SETTLE_S: "settle_s", Real, 0.0, 10.0, "s", "";
    MASS_SCALE: "model.mass_scale", Real, 0.5, 1.5, "", "";
    MODEL_PAYLOAD_KG: "model.payload_kg", Real, 0.0, 300.0, "kg", "the arm is rated for 300 kg";
    FRICTION: "plant.friction", Four, 0.0, 10_000.0, "N m s/rad (joint 4: N s/m)", "";
    DISTURBANCE: "plant.disturbance", Four, 0.0, 1.0, "", "they scale the 30 N m sine of Eq 28";
    SUBSTEPS: "plant.substeps", Whole, 1.0, 16.0, "", "";
    PLANT_PAYLOAD_KG: "plant.payload_kg", Real, 0.0, 600.0, "kg",
        "twice the rated payload is the most tried";
    PAYLOAD_KG: "plant.payload.kg", Real, 0.0, 600.0, "kg", "twice the rated payload is the most tried";
    PAYLOAD_AT_S: "plant.payload.at_s", Real, 0.0, 60.0, "s",
        "the pick-up must not come after the trajectory's end (`duration_s`)";
    ROTARY_BITS: "encoders.rotary_bits", Whole, 16.0, 26.0, "bits",
        "the position word of the rotary encoder has 26 bits";
    LINEAR_LSB_M: "encoders.linear_lsb_m", Real, 50e-9, 10e-6, "m",
        "positions are kept as 26-bit counts, which a finer scale would leave";
    SKEW_S: "encoders.skew_s", Real, 0.0, 15e-6, "s",
        "the fourth latch must fall into the first half of the shortest tick, 125 us";
    ERROR_SHARE: "bus.error_share", Real, 0.0, 1.0, "", "it is a share of the frames";
    FAULT_AT_S: "fault.at_s", Real, -1000.0, 60.0, "s",
        "seconds after the trajectory's start, not after its end (`duration_s`); before power-up means from power-up on";
    FAULT_FOR_S: "fault.for_s", Real, 1e-6, 1000.0, "s", "";
    K1: "controller.k1", Real, 10.0, 500.0, "1/s", "";
    K2: "controller.k2", Real, 10.0, 500.0, "1/s", "";
    KP: "controller.kp", Real, 10.0, 40_000.0, "1/s²", "";
    KD: "controller.kd", Real, 1.0, 400.0, "1/s", "";
    WA: "controller.wa", Real, 0.0, 200.0, "rad/s", "a faster adaptation oscillates under payload";
    PSI: "controller.psi", Four, 1.0, 1e12, "", "psi must be positive";
    RSE_M: "accept.*.rse_m", Real, 1e-9, 1.0, "m", "";
    E_MAX_M: "accept.*.e_max_m", Real, 1e-9, 1.0, "m", "";
    RHO_S: "accept.*.rho_s", Real, 1e-9, 1.0, "s", "";
    RMS_M: "accept.*.rms_m", Real, 1e-9, 1.0, "m", "";
}

/// Command line's `--tick-hz`, held to the range of the file.
///
/// # Errors
/// The allowed range and its reason.
pub fn parse_tick_hz(text: &str) -> Result<u32, String> {
    TICK_HZ.parse_whole(text).map(|hz| hz as u32)
}

/// Command line's `--seed`, held to the range of the file.
///
/// # Errors
/// The allowed range and its reason.
pub fn parse_seed(text: &str) -> Result<u64, String> {
    SEED.parse_whole(text)
}
