//! Random numbers of our own, so that no update of a dependency changes a trace.

/// SplitMix64 (Steele, Lea, Flood 2014). Each user has a stream of its own, derived from the seed and a number, so
/// that one more node or fault does not change what the others draw.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Rng {
    state: u64,
}

impl Rng {
    /// The stream `stream` of `seed`.
    #[must_use]
    pub fn new(seed: u64, stream: u64) -> Self {
        let mut rng = Self { state: seed ^ stream.wrapping_mul(GOLDEN_GAMMA).rotate_left(17) };
        // Neighbouring seeds and streams differ in few bits: two draws mix them.
        let (high, low) = (rng.next_u64(), rng.next_u64());
        Self { state: high ^ low.rotate_left(32) }
    }

    /// 64 random bits.
    pub fn next_u64(&mut self) -> u64 {
        self.state = self.state.wrapping_add(GOLDEN_GAMMA);
        let mixed = (self.state ^ self.state >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ mixed >> 31
    }

    /// A number below `bound`; zero if `bound` is zero.
    pub fn below(&mut self, bound: u64) -> u64 {
        // The high half of a product is uniform but for a bias below 2^-64 * bound.
        ((u128::from(self.next_u64()) * u128::from(bound)) >> 64) as u64
    }

    /// `true` with a probability of `threshold` / 2^64; see [`threshold`].
    pub fn chance(&mut self, threshold: u64) -> bool {
        threshold == u64::MAX || self.next_u64() < threshold
    }
}

/// A probability as a threshold for [`Rng::chance`]. Only multiplication and truncation, which are the same on every
/// machine.
#[must_use]
pub fn threshold(probability: f64) -> u64 {
    // `as` saturates, and takes NaN for zero.
    (probability * TWO_TO_64) as u64
}

/// Gaps between events that happen with one probability in each step, without a logarithm, whose last digit may differ
/// from machine to machine: the binary digits of a geometric variable are independent, and digit `k` is one with the
/// probability `q / (1 + q)` where `q = (1 - p)^(2^k)`.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Gaps {
    digits: [u64; GAP_DIGITS],
}

impl Gaps {
    /// Events of probability `probability` a step.
    #[must_use]
    pub fn new(probability: f64) -> Self {
        let mut none = 1.0 - probability.clamp(0.0, 1.0);
        let digits = std::array::from_fn(|_| {
            let digit = threshold(none / (1.0 + none));
            none *= none;
            digit
        });
        Self { digits }
    }

    /// How many steps without an event come before the next event.
    pub fn draw(&self, rng: &mut Rng) -> u64 {
        self.digits
            .iter()
            .enumerate()
            .fold(0, |gap, (k, &digit)| gap | u64::from(rng.next_u64() < digit) << k)
    }
}

const GOLDEN_GAMMA: u64 = 0x9E37_79B9_7F4A_7C15;
const TWO_TO_64: f64 = 18_446_744_073_709_551_616.0;
/// Gaps are shorter than 2^40 steps: twelve days at 1 Mbit/s.
const GAP_DIGITS: usize = 40;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stream_is_what_it_always_was() {
        // The first outputs of SplitMix64 with state 0 (Vigna's reference program).
        let mut rng = Rng { state: 0 };
        assert_eq!(rng.next_u64(), 0xE220_A839_7B1D_CDAF);
        assert_eq!(rng.next_u64(), 0x6E78_9E6A_A1B9_65F4);
    }

    #[test]
    fn gaps_have_the_mean_of_a_geometric_variable() {
        for probability in [0.5, 0.1, 0.001] {
            let (gaps, mut rng) = (Gaps::new(probability), Rng::new(1, 2));
            let draws = 20_000;
            let sum: u64 = (0..draws).map(|_| gaps.draw(&mut rng)).sum();
            let (mean, expected) = (sum as f64 / f64::from(draws), (1.0 - probability) / probability);
            assert!(
                (mean / expected - 1.0).abs() < 0.05,
                "p {probability}: mean {mean}, expected {expected}"
            );
        }
    }

    #[test]
    fn certain_and_impossible() {
        let mut rng = Rng::new(1, 1);
        assert_eq!(Gaps::new(1.0).draw(&mut rng), 0);
        assert!(Gaps::new(0.0).draw(&mut rng) > 1 << 20);
        assert!((0..1_000).all(|_| rng.chance(threshold(1.0))));
        assert!((0..1_000).all(|_| !rng.chance(threshold(0.0))));
        assert!((0..1_000).all(|_| rng.below(7) < 7));
    }
}
