//! Digital filter and two-deep buffer of the ADS131M04 (TI SBAS890D), in fractions of full scale.

use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;
use shared::wire::ads131m04::{CODE_MAX, CODE_MIN};

/// Modulator clock: half of a CLKIN of 8.192 MHz (Table 8-2).
const MODULATOR_HZ: f64 = 4.096e6;

/// Modulator clocks between a reset and the first sample (section 8.4.2).
const START_UP_CLOCKS: f64 = 300.0;

/// Input-referred noise at gain 1 for oversampling by 128, 256 and so on, V rms (Table 7-1).
const NOISE_V: [f64; 8] =
    [21.31e-6, 10.68e-6, 7.56e-6, 5.35e-6, 4.25e-6, 3.38e-6, 2.39e-6, 1.90e-6];

/// Full scale at gain 1, V and codes (Equation 10).
const FULL_SCALE_V: f64 = 1.2;
const FULL_SCALE_CODES: f64 = 8_388_608.0;

/// Impulse response of the sinc3 filter, integrated over its three conversion intervals.
const SINC3: [f64; 3] = [1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0];

/// The fast-settling filter of the first two conversions after a reset (section 8.3.7.1.1).
const SINC1: [f64; 3] = [0.0, 0.0, 1.0];

/// Four channels from the input pins to the output buffer.
pub(super) struct Filter {
    /// Own clock over nominal clock.
    clock_ratio: f64,
    osr_field: u8,
    conversions_per_s: f64,
    /// Time since the last conversion, in conversions; negative while starting up.
    phase: f64,
    /// Integral of the inputs since the last conversion.
    partial: [f64; 4],
    /// Means of the inputs over the last four conversion intervals, newest last.
    means: [[f64; 4]; 4],
    conversions: u32,
    since_reset: u32,
    unread: u32,
    last_read: [i32; 4],
    rng: Xoshiro256PlusPlus,
}

impl Filter {
    pub(super) fn new(seed: u64, clock_error_ppm: f64) -> Self {
        Self {
            clock_ratio: 1.0 + 1e-6 * clock_error_ppm,
            osr_field: 0,
            conversions_per_s: 0.0,
            phase: 0.0,
            partial: [0.0; 4],
            means: [[0.0; 4]; 4],
            conversions: 0,
            since_reset: 0,
            unread: 0,
            last_read: [0; 4],
            rng: Xoshiro256PlusPlus::seed_from_u64(seed),
        }
    }

    /// Starts as after a reset, oversampling by `128 << osr_field`.
    pub(super) fn reset(&mut self, osr_field: u8) {
        self.set_oversampling(osr_field);
        self.phase = -START_UP_CLOCKS / f64::from(128_u32 << osr_field);
        self.since_reset = 0;
        self.last_read = [0; 4];
    }

    /// Starts again with another ratio; its first three conversions are unsettled.
    pub(super) fn set_oversampling(&mut self, osr_field: u8) {
        self.osr_field = osr_field;
        let oversampling = f64::from(128_u32 << osr_field);
        self.conversions_per_s = self.clock_ratio * MODULATOR_HZ / oversampling;
        self.restart();
    }

    /// Empties filter and buffer, as a synchronisation does (section 8.5.2).
    pub(super) fn restart(&mut self) {
        self.phase = 0.0;
        self.partial = [0.0; 4];
        self.means = [[0.0; 4]; 4];
        self.unread = 0;
    }

    pub(super) fn conversions(&self) -> u32 {
        self.conversions
    }

    pub(super) fn data_ready(&self) -> bool {
        self.unread > 0
    }

    pub(super) fn advance(&mut self, dt_s: f64, inputs: [f64; 4]) {
        let begun = self.phase.max(0.0);
        let end = self.phase + dt_s * self.conversions_per_s;
        let done = end as u32;
        self.phase = end - f64::from(done);
        if done == 0 {
            self.integrate(inputs, end.max(0.0) - begun);
            return;
        }
        self.integrate(inputs, 1.0 - begun);
        self.push(self.partial);
        for _ in 1..done.min(4) {
            self.push(inputs);
        }
        self.partial = inputs.map(|input| input * self.phase);
        self.conversions = self.conversions.wrapping_add(done);
        self.since_reset = self.since_reset.saturating_add(done);
        self.unread = self.unread.saturating_add(done).min(2);
    }

    /// Takes the older buffered conversion; the last one again if all were read.
    ///
    /// A full buffer holds the two newest: the sheet (section 8.5.1.9.1) only says that it holds two.
    pub(super) fn read(&mut self) -> [i32; 4] {
        if let Some(behind) = self.unread.checked_sub(1) {
            self.last_read = self.codes(behind);
            self.unread = behind;
        }
        self.last_read
    }

    fn integrate(&mut self, inputs: [f64; 4], share: f64) {
        for (sum, input) in self.partial.iter_mut().zip(inputs) {
            *sum += input * share;
        }
    }

    fn push(&mut self, mean: [f64; 4]) {
        self.means.rotate_left(1);
        self.means[3] = mean;
    }

    /// The conversion that is `behind` (0 or 1) the newest, with its noise.
    fn codes(&mut self, behind: u32) -> [i32; 4] {
        let taps = if self.since_reset - behind <= 2 { SINC1 } else { SINC3 };
        let oldest = 1 - behind as usize;
        let noise_codes = NOISE_V[usize::from(self.osr_field)] / FULL_SCALE_V * FULL_SCALE_CODES;
        std::array::from_fn(|channel| {
            let window = &self.means[oldest..oldest + 3];
            let input: f64 = taps.iter().zip(window).map(|(tap, mean)| tap * mean[channel]).sum();
            let normal: f64 = StandardNormal.sample(&mut self.rng);
            let code = (input * FULL_SCALE_CODES + normal * noise_codes).round();
            (code as i32).clamp(CODE_MIN, CODE_MAX)
        })
    }
}
