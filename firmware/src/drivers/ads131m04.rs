//! The torque converter ADS131M04 (TI SBAS890D), stepped by the tick: no call waits.
//!
//! A sample takes two frames, because the device buffers two conversions and hands out the older one
//! first (section 8.5.1.9.1). The first frame drains it and carries a register back, the second brings
//! the newest conversion with the status. After configuration the interface is locked: unlike the input
//! CRC, the lock also keeps corrupted register writes out (sections 8.3.12 and 8.5.1.10.5).

#[cfg(test)]
mod tests;

use super::{Progress, SampleError};
use embedded_hal::spi::SpiDevice;
use shared::wire::ads131m04::{
    self as wire, CODE_MAX, FRAME_BYTES, Frame, FrameError, clock, command, mode, register, status,
};

/// MODE: input CRC on, reset flag cleared, 24-bit words, CCITT CRC, data-ready as a level.
const MODE: u16 = mode::RX_CRC_EN | status::WLENGTH_24 | mode::TIMEOUT;

/// CLOCK: oversampling by 128, so 32 000 conversions a second at 8.192 MHz (Table 8-2): four a tick at
/// 8 kHz, which keeps both buffered conversions new whatever the two clocks' error.
const CLOCK: u16 = clock::CHANNELS | clock::HIGH_RESOLUTION;

/// CFG after reset: global chop and current detection off (Table 8-12).
const CFG: u16 = 0x0600;

/// Status of a healthy, configured device with new data on all channels.
const HEALTHY: u16 = status::LOCK | status::WLENGTH_24 | status::DRDY;

const NULL: [u8; FRAME_BYTES] = wire::request(command::NULL);

/// One frame of the boot: what is sent, and the answer due in it to the frame before.
struct Step {
    request: [u8; FRAME_BYTES],
    mask: u16,
    answer: u16,
}

const fn step(request: [u8; FRAME_BYTES], mask: u16, answer: u16) -> Step {
    Step { request, mask, answer }
}

/// Identifies, writes, reads back, locks. The conversions that come with the last three frames are
/// discarded, so the filter has settled (Table 8-3: 856 clocks, 105 us) before the boot ends.
static BOOT: [Step; 10] = [
    // Reset acknowledge and status after reset have these bits in common; a running device has not.
    step(
        wire::request(command::read(register::ID)),
        status::RESET | status::WLENGTH_24,
        status::RESET | status::WLENGTH_24,
    ),
    step(wire::write_request(register::MODE, MODE), 0xFF00, 0x2400),
    step(wire::write_request(register::CLOCK, CLOCK), !0, command::written(register::MODE)),
    step(wire::request(command::read(register::MODE)), !0, command::written(register::CLOCK)),
    step(wire::request(command::read(register::CLOCK)), !0, MODE),
    step(wire::request(command::LOCK), !0, CLOCK),
    step(NULL, !0, command::LOCK),
    step(NULL, !status::F_RESYNC, HEALTHY),
    step(NULL, !0, HEALTHY),
    step(READBACK[0].request, !0, HEALTHY),
];

/// A register that is read back in turn while running, and what it must hold.
struct Readback {
    request: [u8; FRAME_BYTES],
    content: u16,
}

const fn readback(address: u8, content: u16) -> Readback {
    Readback { request: wire::request(command::read(address)), content }
}

/// A power of two of registers, so that the turn is a mask.
static READBACK: [Readback; 4] = [
    readback(register::MODE, MODE),
    readback(register::CLOCK, CLOCK),
    readback(register::GAIN, 0),
    readback(register::CFG, CFG),
];

/// Read-backs in a row that must differ before the configuration counts as lost: repeated frames can
/// fake one or two.
const MISMATCHES: u8 = 3;

/// One conversion of all channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample {
    /// Conversions of channels 0 to 3; 2²³ codes are full scale (Equation 10).
    pub codes: [i32; 4],
    /// One bit a channel whose code is clipped at either rail.
    pub overrange: u8,
    /// The device refused a command because of its CRC; the conversion itself is good.
    pub command_refused: bool,
}

/// Driver state.
#[derive(Clone, Debug)]
pub struct Ads131m04 {
    progress: Progress,
    /// Row of the boot, then of the register that is due.
    turn: usize,
    /// How often in a row the register that is due was another than expected.
    mismatches: u8,
    codes: [i32; 4],
    status: u16,
}

impl Default for Ads131m04 {
    fn default() -> Self {
        Self::new()
    }
}

impl Ads131m04 {
    /// For a device that was reset by its pin at least 5 us ago (tREGACQ, section 6.7).
    pub const fn new() -> Self {
        Self { progress: Progress::Busy, turn: 0, mismatches: 0, codes: [0; 4], status: 0 }
    }

    /// Status word that came with the last conversion whose CRC matched, used or not.
    pub fn status(&self) -> u16 {
        self.status
    }

