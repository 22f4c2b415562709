//! Faults of numbers and memory, as pokes into the controller's image.

use std::ops::Range;

use firmware::config::Config;
use firmware::memory::Memory;
use shared::pil::Poke;

use super::{Injection, Kind, Target};

/// What the injection does to the controller's memory in one tick, if that is where it is.
pub(super) fn poke(injection: &Injection) -> Option<Poke> {
    let Injection { kind, target, severity, .. } = *injection;
    match (kind, target) {
        (Kind::NonFinite, Target::Joint(j)) if severity == 0.0 => {
            Some(set(&Memory::velocity(j), f32::NAN))
        }
        (Kind::NonFinite, Target::Joint(j)) => Some(set(&d_hat(j), f32::NAN)),
        (Kind::DHat, Target::Joint(j)) => Some(set(&d_hat(j), severity as f32)),
        (Kind::HugeError, Target::Joint(j)) => Some(flip(&Memory::position(j), severity as usize)),
        (Kind::Flip, Target::Place(place)) => Some(flip(&place.bytes(), severity as usize)),
        _ => None,
    }
}

/// The configuration with the bits flipped that the injections of this kind name.
pub fn flip_configuration(config: &mut Config, injections: &[Injection]) {
    let bytes = bytemuck::bytes_of_mut(config);
    for injection in injections.iter().filter(|one| one.kind == Kind::ConfigFlip) {
        let bit = injection.severity as usize;
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
}

fn d_hat(j: usize) -> Range<usize> {
    let start = Memory::D_HAT.start + 4 * j;
    start..start + 4
}

fn set(word: &Range<usize>, value: f32) -> Poke {
    Poke::set(word.start, value.to_bits())
}

fn flip(stretch: &Range<usize>, bit: usize) -> Poke {
    Poke::flip(stretch.start + 4 * (bit / 32), 1 << (bit % 32))
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;
    use shared::arm::REFERENCE;

    use super::super::Place;
    use super::*;

    fn poked(kind: Kind, target: Target, severity: f64) -> Memory {
        let mut memory = Memory::zeroed();
        memory.set(&Config::for_arm(&REFERENCE, 2_000));
        if let Some(poke) = poke(&Injection { severity, ..Injection::new(kind, target, 0.0) }) {
            poke.apply(memory.as_words_mut());
        }
        memory
    }

    #[test]
    fn estimates_are_overwritten_where_they_are() {
        let memory = poked(Kind::NonFinite, Target::Joint(2), 0.0);
        assert_eq!(
            memory.estimates.observers.map(|o| o.velocity.is_nan()),
            [false, false, true, false]
        );
        let memory = poked(Kind::NonFinite, Target::Joint(3), 1.0);
        assert!(memory.estimates.d_hat[3].is_nan() && memory.estimates.d_hat[2] == 0.0);
        let memory = poked(Kind::DHat, Target::Joint(1), -5e5);
        assert_eq!(memory.estimates.d_hat[1], -5e5);
        let memory = poked(Kind::HugeError, Target::Joint(0), 30.0);
        assert_eq!(memory.estimates.observers.map(|o| o.position), [1 << 30, 0, 0, 0]);
    }

    #[test]
    fn every_bit_of_every_place_makes_the_copies_differ() {
        for place in [Place::Gain, Place::Limit, Place::Arm, Place::Shadow] {
            let bits = 8 * place.bytes().len();
            for bit in [0, 31, 32, bits - 1] {
                let memory = poked(Kind::Flip, Target::Place(place), bit as f64);
                assert!(!memory.agrees(), "{place:?} {bit}");
            }
        }
        let memory = poked(Kind::Flip, Target::Place(Place::Threshold), 33.0);
        let untouched = poked(Kind::Hang, Target::Only, 0.0);
        let [flipped, right] = [memory, untouched].map(|m| m.thresholds.encoder.tight[1]);
        assert_eq!(flipped ^ right, 2);
    }

    #[test]
    fn flipped_configuration_no_longer_fits_its_check_sum() {
        let mut config = Config::for_arm(&REFERENCE, 2_000);
        let crc = config.crc();
        let bit =
            Injection { severity: 77.0, ..Injection::new(Kind::ConfigFlip, Target::Only, 0.0) };
        flip_configuration(&mut config, &[bit]);
        assert!(config.check(crc).is_err());
        flip_configuration(&mut config, &[bit]);
        assert_eq!(config.crc(), crc);
    }
}
