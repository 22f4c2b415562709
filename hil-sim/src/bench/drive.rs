//! Torque drives: sources that follow the DAC at once, unless something is wrong with them.

/// What is wrong with a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveFault {
    /// Its enable does not arrive, whatever the pin says.
    pub lost: bool,
    /// While enabled it gives this share of full scale, -1 to 1, whatever the DAC says.
    pub stuck: Option<f64>,
    /// It gives the opposite torque.
    pub inverted: bool,
    /// Highest share of full scale that it gives, 0 to 1.
    pub limit: f64,
}

impl DriveFault {
    /// A sound drive.
    pub const NONE: Self = Self { lost: false, stuck: None, inverted: false, limit: 1.0 };

    /// What an enabled drive gives for `command`, shares of full scale.
    pub(super) fn output(&self, command: f64) -> f64 {
        if self.lost {
            return 0.0;
        }
        let sign = if self.inverted { -1.0 } else { 1.0 };
        self.stuck.unwrap_or((sign * command).clamp(-self.limit, self.limit))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sound_drive_gives_what_it_is_told() {
        assert_eq!([-1.0, 0.3].map(|command| DriveFault::NONE.output(command)), [-1.0, 0.3]);
    }

    #[test]
    fn each_fault_changes_the_output() {
        let inverted = DriveFault { inverted: true, ..DriveFault::NONE };
        let limited = DriveFault { limit: 0.2, ..DriveFault::NONE };
        let stuck = DriveFault { stuck: Some(-0.5), ..inverted };
        let lost = DriveFault { lost: true, ..stuck };
        assert_eq!(
            [inverted, limited, stuck, lost].map(|f| f.output(-0.3)),
            [0.3, -0.2, -0.5, 0.0]
        );
    }
}