    /// Conversions of the last good sample.
    pub fn codes(&self) -> [i32; 4] {
        self.codes
    }

    /// Sends one frame of the boot; ten calls, at no more than 10 kHz so that the filter settles.
    #[inline(never)]
    pub fn boot_step(&mut self, spi: &mut impl SpiDevice) -> Progress {
        let (Progress::Busy, Some(step)) = (self.progress, BOOT.get(self.turn)) else {
            return self.progress;
        };
        let mut bytes = [0; FRAME_BYTES];
        let sent = spi.transfer(&mut bytes, &step.request).is_ok();
        self.turn += 1;
        self.progress = match wire::decode(&bytes) {
            Ok(frame) if sent && frame.response & step.mask == step.answer => {
                if self.turn == BOOT.len() { Progress::Ready } else { Progress::Busy }
            }
            _ => Progress::Failed,
        };
        if self.progress == Progress::Ready {
            self.turn = 0;
        }
        self.progress
    }

    /// Reads the newest conversion: two frames, 36 bytes.
    ///
    /// Errors: `Stale` if there was none since the last sample, if its codes are those of the last one
    /// (their noise makes that a repeated frame), or if the filters were restarted; `Device` if the
    /// device was reset, unlocked, or read back another configuration three times in a row; `Framing`
    /// if a frame went missing between the two or the word length changed.
    #[inline(always)]
    pub fn sample(&mut self, spi: &mut impl SpiDevice) -> Result<Sample, SampleError> {
        let mut older = [0; FRAME_BYTES];
        spi.transfer(&mut older, &NULL).map_err(|_| SampleError::Bus)?;
        let due = READBACK[self.turn % READBACK.len()].content;
        let following = self.turn.wrapping_add(1);
        // Seen by the device or not: a frame that it did not see leaves no register due.
        self.turn = following;
        let request = &READBACK[following % READBACK.len()].request;
        let mut newest = [0; FRAME_BYTES];
        spi.transfer(&mut newest, request).map_err(|_| SampleError::Bus)?;
        let frame = wire::decode(&newest)?;
        self.status = frame.response;

        let [r1, r0, ..] = older;
        let mut command_refused = false;
        if frame.response == HEALTHY && u16::from_be_bytes([r1, r0]) == due {
            self.mismatches = 0;
        } else {
            command_refused = self.diagnose(&older, frame.response, due)?;
        }
        let pairs = frame.codes.iter().zip(&self.codes);
        if pairs.fold(0, |changed, (new, last)| changed | (new ^ last)) == 0 {
            return Err(SampleError::Stale);
        }
        self.codes = frame.codes;
        Ok(Sample { codes: frame.codes, overrange: overrange(&frame.codes), command_refused })
    }

    /// Tells what an unexpected answer means; `Ok` says whether a command was refused.
    #[cold]
    #[inline(never)]
    fn diagnose(
        &mut self,
        older: &[u8; FRAME_BYTES],
        newest: u16,
        due: u16,
    ) -> Result<bool, SampleError> {
        const TRANSIENT: u16 = status::CRC_ERR | status::F_RESYNC | status::DRDY;
        // The register came one frame late, so the first frame never reached the device.
        if newest == due {
            return Err(SampleError::Framing);
        }
        let wrong = newest ^ HEALTHY;
        if wrong & !(TRANSIENT | status::WLENGTH) != 0 {
            let reset = wrong & (status::RESET | status::LOCK) != 0;
            return Err(if reset { SampleError::Reset } else { SampleError::Device });
        }
        if wrong & status::WLENGTH != 0 {
            return Err(SampleError::Framing);
        }
        // A frame that is damaged or holds the status reads nothing back, and that is no mismatch.
        let mut seen = newest;
        match wire::decode(older) {
            Ok(Frame { response, .. }) if response == due => self.mismatches = 0,
            Ok(Frame { response, .. }) if (response ^ HEALTHY) & !TRANSIENT == 0 => {
                seen |= response & (status::CRC_ERR | status::F_RESYNC);
            }
            Ok(_) => self.mismatches = self.mismatches.saturating_add(1),
            Err(_) => {}
        }
        if self.mismatches >= MISMATCHES {
            return Err(SampleError::Configuration);
        }
        if seen & status::F_RESYNC != 0 || wrong & status::DRDY != 0 {
            return Err(SampleError::Stale);
        }
        Ok(seen & status::CRC_ERR != 0)
    }
}

impl From<FrameError> for SampleError {
    fn from(error: FrameError) -> Self {
        match error {
            FrameError::Crc => Self::Crc,
            FrameError::Padding => Self::Framing,
        }
    }
}

/// Both rails at once: `c ^ (c >> 31)` folds the negative one onto the positive one.
fn overrange(codes: &[i32; 4]) -> u8 {
    let [a, b, c, d] = codes.map(|code| u8::from(code ^ (code >> 31) == CODE_MAX));
    a | b << 1 | c << 2 | d << 3
}
