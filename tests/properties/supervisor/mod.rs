//! The supervisor alone, on an ideal arm: every transition of its table happens, and no other.

mod driven;
mod stopped;
mod table;

use firmware::config::Config;
use firmware::estimator::{Observer, Scale};
use firmware::monitor::Finding;
use firmware::path::Motion;
use firmware::planner::Order;
use firmware::supervisor::{ALL, Brakes, Events, Mode, Timing};
use shared::arm::JOINTS;
use shared::command::{Command, Profile, Trajectory};
use shared::fault::{Fault, Mode as ModeCode, Refusal};

use crate::path::{TICK_HZ, motion, origin, path};
use crate::planner::plan;

/// A supervisor with all that it is told.
#[derive(Clone)]
struct World {
    mode: Mode,
    timing: Timing,
    scales: [Scale; JOINTS],
    observers: [Observer; JOINTS],
    /// Distance that every joint moved in its brake, counts.
    slip: u32,
    /// Fixed feedback, or that of ideal brakes.
    brakes: Option<Brakes>,
    ready: bool,
    stop_released: bool,
    finding: Finding,
    blind: u8,
    silence: u32,
    /// The arm does not follow its set-point.
    drifts: bool,
}

impl World {
    fn new() -> Self {
        let config = Config::default();
        let mut timing: Timing = bytemuck::zeroed();
        timing.set(&config);
        Self {
            mode: Mode::RESET,
            timing,
            scales: config.joints.map(|joint| Scale::new(&joint, TICK_HZ as f32)),
            observers: origin().map(|word| Observer::at_rest(word >> 6)),
            slip: 0,
            brakes: None,
            ready: false,
            stop_released: true,
            finding: Finding::NONE,
            blind: 0,
            silence: 0,
            drifts: false,
        }
    }

    fn code(&self) -> ModeCode {
        self.mode.code()
    }

    /// One tick with this order; the arm is where the set-point has it.
    fn tick(&mut self, order: Option<&Order>) -> Refusal {
        let follows = if self.drifts { None } else { self.mode.set_point(&self.timing) };
        if let Some(set_point) = follows {
            for (observer, position) in self.observers.iter_mut().zip(set_point.position) {
                observer.position = position;
            }
        }
        let release = self.mode.levels(&self.timing).release;
        let ideal = Brakes { open: release, closed: ALL & !release };
        let (observers, scales) = (self.observers, self.scales);
        let events = Events {
            order,
            observers: &observers,
            scales: &scales,
            codes: observers.map(|o| (o.position >> 6).wrapping_add(self.slip)),
            ready: self.ready,
            complaint: Fault::None,
            brakes: self.brakes.unwrap_or(ideal),
            stop_released: self.stop_released,
            finding: self.finding,
            blind: self.blind,
            silence: self.silence,
        };
        self.mode.step(&self.timing, &events)
    }

    /// A short motion from where the arm is held.
    fn motion(&self) -> Motion {
        let origin_q6 = match self.mode {
            Mode::Holding { pose } => pose,
            _ => self.observers.map(|o| o.position),
        };
        motion(&Trajectory { origin_q6, ..path(Profile::Quintic, 0.1, [1e-4; JOINTS]) })
    }
}

/// A slow jog of all joints.
fn jog(share: f32) -> Order {
    let order = plan(&Command::Jog([0.01 * share; JOINTS]));
    assert!(matches!(order, Order::Jog(_)), "{order:?}");
    order
}
