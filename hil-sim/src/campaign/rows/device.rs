//! Rows 26 and 27: the operator's stop, and devices that reset.

use shared::fault::Fault;

use super::Ways;
use crate::campaign::onset::Condition;
use crate::campaign::pose::Pose;
use crate::campaign::row::{Acting, Drop, Expect, POWER_UP, Sign, Variant, fault};
use crate::campaign::trial::{TICK_S, Trial};
use crate::faults::{Injection, Kind, Target};

const PRESSED: Sign = Sign::Fault(&[Fault::EmergencyStop, Fault::EmergencyStopContacts]);

pub fn emergency_stop(pose: &Pose) -> Ways {
    let stop = |name: &str, injection: Injection| {
        Variant::new(name, vec![injection], Expect::Ss1, PRESSED, 1, 2).checked(opened)
    };
    let pressed = fault(Kind::EStop, Target::Only);
    let mut ways = vec![
        stop("pressed", pressed),
        stop("pressed for 0.8 s", Injection { for_s: Some(0.8), ..pressed }),
        stop("wire 1 broken", fault(Kind::WireBroken, Target::Contact(0))),
        stop("wire 2 broken", fault(Kind::WireBroken, Target::Contact(1))),
        stop("contacts disagree", fault(Kind::ContactsDiffer, Target::Contact(0))),
    ];
    let boot = fault(Kind::ContactsDiffer, Target::Contact(1)).at(POWER_UP);
    let boot = Variant::new(
        "contacts disagree from power-up",
        vec![boot],
        Expect::NoArm,
        Sign::Nothing,
        0,
        0,
    );
    ways.extend(super::parked(pose, vec![boot]).unwrap_or_default());
    Ok(ways)
}

/// The hardware takes torque 500 ms after the press.
fn opened(trial: &Trial, from: usize) -> Option<String> {
    let open = trial.frames[from..].iter().position(|f| !f.chain_closed);
    let after_s = open.map(|steps| steps as f64 * TICK_S);
    match after_s {
        Some(s) if (0.49..=0.51).contains(&s) => None,
        Some(s) => Some(format!("the hardware's chain opened after {s:.3} s")),
        None => Some("the hardware's chain stayed closed".into()),
    }
}

pub fn resets(_: &Pose) -> Ways {
    let adc = vec![fault(Kind::AdcReset, Target::Only)];
    let adc_told = Sign::Fault(&[Fault::AdcReset, Fault::AdcConfiguration]);
    let dac = vec![fault(Kind::DacReset, Target::Only)];
    let dac_told = Sign::Fault(&[Fault::DacReset, Fault::DacNotAcknowledged]);
    let dac = Variant::new("DAC", dac, Expect::Sto, dac_told, 2, 3);
    Ok(vec![
        // 100 ms, and three ticks.
        Variant::new("ADC", adc, Expect::Ss1, adc_told, 200, 203),
        dac.from(Condition::Begun).dropping(Drop::Bound(Acting::Limp)),
    ])
}
