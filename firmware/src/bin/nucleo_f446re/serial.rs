//! The ST-LINK's serial port: USART2 sends by polling and receives by DMA.
//!
//! A tick takes longer than three bytes, so received ones go into a ring without the core. Sections and registers are
//! RM0390's.

use core::sync::atomic::{AtomicU32, Ordering, fence};

use embedded_io::{ErrorKind, ErrorType, Read, ReadReady, Write};
use stm32f4::stm32f446::{Peripherals, dma2, usart1};

use crate::clocks::APB1_HZ;
use crate::wait::{TimedOut, until};

/// The ST-LINK's bridge follows any rate that its host asks for; this one is 0.2 % off.
pub const BAUD: u32 = 460_800;
/// A byte takes 22 us; this is twice that.
const BYTE_POLLS: u32 = 750;

/// 11 ms of the line: longer than idle is away to send a record and an answer.
const RING_BYTES: usize = 512;
static RING: [AtomicU32; RING_BYTES / 4] = [const { AtomicU32::new(0) }; RING_BYTES / 4];

/// DMA1's stream of USART2_RX, and its channel number (DMA1 request mapping).
const STREAM: usize = 5;
const CHANNEL: u8 = 4;

/// See the module's documentation.
pub struct Serial {
    port: &'static usart1::RegisterBlock,
    dma: &'static dma2::RegisterBlock,
    /// Place in the ring of the next byte to be read.
    next: usize,
}

impl Serial {
    /// 8 data bits, no parity, one stop bit (USART_CR1).
    pub fn start(p: &'static Peripherals) -> Self {
        let port = &p.USART2;
        // 16 times USARTDIV, rounded: mantissa and fraction in one (section 25.4.4).
        const DIVIDER: u32 = (APB1_HZ + BAUD / 2) / BAUD;
        let set = const { ((DIVIDER >> 4) as u16, (DIVIDER & 15) as u8) };
        port.brr().write(|w| w.div_mantissa().set(set.0).div_fraction().set(set.1));
        port.cr3().write(|w| w.dmar().enabled());
        let serial = Self { port, dma: &p.DMA1, next: 0 };
        serial.set_up_ring();
        port.cr1().write(|w| w.ue().enabled().te().enabled().re().enabled());
        serial
    }

    fn set_up_ring(&self) {
        let stream = self.dma.st(STREAM);
        // SAFETY: a register that DMA may read at any time.
        stream.par().write(|w| unsafe { w.pa().bits(self.port.dr().as_ptr() as u32) });
        // SAFETY: bytes that live for ever and are atomic.
        stream.m0ar().write(|w| unsafe { w.m0a().bits(RING.as_ptr() as u32) });
        stream.ndtr().write(|w| w.ndt().set(const { RING_BYTES as u16 }));
        stream.cr().write(|w| {
            w.chsel().set(CHANNEL).circ().enabled().dir().peripheral_to_memory();
            w.msize().bits8().psize().bits8().minc().incremented().pinc().fixed();
            w.en().enabled()
        });
    }

    /// Place in the ring of the next byte to be received.
    fn received(&self) -> usize {
        let left = usize::from(self.dma.st(STREAM).ndtr().read().ndt().bits());
        RING_BYTES.saturating_sub(left) % RING_BYTES
    }

    /// Sends bytes until the line does not take one.
    pub fn send(&self, mut bytes: impl Iterator<Item = u8>) -> Result<(), TimedOut> {
        bytes.try_for_each(|byte| {
            until(BYTE_POLLS, || self.port.sr().read().txe().bit())?;
            self.port.dr().write(|w| w.dr().set(u16::from(byte)));
            Ok(())
        })
    }
}

impl ErrorType for Serial {
    type Error = ErrorKind;
}

impl ReadReady for Serial {
    fn read_ready(&mut self) -> Result<bool, ErrorKind> {
        Ok(self.next != self.received())
    }
}

impl Read for Serial {
    fn read(&mut self, buf: &mut [u8]) -> Result<usize, ErrorKind> {
        let Some(slot) = buf.first_mut().filter(|_| self.next != self.received()) else {
            return Ok(0);
        };
        fence(Ordering::Acquire);
        let word = RING.get(self.next / 4).map_or(0, |word| word.load(Ordering::Relaxed));
        *slot = (word >> (8 * (self.next % 4))) as u8;
        self.next = (self.next + 1) % RING_BYTES;
        Ok(1)
    }
}

impl Write for Serial {
    fn write(&mut self, buf: &[u8]) -> Result<usize, ErrorKind> {
        let sent = self.send(buf.iter().copied());
        sent.map(|()| buf.len()).map_err(|TimedOut| ErrorKind::TimedOut)
    }

    fn flush(&mut self) -> Result<(), ErrorKind> {
        Ok(())
    }
}
