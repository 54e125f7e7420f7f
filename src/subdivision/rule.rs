//! Quadrature rules of the parameter triangle.

/// The sample points of the integrand in each triangle. All points of a rule have the same weight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Rule {
    /// 3 points, barycentric (2/3, 1/6, 1/6) and permutations: exact for quadratics.
    Three,
    /// 12 points, the 3 points in each of the 4 sub-triangles (the paper's rule).
    Twelve,
    /// 48 points, the 12 points in each of the 4 sub-triangles.
    FortyEight,
    /// 192 points, the 48 points in each of the 4 sub-triangles.
    OneNinetyTwo,
}

const A: f64 = 1.0 / 6.0;
const B: f64 = 2.0 / 3.0;
const THREE: [[f64; 2]; 3] = [[A, A], [B, A], [A, B]];
const TWELVE: [[f64; 2]; 12] = divided(THREE);
const FORTY_EIGHT: [[f64; 2]; 48] = divided(TWELVE);
const ONE_NINETY_TWO: [[f64; 2]; 192] = divided(FORTY_EIGHT);

/// The points of a rule in the child at each corner, then in the middle one.
const fn divided<const N: usize, const M: usize>(rule: [[f64; 2]; N]) -> [[f64; 2]; M] {
    assert!(M == 4 * N);
    let mut points = [[0.0; 2]; M];
    let mut k = 0;
    while k < N {
        let [v, w] = [0.5 * rule[k][0], 0.5 * rule[k][1]];
        points[k] = [v, w];
        points[N + k] = [0.5 + v, w];
        points[2 * N + k] = [v, 0.5 + w];
        points[3 * N + k] = [0.5 - v, 0.5 - w];
        k += 1;
    }
    points
}

impl Rule {
    /// All rules, from coarse to fine.
    pub const ALL: [Self; 4] = [
        Self::Three,
        Self::Twelve,
        Self::FortyEight,
        Self::OneNinetyTwo,
    ];

    /// The points `(v, w)`.
    pub const fn points(self) -> &'static [[f64; 2]] {
        match self {
            Self::Three => &THREE,
            Self::Twelve => &TWELVE,
            Self::FortyEight => &FORTY_EIGHT,
            Self::OneNinetyTwo => &ONE_NINETY_TWO,
        }
    }

    /// The rule whose points on a triangle are the 12 points of each of the `4^splits` triangles
    /// produced by 1→4 splits. It has at most 192 points.
    pub const fn twelve_after(splits: usize) -> Self {
        match splits {
            0 => Self::Twelve,
            1 => Self::FortyEight,
            _ => Self::OneNinetyTwo,
        }
    }

    /// The weight of each point, such that the integral of `F` over a triangle of the surface is
    /// the sum of `weight * 0.5 * sqrt(g) * F`.
    pub const fn weight(self) -> f64 {
        match self {
            Self::Three => 1.0 / 3.0,
            Self::Twelve => 1.0 / 12.0,
            Self::FortyEight => 1.0 / 48.0,
            Self::OneNinetyTwo => 1.0 / 192.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `int v^i w^j = i! j! / (i + j + 2)!` for total degree 2.
    #[test]
    fn quadratics_are_exact() {
        for rule in Rule::ALL {
            let integral = |f: fn(f64, f64) -> f64| -> f64 {
                let sum: f64 = rule.points().iter().map(|p| f(p[0], p[1])).sum();
                0.5 * rule.weight() * sum
            };
            assert!((integral(|_, _| 1.0) - 0.5).abs() < 1e-15);
            assert!((integral(|v, _| v) - 1.0 / 6.0).abs() < 1e-15);
            assert!((integral(|_, w| w * w) - 1.0 / 12.0).abs() < 1e-15);
            assert!((integral(|v, w| v * w) - 1.0 / 24.0).abs() < 1e-15);
        }
    }
}
