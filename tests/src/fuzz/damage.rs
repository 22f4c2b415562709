//! Damage to frames of the bus: sorts that every check must find, and what is beyond them.

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};
use shared::wire::biss_c::{self, Layout, Word};
use shared::wire::{ads131m04, dac81404};

/// Sort of damage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sort {
    /// One or two flipped bits.
    Flips,
    /// A burst no longer than the CRC.
    Burst,
    /// Random contents where a bit can have either level: the CRC alone tells.
    Any,
}

/// What frames there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Device {
    /// An encoder of this width, bits.
    Encoder(u32),
    /// Torque converter.
    Adc,
    /// DAC, in either direction.
    Dac,
}

impl Device {
    /// Bits of its CRC.
    pub fn crc_bits(self) -> u32 {
        match self {
            Self::Encoder(_) => 6,
            Self::Adc => 16,
            Self::Dac => 8,
        }
    }

    /// Bits that have but one right level, ones over a frame.
    fn fixed(self) -> Vec<u8> {
        match self {
            Self::Encoder(bits) => {
                let tail = 32 - bits;
                (!0_u64 << 40 | ((1 << tail) - 1)).to_be_bytes().to_vec()
            }
            Self::Adc => {
                let mut fixed = vec![0; ads131m04::FRAME_BYTES];
                (fixed[2], fixed[ads131m04::FRAME_BYTES - 1]) = (0xFF, 0xFF);
                fixed
            }
            Self::Dac => vec![0; 4],
        }
    }

    /// A frame like those of the running arm, with these random contents.
    fn frame(self, random: &mut Xoshiro256PlusPlus) -> Vec<u8> {
        let word = random.next_u64();
        match self {
            Self::Encoder(bits) => {
                let layout = Layout::new(bits).expect("a width that a head has");
                layout.encode(Word { position: word as u32, error: false, warning: false }).into()
            }
            Self::Adc => {
                let codes = std::array::from_fn(|_| random.next_u32() as i32 >> 8);
                ads131m04::encode(&ads131m04::Frame { response: word as u16, codes }).into()
            }
            Self::Dac => {
                let address = (word >> 16) as u8 & 0x3F;
                let answer = dac81404::Answer { address, data: word as u16, ..Default::default() };
                answer.to_bytes().into()
            }
        }
    }

    /// Whether its check takes the frame.
    fn takes(self, bytes: &[u8]) -> bool {
        match self {
            Self::Encoder(bits) => {
                let layout = Layout::new(bits).expect("a width that a head has");
                let frame: &[u8; biss_c::FRAME_BYTES] = bytes.try_into().expect("a whole frame");
                layout.decode(frame).is_ok()
            }
            Self::Adc => ads131m04::decode(bytes.try_into().expect("a whole frame")).is_ok(),
            Self::Dac => {
                dac81404::Answer::from_bytes(bytes.try_into().expect("a whole frame")).is_some()
            }
        }
    }
}

/// A source of damage.
#[derive(Clone, Debug)]
pub struct Damage {
    random: Xoshiro256PlusPlus,
}

impl Damage {
    /// The same for the same seed.
    pub fn new(seed: u64) -> Self {
        Self { random: Xoshiro256PlusPlus::seed_from_u64(seed) }
    }

    /// A whole number below `limit`.
    pub fn below(&mut self, limit: usize) -> usize {
        (self.random.next_u64() % limit as u64) as usize
    }

    /// Does this to a frame of `device`; at least one bit is another afterwards.
    pub fn inflict(&mut self, sort: Sort, device: Device, bytes: &mut [u8]) {
        let before = bytes.to_vec();
        while *bytes == *before {
            match sort {
                Sort::Flips => (0..=self.below(2)).for_each(|_| self.flip_any(bytes)),
                Sort::Burst => self.burst(device.crc_bits() as usize, bytes),
                Sort::Any => self.replace(&device.fixed(), bytes),
            }
        }
    }

    fn flip_any(&mut self, bytes: &mut [u8]) {
        let bit = self.below(8 * bytes.len());
        flip(bytes, bit);
    }

    /// Both ends of a burst are flipped, what is between them may be.
    fn burst(&mut self, longest: usize, bytes: &mut [u8]) {
        let length = 1 + self.below(longest);
        let first = self.below(8 * bytes.len() - length + 1);
        let inner = self.random.next_u32();
        for i in 0..length {
            if i == 0 || i == length - 1 || inner >> i & 1 != 0 {
                flip(bytes, first + i);
            }
        }
    }

    fn replace(&mut self, fixed: &[u8], bytes: &mut [u8]) {
        for (byte, fixed) in bytes.iter_mut().zip(fixed) {
            *byte = *byte & fixed | self.random.next_u32() as u8 & !fixed;
        }
    }
}

fn flip(bytes: &mut [u8], bit: usize) {
    bytes[bit / 8] ^= 0x80 >> (bit % 8);
}

/// How many of `count` damaged frames the device's check takes.
pub fn taken(sort: Sort, device: Device, count: u64, seed: u64) -> u64 {
    let mut damage = Damage::new(seed);
    let passes = (0..count).filter(|_| {
        let mut bytes = device.frame(&mut damage.random);
        damage.inflict(sort, device, &mut bytes);
        device.takes(&bytes)
    });
    passes.count() as u64
}
