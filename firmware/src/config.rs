//! Configuration: plain physical values, refused by name before they become coefficients.

use bytemuck::{Pod, Zeroable};
use shared::arm::{Arm, Inertial, JOINTS, PAYLOAD, REFERENCE};
use shared::wire::biss_c::{LATCH_DELAY_S, Layout};

/// Lengths of the MDH table, m; see [`shared::arm::Geometry`].
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Geometry {
    /// Row 2, a.
    pub a1_m: f32,
    /// Row 3, a.
    pub a2_m: f32,
    /// Row 4, a.
    pub a3_m: f32,
    /// Row 1', d.
    pub d1_m: f32,
    /// Row 3, d.
    pub d3_m: f32,
}

/// A rigid body in its link's MDH frame; see [`Inertial`].
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Body {
    /// Mass, kg.
    pub mass_kg: f32,
    /// Centre of mass, m.
    pub com_m: [f32; 3],
    /// Tensor entries `[Ixx, Iyy, Izz, Ixy, Ixz, Iyz]` about the centre of mass, kg m².
    pub inertia_com_kg_m2: [f32; 6],
}

/// The arm as the controller believes it to be.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ArmModel {
    /// MDH lengths.
    pub geometry: Geometry,
    /// Column, boom, forearm, telescope.
    pub links: [Body; JOINTS],
    /// What hangs at the tip, in the telescope's frame.
    pub payload: Body,
    /// Gravity, m/s².
    pub gravity_m_s2: f32,
}

/// One joint's encoder, drive, transducer and limits. SI units; joint 4 in m and N.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Joint {
    /// Range of motion.
    pub q_min: f32,
    /// Range of motion.
    pub q_max: f32,
    /// Highest speed of a trajectory.
    pub qd_max: f32,
    /// Highest torque command.
    pub tau_max: f32,
    /// Width of the encoder's position word.
    pub encoder_bits: u32,
    /// One encoder count.
    pub encoder_lsb: f32,
    /// Position at code 0.
    pub encoder_zero: f32,
    /// From the tick instant to the encoder's latch, s.
    pub latch_offset_s: f32,
    /// Drive torque at the DAC's positive full scale.
    pub drive_full_scale: f32,
    /// Measured torque at the ADC's positive full scale.
    pub torque_full_scale: f32,
}

/// Control law, as a number: a flipped bit may not make an invalid value of it.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Law(pub u32);

impl Law {
    /// Backstepping with psi = wa² M².
    pub const INERTIA_WEIGHTED: Self = Self(0);
    /// Backstepping with a constant diagonal psi.
    pub const PAPER_PSI: Self = Self(1);
    /// Backstepping without adaptation.
    pub const FIXED_GAIN: Self = Self(2);
    /// Computed-torque PD, Eq 29.
    pub const PD: Self = Self(3);
}

/// Gains of the laws and of the observer.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Gains {
    /// Which law runs.
    pub law: Law,
    /// Diagonal of K1, 1/s (Eq 12).
    pub k1: [f32; JOINTS],
    /// Diagonal of K2, 1/s (Eq 20).
    pub k2: [f32; JOINTS],
    /// Adaptation bandwidth of the inertia-weighted law, rad/s.
    pub wa_rad_s: f32,
    /// Diagonal of psi (Eq 19).
    pub psi: [f32; JOINTS],
    /// Bound of the disturbance estimate (Eq 5), N m and N.
    pub d_max: [f32; JOINTS],
    /// Position gain of the PD, 1/s².
    pub kp: [f32; JOINTS],
    /// Velocity gain of the PD, 1/s.
    pub kd: [f32; JOINTS],
    /// Double pole of the tracking observer, rad/s.
    pub observer_rad_s: f32,
}

/// Everything that a board's owner may set: 32-bit words without padding, so that it can be sent, kept and
/// checked as bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Config {
    /// Ticks a second.
    pub tick_hz: u32,
    /// The arm.
    pub arm: ArmModel,
    /// Its joints.
    pub joints: [Joint; JOINTS],
    /// Gains.
    pub gains: Gains,
}

/// A value that cannot be used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConfigError {
    /// Name of the field.
    pub field: &'static str,
    /// Which element of it, counted from 0.
    pub index: usize,
    /// What was found.
    pub value: f32,
    /// Lowest value allowed.
    pub min: f32,
    /// Highest value allowed.
    pub max: f32,
}

impl core::fmt::Display for ConfigError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { field, index, value, min, max } = self;
        write!(f, "{field}[{index}] = {value} is outside {min} to {max}")
    }
}

