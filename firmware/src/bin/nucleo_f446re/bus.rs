//! The SPI devices: two chips on their own ports, and the four encoders' lines.

use embedded_hal::digital::OutputPin;
use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use stm32f4::stm32f446::spi1::RegisterBlock;

use crate::clocks::CORE_HZ;
use crate::encoders::Line;
use crate::pins::Output;
use crate::wait::{TimedOut, until};

/// Longest wait for one byte: about 10 us, thirteen times the slower port's 0.76 us.
const BYTE_POLLS: u32 = 170;

/// A device on the bus.
pub enum Bus {
    /// Torque converter or DAC.
    Chip(Chip),
    /// One encoder of the four that are read together.
    Encoder(Line),
}

impl ErrorType for Bus {
    type Error = TimedOut;
}

impl SpiDevice for Bus {
    #[inline(always)]
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), TimedOut> {
        match self {
            Self::Chip(chip) => chip.transaction(operations),
            Self::Encoder(line) => match operations {
                [Operation::Read(bytes)] => line.read(bytes),
                _ => Err(TimedOut),
            },
        }
    }
}

/// Clock of a port: its bus's divided by four.
pub const PORT_DIVISOR: u32 = 4;

/// A chip on a port of its own, in SPI mode 1.
pub struct Chip {
    port: &'static RegisterBlock,
    select: Output,
}

impl Chip {
    /// Master, mode 1, 8 bits, bus clock / [`PORT_DIVISOR`] (RM0390, SPI_CR1).
    pub fn start(port: &'static RegisterBlock, select: Output) -> Self {
        port.cr1().write(|w| {
            w.mstr().master().cpol().idle_low().cpha().second_edge().br().div4();
            w.ssm().enabled().ssi().slave_not_selected().spe().enabled()
        });
        Self { port, select }
    }

    /// One chip select around all operations.
    #[inline(always)]
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), TimedOut> {
        let port = self.port;
        // What an abandoned transaction left behind: data, then the overrun flag.
        port.dr().read();
        port.sr().read();
        let Ok(()) = self.select.set_low();
        let result = operations.iter_mut().try_for_each(|operation| run(port, operation));
        let idle = until(BYTE_POLLS, || !port.sr().read().bsy().bit());
        let Ok(()) = self.select.set_high();
        result.and(idle)
    }
}

#[inline(always)]
fn run(port: &RegisterBlock, operation: &mut Operation<'_, u8>) -> Result<(), TimedOut> {
    match operation {
        Operation::Read(read) => read.iter_mut().try_for_each(|byte| {
            *byte = exchange(port, 0)?;
            Ok(())
        }),
        Operation::Write(write) => {
            write.iter().try_for_each(|byte| exchange(port, *byte).map(|_| ()))
        }
        Operation::Transfer(read, write) => transfer(port, read, write),
        Operation::TransferInPlace(bytes) => bytes.iter_mut().try_for_each(|byte| {
            *byte = exchange(port, *byte)?;
            Ok(())
        }),
        Operation::DelayNs(ns) => {
            cortex_m::asm::delay(ns.div_ceil(1_000_000_000 / CORE_HZ));
            Ok(())
        }
    }
}

/// Sends zeros where `write` is the shorter one, drops answers where `read` is.
fn transfer(port: &RegisterBlock, read: &mut [u8], write: &[u8]) -> Result<(), TimedOut> {
    let mut answers = read.iter_mut();
    for byte in write {
        let answer = exchange(port, *byte)?;
        if let Some(slot) = answers.next() {
            *slot = answer;
        }
    }
    answers.try_for_each(|slot| {
        *slot = exchange(port, 0)?;
        Ok(())
    })
}

/// One byte each way.
#[inline(always)]
fn exchange(port: &RegisterBlock, byte: u8) -> Result<u8, TimedOut> {
    port.dr().write(|w| w.dr().set(u16::from(byte)));
    until(BYTE_POLLS, || port.sr().read().rxne().bit())?;
    Ok(port.dr().read().dr().bits() as u8)
}
