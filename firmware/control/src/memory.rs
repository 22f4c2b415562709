//! Parameters with a shadow copy and check sums, and the estimates: what a flipped bit would turn into motion.
//!
//! The tick compares the coefficients with their shadow word by word before it uses them. Where they differ,
//! a CRC-32 says which copy is right; that takes up to two ticks, in which the drives keep their torque.
//! The thresholds are compared two words a tick, and summed up over some ticks where they differ.

mod places;

use core::mem::{offset_of, size_of};

use bytemuck::{Pod, Zeroable};
use shared::arm::JOINTS;
use shared::crc32::{continued, crc32};

use crate::JointVector;
use crate::config::Config;
use crate::dynamics;
use crate::estimator::{self, Observer};
use crate::law;
use crate::monitor::Thresholds;

/// Gains, limits and arm parameters as a tick uses them.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Coefficients {
    /// Observers.
    pub observer: estimator::Gains,
    /// Encoders.
    pub scales: [estimator::Scale; JOINTS],
    /// The arm.
    pub dynamics: dynamics::Constants,
    /// Highest torque commands, N m and N.
    pub tau_max: JointVector,
    /// DAC codes per N m and N.
    pub codes_per_torque: JointVector,
    /// The law: the only part that an order changes, and therefore last.
    pub law: law::Coefficients,
}

/// Words that a tick compares at once: enough to keep a loop's own cost small.
const ROW: usize = 6;

/// Codes from DAC mid-scale to full scale.
const DAC_HALF_SCALE: f32 = 32_768.0;

impl Coefficients {
    /// Filled group by group, so that a small stack is enough.
    #[inline(never)]
    fn set(&mut self, config: &Config) {
        let tick_hz = config.tick_hz as f32;
        let gains = &config.gains;
        self.dynamics.collect(&config.arm, &config.arm.payload);
        self.law = law::Coefficients::new(gains, tick_hz);
        self.observer = estimator::Gains::new(gains.observer_rad_s, tick_hz);
        for (j, joint) in config.joints.iter().enumerate() {
            self.scales[j] = estimator::Scale::new(joint, tick_hz);
            self.tau_max[j] = joint.tau_max;
            self.codes_per_torque[j] = DAC_HALF_SCALE / joint.drive_full_scale;
        }
    }

    fn rows(&self) -> &[[u32; ROW]; size_of::<Self>() / 4 / ROW] {
        bytemuck::cast_ref(self)
    }

    /// What no order changes, as bytes.
    fn fixed(&self) -> &[u8] {
        bytemuck::bytes_of(self).get(..offset_of!(Self, law)).unwrap_or_default()
    }
}

/// A law's coefficients with their check sum, computed outside the tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gained {
    /// The coefficients.
    pub law: law::Coefficients,
    crc: u32,
}

impl Gained {
    /// With the check sum of `law`.
    pub fn new(law: &law::Coefficients) -> Self {
        Self { law: *law, crc: crc32(bytemuck::bytes_of(law)) }
    }
}

/// What the controller believes of the arm's state.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Estimates {
    /// Position and speed of each joint.
    pub observers: [Observer; JOINTS],
    /// Disturbance, N m and N.
    pub d_hat: JointVector,
    /// Its words, exclusive-ored.
    parity: u32,
}

impl Estimates {
    /// Whether the disturbance estimate is what was last set.
    #[inline(always)]
    pub fn is_sound(&self) -> bool {
        parity(&self.d_hat) == self.parity
    }

    /// Sets the disturbance estimate.
    #[inline(always)]
    pub fn set_d_hat(&mut self, d_hat: JointVector) {
        self.d_hat = d_hat;
        self.parity = parity(&d_hat);
    }
}

#[inline(always)]
fn parity(d: &JointVector) -> u32 {
    d.x.to_bits() ^ d.y.to_bits() ^ d.z.to_bits() ^ d.w.to_bits()
}

/// See the module's documentation. What a tick uses comes first: loads of floats do not reach far.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Memory {
    /// State of the estimator.
    pub estimates: Estimates,
    /// Compared at every tick.
    pub coefficients: Coefficients,
    shadow: Coefficients,
    /// Compared in turn.
    pub thresholds: Thresholds,
    shadow_thresholds: Thresholds,
    crc_fixed: u32,
    crc_law: u32,
    crc_thresholds: u32,
}

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

/// How far the search for the good copy has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Search {
    /// The live copy's fixed part was found damaged.
    live_is_bad: bool,
}

impl Search {
    /// Not begun.
    pub const NONE: Self = Self { live_is_bad: false };
}

impl Memory {
    /// Takes a configuration.
    #[inline(never)]
    pub fn set(&mut self, config: &Config) {
        self.coefficients.set(config);
        self.thresholds.set(config);
        self.crc_fixed = crc32(self.coefficients.fixed());
        self.crc_law = crc32(bytemuck::bytes_of(&self.coefficients.law));
        self.crc_thresholds = crc32(bytemuck::bytes_of(&self.thresholds));
        self.shadow = self.coefficients;
        self.shadow_thresholds = self.thresholds;
    }

