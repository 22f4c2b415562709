//! The fixed-step executive: one tick walks from the sensors to the drives once, with no way back.

mod output;

use control::controller::{ADC, Control, Core};
use control::monitor::Elapsed;
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::spi::SpiDevice;
use shared::arm::JOINTS;
use shared::fault::Fault;
use shared::telemetry::Record;
use shared::wire::biss_c::Layout;

pub use control::controller::{Retained, TickInput};

use crate::config::{Config, ConfigError};
use crate::drivers::ads131m04::Ads131m04;
use crate::drivers::dac81404::Dac81404;
use crate::drivers::{Progress, SampleError, encoder};
use crate::io::Io;
use crate::memory::Memory;
use crate::supervisor::Mode;

/// The controller: its core and the devices that it is wired to.
pub struct Executive<'m, S, O, I> {
    core: &'m mut Core,
    io: Io<S, O, I>,
    adc: Ads131m04,
    dac: Dac81404,
    layouts: [Layout; JOINTS],
    adc_ready: bool,
    dac_ready: bool,
    /// Drive enables and brake releases as driven.
    powered: u8,
    /// Level of the watchdog's pin.
    fed: bool,
    /// Ticks between two feeds of the watchdog, and those left to the next one.
    feed: (u32, u32),
    /// Stages that this tick has gone through, four bits each.
    stages: u32,
    /// What the last tick left.
    record: Record,
}

impl<'m, S: SpiDevice, O: OutputPin, I: InputPin> Executive<'m, S, O, I> {
    /// A controller that has no configuration yet; no pin is touched before the first tick.
    pub fn new(io: Io<S, O, I>, core: &'m mut Core) -> Self {
        Self {
            core,
            io,
            adc: Ads131m04::new(),
            dac: Dac81404::new(),
            layouts: [Layout::default(); JOINTS],
            adc_ready: false,
            dac_ready: false,
            powered: 0,
            fed: false,
            feed: (0, 0),
            stages: 0,
            record: bytemuck::zeroed(),
        }
    }

    /// Takes a configuration with the CRC-32 that it was kept with (`Config::crc`), and what the board kept
    /// over the loss of power; to be called once, before the first tick.
    ///
    /// # Errors
    /// A check sum that does not fit, or the first value of `config` that is out of range; then nothing is
    /// taken.
    pub fn configure(
        &mut self,
        config: &Config,
        crc: u32,
        retained: &Retained,
    ) -> Result<(), ConfigError> {
        self.core.configure(config, crc, retained)?;
        for (layout, joint) in self.layouts.iter_mut().zip(&config.joints) {
            *layout = joint.layout();
        }
        // Toggled every 2 ms (docs/parts.md, external watchdog).
        let interval = config.tick_hz / 500;
        self.feed = (interval, interval);
        Ok(())
    }

    /// What the configuration became, as bytes in two pieces: equal on host and target, or the builds differ.
    pub fn parameter_bytes(&self) -> [&[u8]; 2] {
        let memory = self.core.memory();
        [bytemuck::bytes_of(&memory.coefficients), bytemuck::bytes_of(&memory.thresholds)]
    }

    /// Parameters, their shadow and the estimates, for whoever injects faults into memory.
    pub fn memory(&mut self) -> &mut Memory {
        self.core.memory_mut()
    }

    /// One control tick: update (LDAC), sample, compute, write. The only entry.
    ///
    /// Call it every 1 / `tick_hz`. What tick k computes takes effect at the start of tick k + 1, so the
    /// delay is one tick whatever the computation took; the deadline is the next tick, and half a tick
    /// for computation and wire together keeps the other half for the idle loop. A late, early or missing
    /// tick is told by `input.cycles` and made up for; several, or one far too late, stop the arm. A tick
    /// that never returns is the external watchdog's business, which this feeds every 2 ms.
    ///
    /// Allocates nothing, has no panic path, loops only over joints and reads no clock.
    #[inline(always)]
    pub fn tick(&mut self, input: &TickInput<'_>) -> &Record {
        let sound = self.core.begin();
        let driven = self.update();
        let (control, codes) = if sound { self.work(input, driven) } else { self.repair(input) };
        self.core.record(&control, codes, self.adc.codes(), self.powered, &mut self.record);
        self.feed_watchdog();
        &self.record
    }

