//! Parameters of the arm: geometry, inertias, limits and the scales of its sensors and drives.
//!
//! SI units; joint 4 is prismatic, so its position is in m, its rate in m/s and its "torque" a force in N.
//! Values are `f64` so that the plant has them exactly; the firmware rounds them once, when it builds its
//! configuration.

/// Number of joints.
pub const JOINTS: usize = 4;

/// Standard gravity as the reference data use it, m/s².
pub const GRAVITY_M_S2: f64 = 9.81;

/// Lengths of the modified Denavit-Hartenberg table (paper Table 1), m.
///
/// | row | theta | d | a(i-1) | alpha(i-1) |
/// |---|---|---|---|---|
/// | 1 | q1 | 0 | 0 | 0 |
/// | 1' | pi/2 | `d1` | 0 | 0 |
/// | 2 | q2 | 0 | `a1` | pi/2 |
/// | 3 | q3 | `d3` | `a2` | 0 |
/// | 4 | pi | q4 | `a3` | pi/2 |
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    /// Offset of the boom pin from the slewing axis (row 2, a).
    pub a1_m: f64,
    /// Boom length between pins (row 3, a).
    pub a2_m: f64,
    /// Offset of the telescope from the forearm pin (row 4, a).
    pub a3_m: f64,
    /// Height of the boom pin (row 1', d).
    pub d1_m: f64,
    /// Lateral offset of the forearm (row 3, d).
    pub d3_m: f64,
}

/// Inertial parameters of one rigid body in its link's MDH frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertial {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of mass, m.
    pub com_m: [f64; 3],
    /// Entries `[Ixx, Iyy, Izz, Ixy, Ixz, Iyz]` of the inertia tensor about the centre of mass, kg m².
    /// They are tensor entries: Ixy = -∫xy dm.
    pub inertia_com_kg_m2: [f64; 6],
}

/// Range of motion and of effort of one joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits {
    /// Lowest position, rad or m.
    pub q_min: f64,
    /// Highest position, rad or m.
    pub q_max: f64,
    /// Highest speed, rad/s or m/s.
    pub qd_max: f64,
    /// Highest torque or force, N m or N.
    pub tau_max: f64,
}

/// An absolute encoder: `code = round((q - zero) / lsb) mod 2^bits`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncoderSpec {
    /// Width of the position word, bits (up to 32).
    pub bits: u32,
    /// One count, rad or m.
    pub lsb: f64,
    /// Joint position at code 0, rad or m; such that no joint wraps inside its range.
    pub zero: f64,
}

/// Everything about the arm that both the plant and the controller are told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arm {
    /// MDH lengths.
    pub geometry: Geometry,
    /// Column, boom, forearm, telescope.
    pub links: [Inertial; JOINTS],
    /// Joint limits.
    pub limits: [JointLimits; JOINTS],
    /// Encoders.
    pub encoders: [EncoderSpec; JOINTS],
    /// Drive torque at the DAC's positive full scale, N m or N.
    pub drive_full_scale: [f64; JOINTS],
    /// Measured torque at the ADC's positive full scale, N m or N.
    pub torque_full_scale: [f64; JOINTS],
}

