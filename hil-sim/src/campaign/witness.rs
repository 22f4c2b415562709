//! What really crossed the bus, tick by tick, whatever the controller made of it.

use shared::arm::{Arm, JOINTS};
use shared::wire::ads131m04;
use shared::wire::biss_c::Layout;

use crate::bench::{Device, Event};

/// Index of the torque converter among the devices.
pub const ADC: usize = JOINTS;
/// Index of the DAC among the devices.
pub const DAC: usize = JOINTS + 1;

/// One tick's traffic.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// One bit a device of which a frame was lost.
    pub lost: u8,
    /// Codes of the encoders whose frames are sound and bear no error bit.
    pub codes: [Option<u32>; JOINTS],
    /// Codes of the torque converter, if its frame is sound.
    pub torque: Option<[i32; JOINTS]>,
}

/// Reads the traffic of one tick.
#[derive(Clone, Debug)]
pub struct Witness {
    layouts: [Option<Layout>; JOINTS],
}

impl Witness {
    /// Of an arm's encoders.
    pub fn new(arm: &Arm) -> Self {
        Self { layouts: arm.encoders.map(|encoder| Layout::new(encoder.bits)) }
    }

    /// What `traffic` shows.
    pub fn see(&self, traffic: &[Event]) -> Seen {
        let mut seen = Seen::default();
        for event in traffic {
            let Event::Transfer { device, miso, .. } = event else { continue };
            match *device {
                _ if miso.is_empty() => seen.lost |= 1 << index(*device),
                Device::Encoder(j) => seen.codes[j] = self.code(j, miso),
                Device::Adc => seen.torque = torque(miso),
                Device::Dac => {}
            }
        }
        seen
    }

    fn code(&self, j: usize, miso: &[u8]) -> Option<u32> {
        let word = self.layouts[j]?.decode(miso.first_chunk()?).ok()?;
        (!word.error).then_some(word.position)
    }
}

fn torque(miso: &[u8]) -> Option<[i32; JOINTS]> {
    ads131m04::decode(miso.first_chunk()?).ok().map(|frame| frame.codes)
}

fn index(device: Device) -> usize {
    match device {
        Device::Encoder(j) => j,
        Device::Adc => ADC,
        Device::Dac => DAC,
    }
}

#[cfg(test)]
mod tests {
    use shared::arm::REFERENCE;
    use shared::wire::biss_c::Word;

    use super::*;

    #[test]
    fn sound_spoilt_and_lost_frames_are_told_apart() {
        let witness = Witness::new(&REFERENCE);
        let layout = Layout::new(26).expect("a width");
        let frame = |error| layout.encode(Word { position: 77, error, warning: false }).to_vec();
        let transfer = |j, miso| Event::Transfer { device: Device::Encoder(j), mosi: vec![], miso };
        let mut spoilt = frame(false);
        spoilt[3] ^= 1;
        let traffic = [
            transfer(0, frame(false)),
            transfer(1, spoilt),
            transfer(2, frame(true)),
            transfer(3, vec![]),
        ];
        let seen = witness.see(&traffic);
        assert_eq!(seen.codes, [Some(77), None, None, None]);
        assert_eq!((seen.lost, seen.torque), (0b1000, None));
    }
}
