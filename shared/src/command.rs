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
    /// Duration in ticks.
    pub duration_ticks: u32,
    /// Start, in encoder counts with 6 fractional bits, modulo 2³².
    pub origin_q6: [u32; JOINTS],
    /// Amplitude, in encoder counts with 5 fractional bits.
    pub amplitude_q5: [i32; JOINTS],
}

/// What an operator can ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Preload torque, open the brakes and hold the measured pose.
    Arm,
    /// Follow a trajectory from the present set-point.
    Start(Trajectory),
    /// Set the brakes and switch torque off.
    Stop,
}

/// Size of an encoded command.
pub const COMMAND_BYTES: usize = 40;

const TAG_ARM: u8 = 1;
const TAG_START: u8 = 2;
const TAG_STOP: u8 = 3;

impl Command {
    /// Encodes: tag, profile, flags, 0, then duration, origin and amplitude as little-endian words.
    pub fn to_bytes(&self) -> [u8; COMMAND_BYTES] {
        let mut bytes = [0; COMMAND_BYTES];
        match self {
            Self::Arm => bytes[0] = TAG_ARM,
            Self::Stop => bytes[0] = TAG_STOP,
            Self::Start(trajectory) => {
                bytes[0] = TAG_START;
                bytes[1] = trajectory.profile as u8;
                bytes[2] = u8::from(trajectory.allow_velocity_step);
                let origin = trajectory.origin_q6;
                let amplitude = trajectory.amplitude_q5.map(|a| a as u32);
                let words = [trajectory.duration_ticks].into_iter().chain(origin).chain(amplitude);
                for (slot, word) in bytes[4..].chunks_exact_mut(4).zip(words) {
                    slot.copy_from_slice(&word.to_le_bytes());
                }
            }
        }
        bytes
    }

    /// Decodes; `None` where tag, profile or flags are unknown.
    pub fn from_bytes(bytes: &[u8; COMMAND_BYTES]) -> Option<Self> {
        match bytes[0] {
            TAG_ARM => Some(Self::Arm),
            TAG_STOP => Some(Self::Stop),
            TAG_START => Some(Self::Start(Trajectory {
                profile: match bytes[1] {
                    0 => Profile::Quintic,
                    1 => Profile::HalfSine,
                    _ => return None,
                },
                allow_velocity_step: match bytes[2] {
                    0 => false,
                    1 => true,
                    _ => return None,
                },
                duration_ticks: word(bytes, 1),
                origin_q6: [word(bytes, 2), word(bytes, 3), word(bytes, 4), word(bytes, 5)],
                amplitude_q5: [6, 7, 8, 9].map(|i| word(bytes, i) as i32),
            })),
            _ => None,
        }
    }
}

fn word(bytes: &[u8; COMMAND_BYTES], index: usize) -> u32 {
    let at = 4 * index;
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}
