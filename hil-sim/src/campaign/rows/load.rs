//! Row 16: a load that the controller does not know.

use shared::arm::JOINTS;
use shared::fault::Limit;

use super::Ways;
use crate::campaign::onset::Condition;
use crate::campaign::pose::Pose;
use crate::campaign::row::{Expect, Sign, Variant, fault};
use crate::campaign::trial::Trial;
use crate::faults::{Injection, Kind, Target};

/// Rated payload, kg.
const RATED_KG: f64 = 300.0;

pub fn load(pose: &Pose) -> Ways {
    let mut ways = vec![
        unknown("20 % more", more(0.2 * RATED_KG)),
        unknown("50 % more", more(0.5 * RATED_KG)),
        unknown("200 % more", more(2.0 * RATED_KG)),
        limited("a torque at its limit for a while", more(pose.limiting_kg), Expect::Tolerate),
        Variant {
            react: vec![(Condition::Astray, 100)],
            ..limited("a torque at its limit for too long", more(pose.overload_kg), Expect::Ss1)
        },
    ];
    if pose.payload_kg > 0.0 {
        ways.push(unknown("dropped", fault(Kind::PayloadDrop, Target::Only)));
    }
    Ok(ways)
}

fn more(kg: f64) -> Injection {
    fault(Kind::Payload, Target::Only).of(kg)
}

fn unknown(name: &str, load: Injection) -> Variant {
    let variant = Variant::new(name, vec![load], Expect::Ss1OrNone, Sign::Nothing, 0, 100);
    variant.checked(learns_at_limit)
}

/// A load that takes a torque to its limit, which is told at once.
fn limited(name: &str, load: Injection, expect: Expect) -> Variant {
    let variant = Variant::new(name, vec![load], expect, Sign::Limited(Limit::Torque), 1, 0);
    variant.from(Condition::TorqueAtLimit).checked(is_limited)
}

fn is_limited(trial: &Trial, from: usize) -> Option<String> {
    let never = Condition::TorqueAtLimit.index(trial, trial.start.unwrap_or(0)).is_none();
    never.then(|| "no torque came to its limit".into()).or_else(|| learns_at_limit(trial, from))
}

/// A joint at its torque limit learns nothing: the estimate is the law's only integral, and would wind up.
fn learns_at_limit(trial: &Trial, _: usize) -> Option<String> {
    let learns = trial.frames.windows(2).flat_map(|pair| {
        let (before, now) = (&pair[0].record, &pair[1].record);
        (0..JOINTS)
            .filter(move |j| now.saturated >> j & 1 != 0 && now.d_hat[*j] != before.d_hat[*j])
    });
    let joint = learns.into_iter().next()?;
    Some(format!("joint {} adapted at its torque limit", joint + 1))
}
