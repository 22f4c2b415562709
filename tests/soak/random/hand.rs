//! An operator who mostly knows what to do, and otherwise does anything.

use shared::arm::{JOINTS, REFERENCE};
use shared::command::{Command, Profile, Trajectory};
use shared::fault::Mode;
use shared::telemetry::Record;

use super::dice::Dice;

/// Share of commands without sense.
const SENSELESS: f64 = 0.2;
/// Ticks between two commands of a jog.
const JOG_TICKS: u32 = 60;

/// See the module's documentation.
#[derive(Default)]
pub struct Hand {
    wait: u32,
    /// Speeds of a jog, and its commands left.
    jog: Option<([f32; JOINTS], u32)>,
    /// Set-point when the arm began to hold, position words, and the mode before.
    hold: [u32; JOINTS],
    mode: u8,
}

impl Hand {
    /// The command for the coming tick.
    pub fn command(&mut self, dice: &mut Dice, last: &Record) -> Option<Command> {
        if self.mode != last.mode {
            self.mode = last.mode;
            self.hold = std::array::from_fn(|j| {
                let off = f64::from(last.e1[j]) / REFERENCE.encoders[j].lsb * 64.0;
                (last.code[j] << 6).wrapping_add_signed(-off.round() as i32)
            });
        }
        if self.wait > 0 {
            self.wait -= 1;
            return None;
        }
        if let Some((speeds, left)) = self.jog {
            self.wait = JOG_TICKS;
            self.jog = (left > 0).then(|| (speeds, left - 1));
            return Some(Command::Jog(speeds));
        }
        self.wait = 20 + dice.below(300) as u32;
        if dice.happens(SENSELESS) {
            return Some(self.any(dice));
        }
        match Mode::from_number(last.mode)? {
            Mode::Latched => Some(Command::Clear),
            Mode::Standby => Some(Command::Arm),
            Mode::Boot => Some(Command::ConfirmPose),
            Mode::Holding if dice.happens(0.4) => {
                self.wait = 0;
                self.jog = Some((speeds(dice, 0.05), 2 + dice.below(20) as u32));
                None
            }
            Mode::Holding => Some(Command::Start(self.path(dice))),
            Mode::Moving | Mode::Jogging => dice.happens(0.02).then_some(Command::Stop),
            _ => None,
        }
    }

    fn path(&self, dice: &mut Dice) -> Trajectory {
        let ways = [0.05, 0.05, 0.05, 0.1].map(|most| dice.between(-most, most));
        Trajectory {
            profile: Profile::Quintic,
            allow_velocity_step: false,
            speed_limit_percent: 100,
            duration_ticks: 1_000 + dice.below(5_000) as u32,
            origin_q6: self.hold,
            amplitude_q5: std::array::from_fn(|j| {
                (ways[j] / REFERENCE.encoders[j].lsb * 32.0) as i32
            }),
        }
    }

    fn any(&self, dice: &mut Dice) -> Command {
        let odd = |dice: &mut Dice| {
            dice.of(&[f32::NAN, f32::INFINITY, -1.0, 0.0, 1e-30, 1e9, 30.0, 150.0, 250.0])
        };
        match dice.below(9) {
            0 => Command::Arm,
            1 => Command::Stop,
            2 => Command::Clear,
            3 => Command::ConfirmPose,
            4 => Command::Jog([odd(dice), 0.0, odd(dice), 0.0]),
            5 => Command::Jog(speeds(dice, 2.0)),
            6 => Command::Start(Trajectory {
                duration_ticks: dice.of(&[0, 1, 100, u32::MAX]),
                ..self.path(dice)
            }),
            7 => Command::SetGain { name: dice.below(9) as u8, values: [odd(dice); JOINTS] },
            _ => {
                let value = dice.between(100.0, 220.0) as f32;
                Command::SetGain { name: dice.below(2) as u8, values: [value; JOINTS] }
            }
        }
    }
}

fn speeds(dice: &mut Dice, most: f64) -> [f32; JOINTS] {
    std::array::from_fn(|_| dice.between(-most, most) as f32)
}
