//! The line between console and board, in memory; the board's end of it is an `embedded_io` stream.

use std::collections::VecDeque;
use std::convert::Infallible;

use embedded_io::{ErrorType, Read, ReadReady, Write};

/// See the module's documentation.
#[derive(Debug, Default)]
pub struct Line {
    to_board: VecDeque<u8>,
    to_console: Vec<u8>,
}

impl Line {
    /// Bytes on their way to the board.
    pub fn deliver(&mut self, bytes: &[u8]) {
        self.to_board.extend(bytes);
    }

    /// What the board has sent since this was last asked.
    pub fn take(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.to_console)
    }
}

impl ErrorType for Line {
    type Error = Infallible;
}

impl Read for Line {
    fn read(&mut self, buf: &mut [u8]) -> Result<usize, Infallible> {
        let taken = buf.len().min(self.to_board.len());
        for (slot, byte) in buf.iter_mut().zip(self.to_board.drain(..taken)) {
            *slot = byte;
        }
        Ok(taken)
    }
}

impl ReadReady for Line {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(!self.to_board.is_empty())
    }
}

impl Write for Line {
    fn write(&mut self, buf: &[u8]) -> Result<usize, Infallible> {
        self.to_console.extend(buf);
        Ok(buf.len())
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}
