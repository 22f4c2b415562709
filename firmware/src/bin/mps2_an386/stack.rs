//! The stack's guard and its high-water mark.

use core::arch::naked_asm;

use cortex_m::peripheral::MPU;

/// What an untouched word of stack holds.
const PAINT: u32 = 0xA5C3_5A3C;

/// The guard ends where the stack region begins and reaches this far down: no frame steps over it.
const GUARD_BYTES: u32 = 1 << 20;

unsafe extern "C" {
    /// Lowest word of the stack region, by `memory.x`.
    static _stack_end: u32;
    /// First word past it.
    static _stack_start: u32;
}

/// Makes an overflow fault, which it would not do by itself: the emulator drops writes below RAM silently.
pub fn guard() {
    let base = (&raw const _stack_end as u32).wrapping_sub(GUARD_BYTES);
    // SAFETY: the only use of these registers (Armv7-M ARM B3.5): region 0 of 2^20 bytes, without access and
    // execution; everything else as without an MPU, and hard faults run without it.
    unsafe {
        let mpu = &*MPU::PTR;
        // A region's base is a multiple of its size: 0x2000_0000 - 2^20 is.
        mpu.rbar.write(base | 1 << 4);
        mpu.rasr.write(1 << 28 | (GUARD_BYTES.trailing_zeros() - 1) << 1 | 1);
        mpu.ctrl.write(0b101);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// Paints what the caller's frames leave free: without a frame of its own, so that none is painted over.
#[unsafe(naked)]
pub extern "C" fn paint() {
    naked_asm!(
        "ldr r0, =_stack_end",
        "ldr r1, ={paint}",
        "0:",
        "cmp r0, sp",
        "bhs 1f",
        "str r1, [r0], #4",
        "b 0b",
        "1:",
        "bx lr",
        paint = const PAINT,
    )
}

/// Whether a fault with the stack pointer here, its exception frame included, means that the stack had run out: one
/// instruction stores up to 64 bytes at once.
pub fn is_spent(stack_pointer: u32) -> bool {
    stack_pointer < (&raw const _stack_end as u32).wrapping_add(64)
}

/// Bytes of stack that were ever touched.
pub fn high_water_bytes() -> u16 {
    let (mut word, top) = (&raw const _stack_end, &raw const _stack_start);
    // SAFETY: words of the stack region, read only.
    while word < top && unsafe { word.read_volatile() } == PAINT {
        // SAFETY: still within the region or one past it.
        word = unsafe { word.add(1) };
    }
    (top as usize).saturating_sub(word as usize) as u16
}
