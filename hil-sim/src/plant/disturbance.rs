//! What the model does not tell the controller: viscous friction (Eq 27) and a slow disturbance (Eq 28).

use core::f64::consts::PI;

use rand_distr::{Distribution, StandardUniform};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

use super::Joints;

/// Viscous friction of Eq 27, N m s/rad and N s/m.
pub const FRICTION: Joints = [200.0, 200.0, 200.0, 100.0];

/// The four numbers of Eq 28 that a run uses unless told otherwise.
pub const RATIOS: Joints = [0.8147, 0.9058, 0.1270, 0.9134];

/// Amplitude of Eq 28, N m and N.
const AMPLITUDE: f64 = 30.0;

/// Where the numbers in [0, 1] of Eq 28 come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ratios {
    /// The same throughout the run.
    Fixed(Joints),
    /// Drawn anew for every tick from this seed.
    Redrawn(u64),
}

/// d = diag(friction) qd + 30 sin(pi t) r; the second part acts from [`Disturbance::start`] on.
#[derive(Clone, Debug)]
pub struct Disturbance {
    friction: Joints,
    ratios: Joints,
    generator: Option<Xoshiro256PlusPlus>,
    time_s: Option<f64>,
}

impl Disturbance {
    /// Friction coefficients as [`FRICTION`], N m s/rad and N s/m.
    pub fn new(friction: Joints, ratios: Ratios) -> Self {
        let (ratios, generator) = match ratios {
            Ratios::Fixed(ratios) => (ratios, None),
            Ratios::Redrawn(seed) => ([0.0; 4], Some(Xoshiro256PlusPlus::seed_from_u64(seed))),
        };
        let mut disturbance = Self { friction, ratios, generator, time_s: None };
        disturbance.redraw();
        disturbance
    }

    /// Makes this instant t = 0 of Eq 28.
    pub(super) fn start(&mut self) {
        self.time_s = Some(0.0);
    }

    pub(super) fn advance(&mut self, dt_s: f64) {
        if let Some(time_s) = &mut self.time_s {
            *time_s += dt_s;
        }
    }

    /// Takes the next tick's numbers, where they change.
    pub(super) fn redraw(&mut self) {
        if let Some(generator) = &mut self.generator {
            self.ratios = core::array::from_fn(|_| StandardUniform.sample(generator));
        }
    }

    /// Eq 28 this much later than now, N m and N.
    pub(super) fn external(&self, later_s: f64) -> Joints {
        match self.time_s {
            Some(time_s) => {
                let level = AMPLITUDE * (PI * (time_s + later_s)).sin();
                self.ratios.map(|ratio| level * ratio)
            }
            None => [0.0; 4],
        }
    }

    /// Eq 27, N m and N.
    pub(super) fn friction(&self, qd: &Joints) -> Joints {
        core::array::from_fn(|j| self.friction[j] * qd[j])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn external_part_waits_for_the_start_and_then_follows_the_sine() {
        let mut d = Disturbance::new(FRICTION, Ratios::Fixed(RATIOS));
        d.advance(0.25);
        assert_eq!(d.external(0.5), [0.0; 4]);
        d.start();
        d.advance(0.25);
        assert_eq!(d.external(0.25), RATIOS.map(|r| 30.0 * r));
    }

    #[test]
    fn numbers_are_redrawn_inside_the_unit_interval_and_repeat_with_the_seed() {
        let draw = |seed| {
            let mut d = Disturbance::new(FRICTION, Ratios::Redrawn(seed));
            core::array::from_fn::<_, 100, _>(|_| {
                d.redraw();
                d.ratios
            })
        };
        let drawn = draw(7);
        assert!(drawn.iter().flatten().all(|r| (0.0..1.0).contains(r)));
        assert!(drawn.windows(2).all(|pair| pair[0] != pair[1]));
        let mean = drawn.iter().flatten().sum::<f64>() / 400.0;
        assert!((mean - 0.5).abs() < 0.06, "mean {mean} of 400 uniform numbers");
        assert_eq!(drawn, draw(7));
        assert_ne!(drawn, draw(8));
    }
}
