//! Row 16: a load that the controller does not know.

use shared::arm::JOINTS;

use super::Ways;
use crate::campaign::pose::Pose;
use crate::campaign::row::{Expect, Sign, Variant, fault};
use crate::campaign::trial::Trial;
use crate::faults::{Kind, Target};

/// Rated payload, kg.
const RATED_KG: f64 = 300.0;

pub fn load(pose: &Pose) -> Ways {
    let more = |name: &str, kg| {
        let payload = vec![fault(Kind::Payload, Target::Only).of(kg)];
        Variant::new(name, payload, Expect::Ss1OrNone, Sign::Nothing, 0, 100)
    };
    let mut ways = vec![
        more("20 % more", 0.2 * RATED_KG),
        more("50 % more", 0.5 * RATED_KG),
        more("600 kg more: torque at its limit", 600.0),
    ];
    if pose.payload_kg > 0.0 {
        let drop = vec![fault(Kind::PayloadDrop, Target::Only)];
        ways.push(Variant::new("dropped", drop, Expect::Ss1OrNone, Sign::Nothing, 0, 100));
    }
    Ok(ways.into_iter().map(|way| way.checked(frozen)).collect())
}

/// A joint at its torque limit learns nothing.
fn frozen(trial: &Trial, from: usize) -> Option<String> {
    let pairs = trial.frames[from..].windows(2);
    let learns = pairs.flat_map(|pair| {
        let (before, now) = (&pair[0].record, &pair[1].record);
        (0..JOINTS)
            .filter(move |j| now.saturated >> j & 1 != 0 && now.d_hat[*j] != before.d_hat[*j])
    });
    let joint = learns.into_iter().next()?;
    Some(format!("joint {} adapted at its torque limit", joint + 1))
}
