#![no_std]
#![no_main]
#![allow(unsafe_code)]
#![warn(clippy::undocumented_unsafe_blocks)]
//! Board file of the ST Nucleo-F446RE; it has not run on hardware. Wiring: `docs/wiring-nucleo-f446re.md`.
//!
//! TIM2 starts a tick: its update clocks the encoders by hardware and raises the only interrupt, which runs
//! the controller. The idle loop sends telemetry, serves the operator and sleeps.

mod budget;
mod bus;
mod clocks;
mod encoders;
mod faults;
mod kept;
mod lanes;
mod mailbox;
mod pins;
mod serial;
mod telemetry;
mod wait;

use cortex_m::peripheral::{DWT, NVIC};
use cortex_m::{asm, singleton};
use cortex_m_rt::entry;
use firmware::config::{Config, ConfigError};
use firmware::controller::Core;
use firmware::evidence::Recorder;
use firmware::executive::{Executive, Retained, TickInput};
use firmware::io::Io;
use firmware::link::{Served, Station};
use shared::arm::REFERENCE;
use stm32f4::stm32f446::{Interrupt, Peripherals, interrupt, iwdg, tim2, tim3};

use crate::budget::TICK_HZ;
use crate::bus::{Bus, Chip};
use crate::encoders::{LATCH_OFFSET_S, Line, Reader};
use crate::pins::{Input, Output, Pins};
use crate::serial::Serial;
use crate::telemetry::{Measured, Outbox};

/// The controller and what its tick needs of the board.
struct Control {
    executive: Executive<'static, Bus, Output, Input>,
    reader: Reader,
    outbox: Outbox,
    tick: &'static tim2::RegisterBlock,
    adc_clock: &'static tim3::RegisterBlock,
    watchdog: &'static iwdg::RegisterBlock,
    /// Last count of the torque converter's clock.
    adc_count: u16,
    /// Its clocks since the last conversion, and conversions modulo 2³².
    adc_rest: u32,
    conversions: u32,
}

/// What the controller believes and decides: its alone.
static mut CORE: Core = Core::new();

/// Written once by `main` before the interrupt is unmasked, then the interrupt's alone.
static mut CONTROL: Option<Control> = None;

#[entry]
fn main() -> ! {
    // SAFETY: the only instance of each; nothing ran before.
    let (core, device) = unsafe { (cortex_m::Peripherals::steal(), Peripherals::steal()) };
    let Some(p) = singleton!(: Peripherals = device) else { faults::all_off() };
    let p: &'static Peripherals = p;
    if clocks::start(p).is_err() {
        faults::all_off();
    }
    count_cycles(core);
    let pins = pins::start(p);
    let mut serial = Serial::start(p);
    let Some(station) = singleton!(: Station = Station::new()) else { faults::all_off() };
    // SAFETY: the only call.
    let evidence = unsafe { faults::evidence() };
    if let Some(crash) = faults::hung(&p.RCC) {
        (evidence.crash, evidence.crash_status) = (crash as u32, 0);
    }
    let (mut recorder, retained) = Recorder::new(evidence, TICK_HZ);
    match control(p, pins, &retained, station) {
        // SAFETY: the interrupt that shares it is still masked.
        Ok(control) => unsafe { CONTROL = Some(control) },
        Err(error) => refuse(&serial, &error),
    }
    start_ticks(p);
    loop {
        let sent = telemetry::send_next(&serial, |record| {
            recorder.note(evidence, record);
            station.note(record);
        });
        if !sent {
            if mailbox::returned(station) {
                station.serve(&mut serial, evidence);
                mailbox::post(station.served());
            }
            asm::wfi();
        }
    }
}

