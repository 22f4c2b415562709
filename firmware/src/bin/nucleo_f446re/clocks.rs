//! Clock tree: 168 MHz core from the ST-LINK's 8 MHz.
//!
//! Sources: RM0390, reference manual of the STM32F446xx; DS10693, its data sheet.

use stm32f4::stm32f446::Peripherals;

use crate::wait::{TimedOut, until};

/// Core and AHB clock; also that of TIM1, because APB2 is divided (RM0390 section 6.2).
pub const CORE_HZ: u32 = 168_000_000;
/// APB2 clock, 90 MHz at most (DS10693, general operating conditions).
pub const APB2_HZ: u32 = CORE_HZ / 2;
/// APB1 clock, 45 MHz at most.
pub const APB1_HZ: u32 = CORE_HZ / 4;
/// Clock of timers on APB1: twice the bus.
pub const APB1_TIMER_HZ: u32 = 2 * APB1_HZ;

/// About 6 ms at the 16 MHz of reset. The external clock is an oscillator's, and the PLL locks within
/// 0.3 ms (DS10693, main PLL characteristics).
const START_POLLS: u32 = 10_000;

/// Starts HSE and PLL, switches to them and clocks every peripheral in use.
///
/// From here on the clock security system raises NMI if the external clock fails.
pub fn start(p: &Peripherals) -> Result<(), TimedOut> {
    let rcc = &p.RCC;
    rcc.cr().modify(|_, w| w.hsebyp().bypassed().hseon().on());
    until(START_POLLS, || rcc.cr().read().hserdy().is_ready())?;
    // 8 MHz / 4 · 168 / 2; the 48 MHz outputs stay unused (RM0390, RCC_PLLCFGR).
    // SAFETY: the factors are in range: VCO input 2 MHz, VCO 336 MHz.
    rcc.pllcfgr().write(|w| unsafe {
        w.pllsrc().hse().pllm().bits(4).plln().bits(168).pllp().div2().pllq().bits(7).pllr().bits(2)
    });
    rcc.cr().modify(|_, w| w.pllon().on());
    until(START_POLLS, || rcc.cr().read().pllrdy().is_ready())?;
    // Five wait states above 150 MHz at 2.7 to 3.6 V (RM0390 section 3.4.1); scale 1 is the reset value
    // of the regulator and allows 168 MHz without over-drive.
    let flash = &p.FLASH;
    flash.acr().write(|w| w.latency().ws5().prften().enabled().icen().enabled().dcen().enabled());
    until(START_POLLS, || flash.acr().read().latency().is_ws5())?;
    rcc.cfgr().modify(|_, w| w.hpre().div1().ppre1().div4().ppre2().div2().sw().pll());
    until(START_POLLS, || rcc.cfgr().read().sws().is_pll())?;
    rcc.cr().modify(|_, w| w.csson().on());
    supply(p);
    Ok(())
}

/// Clocks the peripherals.
fn supply(p: &Peripherals) {
    let rcc = &p.RCC;
    rcc.ahb1enr().modify(|_, w| {
        w.gpioaen().enabled().gpioben().enabled().gpiocen().enabled().gpioden().enabled();
        w.dma1en().enabled().dma2en().enabled()
    });
    rcc.apb1enr().modify(|_, w| {
        w.tim2en().enabled().tim3en().enabled().spi2en().enabled().usart2en().enabled()
    });
    rcc.apb2enr().modify(|_, w| w.tim1en().enabled().spi1en().enabled());
    // A peripheral answers two of its bus's clocks after it is enabled (RM0390, RCC_AHB1ENR).
    cortex_m::asm::delay(16);
}