/// The reference arm: about the size of a 10 t m loader crane.
///
/// The paper prints no masses; each link follows from the box or cylinder named beside it.
pub const REFERENCE: Arm = Arm {
    geometry: Geometry { a1_m: -0.552, a2_m: 2.622, a3_m: 0.02, d1_m: 1.548, d3_m: -0.19 },
    links: [
        // Column 1.6 m tall, r = 0.35 m: m(3r²+h²)/12 and m r²/2; leaning 0.15 m towards the boom pin.
        Inertial {
            mass_kg: 900.0,
            com_m: [0.0, -0.15, 0.8],
            inertia_com_kg_m2: [219.6, 219.6, 55.0, 0.0, 0.0, 12.0],
        },
        // Boom: welded 0.30 x 0.28 m box of 110 kg/m, 2.75 m long, with half of the lift cylinder.
        Inertial {
            mass_kg: 420.0,
            com_m: [1.25, 0.06, -0.08],
            inertia_com_kg_m2: [11.8, 270.0, 270.0, -4.5, 3.0, 0.4],
        },
        // Forearm: outer telescope box 0.24 x 0.24 x 2.7 m along -y3, with the extension cylinder.
        Inertial {
            mass_kg: 310.0,
            com_m: [0.03, -1.15, 0.02],
            inertia_com_kg_m2: [192.0, 6.0, 192.0, 2.5, 0.2, -1.8],
        },
        // Telescope: inner section 0.18 x 0.18 x 2.8 m ending at the tip.
        Inertial {
            mass_kg: 160.0,
            com_m: [0.01, -0.005, -1.25],
            inertia_com_kg_m2: [105.5, 105.5, 1.73, 0.05, 1.2, -0.6],
        },
    ],
    limits: [
        JointLimits { q_min: -3.1, q_max: 3.1, qd_max: 0.6, tau_max: 30_000.0 },
        JointLimits { q_min: -0.3, q_max: 1.4, qd_max: 0.4, tau_max: 120_000.0 },
        JointLimits { q_min: -2.0, q_max: 2.0, qd_max: 0.5, tau_max: 70_000.0 },
        JointLimits { q_min: 2.9, q_max: 5.3, qd_max: 0.8, tau_max: 30_000.0 },
    ],
    // Zeros keep every range inside one turn and any two codes at least 0.2 rad apart in the shipped
    // poses, so that two swapped encoders show as a jump.
    encoders: [rotary(26, -3.13), rotary(26, -0.8), rotary(26, -2.6), linear(32, 50e-9, 2.5)],
    drive_full_scale: [
        30_000.0 * DRIVE_HEADROOM,
        120_000.0 * DRIVE_HEADROOM,
        70_000.0 * DRIVE_HEADROOM,
        30_000.0 * DRIVE_HEADROOM,
    ],
    torque_full_scale: [
        30_000.0 * SENSOR_HEADROOM,
        120_000.0 * SENSOR_HEADROOM,
        70_000.0 * SENSOR_HEADROOM,
        30_000.0 * SENSOR_HEADROOM,
    ],
};

/// Drives take 32 000 of 32 768 codes at the torque limit, so the limit itself is exactly on a code.
const DRIVE_HEADROOM: f64 = 32_768.0 / 32_000.0;

/// Transducers see a quarter more than the torque limit before the converter saturates.
const SENSOR_HEADROOM: f64 = 1.25;

/// A 0.5 m cube of 300 kg held rigidly, its centre 0.25 m beyond the tip (telescope frame).
pub const PAYLOAD: Inertial = Inertial {
    mass_kg: 300.0,
    com_m: [0.0, 0.0, 0.25],
    inertia_com_kg_m2: [12.5, 12.5, 12.5, 0.0, 0.0, 0.0],
};

/// Start of the paper's lift (Section 4), rad and m.
pub const Q0: [f64; JOINTS] = [0.2129, 1.1229, -0.1416, 4.0915];

/// An encoder with `2^bits` counts a turn.
pub const fn rotary(bits: u32, zero_rad: f64) -> EncoderSpec {
    EncoderSpec { bits, lsb: core::f64::consts::TAU / (1u64 << bits) as f64, zero: zero_rad }
}

/// A linear encoder with the given resolution.
pub const fn linear(bits: u32, lsb_m: f64, zero_m: f64) -> EncoderSpec {
    EncoderSpec { bits, lsb: lsb_m, zero: zero_m }
}

impl Arm {
    /// The same arm with `rotary_bits` encoders on joints 1 to 3 and a linear one of `linear_lsb_m`.
    pub const fn with_encoders(mut self, rotary_bits: u32, linear_lsb_m: f64) -> Self {
        let mut j = 0;
        while j < JOINTS - 1 {
            self.encoders[j] = rotary(rotary_bits, self.encoders[j].zero);
            j += 1;
        }
        let last = self.encoders[JOINTS - 1];
        self.encoders[JOINTS - 1] = linear(last.bits, linear_lsb_m, last.zero);
        self
    }

    /// Torque that the DAC's `code` (offset binary, 16 bits) asks the drive of joint `j` for, N m and N.
    pub fn commanded(&self, j: usize, code: u16) -> f64 {
        (f64::from(code) - 32_768.0) / 32_768.0 * self.drive_full_scale[j]
    }
}
