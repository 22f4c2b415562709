//! All four encoders in one read: a timer makes MA, DMA samples the four lines with every clock.
//!
//! No SPI port can: 1 MHz is not 42 or 84 MHz over a power of two, and two of the three ports belong to
//! the converters. TIM2's update starts TIM1, so all heads latch at one instant, fixed to the tick without
//! any software in between. Sections and registers are RM0390's.

use core::sync::atomic::{AtomicU32, Ordering, fence};

use shared::wire::biss_c::{FRAME_BYTES, LATCH_DELAY_S, MA_HZ};
use stm32f4::stm32f446::{Peripherals, dma2, tim1, tim2};

use crate::clocks::{APB1_TIMER_HZ, CORE_HZ};
use crate::lanes::{self, SAMPLE_WORDS};
use crate::wait::{TimedOut, until};

/// Timer clocks of one period of MA: high for the first half, so that it rests high between reads.
const PERIOD: u32 = CORE_HZ / MA_HZ;
const FIRST_FALL: u32 = PERIOD / 2;
/// Within the period: 170 ns before the rising edge, where DMA's latency cannot reach past it. The heads
/// change SLO at rising edges, so line and receivers may delay it by 0.8 us.
const SAMPLE_AT: u32 = PERIOD - 28;
/// Clocks of a read.
const CLOCKS: u32 = 8 * FRAME_BYTES as u32;

/// From the tick instant to the position's latch, s.
pub const LATCH_OFFSET_S: f32 = (FIRST_FALL as f64 / CORE_HZ as f64 + LATCH_DELAY_S) as f32;
/// From the tick instant to the end of the read, ns.
pub const READ_NS: u32 = CLOCKS * (1_000_000_000 / MA_HZ);

/// TIM2 count at which a read that is not complete has failed: 4 us after its end.
const DEADLINE: u32 = (READ_NS / 1_000 + 4) * (APB1_TIMER_HZ / 1_000_000);
/// Beyond [`DEADLINE`] in any case.
const POLLS: u32 = 2_000;

/// DMA stream of TIM1's second channel, and its channel number (DMA2 request mapping).
const STREAM: usize = 2;
const CHANNEL: u8 = 6;

/// Port C's low byte, one sample a clock; written by DMA.
static SAMPLES: [AtomicU32; SAMPLE_WORDS] = [const { AtomicU32::new(0) }; SAMPLE_WORDS];

/// The timer and the DMA stream.
pub struct Reader {
    ma: &'static tim1::RegisterBlock,
    dma: &'static dma2::RegisterBlock,
}

impl Reader {
    /// Prepares the first read; TIM2's updates start it and all that follow.
    pub fn start(p: &'static Peripherals) -> Self {
        let reader = Self { ma: &p.TIM1, dma: &p.DMA2 };
        reader.set_up_ma();
        let stream = p.DMA2.st(STREAM);
        // SAFETY: a register that may be read at any time.
        stream.par().write(|w| unsafe { w.pa().bits(p.GPIOC.idr().as_ptr() as u32) });
        // SAFETY: 64 bytes that live for ever and are atomic.
        stream.m0ar().write(|w| unsafe { w.m0a().bits(SAMPLES.as_ptr() as u32) });
        stream.cr().write(|w| {
            w.chsel().set(CHANNEL).pl().very_high().dir().peripheral_to_memory();
            w.msize().bits8().psize().bits8().minc().incremented().pinc().fixed()
        });
        reader.arm();
        reader
    }

    /// One-pulse mode with a repetition counter: 64 periods, then rest (sections 16.3.3 and 16.3.15).
    fn set_up_ma(&self) {
        let timer = self.ma;
        timer.arr().write(|w| w.arr().set(const { (PERIOD - 1) as u16 }));
        timer.rcr().write(|w| w.rep().set(const { (CLOCKS - 1) as u8 }));
        timer.ccr1().write(|w| w.ccr().set(const { FIRST_FALL as u16 }));
        timer.ccr2().write(|w| w.ccr().set(const { SAMPLE_AT as u16 }));
        timer.ccmr1_output().write(|w| w.oc1m().pwm_mode1().oc2m().frozen());
        timer.ccer().write(|w| w.cc1e().set_bit());
        timer.cr1().write(|w| w.opm().enabled());
        timer.egr().write(|w| w.ug().set_bit());
        timer.bdtr().write(|w| w.moe().enabled());
        // ITR1 is TIM2's trigger output (TIM1_SMCR, internal trigger connection).
        timer.smcr().write(|w| w.ts().itr1().sms().trigger_mode());
    }

    /// Makes DMA ready for the next read; to be called after the lines were read, before the next tick.
    ///
    /// Requests are masked meanwhile: one left over from a read that overran would shift the next one.
    pub fn arm(&self) {
        let stream = self.dma.st(STREAM);
        self.ma.dier().write(|w| w.cc2de().disabled());
        stream.cr().modify(|_, w| w.en().disabled());
        // A stream that will not stop leaves the next read incomplete, which its lines report.
        let _ = until(POLLS, || !stream.cr().read().en().bit());
        self.dma.lifcr().write(|w| {
            w.ctcif2().set_bit().chtif2().set_bit().cteif2().set_bit();
            w.cdmeif2().set_bit().cfeif2().set_bit()
        });
        stream.ndtr().write(|w| w.ndt().set(const { CLOCKS as u16 }));
        stream.cr().modify(|_, w| w.en().enabled());
        self.ma.dier().write(|w| w.cc2de().enabled());
    }
}

/// One encoder's line.
pub struct Line {
    dma: &'static dma2::RegisterBlock,
    tick: &'static tim2::RegisterBlock,
    /// Pin of port C.
    number: u32,
}

impl Line {
    /// The lines of joints 1 to 4, PC0 to PC3.
    pub fn all(p: &'static Peripherals) -> [Self; 4] {
        [0, 1, 2, 3].map(|number| Self { dma: &p.DMA2, tick: &p.TIM2, number })
    }

    /// This line's part of the read that the tick started; the first caller waits for its end.
    #[inline(always)]
    pub fn read(&self, bytes: &mut [u8]) -> Result<(), TimedOut> {
        let complete = || self.dma.lisr().read().tcif2().bit();
        until(POLLS, || complete() || self.tick.cnt().read().bits() >= DEADLINE)?;
        if !complete() {
            return Err(TimedOut);
        }
        fence(Ordering::Acquire);
        let samples = SAMPLES.each_ref().map(|word| word.load(Ordering::Relaxed));
        for (slot, byte) in bytes.iter_mut().zip(lanes::frame(&samples, self.number)) {
            *slot = byte;
        }
        Ok(())
    }
}
