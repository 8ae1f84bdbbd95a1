//! Seeded random numbers, the same on every machine.

/// SplitMix64 (Steele, Lea and Flood, 2014): one 64-bit state, full period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SplitMix64 {
    state: u64,
}

impl SplitMix64 {
    /// A stream that starts at `seed`.
    pub fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// The next 64 random bits.
    pub fn next_bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number in `[-1, 1)`, from the upper 53 bits.
    pub fn symmetric(&mut self) -> f64 {
        2.0 * ((self.next_bits() >> 11) as f64 / (1u64 << 53) as f64) - 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_numbers_of_the_published_stream() {
        let mut stream = SplitMix64::new(17);
        let expected = [0.00404238, -0.217132642, -0.343340371, -0.552207614, -0.96548195];
        for value in expected {
            assert!((stream.symmetric() - value).abs() < 1e-9);
        }
    }
}
