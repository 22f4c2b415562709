//! Refusal of a configuration, by the name of what is wrong with it.

use super::fields::{Field, LIMITS, Reading, SHAPES};

/// Why a configuration cannot be used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConfigError {
    /// Its bytes are not those that its check sum was made of.
    Damaged,
    /// A value is not a number within its range.
    OutOfRange {
        /// The field.
        field: Field,
        /// Which element of it, counted from 0.
        index: usize,
        /// What was found.
        value: f32,
        /// Lowest value allowed.
        min: f32,
        /// Highest value allowed.
        max: f32,
    },
}

impl ConfigError {
    /// Name of what is wrong.
    pub fn field(&self) -> &'static str {
        match self {
            Self::Damaged => "check sum",
            Self::OutOfRange { field, .. } => field.name(),
        }
    }
}

impl core::fmt::Display for ConfigError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Damaged => write!(f, "the configuration does not fit its check sum"),
            Self::OutOfRange { field, index, value, min, max } => {
                write!(f, "{}[{index}] = {value} is outside {min} to {max}", field.name())
            }
        }
    }
}

/// What validation found first. It goes on after that, so that no value needs a way out of its own.
pub(crate) struct Check {
    pub found: Result<(), ConfigError>,
    tick_hz: f32,
}

impl Check {
    /// For a configuration of this tick rate.
    pub fn new(tick_hz: f32) -> Self {
        Self { found: Ok(()), tick_hz }
    }

    /// Checks the words of a group whose first field is `first`, the `turn`-th of its kind, by the table.
    #[inline(never)]
    pub fn group(&mut self, first: Field, turn: usize, words: &[u32]) {
        let mut words = words.iter();
        let rules = LIMITS.iter().zip(&SHAPES).enumerate();
        for (n, (&[min, max], shape)) in rules.skip(first.number()) {
            let max = match shape.reading {
                Reading::RATE => max * self.tick_hz,
                Reading::RATE_SQUARED => max * (self.tick_hz * self.tick_hz),
                Reading::TIME => max / self.tick_hz,
                _ => max,
            };
            let count = usize::from(shape.count);
            for index in 0..count {
                let Some(&word) = words.next() else { return };
                let value = match shape.reading {
                    Reading::RELATED => continue,
                    Reading::WHOLE => word as f32,
                    _ => f32::from_bits(word),
                };
                self.one(Field::numbered(n), turn * count + index, value, min, max);
            }
        }
    }

    /// A NaN lies within nothing.
    #[inline(never)]
    pub fn one(&mut self, field: Field, index: usize, value: f32, min: f32, max: f32) {
        if self.found.is_ok() && !(value >= min && value <= max) {
            self.found = Err(ConfigError::OutOfRange { field, index, value, min, max });
        }
    }
}
