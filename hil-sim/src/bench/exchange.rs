//! Frames between the controller and the chips.

use embedded_hal::spi;
use shared::wire::biss_c::LATCH_DELAY_S;

use super::{Bench, Device, Event, Motion};
use crate::faults::Interference;

impl Bench {
    /// One chip-select frame.
    ///
    /// # Errors
    /// Where the frame was lost on the bus.
    pub fn transfer(
        &mut self,
        device: Device,
        mosi: &[u8],
        miso: &mut [u8],
    ) -> Result<(), spi::ErrorKind> {
        let result = self.carry(device, mosi, miso);
        if let Some(noise) = &mut self.noise {
            noise.disturb(miso);
        }
        if let Some(traffic) = &mut self.traffic {
            let received = if result.is_ok() { miso.to_vec() } else { Vec::new() };
            traffic.push(Event::Transfer { device, mosi: mosi.to_vec(), miso: received });
        }
        result
    }

    /// The frame and its answer, through whatever faults there may be.
    fn carry(
        &mut self,
        device: Device,
        mosi: &[u8],
        miso: &mut [u8],
    ) -> Result<(), spi::ErrorKind> {
        if let Some(interference) = self.interference.take() {
            return self.carry_through(interference, device, mosi, miso);
        }
        match device {
            Device::Encoder(j) => {
                let q = self.latched(j, 0.0);
                self.encoders[j].transfer(q, miso);
                self.cursor_s += self.skew_s;
            }
            Device::Adc => self.adc.transfer(mosi, miso),
            Device::Dac => self.dac.transfer(mosi, miso),
        }
        Ok(())
    }

    /// Where joint `j` is when its head latches, this much later than it should, rad or m.
    fn latched(&self, j: usize, later_s: f64) -> f64 {
        let Motion { q, qd, qdd } = &self.motion;
        let t = self.cursor_s + LATCH_DELAY_S + later_s;
        q[j] + t * (qd[j] + 0.5 * t * qdd[j])
    }

    #[cold]
    #[inline(never)]
    fn carry_through(
        &mut self,
        mut interference: Box<Interference>,
        device: Device,
        mosi: &[u8],
        miso: &mut [u8],
    ) -> Result<(), spi::ErrorKind> {
        let mut result = Ok(());
        match interference.pass_on(device, mosi) {
            Some((Device::Encoder(j), _)) => {
                let q = self.latched(j, interference.latch_shift_s(j));
                let code = interference.code(j, self.encoders[j].code(q));
                self.encoders[j].answer(code, miso);
            }
            // Without interference now.
            Some((at, mosi)) => result = self.carry(at, &mosi, miso),
            None => result = Err(spi::ErrorKind::Other),
        }
        if matches!(device, Device::Encoder(_)) {
            self.cursor_s += self.skew_s;
        }
        if result.is_ok() {
            interference.spoil_answer(device, miso);
        }
        self.interference = Some(interference);
        result
    }
}
