//! Faults of frames on the bus.

use rand_distr::{Bernoulli, Distribution, Uniform};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};
use shared::arm::Arm;
use shared::wire::biss_c::{Layout, Word};
use shared::wire::{ads131m04, dac81404};

use super::{Injection, Kind};
use crate::bench::Device;

/// One injection that spoils frames.
#[derive(Clone, Debug)]
pub(super) struct FrameFault {
    injection: Injection,
    arm: Arm,
    generator: Xoshiro256PlusPlus,
    /// The frame under way was spoilt on its way to the device.
    spoilt: bool,
    /// Devices whose frames are lost in this tick.
    lost: Vec<Device>,
    /// Device, number of the frame in its tick, and answer while all was well.
    good: Vec<(Device, usize, Vec<u8>)>,
}

impl FrameFault {
    /// `None` where the injection is of another sort.
    pub fn new(injection: &Injection, arm: &Arm, seed: u64) -> Option<Self> {
        use Kind::{BitFlips, Burst, Dead, FrameLoss, Missing, Mutation, Repeat, Swap, Zeros};
        let of_frames = matches!(
            injection.kind,
            BitFlips | Burst | Dead | FrameLoss | Missing | Mutation | Repeat | Swap | Zeros
        );
        of_frames.then(|| Self {
            injection: *injection,
            arm: *arm,
            generator: Xoshiro256PlusPlus::seed_from_u64(seed),
            spoilt: false,
            lost: Vec::new(),
            good: Vec::new(),
        })
    }

    /// The device that gets the frames of `device`.
    pub fn route(&self, device: Device) -> Device {
        let Injection { kind: Kind::Swap, target, severity, .. } = self.injection else {
            return device;
        };
        let other = Device::Encoder(severity as usize - 1);
        let own = target.joints().map(Device::Encoder).next();
        match own {
            Some(own) if device == own => other,
            Some(own) if device == other => own,
            _ => device,
        }
    }

    /// Whether the frame with this number in its tick is lost. A device loses all its frames of a tick, or
    /// none: what the bus driver starts is the whole exchange.
    pub fn loses(&mut self, device: Device, frame: usize) -> bool {
        let severity = self.injection.severity;
        match self.injection.kind {
            _ if !self.hits(device) => false,
            Kind::Dead => severity == 2.0,
            Kind::FrameLoss => {
                if frame == 0 {
                    self.lost.retain(|lost| *lost != device);
                    let lost = self.happens(severity).then_some(device);
                    self.lost.extend(lost);
                }
                self.lost.contains(&device)
            }
            _ => false,
        }
    }

    /// Spoils what is sent.
    pub fn spoil_request(&mut self, device: Device, mosi: &mut [u8]) {
        let flips = matches!(self.injection.kind, Kind::BitFlips | Kind::Burst);
        self.spoilt = flips && device == Device::Dac && self.hits(device) && self.happens(0.5);
        if self.spoilt {
            self.flip(mosi);
        }
    }

    /// Spoils what comes back as the frame with this number in its tick.
    pub fn spoil_answer(&mut self, device: Device, frame: usize, miso: &mut [u8]) {
        if !self.hits(device) {
            return;
        }
        match self.injection.kind {
            Kind::BitFlips | Kind::Burst if !self.spoilt => self.flip(miso),
            Kind::Mutation => self.mutate(device, miso),
            Kind::Repeat => self.repeat(device, frame, miso),
            Kind::Dead if self.injection.severity == 0.0 => miso.fill(0),
            Kind::Dead | Kind::Missing => miso.fill(0xFF),
            Kind::Zeros => replace_codes(miso, |_| 0),
            _ => {}
        }
    }

    /// Sees an answer while the fault is not there yet.
    pub fn keep(&mut self, device: Device, frame: usize, miso: &[u8]) {
        if self.injection.kind != Kind::Repeat || !self.hits(device) {
            return;
        }
        match self.good.iter_mut().find(|(d, f, _)| (*d, *f) == (device, frame)) {
            Some((_, _, answer)) => miso.clone_into(answer),
            None => self.good.push((device, frame, miso.to_vec())),
        }
    }

    fn hits(&self, device: Device) -> bool {
        self.injection.target.hits(device)
    }

    fn happens(&mut self, share: f64) -> bool {
        Bernoulli::new(share).is_ok_and(|coin| coin.sample(&mut self.generator))
    }

    /// A whole number below `end`.
    fn below(&mut self, end: usize) -> usize {
        Uniform::new(0, end).map_or(0, |numbers| numbers.sample(&mut self.generator))
    }

    fn flip(&mut self, bytes: &mut [u8]) {
        let bits = 8 * bytes.len();
        let count = (self.injection.severity as usize).min(bits);
        let mut flipped = Vec::new();
        if self.injection.kind == Kind::Burst {
            let first = self.below(bits - count + 1);
            let last = first + count - 1;
            flipped.extend(
                (first..=last).filter(|bit| *bit == first || *bit == last || self.happens(0.5)),
            );
        } else {
            while flipped.len() < count {
                let bit = self.below(bits);
                if !flipped.contains(&bit) {
                    flipped.push(bit);
                }
            }
        }
        for bit in flipped {
            bytes[bit / 8] ^= 0x80 >> (bit % 8);
        }
    }

    fn mutate(&mut self, device: Device, miso: &mut [u8]) {
        let fits = self.happens(self.injection.severity);
        match device {
            Device::Encoder(j) => self.mutate_word(self.arm.encoders[j].bits, fits, miso),
            Device::Adc if fits => {
                replace_codes(miso, |_| self.generator.next_u32() as i32 >> 8);
            }
            Device::Dac if fits => self.mutate_echo(miso),
            Device::Adc | Device::Dac => self.generator.fill_bytes(miso),
        }
    }

    fn mutate_word(&mut self, bits: u32, fits: bool, miso: &mut [u8]) {
        let Some(layout) = Layout::new(bits) else { return };
        let random = self.generator.next_u64();
        let [error, warning] = [40, 41].map(|bit| !fits && random >> bit & 1 != 0);
        let frame = layout.encode(Word { position: random as u32, error, warning });
        let crc = if fits { 0 } else { random >> 32 & 0x3F };
        let frame = u64::from_be_bytes(frame) ^ crc << (32 - bits);
        overwrite(miso, &frame.to_be_bytes());
    }

    fn mutate_echo(&mut self, miso: &mut [u8]) {
        if let Some(&bytes) = miso.first_chunk()
            && let Some(answer) = dac81404::Answer::from_bytes(bytes)
        {
            let data = self.generator.next_u32() as u16;
            overwrite(miso, &dac81404::Answer { data, ..answer }.to_bytes());
        }
    }

    fn repeat(&mut self, device: Device, frame: usize, miso: &mut [u8]) {
        let good = self.good.iter().find(|(d, f, _)| (*d, *f) == (device, frame));
        if let Some((_, _, answer)) = good {
            overwrite(miso, answer);
        }
    }
}

fn overwrite(miso: &mut [u8], bytes: &[u8]) {
    for (slot, byte) in miso.iter_mut().zip(bytes) {
        *slot = *byte;
    }
}

/// Gives a frame of the torque converter other codes and the check sum that fits them.
fn replace_codes(miso: &mut [u8], code: impl FnMut(i32) -> i32) {
    if let Some(bytes) = miso.first_chunk()
        && let Ok(frame) = ads131m04::decode(bytes)
    {
        let codes = frame.codes.map(code);
        overwrite(miso, &ads131m04::encode(&ads131m04::Frame { codes, ..frame }));
    }
}

#[cfg(test)]
mod tests;
