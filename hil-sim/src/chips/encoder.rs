//! Absolute encoder (Renishaw RESOLUTE, BiSS-C unidirectional).
//!
//! Sources are those of [`shared::wire::biss_c`]. The sheet names no power-up behaviour, so the head answers
//! from the first request on.

use shared::arm::EncoderSpec;
use shared::wire::biss_c::{Layout, Word};

/// One encoder at the other end of an SPI port.
#[derive(Clone, Debug)]
pub struct Encoder {
    spec: EncoderSpec,
    layout: Layout,
    /// The head's own check has failed or it is too hot: it answers with its error bit active.
    pub failed: bool,
    /// Scale or reading window is dirty: the head answers with its warning bit active.
    pub dirty: bool,
}

impl Encoder {
    /// A healthy encoder; `None` where no head has that many bits.
    pub fn new(spec: EncoderSpec) -> Option<Self> {
        let layout = Layout::new(spec.bits)?;
        Some(Self { spec, layout, failed: false, dirty: false })
    }

    /// Position code at `q` (rad or m).
    pub fn code(&self, q: f64) -> u32 {
        let counts = ((q - self.spec.zero) / self.spec.lsb).round() as i64;
        counts as u32 & (u32::MAX >> (32 - self.spec.bits))
    }

    /// One read. `q_latched` is the position (rad or m) at the sampling moment,
    /// [`shared::wire::biss_c::LATCH_DELAY_S`] after the read's first clock edge.
    ///
    /// A shorter read is cut off and leaves no trace: stopping the clock resets the head. In a longer one SLO
    /// stays low, because the timeout waits for the clock to stop.
    pub fn transfer(&mut self, q_latched: f64, miso: &mut [u8]) {
        self.answer(self.code(q_latched), miso);
    }

    /// As [`Self::transfer`], with a position code as latched.
    pub fn answer(&self, code: u32, miso: &mut [u8]) {
        let word = Word { position: code, error: self.failed, warning: self.dirty };
        let frame = self.layout.encode(word).into_iter().chain(std::iter::repeat(0));
        for (slot, byte) in miso.iter_mut().zip(frame) {
            *slot = byte;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
    use firmware::drivers::SampleError;
    use firmware::drivers::encoder::{Sample, read};
    use proptest::prelude::*;
    use shared::arm::{Arm, JOINTS, REFERENCE};

    use super::*;

    /// An encoder held still at a position, as the firmware sees it.
    struct Port(Encoder, f64);

    impl ErrorType for Port {
        type Error = Infallible;
    }

    impl SpiDevice for Port {
        fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
            for operation in operations {
                match operation {
                    Operation::Read(miso) => self.0.transfer(self.1, miso),
                    other => unreachable!("the encoder is only read, not {other:?}"),
                }
            }
            Ok(())
        }
    }

    fn port(arm: &Arm, joint: usize, q: f64) -> Port {
        Port(Encoder::new(arm.encoders[joint]).unwrap(), q)
    }

    fn firmware_reads(port: &mut Port) -> Result<Sample, SampleError> {
        let layout = Layout::new(port.0.spec.bits).unwrap();
        read(port, &layout)
    }

    fn arms() -> impl Strategy<Value = Arm> {
        prop_oneof![
            Just(REFERENCE),
            Just(REFERENCE.with_encoders(20, 1e-6)),
            Just(REFERENCE.with_encoders(18, 50e-9)),
        ]
    }

    proptest! {
        /// Inside its range no joint wraps, so the code leads back to the position within half a count.
        #[test]
        fn firmware_reads_the_position(arm in arms(), joint in 0..JOINTS, share in 0.0..=1.0f64) {
            let limits = arm.limits[joint];
            let q = limits.q_min + share * (limits.q_max - limits.q_min);
            let mut port = port(&arm, joint, q);
            let sample = firmware_reads(&mut port).unwrap();
            let spec = arm.encoders[joint];
            let read_back = spec.zero + f64::from(sample.code) * spec.lsb;
            prop_assert!((read_back - q).abs() <= 0.5 * spec.lsb + 1e-14, "{} from {}", read_back, q);
            prop_assert!(!sample.warning);
        }

        #[test]
        fn a_turn_more_is_the_same_code(bits in prop_oneof![Just(20u32), Just(26)], count in 0u32..1 << 20, turns in -3..=3i32) {
            let spec = shared::arm::rotary(bits, -0.8);
            let encoder = Encoder::new(spec).unwrap();
            let q = spec.zero + f64::from(count) * spec.lsb + f64::from(turns) * std::f64::consts::TAU;
            prop_assert_eq!(encoder.code(q), count);
        }
    }

    #[test]
    fn rounds_to_the_nearest_count_and_wraps_below_zero() {
        let encoder = Encoder::new(shared::arm::linear(26, 1e-6, 2.5)).unwrap();
        assert_eq!(encoder.code(2.5 + 1.4e-6), 1);
        assert_eq!(encoder.code(2.5 + 1.6e-6), 2);
        assert_eq!(encoder.code(2.5 - 1e-6), (1 << 26) - 1);
    }

    #[test]
    fn error_and_warning_reach_the_firmware() {
        let mut port = port(&REFERENCE, 3, 4.0);
        port.0.dirty = true;
        let sample = firmware_reads(&mut port).unwrap();
        assert_eq!(sample, Sample { code: 30_000_000, warning: true });
        port.0.failed = true;
        assert_eq!(firmware_reads(&mut port), Err(SampleError::Device));
    }

    #[test]
    fn short_reads_are_cut_and_long_ones_end_low() {
        let mut encoder = Encoder::new(REFERENCE.encoders[0]).unwrap();
        let (mut whole, mut short, mut long) = ([0xA5; 8], [0xA5; 5], [0xA5; 11]);
        encoder.transfer(0.3, &mut whole);
        encoder.transfer(0.3, &mut short);
        encoder.transfer(0.3, &mut long);
        assert_eq!(short, whole[..5]);
        assert_eq!(long[..8], whole);
        assert_eq!(long[8..], [0; 3]);
    }

    #[test]
    fn widths_that_do_not_exist_are_refused() {
        assert!(Encoder::new(shared::arm::rotary(33, 0.0)).is_none());
    }
}
