//! What a reset leaves alone, and the way through a hard fault: outputs off, the cause kept, a reset.

use core::arch::naked_asm;
use core::mem::MaybeUninit;

use cortex_m::peripheral::SCB;
use shared::evidence::Image;
use shared::fault::Fault;

use crate::{Owned, link, stack};

/// Neither cleared nor initialised by the start-up code (cortex-m-rt, `.uninit`).
#[unsafe(link_section = ".uninit.EVIDENCE")]
static EVIDENCE: Owned<MaybeUninit<Image>> =
    Owned(core::cell::UnsafeCell::new(MaybeUninit::uninit()));

/// What was kept; anything at power-up.
///
/// # Safety
/// To be called once.
pub unsafe fn evidence() -> &'static mut Image {
    // SAFETY: any bytes are an image, and the caller has the only reference.
    unsafe { (*EVIDENCE.0.get()).assume_init_mut() }
}

/// What is kept now, for the harness to read.
pub fn kept() -> &'static [u8] {
    // SAFETY: read by idle between two ticks, which alone writes to it then.
    bytemuck::bytes_of(unsafe { (*EVIDENCE.0.get()).assume_init_ref() })
}

/// After an overflow there is no stack left, so it is emptied first.
///
/// # Safety
/// For the vector table only.
#[unsafe(naked)]
// SAFETY: `cortex-m-rt` provides the symbol weakly, to be defined with this signature.
#[unsafe(no_mangle)]
unsafe extern "C" fn HardFault() -> ! {
    naked_asm!("mov r0, sp", "ldr r1, =_stack_start", "msr msp, r1", "b {end}", end = sym end)
}

extern "C" fn end(stack_pointer: u32) -> ! {
    link::all_off();
    // SAFETY: a register that may be read at any time.
    let status = unsafe { (*SCB::PTR).cfsr.read() };
    let fault =
        if stack::is_spent(stack_pointer) { Fault::StackOverflow } else { Fault::HardFault };
    let image = EVIDENCE.0.get().cast::<Image>();
    // SAFETY: words of a static; whoever else uses it will not run again.
    unsafe {
        (&raw mut (*image).crash_status).write_volatile(status);
        (&raw mut (*image).crash).write_volatile(fault as u32);
    }
    link::report_fault(status);
    SCB::sys_reset()
}