/// Lowest tick rate: through the whole chain 500 Hz ends in a limit cycle.
pub const TICK_HZ_MIN: u32 = 1_000;
/// Highest tick rate that wire time leaves room for.
pub const TICK_HZ_MAX: u32 = 8_000;

/// Encoder counts a joint may span: positions are kept as 32-bit words with 6 fractional bits.
const SPAN_MAX_COUNTS: f32 = 67_108_864.0;
/// Counts a tick at the speed limit, with 6 fractional bits below the rounder's 2²² and a reserve of 2.
const STEP_MAX_COUNTS: f32 = 32_768.0;

/// Widths of position word that the frame has room for.
const ENCODER_BITS_MIN: f32 = 12.0;
const ENCODER_BITS_MAX: f32 = 32.0;

const fn body(b: &Inertial, scale: f32) -> Body {
    let c = b.com_m;
    let i = b.inertia_com_kg_m2;
    Body {
        mass_kg: b.mass_kg as f32 * scale,
        com_m: [c[0] as f32, c[1] as f32, c[2] as f32],
        inertia_com_kg_m2: [
            i[0] as f32 * scale,
            i[1] as f32 * scale,
            i[2] as f32 * scale,
            i[3] as f32 * scale,
            i[4] as f32 * scale,
            i[5] as f32 * scale,
        ],
    }
}

const fn joint(arm: &Arm, j: usize) -> Joint {
    let limits = arm.limits[j];
    let encoder = arm.encoders[j];
    Joint {
        q_min: limits.q_min as f32,
        q_max: limits.q_max as f32,
        qd_max: limits.qd_max as f32,
        tau_max: limits.tau_max as f32,
        encoder_bits: encoder.bits,
        encoder_lsb: encoder.lsb as f32,
        encoder_zero: encoder.zero as f32,
        latch_offset_s: LATCH_DELAY_S as f32,
        drive_full_scale: arm.drive_full_scale[j] as f32,
        torque_full_scale: arm.torque_full_scale[j] as f32,
    }
}

impl ArmModel {
    /// The controller's model of `arm`, every mass and inertia times `mass_scale`, carrying `payload_kg`.
    pub const fn new(arm: &Arm, mass_scale: f32, payload_kg: f32) -> Self {
        let g = &arm.geometry;
        let l = &arm.links;
        Self {
            geometry: Geometry {
                a1_m: g.a1_m as f32,
                a2_m: g.a2_m as f32,
                a3_m: g.a3_m as f32,
                d1_m: g.d1_m as f32,
                d3_m: g.d3_m as f32,
            },
            links: [
                body(&l[0], mass_scale),
                body(&l[1], mass_scale),
                body(&l[2], mass_scale),
                body(&l[3], mass_scale),
            ],
            payload: body(&PAYLOAD, payload_kg / PAYLOAD.mass_kg as f32),
            gravity_m_s2: shared::arm::GRAVITY_M_S2 as f32,
        }
    }
}

impl Config {
    /// Defaults for `arm` at `tick_hz`: the inertia-weighted law with the paper's K1 and K2.
    pub const fn for_arm(arm: &Arm, tick_hz: u32) -> Self {
        Self {
            tick_hz,
            arm: ArmModel::new(arm, 1.0, 0.0),
            joints: [joint(arm, 0), joint(arm, 1), joint(arm, 2), joint(arm, 3)],
            gains: Gains {
                law: Law::INERTIA_WEIGHTED,
                k1: [200.0; JOINTS],
                k2: [200.0; JOINTS],
                wa_rad_s: 100.0,
                // The strongest diagonal that stays quiet at 2 kHz.
                psi: [7.6e10, 4.9e10, 1.85e10, 4.1e8],
                d_max: [6_000.0, 20_000.0, 15_000.0, 6_000.0],
                kp: [9_000.0; JOINTS],
                kd: [80.0; JOINTS],
                observer_rad_s: 2_400.0,
            },
        }
    }

    /// Checks every value by name: finite, sign and range.
    ///
    /// # Errors
    /// The first value that is out of range, with its range.
    pub fn validate(&self) -> Result<(), ConfigError> {
        let mut check = Check(Ok(()));
        let tick_hz = self.tick_hz as f32;
        check.one("tick_hz", 0, tick_hz, TICK_HZ_MIN as f32, TICK_HZ_MAX as f32);
        self.arm.validate(&mut check);
        for (j, joint) in self.joints.iter().enumerate() {
            joint.validate(&mut check, j, tick_hz);
        }
        self.gains.validate(&mut check, tick_hz);
        check.0
    }
}

impl Default for Config {
    /// The reference arm at 2 kHz.
    fn default() -> Self {
        const { Self::for_arm(&REFERENCE, 2_000) }
    }
}

