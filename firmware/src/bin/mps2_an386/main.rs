//! Emulated MPS2-AN386 (Cortex-M4F): the controller in the SysTick exception, telemetry from idle.
//!
//! Buses and pins are tunnelled to the harness ([`link`]), which also releases each tick.
#![no_std]
#![no_main]
#![allow(unsafe_code, reason = "board file")]

mod crash;
mod defect;
mod link;
mod stack;

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;

use cortex_m::peripheral::SYST;
use cortex_m_rt::{entry, exception};
use firmware::config::Config;
use firmware::controller::Core;
use firmware::evidence::Recorder;
use firmware::executive::{Executive, TickInput};
use firmware::io::{Inputs, Io, Outputs};
use firmware::link::{Access, Station};
use link::{Level, Line, Serial, Tunnel};
use shared::arm::JOINTS;
use shared::evidence::Image;
use shared::link::DEFAULT_KEY;
use shared::pil::{self, Release};

/// Vectors of the device's interrupts, in place of 240 default ones: none is enabled, but the linker script
/// wants at least one.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
pub static __INTERRUPTS: [unsafe extern "C" fn(); 1] = {
    unsafe extern "C" {
        fn DefaultHandler();
    }
    [DefaultHandler]
};

/// SysTick clock of the board, Hz (Arm DAI0386).
const CLOCK_HZ: u32 = 25_000_000;

type Controller = Executive<'static, Tunnel, Line, Level>;

/// A static that one exception owns.
struct Owned<T>(UnsafeCell<T>);

// SAFETY: each use names the one context that touches the value, or masks the others.
unsafe impl<T> Sync for Owned<T> {}

/// Written once before SysTick starts, then SysTick's; idle reads the record of a tick before it releases the next.
static CONTROLLER: Owned<MaybeUninit<Controller>> = Owned(UnsafeCell::new(MaybeUninit::uninit()));

/// The operator's end. Idle's, but the tick's while [`RELEASED`] says so.
static STATION: Owned<Station> = Owned(UnsafeCell::new(Station::new()));

/// What the tick is told: as [`STATION`].
static RELEASE: Owned<Release> = Owned(UnsafeCell::new(Release::NONE));

/// Idle has served the operator link, and the harness lets the tick go. Idle writes it with SysTick masked.
static RELEASED: Owned<bool> = Owned(UnsafeCell::new(false));

/// The operator link: idle's alone.
static SERIAL: Owned<Serial> = Owned(UnsafeCell::new(Serial::new()));

/// What the controller believes and decides: its alone.
static CORE: Owned<Core> = Owned(UnsafeCell::new(Core::new()));

/// Comes from the harness; kept off the stack.
static CONFIG: Owned<Config> = Owned(UnsafeCell::new(bytemuck::zeroed()));

/// A tick has left a record that idle has not taken yet. Both write it with SysTick masked.
static TICKED: Owned<bool> = Owned(UnsafeCell::new(false));

#[entry]
fn main() -> ! {
    stack::guard();
    stack::paint();
    link::open();
    // SAFETY: the only reference to it; a hard fault, which writes it too, does not come back.
    let evidence = unsafe { crash::evidence() };
    let (mut recorder, tick_hz) = start(evidence);
    if let Some(tick_hz) = tick_hz {
        serve(evidence);
        start_ticking(tick_hz);
    }
    defect::in_idle();
    loop {
        // SAFETY: SysTick, the only other user, is masked.
        let ticked = cortex_m::interrupt::free(|_| unsafe { TICKED.0.get().replace(false) });
        if ticked {
            conclude(&mut recorder, evidence);
            serve(evidence);
        } else {
            cortex_m::asm::wfi();
        }
    }
}

/// Takes what the harness hands over; gives ticks a second, unless it was refused. Out of the way of what comes later,
/// which needs its stack.
#[inline(never)]
fn start(evidence: &mut Image) -> (Recorder, Option<u32>) {
    // SAFETY: SysTick is not running yet, and nothing else touches these.
    let (config, core, controller) =
        unsafe { (&mut *CONFIG.0.get(), &mut *CORE.0.get(), &mut *CONTROLLER.0.get()) };
    link::receive(bytemuck::bytes_of_mut(config));
    let mut kept = [0_u32; 2 + JOINTS];
    link::receive(bytemuck::bytes_of_mut(&mut kept));
    let [crc, parked @ .., boots] = kept;
    let mut access = Access { key: DEFAULT_KEY, boots };
    link::receive(&mut access.key);
    defect::before_configuration(config);
    let crc = defect::in_coefficients(config, crc);
    let (recorder, mut retained) = Recorder::new(evidence, config.tick_hz);
    // What the harness gives stands for a memory that outlives the loss of power.
    retained.parked.get_or_insert(parked);
    let controller = controller.write(Executive::new(wire(), core));
    if controller.configure(config, crc, &retained).is_ok() {
        // Those before power-up are the harness's to know.
        access.boots = access.boots.wrapping_add(evidence.boots);
        // SAFETY: SysTick is not running yet.
        unsafe { &mut *STATION.0.get() }.configure(config, &access);
        link::send_coefficients(controller.parameter_bytes());
        defect::in_law(controller, config, &retained);
        (recorder, Some(config.tick_hz))
    } else {
        link::send_refusal();
        (recorder, None)
    }
}

