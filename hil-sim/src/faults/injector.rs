//! When each fault of a scenario begins and ends, and what it does then.

use shared::arm::{Arm, JOINTS};
use shared::pil::{POKES, Poke};

use super::conditions::Conditions;
use super::{Injection, Kind, Span, memory};
use crate::bench::Bench;
use crate::plant::Plant;
use crate::session::Slot;

/// Times are sums of many periods, s.
const ROUNDING_S: f64 = 1e-9;

/// How far a fault has come.
#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Waiting,
    Active,
    Over,
}

#[derive(Clone, Copy, Debug)]
struct Running {
    injection: Injection,
    state: State,
    /// It has done what it does but once.
    done: bool,
    /// The tick before was late because of it.
    was_late: bool,
}

impl Running {
    /// Whether it would have ended at `t_s`.
    fn ends(&self, t_s: f64) -> bool {
        let Injection { kind, at_s, for_s, .. } = self.injection;
        match for_s {
            Some(for_s) => t_s >= at_s + for_s - ROUNDING_S,
            None => kind.spec().span == Span::Once && self.done,
        }
    }
}

/// A fault that began or ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Number of the injection.
    pub injection: usize,
    /// It began.
    pub begins: bool,
}

/// What faults change of what the tick is told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Told {
    /// The operator link carries what is put on it.
    pub alive: bool,
    /// Computing time reported, if not the usual one, ticks.
    pub spent: Option<f64>,
    /// Changes of memory.
    pub pokes: [Poke; POKES],
}

impl Told {
    /// Nothing is wrong.
    pub const WELL: Self = Self { alive: true, spent: None, pokes: [bytemuck::zeroed(); POKES] };
}

/// All faults of a run.
#[derive(Clone, Debug)]
pub struct Injector {
    arm: Arm,
    running: Vec<Running>,
}

impl Injector {
    /// Nothing has begun yet.
    pub fn new(injections: &[Injection], arm: &Arm) -> Self {
        let running = injections.iter().map(|injection| {
            let state = match injection.kind.spec().span {
                Span::PowerUp => State::Over,
                _ => State::Waiting,
            };
            Running { injection: *injection, state, done: false, was_late: false }
        });
        Self { arm: *arm, running: running.collect() }
    }

    fn active(&self) -> impl Iterator<Item = &Injection> {
        self.running.iter().filter(|r| r.state == State::Active).map(|r| &r.injection)
    }

    fn is_active(&self, kind: Kind) -> bool {
        self.active().any(|injection| injection.kind == kind)
    }

    /// Brings bench and plant to what is wrong at `t_s`; gives what began or ended.
    pub fn advance(&mut self, t_s: f64, bench: &mut Bench, plant: &mut Plant) -> Vec<Edge> {
        let mut edges = Vec::new();
        for (i, running) in self.running.iter_mut().enumerate() {
            if running.state == State::Waiting && t_s >= running.injection.at_s - ROUNDING_S {
                running.state = State::Active;
                edges.push(Edge { injection: i, begins: true });
            }
            if running.state == State::Active && running.ends(t_s) {
                running.state = State::Over;
                edges.push(Edge { injection: i, begins: false });
            }
        }
        for edge in &edges {
            bench.interfere(edge.injection, edge.begins);
            load(&self.running[edge.injection].injection, edge.begins, plant);
        }
        if !edges.is_empty() {
            Conditions::of(self.active(), &self.arm).apply(bench, plant);
        }
        self.strike(bench);
        edges
    }

    /// What happens to devices at an instant.
    fn strike(&mut self, bench: &mut Bench) {
        for running in self.running.iter_mut().filter(|r| r.state == State::Active) {
            match running.injection.kind {
                Kind::AdcReset => bench.reset_adc(),
                Kind::DacReset => bench.reset_dac(),
                Kind::EarlyKick => running.done |= bench.kick_watchdog(),
                _ => {}
            }
        }
    }

    /// How the tick comes that is due.
    pub fn slot(&mut self) -> Slot {
        let mut slot = Slot::Regular;
        for running in self.running.iter_mut().filter(|r| r.state == State::Active) {
            running.was_late = running.injection.kind == Kind::LateTick && !running.was_late;
            slot = match running.injection.kind {
                Kind::LateTick if running.was_late => Slot::Late(running.injection.severity),
                Kind::MissingTick | Kind::Hang => Slot::Missing,
                Kind::DoubleTick => Slot::Double,
                _ => continue,
            };
            running.done = true;
        }
        slot
    }

    /// Board's clock over its nominal rate.
    pub fn clock_ratio(&self) -> f64 {
        let off = self.active().filter(|injection| injection.kind == Kind::ClockOff);
        off.map(|injection| injection.severity).product()
    }

    /// What the coming tick is told. Faults that last one tick have had theirs with this.
    pub fn tell(&mut self) -> Told {
        let mut told = Told { alive: !self.is_active(Kind::LinkSilent), ..Told::WELL };
        let mut free = told.pokes.iter_mut();
        for running in self.running.iter_mut().filter(|r| r.state == State::Active) {
            if running.injection.kind == Kind::OverBudget {
                told.spent = Some(running.injection.severity);
            }
            if let Some(poke) = memory::poke(&running.injection) {
                // Where there is no room the poke waits for the next tick.
                let Some(slot) = free.next() else { continue };
                *slot = poke;
            }
            running.done |= running.injection.kind != Kind::EarlyKick;
        }
        told
    }

    /// What the torque transducers' channels get in place of `shares` of their full scale at `t_s`.
    pub fn sense(&self, t_s: f64, shares: &mut [f64; JOINTS]) {
        for injection in self.active() {
            for j in injection.target.joints() {
                match injection.kind {
                    Kind::TorqueDrift => {
                        let drift = injection.severity * (t_s - injection.at_s);
                        shares[j] += drift / self.arm.torque_full_scale[j];
                    }
                    Kind::Overrange => shares[j] = OVER_RANGE,
                    _ => {}
                }
            }
        }
    }
}

/// Beyond what the converter can show, of full scale.
const OVER_RANGE: f64 = 1.5;

/// Payload that comes or goes.
fn load(injection: &Injection, begins: bool, plant: &mut Plant) {
    let carried_kg = plant.payload_kg();
    match injection.kind {
        Kind::Payload => {
            let added_kg = if begins { injection.severity } else { -injection.severity };
            plant.set_payload((carried_kg + added_kg).max(0.0));
        }
        Kind::PayloadDrop if begins => plant.set_payload(0.0),
        _ => {}
    }
}
