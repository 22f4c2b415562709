//! A device's line, on which the frame that is to be hit is damaged.

use std::cell::RefCell;

use shared::arm::REFERENCE;
use shared::wire::biss_c::{self, Layout, Word};

use super::{ADC, DAC, NEAR};
use crate::fuzz::damage::{Damage, Device, Sort};
use crate::rig::Way;

const SORTS: [Sort; 4] = [Sort::Flips, Sort::Burst, Sort::Any, Sort::Any];

/// One frame to be damaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Hit {
    /// Its number among the device's frames of the tick.
    pub frame: usize,
    pub way: Way,
    /// Index of [`SORTS`].
    pub sort: usize,
    /// How far a near position is off, counts.
    pub near: i32,
}

/// One device's line in one tick.
#[derive(Debug, Default)]
pub(super) struct Tap {
    pub hit: Option<Hit>,
    pub frames: [usize; 2],
    /// Last frame from the device, as it sent it.
    pub sent: Vec<u8>,
    /// The frame that was hit, before and after.
    pub changed: Option<(Vec<u8>, Vec<u8>)>,
}

impl Tap {
    /// Takes note of a frame, and damages it if it is the one.
    pub fn pass(&mut self, device: usize, way: Way, bytes: &mut [u8], damage: &RefCell<Damage>) {
        let frame = &mut self.frames[way as usize];
        let number = *frame;
        *frame += 1;
        if way == Way::In {
            self.sent = bytes.to_vec();
        }
        let Some(hit) = self.hit.filter(|hit| (hit.frame, hit.way) == (number, way)) else {
            return;
        };
        let before = bytes.to_vec();
        if hit.sort == NEAR {
            shift(REFERENCE.encoders[device].bits, hit.near, bytes);
        } else {
            let kind = match device {
                ADC => Device::Adc,
                DAC => Device::Dac,
                j => Device::Encoder(REFERENCE.encoders[j].bits),
            };
            damage.borrow_mut().inflict(SORTS[hit.sort], kind, bytes);
        }
        self.changed = Some((before, bytes.to_vec()));
    }
}

/// Gives an encoder's frame a position this far away, and the check sum that fits.
fn shift(bits: u32, counts: i32, bytes: &mut [u8]) {
    let layout = Layout::new(bits).expect("a width that a head has");
    let frame: &mut [u8; biss_c::FRAME_BYTES] = bytes.try_into().expect("a whole frame");
    let word = layout.decode(frame).expect("as a head sends it");
    let position = word.position.wrapping_add_signed(counts);
    *frame = layout.encode(Word { position, ..word });
}
