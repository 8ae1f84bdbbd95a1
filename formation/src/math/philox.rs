//! Random numbers by their place instead of their order: counter-based streams.

/// Philox4x32-10 (Salmon, Moraes, Dror and Shaw, SC 2011): 128 random bits as a pure function of a key and a counter.
pub fn philox(key: [u32; 2], counter: [u32; 4]) -> [u32; 4] {
    let product = |factor: u32, word: u32| {
        let product = u64::from(factor) * u64::from(word);
        ((product >> 32) as u32, product as u32)
    };
    let ([mut a, mut b], [mut w, mut x, mut y, mut z]) = (key, counter);
    for _ in 0..10 {
        let (high0, low0) = product(0xD251_1F53, w);
        let (high1, low1) = product(0xCD9E_8D57, y);
        [w, x, y, z] = [high1 ^ x ^ a, low1, high0 ^ z ^ b, low0];
        (a, b) = (a.wrapping_add(0x9E37_79B9), b.wrapping_add(0xBB67_AE85));
    }
    [w, x, y, z]
}

/// The random numbers of one object, such as the link from agent 2 to agent 5: a number is a pure function of the seed, the name of the
/// object, the count (a step) and its place among the numbers of that count. So no other object, no order and no process has any
/// influence on it.
///
/// ```
/// use formation::math::RandomStream;
/// let link = RandomStream::new(7, "link 2 -> 5");
/// assert_eq!(link.uniform(100, 0), RandomStream::new(7, "link 2 -> 5").uniform(100, 0));
/// assert_ne!(link.uniform(100, 0), RandomStream::new(7, "link 5 -> 2").uniform(100, 0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RandomStream {
    key: [u32; 2],
    object: [u32; 2],
}

impl RandomStream {
    /// The numbers of the object of this name in a run with this seed.
    pub fn new(seed: u64, object: &str) -> Self {
        // FNV-1a (Fowler, Noll and Vo), 64 bits.
        let hash = object
            .bytes()
            .fold(0xCBF2_9CE4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3));
        Self { key: halves(seed), object: halves(hash) }
    }

    /// Two times 64 random bits.
    fn bits(&self, count: u64, place: u32) -> [u64; 2] {
        let [low, high] = halves(count);
        let [object, other] = self.object;
        let [w, x, y, z] = philox(self.key, [low, place ^ high.rotate_left(16), object, other]);
        [u64::from(w) | u64::from(x) << 32, u64::from(y) | u64::from(z) << 32]
    }

    /// A number in [0, 1), from 53 bits.
    pub fn uniform(&self, count: u64, place: u32) -> f64 {
        (self.bits(count, place)[0] >> 11) as f64 * UNIT
    }

    /// A standard normal number, by the method of Box and Muller (1958).
    pub fn normal(&self, count: u64, place: u32) -> f64 {
        let [radius, turn] = self.bits(count, place).map(|bits| ((bits >> 11) + 1) as f64 * UNIT);
        (-2.0 * libm::log(radius)).sqrt() * libm::cos(std::f64::consts::TAU * turn)
    }
}

/// 2^-53.
const UNIT: f64 = 1.0 / (1_u64 << 53) as f64;

fn halves(word: u64) -> [u32; 2] {
    [word as u32, (word >> 32) as u32]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_answers() {
        // kat_vectors of Random123 1.09.
        const ONES: u32 = u32::MAX;
        let answers = [
            ([0; 2], [0; 4], [0x6627_E8D5, 0xE169_C58D, 0xBC57_AC4C, 0x9B00_DBD8]),
            ([ONES; 2], [ONES; 4], [0x408F_276D, 0x41C8_3B0E, 0xA20B_C7C6, 0x6D54_51FD]),
            (
                [0xA409_3822, 0x299F_31D0],
                [0x243F_6A88, 0x85A3_08D3, 0x1319_8A2E, 0x0370_7344],
                [0xD16C_FE09, 0x94FD_CCEB, 0x5001_E420, 0x2412_6EA1],
            ),
        ];
        for (key, counter, expected) in answers {
            assert_eq!(philox(key, counter), expected);
        }
    }

    #[test]
    fn numbers_have_their_distribution_and_are_independent() {
        const COUNT: u64 = 20_000;
        let (one, other) = (RandomStream::new(1, "link 1 -> 2"), RandomStream::new(1, "link 2 -> 1"));
        let mean = |of: &dyn Fn(u64) -> f64| (0..COUNT).map(of).sum::<f64>() / COUNT as f64;
        // The standard error of the mean of a standard normal number is 0.007.
        assert!((mean(&|k| one.uniform(k, 0)) - 0.5).abs() < 0.01);
        assert!(mean(&|k| one.normal(k, 0)).abs() < 0.03);
        assert!((mean(&|k| one.normal(k, 0).powi(2)) - 1.0).abs() < 0.05);
        assert!(mean(&|k| one.normal(k, 0) * one.normal(k + 1, 0)).abs() < 0.03);
        assert!(mean(&|k| one.normal(k, 0) * one.normal(k, 1)).abs() < 0.03);
        assert!(mean(&|k| one.normal(k, 0) * other.normal(k, 0)).abs() < 0.03);
        assert!(mean(&|k| one.normal(k, 0) * RandomStream::new(2, "link 1 -> 2").normal(k, 0)).abs() < 0.03);
    }
}