/// Builds the controller; all outputs stay off until its first tick.
fn control(
    p: &'static Peripherals,
    pins: Pins,
    retained: &Retained,
    station: &mut Station,
) -> Result<Control, ConfigError> {
    const CONFIG: Config = Config::for_arm(&REFERENCE, TICK_HZ);
    let mut config = CONFIG;
    // Here the four heads latch together.
    for joint in &mut config.joints {
        joint.latch_offset_s = LATCH_OFFSET_S;
    }
    let io = Io {
        encoders: Line::all(p).map(Bus::Encoder),
        adc: Bus::Chip(Chip::start(&p.SPI1, pins.adc_select)),
        dac: Bus::Chip(Chip::start(&p.SPI2, pins.dac_select)),
        outputs: pins.outputs,
        inputs: pins.inputs,
    };
    let core = &raw mut CORE;
    // SAFETY: `main` alone is running, and hands it to the interrupt with the rest.
    let core = unsafe { &mut *core };
    let mut executive = Executive::new(io, core);
    executive.configure(&config, config.crc(), retained)?;
    station.configure(&config, &kept::access(&p.FLASH));
    Ok(Control {
        executive,
        reader: Reader::start(p),
        outbox: Outbox::default(),
        tick: &p.TIM2,
        adc_clock: &p.TIM3,
        watchdog: &p.IWDG,
        adc_count: 0,
        adc_rest: 0,
        conversions: 0,
    })
}

/// Names the value that is out of range, once, and stays off.
fn refuse(serial: &Serial, error: &ConfigError) -> ! {
    let _ = serial.send(error.field().bytes().chain(*b"\r\n"));
    faults::all_off()
}

fn count_cycles(mut core: cortex_m::Peripherals) {
    core.DCB.enable_trace();
    core.DWT.enable_cycle_counter();
}

/// Starts the watchdog, the count of the torque converter's clock and the ticks.
fn start_ticks(p: &Peripherals) {
    // 80 / 8 kHz: 10 ms, from 6.8 to 18.8 ms over the LSI's 17 to 47 kHz (DS10693, LSI characteristics).
    p.IWDG.kr().write(|w| w.key().start());
    p.IWDG.kr().write(|w| w.key().unlock());
    p.IWDG.pr().write(|w| w.pr().divide_by4());
    p.IWDG.rlr().write(|w| w.rl().set(79));
    // External clock mode 2 (RM0390 section 17.3.3).
    p.TIM3.smcr().write(|w| w.ece().enabled());
    p.TIM3.cr1().write(|w| w.cen().enabled());
    p.TIM2.arr().write(|w| w.arr().set(clocks::APB1_TIMER_HZ / TICK_HZ - 1));
    p.TIM2.cr2().write(|w| w.mms().update());
    p.TIM2.dier().write(|w| w.uie().enabled());
    // SAFETY: `CONTROL` is complete, and this is the only interrupt.
    unsafe { NVIC::unmask(Interrupt::TIM2) };
    p.TIM2.cr1().write(|w| w.cen().enabled());
}

#[interrupt]
fn TIM2() {
    // SAFETY: `main` is done with it, and this interrupt does not nest.
    if let Some(control) = unsafe { (&raw mut CONTROL).as_mut() }.and_then(Option::as_mut) {
        control.tick();
    }
}

impl Control {
    /// One tick; its end feeds the internal watchdog, the controller itself the external one.
    fn tick(&mut self) {
        let began = DWT::cycle_count();
        self.tick.sr().modify(|_, w| w.uif().clear_bit());
        let adc_count = self.adc_clock.cnt().read().cnt().bits();
        let adc_clocks = u32::from(adc_count.wrapping_sub(self.adc_count));
        self.adc_count = adc_count;
        self.outbox.measured.adc_clocks = adc_clocks;
        // CLKIN is counted; a conversion takes 256 of its clocks.
        self.adc_rest += adc_clocks;
        self.conversions = self.conversions.wrapping_add(self.adc_rest / 256);
        self.adc_rest %= 256;
        let served = mailbox::take();
        let input = TickInput {
            order: served.as_ref().and_then(Served::order),
            alive: served.is_some_and(|served| served.alive),
            cycles: began,
            spent: self.outbox.measured.tick_clocks,
            conversions: self.conversions,
        };
        let record = self.executive.tick(&input);
        if served.is_some() {
            mailbox::answer(record.refusal);
        }
        if !self.outbox.push(record) {
            self.executive.record_dropped();
        }
        self.reader.arm();
        self.watchdog.kr().write(|w| w.key().feed());
        let tick_clocks = DWT::cycle_count().wrapping_sub(began);
        self.outbox.measured = Measured { tick_clocks, adc_clocks };
    }
}
