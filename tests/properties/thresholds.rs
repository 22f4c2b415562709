//! Every limit of the monitors and time of the supervisor against its formula in `f64`.

use firmware::config::{Config, Law, Safety};
use firmware::monitor::Thresholds;
use proptest::prelude::*;
use shared::arm::{JOINTS, REFERENCE};

/// One word of the thresholds as it should be.
#[derive(Clone, Copy, Debug)]
enum Word {
    Float(f64),
    /// Cut to a whole number.
    Cut(f64),
    /// Seconds as the nearest number of ticks.
    Ticks(f64),
    /// A position word that may be off by 1e-6 rad or m: `f32` differences of up to 6 rad.
    Position {
        words: f64,
        off: f64,
    },
}

impl Word {
    fn fits(self, bits: u32) -> bool {
        let count = f64::from(bits);
        let rounding = |of: f64| 1e-6 * of.abs() + 1e-3;
        match self {
            Self::Float(x) => (f64::from(f32::from_bits(bits)) - x).abs() <= 1e-6 * x.abs(),
            Self::Cut(x) => count <= x + rounding(x) && count > x - 1.0 - rounding(x),
            Self::Ticks(x) => (count - x).abs() <= 0.5 + rounding(x),
            Self::Position { words, off } => (count - words).abs() <= off + 1.0,
        }
    }
}

/// The table in the order of its memory.
fn expected(config: &Config) -> Vec<(&'static str, Word)> {
    let mut table = Table { words: Vec::new(), hz: f64::from(config.tick_hz) };
    table.encoders(config);
    table.torque(&config.safety);
    table.motion(config);
    table.clock(&config.safety);
    table.timing(config);
    table.words
}

struct Table {
    words: Vec<(&'static str, Word)>,
    hz: f64,
}

/// One encoder count of each joint, rad and m.
const LSB: [f64; JOINTS] = {
    let e = REFERENCE.encoders;
    [e[0].lsb, e[1].lsb, e[2].lsb, e[3].lsb]
};

impl Table {
    fn one(&mut self, name: &'static str, word: Word) {
        self.words.push((name, word));
    }

    fn each(&mut self, name: &'static str, word: impl Fn(usize) -> Word) {
        self.words.extend((0..JOINTS).map(|j| (name, word(j))));
    }

    fn floats(&mut self, name: &'static str, values: [f32; JOINTS]) {
        self.each(name, |j| Word::Float(values[j].into()));
    }

    fn ticks(&mut self, name: &'static str, seconds: impl Into<f64>) {
        self.one(name, Word::Ticks(seconds.into() * self.hz));
    }

    fn encoders(&mut self, config: &Config) {
        let per_count = LSB.map(|lsb| self.hz * self.hz * lsb);
        let window = |a: [f32; JOINTS]| move |j| Word::Cut(8.0 + f64::from(a[j]) / per_count[j]);
        self.each("tight", window(config.safety.unforeseen));
        self.each("wide", window(config.safety.violent));
        let forever = f64::from(u32::MAX);
        let (stuck, patience) = match config.gains.law {
            Law::INERTIA_WEIGHTED => (40.0, 0.025 * self.hz),
            Law::PD => (1_024.0, forever),
            _ => (40.0, forever),
        };
        self.one("stuck", Word::Cut(stuck * 64.0));
        self.one("patience", Word::Cut(patience));
        self.one("lag", Word::Float(64.0));
        self.each("per_acceleration", |j| Word::Float(64.0 / per_count[j]));
    }

    fn torque(&mut self, s: &Safety) {
        self.each("torque scale", |j| Word::Float(REFERENCE.torque_full_scale[j] / 8_388_608.0));
        self.floats("warn", s.torque_warn);
        self.floats("wrong", s.torque_wrong);
        self.floats("speed error", s.speed_error);
        self.one("lasting torque", Word::Cut(0.040 * self.hz));
    }

    fn motion(&mut self, config: &Config) {
        let s = &config.safety;
        let over = s.overtravel.map(f64::from);
        let limits = REFERENCE.limits;
        self.each("lowest", |j| position(j, limits[j].q_min - over[j]));
        self.each("span", |j| {
            let span = limits[j].q_max - limits[j].q_min + 2.0 * over[j];
            Word::Position { words: span / LSB[j] * 64.0, off: 2.0 * off(j) }
        });
        self.each("speed", |j| Word::Float(limits[j].qd_max * f64::from(s.overspeed)));
        self.floats("tracking", s.tracking);
        self.one("lasting error", Word::Cut(f64::from(s.tracking_s) * self.hz));
        self.floats("error window", s.error_window);
        // A count moves the observed speed by the observer's second gain, (1 - p)^2 counts a tick.
        let gain = 1.0 - (-f64::from(config.gains.observer_rad_s) / self.hz).exp();
        let count = LSB.map(|lsb| gain * gain * lsb * self.hz);
        self.each("swing", |j| Word::Float(f64::from(s.swing[j]) + 2.0 * count[j]));
        self.one("period", Word::Cut(0.05 * self.hz));
    }

