//! Absolute encoders (Renishaw RESOLUTE, BiSS-C unidirectional).

use embedded_hal::spi::SpiDevice;
use shared::wire::biss_c::{FRAME_BYTES, FrameError, Layout};

use super::SampleError;

/// A position that the encoder vouches for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample {
    /// Position code, counts; taken [`shared::wire::biss_c::LATCH_DELAY_S`] after the read's first clock edge.
    pub code: u32,
    /// Scale or reading window should be cleaned; the position is good.
    pub warning: bool,
}

impl From<FrameError> for SampleError {
    fn from(error: FrameError) -> Self {
        match error {
            FrameError::Framing => Self::Framing,
            FrameError::Crc => Self::Crc,
        }
    }
}

/// Reads one position in one transaction. The bus is in SPI mode 3 at
/// [`shared::wire::biss_c::MA_HZ`]; nothing is sent and there is no chip select.
#[inline(always)]
pub fn read<S: SpiDevice>(spi: &mut S, layout: &Layout) -> Result<Sample, SampleError> {
    let mut frame = [0; FRAME_BYTES];
    spi.read(&mut frame).map_err(|_| SampleError::Bus)?;
    let word = layout.decode(&frame)?;
    if word.error {
        return Err(SampleError::Device);
    }
    Ok(Sample { code: word.position, warning: word.warning })
}
