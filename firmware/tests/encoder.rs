//! The encoder driver against a mocked bus.

use embedded_hal::spi::{ErrorKind, ErrorType, Operation, SpiDevice};
use embedded_hal_mock::eh1::spi::{Mock, Transaction};
use firmware::drivers::SampleError;
use firmware::drivers::encoder::{Sample, read};
use shared::wire::biss_c::Layout;

const LAYOUT: Layout = Layout::new(32).unwrap();

fn read_of(frame: u64) -> Result<Sample, SampleError> {
    let mut spi = Mock::new(&[
        Transaction::transaction_start(),
        Transaction::read_vec(frame.to_be_bytes().to_vec()),
        Transaction::transaction_end(),
    ]);
    let sample = read(&mut spi, &LAYOUT);
    spi.done();
    sample
}

#[test]
fn one_transaction_yields_the_code() {
    assert_eq!(read_of(0xC000_0212_3456_78C5), Ok(Sample { code: 0x1234_5678, warning: false }));
}

#[test]
fn a_warning_does_not_spoil_the_code() {
    // Clearing the warning bit adds x⁶ to the codeword, whose remainder is x + 1.
    let frame = 0xC000_0212_3456_78C5 ^ 0x40 ^ 0x03;
    assert_eq!(read_of(frame), Ok(Sample { code: 0x1234_5678, warning: true }));
}

#[test]
fn the_error_bit_refuses_the_code() {
    assert_eq!(read_of(0xC000_0212_3456_7843), Err(SampleError::Device));
}

#[test]
fn a_spoilt_error_bit_is_a_crc_error() {
    assert_eq!(read_of(0xC000_0212_3456_7845), Err(SampleError::Crc));
}

#[test]
fn a_dead_line_is_a_framing_error() {
    assert_eq!(read_of(0), Err(SampleError::Framing));
    assert_eq!(read_of(u64::MAX), Err(SampleError::Framing));
}

struct DeadBus;

impl ErrorType for DeadBus {
    type Error = ErrorKind;
}

impl SpiDevice for DeadBus {
    fn transaction(&mut self, _: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        Err(ErrorKind::Other)
    }
}

#[test]
fn a_failing_bus_is_named() {
    assert_eq!(read(&mut DeadBus, &LAYOUT), Err(SampleError::Bus));
}