impl ArmModel {
    fn validate(&self, check: &mut Check) {
        let g = &self.geometry;
        let lengths = [g.a1_m, g.a2_m, g.a3_m, g.d1_m, g.d3_m];
        check.all("geometry_m", &lengths, -20.0, 20.0);
        check.one("gravity_m_s2", 0, self.gravity_m_s2, 0.0, 20.0);
        for (i, link) in self.links.iter().enumerate() {
            check.one("links.mass_kg", i, link.mass_kg, 1.0, 20_000.0);
            link.validate(check);
        }
        check.one("payload.mass_kg", 0, self.payload.mass_kg, 0.0, 5_000.0);
        self.payload.validate(check);
    }
}

impl Body {
    #[inline(never)]
    fn validate(&self, check: &mut Check) {
        check.all("com_m", &self.com_m, -20.0, 20.0);
        let [ixx, iyy, izz, ixy, ixz, iyz] = self.inertia_com_kg_m2;
        check.all("inertia_com_kg_m2 moments", &[ixx, iyy, izz], 0.0, 1e6);
        check.all("inertia_com_kg_m2 products", &[ixy, ixz, iyz], -1e6, 1e6);
    }
}

impl Joint {
    #[inline(never)]
    fn validate(&self, check: &mut Check, j: usize, tick_hz: f32) {
        check.one("q_min", j, self.q_min, -60.0, 60.0);
        check.one("q_max", j, self.q_max, self.q_min, 60.0);
        check.one("qd_max", j, self.qd_max, 1e-3, 10.0);
        check.one("tau_max", j, self.tau_max, 1.0, 1e6);
        check.one("encoder_bits", j, self.encoder_bits as f32, ENCODER_BITS_MIN, ENCODER_BITS_MAX);
        check.one("encoder_lsb", j, self.encoder_lsb, 1e-9, 1e-3);
        let top = self.q_min;
        let bottom = self.q_max - SPAN_MAX_COUNTS * self.encoder_lsb;
        check.one("encoder_zero", j, self.encoder_zero, bottom, top);
        let step_max = self.encoder_lsb * STEP_MAX_COUNTS * tick_hz;
        check.one("qd_max against encoder_lsb", j, self.qd_max, 0.0, step_max);
        check.one("latch_offset_s", j, self.latch_offset_s, 0.0, 0.5 / tick_hz);
        check.one("drive_full_scale", j, self.drive_full_scale, self.tau_max, 2e6);
        check.one("torque_full_scale", j, self.torque_full_scale, self.tau_max, 2e6);
    }
}

impl Joint {
    /// Layout of the encoder's frames.
    pub(crate) fn layout(&self, j: usize) -> Result<Layout, ConfigError> {
        let value = self.encoder_bits as f32;
        Layout::new(self.encoder_bits).ok_or(ConfigError {
            field: "encoder_bits",
            index: j,
            value,
            min: ENCODER_BITS_MIN,
            max: ENCODER_BITS_MAX,
        })
    }
}

impl Gains {
    fn validate(&self, check: &mut Check, tick_hz: f32) {
        // Discrete stability wants each first-order pole well inside the tick rate.
        let fastest = 0.5 * tick_hz;
        check.one("law", 0, self.law.0 as f32, 0.0, Law::PD.0 as f32);
        check.all("k1", &self.k1, 1.0, fastest);
        check.all("k2", &self.k2, 1.0, fastest);
        check.one("wa_rad_s", 0, self.wa_rad_s, 0.0, 200.0);
        check.all("psi", &self.psi, 0.0, 1e12);
        check.all("d_max", &self.d_max, 0.0, 1e6);
        check.all("kp", &self.kp, 0.0, fastest * fastest);
        check.all("kd", &self.kd, 0.0, fastest);
        check.one("observer_rad_s", 0, self.observer_rad_s, 10.0, 3.0 * tick_hz);
    }
}

/// What validation found first. It goes on after that, so that no value needs a way out of its own.
struct Check(Result<(), ConfigError>);

impl Check {
    #[inline(never)]
    fn all(&mut self, field: &'static str, values: &[f32], min: f32, max: f32) {
        for (i, &value) in values.iter().enumerate() {
            self.one(field, i, value, min, max);
        }
    }

    /// A NaN lies within nothing.
    #[inline(never)]
    fn one(&mut self, field: &'static str, index: usize, value: f32, min: f32, max: f32) {
        if self.0.is_ok() && !(value >= min && value <= max) {
            self.0 = Err(ConfigError { field, index, value, min, max });
        }
    }
}
