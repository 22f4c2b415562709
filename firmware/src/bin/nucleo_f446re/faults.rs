//! What nothing else catches: every path ends with torque off and brakes set.

use core::arch::naked_asm;
use core::panic::PanicInfo;

use cortex_m::asm;
use cortex_m_rt::exception;
use stm32f4::stm32f446::GPIOC;

/// Reset bits, in GPIOC's BSRR, of drive enables (4 to 7), brake releases (8 to 11) and STO (12).
const ALL_OFF: u32 = 0x1FF0 << 16;

/// Torque off, brakes set; the watchdogs do the rest. Needs no static and next to no stack.
pub extern "C" fn all_off() -> ! {
    // SAFETY: one store of a constant to a write-only register, right whatever else is broken.
    unsafe { (*GPIOC::PTR).bsrr().write(|w| w.bits(ALL_OFF)) };
    loop {
        asm::nop();
    }
}

/// After an overflow the stack pointer is outside RAM, so the stack is emptied first.
///
/// # Safety
/// For the vector table only.
#[unsafe(naked)]
// SAFETY: `cortex-m-rt` provides the symbol weakly, to be defined with this signature.
#[unsafe(no_mangle)]
unsafe extern "C" fn HardFault() -> ! {
    naked_asm!("ldr r0, =_stack_start", "msr msp, r0", "b {all_off}", all_off = sym all_off)
}

/// NMI, raised by the clock security system, and every vector that is not in use.
#[exception]
unsafe fn DefaultHandler(_number: i16) -> ! {
    all_off()
}

/// Linking fails where a panic can be reached, because nobody defines the symbol.
#[cfg(not(debug_assertions))]
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    // SAFETY: never called; an image with a call does not link.
    unsafe extern "C" {
        safe fn a_panic_is_reachable() -> !;
    }
    a_panic_is_reachable()
}

#[cfg(debug_assertions)]
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    all_off()
}
