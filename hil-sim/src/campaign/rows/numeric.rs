//! Rows 20 and 21: numbers that should not be.

use firmware::config::Gains;
use shared::fault::{Fault, Limit};

use super::Ways;
use crate::campaign::onset::Condition;
use crate::campaign::pose::Pose;
use crate::campaign::row::{Expect, Sign, Variant, fault};
use crate::campaign::trial::Trial;
use crate::faults::{Kind, Target};

pub fn estimates(_: &Pose) -> Ways {
    let mut ways = Vec::new();
    for (j, value) in [(0, 1.0), (1, 1.0), (1, -1.0), (3, 1.0), (1, 50.0)] {
        let driven = value * f64::from(Gains::DEFAULT.d_max[j]);
        let name = format!("joint {}: disturbance set to {value} of its bound", j + 1);
        let driven = vec![fault(Kind::DHat, Target::Joint(j)).of(driven)];
        let way = Variant::new(name, driven, Expect::Ss1OrNone, Sign::Nothing, 0, 100);
        ways.push(way.checked(bounded));
    }
    let payload = vec![fault(Kind::Payload, Target::Only).of(600.0)];
    let sign = Sign::Limited(Limit::Adaptation);
    let learnt = "adaptation driven to its bound by 600 kg";
    let learnt = Variant::new(learnt, payload, Expect::Ss1OrNone, sign, 1, 100);
    ways.push(learnt.from(Condition::AdaptationBound).checked(bounded));
    for (j, severity, what) in
        [(0, 0.0, "speed"), (1, 0.0, "speed"), (1, 1.0, "disturbance"), (3, 1.0, "disturbance")]
    {
        let nan = vec![fault(Kind::NonFinite, Target::Joint(j)).of(severity)];
        let name = format!("joint {}: {what} is no number", j + 1);
        let sign = Sign::Fault(&[Fault::NotFinite]);
        ways.push(Variant::new(name, nan, Expect::Ss1, sign, 1, 1).checked(finite));
    }
    Ok(ways)
}

/// No disturbance estimate leaves its bound.
fn bounded(trial: &Trial, from: usize) -> Option<String> {
    let bounds = Gains::DEFAULT.d_max;
    let within = |d: f32, bound: f32| d.abs() <= bound;
    let mut learnt = trial.frames[from..].iter().map(|f| f.record.d_hat);
    let holds = learnt.all(|d| d.iter().zip(bounds).all(|(d, bound)| within(*d, bound)));
    (!holds).then(|| "a disturbance estimate is beyond its bound".into())
}

/// What a tick reports are numbers.
fn finite(trial: &Trial, from: usize) -> Option<String> {
    let wrong = trial.frames[from..].iter().any(|f| {
        let r = &f.record;
        [r.e1, r.qd, r.e1_dot, r.d_hat].iter().flatten().any(|x| !x.is_finite())
    });
    wrong.then(|| "a record holds what is no number".into())
}

pub fn extremes(pose: &Pose) -> Ways {
    let huge = |j: usize, bit: f64| {
        let flip = vec![fault(Kind::HugeError, Target::Joint(j)).of(bit)];
        let name = format!("joint {}: bit {bit} of the estimated position", j + 1);
        Variant::new(
            name,
            flip,
            Expect::Ss1,
            Sign::Fault(&[Fault::ErrorWindow, Fault::NotFinite]),
            1,
            1,
        )
        .checked(finite)
    };
    let tiny = vec![fault(Kind::DHat, Target::Joint(1)).of(1e-40)];
    let mut ways = vec![
        huge(0, 30.0),
        huge(1, 24.0),
        huge(3, 31.0),
        // A change that no law has made may be told from a learnt one, and stopped.
        Variant::harmless("denormal disturbance", tiny).or_stopped().checked(finite),
    ];
    if !pose.moves() {
        // The tip hangs below the column's axis: slewing hardly moves it, and the inertia about it is least.
        let singular = Pose {
            name: "near-singular".into(),
            q: [0.0, 1.35, -1.31, 4.0],
            qd: [0.05, 0.02, 0.02, 0.02],
            payload_kg: 0.0,
            ..pose.clone()
        };
        let way = Variant::harmless("near-singular pose, in motion", Vec::new()).checked(finite);
        ways.push(Variant { pose: Some(singular), ..way });
    }
    Ok(ways)
}
