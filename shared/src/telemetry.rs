//! The record that every tick leaves behind, as little-endian words without padding, small fields packed lowest first.

use bytemuck::{Pod, Zeroable};

use crate::arm::JOINTS;

/// Size of an encoded record.
pub const RECORD_BYTES: usize = size_of::<Record>();

/// Everything a tick knew and decided, as it is sent. Joint 4 is in m, m/s and N.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Record {
    /// Ticks since reset, modulo 2³².
    pub tick: u32,
    /// [`crate::fault::Mode`] number.
    pub mode: u8,
    /// [`crate::fault::Refusal`] number of the last command.
    pub refusal: u8,
    /// [`crate::fault::Fault`] number that is latched.
    pub fault: u16,
    /// One bit a joint whose torque command sits at its limit.
    pub saturated: u8,
    /// One bit a joint whose disturbance estimate sits at its bound.
    pub adaptation_bound: u8,
    /// One bit a sample that this tick could not use: encoders 0 to 3, torque converter 4, DAC 5.
    pub rejected: u8,
    /// Records that the full queue dropped so far, saturating.
    pub dropped: u8,
    /// Ticks since the trajectory started.
    pub phase: u32,
    /// Last accepted encoder codes.
    pub code: [u32; JOINTS],
    /// Position error e1 = q - q_d, rad or m.
    pub e1: [f32; JOINTS],
    /// Velocity estimate, rad/s or m/s.
    pub qd: [f32; JOINTS],
    /// Velocity error, rad/s or m/s.
    pub e1_dot: [f32; JOINTS],
    /// Last accepted ADC codes, sign-extended.
    pub adc: [i32; JOINTS],
    /// Disturbance estimate, N m or N.
    pub d_hat: [f32; JOINTS],
    /// Torque command as DAC codes, offset binary.
    pub dac: [u16; JOINTS],
    /// One bit a [`crate::fault::Limit`] that holds the arm back.
    pub limits: u16,
    /// One bit a joint that the fault names.
    pub joints: u8,
    /// Drive enables in bits 0 to 3, brake releases in bits 4 to 7, as driven by this tick.
    pub powered: u8,
    /// Rate at which the path is followed, 1 is [`PATH_RATE_ONE`].
    pub path_rate: u16,
    /// Ticks so far that came late, early or not at all, modulo 256.
    pub irregular: u8,
    /// Highest level of all devices' loss buckets.
    pub bucket: u8,
}

/// [`Record::path_rate`] at full speed.
pub const PATH_RATE_ONE: u16 = 1 << 15;

impl Record {
    /// Encodes the record: its bytes as they are.
    pub fn to_bytes(&self) -> [u8; RECORD_BYTES] {
        bytemuck::cast(*self)
    }

    /// Decodes a record; every byte pattern is one.
    pub fn from_bytes(bytes: &[u8; RECORD_BYTES]) -> Self {
        bytemuck::pod_read_unaligned(bytes)
    }
}

const _: () = assert!(cfg!(target_endian = "little"), "records are little-endian");
