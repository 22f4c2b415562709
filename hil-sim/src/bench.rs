//! The mocked bus: simulated chips and pins behind the `embedded-hal` traits.
//!
//! One [`Bench`] holds all devices. Handles given to the controller borrow it for the length of one
//! transaction. Within a tick a cursor tells when a read starts, because an encoder latches then.

use std::cell::RefCell;
use std::fmt;
use std::rc::Rc;

use embedded_hal::digital::{self, InputPin, OutputPin, PinState};
use embedded_hal::spi::{self, Operation, SpiDevice};
use firmware::io::{Inputs, Io, Outputs};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};
use shared::arm::{Arm, JOINTS};
use shared::pil;

use shared::wire::biss_c::LATCH_DELAY_S;

use crate::chips::ads131m04::Ads131m04;
use crate::chips::dac81404::Dac81404;
use crate::chips::encoder::Encoder;

/// True motion at a tick instant, for what is latched shortly after it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion {
    /// Position, rad and m.
    pub q: [f64; JOINTS],
    /// Speed, rad/s and m/s.
    pub qd: [f64; JOINTS],
    /// Acceleration, rad/s² and m/s².
    pub qdd: [f64; JOINTS],
}

/// Levels on the controller's output pins; everything is low from reset to the first tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OutputLevels {
    /// DAC update.
    pub ldac: bool,
    /// Drive enables.
    pub drive_enable: [bool; JOINTS],
    /// Safe torque off, low is off.
    pub sto: bool,
    /// Brake releases.
    pub brake_release: [bool; JOINTS],
    /// DAC reset, low resets.
    pub dac_reset: bool,
    /// ADC reset, low resets.
    pub adc_reset: bool,
    /// Watchdog feed.
    pub watchdog: bool,
}

/// All devices on the bus, their pins and the instant within the tick.
pub struct Bench {
    encoders: [Encoder; JOINTS],
    adc: Ads131m04,
    dac: Dac81404,
    /// Levels that the controller drives.
    pub outputs: OutputLevels,
    /// Brake feedback contacts, high is open.
    pub brake_open: [bool; JOINTS],
    /// Emergency stop contacts, high is healthy.
    pub emergency_stop: [bool; 2],
    motion: Motion,
    /// Time since the tick instant, s.
    cursor_s: f64,
    /// Between the starts of two encoder reads, s.
    skew_s: f64,
    /// Flips bits, once the bus is to be noisy.
    noise: Option<Noise>,
    /// What crossed bus and pins since it was last taken, if it is kept.
    traffic: Option<Vec<Event>>,
}

impl Bench {
    /// Chips fitted to `arm`, just powered up.
    ///
    /// # Panics
    /// If no encoder of the arm's width exists; scenarios are refused before that.
    pub fn new(arm: &Arm, skew_s: f64, seed: u64) -> Self {
        Self {
            encoders: arm.encoders.map(|e| Encoder::new(e).expect("a width that a head has")),
            adc: Ads131m04::new(seed, ADC_CLOCK_ERROR_PPM),
            dac: Dac81404::default(),
            outputs: OutputLevels::default(),
            brake_open: [false; JOINTS],
            emergency_stop: [true; 2],
            motion: Motion::default(),
            cursor_s: 0.0,
            skew_s,
            noise: None,
            traffic: None,
        }
    }

    /// Starts a tick with the arm in `motion`.
    pub fn begin_tick(&mut self, motion: Motion) {
        self.motion = motion;
        self.cursor_s = 0.0;
    }

    /// Lets `dt_s` pass with `torque` (as fractions of the transducers' full scale) acting.
    pub fn advance(&mut self, dt_s: f64, torque: [f64; JOINTS]) {
        self.adc.advance(dt_s, torque);
    }

    /// What the drives are told, as fractions of full scale; 0 where enable or STO is low.
    pub fn drive_commands(&self) -> [f64; JOINTS] {
        let outputs = self.dac.outputs();
        std::array::from_fn(|j| {
            let enabled = self.outputs.sto && self.outputs.drive_enable[j];
            if enabled { outputs[j] } else { 0.0 }
        })
    }

    /// Flips one bit in this share of the answers from now on.
    pub fn make_noisy(&mut self, error_share: f64, seed: u64) {
        self.noise =
            Some(Noise { error_share, generator: Xoshiro256PlusPlus::seed_from_u64(seed) });
    }

    /// Keeps a copy of everything that crosses bus and pins from now on.
    pub fn keep_traffic(&mut self) {
        self.traffic = Some(Vec::new());
    }

