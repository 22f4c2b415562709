//! Every field of the configuration with its range, in the order of the words.
//!
//! Names serve whoever reads an error: a target that shows none does not hold them.

/// A field of the configuration, by its place in the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Field(u8);

/// How a field's words are read, and what its highest value is a multiple of.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct Reading(u8);

impl Reading {
    /// A number.
    const NUMBER: Self = Self(0);
    /// A whole number.
    pub const WHOLE: Self = Self(1);
    /// A number; the limit is per tick.
    pub const RATE: Self = Self(2);
    /// A number; the limit is per tick squared.
    pub const RATE_SQUARED: Self = Self(3);
    /// A number; the limit is in ticks.
    pub const TIME: Self = Self(4);
    /// A number whose range depends on other fields: not checked by the table.
    pub const RELATED: Self = Self(5);
}

/// How many words a field has, and how each is read.
#[derive(Clone, Copy)]
pub(super) struct Shape {
    pub count: u8,
    pub reading: Reading,
}

/// What the table says of a field.
#[derive(Clone, Copy)]
struct Rule {
    limits: [f32; 2],
    shape: Shape,
}

type Row = (&'static str, Rule);

const fn of(name: &'static str, count: u8, reading: Reading, min: f32, max: f32) -> Row {
    (name, Rule { limits: [min, max], shape: Shape { count, reading } })
}

const fn row(name: &'static str, count: u8, min: f32, max: f32) -> Row {
    of(name, count, Reading::NUMBER, min, max)
}

const fn related(name: &'static str) -> Row {
    of(name, 1, Reading::RELATED, 0.0, 0.0)
}

const COUNT: usize = 60;

const TABLE: [Row; COUNT] = [
    of("tick_hz", 1, Reading::WHOLE, super::TICK_HZ_MIN as f32, super::TICK_HZ_MAX as f32),
    // Arm.
    row("geometry_m", 5, -20.0, 20.0),
    row("links.mass_kg", 1, 1.0, 20_000.0),
    row("com_m", 3, -20.0, 20.0),
    row("inertia_com_kg_m2 moments", 3, 0.0, 1e6),
    row("inertia_com_kg_m2 products", 3, -1e6, 1e6),
    row("payload.mass_kg", 1, 0.0, 5_000.0),
    row("com_m", 3, -20.0, 20.0),
    row("inertia_com_kg_m2 moments", 3, 0.0, 1e6),
    row("inertia_com_kg_m2 products", 3, -1e6, 1e6),
    row("gravity_m_s2", 1, 0.0, 20.0),
    // Joint.
    row("q_min", 1, -60.0, 60.0),
    related("q_max"),
    row("qd_max", 1, 1e-3, 10.0),
    row("tau_max", 1, 1.0, 1e6),
    of("encoder_bits", 1, Reading::WHOLE, super::joint::BITS_MIN, super::joint::BITS_MAX),
    row("encoder_lsb", 1, 1e-9, 1e-3),
    related("encoder_zero"),
    of("latch_offset_s", 1, Reading::TIME, 0.0, 0.5),
    related("drive_full_scale"),
    related("torque_full_scale"),
    related("qd_max against encoder_lsb"),
    // Gains; discrete stability wants each first-order pole well inside the tick rate.
    of("law", 1, Reading::WHOLE, 0.0, super::Law::PD.0 as f32),
    of("k1", 4, Reading::RATE, 1.0, 0.5),
    of("k2", 4, Reading::RATE, 1.0, 0.5),
    row("wa_rad_s", 1, 0.0, 200.0),
    row("psi", 4, 0.0, 1e12),
    row("d_max", 4, 0.0, 1e6),
    of("kp", 4, Reading::RATE_SQUARED, 0.0, 0.25),
    of("kd", 4, Reading::RATE, 0.0, 0.5),
    of("observer_rad_s", 1, Reading::RATE, 10.0, 3.0),
    // Safety.
    row("stop_s", 1, 0.05, 1.0),
    row("preload_s", 1, 0.005, 1.0),
    row("brake_open_s", 1, 0.02, 5.0),
    row("brake_set_s", 1, 0.02, 5.0),
    row("torque_tail_s", 1, 0.0, 1.0),
    row("test_move_s", 1, 0.05, 5.0),
    row("test_move", 4, 1e-5, 1e-2),
    row("link_timeout_s", 1, 0.02, 10.0),
    row("jog_timeout_s", 1, 0.02, 1.0),
    row("rest_pose", 3, -60.0, 60.0),
    row("lowering_share", 1, 0.01, 0.5),
    row("rated_payload_kg", 1, 0.0, 5_000.0),
    row("torque_reserve", 1, 0.1, 1.0),
    row("parked_tolerance", 1, 1e-3, 1.0),
    row("unforeseen", 4, 0.1, 1e3),
    row("violent", 4, 1.0, 1e4),
    row("torque_warn", 4, 1.0, 1e6),
    row("torque_wrong", 4, 1.0, 1e6),
    row("speed_error", 4, 1e-4, 10.0),
    row("swing", 4, 1e-5, 10.0),
    row("tracking", 4, 1e-5, 1.0),
    row("tracking_s", 1, 0.005, 5.0),
    row("error_window", 4, 1e-4, 1.0),
    row("overspeed", 1, 1.0, 3.0),
    row("overtravel", 4, 0.0, 1.0),
    row("slip", 4, 1e-7, 1e-2),
    of("clock_hz", 1, Reading::WHOLE, 1e6, 1e9),
    row("budget", 1, 0.05, 0.95),
    row("conversions_hz", 1, 2e3, 1e6),
];

/// The table without its names, in two pieces so that no word is half empty.
pub(super) static LIMITS: [[f32; 2]; COUNT] = {
    let mut limits = [[0.0; 2]; COUNT];
    let mut n = 0;
    while n < COUNT {
        limits[n] = TABLE[n].1.limits;
        n += 1;
    }
    limits
};

/// See [`LIMITS`].
pub(super) static SHAPES: [Shape; COUNT] = {
    let mut shapes = [TABLE[0].1.shape; COUNT];
    let mut n = 0;
    while n < COUNT {
        shapes[n] = TABLE[n].1.shape;
        n += 1;
    }
    shapes
};

impl Field {
    /// Name as errors show it.
    pub fn name(self) -> &'static str {
        TABLE.get(self.number()).map_or("", |(name, _)| name)
    }

    /// The first of this name, for use in constants.
    pub(super) const fn named(name: &str) -> Self {
        let mut n = 0;
        while !is_same(TABLE[n].0.as_bytes(), name.as_bytes()) {
            n += 1;
        }
        Self(n as u8)
    }

    pub(super) const fn numbered(number: usize) -> Self {
        Self(number as u8)
    }

    pub(super) const fn number(self) -> usize {
        self.0 as usize
    }
}

const fn is_same(a: &[u8], b: &[u8]) -> bool {
    let mut same = a.len() == b.len();
    let mut i = 0;
    while same && i < a.len() {
        same = a[i] == b[i];
        i += 1;
    }
    same
}