/// Between two ticks: takes note of what the last one left.
#[inline(never)]
fn conclude(recorder: &mut Recorder, evidence: &mut Image) {
    // SAFETY: no tick comes before idle releases it, and the controller is written.
    let (station, controller) =
        unsafe { (&mut *STATION.0.get(), (*CONTROLLER.0.get()).assume_init_ref()) };
    let record = controller.record();
    recorder.note(evidence, record);
    station.note(record);
    link::send_record(record);
}

/// Between two ticks: waits until the next may come, and serves the operator.
#[inline(never)]
fn serve(evidence: &Image) {
    // SAFETY: these are idle's until it releases the tick below.
    let (station, serial, release) =
        unsafe { (&mut *STATION.0.get(), &mut *SERIAL.0.get(), &mut *RELEASE.0.get()) };
    link::await_release(release);
    serial.receive(release);
    station.serve(serial, evidence);
    // SAFETY: SysTick, the only other user, is masked.
    cortex_m::interrupt::free(|_| unsafe { *RELEASED.0.get() = true });
}

fn wire() -> Io<Tunnel, Line, Level> {
    let from = |first: u8| [0, 1, 2, 3].map(|j| Line(first + j));
    Io {
        encoders: [0, 1, 2, 3].map(Tunnel),
        adc: Tunnel(pil::DEVICE_ADC),
        dac: Tunnel(pil::DEVICE_DAC),
        outputs: Outputs {
            ldac: Line(pil::PIN_LDAC),
            drive_enable: from(pil::PIN_DRIVE_ENABLE),
            sto: Line(pil::PIN_STO),
            brake_release: from(pil::PIN_BRAKE_RELEASE),
            dac_reset: Line(pil::PIN_DAC_RESET),
            adc_reset: Line(pil::PIN_ADC_RESET),
            watchdog: Line(pil::PIN_WATCHDOG),
        },
        inputs: Inputs { brake_open: [0, 1, 2, 3].map(Level), emergency_stop: [4, 5].map(Level) },
    }
}

fn start_ticking(tick_hz: u32) {
    // SAFETY: the only use of SysTick's registers.
    let syst = unsafe { &*SYST::PTR };
    let reload = CLOCK_HZ.checked_div(tick_hz).unwrap_or(CLOCK_HZ) - 1;
    // SAFETY: a reload value of 24 bits: 25 MHz over at least 1 kHz.
    unsafe {
        syst.rvr.write(reload);
        syst.cvr.write(0);
        // Processor clock, exception, counter on (Armv7-M ARM B3.3.3, SYST_CSR).
        syst.csr.write(0b111);
    }
}

#[exception]
fn SysTick() {
    // In lock-step a tick waits until idle has sent the record of the one before and served the operator.
    // SAFETY: idle touches it with SysTick masked.
    let released = unsafe { &mut *RELEASED.0.get() };
    if !*released {
        return;
    }
    *released = false;
    // SAFETY: SysTick starts only after the controller is written; idle is done with all of them until this tick has
    // left its record.
    let (controller, station, release) = unsafe {
        ((*CONTROLLER.0.get()).assume_init_mut(), &mut *STATION.0.get(), &*RELEASE.0.get())
    };
    for poke in &release.pokes {
        poke.apply(controller.memory().as_words_mut());
    }
    let served = station.served();
    let input = TickInput {
        order: served.order(),
        alive: served.alive,
        cycles: release.cycles,
        spent: release.spent,
        conversions: release.conversions,
    };
    tick(controller, &input);
    station.taken(controller.record().refusal);
    // SAFETY: idle touches it with SysTick masked.
    unsafe { *TICKED.0.get() = true };
}

/// One tick under its own symbol, so that its instructions can be counted.
#[inline(never)]
#[unsafe(no_mangle)]
fn tick(controller: &mut Controller, input: &TickInput<'_>) {
    controller.tick(input);
    defect::in_tick();
}

/// Linking fails if any panic is reachable: nothing defines this symbol.
#[cfg(not(debug_assertions))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    unsafe extern "C" {
        fn a_panic_is_reachable() -> !;
    }
    // SAFETY: never linked.
    unsafe { a_panic_is_reachable() }
}

#[cfg(debug_assertions)]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    cortex_m_semihosting::debug::exit(cortex_m_semihosting::debug::EXIT_FAILURE);
    loop {}
}
