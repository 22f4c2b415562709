//! The tunnel to the harness: semihosting reads and writes on two FIFOs.
//!
//! What has no answer is collected and sent with the next thing that has one. All of this stands for wire
//! time on silicon; its functions lie in the section `.text.link`, which counts leave out.

use core::cell::UnsafeCell;
use core::convert::Infallible;

use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};
use cortex_m_semihosting::syscall;
use embedded_hal::digital::{self, InputPin, OutputPin, PinState};
use embedded_hal::spi::{self, Operation, SpiDevice};
use embedded_io::{ErrorType, Read, ReadReady, Write};
use heapless::{Deque, Vec};
use shared::pil::{self, LINK_BYTES, Release, TRANSFER_MAX};
use shared::telemetry::Record;

use crate::{crash, defect, stack};

/// Semihosting open modes (Arm IHI 0069, SYS_OPEN): "rb" and "wb".
const MODE_READ: usize = 1;
const MODE_WRITE: usize = 5;

struct Link {
    to_harness: usize,
    to_board: usize,
    /// Collected, not yet sent.
    pending: Vec<u8, 256>,
    /// Input pins as of the last release.
    levels: u8,
}

struct Shared(UnsafeCell<Link>);

// SAFETY: idle uses it before SysTick starts and, between ticks, to send records; a tick begins only when
// the harness has that record, so the two never overlap.
unsafe impl Sync for Shared {}

static LINK: Shared =
    Shared(UnsafeCell::new(Link { to_harness: 0, to_board: 0, pending: Vec::new(), levels: 0 }));

fn with<R>(use_link: impl FnOnce(&mut Link) -> R) -> R {
    // SAFETY: see `Sync` above; no caller nests.
    use_link(unsafe { &mut *LINK.0.get() })
}

/// Opens both FIFOs; waits for the harness.
#[inline(never)]
#[unsafe(link_section = ".text.link")]
pub fn open() {
    with(|link| {
        link.to_harness = open_one(b"to-harness\0", MODE_WRITE);
        link.to_board = open_one(b"to-board\0", MODE_READ);
    });
}

fn open_one(name: &'static [u8], mode: usize) -> usize {
    // SAFETY: SYS_OPEN takes the address of a zero-terminated name, the mode and the name's length.
    unsafe { syscall!(OPEN, name.as_ptr(), mode, name.len() - 1) }
}

fn put(handle: usize, bytes: &[u8]) {
    // SAFETY: SYS_WRITE takes handle, address and length; it returns what was not written.
    if unsafe { syscall!(WRITE, handle, bytes.as_ptr(), bytes.len()) } != 0 {
        give_up();
    }
}

/// Ends the emulation: the harness is gone.
fn give_up() -> ! {
    debug::exit(EXIT_FAILURE);
    loop {
        cortex_m::asm::wfi();
    }
}

impl Link {
    /// Adds to what will be sent; sends first where there is no room.
    #[inline(never)]
    #[unsafe(link_section = ".text.link")]
    fn post(&mut self, bytes: &[u8]) {
        if self.pending.extend_from_slice(bytes).is_err() {
            self.flush();
            if self.pending.extend_from_slice(bytes).is_err() {
                put(self.to_harness, bytes);
            }
        }
    }

    #[inline(never)]
    #[unsafe(link_section = ".text.link")]
    fn flush(&mut self) {
        put(self.to_harness, &self.pending);
        self.pending.clear();
    }

    #[inline(never)]
    #[unsafe(link_section = ".text.link")]
    fn read(&mut self, bytes: &mut [u8]) {
        let mut left = bytes.len();
        while left > 0 {
            let Some(rest) = bytes.len().checked_sub(left).and_then(|done| bytes.get_mut(done..))
            else {
                give_up();
            };
            // SAFETY: SYS_READ takes handle, address and length; it returns what was not read.
            let missing = unsafe { syscall!(READ, self.to_board, rest.as_mut_ptr(), rest.len()) };
            if missing >= left {
                give_up();
            }
            left = missing;
        }
    }
}

/// Fills `bytes` from the harness.
#[inline(never)]
#[unsafe(link_section = ".text.link")]
pub fn receive(bytes: &mut [u8]) {
    with(|link| link.read(bytes));
}

