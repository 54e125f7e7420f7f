//! A small random-number generator with a fixed stream, for reproducible meshes and noise.

use std::f64::consts::TAU;

use glam::DVec3;

/// `SplitMix64` (Steele, Lea and Flood 2014): 64 bits of state, every seed good.
#[derive(Clone, Debug)]
pub struct SplitMix {
    state: u64,
}

impl SplitMix {
    /// A separate stream for every seed.
    pub const fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// The next 64 random bits.
    pub const fn next_u64(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform in `0.0..1.0`.
    pub fn unit(&mut self) -> f64 {
        // 53 bits: every value is a multiple of 2^-53
        (self.next_u64() >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
    }

    /// Uniform in `low..high`.
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform in `0..n`; 0 for `n = 0`.
    pub fn below(&mut self, n: usize) -> usize {
        // multiply and shift (Lemire 2019): the bias is below n / 2^64
        ((u128::from(self.next_u64()) * n as u128) >> 64) as usize
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> DVec3 {
        let z = self.range(-1.0, 1.0);
        let (s, c) = self.range(0.0, TAU).sin_cos();
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * c, r * s, z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stream_is_the_published_one() {
        // first outputs for seed 1234567 as in the reference implementation
        let mut rng = SplitMix::new(1_234_567);
        assert_eq!(rng.next_u64(), 6_457_827_717_110_365_317);
        assert_eq!(rng.next_u64(), 3_203_168_211_198_807_973);
    }

    #[test]
    fn directions_are_unit_and_balanced() {
        let mut rng = SplitMix::new(5);
        let mut sum = DVec3::ZERO;
        for _ in 0..10_000 {
            let d = rng.direction();
            assert!((d.length() - 1.0).abs() < 1e-14);
            sum += d;
        }
        // standard deviation of each component's mean is 0.0058
        assert!((sum / 10_000.0).length() < 0.03);
    }
}
