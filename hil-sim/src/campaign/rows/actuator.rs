//! Rows 12 to 15: faults of drives and brakes.

use firmware::config::Safety;
use shared::arm::{JOINTS, REFERENCE};
use shared::command::Command;
use shared::fault::{Fault, Mode};

use super::Ways;
use crate::campaign::measure;
use crate::campaign::onset::Condition;
use crate::campaign::pose::{PATH_S, Pose};
use crate::campaign::row::{Acting, Drop, Expect, POWER_UP, Sign, Variant, fault};
use crate::campaign::trial::{Ask, Order, Trial};
use crate::faults::{Injection, Kind, Target};
use crate::plant::Model;

pub fn enable_lost(_: &Pose) -> Ways {
    let ways = (0..JOINTS).map(|j| {
        let lost = vec![fault(Kind::EnableLost, Target::Joint(j))];
        let sign = Sign::Fault(&[Fault::DriveLost]);
        // 5 and 6 ms.
        let plain =
            Variant::new(format!("joint {}", j + 1), lost, Expect::Isolate(j), sign, 10, 12);
        plain.from(Condition::TorqueWrong(j)).dropping(Drop::Bound(Acting::Isolated(j)))
    });
    Ok(ways.collect())
}

pub fn wrong_torque(_: &Pose) -> Ways {
    let mut ways = Vec::new();
    for j in 0..JOINTS {
        let target = Target::Joint(j);
        for (name, injection, acting) in [
            (
                "stuck at its maximum",
                fault(Kind::TorqueStuck, target).of(1.0),
                Acting::Stuck(j, 1.0),
            ),
            (
                "stuck at its minimum",
                fault(Kind::TorqueStuck, target).of(-1.0),
                Acting::Stuck(j, -1.0),
            ),
            ("inverted", fault(Kind::TorqueInverted, target), Acting::Inverted(j)),
        ] {
            let name = format!("joint {}: {name}", j + 1);
            let sign = Sign::Fault(&[Fault::TorqueWrong, Fault::Overspeed]);
            // 5 ms.
            let plain = Variant::new(name, vec![injection], Expect::Sto, sign, 10, 10);
            ways.push(plain.from(Condition::TorqueWrong(j)).dropping(Drop::Bound(acting)));
        }
    }
    Ok(ways)
}

/// From the release to an open brake, s.
const OPENING_S: f64 = 0.150;
/// After the brakes' deadline and before the end of the test move; the path starts half of its 2 s before the pose.
const RELEASED: f64 = -0.5 * PATH_S - 0.3;
/// From open brakes to the test move, s.
const CALM_S: f64 = 0.1;

pub fn jammed(pose: &Pose) -> Ways {
    let jam = |target, severity| vec![fault(Kind::BrakeJammed, target).of(severity).at(POWER_UP)];
    let told = Sign::Fault(&[Fault::BrakeNotReleased]);
    let stiff = Sign::Fault(&[Fault::BrakeNotFree]);
    let mut ways = Vec::new();
    for (name, target) in [
        ("brake 1", Target::Brake(0)),
        ("brake 2", Target::Brake(1)),
        ("brake 4", Target::Brake(3)),
    ] {
        let stays = format!("{name}: feedback tells");
        // 100 and 105 ms.
        let stays = Variant::new(stays, jam(target, 0.0), Expect::NoGo, told, 200, 210);
        ways.push(stays.from(Condition::Released(OPENING_S)).checked(never_went));
        let lies = format!("{name}: feedback agrees");
        // 300 ms.
        let lies = Variant::new(lies, jam(target, 1.0), Expect::NoGo, stiff, 600, 600);
        ways.push(lies.from(Condition::Opened(CALM_S)).checked(never_went));
    }
    // 1 ms: the time in which brakes may open is over.
    let falls = vec![fault(Kind::BrakeNoFeedback, Target::Brake(1)).of(0.0).at(RELEASED)];
    let falls = Variant::new("brake 2: feedback falls back", falls, Expect::NoGo, told, 2, 2);
    ways.push(falls.checked(never_went));
    super::parked(pose, ways)
}

/// Holding was never reached, and nothing wound up meanwhile.
fn never_went(trial: &Trial, _: usize) -> Option<String> {
    let mut frames = trial.frames.iter();
    if frames.any(|f| [Mode::Holding, Mode::Moving].map(|mode| mode as u8).contains(&f.record.mode))
    {
        return Some("arming went on".into());
    }
    let wound = trial.frames.iter().any(|f| f.record.d_hat != [0.0; JOINTS]);
    wound.then(|| "the disturbance estimate wound up".into())
}

/// After the stop's order the brakes have set and torque is off, s.
const SET_S: f64 = 0.6;

/// Share of a joint's load that a slipping brake still takes.
const LEFT: f64 = 0.5;
/// Friction of a sound brake over the torque limit.
const HOLDING: f64 = 1.5;

pub fn slips(pose: &Pose) -> Ways {
    let mut model = Model::new(&REFERENCE);
    model.set_payload(pose.payload_kg);
    let load = model.gravity(&pose.q);
    let slip = |j: usize| {
        let share = LEFT * load[j].abs() / (HOLDING * REFERENCE.limits[j].tau_max);
        fault(Kind::BrakeSlip, Target::Brake(j)).of(share).at(SET_S)
    };
    let way = |name: &str, j: usize, slips: Vec<Injection>| {
        // 5 and 10 ms.
        let sign = Sign::Fault(&[Fault::BrakeSlipped]);
        let plain = Variant::new(name, slips, Expect::Lower, sign, 10, 20);
        let stop = Order { at_s: 0.0, ask: Ask::Plain(Command::Stop) };
        let way = f64::from(Safety::REFERENCE.slip[j]);
        plain.from(Condition::Moved(j, way)).ordered(vec![stop])
    };
    Ok(vec![
        way("brake 2", 1, vec![slip(1)]).checked(locked_out),
        way("brake 3", 2, vec![slip(2)]).checked(locked_out),
        way("brakes 2 and 3", 1, vec![slip(1), slip(2)]).checked(locked_out),
        // The telescope hangs in the rest pose: a brake that slips anywhere slips there, and torque has to hold it.
        way("brake 4", 3, vec![slip(3)]),
    ])
}

/// The arm ends in its brakes, and the fault is one that no order clears.
fn locked_out(trial: &Trial, _: usize) -> Option<String> {
    let last = trial.frames.last()?;
    let lowered = trial.frames.iter().any(|f| f.record.mode == Mode::Lowering as u8);
    if !lowered {
        return None;
    }
    let (fault, _) = measure::reported(trial);
    if last.record.mode != Mode::Latched as u8 || fault != Fault::BrakeSlipped {
        let mode = Mode::from_number(last.record.mode).map_or("?", Mode::name);
        return Some(format!("it ended in {mode} with {}", fault.name()));
    }
    None
}
