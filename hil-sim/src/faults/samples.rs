//! Faults of what an encoder's head measures.

use std::collections::VecDeque;

use rand_distr::{Distribution, Uniform};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;
use shared::arm::{Arm, JOINTS};

use super::{Injection, Kind};

/// What one head remembers.
#[derive(Clone, Debug, Default)]
struct Past {
    /// Code at which it stands still.
    frozen: Option<u32>,
    /// Codes of the last ticks, newest last.
    codes: VecDeque<u32>,
    /// The last code was an old one.
    was_old: bool,
}

/// One injection that spoils samples.
#[derive(Clone, Debug)]
pub(super) struct SampleFault {
    injection: Injection,
    arm: Arm,
    generator: Xoshiro256PlusPlus,
    past: [Past; JOINTS],
}

impl SampleFault {
    /// `None` where the injection is of another sort.
    pub fn new(injection: &Injection, arm: &Arm, seed: u64) -> Option<Self> {
        use Kind::{HalfRate, Jump, LateSamples, SampleJitter, StuckEncoder, Zeros};
        let of_samples = matches!(
            injection.kind,
            HalfRate | Jump | LateSamples | SampleJitter | StuckEncoder | Zeros
        );
        of_samples.then(|| Self {
            injection: *injection,
            arm: *arm,
            generator: Xoshiro256PlusPlus::seed_from_u64(seed),
            past: Default::default(),
        })
    }

    /// How much later than it should the head of joint `j` latches, s.
    pub fn latch_shift_s(&mut self, j: usize) -> f64 {
        let Injection { kind, target, severity, .. } = self.injection;
        if kind == Kind::SampleJitter && target.hits_joint(j) {
            self.between(-severity, severity)
        } else {
            0.0
        }
    }

    /// Sees the code of joint `j` while the fault is not there.
    pub fn keep(&mut self, j: usize, code: u32) {
        let past = &mut self.past[j];
        past.frozen = None;
        if matches!(self.injection.kind, Kind::LateSamples | Kind::HalfRate) {
            past.codes.push_back(code);
            if past.codes.len() > 1 + self.injection.severity as usize {
                past.codes.pop_front();
            }
        }
    }

    /// The code that the head of joint `j` gives in place of `code`.
    pub fn code(&mut self, j: usize, code: u32) -> u32 {
        let Injection { kind, target, severity, .. } = self.injection;
        if !target.hits_joint(j) {
            return code;
        }
        let spoilt = match kind {
            Kind::StuckEncoder => {
                let dither = self.between(-1.5, 1.5).round() as i32;
                self.past[j].frozen.get_or_insert(code).wrapping_add_signed(dither)
            }
            Kind::Jump => {
                let counts = (severity / self.arm.encoders[j].lsb).round() as i64;
                code.wrapping_add(counts as u32)
            }
            Kind::LateSamples => self.old(j, code),
            Kind::HalfRate => self.every_other(j, code),
            Kind::Zeros => 0,
            _ => code,
        };
        spoilt & u32::MAX >> (32 - self.arm.encoders[j].bits)
    }

    fn between(&mut self, lo: f64, hi: f64) -> f64 {
        Uniform::new_inclusive(lo, hi).map_or(lo, |numbers| numbers.sample(&mut self.generator))
    }

    /// The oldest code kept, or the first of all.
    fn old(&mut self, j: usize, code: u32) -> u32 {
        self.keep(j, code);
        self.past[j].codes.front().copied().unwrap_or(code)
    }

    fn every_other(&mut self, j: usize, code: u32) -> u32 {
        let past = &mut self.past[j];
        past.was_old = !past.was_old;
        match past.codes.back() {
            Some(&before) if past.was_old => before,
            _ => {
                self.keep(j, code);
                code
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use shared::arm::REFERENCE;

    use super::super::Target;
    use super::*;

    fn fault(kind: Kind, severity: f64) -> SampleFault {
        let injection = Injection { severity, ..Injection::new(kind, Target::Encoder(1), 0.0) };
        SampleFault::new(&injection, &REFERENCE, 1).expect("a fault of samples")
    }

    /// Codes 100, 200 and so on, three of them before the fault.
    fn codes(mut fault: SampleFault) -> Vec<u32> {
        (1..=3).for_each(|i| fault.keep(1, 100 * i));
        (4..=8).map(|i| fault.code(1, 100 * i)).collect()
    }

    #[test]
    fn stuck_code_stays_within_one_count() {
        let codes = codes(fault(Kind::StuckEncoder, 0.0));
        assert!(codes.iter().all(|code| code.abs_diff(400) <= 1), "{codes:?}");
        assert!(codes.iter().any(|code| *code != codes[0]), "{codes:?}");
    }

    #[test]
    fn late_codes_are_as_old_as_asked_for() {
        assert_eq!(codes(fault(Kind::LateSamples, 1.0)), [300, 400, 500, 600, 700]);
        assert_eq!(codes(fault(Kind::LateSamples, 2.0)), [200, 300, 400, 500, 600]);
        assert_eq!(codes(fault(Kind::LateSamples, 50.0)), [100; 5]);
    }

    #[test]
    fn half_rate_repeats_every_other_code() {
        assert_eq!(codes(fault(Kind::HalfRate, 0.0)), [300, 500, 500, 700, 700]);
    }

    #[test]
    fn jump_is_rounded_to_counts_and_wraps_in_the_word() {
        let lsb = REFERENCE.encoders[1].lsb;
        assert_eq!(codes(fault(Kind::Jump, 10.2 * lsb))[0], 410);
        assert_eq!(fault(Kind::Jump, -10.0 * lsb).code(1, 3), (1 << 26) - 7);
    }

    #[test]
    fn jitter_goes_both_ways_within_its_width_and_repeats_with_its_seed() {
        let shifts = |mut fault: SampleFault| (0..100).map(move |_| fault.latch_shift_s(1));
        let jitter = fault(Kind::SampleJitter, 1e-5);
        let drawn = shifts(jitter.clone()).collect::<Vec<_>>();
        assert!(drawn.iter().all(|s| s.abs() <= 1e-5));
        assert!(drawn.iter().any(|s| *s < -5e-6) && drawn.iter().any(|s| *s > 5e-6));
        assert_eq!(drawn, shifts(jitter).collect::<Vec<_>>());
    }

    #[test]
    fn other_joints_are_left_alone() {
        for kind in [Kind::StuckEncoder, Kind::Jump, Kind::Zeros, Kind::LateSamples] {
            assert_eq!(fault(kind, 1.0).code(0, 77), 77, "{kind}");
        }
        assert_eq!(fault(Kind::SampleJitter, 1e-5).latch_shift_s(0), 0.0);
    }
}
