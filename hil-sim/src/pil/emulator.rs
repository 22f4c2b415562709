//! The board in the emulator: what is said at its end of the bench.

use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;

use firmware::executive::Retained;
use shared::evidence::Image;
use shared::pil::{self, Release, TRANSFER_MAX};
use shared::telemetry::{RECORD_BYTES, Record};

use super::process::{EmulatorError, Process};
use crate::bench::{Bench, Device, Output};
use crate::run::{ACCESS, Kept};

/// What the board leaves behind.
#[derive(Clone, Debug)]
pub struct End {
    /// High-water mark of its stack, bytes.
    pub stack_bytes: u16,
    /// What it kept.
    pub evidence: Box<Image>,
}

/// A board in a running emulator, which ends with it.
pub struct Emulator {
    process: Process,
    bench: Rc<RefCell<Bench>>,
    /// What the board is handed at each boot: configuration, its check sum, parked pose, access.
    introduction: Vec<u8>,
    coefficients: Vec<u8>,
    /// What the board has said on the operator link.
    said: Vec<u8>,
}

impl Emulator {
    /// Starts `image` and hands it its configuration.
    ///
    /// # Errors
    /// [`EmulatorError`] where it does not come up.
    pub fn start(
        image: &Path,
        kept: impl Into<Kept>,
        retained: Retained,
        bench: Rc<RefCell<Bench>>,
    ) -> Result<Self, EmulatorError> {
        Self::start_with(image, kept, retained, bench, &[])
    }

    /// As [`Self::start`], with further arguments to the emulator.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub fn start_with(
        image: &Path,
        kept: impl Into<Kept>,
        retained: Retained,
        bench: Rc<RefCell<Bench>>,
        arguments: &[String],
    ) -> Result<Self, EmulatorError> {
        let mut emulator = Self::spawn(image, kept.into(), retained, bench, arguments)?;
        emulator.introduce()?;
        Ok(emulator)
    }

    /// Starts the process; the board has not been handed anything.
    pub(super) fn spawn(
        image: &Path,
        Kept { config, crc }: Kept,
        retained: Retained,
        bench: Rc<RefCell<Bench>>,
        arguments: &[String],
    ) -> Result<Self, EmulatorError> {
        let mut introduction = bytemuck::bytes_of(&config).to_vec();
        introduction.extend(crc.to_le_bytes());
        introduction
            .extend(retained.parked.unwrap_or_default().map(u32::to_le_bytes).as_flattened());
        introduction.extend(ACCESS.boots.to_le_bytes());
        introduction.extend(ACCESS.key);
        Ok(Self {
            process: Process::start(image, arguments)?,
            bench,
            introduction,
            coefficients: Vec::new(),
            said: Vec::new(),
        })
    }

    /// Hands the board its configuration, after power-up or after it has reset itself.
    ///
    /// # Errors
    /// [`EmulatorError`] where it does not come up.
    pub fn introduce(&mut self) -> Result<(), EmulatorError> {
        self.process.forget_unread()?;
        self.process.send(&self.introduction)?;
        self.coefficients = self.greet()?;
        Ok(())
    }

    /// What the configuration became on the board.
    pub fn coefficients(&self) -> &[u8] {
        &self.coefficients
    }

    /// The emulator's process.
    pub fn process_id(&self) -> u32 {
        self.process.id()
    }

    /// Ends the emulation in order, so that what the emulator writes at its end is written.
    ///
    /// # Errors
    /// Where it cannot be told or does not end.
    pub fn stop(mut self) -> Result<End, EmulatorError> {
        self.release(&Release::instead(pil::QUIT))?;
        let stack_bytes = match self.process.byte()? {
            pil::TAG_STACK => u16::from_le_bytes([self.process.byte()?, self.process.byte()?]),
            tag => return Err(self.unexpected(tag)),
        };
        let mut evidence: Box<Image> = Box::new(bytemuck::zeroed());
        self.process.fill(bytemuck::bytes_of_mut(&mut *evidence))?;
        self.process.wait()?;
        Ok(End { stack_bytes, evidence })
    }

    fn greet(&mut self) -> Result<Vec<u8>, EmulatorError> {
        match self.process.byte()? {
            pil::TAG_COEFFICIENTS => {
                let length = u16::from_le_bytes([self.process.byte()?, self.process.byte()?]);
                (0..length).map(|_| self.process.byte()).collect()
            }
            pil::TAG_REFUSED => Err(EmulatorError::Refused),
            tag => Err(self.unexpected(tag)),
        }
    }

    /// What a message means that may come at any time, or at none.
    fn unexpected(&mut self, tag: u8) -> EmulatorError {
        let mut status = [0; 4];
        match tag {
            pil::TAG_FAULT => match self.process.fill(&mut status) {
                Ok(()) => EmulatorError::Fault { status: u32::from_le_bytes(status) },
                Err(error) => error,
            },
            _ => EmulatorError::Unknown(tag),
        }
    }

    /// What the board has said on the operator link since this was last asked.
    pub fn said(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.said)
    }

    /// Releases one tick and serves its bus until its record arrives.
    ///
    /// # Errors
    /// [`EmulatorError`] where the emulator is gone or talks nonsense.
    pub fn exchange(&mut self, release: &Release) -> Result<Record, EmulatorError> {
        self.release(release)?;
        self.serve()
    }

    pub(super) fn release(&mut self, release: &Release) -> Result<(), EmulatorError> {
        self.process.send(bytemuck::bytes_of(release))
    }

    /// Makes the board pass through its function `halt`.
    pub(super) fn halt(&mut self) -> Result<(), EmulatorError> {
        self.release(&Release::instead(pil::HALT))
    }

    /// Serves the bus until the record arrives.
    pub(super) fn serve(&mut self) -> Result<Record, EmulatorError> {
        loop {
            match self.process.byte()? {
                pil::TAG_PIN => {
                    let (pin, high) = (self.process.byte()?, self.process.byte()? != 0);
                    let pin = Output::from_number(pin).ok_or(EmulatorError::Unknown(pin))?;
                    self.bench.borrow_mut().set(pin, high);
                }
                pil::TAG_TRANSFER => self.transfer()?,
                pil::TAG_LINK => {
                    let length = self.process.byte()?;
                    for _ in 0..length {
                        let byte = self.process.byte()?;
                        self.said.push(byte);
                    }
                }
                pil::TAG_RECORD => {
                    let mut bytes = [0; RECORD_BYTES];
                    self.process.fill(&mut bytes)?;
                    return Ok(Record::from_bytes(&bytes));
                }
                tag => return Err(self.unexpected(tag)),
            }
        }
    }

    fn transfer(&mut self) -> Result<(), EmulatorError> {
        let (device, length) = (self.process.byte()?, self.process.byte()?);
        let device = Device::from_number(device).ok_or(EmulatorError::Unknown(device))?;
        let (mut mosi, mut answer) = ([0; TRANSFER_MAX], [0; 1 + TRANSFER_MAX]);
        let length = usize::from(length).min(TRANSFER_MAX);
        self.process.fill(&mut mosi[..length])?;
        let miso = &mut answer[1..=length];
        let exchanged = self.bench.borrow_mut().transfer(device, &mosi[..length], miso);
        answer[0] = u8::from(exchanged.is_err());
        self.process.send(&answer[..=length])
    }
}
