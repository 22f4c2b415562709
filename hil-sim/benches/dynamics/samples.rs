//! Random states over the whole range of motion, as each contender wants them.

use firmware::JointVector;
use firmware::law;
use rand_distr::{Distribution, StandardUniform};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;
use shared::arm::{JOINTS, REFERENCE};

/// More than branch predictors learn by heart, few enough for the caches.
const STATES: usize = 1024;

/// Position and velocity; rad and m, rad/s and m/s.
pub struct Exact {
    /// Position.
    pub q: [f64; JOINTS],
    /// Velocity.
    pub qd: [f64; JOINTS],
}

/// The same states three times; `f64` values are those of the `f32` ones.
pub struct Samples {
    /// For the firmware.
    pub firmware: Vec<law::State>,
    /// For the plain versions.
    pub plain: Vec<plain::State>,
    /// For the library.
    pub exact: Vec<Exact>,
}

impl Samples {
    /// States within the limits of motion, with errors of a transient.
    pub fn random() -> Self {
        let mut generator = Xoshiro256PlusPlus::seed_from_u64(1);
        let mut share = || -> f64 { StandardUniform.sample(&mut generator) };
        let mut joints = |low: fn(usize) -> f64, high: fn(usize) -> f64| {
            JointVector::from_fn(|j, _| (low(j) + (high(j) - low(j)) * share()) as f32)
        };
        let firmware = Vec::from_iter((0..STATES).map(|_| law::State {
            q: joints(|j| REFERENCE.limits[j].q_min, |j| REFERENCE.limits[j].q_max),
            qd: joints(|j| -REFERENCE.limits[j].qd_max, |j| REFERENCE.limits[j].qd_max),
            e1: joints(|_| -1e-4, |_| 1e-4),
            e1_dot: joints(|_| -1e-2, |_| 1e-2),
            qdd_d: joints(|_| -1.0, |_| 1.0),
        }));
        let plain = firmware.iter().map(|s| plain::State {
            q: s.q,
            qd: s.qd,
            e1: s.e1,
            e1_dot: s.e1_dot,
            qdd_d: s.qdd_d,
        });
        let exact =
            firmware.iter().map(|s| Exact { q: widened(&s.q), qd: widened(&s.qd) }).collect();
        Self { plain: plain.collect(), exact, firmware }
    }
}

fn widened(x: &JointVector) -> [f64; JOINTS] {
    [x.x, x.y, x.z, x.w].map(f64::from)
}
