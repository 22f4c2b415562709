//! What a session does before and after each tick of the controller.

use shared::fault::Mode;
use shared::pil::Release;
use shared::telemetry::Record;

use super::clock::Step;
use super::faults::Faults;
use super::{SPENT_CYCLES, Session};
use crate::bench::Motion;
use crate::faults::Told;

impl Session<'_> {
    /// Takes the operator's next command, and t = 0 from it.
    pub(super) fn ask_operator(&mut self) {
        let command = self.operator.command(&self.last);
        // One that no tick has taken yet comes first.
        self.command = self.command.or(command);
        if self.operator.has_begun() && self.clock.since_start_s().is_none() {
            self.clock.start();
            self.plant.start_disturbance();
            if let Some(tape) = &mut self.tape {
                tape.start = Some(tape.frames.len());
            }
        }
    }

    /// Brings bench, plant and clock to what is wrong at this instant.
    pub(super) fn inject(&mut self) {
        if let Some(faults) = &mut self.faults {
            faults.inject(&mut self.clock, &mut self.bench.borrow_mut(), &mut self.plant);
        }
    }

    /// Puts the plant's state where the sensors latch it, and says what the tick is told.
    pub(super) fn release(&mut self) -> Release {
        let told = self.faults.as_mut().map_or(Told::WELL, Faults::tell);
        let spent = told.spent.map(|periods| self.clock.cycles_in(periods) as u32);
        let motion = Motion {
            q: self.plant.q(),
            qd: self.plant.qd(),
            qdd: self.plant.acceleration(&self.torque),
        };
        // On a dead line the console speaks in vain.
        let spoken = self.console.speak(self.command.take());
        let mut bench = self.bench.borrow_mut();
        bench.brake_open = self.plant.brake_released();
        bench.begin_tick(motion);
        Release {
            levels: bench.input_levels(),
            cycles: self.clock.cycles(),
            spent: spent.unwrap_or(SPENT_CYCLES),
            conversions: bench.conversions(),
            pokes: told.pokes,
            ..Release::default()
        }
        .with_link(if told.alive { &spoken } else { &[] })
    }

    pub(super) fn take(&mut self, record: Record) {
        if self.last.mode == Mode::Boot as u8 && record.mode != Mode::Boot as u8 {
            self.spoil_bus();
        }
        self.last = record;
        self.ticks += 1;
    }

    /// Passes on what the board says.
    pub(super) fn hear(&mut self, said: Vec<u8>) {
        self.console.hear(&said);
        self.said = said;
    }

    /// What the controller said on the operator link in its last tick.
    pub fn said(&self) -> &[u8] {
        &self.said
    }

    /// Converters are configured: from now on the bus may err.
    pub(super) fn spoil_bus(&mut self) {
        let error_share = self.scenario.bus.error_share;
        if error_share > 0.0 {
            self.bench.borrow_mut().make_noisy(error_share, self.scenario.seed);
        }
    }

    /// Passes on what reaches drives and brakes.
    pub(super) fn drive(&mut self) {
        let bench = self.bench.borrow();
        let shares = bench.drive_commands();
        self.torque = std::array::from_fn(|j| shares[j] * self.arm.drive_full_scale[j]);
        self.plant.set_brake_release(bench.brake_releases());
    }

    /// Judges the step, and keeps what is asked for.
    pub(super) fn note(&mut self, ticked: bool) {
        if let Some(t_s) = self.clock.path_s()
            && ticked
            && self.operator.is_served(&self.last)
        {
            self.judge.add(t_s, &self.plant, &self.torque, &self.last);
            self.pick_up(t_s);
        }
        if let Some(faults) = &mut self.faults {
            faults.watch(&self.clock, &self.last, self.bench.borrow().chain_closed());
        }
        if let Some(tape) = &mut self.tape {
            let (plant, bench) = (&self.plant, self.bench.borrow());
            tape.add(self.clock.true_s(), (ticked, self.last), plant, &self.torque, &bench);
        }
    }

    /// Attaches the payload when its time has come.
    pub(super) fn pick_up(&mut self, t_s: f64) {
        if let Some(payload) = self.scenario.plant.payload
            && !self.picked_up
            && t_s + 0.5 / f64::from(self.scenario.tick_hz) >= payload.at_s
        {
            self.plant.set_payload(self.scenario.plant.payload_kg + payload.kg);
            self.picked_up = true;
        }
    }

    /// Lets the torques act until the next step.
    pub(super) fn pass(&mut self, step: Step) {
        let (parts, dt_s) = self.clock.parts(step);
        for part in 0..parts {
            if part > 0 {
                self.drive();
            }
            self.plant.step(self.torque, dt_s);
            let mut sensed =
                std::array::from_fn(|j| self.torque[j] / self.arm.torque_full_scale[j]);
            if let Some(faults) = &self.faults {
                faults.sense(&self.clock, &mut sensed);
            }
            self.bench.borrow_mut().advance(dt_s, sensed);
        }
        self.clock.pass(step);
    }
}
