//! Random faults of a run.

use hil_sim::faults::{Injection, Kind, SPECS, Target};
use hil_sim::scenario::Scenario;

use super::dice::Dice;

/// Times of the faults after the path's start, s.
pub const FROM_S: f64 = 0.5;
pub const UNTIL_S: f64 = 100.0;
/// From one fault to the next, s: time to stop, clear, arm and move.
const EVERY_S: (f64, f64) = (1.0, 3.0);
/// Share of faults that another one goes with.
const PAIRS: f64 = 0.2;

/// The paper's lift with faults, whose last one the hardware has to meet.
pub fn scenario(dice: &mut Dice, seed: u64) -> Scenario {
    let mut scenario = Scenario::load("paper").expect("a shipped scenario");
    scenario.seed = seed;
    let mut at_s = FROM_S;
    while at_s < UNTIL_S {
        let fault = any(dice, at_s);
        scenario.faults.push(fault);
        if matches!(fault.kind, Kind::WireBroken | Kind::ContactsDiffer) {
            // Contacts that disagreed are trusted again once the button has been tried.
            let at_s = at_s + fault.for_s.unwrap_or(0.0) + 0.1;
            let tried = Injection::new(Kind::EStop, Target::Only, at_s);
            scenario.faults.push(Injection { for_s: Some(0.1), ..tried });
        }
        if dice.happens(PAIRS) {
            let later_s = dice.between(0.0, 0.05);
            scenario.faults.push(any(dice, at_s + later_s));
        }
        at_s += dice.between(EVERY_S.0, EVERY_S.1);
    }
    // A watchdog that has tripped stays so.
    let kind = dice.of(&[Kind::Hang, Kind::EarlyKick, Kind::WarningBit]);
    scenario.faults.push(of(kind, dice, UNTIL_S));
    scenario
}

/// A fault of any kind but those that end every run, and that which lets none begin.
fn any(dice: &mut Dice, at_s: f64) -> Injection {
    loop {
        let kind = SPECS[dice.below(SPECS.len())].kind;
        // A brake that slips locks the arm out: at most one, and late.
        let late = at_s > 0.8 * UNTIL_S;
        match kind {
            Kind::Hang | Kind::EarlyKick | Kind::ConfigFlip => {}
            Kind::BrakeSlip if !late => {}
            _ => return of(kind, dice, at_s),
        }
    }
}

fn of(kind: Kind, dice: &mut Dice, at_s: f64) -> Injection {
    let target = dice.of(kind.spec().targets);
    let plain = Injection::new(kind, target, at_s);
    let for_s = (kind.spec().span == hil_sim::faults::Span::Lasting || kind == Kind::Jump)
        .then(|| dice.between(0.02, 0.8));
    Injection { for_s, severity: severity(&plain, dice), ..plain }
}

/// A severity that is worth it.
fn severity(plain: &Injection, dice: &mut Dice) -> f64 {
    match plain.kind {
        Kind::BitFlips => dice.of(&[1.0, 2.0]),
        Kind::Burst => dice.of(&[1.0, 3.0, 6.0]),
        Kind::FrameLoss => dice.of(&[0.01, 0.1, 0.3, 1.0, 1.0]),
        Kind::Swap => {
            let own = plain.target.joints().next().unwrap_or(0);
            ((own + 1 + dice.below(3)) % 4 + 1) as f64
        }
        Kind::Dead => dice.below(3) as f64,
        Kind::TorqueDrift => dice.between(5e3, 5e4) * dice.of(&[-1.0, 1.0]),
        Kind::TorqueStuck => dice.of(&[-1.0, 1.0]),
        Kind::LateSamples => (1 + dice.below(10)) as f64,
        Kind::SampleJitter => dice.between(0.0, 2e-5),
        Kind::TorqueLimit => dice.between(0.0, 1.0),
        Kind::BrakeJammed | Kind::BrakeNoFeedback | Kind::NonFinite => dice.below(2) as f64,
        Kind::Payload => dice.between(-300.0, 300.0),
        // Later than that is the watchdog's.
        Kind::LateTick => dice.of(&[1.2, 1.5, 5.0, 10.0]),
        Kind::ClockOff => dice.between(0.97, 1.03),
        Kind::OverBudget => dice.between(0.1, 2.0),
        Kind::HugeError => (26 + dice.below(6)) as f64,
        Kind::DHat => dice.between(-1e5, 1e5),
        Kind::Flip => {
            let bits = plain.kind.severity(plain.target).map_or(0.0, |s| s.bounds.hi);
            dice.below(bits as usize + 1) as f64
        }
        _ => plain.severity,
    }
}
