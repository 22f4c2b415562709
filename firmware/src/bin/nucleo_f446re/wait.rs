//! Waiting for the hardware, never longer than a number of polls.

use embedded_hal::spi;

/// The hardware did not get there in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimedOut;

impl spi::Error for TimedOut {
    fn kind(&self) -> spi::ErrorKind {
        spi::ErrorKind::Other
    }
}

/// Polls `done` at most `polls` times; a poll takes about ten core clocks.
#[inline(always)]
pub fn until(polls: u32, mut done: impl FnMut() -> bool) -> Result<(), TimedOut> {
    if (0..polls).any(|_| done()) { Ok(()) } else { Err(TimedOut) }
}
