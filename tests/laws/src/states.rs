//! Random states over the whole range of motion, the same in each run.

use firmware::JointVector;
use firmware::config::Config;
use rand_xoshiro::Xoshiro128PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

/// Source of states.
pub struct States {
    config: &'static Config,
    generator: Xoshiro128PlusPlus,
}

impl States {
    /// States within the limits of motion of `config`.
    pub fn new(config: &'static Config) -> Self {
        Self { config, generator: Xoshiro128PlusPlus::seed_from_u64(1) }
    }

    /// A state with errors of a transient.
    pub fn state(&mut self) -> plain::State {
        let joints = &self.config.joints;
        plain::State {
            q: self.within(joints.map(|j| j.q_min), joints.map(|j| j.q_max)),
            qd: self.within(joints.map(|j| -j.qd_max), joints.map(|j| j.qd_max)),
            e1: self.within([-1e-4; 4], [1e-4; 4]),
            e1_dot: self.within([-1e-2; 4], [1e-2; 4]),
            qdd_d: self.within([-1.0; 4], [1.0; 4]),
        }
    }

    /// A disturbance estimate within its bounds, N m and N.
    pub fn d_hat(&mut self) -> JointVector {
        let d_max = self.config.gains.d_max;
        self.within(d_max.map(|d| -d), d_max)
    }

    fn within(&mut self, low: [f32; 4], high: [f32; 4]) -> JointVector {
        JointVector::from(low).zip_map(&high.into(), |a, b| a + (b - a) * self.share())
    }

    /// Uniform in [0, 1): the upper 24 bits are a mantissa.
    fn share(&mut self) -> f32 {
        (self.generator.next_u32() >> 8) as f32 / 16_777_216.0
    }
}
