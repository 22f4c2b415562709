//! Faults injected from outside: into frames on the bus, encoder heads, drives, brakes, load, time, the
//! controller's memory and the operator's hands. The controller under test is not changed.
//!
//! An [`Injection`] is plain data. A session hands all of a scenario's to its [`Injector`], which brings
//! bench and plant to what is wrong at each instant, in the same way whatever controller they are wired to.

mod conditions;
mod frames;
mod help;
mod injector;
mod interference;
mod kind;
mod memory;
mod samples;
mod target;

pub use help::table;
pub use injector::{Edge, Injector, Told};
pub use interference::Interference;
pub use kind::{Kind, SPECS, Severity, Span, Spec};
pub use memory::flip_configuration;
pub use target::{Place, Target};

/// One fault, with its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Injection {
    /// What kind.
    pub kind: Kind,
    /// Where.
    pub target: Target,
    /// Begin after the trajectory's start, s. Before power-up means from power-up on.
    pub at_s: f64,
    /// Duration, s; `None` for what the kind does by itself, see [`Span`].
    pub for_s: Option<f64>,
    /// How much, see [`Spec::severity`]; without meaning where the kind has none.
    pub severity: f64,
}

impl Injection {
    /// A fault of the kind's usual severity and duration; where no severity is usual, the lowest.
    pub fn new(kind: Kind, target: Target, at_s: f64) -> Self {
        let severity = kind.severity(target).map_or(0.0, |s| s.default.unwrap_or(s.bounds.lo));
        Self { kind, target, at_s, for_s: None, severity }
    }
}

impl std::fmt::Display for Injection {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.kind)?;
        if self.target != Target::Only {
            write!(f, " on {}", self.target)?;
        }
        match self.kind.severity(self.target) {
            Some(severity) => {
                // Not that of joint 4 in brackets behind it.
                let unit = severity.bounds.unit.split(" (").next().unwrap_or_default();
                let space = if unit.is_empty() { "" } else { " " };
                write!(f, " ({}{space}{unit})", self.severity)
            }
            None => Ok(()),
        }
    }
}

/// Seed of what is random about one of a scenario's injections: the same whatever the others are.
fn seed_of(scenario_seed: u64, index: usize) -> u64 {
    // Odd, so that no two indices meet: 2⁶⁴ over the golden ratio.
    scenario_seed ^ (index as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn injections_are_told_in_a_few_words() {
        let told = |kind, target| Injection::new(kind, target, 0.0).to_string();
        assert_eq!(told(Kind::Hang, Target::Only), "hang");
        assert_eq!(told(Kind::StuckEncoder, Target::Encoder(2)), "stuck-encoder on encoder3");
        assert_eq!(
            told(Kind::TorqueDrift, Target::Joint(0)),
            "torque-drift on joint1 (1000 N m/s)"
        );
        assert_eq!(told(Kind::FrameLoss, Target::All), "frame-loss on all (1)");
    }
}