/// Waits for the next tick's release.
#[inline(never)]
#[unsafe(link_section = ".text.link")]
pub fn await_release(release: &mut Release) {
    loop {
        receive(bytemuck::bytes_of_mut(release));
        match release.request {
            pil::RUN => break,
            pil::QUIT => {
                send_stack(stack::high_water_bytes());
                with(|link| put(link.to_harness, crash::kept()));
                debug::exit(EXIT_SUCCESS);
            }
            _ => halt(),
        }
    }
    with(|link| link.levels = release.levels);
}

/// The operator link, as a serial port's driver would offer it.
pub struct Serial {
    /// Received, not yet read.
    received: Deque<u8, { 2 * LINK_BYTES }>,
}

impl Serial {
    /// Nothing has come yet.
    pub const fn new() -> Self {
        Self { received: Deque::new() }
    }

    /// Takes what came with a release.
    #[inline(never)]
    #[unsafe(link_section = ".text.link")]
    pub fn receive(&mut self, release: &Release) {
        for byte in release.link() {
            // The harness sends no more than there is room for.
            let _ = self.received.push_back(*byte);
        }
    }
}

impl ErrorType for Serial {
    type Error = Infallible;
}

impl Read for Serial {
    fn read(&mut self, buf: &mut [u8]) -> Result<usize, Infallible> {
        let next = buf.first_mut().zip(self.received.pop_front());
        Ok(next.map_or(0, |(slot, byte)| {
            *slot = byte;
            1
        }))
    }
}

impl ReadReady for Serial {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(!self.received.is_empty())
    }
}

