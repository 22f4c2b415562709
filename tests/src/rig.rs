//! The controller on its simulated bus, ticked by hand: commands, dead devices and pins in the test's hands.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use embedded_hal::digital::{self, OutputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};
use firmware::config::Config;
use firmware::executive::{Executive, Retained, TickInput};
use firmware::io::{Io, Outputs};
use firmware::memory::Memory;
use firmware::planner::{Order, Planner};
use hil_sim::bench::{self, Bench, Device, Handle, Input, Motion, Output};
use hil_sim::plant::{Disturbance, FRICTION, Plant, RATIOS, Ratios};
use shared::arm::{Arm, JOINTS, Q0, REFERENCE};
use shared::command::Command;
use shared::fault::Mode;
use shared::telemetry::Record;

/// Way of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// To the device; only where both ways share their bytes.
    Out,
    /// From the device.
    In,
}

/// Sees a frame pass, and may change it.
pub type Tamper = Box<dyn FnMut(Way, &mut [u8])>;

/// What a test can do to one connection and learn of it.
#[derive(Default)]
pub struct Line {
    /// The controller has driven this pin.
    pub driven: Cell<bool>,
    /// Transactions fail.
    pub dead: Cell<bool>,
    /// Stands between the device and the controller.
    pub tamper: RefCell<Option<Tamper>>,
}

/// A handle with a [`Line`] in between.
struct Tapped<T> {
    inner: Handle<T>,
    line: Rc<Line>,
}

impl spi::ErrorType for Tapped<Device> {
    type Error = spi::ErrorKind;
}

impl SpiDevice for Tapped<Device> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Self::Error> {
        if self.line.dead.get() {
            return Err(spi::ErrorKind::Other);
        }
        let mut tamper = self.line.tamper.borrow_mut();
        let Some(tamper) = tamper.as_mut() else { return self.inner.transaction(operations) };
        for operation in operations.iter_mut() {
            if let Operation::TransferInPlace(bytes) = operation {
                tamper(Way::Out, bytes);
            }
        }
        self.inner.transaction(operations)?;
        for operation in operations {
            match operation {
                Operation::Read(bytes)
                | Operation::Transfer(bytes, _)
                | Operation::TransferInPlace(bytes) => tamper(Way::In, bytes),
                Operation::Write(_) | Operation::DelayNs(_) => {}
            }
        }
        Ok(())
    }
}

impl digital::ErrorType for Tapped<Output> {
    type Error = digital::ErrorKind;
}

impl OutputPin for Tapped<Output> {
    fn set_low(&mut self) -> Result<(), Self::Error> {
        self.line.driven.set(true);
        self.inner.set_low()
    }

    fn set_high(&mut self) -> Result<(), Self::Error> {
        self.line.driven.set(true);
        self.inner.set_high()
    }
}

/// The reference arm at rest in its start pose, its bench and the controller, just powered up.
pub struct Rig {
    /// Chips and pin levels.
    pub bench: Rc<RefCell<Bench>>,
    /// The arm.
    pub plant: Plant,
    /// Record of the last tick.
    pub last: Record,
    /// Encoders 1 to 4, torque converter, DAC.
    pub devices: [Rc<Line>; JOINTS + 2],
    /// Every output pin.
    pub pins: Vec<Rc<Line>>,
    controller: Executive<'static, Tapped<Device>, Tapped<Output>, Handle<Input>>,
    planner: Planner,
    arm: Arm,
    tick_s: f64,
    cycles: u32,
    torque: [f64; JOINTS],
}

impl Rig {
    /// A controller with `config` whose encoder reads start `skew_s` apart.
    ///
    /// # Panics
    /// If the controller refuses its configuration.
    pub fn new(config: &Config, skew_s: f64) -> Self {
        let arm = REFERENCE;
        let bench = Rc::new(RefCell::new(Bench::new(&arm, skew_s, 1)));
        let (io, devices, pins) = tap(&bench);
        let mut controller = Executive::new(io, Box::leak(Box::default()));
        let retained =
            Retained { parked: Some(std::array::from_fn(|j| code(&arm, j))), crash: None };
        controller.configure(config, config.crc(), &retained).expect("a configuration in range");
        Self {
            plant: Plant::at_rest(&arm, Q0, Disturbance::new(FRICTION, Ratios::Fixed(RATIOS)), 1),
            last: Record::default(),
            controller,
            planner: Planner::new(config),
            tick_s: 1.0 / f64::from(config.tick_hz),
            cycles: 0,
            torque: [0.0; JOINTS],
            bench,
            devices,
            pins,
            arm,
        }
    }