    /// What the last tick left.
    pub fn record(&self) -> &Record {
        &self.record
    }

    /// Counts a record that whoever passes it on had no room for.
    pub fn record_dropped(&mut self) {
        self.core.record_dropped();
    }

    /// What a tick is for, with parameters that can be used.
    #[inline(always)]
    fn work(&mut self, input: &TickInput<'_>, mut driven: bool) -> (Control, [u16; JOINTS]) {
        self.sample(input);
        self.supervise(input);
        driven &= self.drive();
        let control = self.control(input);
        let codes = self.write(&control.torque);
        if self.core.conclude(driven) {
            self.drive_again();
        }
        (control, codes)
    }

    /// Reads encoders, in joint order as their latch offsets assume, and the torque converter.
    #[inline(always)]
    fn sample(&mut self, input: &TickInput<'_>) {
        self.stages = self.stages << 4 | 2;
        let elapsed = self.core.start_sampling(input);
        for j in 0..JOINTS {
            let sample = encoder::read(&mut self.io.encoders[j], &self.layouts[j]);
            match (elapsed, sample) {
                (Elapsed::Regular, Ok(sample)) => self.core.take(j, sample.code, sample.warning),
                (Elapsed::Regular, Err(_)) => self.core.lose(j),
                (Elapsed::Irregular(ticks), sample) => {
                    let sample = sample.ok().map(|s| (s.code, s.warning));
                    self.core.take_after(j, sample, ticks);
                }
            }
        }
        if self.adc_ready {
            self.sample_torque(input);
        }
        self.core.end_sampling();
    }

    #[inline(always)]
    fn sample_torque(&mut self, input: &TickInput<'_>) {
        match self.adc.sample(&mut self.io.adc) {
            Ok(sample) if sample.overrange == 0 => {
                if sample.command_refused {
                    self.core.adc_refused();
                }
                self.core.take_torque(&sample.codes, input);
            }
            // A code that a rail has clipped is none.
            Ok(_) => self.core.miss(ADC, Fault::TorqueAdcLost),
            Err(SampleError::Reset) => self.core.miss(ADC, Fault::AdcReset),
            Err(SampleError::Configuration) => self.core.adc_misconfigured(),
            Err(_) => self.core.miss(ADC, Fault::TorqueAdcLost),
        }
    }

    /// Watches over operator and parameters, and moves the mode where there is something to decide.
    #[inline(always)]
    fn supervise(&mut self, input: &TickInput<'_>) {
        self.stages = self.stages << 4 | 3;
        let open = self.io.inputs.contacts_open();
        if self.core.supervise(input, open) {
            self.decide(input);
        }
    }

    #[cold]
    #[inline(never)]
    fn decide(&mut self, input: &TickInput<'_>) {
        if let Mode::Boot { ticks, .. } = *self.core.mode() {
            self.boot(ticks, input.conversions);
        }
        let brakes = self.io.inputs.brakes();
        self.core.decide(input, brakes, self.adc_ready && self.dac_ready);
        if let Mode::Boot { ticks: 0, .. } = self.core.mode() {
            // Cleared: this tick's pins reset both.
            (self.adc_ready, self.dac_ready) = (false, false);
        }
    }

    /// One boot step of each converter.
    #[cold]
    #[inline(never)]
    fn boot(&mut self, ticks: u32, conversions: u32) {
        if ticks == 0 {
            self.core.start_over();
            (self.adc, self.dac) = (Ads131m04::new(), Dac81404::new());
            (self.adc_ready, self.dac_ready) = (false, false);
        }
        if ticks < self.core.memory().thresholds.timing.settle {
            return;
        }
        if !self.adc_ready && self.adc.boot_step(&mut self.io.adc) == Progress::Ready {
            self.adc_ready = true;
            self.core.adc_is_ready(conversions);
        }
        if !self.dac_ready {
            self.dac_ready = self.dac.boot_step(&mut self.io.dac) == Progress::Ready;
        }
    }

    #[inline(always)]
    fn control(&mut self, input: &TickInput<'_>) -> Control {
        self.stages = self.stages << 4 | 4;
        self.core.control(input)
    }
}