    /// Takes new gains, in both copies.
    pub fn gain(&mut self, gained: &Gained) {
        self.coefficients.law = gained.law;
        self.shadow.law = gained.law;
        self.crc_law = gained.crc;
    }

    /// Whether both copies of the coefficients hold the same words.
    #[inline(never)]
    pub fn agrees(&self) -> bool {
        let rows = self.coefficients.rows().iter().zip(self.shadow.rows());
        let differing = rows.fold(0, |all, (a, b)| {
            let [a0, a1, a2, a3, a4, a5] = *a;
            let [b0, b1, b2, b3, b4, b5] = *b;
            all | (a0 ^ b0) | (a1 ^ b1) | (a2 ^ b2) | (a3 ^ b3) | (a4 ^ b4) | (a5 ^ b5)
        });
        differing == 0
    }

    /// One tick's work towards the good copy, where the two differ: one check sum of the fixed part, or both
    /// of the law. A single damage takes two ticks at most.
    #[cold]
    #[inline(never)]
    pub fn search(&mut self, search: &mut Search) -> Health {
        let (live, shadow) = (&mut self.coefficients, &mut self.shadow);
        if bytemuck::bytes_of(&live.law) != bytemuck::bytes_of(&shadow.law) {
            let good = |c: &Coefficients| crc32(bytemuck::bytes_of(&c.law)) == self.crc_law;
            match (good(live), good(shadow)) {
                (true, _) => shadow.law = live.law,
                (_, true) => live.law = shadow.law,
                _ => return Health::Lost,
            }
        } else if search.live_is_bad {
            if crc32(shadow.fixed()) != self.crc_fixed {
                return Health::Lost;
            }
            *live = *shadow;
        } else if crc32(live.fixed()) == self.crc_fixed {
            *shadow = *live;
        } else {
            search.live_is_bad = true;
            return Health::Unknown;
        }
        *search = Search::NONE;
        if self.agrees() { Health::Restored } else { Health::Unknown }
    }

    /// Everything in words, for whoever injects faults.
    pub fn as_words_mut(&mut self) -> &mut [u32] {
        let words: &mut [u32; size_of::<Self>() / 4] = bytemuck::cast_mut(self);
        words
    }
}

/// Compares the two copies of the thresholds, two words a tick: at 1 kHz a round takes less than 100 ms. Where they
/// differ, the live one is summed up piece by piece to see which is right.
#[derive(Clone, Copy, Debug)]
pub struct Scrub {
    /// Two words.
    pair: usize,
    /// Bytes of the live copy that a trial has summed up, and their CRC so far; none is under way at 0.
    summed: usize,
    crc: u32,
    /// The shadow has taken the live copy's place already.
    last: bool,
}

const PAIRS: usize = size_of::<Thresholds>() / 8;
const _: () = assert!(PAIRS < 99, "a round must end within 100 ms at 1 kHz");
/// Bytes summed up in a tick.
const PIECE: usize = 16;

impl Scrub {
    /// At the start of a round.
    pub const NONE: Self = Self { pair: 0, summed: 0, crc: 0, last: false };

    /// Two words on; what is known of the two copies.
    #[inline(always)]
    pub fn step(&mut self, memory: &mut Memory) -> Health {
        let live: &[[u32; 2]; PAIRS] = bytemuck::cast_ref(&memory.thresholds);
        let shadow: &[[u32; 2]; PAIRS] = bytemuck::cast_ref(&memory.shadow_thresholds);
        let pair = self.pair;
        self.pair = if pair + 1 < PAIRS { pair + 1 } else { 0 };
        if live.get(pair) == shadow.get(pair) && self.summed == 0 {
            Health::Good
        } else {
            self.judge(memory)
        }
    }

    /// One piece of a trial on.
    #[cold]
    #[inline(never)]
    fn judge(&mut self, memory: &mut Memory) -> Health {
        let bytes = bytemuck::bytes_of(&memory.thresholds);
        let rest = bytes.get(self.summed..).unwrap_or_default();
        if !rest.is_empty() {
            self.crc = continued(self.crc, rest.get(..PIECE).unwrap_or(rest));
            self.summed += PIECE;
            return Health::Unknown;
        }
        let (good, last) = (self.crc == memory.crc_thresholds, self.last);
        (self.summed, self.crc, self.last) = (0, 0, false);
        if good {
            memory.shadow_thresholds = memory.thresholds;
            return Health::Restored;
        }
        if last {
            return Health::Lost;
        }
        // Where the shadow is damaged too, the next trial tells.
        memory.thresholds = memory.shadow_thresholds;
        self.crc =
            continued(0, bytemuck::bytes_of(&memory.thresholds).get(..PIECE).unwrap_or_default());
        (self.summed, self.last) = (PIECE, true);
        Health::Unknown
    }
}
