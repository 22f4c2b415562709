//! Rows 17 to 19: faults of time.

use shared::fault::{Fault, Limit};

use super::Ways;
use crate::campaign::onset::Condition;
use crate::campaign::pose::Pose;
use crate::campaign::row::{Acting, Drop, Expect, Sign, T, Variant, fault};
use crate::faults::{Injection, Kind, Target};

const LATE: Sign = Sign::Fault(&[Fault::TickLate]);

pub fn late(_: &Pose) -> Ways {
    let late = |ticks| fault(Kind::LateTick, Target::Only).of(ticks);
    let once = Variant::tolerated("one of 1.2 ticks", vec![late(1.2)], Sign::Irregular, 2);
    let thrice = Injection { for_s: Some(4.5 * T), ..late(1.2) };
    let thrice = Variant::new("three of 1.2 ticks", vec![thrice], Expect::Ss1, LATE, 2, 3);
    let long = Variant::new("one of 5 ticks", vec![late(5.0)], Expect::Ss1, LATE, 2, 3);
    Ok(vec![
        Variant { observable: Condition::Late(1), ..once },
        thrice.from(Condition::Late(3)).twin(vec![late(1.2)]),
        long.from(Condition::Late(1)).twin(vec![late(1.2)]),
    ])
}

pub fn watchdog(_: &Pose) -> Ways {
    let hardware = |name: &str, kind| {
        // 10 ms.
        let plain = Variant::new(
            name,
            vec![fault(kind, Target::Only)],
            Expect::Hardware,
            Sign::Chain,
            20,
            20,
        );
        plain.from(Condition::BegunAnyhow).dropping(Drop::Bound(Acting::Held))
    };
    Ok(vec![hardware("hung tick", Kind::Hang), hardware("early kick", Kind::EarlyKick)])
}

pub fn clock(_: &Pose) -> Ways {
    let once = |kind| vec![fault(kind, Target::Only)];
    let counted = |name: &str, kind, from| {
        let plain = Variant::tolerated(name, once(kind), Sign::Irregular, 1);
        Variant { observable: from, ..plain }.dropping(Drop::Zero)
    };
    let wrap =
        Variant::harmless("cycle counter wraps", once(Kind::CounterWrap)).dropping(Drop::Zero);
    let off = |ratio: f64, almost: f64| {
        let clock = |ratio| vec![fault(Kind::ClockOff, Target::Only).of(ratio)];
        let name = format!("clock at {:.0} %", 100.0 * ratio);
        // 200 ms.
        let plain = Variant::tolerated(name, clock(ratio), Sign::Limited(Limit::ClockDrift), 400);
        Variant { by_ticks: true, ..plain }.dropping(Drop::Zero).twin(clock(almost))
    };
    Ok(vec![
        wrap,
        counted("one tick missing", Kind::MissingTick, Condition::Begun),
        counted("one tick doubled", Kind::DoubleTick, Condition::After(1)),
        // The alarm's threshold is 1 %.
        off(1.02, 1.009),
        off(0.98, 0.991),
    ])
}