    /// One tick with this command, and what the arm does until the next.
    pub fn tick(&mut self, command: Option<Command>) -> Record {
        self.bench.borrow_mut().brake_open = self.plant.brake_released();
        self.bench.borrow_mut().begin_tick(Motion {
            q: self.plant.q(),
            qd: self.plant.qd(),
            qdd: self.plant.acceleration(&self.torque),
        });
        let order = command.map(|command| {
            let mut order = Order::Arm;
            self.planner.plan(&command, &self.last.code, &mut order);
            order
        });
        let input = TickInput {
            order: order.as_ref(),
            alive: true,
            cycles: self.cycles,
            spent: 2_000,
            conversions: self.bench.borrow().conversions(),
        };
        self.last = *self.controller.tick(&input);
        self.cycles = self.cycles.wrapping_add((168e6 * self.tick_s) as u32);
        let commands = self.bench.borrow().drive_commands();
        self.torque = std::array::from_fn(|j| commands[j] * self.arm.drive_full_scale[j]);
        self.plant.set_brake_release(self.bench.borrow().outputs.brake_release);
        self.plant.step(self.torque, self.tick_s);
        let sensed = std::array::from_fn(|j| self.torque[j] / self.arm.torque_full_scale[j]);
        self.bench.borrow_mut().advance(self.tick_s, sensed);
        self.last
    }

    /// Ticks without a command until `mode`, at most `limit_s` long.
    ///
    /// # Panics
    /// If the controller does not get there in time.
    pub fn until(&mut self, mode: Mode, limit_s: f64) {
        for _ in 0..(limit_s / self.tick_s) as u32 {
            if self.tick(None).mode == mode as u8 {
                return;
            }
        }
        let (now, fault) = (Mode::from_number(self.last.mode), self.last.fault);
        panic!("{mode:?} is not reached in {limit_s} s: {now:?}, fault {fault}");
    }

    /// Parameters and estimates, to damage them.
    pub fn memory(&mut self) -> &mut Memory {
        self.controller.memory()
    }

    /// Whether any pin lets torque flow or opens a brake.
    pub fn is_live(&self) -> bool {
        let o = self.bench.borrow().outputs;
        o.sto || o.drive_enable.contains(&true) || o.brake_release.contains(&true)
    }
}

type TappedIo = Io<Tapped<Device>, Tapped<Output>, Handle<Input>>;

/// The bench's wiring with a [`Line`] in every device and output pin.
fn tap(bench: &Rc<RefCell<Bench>>) -> (TappedIo, [Rc<Line>; JOINTS + 2], Vec<Rc<Line>>) {
    let devices: [Rc<Line>; JOINTS + 2] = Default::default();
    let [l1, l2, l3, l4, adc_line, dac_line] = devices.clone();
    let mut pins = Vec::new();
    let mut pin = |inner: Handle<Output>| {
        let line = Rc::<Line>::default();
        pins.push(Rc::clone(&line));
        Tapped { inner, line }
    };
    let Io { encoders: [e1, e2, e3, e4], adc, dac, outputs: o, inputs } = bench::wire(bench);
    let outputs = Outputs {
        ldac: pin(o.ldac),
        drive_enable: o.drive_enable.map(&mut pin),
        sto: pin(o.sto),
        brake_release: o.brake_release.map(&mut pin),
        dac_reset: pin(o.dac_reset),
        adc_reset: pin(o.adc_reset),
        watchdog: pin(o.watchdog),
    };
    let spi = |inner, line| Tapped { inner, line };
    let io = Io {
        encoders: [spi(e1, l1), spi(e2, l2), spi(e3, l3), spi(e4, l4)],
        adc: spi(adc, adc_line),
        dac: spi(dac, dac_line),
        outputs,
        inputs,
    };
    (io, devices, pins)
}

/// Code of joint `j` in the start pose.
fn code(arm: &Arm, j: usize) -> u32 {
    ((Q0[j] - arm.encoders[j].zero) / arm.encoders[j].lsb) as u32
}
