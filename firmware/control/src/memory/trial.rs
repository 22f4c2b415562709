//! Which of two copies that differ is right, told by the check sum that both should have.

use core::mem::offset_of;

use bytemuck::must_cast_slice;
use shared::crc32::continued;

use super::{Coefficients, Memory, words_mut};
use crate::monitor::Thresholds;

/// What the check of the parameters says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Health {
    /// Both copies agree.
    Good,
    /// They differ, and it is not known yet which is right.
    Unknown,
    /// They differed; the good one has been restored.
    Restored,
    /// Neither is good.
    Lost,
}

/// Sums up the live copy piece by piece, and if that is damaged the shadow.
#[derive(Clone, Copy, Debug)]
struct Trial {
    /// Words that have been summed up, and their CRC.
    summed: usize,
    crc: u32,
    /// The live copy is damaged.
    live_is_bad: bool,
    /// So is the shadow. Nothing mends that.
    lost: bool,
}

impl Trial {
    const NONE: Self = Self { summed: 0, crc: 0, live_is_bad: false, lost: false };

    fn is_under_way(&self) -> bool {
        self.summed != 0 || self.live_is_bad || self.lost
    }

    /// One piece of so many words on.
    #[inline(never)]
    fn step(&mut self, live: &mut [u32], shadow: &mut [u32], crc: u32, piece: usize) -> Health {
        if self.lost {
            return Health::Lost;
        }
        let copy = if self.live_is_bad { &*shadow } else { &*live };
        let rest = copy.get(self.summed..).unwrap_or_default();
        let next = rest.get(..piece).unwrap_or(rest);
        self.crc = continued(self.crc, must_cast_slice(next));
        self.summed += piece;
        if next.len() < rest.len() {
            return Health::Unknown;
        }
        let Self { crc: found, live_is_bad, .. } = *self;
        *self = Self::NONE;
        let good = found == crc;
        self.live_is_bad = !good && !live_is_bad;
        match (good, live_is_bad) {
            (true, false) => overwrite(shadow, live),
            (true, true) => overwrite(live, shadow),
            (false, false) => return Health::Unknown,
            (false, true) => {
                self.lost = true;
                return Health::Lost;
            }
        }
        Health::Restored
    }
}

fn overwrite(bad: &mut [u32], good: &[u32]) {
    for (bad, good) in bad.iter_mut().zip(good) {
        *bad = *good;
    }
}

/// Words of the coefficients summed up in a tick, which then takes no sample and computes no law: it costs no more than
/// one that does.
const COEFFICIENTS_PIECE: usize = 25;

/// Search for the good copy of the coefficients, which no tick uses before.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    trial: Trial,
    begun: bool,
    /// It is the law's part that differs.
    in_law: bool,
}

impl Search {
    /// Not begun.
    pub const NONE: Self = Self { trial: Trial::NONE, begun: false, in_law: false };

    /// One tick's work. The first only sees which part differs; a damage then takes two ticks, or four if it is in
    /// the live copy's arm.
    #[cold]
    #[inline(never)]
    pub fn step(&mut self, memory: &mut Memory) -> Health {
        const LAW: usize = offset_of!(Coefficients, law) / 4;
        let live = words_mut::<_, { size_of::<Coefficients>() / 4 }>(&mut memory.coefficients);
        let shadow = words_mut::<_, { size_of::<Coefficients>() / 4 }>(&mut memory.shadow);
        let (live, live_law) = live.split_at_mut(LAW);
        let (shadow, shadow_law) = shadow.split_at_mut(LAW);
        if !self.begun {
            self.begun = true;
            self.in_law = live_law.iter().zip(&*shadow_law).any(|(a, b)| a != b);
            return Health::Unknown;
        }
        let health = if self.in_law {
            self.trial.step(live_law, shadow_law, memory.crc_law, COEFFICIENTS_PIECE)
        } else {
            self.trial.step(live, shadow, memory.crc_fixed, COEFFICIENTS_PIECE)
        };
        self.begun = matches!(health, Health::Unknown | Health::Lost);
        health
    }
}

/// Compares the two copies of the thresholds, two words a tick: at 1 kHz a round takes less than 100 ms. Where they
/// differ, a trial goes on while they are used.
#[derive(Clone, Copy, Debug)]
pub struct Scrub {
    /// Two words.
    pair: usize,
    trial: Trial,
}

const PAIRS: usize = size_of::<Thresholds>() / 8;
const _: () = assert!(PAIRS < 99, "a round must end within 100 ms at 1 kHz");
/// Words of the thresholds summed up in a tick.
const THRESHOLDS_PIECE: usize = 4;

impl Scrub {
    /// At the start of a round.
    pub const NONE: Self = Self { pair: 0, trial: Trial::NONE };

    /// Two words on; what is known of the two copies.
    #[inline(always)]
    pub fn step(&mut self, memory: &mut Memory) -> Health {
        let live: &[[u32; 2]; PAIRS] = bytemuck::cast_ref(&memory.thresholds);
        let shadow: &[[u32; 2]; PAIRS] = bytemuck::cast_ref(&memory.shadow_thresholds);
        let pair = self.pair;
        self.pair = if pair + 1 < PAIRS { pair + 1 } else { 0 };
        if live.get(pair) == shadow.get(pair) && !self.trial.is_under_way() {
            Health::Good
        } else {
            self.judge(memory)
        }
    }

    #[cold]
    #[inline(never)]
    fn judge(&mut self, memory: &mut Memory) -> Health {
        let crc = memory.crc_thresholds;
        let live = words_mut::<_, { 2 * PAIRS }>(&mut memory.thresholds);
        let shadow = words_mut::<_, { 2 * PAIRS }>(&mut memory.shadow_thresholds);
        let health = self.trial.step(live, shadow, crc, THRESHOLDS_PIECE);
        if self.trial.live_is_bad && self.trial.summed == 0 {
            // Not used any longer; whether the other is right is yet to be seen.
            overwrite(live, shadow);
        }
        health
    }
}
