//! Commands to the controller, as values and as fixed-size little-endian bytes.

use crate::arm::JOINTS;

/// Time law of a trajectory, s(x) with x = t / duration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Profile {
    /// s = 10x³ - 15x⁴ + 6x⁵, rest to rest.
    Quintic = 0,
    /// s = sin(πx): starts and ends with a velocity step.
    HalfSine = 1,
}

/// A joint-space path q_d = origin + amplitude · s(t / duration).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Trajectory {
    /// Time law.
    pub profile: Profile,
    /// Accept a velocity step at the start.
    pub allow_velocity_step: bool,
    /// Refuse it if a joint would be faster than this share of its speed limit, per cent.
    pub speed_limit_percent: u8,
    /// Duration in ticks.
    pub duration_ticks: u32,
    /// Start, in encoder counts with 6 fractional bits, modulo 2³².
    pub origin_q6: [u32; JOINTS],
    /// Amplitude, in encoder counts with 5 fractional bits.
    pub amplitude_q5: [i32; JOINTS],
}

/// A gain by its number in a [`Command::SetGain`]; `firmware::config::Gains` describes each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum GainName {
    /// Diagonal of K1, 1/s.
    K1 = 0,
    /// Diagonal of K2, 1/s.
    K2 = 1,
    /// Adaptation bandwidth in the first value, rad/s.
    Wa = 2,
    /// Diagonal of psi.
    Psi = 3,
    /// Bound of the disturbance estimate, N m and N.
    DMax = 4,
    /// Position gain of the PD, 1/s².
    Kp = 5,
    /// Velocity gain of the PD, 1/s.
    Kd = 6,
}

impl GainName {
    /// Every gain with the name that an operator types.
    pub const ALL: [(Self, &'static str); 7] = [
        (Self::K1, "k1"),
        (Self::K2, "k2"),
        (Self::Wa, "wa"),
        (Self::Psi, "psi"),
        (Self::DMax, "d_max"),
        (Self::Kp, "kp"),
        (Self::Kd, "kd"),
    ];
}

/// What an operator can ask for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Preload torque, open the brakes, try each joint and hold the measured pose.
    Arm,
    /// Follow a trajectory from the present set-point.
    Start(Trajectory),
    /// Stop along the path, set the brakes and switch torque off.
    Stop,
    /// Leave a latched stop: all devices are configured and checked anew.
    Clear,
    /// Move at these joint speeds (rad/s and m/s) while the command is repeated.
    Jog([f32; JOINTS]),
    /// Change one gain without a step in torque; a gain without joints uses the first value.
    SetGain {
        /// Number of a [`GainName`]; others are refused by the controller.
        name: u8,
        /// One value a joint.
        values: [f32; JOINTS],
    },
    /// The pose at power-up is right although it is not the parked one.
    ConfirmPose,
}

/// Size of an encoded command.
pub const COMMAND_BYTES: usize = 40;

const TAG_ARM: u8 = 1;
const TAG_START: u8 = 2;
const TAG_STOP: u8 = 3;
const TAG_CLEAR: u8 = 4;
const TAG_JOG: u8 = 5;
const TAG_SET_GAIN: u8 = 6;
const TAG_CONFIRM_POSE: u8 = 7;

impl Command {
    /// Encodes: tag and three bytes of detail, then up to nine little-endian words.
    pub fn to_bytes(&self) -> [u8; COMMAND_BYTES] {
        let mut words = [0; WORDS];
        let head = match self {
            Self::Arm => [TAG_ARM, 0, 0, 0],
            Self::Stop => [TAG_STOP, 0, 0, 0],
            Self::Clear => [TAG_CLEAR, 0, 0, 0],
            Self::ConfirmPose => [TAG_CONFIRM_POSE, 0, 0, 0],
            Self::Jog(speeds) => {
                fill(&mut words, speeds.map(f32::to_bits));
                [TAG_JOG, 0, 0, 0]
            }
            Self::SetGain { name, values } => {
                fill(&mut words, values.map(f32::to_bits));
                [TAG_SET_GAIN, *name, 0, 0]
            }
            Self::Start(t) => {
                let amplitude = t.amplitude_q5.map(|a| a as u32);
                let all = [t.duration_ticks].into_iter().chain(t.origin_q6).chain(amplitude);
                fill(&mut words, all);
                let step = u8::from(t.allow_velocity_step);
                [TAG_START, t.profile as u8, step, t.speed_limit_percent]
            }
        };
        let mut bytes = [0; COMMAND_BYTES];
        let all = head.into_iter().chain(words.into_iter().flat_map(u32::to_le_bytes));
        fill(&mut bytes, all);
        bytes
    }

    /// Decodes; `None` where tag, profile or flags are unknown. Numbers are not judged here.
    pub fn from_bytes(bytes: &[u8; COMMAND_BYTES]) -> Option<Self> {
        let [tag, a, b, c, ..] = *bytes;
        let words: [u32; 1 + WORDS] = bytemuck::pod_read_unaligned(bytes);
        let [_, first, w2, w3, w4, w5, w6, w7, w8, w9] = words.map(u32::from_le);
        let floats = bytemuck::cast([first, w2, w3, w4]);
        match tag {
            TAG_ARM => Some(Self::Arm),
            TAG_STOP => Some(Self::Stop),
            TAG_CLEAR => Some(Self::Clear),
            TAG_CONFIRM_POSE => Some(Self::ConfirmPose),
            TAG_JOG => Some(Self::Jog(floats)),
            TAG_SET_GAIN => Some(Self::SetGain { name: a, values: floats }),
            TAG_START => Some(Self::Start(Trajectory {
                profile: match a {
                    0 => Profile::Quintic,
                    1 => Profile::HalfSine,
                    _ => return None,
                },
                allow_velocity_step: match b {
                    0 => false,
                    1 => true,
                    _ => return None,
                },
                speed_limit_percent: c,
                duration_ticks: first,
                origin_q6: [w2, w3, w4, w5],
                amplitude_q5: bytemuck::cast([w6, w7, w8, w9]),
            })),
            _ => None,
        }
    }
}

/// Words behind the head.
const WORDS: usize = COMMAND_BYTES / 4 - 1;

fn fill<T>(slots: &mut [T], values: impl IntoIterator<Item = T>) {
    for (slot, value) in slots.iter_mut().zip(values) {
        *slot = value;
    }
}
