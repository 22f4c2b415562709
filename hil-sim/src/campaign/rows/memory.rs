//! Rows 24 and 25: memory.

use shared::fault::Fault;

use super::Ways;
use crate::campaign::pose::Pose;
use crate::campaign::row::{Acting, Drop, Expect, Sign, Variant, fault};
use crate::faults::{Kind, Place, Target};
use crate::pil::Crash;

pub fn flips(_: &Pose) -> Ways {
    let flipped = Sign::Fault(&[Fault::ParameterFlipped]);
    let mut ways = Vec::new();
    for (place, bits) in [
        (Place::Gain, [40.0, 62.0]),
        (Place::Limit, [35.0, 61.0]),
        (Place::Arm, [70.0, 94.0]),
        (Place::Shadow, [200.0, 254.0]),
        (Place::Threshold, [70.0, 1_000.0]),
    ] {
        for bit in bits {
            let flip = vec![fault(Kind::Flip, Target::Place(place)).of(bit)];
            // Thresholds are scrubbed: within 100 ms.
            let (detect, react) = if place == Place::Threshold { (200, 202) } else { (1, 3) };
            let name = format!("{}, bit {bit}", Target::Place(place));
            ways.push(Variant::new(name, flip, Expect::Ss1, flipped, detect, react));
        }
    }
    for bit in [77.0, 3_000.0] {
        let boot = vec![fault(Kind::ConfigFlip, Target::Only).of(bit)];
        let name = format!("configuration at boot, bit {bit}");
        let way = Variant::new(name, boot, Expect::NoConfiguration, Sign::Nothing, 0, 0);
        ways.push(way.dropping(Drop::Zero));
    }
    Ok(ways)
}

pub fn crash(_: &Pose) -> Ways {
    let crash = |name: &str, crash, faults| {
        // 1 ms.
        let way = Variant::new(name, Vec::new(), Expect::Sto, Sign::Fault(faults), 2, 2);
        Variant { crash: Some(crash), ..way }.dropping(Drop::Bound(Acting::Held))
    };
    Ok(vec![
        crash("hard fault", Crash::HardFault, &[Fault::HardFault]),
        crash("stack overflow", Crash::StackOverflow, &[Fault::StackOverflow]),
    ])
}
