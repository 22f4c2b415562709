//! Leaky bucket of a device's losses: three in a row are too many, one in three for ever is not.

/// What a lost or refused sample adds.
const MISS: u8 = 2;
/// Level at which the device counts as lost.
const FULL: u8 = 6;

/// Level of one device's bucket.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bucket(u8);

impl Bucket {
    /// Of a device without losses.
    pub const EMPTY: Self = Self(0);
    /// Of a device that never gave a sample.
    pub const FULL: Self = Self(FULL);

    /// Counts a loss; `true` if there have been too many.
    pub fn miss(&mut self) -> bool {
        self.0 = if self.0 + MISS < FULL { self.0 + MISS } else { FULL };
        self.0 == FULL
    }

    /// Counts a good sample.
    #[inline(always)]
    pub fn good(&mut self) {
        self.0 = self.0.saturating_sub(1);
    }

    /// Forgets the losses.
    pub fn empty(&mut self) {
        self.0 = 0;
    }

    /// Present level.
    pub fn level(self) -> u8 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trips(pattern: impl Iterator<Item = bool>) -> Option<usize> {
        let mut bucket = Bucket::default();
        pattern.enumerate().find_map(|(i, lost)| {
            if lost {
                bucket.miss().then_some(i)
            } else {
                bucket.good();
                None
            }
        })
    }

    #[test]
    fn three_in_a_row_trip_and_one_in_three_for_ever_does_not() {
        assert_eq!(trips([true; 3].into_iter()), Some(2));
        assert_eq!(trips([true, true, false].into_iter().chain([false; 9])), None);
        assert_eq!(trips((0..3_000).map(|i| i % 3 == 0)), None);
        assert!(trips((0..3_000).map(|i| i % 2 == 0)).is_some());
        assert_eq!(Bucket::FULL.level(), FULL);
    }
}
