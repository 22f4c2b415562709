//! A small image to try the measuring tools on: a SysTick tick of f32 work with loads, multiply-accumulates, a
//! division, a loop with a data-dependent exit and a link that stands for bytes on a wire, and a routine whose price
//! is counted by hand.
#![no_std]
#![no_main]

use core::ptr::{addr_of, addr_of_mut, read_volatile, write_volatile};
use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::peripheral::{SYST, syst::SystClkSource};
use cortex_m_rt::{entry, exception};
use cortex_m_semihosting::{debug, hio};

const TICKS: usize = 200;
const PAINT: u32 = 0xA5A5_A5A5;
const PAINTED_BYTES: u32 = 4096;

mod law {
    /// Sixteen rows of a product and a Newton iteration whose count depends on the data.
    pub fn step(a: &[[f32; 16]; 16], x: &mut [f32; 16]) -> f32 {
        let mut y = [0.0f32; 16];
        for (y, row) in y.iter_mut().zip(a) {
            let mut sum = 0.0;
            for (p, q) in row.iter().zip(x.iter()) {
                sum += p * q;
            }
            *y = sum;
        }
        let mut norm = 0.0;
        for (x, y) in x.iter_mut().zip(&y) {
            *x = *x + 0.125 * (*y - *x);
            norm += *x * *x;
        }
        root(norm)
    }

    fn root(v: f32) -> f32 {
        let mut r = 1.0;
        for _ in 0..20 {
            let next = 0.5 * (r + v / r);
            let d = next - r;
            r = next;
            if d * d < 1e-10 {
                break;
            }
        }
        r
    }
}

mod link {
    use core::ptr::{read_volatile, write_volatile};

    static mut WIRE: [u32; 8] = [0; 8];

    /// Pushes a word through eight volatile cells.
    pub fn send(word: u32) -> u32 {
        let wire = &raw mut WIRE;
        let mut w = word;
        for i in 0..8 {
            let cell = unsafe { (*wire).as_mut_ptr().add(i) };
            unsafe { write_volatile(cell, w ^ read_volatile(cell)) };
            // A device's register: the emulator cuts its translation here.
            let _ = cortex_m::peripheral::SYST::get_current();
            w = w.rotate_left(3);
        }
        super::mix(w)
    }
}

/// Called by the link and by the tick itself: whoever calls pays.
#[inline(never)]
fn mix(w: u32) -> u32 {
    let a = w.wrapping_mul(0x9E37_79B9);
    (a ^ (a >> 15)).wrapping_mul(0x85EB_CA6B)
}

struct State {
    a: [[f32; 16]; 16],
    x: [f32; 16],
    out: u32,
}

static mut STATE: State = State { a: [[0.01; 16]; 16], x: [1.0; 16], out: 0 };
static mut TIMES: [u32; TICKS] = [0; TICKS];
static DONE: AtomicU32 = AtomicU32::new(0);

core::arch::global_asm!(
    ".section .text.straight, \"ax\"",
    ".global straight",
    ".type straight, %function",
    ".thumb_func",
    "straight:",
    "push {{r4, lr}}",
    "movs r4, #3",
    "adds r4, r4, #1",
    "vmov s0, r4",
    "vadd.f32 s1, s0, s0",
    "vmla.f32 s1, s0, s0",
    "vdiv.f32 s2, s1, s0",
    "add.w r3, r0, #4",
    "ldr r1, [r3, #0]",
    "str r1, [r0, #8]",
    "udiv r2, r1, r4",
    "cbz r4, 1f",
    "b 1f",
    "nop",
    "1:",
    "pop {{r4, pc}}",
    ".size straight, . - straight",
);

unsafe extern "C" {
    fn straight(words: *mut u32);
}

#[inline(never)]
fn tick(s: &mut State, n: u32) {
    let norm = law::step(&s.a, &mut s.x);
    if n % 8 == 7 {
        s.x[0] += 100.0 / (n as f32);
    }
    s.out = link::send(norm.to_bits() ^ n);
    let mut words = [n; 4];
    unsafe { straight(words.as_mut_ptr()) };
    s.out ^= mix(words[2]);
}

#[exception]
fn SysTick() {
    let n = DONE.load(Ordering::Relaxed);
    if (n as usize) < TICKS {
        let start = SYST::get_current();
        tick(unsafe { &mut *addr_of_mut!(STATE) }, n);
        let end = SYST::get_current();
        unsafe { write_volatile(addr_of_mut!(TIMES).cast::<u32>().add(n as usize), start - end) };
        DONE.store(n + 1, Ordering::Relaxed);
    }
}

fn paint() {
    let mut p = cortex_m::register::msp::read() - 64;
    for _ in 0..PAINTED_BYTES / 4 {
        p -= 4;
        unsafe { write_volatile(p as *mut u32, PAINT) };
    }
}