    fn clock(&mut self, s: &Safety) {
        let clock_hz = f64::from(s.clock_hz);
        let period = clock_hz / self.hz;
        self.one("period", Word::Cut(period));
        self.one("jitter", Word::Cut(period * 0.02));
        self.one("per cycle", Word::Float(1.0 / period));
        self.one("budget", Word::Cut(period * f64::from(s.budget)));
        self.one("window", Word::Cut(clock_hz * 0.09));
        self.one("conversions", Word::Float(f64::from(s.conversions_hz) / clock_hz));
    }

    fn timing(&mut self, config: &Config) {
        let s = &config.safety;
        self.ticks("reset", 0.002);
        self.ticks("settle", 0.012);
        self.ticks("boot", 0.5);
        self.ticks("preload", s.preload_s);
        self.ticks("brake open", s.brake_open_s);
        self.ticks("calm", 0.1);
        self.bump(s.test_move_s.into(), s.test_move.map(f64::from));
        // Half of it is more than the counts that tell a stuck encoder; none where it would show.
        let counts = if config.gains.law == Law::INERTIA_WEIGHTED { 32.0 } else { 96.0 };
        let watch = LSB.map(|lsb| if counts * lsb <= 2e-5 { counts * lsb } else { 0.0 });
        self.bump(0.1, watch);
        let stop_s = f64::from(s.stop_s);
        self.one("stop", Word::Float(stop_s * self.hz));
        self.one("stop per tick", Word::Float(1.0 / (stop_s * self.hz)));
        self.one("stop per s", Word::Float(1.0 / stop_s));
        self.ticks("brake set", s.brake_set_s);
        self.ticks("torque tail", s.torque_tail_s);
        self.ticks("link", s.link_timeout_s);
        self.ticks("jog", s.jog_timeout_s);
        self.ticks("contacts", 0.050);
        // An encoder's noise is one count: less than four is no motion.
        self.each("slip", |j| Word::Cut((f64::from(s.slip[j]) / LSB[j]).max(4.0)));
        self.each("jog lowest", |j| position(j, REFERENCE.limits[j].q_min));
        self.each("jog highest", |j| position(j, REFERENCE.limits[j].q_max));
        self.each("parked", |j| Word::Cut(f64::from(s.parked_tolerance) / LSB[j]));
    }

    /// A motion out and back.
    fn bump(&mut self, duration_s: f64, amplitude: [f64; JOINTS]) {
        self.ticks("bump", duration_s);
        self.one("bump per tick", Word::Float(1.0 / (duration_s * self.hz)));
        self.one("bump per s", Word::Float(1.0 / duration_s));
        self.each("bump words", |j| Word::Float(amplitude[j] / LSB[j] * 64.0));
        self.each("bump", |j| Word::Float(amplitude[j]));
    }
}

fn off(j: usize) -> f64 {
    1e-6 / LSB[j] * 64.0
}

fn position(j: usize, q: f64) -> Word {
    Word::Position { words: (q - REFERENCE.encoders[j].zero) / LSB[j] * 64.0, off: off(j) }
}

/// Valid safeties around the reference: every number at 0.5 to 1.9 times its own.
fn safeties() -> impl Strategy<Value = Safety> {
    let words = size_of::<Safety>() / 4;
    proptest::collection::vec(0.5f32..1.9, words).prop_map(|factors| {
        let mut s = Safety::REFERENCE;
        let numbers: &mut [f32] = bytemuck::cast_slice_mut(bytemuck::bytes_of_mut(&mut s));
        numbers.iter_mut().zip(&factors).for_each(|(number, factor)| *number *= factor);
        s.clock_hz = (168e6 * factors[0]) as u32;
        s.torque_reserve = s.torque_reserve.clamp(0.1, 1.0);
        s.overspeed = s.overspeed.clamp(1.0, 3.0);
        s.budget = s.budget.clamp(0.05, 0.95);
        s
    })
}

proptest! {
    #[test]
    fn every_threshold_follows_from_the_configuration(
        safety in safeties(), tick_hz in proptest::sample::select(vec![1_000u32, 2_000, 4_000, 8_000]),
        law in 0..4u32,
    ) {
        let mut config = Config { safety, ..Config::for_arm(&REFERENCE, tick_hz) };
        config.gains.law = Law(law);
        prop_assert_eq!(config.validate(), Ok(()));
        let mut thresholds: Thresholds = bytemuck::zeroed();
        thresholds.set(&config);
        let words: &[u32] = bytemuck::cast_slice(bytemuck::bytes_of(&thresholds));
        let expected = expected(&config);
        prop_assert_eq!(words.len(), expected.len());
        for (n, (&bits, (name, word))) in words.iter().zip(&expected).enumerate() {
            let float = f32::from_bits(bits);
            prop_assert!(word.fits(bits), "{name}, word {n}: {bits} or {float}, not {word:?}");
        }
    }
}
