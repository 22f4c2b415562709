//! The poses in which faults are injected, from `campaign/poses.toml`.

use serde::Deserialize;
use shared::arm::{JOINTS, REFERENCE};

use crate::scenario::Scenario;

const FILE: &str = include_str!("../../campaign/poses.toml");

/// A pose, passed at a speed with a payload.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pose {
    /// Name.
    pub name: String,
    /// Joint positions when the fault begins, rad and m.
    pub q: [f64; JOINTS],
    /// Joint speeds at that time, rad/s and m/s.
    pub qd: [f64; JOINTS],
    /// Payload, known to the controller, kg.
    pub payload_kg: f64,
    /// Load beside it that takes a torque to its limit for some ticks, kg.
    pub limiting_kg: f64,
    /// Load beside it that takes a torque to its limit for so long that the error lasts, kg.
    pub overload_kg: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    pose: Vec<Pose>,
}

/// Why the poses cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PoseError {
    /// The file is not what it should be.
    #[error("campaign/poses.toml: {0}")]
    Syntax(#[from] toml::de::Error),
    /// A pose leaves what the arm can do.
    #[error(
        "campaign/poses.toml: pose `{pose}`: {key} of joint {joint} = {value} is outside {lo} to {hi}"
    )]
    Range {
        /// Name of the pose.
        pose: String,
        /// Which of its values.
        key: &'static str,
        /// Joint, counted from 1.
        joint: usize,
        /// The value.
        value: f64,
        /// Lowest allowed.
        lo: f64,
        /// Highest allowed.
        hi: f64,
    },
}

/// Duration of a path, s; the fault begins half-way.
pub const PATH_S: f64 = 2.0;
/// What may be added to a payload, kg.
const LOADS_KG: (f64, f64) = (0.0, 2_000.0);
/// Highest ds/dx of the quintic, at its middle.
const PEAK: f64 = 1.875;
/// A scenario that says nothing but what it must.
const BARE: &str =
    "summary = \"a pose\"\n[trajectory]\nprofile = \"quintic\"\namplitude = [0, 0, 0, 0]\n";
/// Hold before the path starts, s.
const SETTLE_S: f64 = 0.1;

impl Pose {
    /// Those of the file.
    ///
    /// # Errors
    /// A value that cannot be, by its name.
    pub fn all() -> Result<Vec<Self>, PoseError> {
        Self::parse(FILE)
    }

    fn parse(text: &str) -> Result<Vec<Self>, PoseError> {
        let File { pose: poses } = toml::from_str(text)?;
        poses.iter().try_for_each(Self::validate)?;
        Ok(poses)
    }

    fn validate(&self) -> Result<(), PoseError> {
        let amplitude = self.amplitude(PATH_S);
        for (j, limit) in REFERENCE.limits.iter().enumerate() {
            let half = 0.5 * amplitude[j].abs();
            let (q, qd) = ((limit.q_min + half, limit.q_max - half), (-limit.qd_max, limit.qd_max));
            self.within("q", j, self.q[j], q)?;
            self.within("qd", j, self.qd[j], qd)?;
        }
        self.within("payload_kg", 0, self.payload_kg, (0.0, 300.0))?;
        self.within("limiting_kg", 0, self.limiting_kg, LOADS_KG)?;
        self.within("overload_kg", 0, self.overload_kg, LOADS_KG)
    }

    fn within(
        &self,
        key: &'static str,
        j: usize,
        value: f64,
        (lo, hi): (f64, f64),
    ) -> Result<(), PoseError> {
        if value >= lo && value <= hi {
            return Ok(());
        }
        Err(PoseError::Range { pose: self.name.clone(), key, joint: j + 1, value, lo, hi })
    }

    /// Whether the arm moves.
    pub fn moves(&self) -> bool {
        self.qd.iter().any(|qd| *qd != 0.0)
    }

    /// Amplitude of the path of `duration_s` that passes the pose half-way at its speed, rad and m.
    fn amplitude(&self, duration_s: f64) -> [f64; JOINTS] {
        self.qd.map(|qd| qd * duration_s / PEAK)
    }

    /// The path through the pose, without faults; in `duration_s` instead of [`PATH_S`] it is passed more slowly.
    pub fn scenario(&self, duration_s: f64, seed: u64) -> Scenario {
        let mut scenario =
            Scenario::parse(&self.name, BARE).expect("the least that a scenario needs");
        let amplitude = self.amplitude(PATH_S);
        scenario.trajectory.amplitude = amplitude;
        scenario.trajectory.q0 = std::array::from_fn(|j| self.q[j] - 0.5 * amplitude[j]);
        scenario.duration_s = duration_s;
        scenario.settle_s = SETTLE_S;
        scenario.seed = seed;
        scenario.model.payload_kg = self.payload_kg;
        scenario.plant.payload_kg = self.payload_kg;
        scenario
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::Path;

    #[test]
    fn path_passes_the_pose_at_its_speed_half_way() {
        for pose in Pose::all().expect("good poses") {
            let middle = Path::of(&pose.scenario(PATH_S, 1)).at(0.5 * PATH_S);
            for j in 0..JOINTS {
                assert!((middle.q[j] - pose.q[j]).abs() < 1e-12, "{} {j}", pose.name);
                assert!((middle.qd[j] - pose.qd[j]).abs() < 1e-12, "{} {j}", pose.name);
                assert!(middle.qdd[j].abs() < 1e-12, "{} {j}", pose.name);
            }
        }
    }

    #[test]
    fn poses_beyond_the_arm_and_unknown_keys_are_refused_by_name() {
        let text = |q4: &str, more: &str| {
            format!(
                "[[pose]]\nname = \"far\"\nq = [0, 0.2, 1.35, {q4}]\nqd = [0, 0, 0, 0]\npayload_kg = 0\nlimiting_kg = 0\noverload_kg = 0\n{more}"
            )
        };
        let told = |text: String| Pose::parse(&text).expect_err("refused").to_string();
        assert!(
            told(text("5.4", "")).ends_with("pose `far`: q of joint 4 = 5.4 is outside 2.9 to 5.3")
        );
        assert!(told(text("5.2", "speed = 1\n")).contains("unknown field `speed`"));
    }
}
