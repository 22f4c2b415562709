//! Emergency stop relay (Pilz PNOZ s5) with its delayed contacts set to 0.4 s.

/// A stop's contact that has been open for this long has opened the delayed contacts for certain, s: set to
/// 0.4 s they open after 480 ms at the latest.
pub const OPEN_S: f64 = 0.5;

/// The relay with both of its input contacts.
#[derive(Clone, Debug, Default)]
pub struct StopRelay {
    /// How long a contact has been open, s.
    open_s: f64,
}

impl StopRelay {
    /// Whether the delayed contacts let torque flow.
    pub fn is_closed(&self) -> bool {
        self.open_s < OPEN_S
    }

    /// Lets `dt_s` pass with the stop's contacts as they are, `true` closed.
    pub fn advance(&mut self, dt_s: f64, contacts: [bool; 2]) {
        self.open_s = if contacts == [true; 2] { 0.0 } else { self.open_s + dt_s };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn either_contact_opens_it_after_its_delay_and_both_close_it() {
        for contacts in [[false, true], [true, false], [false; 2]] {
            let mut relay = StopRelay::default();
            relay.advance(1.0, [true; 2]);
            relay.advance(0.499, contacts);
            assert!(relay.is_closed());
            relay.advance(0.001, contacts);
            assert!(!relay.is_closed());
            relay.advance(1e-3, [true, true]);
            assert!(relay.is_closed());
        }
    }

    #[test]
    fn short_opening_does_not_reach_the_delayed_contacts() {
        let mut relay = StopRelay::default();
        for _ in 0..10 {
            relay.advance(0.3, [false; 2]);
            relay.advance(1e-3, [true; 2]);
        }
        assert!(relay.is_closed());
    }
}
