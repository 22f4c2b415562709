//! What nothing else catches: every path ends with torque off and brakes set. What a reset leaves alone lies here too.

use core::arch::naked_asm;
use core::mem::MaybeUninit;
use core::panic::PanicInfo;

use cortex_m::asm;
use cortex_m::peripheral::SCB;
use cortex_m_rt::exception;
use shared::evidence::Image;
use shared::fault::Fault;
use stm32f4::stm32f446::{GPIOC, rcc};

/// Reset bits, in GPIOC's BSRR, of drive enables (4 to 7), brake releases (8 to 11) and STO (12).
const ALL_OFF: u32 = 0x1FF0 << 16;

/// Plain SRAM, which a reset of the system does not clear (RM0390 section 2.2); all of it that the start-up code
/// leaves alone.
#[unsafe(link_section = ".uninit.EVIDENCE")]
static mut EVIDENCE: MaybeUninit<Image> = MaybeUninit::uninit();

unsafe extern "C" {
    /// Lowest word of the stack region, by `memory.x`.
    static _stack_end: u32;
}

/// What was kept; anything at power-up.
///
/// # Safety
/// To be called once.
pub unsafe fn evidence() -> &'static mut Image {
    let kept = &raw mut EVIDENCE;
    // SAFETY: any bytes are an image, and the caller has the only reference.
    unsafe { (*kept).assume_init_mut() }
}

/// Whether the last run ended because a tick did not: its watchdog reset the chip (RM0390 section 6.3.21, RCC_CSR).
pub fn hung(rcc: &rcc::RegisterBlock) -> Option<Fault> {
    let by_watchdog = rcc.csr().read().wdgrstf().bit_is_set();
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    by_watchdog.then_some(Fault::TickHung)
}

/// Torque off, brakes set.
fn switch_off() {
    // SAFETY: one store of a constant to a write-only register, right whatever else is broken.
    unsafe { (*GPIOC::PTR).bsrr().write(|w| w.bits(ALL_OFF)) };
}

/// Torque off, brakes set; the watchdogs do the rest. Needs no static and next to no stack.
pub extern "C" fn all_off() -> ! {
    switch_off();
    loop {
        asm::nop();
    }
}

/// Switches off, keeps the cause and resets. With less stack left than one instruction stores at most, 64 bytes, it
/// had overflowed.
extern "C" fn crash(stack_pointer: u32) -> ! {
    switch_off();
    let spent = stack_pointer < (&raw const _stack_end as u32).wrapping_add(64);
    let fault = if spent { Fault::StackOverflow } else { Fault::HardFault };
    let image = (&raw mut EVIDENCE).cast::<Image>();
    // SAFETY: a register that may be read at any time, and words of a static that nobody else will use again.
    unsafe {
        (&raw mut (*image).crash_status).write_volatile((*SCB::PTR).cfsr.read());
        (&raw mut (*image).crash).write_volatile(fault as u32);
    }
    SCB::sys_reset()
}

/// After an overflow there is no stack left, so it is emptied first.
///
/// # Safety
/// For the vector table only.
#[unsafe(naked)]
// SAFETY: `cortex-m-rt` provides the symbol weakly, to be defined with this signature.
#[unsafe(no_mangle)]
unsafe extern "C" fn HardFault() -> ! {
    naked_asm!("mov r0, sp", "ldr r1, =_stack_start", "msr msp, r1", "b {crash}", crash = sym crash)
}

/// NMI, raised by the clock security system, and every vector that is not in use.
#[exception]
unsafe fn DefaultHandler(_number: i16) -> ! {
    crash(u32::MAX)
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