fn lowest_touched() -> u32 {
    let mut p = cortex_m::register::msp::read() - 64 - PAINTED_BYTES;
    while unsafe { read_volatile(p as *const u32) } == PAINT {
        p += 4;
    }
    p
}

fn report(name: &str, value: u32) {
    let mut digits = *b"0000000000\n";
    let mut rest = value;
    for d in digits.iter_mut().take(10).rev() {
        *d += (rest % 10) as u8;
        rest /= 10;
    }
    if let Ok(mut out) = hio::hstdout() {
        let _ = out.write_all(name.as_bytes());
        let _ = out.write_all(&digits);
    }
}

// Handlers that never run: with a stack that cannot be bounded, with a jump table and a return under a condition, with
// an epilogue of several pops under a condition, and with pops of which a condition leaves some out.
static POINTER: AtomicU32 = AtomicU32::new(0);

#[exception]
fn PendSV() {
    let f: fn() = unsafe { core::mem::transmute(core::hint::black_box(POINTER.load(Ordering::Relaxed))) };
    f();
    DONE.store(0, Ordering::Relaxed);
}

core::arch::global_asm!(
    ".section .text.odd, \"ax\"",
    ".global SVCall, DebugMonitor, NonMaskableInt, UsageFault, MemoryManagement, BusFault",
    ".type UsageFault, %function",
    ".thumb_func",
    "UsageFault:",
    "sub sp, #8",
    "bx lr",
    ".size UsageFault, . - UsageFault",
    ".type NonMaskableInt, %function",
    ".thumb_func",
    "NonMaskableInt:",
    "push {{r4, lr}}",
    "cmp r0, #2",
    "bhi 3f",
    "tbb [pc, r0]",
    "0:",
    ".byte (1f - 0b) / 2",
    ".byte (2f - 0b) / 2",
    ".byte (3f - 0b) / 2",
    ".p2align 1",
    "1:",
    "sub sp, #16",
    "add sp, #16",
    "b 3f",
    "2:",
    "sub sp, #40",
    "add sp, #40",
    "3:",
    "cmp r1, #0",
    "it eq",
    "popeq {{r4, pc}}",
    "vpush {{d8, d9}}",
    "str r0, [sp, #-4]!",
    "ldr r0, [sp], #4",
    "vpop {{d8, d9}}",
    "pop {{r4, pc}}",
    ".size NonMaskableInt, . - NonMaskableInt",
    ".type SVCall, %function",
    ".thumb_func",
    "SVCall:",
    "push {{r4, lr}}",
    "mov r4, sp",
    "sub r4, r4, r0",
    "mov sp, r4",
    "pop {{r4, pc}}",
    ".size SVCall, . - SVCall",
    ".type DebugMonitor, %function",
    ".thumb_func",
    "DebugMonitor:",
    "push {{r7, lr}}",
    "bl DebugMonitor",
    "pop {{r7, pc}}",
    ".size DebugMonitor, . - DebugMonitor",
    ".type MemoryManagement, %function",
    ".thumb_func",
    "MemoryManagement:",
    "push {{r4, lr}}",
    "push.w {{r8, r9, r11}}",
    "cmp r0, #0",
    "itt eq",
    "popeq.w {{r8, r9, r11}}",
    "popeq {{r4, pc}}",
    "sub sp, #12",
    "add sp, #12",
    "pop.w {{r8, r9, r11}}",
    "pop {{r4, pc}}",
    ".size MemoryManagement, . - MemoryManagement",
    ".type BusFault, %function",
    ".thumb_func",
    "BusFault:",
    "push {{r4, lr}}",
    "push.w {{r8, r9, r11}}",
    "cmp r0, #0",
    "ite eq",
    "popeq.w {{r8, r9, r11}}",
    "popne {{r4, pc}}",
    "pop {{r4, pc}}",
    ".size BusFault, . - BusFault",
);

#[entry]
fn main() -> ! {
    paint();
    let mut syst = unsafe { cortex_m::Peripherals::steal() }.SYST;
    syst.set_clock_source(SystClkSource::Core);
    syst.set_reload(24_999);
    syst.clear_current();
    syst.enable_counter();
    syst.enable_interrupt();
    while (DONE.load(Ordering::Relaxed) as usize) < TICKS {}
    syst.disable_interrupt();
    let lowest = lowest_touched();
    report("stack ", 0x2040_0000 - lowest);
    for i in 0..TICKS {
        report("time ", unsafe { read_volatile(addr_of!(TIMES).cast::<u32>().add(i)) });
    }
    debug::exit(debug::EXIT_SUCCESS);
    loop {}
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {}
}
