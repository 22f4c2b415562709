//! External window watchdog with the latch that it trips.
//!
//! Two parts watch the same pin: TI TPS3430WDRCR, CWD by 10 kOhm to VDD and SET0 = SET1 = VDD, whose window runs
//! from falling edge to falling edge, tells edges that come too early; ST STWD100NWWY3F, which counts edges of
//! either direction, tells those that come too late. Both release their outputs by themselves, so a latch
//! (SN74LVC1G74) keeps what they told. Every figure is the corner in which torque stays on for longest.

/// Falling edges nearer than this trip for certain: least lower boundary of the window, s (SBVS366A Section 6.6,
/// SBVS264B Table 8-3).
pub const EARLY_S: f64 = 1.48e-3;

/// An edge later than this trips for certain: longest timeout, s (DocID 14134 Table 5).
pub const LATE_S: f64 = 8.6e-3;

/// Feeds further apart than this are regular: usual lower boundary of the window, s (as [`EARLY_S`]).
const REGULAR_S: f64 = 1.85e-3;

/// What the latch holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Latch {
    /// As after power-up: no regular feed has come yet.
    Fresh,
    Closed,
    Tripped,
}

/// The watchdog. On a board an arming edge closes the latch; here the second regular feed does.
#[derive(Clone, Debug)]
pub struct Watchdog {
    latch: Latch,
    level: bool,
    /// Since the last edge of either direction, s.
    since_edge_s: f64,
    /// Since the last falling edge, s; endless before the first.
    since_fall_s: f64,
}

impl Default for Watchdog {
    /// At power-up, its input low.
    fn default() -> Self {
        Self { latch: Latch::Fresh, level: false, since_edge_s: 0.0, since_fall_s: f64::INFINITY }
    }
}

impl Watchdog {
    /// Whether it lets torque flow.
    pub fn is_closed(&self) -> bool {
        self.latch == Latch::Closed
    }

    /// Time since the last falling edge, s.
    pub fn since_fall_s(&self) -> f64 {
        self.since_fall_s
    }

    /// Level at the input.
    pub fn drive(&mut self, high: bool) {
        let falls = self.level && !high;
        if high != self.level {
            self.level = high;
            self.since_edge_s = 0.0;
        }
        if falls {
            self.fall();
        }
    }

    /// Lets `dt_s` pass.
    pub fn advance(&mut self, dt_s: f64) {
        self.since_edge_s += dt_s;
        self.since_fall_s += dt_s;
        if self.latch == Latch::Closed && self.since_edge_s > LATE_S {
            self.latch = Latch::Tripped;
        }
    }

    fn fall(&mut self) {
        let since_s = std::mem::replace(&mut self.since_fall_s, 0.0);
        let regular = (REGULAR_S..=LATE_S).contains(&since_s);
        self.latch = match self.latch {
            Latch::Fresh if regular => Latch::Closed,
            Latch::Closed if since_s < EARLY_S => Latch::Tripped,
            latch => latch,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Toggled this often, `interval_s` apart.
    fn feed(watchdog: &mut Watchdog, edges: u32, interval_s: f64) {
        for _ in 0..edges {
            watchdog.drive(!watchdog.level);
            watchdog.advance(interval_s);
        }
    }

    fn fed() -> Watchdog {
        let mut watchdog = Watchdog::default();
        feed(&mut watchdog, 4, 2e-3);
        watchdog
    }

    #[test]
    fn closes_at_the_second_regular_falling_edge() {
        let mut watchdog = Watchdog::default();
        feed(&mut watchdog, 3, 2e-3);
        assert!(!watchdog.is_closed());
        watchdog.drive(false);
        assert!(watchdog.is_closed());
    }

    #[test]
    fn neither_too_fast_nor_too_slow_feeds_close_it() {
        for interval_s in [0.9e-3, 4.4e-3] {
            let mut watchdog = Watchdog::default();
            feed(&mut watchdog, 100, interval_s);
            assert!(!watchdog.is_closed(), "{interval_s}");
        }
    }

    #[test]
    fn silence_trips_after_the_longest_timeout_and_stays_tripped() {
        for edges in 0..2 {
            let mut watchdog = fed();
            feed(&mut watchdog, edges, 2e-3);
            watchdog.advance(LATE_S - 2.01e-3);
            assert!(watchdog.is_closed());
            watchdog.advance(0.02e-3);
            assert!(!watchdog.is_closed());
            feed(&mut watchdog, 100, 2e-3);
            assert!(!watchdog.is_closed());
        }
    }

    #[test]
    fn falling_edges_too_near_to_each_other_trip_and_others_do_not() {
        for (apart_s, closed) in [(1.47e-3, false), (1.49e-3, true)] {
            let mut watchdog = fed();
            watchdog.drive(true);
            watchdog.drive(false);
            watchdog.advance(apart_s);
            watchdog.drive(true);
            assert!(watchdog.is_closed());
            watchdog.drive(false);
            assert_eq!(watchdog.is_closed(), closed, "{apart_s}");
        }
    }
}
