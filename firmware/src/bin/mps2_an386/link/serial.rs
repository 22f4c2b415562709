//! The operator link through the tunnel, as a serial port's driver would offer it.

use core::convert::Infallible;

use embedded_io::{ErrorType, Read, ReadReady, Write};
use heapless::Deque;
use shared::pil::{self, LINK_BYTES, Release};

use super::with;

/// See the module's documentation.
pub struct Serial {
    /// Received, not yet read.
    received: Deque<u8, { 2 * LINK_BYTES }>,
}

impl Serial {
    /// Nothing has come yet.
    pub const fn new() -> Self {
        Self { received: Deque::new() }
    }

    /// Takes what came with a release.
    #[inline(never)]
    #[unsafe(link_section = ".text.link")]
    pub fn receive(&mut self, release: &Release) {
        for byte in release.link() {
            // The harness sends no more than there is room for.
            let _ = self.received.push_back(*byte);
        }
    }
}

impl ErrorType for Serial {
    type Error = Infallible;
}

impl Read for Serial {
    fn read(&mut self, buf: &mut [u8]) -> Result<usize, Infallible> {
        let next = buf.first_mut().zip(self.received.pop_front());
        Ok(next.map_or(0, |(slot, byte)| {
            *slot = byte;
            1
        }))
    }
}

impl ReadReady for Serial {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(!self.received.is_empty())
    }
}

impl Write for Serial {
    #[inline(never)]
    #[unsafe(link_section = ".text.link")]
    fn write(&mut self, buf: &[u8]) -> Result<usize, Infallible> {
        let piece = buf.get(..usize::from(u8::MAX)).unwrap_or(buf);
        with(|link| {
            link.post(&[pil::TAG_LINK, piece.len() as u8]);
            link.post(piece);
        });
        Ok(piece.len())
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}
