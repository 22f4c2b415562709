//! The tunnel to the harness: semihosting reads and writes on two FIFOs.
//!
//! What has no answer is collected and sent with the next thing that has one. All of this stands for wire
//! time on silicon; its functions lie in the section `.text.link`, which counts leave out.

mod serial;
mod wire;

use core::cell::UnsafeCell;

use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};
use cortex_m_semihosting::syscall;
use heapless::Vec;
use shared::pil::{self, Release};
use shared::telemetry::Record;

pub use serial::Serial;
pub use wire::{Level, Line, Tunnel};

use crate::{crash, stack};

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

#[inline(never)]
#[unsafe(link_section = ".text.link")]
fn put(handle: usize, bytes: &[u8]) {
    // SAFETY: SYS_WRITE takes handle, address and length; it returns what was not written.
    insist(unsafe { syscall!(WRITE, handle, bytes.as_ptr(), bytes.len()) } == 0);
}

/// Ends the emulation if the harness is gone.
#[inline(never)]
fn insist(is_there: bool) {
    if !is_there {
        debug::exit(EXIT_FAILURE);
        loop {
            cortex_m::asm::wfi();
        }
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
            let done = bytes.len() - left;
            let rest = bytes.get_mut(done..).unwrap_or_default();
            // SAFETY: SYS_READ takes handle, address and length; it returns what was not read.
            let missing = unsafe { syscall!(READ, self.to_board, rest.as_mut_ptr(), rest.len()) };
            insist(missing < left);
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
