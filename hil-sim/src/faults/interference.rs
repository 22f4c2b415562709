//! What stands between the bus and the chips while faults are to be expected there.

use shared::arm::{Arm, JOINTS};

use super::frames::FrameFault;
use super::samples::SampleFault;
use super::{Injection, seed_of};
use crate::bench::Device;

/// Faults of one scenario in frames and samples, each with its number among the injections.
#[derive(Clone, Debug)]
pub struct Interference {
    frames: Vec<(usize, FrameFault)>,
    samples: Vec<(usize, SampleFault)>,
    active: Vec<bool>,
    /// Frames in this tick so far: encoders, ADC, DAC.
    counts: [usize; JOINTS + 2],
}

impl Interference {
    /// `None` where nothing of the sort will be injected.
    pub fn of(injections: &[Injection], arm: &Arm, seed: u64) -> Option<Self> {
        let numbered = || injections.iter().enumerate();
        let frames = numbered()
            .filter_map(|(i, one)| Some((i, FrameFault::new(one, arm, seed_of(seed, i))?)))
            .collect::<Vec<_>>();
        let samples = numbered()
            .filter_map(|(i, one)| Some((i, SampleFault::new(one, arm, seed_of(seed, i))?)))
            .collect::<Vec<_>>();
        let any = !frames.is_empty() || !samples.is_empty();
        let active = vec![false; injections.len()];
        any.then_some(Self { frames, samples, active, counts: [0; JOINTS + 2] })
    }

    /// Lets the injection with this number begin or end.
    pub fn set_active(&mut self, injection: usize, active: bool) {
        self.active[injection] = active;
    }

    /// Frames are numbered anew.
    pub fn begin_tick(&mut self) {
        self.counts = [0; JOINTS + 2];
    }

    /// Takes the next frame to `device`: what reaches which chip; `None` where it is lost.
    pub fn pass_on(&mut self, device: Device, mosi: &[u8]) -> Option<(Device, Vec<u8>)> {
        let (mut at, mut mosi) = (device, mosi.to_vec());
        let frame = self.counts[index(device)];
        let mut lost = false;
        for (i, fault) in &mut self.frames {
            if self.active[*i] {
                at = fault.route(at);
                lost |= fault.loses(device, frame);
                fault.spoil_request(device, &mut mosi);
            }
        }
        if lost {
            self.counts[index(device)] += 1;
        }
        (!lost).then_some((at, mosi))
    }

    /// How much later than it should the head of joint `j` latches, s.
    pub fn latch_shift_s(&mut self, j: usize) -> f64 {
        let active = &self.active;
        let faults = self.samples.iter_mut().filter(|(i, _)| active[*i]);
        faults.map(|(_, fault)| fault.latch_shift_s(j)).sum()
    }

    /// What the head of joint `j` gives in place of `code`.
    pub fn code(&mut self, j: usize, code: u32) -> u32 {
        let mut spoilt = code;
        for (i, fault) in &mut self.samples {
            if self.active[*i] {
                spoilt = fault.code(j, spoilt);
            } else {
                fault.keep(j, code);
            }
        }
        spoilt
    }

    /// Spoils the answer to the frame that was passed on.
    pub fn spoil_answer(&mut self, device: Device, miso: &mut [u8]) {
        let count = &mut self.counts[index(device)];
        let frame = *count;
        *count += 1;
        for (i, fault) in &mut self.frames {
            if self.active[*i] {
                fault.spoil_answer(device, frame, miso);
            } else {
                fault.keep(device, frame, miso);
            }
        }
    }
}

fn index(device: Device) -> usize {
    match device {
        Device::Encoder(j) => j,
        Device::Adc => JOINTS,
        Device::Dac => JOINTS + 1,
    }
}
