//! Buses and pins through the tunnel, as peripherals' drivers would offer them.

use embedded_hal::digital::{self, InputPin, OutputPin, PinState};
use embedded_hal::spi::{self, Operation, SpiDevice};
use shared::pil::{self, TRANSFER_MAX};

use super::with;
use crate::defect;

/// One chip-select frame; what is sent and what comes back have the same length.
#[inline(never)]
#[unsafe(link_section = ".text.link")]
fn transfer(device: u8, mosi: &[u8], miso: &mut [u8]) -> Result<(), spi::ErrorKind> {
    if mosi.len() != miso.len() || mosi.len() > TRANSFER_MAX {
        return Err(spi::ErrorKind::Overrun);
    }
    with(|link| {
        link.post(&[pil::TAG_TRANSFER, device, mosi.len() as u8]);
        link.post(mosi);
        link.flush();
        let mut answer = [0; 1 + TRANSFER_MAX];
        link.read(answer.get_mut(..=miso.len()).ok_or(spi::ErrorKind::Overrun)?);
        let [failed, received @ ..] = answer;
        if failed != 0 {
            return Err(spi::ErrorKind::Other);
        }
        for (slot, byte) in miso.iter_mut().zip(received) {
            *slot = byte;
        }
        defect::in_sample(device, miso);
        Ok(())
    })
}

/// As [`transfer`], sending zeros.
#[inline(never)]
#[unsafe(link_section = ".text.link")]
fn read(device: u8, miso: &mut [u8]) -> Result<(), spi::ErrorKind> {
    let zeros = [0; TRANSFER_MAX];
    transfer(device, zeros.get(..miso.len()).ok_or(spi::ErrorKind::Overrun)?, miso)
}

/// As [`transfer`], dropping what comes back.
#[inline(never)]
#[unsafe(link_section = ".text.link")]
fn write(device: u8, mosi: &[u8]) -> Result<(), spi::ErrorKind> {
    let mut ignored = [0; TRANSFER_MAX];
    transfer(device, mosi, ignored.get_mut(..mosi.len()).ok_or(spi::ErrorKind::Overrun)?)
}

/// As [`transfer`], with what comes back in the place of what is sent.
#[inline(never)]
#[unsafe(link_section = ".text.link")]
fn transfer_in_place(device: u8, data: &mut [u8]) -> Result<(), spi::ErrorKind> {
    let mut buffer = [0; TRANSFER_MAX];
    let sent = buffer.get_mut(..data.len()).ok_or(spi::ErrorKind::Overrun)?;
    for (slot, byte) in sent.iter_mut().zip(data.iter()) {
        *slot = *byte;
    }
    transfer(device, sent, data)
}

#[inline(never)]
#[unsafe(link_section = ".text.link")]
fn post_pin(pin: u8, high: bool) {
    with(|link| link.post(&[pil::TAG_PIN, pin, u8::from(high)]));
}

#[inline(never)]
#[unsafe(link_section = ".text.link")]
fn level(bit: u8) -> bool {
    with(|link| link.levels >> (bit & 7) & 1 == 1)
}

/// A device on the tunnelled bus.
pub struct Tunnel(pub u8);

impl spi::ErrorType for Tunnel {
    type Error = spi::ErrorKind;
}

/// The drivers' calls are passed on directly, as a peripheral's driver would.
impl SpiDevice for Tunnel {
    /// Each operation is a chip-select frame of its own: the drivers use one a transaction.
    #[inline(always)]
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Self::Error> {
        for operation in operations {
            match operation {
                Operation::Read(data) => self.read(data)?,
                Operation::Write(data) => self.write(data)?,
                Operation::Transfer(read, write) => self.transfer(read, write)?,
                Operation::TransferInPlace(data) => self.transfer_in_place(data)?,
                Operation::DelayNs(_) => return Err(spi::ErrorKind::Other),
            }
        }
        Ok(())
    }

    #[inline(always)]
    fn read(&mut self, buf: &mut [u8]) -> Result<(), Self::Error> {
        read(self.0, buf)
    }

    #[inline(always)]
    fn write(&mut self, buf: &[u8]) -> Result<(), Self::Error> {
        write(self.0, buf)
    }

    #[inline(always)]
    fn transfer(&mut self, read: &mut [u8], write: &[u8]) -> Result<(), Self::Error> {
        transfer(self.0, write, read)
    }

    #[inline(always)]
    fn transfer_in_place(&mut self, buf: &mut [u8]) -> Result<(), Self::Error> {
        transfer_in_place(self.0, buf)
    }
}

/// A tunnelled output pin.
pub struct Line(pub u8);

impl digital::ErrorType for Line {
    type Error = digital::ErrorKind;
}

impl OutputPin for Line {
    #[inline(always)]
    fn set_low(&mut self) -> Result<(), Self::Error> {
        self.set_state(PinState::Low)
    }

    #[inline(always)]
    fn set_high(&mut self) -> Result<(), Self::Error> {
        self.set_state(PinState::High)
    }

    #[inline(always)]
    fn set_state(&mut self, state: PinState) -> Result<(), Self::Error> {
        post_pin(self.0, state == PinState::High);
        Ok(())
    }
}

/// An input pin as of the last release.
pub struct Level(pub u8);

impl digital::ErrorType for Level {
    type Error = digital::ErrorKind;
}

impl InputPin for Level {
    #[inline(always)]
    fn is_high(&mut self) -> Result<bool, Self::Error> {
        Ok(level(self.0))
    }

    #[inline(always)]
    fn is_low(&mut self) -> Result<bool, Self::Error> {
        Ok(!level(self.0))
    }
}
