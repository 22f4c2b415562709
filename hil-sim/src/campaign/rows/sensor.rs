//! Rows 6 to 11: faults of sensors.

use firmware::config::Safety;
use shared::arm::JOINTS;
use shared::fault::{Fault, Limit};

use super::Ways;
use super::bus::index;
use crate::campaign::onset::Condition;
use crate::campaign::pose::Pose;
use crate::campaign::row::{Expect, POWER_UP, Sign, Variant, fault};
use crate::campaign::trial::Trial;
use crate::campaign::witness::ADC;
use crate::faults::{Injection, Kind, Target};

const STUCK: Sign = Sign::Fault(&[Fault::EncoderStuck, Fault::EncoderImplausible]);
const IMPLAUSIBLE: Sign = Sign::Fault(&[Fault::EncoderImplausible, Fault::EncoderStuck]);

pub fn stuck(pose: &Pose) -> Ways {
    let one = |j| (format!("encoder {}", j + 1), Target::Encoder(j), j);
    let all = ("all encoders".to_owned(), Target::Encoders, 0);
    let ways = (0..JOINTS).map(one).chain([all]).map(|(name, target, j)| {
        let stuck = vec![fault(Kind::StuckEncoder, target)];
        if !pose.moves() {
            return Variant::harmless(name, stuck).or_stopped();
        }
        Variant::new(name, stuck, Expect::Ss1, STUCK, 3, 5).from(Condition::Still(j, 0))
    });
    Ok(ways.collect())
}

pub fn jumps(_: &Pose) -> Ways {
    let mut ways = Vec::new();
    for j in [0, 1, 3] {
        let jump = |tick: u32| {
            fault(Kind::Jump, Target::Encoder(j)).at(f64::from(tick) * crate::campaign::row::T)
        };
        let once = format!("encoder {}: one sample", j + 1);
        ways.push(Variant::tolerated(once, vec![jump(0)], Sign::Rejected(j), 1));
        let thrice = format!("encoder {}: 3 in 7 ticks", j + 1);
        let thrice =
            Variant::new(thrice, [0, 3, 6].map(jump).into(), Expect::Ss1, IMPLAUSIBLE, 1, 10);
        ways.push(thrice.from(Condition::After(6)).twin(vec![jump(0)]));
    }
    Ok(ways)
}

/// Time in which the channel drifts as far as counts as wrong, s.
const DRIFT_S: f64 = 0.1;

pub fn drift(_: &Pose) -> Ways {
    let ways = (0..JOINTS).map(|j| {
        let wrong = f64::from(Safety::REFERENCE.torque_wrong[j]);
        let drift = fault(Kind::TorqueDrift, Target::Joint(j)).of(wrong / DRIFT_S);
        let drifted = Sign::Fault(&[Fault::TorqueDrift]);
        let name = format!("joint {}", j + 1);
        let plain = Variant::new(name, vec![drift], Expect::Ss1, drifted, 100, 100);
        let almost = Injection { for_s: Some(0.9 * DRIFT_S), ..drift };
        plain.from(Condition::Later(DRIFT_S)).twin(vec![almost]).checked(warned)
    });
    Ok(ways.collect())
}

/// The drift was warned of before the stop.
fn warned(trial: &Trial, from: usize) -> Option<String> {
    let bit = 1 << Limit::TorqueDrift as u16;
    let warned = trial.frames[..from].iter().any(|f| f.record.limits & bit != 0);
    (!warned).then(|| "no warning before the threshold".into())
}

pub fn alarms(_: &Pose) -> Ways {
    let encoder = Target::Encoder(1);
    let out = fault(Kind::Zeros, encoder);
    let over = fault(Kind::Overrange, Target::Joint(1));
    let error = fault(Kind::ErrorBit, encoder);
    let mut ways = Vec::new();
    for (name, injection, device) in [
        ("encoder 2: error bit", error, index(encoder)),
        ("encoder 2: code out of range", out, index(encoder)),
        ("ADC: overrange", over, ADC),
    ] {
        let rejected = Sign::Rejected(device);
        let two = format!("{name}, two samples");
        // The converter shows in the next tick what acts from this one on.
        let later = u32::from(device == ADC);
        let tolerated = Variant::tolerated(two, vec![injection.ticks(2)], rejected, 1);
        ways.push(Variant { observable: Condition::After(later), ..tolerated });
        let plain =
            Variant::new(format!("{name}, lasting"), vec![injection], Expect::Ss1, rejected, 1, 3);
        let plain = Variant { observable: Condition::After(later), ..plain };
        ways.push(plain.due(Condition::After(2 + later)).twin(vec![injection.ticks(2)]));
    }
    let warning = vec![fault(Kind::WarningBit, encoder)];
    ways.push(Variant::tolerated(
        "encoder 2: warning bit",
        warning,
        Sign::Limited(Limit::EncoderWarning),
        1,
    ));
    Ok(ways)
}

pub fn old(pose: &Pose) -> Ways {
    let mut ways = Vec::new();
    for j in [0, 1, 3] {
        let target = Target::Encoder(j);
        for (name, injection) in [
            ("5 ticks old", fault(Kind::LateSamples, target)),
            ("half rate", fault(Kind::HalfRate, target)),
            ("jitter of 100 us", fault(Kind::SampleJitter, target).of(1e-4)),
        ] {
            let name = format!("encoder {}: {name}", j + 1);
            // At rest there is nothing to see, unless the loop swings.
            let (expect, condition) = match pose.moves() {
                true => (Expect::Ss1, Condition::Doubtful(j)),
                false => (Expect::Ss1OrNone, Condition::Never),
            };
            let plain = Variant::new(name, vec![injection], expect, IMPLAUSIBLE, 5, 10);
            ways.push(plain.from(condition));
        }
        // At 0.1 rad/s that is 2 counts, and 8 in the difference of differences.
        let name = format!("encoder {}: jitter of 2 us, within the noise", j + 1);
        let jitter = vec![fault(Kind::SampleJitter, target).of(2e-6)];
        ways.push(Variant::harmless(name, jitter));
    }
    Ok(ways)
}

pub fn missing(pose: &Pose) -> Ways {
    let absent = |name: &str, kind, target| {
        let injection = fault(kind, target).at(POWER_UP);
        Variant::new(name, vec![injection], Expect::NoArm, Sign::Nothing, 0, 0)
            .dropping(crate::campaign::row::Drop::Zero)
    };
    let ways = vec![
        absent("encoder 2: zeros", Kind::Zeros, Target::Encoder(1)),
        absent("all encoders: zeros", Kind::Zeros, Target::Encoders),
        absent("ADC: zeros", Kind::Zeros, Target::Adc),
        absent("encoder 2: missing", Kind::Missing, Target::Encoder(1)),
        absent("ADC: missing", Kind::Missing, Target::Adc),
        absent("DAC: missing", Kind::Missing, Target::Dac),
        absent("everything: missing", Kind::Missing, Target::All),
    ];
    super::parked(pose, ways)
}