impl Write for Serial {
    #[inline(never)]
    #[unsafe(link_section = ".text.link")]
    fn write(&mut self, buf: &[u8]) -> Result<usize, Infallible> {
        let piece = buf.get(..usize::from(u8::MAX)).unwrap_or(buf);
        with(|link| {
            link.post(&[pil::TAG_LINK, piece.len() as u8]);
            link.post(piece);
        });
        Ok(piece.len())
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// A place for a debugger to stop the board at, while nothing is under way.
#[unsafe(naked)]
#[unsafe(link_section = ".text.link")]
// SAFETY: no other symbol has this name.
#[unsafe(no_mangle)]
extern "C" fn halt() {
    core::arch::naked_asm!("bx lr")
}

/// Tells the harness what the configuration became.
pub fn send_coefficients(pieces: [&[u8]; 2]) {
    let length: usize = pieces.iter().map(|piece| piece.len()).sum();
    let [low, high] = (length as u16).to_le_bytes();
    with(|link| {
        link.post(&[pil::TAG_COEFFICIENTS, low, high]);
        link.flush();
        for piece in pieces {
            put(link.to_harness, piece);
        }
    });
}

/// Tells the harness that the configuration was refused.
pub fn send_refusal() {
    with(|link| {
        link.post(&[pil::TAG_REFUSED]);
        link.flush();
    });
}

fn send_stack(used_bytes: u16) {
    let [low, high] = used_bytes.to_le_bytes();
    with(|link| put(link.to_harness, &[pil::TAG_STACK, low, high]));
}

/// Drives STO, drive enables and brake releases low; what was collected is lost.
pub fn all_off() {
    with(|link| put(link.to_harness, &pil::ALL_OFF));
}

/// Tells the harness what the fault status register says.
pub fn report_fault(status: u32) {
    let [a, b, c, d] = status.to_le_bytes();
    with(|link| put(link.to_harness, &[pil::TAG_FAULT, a, b, c, d]));
}

/// Closes a tick.
pub fn send_record(record: &Record) {
    let bytes = record.to_bytes();
    with(|link| {
        link.post(&[pil::TAG_RECORD]);
        link.post(&bytes);
        link.flush();
    });
}

/// One chip-select frame; what is sent and what comes back have the same length.
#[inline(never)]
#[unsafe(link_section = ".text.link")]
fn transfer(device: u8, mosi: &[u8], miso: &mut [u8]) -> Result<(), spi::ErrorKind> {
    if mosi.len() != miso.len() || mosi.len() > TRANSFER_MAX {
        return Err(spi::ErrorKind::Overrun);
    }
    with(|link| {
        link.post(&[pil::TAG_TRANSFER, device, mosi.len() as u8]);
        link.post(mosi);
        link.flush();
        let mut answer = [0; 1 + TRANSFER_MAX];
        link.read(answer.get_mut(..=miso.len()).ok_or(spi::ErrorKind::Overrun)?);
        let [failed, received @ ..] = answer;
        if failed != 0 {
            return Err(spi::ErrorKind::Other);
        }
        for (slot, byte) in miso.iter_mut().zip(received) {
            *slot = byte;
        }
        defect::in_sample(device, miso);
        Ok(())
    })
}

/// As [`transfer`], sending zeros.
#[inline(never)]
#[unsafe(link_section = ".text.link")]
fn read(device: u8, miso: &mut [u8]) -> Result<(), spi::ErrorKind> {
    let zeros = [0; TRANSFER_MAX];
    transfer(device, zeros.get(..miso.len()).ok_or(spi::ErrorKind::Overrun)?, miso)
}

/// As [`transfer`], dropping what comes back.
#[inline(never)]
#[unsafe(link_section = ".text.link")]
fn write(device: u8, mosi: &[u8]) -> Result<(), spi::ErrorKind> {
    let mut ignored = [0; TRANSFER_MAX];
    transfer(device, mosi, ignored.get_mut(..mosi.len()).ok_or(spi::ErrorKind::Overrun)?)
}

/// As [`transfer`], with what comes back in the place of what is sent.
#[inline(never)]
#[unsafe(link_section = ".text.link")]
fn transfer_in_place(device: u8, data: &mut [u8]) -> Result<(), spi::ErrorKind> {
    let mut buffer = [0; TRANSFER_MAX];
    let sent = buffer.get_mut(..data.len()).ok_or(spi::ErrorKind::Overrun)?;
    for (slot, byte) in sent.iter_mut().zip(data.iter()) {
        *slot = *byte;
    }
    transfer(device, sent, data)
}

#[inline(never)]
#[unsafe(link_section = ".text.link")]
fn post_pin(pin: u8, high: bool) {
    with(|link| link.post(&[pil::TAG_PIN, pin, u8::from(high)]));
}

#[inline(never)]
#[unsafe(link_section = ".text.link")]
fn level(bit: u8) -> bool {
    with(|link| link.levels >> (bit & 7) & 1 == 1)
}

/// A device on the tunnelled bus.
pub struct Tunnel(pub u8);

impl spi::ErrorType for Tunnel {
    type Error = spi::ErrorKind;
}

/// The drivers' calls are passed on directly, as a peripheral's driver would.
impl SpiDevice for Tunnel {
    /// Each operation is a chip-select frame of its own: the drivers use one a transaction.
    #[inline(always)]
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Self::Error> {
        for operation in operations {
            match operation {
                Operation::Read(data) => self.read(data)?,
                Operation::Write(data) => self.write(data)?,
                Operation::Transfer(read, write) => self.transfer(read, write)?,
                Operation::TransferInPlace(data) => self.transfer_in_place(data)?,
                Operation::DelayNs(_) => return Err(spi::ErrorKind::Other),
            }
        }
        Ok(())
    }

    #[inline(always)]
    fn read(&mut self, buf: &mut [u8]) -> Result<(), Self::Error> {
        read(self.0, buf)
    }

    #[inline(always)]
    fn write(&mut self, buf: &[u8]) -> Result<(), Self::Error> {
        write(self.0, buf)
    }

    #[inline(always)]
    fn transfer(&mut self, read: &mut [u8], write: &[u8]) -> Result<(), Self::Error> {
        transfer(self.0, write, read)
    }

    #[inline(always)]
    fn transfer_in_place(&mut self, buf: &mut [u8]) -> Result<(), Self::Error> {
        transfer_in_place(self.0, buf)
    }
}

/// A tunnelled output pin.
pub struct Line(pub u8);

impl digital::ErrorType for Line {
    type Error = digital::ErrorKind;
}

impl OutputPin for Line {
    #[inline(always)]
    fn set_low(&mut self) -> Result<(), Self::Error> {
        self.set_state(PinState::Low)
    }

    #[inline(always)]
    fn set_high(&mut self) -> Result<(), Self::Error> {
        self.set_state(PinState::High)
    }

    #[inline(always)]
    fn set_state(&mut self, state: PinState) -> Result<(), Self::Error> {
        post_pin(self.0, state == PinState::High);
        Ok(())
    }
}

/// An input pin as of the last release.
pub struct Level(pub u8);

impl digital::ErrorType for Level {
    type Error = digital::ErrorKind;
}

impl InputPin for Level {
    #[inline(always)]
    fn is_high(&mut self) -> Result<bool, Self::Error> {
        Ok(level(self.0))
    }

    #[inline(always)]
    fn is_low(&mut self) -> Result<bool, Self::Error> {
        Ok(!level(self.0))
    }
}
