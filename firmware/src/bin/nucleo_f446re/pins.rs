//! Pins: what each is for, and handles that drive or read one.

use core::convert::Infallible;

use cortex_m::asm;
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use firmware::io::{Inputs, Outputs};
use stm32f4::stm32f446::Peripherals;
use stm32f4::stm32f446::gpioa::{BSRR, IDR};

/// Core clocks that every level lasts at least, 60 ns. The DAC wants LDAC low for 20 ns and SYNC high for
/// 50 ns (SLASEH2A section 7.6).
const HOLD_CLOCKS: u32 = 10;

/// A driven pin.
pub struct Output {
    set_reset: &'static BSRR,
    number: u32,
}

impl Output {
    /// Writes one bit of the set (0) or reset (16) half.
    #[inline(always)]
    fn write(&mut self, half: u32) {
        // SAFETY: every pattern is valid; zeros change nothing, so handles of one port do not interfere.
        self.set_reset.write(|w| unsafe { w.bits(1 << (self.number + half)) });
        asm::delay(HOLD_CLOCKS);
    }
}

impl ErrorType for Output {
    type Error = Infallible;
}

impl OutputPin for Output {
    #[inline(always)]
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.write(16);
        Ok(())
    }

    #[inline(always)]
    fn set_high(&mut self) -> Result<(), Infallible> {
        self.write(0);
        Ok(())
    }
}

/// A pin that is read.
pub struct Input {
    levels: &'static IDR,
    number: u32,
}

impl ErrorType for Input {
    type Error = Infallible;
}

impl InputPin for Input {
    #[inline(always)]
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(self.levels.read().bits() & 1 << self.number != 0)
    }

    #[inline(always)]
    fn is_low(&mut self) -> Result<bool, Infallible> {
        self.is_high().map(|high| !high)
    }
}

/// Every handle the controller needs.
pub struct Pins {
    /// Chip select of the torque converter, PB6.
    pub adc_select: Output,
    /// SYNC of the DAC, PB12.
    pub dac_select: Output,
    /// Outputs of the controller.
    pub outputs: Outputs<Output>,
    /// Inputs of the controller.
    pub inputs: Inputs<Input>,
}

/// Sets all pins up: outputs off, chip selects and LDAC high before they are driven.
pub fn start(p: &'static Peripherals) -> Pins {
    let a = |number| Output { set_reset: p.GPIOA.bsrr(), number };
    let b = |number| Output { set_reset: p.GPIOB.bsrr(), number };
    let c = |number| Output { set_reset: p.GPIOC.bsrr(), number };
    let in_a = |number| Input { levels: p.GPIOA.idr(), number };
    let in_b = |number| Input { levels: p.GPIOB.idr(), number };
    let pins = Pins {
        adc_select: b(6),
        dac_select: b(12),
        outputs: Outputs {
            ldac: b(0),
            drive_enable: [c(4), c(5), c(6), c(7)],
            sto: c(12),
            brake_release: [c(8), c(9), c(10), c(11)],
            dac_reset: b(1),
            adc_reset: b(7),
            watchdog: a(9),
        },
        inputs: Inputs {
            brake_open: [in_a(6), in_a(7), in_a(11), in_a(12)],
            emergency_stop: [in_b(8), in_b(9)],
        },
    };
    p.GPIOB.bsrr().write(|w| w.bs0().set_bit().bs6().set_bit().bs12().set_bit());
    set_up_a(p);
    set_up_b(p);
    set_up_c_and_d(p);
    pins
}

/// USART2 on PA2 and PA3, MA on PA8 (alternate functions: DS10693 Table 11).
fn set_up_a(p: &Peripherals) {
    let port = &p.GPIOA;
    port.afrl().modify(|_, w| w.afrl2().af7().afrl3().af7());
    port.afrh().modify(|_, w| w.afrh8().af1());
    port.pupdr().modify(|_, w| {
        w.pupdr6().pull_down().pupdr7().pull_down().pupdr11().pull_down().pupdr12().pull_down()
    });
    port.moder().modify(|_, w| {
        w.moder2().alternate().moder3().alternate().moder8().alternate().moder9().output()
    });
}

/// SPI1 on PB3 to PB5, SPI2 on PB13 to PB15.
fn set_up_b(p: &Peripherals) {
    let port = &p.GPIOB;
    port.afrl().modify(|_, w| w.afrl3().af5().afrl4().af5().afrl5().af5());
    port.afrh().modify(|_, w| w.afrh13().af5().afrh14().af5().afrh15().af5());
    port.ospeedr().modify(|_, w| {
        w.ospeedr3().high_speed().ospeedr5().high_speed();
        w.ospeedr13().high_speed().ospeedr15().high_speed()
    });
    // PB4 leaves reset as a pulled-up JTAG pin.
    port.pupdr().modify(|_, w| w.pupdr4().floating().pupdr8().pull_down().pupdr9().pull_down());
    port.moder().modify(|_, w| {
        w.moder0().output().moder1().output().moder6().output().moder7().output();
        w.moder12().output().moder3().alternate().moder4().alternate().moder5().alternate();
        w.moder13().alternate().moder14().alternate().moder15().alternate()
    });
}

/// Encoder lines PC0 to PC3, pulled to a level that is no frame; enables, brakes and STO on PC4 to PC12; the torque
/// converter's clock on PD2.
fn set_up_c_and_d(p: &Peripherals) {
    let port = &p.GPIOC;
    port.pupdr().modify(|_, w| {
        w.pupdr0().pull_down().pupdr1().pull_down().pupdr2().pull_down().pupdr3().pull_down()
    });
    port.moder().modify(|_, w| {
        w.moder4().output().moder5().output().moder6().output().moder7().output();
        w.moder8().output().moder9().output().moder10().output().moder11().output();
        w.moder12().output()
    });
    p.GPIOD.afrl().modify(|_, w| w.afrl2().af2());
    p.GPIOD.moder().modify(|_, w| w.moder2().alternate());
}