    /// What has crossed since the last call.
    pub fn take_traffic(&mut self) -> Vec<Event> {
        self.traffic.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Input pins as one bit each: brake feedbacks in bits 0 to 3, emergency stop contacts in 4 and 5.
    pub fn input_levels(&self) -> u8 {
        let pins = self.brake_open.iter().chain(&self.emergency_stop);
        pins.enumerate().map(|(bit, &high)| u8::from(high) << bit).sum()
    }

    /// One chip-select frame.
    pub fn transfer(&mut self, device: Device, mosi: &[u8], miso: &mut [u8]) {
        self.transfer_cleanly(device, mosi, miso);
        if let Some(noise) = &mut self.noise {
            noise.disturb(miso);
        }
        if let Some(traffic) = &mut self.traffic {
            traffic.push(Event::Transfer { device, mosi: mosi.to_vec(), miso: miso.to_vec() });
        }
    }

    fn transfer_cleanly(&mut self, device: Device, mosi: &[u8], miso: &mut [u8]) {
        match device {
            Device::Encoder(j) => {
                let Motion { q, qd, qdd } = &self.motion;
                let t = self.cursor_s + LATCH_DELAY_S;
                self.encoders[j].transfer(q[j] + t * (qd[j] + 0.5 * t * qdd[j]), miso);
                self.cursor_s += self.skew_s;
            }
            Device::Adc => self.adc.transfer(mosi, miso),
            Device::Dac => self.dac.transfer(mosi, miso),
        }
    }

    /// Drives an output pin.
    pub fn set(&mut self, pin: Output, high: bool) {
        if let Some(traffic) = &mut self.traffic {
            traffic.push(Event::Pin { pin, high });
        }
        let o = &mut self.outputs;
        match pin {
            Output::Ldac => {
                if o.ldac && !high {
                    self.dac.ldac();
                }
                o.ldac = high;
            }
            Output::DriveEnable(j) => o.drive_enable[j] = high,
            Output::Sto => o.sto = high,
            Output::BrakeRelease(j) => o.brake_release[j] = high,
            Output::DacReset => {
                o.dac_reset = high;
                if !high {
                    self.dac.reset();
                }
            }
            Output::AdcReset => {
                o.adc_reset = high;
                self.adc.set_reset_pin(high);
            }
            Output::Watchdog => o.watchdog = high,
        }
    }

    fn get(&self, pin: Input) -> bool {
        match pin {
            Input::BrakeOpen(j) => self.brake_open[j],
            Input::EmergencyStop(contact) => self.emergency_stop[contact],
        }
    }
}

/// Bit errors on the way to the controller.
#[derive(Clone)]
struct Noise {
    error_share: f64,
    generator: Xoshiro256PlusPlus,
}

impl Noise {
    fn disturb(&mut self, miso: &mut [u8]) {
        let draw = self.generator.next_u64();
        // The upper half decides whether, the lower half where.
        let hit = (draw >> 32) as f64 / 4_294_967_296.0 < self.error_share;
        let bits = 8 * miso.len() as u64;
        if hit && bits > 0 {
            let bit = (draw & 0xFFFF_FFFF) * bits >> 32;
            miso[(bit / 8) as usize] ^= 1 << (bit % 8);
        }
    }
}

/// The converter's crystal against the controller's, a usual 20 ppm part.
const ADC_CLOCK_ERROR_PPM: f64 = 20.0;

/// A chip select.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Device {
    /// Encoder of a joint.
    Encoder(usize),
    /// Torque converter.
    Adc,
    /// Torque-drive DAC.
    Dac,
}

/// An output pin of the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "named as the fields of `firmware::io::Outputs`")]
pub enum Output {
    Ldac,
    DriveEnable(usize),
    Sto,
    BrakeRelease(usize),
    DacReset,
    AdcReset,
    Watchdog,
}

/// An input pin of the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "named as the fields of `firmware::io::Inputs`")]
pub enum Input {
    BrakeOpen(usize),
    EmergencyStop(usize),
}

impl Device {
    /// The device with this number in the messages of an emulated board.
    pub fn from_number(number: u8) -> Option<Self> {
        match number {
            pil::DEVICE_ADC => Some(Self::Adc),
            pil::DEVICE_DAC => Some(Self::Dac),
            j if usize::from(j) < JOINTS => Some(Self::Encoder(j.into())),
            _ => None,
        }
    }
}

impl Output {
    /// The pin with this number in the messages of an emulated board.
    pub fn from_number(number: u8) -> Option<Self> {
        let joint = |first: u8| usize::from(number - first);
        match number {
            pil::PIN_LDAC => Some(Self::Ldac),
            pil::PIN_DRIVE_ENABLE..pil::PIN_STO => {
                Some(Self::DriveEnable(joint(pil::PIN_DRIVE_ENABLE)))
            }
            pil::PIN_STO => Some(Self::Sto),
            pil::PIN_BRAKE_RELEASE..pil::PIN_DAC_RESET => {
                Some(Self::BrakeRelease(joint(pil::PIN_BRAKE_RELEASE)))
            }
            pil::PIN_DAC_RESET => Some(Self::DacReset),
            pil::PIN_ADC_RESET => Some(Self::AdcReset),
            pil::PIN_WATCHDOG => Some(Self::Watchdog),
            _ => None,
        }
    }
}

