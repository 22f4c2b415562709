//! Devices and pins by name, and the handles that the controller is wired to.

use std::cell::RefCell;
use std::rc::Rc;

use embedded_hal::digital::{self, InputPin, OutputPin, PinState};
use embedded_hal::spi::{self, Operation, SpiDevice};
use firmware::io::{Inputs, Io, Outputs};
use shared::arm::JOINTS;
use shared::pil;

use super::Bench;

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
        self.bench.borrow_mut().transfer(self.what, &mosi[..length], &mut miso[..length])?;
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
