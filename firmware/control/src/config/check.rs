//! Refusal of a configuration, by the name of what is wrong with it.

/// Why a configuration cannot be used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConfigError {
    /// Its bytes are not those that its check sum was made of.
    Damaged,
    /// A value is not a number within its range.
    OutOfRange {
        /// Name of the field.
        field: &'static str,
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
            Self::OutOfRange { field, .. } => field,
        }
    }
}

impl core::fmt::Display for ConfigError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Damaged => write!(f, "the configuration does not fit its check sum"),
            Self::OutOfRange { field, index, value, min, max } => {
                write!(f, "{field}[{index}] = {value} is outside {min} to {max}")
            }
        }
    }
}

/// What validation found first. It goes on after that, so that no value needs a way out of its own.
pub(crate) struct Check(pub Result<(), ConfigError>);

impl Check {
    #[inline(never)]
    pub fn all(&mut self, field: &'static str, values: &[f32], min: f32, max: f32) {
        for (i, &value) in values.iter().enumerate() {
            self.one(field, i, value, min, max);
        }
    }

    /// A NaN lies within nothing.
    #[inline(never)]
    pub fn one(&mut self, field: &'static str, index: usize, value: f32, min: f32, max: f32) {
        if self.0.is_ok() && !(value >= min && value <= max) {
            self.0 = Err(ConfigError::OutOfRange { field, index, value, min, max });
        }
    }
}