/// One thing that crossed bus or pins.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Event {
    /// A chip-select frame.
    Transfer {
        /// Chip selected.
        device: Device,
        /// Bytes from the controller.
        mosi: Vec<u8>,
        /// Bytes to the controller.
        miso: Vec<u8>,
    },
    /// An output pin was driven.
    Pin {
        /// Which.
        pin: Output,
        /// Its level.
        high: bool,
    },
}

impl Event {
    /// Device or pin.
    pub fn place(&self) -> String {
        match self {
            Self::Transfer { device, .. } => format!("{device:?}"),
            Self::Pin { pin, .. } => format!("pin {pin:?}"),
        }
    }
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Transfer { device, mosi, miso } => {
                write!(f, "{device:?} sent {mosi:02x?}, received {miso:02x?}")
            }
            Self::Pin { pin, high } => write!(f, "{pin:?} {}", if *high { "high" } else { "low" }),
        }
    }
}

/// A handle to one thing on the bench.
#[derive(Clone)]
pub struct Handle<T> {
    bench: Rc<RefCell<Bench>>,
    what: T,
}

/// The controller's connections to a bench.
pub type BenchIo = Io<Handle<Device>, Handle<Output>, Handle<Input>>;

/// Wires a controller to `bench`.
pub fn wire(bench: &Rc<RefCell<Bench>>) -> BenchIo {
    let spi = |what| Handle { bench: Rc::clone(bench), what };
    let output = |what| Handle { bench: Rc::clone(bench), what };
    let input = |what| Handle { bench: Rc::clone(bench), what };
    Io {
        encoders: std::array::from_fn(|j| spi(Device::Encoder(j))),
        adc: spi(Device::Adc),
        dac: spi(Device::Dac),
        outputs: Outputs {
            ldac: output(Output::Ldac),
            drive_enable: std::array::from_fn(|j| output(Output::DriveEnable(j))),
            sto: output(Output::Sto),
            brake_release: std::array::from_fn(|j| output(Output::BrakeRelease(j))),
            dac_reset: output(Output::DacReset),
            adc_reset: output(Output::AdcReset),
            watchdog: output(Output::Watchdog),
        },
        inputs: Inputs {
            brake_open: std::array::from_fn(|j| input(Input::BrakeOpen(j))),
            emergency_stop: std::array::from_fn(|contact| input(Input::EmergencyStop(contact))),
        },
    }
}

impl spi::ErrorType for Handle<Device> {
    type Error = spi::ErrorKind;
}

/// Longest transaction of any device, bytes.
const FRAME_MAX: usize = 32;

impl SpiDevice for Handle<Device> {
    /// One chip-select frame: what all operations write, then what they read.
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Self::Error> {
        let (mut mosi, mut miso) = ([0; FRAME_MAX], [0; FRAME_MAX]);
        let mut length = 0;
        for operation in operations.iter() {
            let (sent, clocks): (&[u8], usize) = match operation {
                Operation::Read(read) => (&[], read.len()),
                Operation::Write(write) => (write, write.len()),
                Operation::Transfer(read, write) => (write, read.len().max(write.len())),
                Operation::TransferInPlace(data) => (data, data.len()),
                Operation::DelayNs(_) => continue,
            };
            let end = length + clocks;
            let frame = mosi.get_mut(length..end).ok_or(spi::ErrorKind::Overrun)?;
            frame[..sent.len()].copy_from_slice(sent);
            length = end;
        }
        self.bench.borrow_mut().transfer(self.what, &mosi[..length], &mut miso[..length]);
        let mut at = 0;
        for operation in operations {
            let (read, clocks): (&mut [u8], usize) = match operation {
                Operation::Read(read) => (read, 0),
                Operation::Write(write) => (&mut [], write.len()),
                Operation::Transfer(read, write) => (read, write.len()),
                Operation::TransferInPlace(data) => (data, 0),
                Operation::DelayNs(_) => continue,
            };
            read.copy_from_slice(&miso[at..at + read.len()]);
            at += read.len().max(clocks);
        }
        Ok(())
    }
}

impl<T> digital::ErrorType for Handle<T> {
    type Error = digital::ErrorKind;
}

impl OutputPin for Handle<Output> {
    fn set_low(&mut self) -> Result<(), Self::Error> {
        self.set_state(PinState::Low)
    }

    fn set_high(&mut self) -> Result<(), Self::Error> {
        self.set_state(PinState::High)
    }

    fn set_state(&mut self, state: PinState) -> Result<(), Self::Error> {
        self.bench.borrow_mut().set(self.what, state == PinState::High);
        Ok(())
    }
}

impl InputPin for Handle<Input> {
    fn is_high(&mut self) -> Result<bool, Self::Error> {
        Ok(self.bench.borrow().get(self.what))
    }

    fn is_low(&mut self) -> Result<bool, Self::Error> {
        self.is_high().map(|high| !high)
    }
}
