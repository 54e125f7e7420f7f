//! Cholesky factorization in envelope form of several matrices at once, of at most some hundred
//! unknowns: no symbolic phase.

/// Envelope of a symmetric matrix: each row of the lower triangle from its first entry to the
/// diagonal. The factor of the matrix has the same envelope. `N` matrices with one envelope are
/// factorized together: an entry holds the values of all of them.
#[derive(Clone, Debug)]
pub struct Envelope {
    /// Column of the first entry of each row.
    first: Vec<usize>,
    /// Start of each row in the values; one more at the end.
    start: Vec<usize>,
}

impl Envelope {
    /// The envelope whose row `i` begins in column `first[i]`, which is at most `i`.
    pub fn new(first: Vec<usize>) -> Self {
        let mut start = vec![0];
        for (i, &f) in first.iter().enumerate() {
            start.push(start[i] + i + 1 - f);
        }
        Self { first, start }
    }

    /// Number of unknowns of each matrix.
    pub fn unknowns(&self) -> usize {
        self.first.len()
    }

    /// The values of a matrix of zeros.
    pub fn zeros(&self) -> Vec<f64> {
        vec![0.0; self.start[self.unknowns()]]
    }

    /// Adds `factor` times a vector to row `i` of a matrix: `entries` are columns of the envelope, of
    /// which those beyond the diagonal are ignored.
    #[inline]
    pub fn add_to_row(
        &self,
        values: &mut [f64],
        i: usize,
        factor: f64,
        entries: impl IntoIterator<Item = (usize, f64)>,
    ) {
        let first = self.first[i];
        let row = &mut values[self.start[i]..self.start[i + 1]];
        for (j, value) in entries {
            if j <= i {
                row[j - first] += factor * value;
            }
        }
    }

    /// Replaces matrices by their Cholesky factors. The factor of a matrix that is not positive definite
    /// has NaN on its diagonal.
    pub fn factorize<const N: usize>(&self, values: &mut [[f64; N]]) {
        pulp::Arch::new().dispatch(
            #[inline(always)]
            || self.factorize_here(values),
        );
    }

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled once per instruction set")]
    fn factorize_here<const N: usize>(&self, values: &mut [[f64; N]]) {
        for (i, &begin) in self.first.iter().enumerate() {
            let (above, row) = values.split_at_mut(self.start[i]);
            let row = &mut row[..=i - begin];
            for j in begin..i {
                let other = &above[self.start[j]..self.start[j + 1]];
                let common = begin.max(self.first[j]);
                let sum = dot(
                    &row[common - begin..j - begin],
                    &other[common - self.first[j]..],
                );
                let diagonal = other[j - self.first[j]];
                let entry = &mut row[j - begin];
                for k in 0..N {
                    entry[k] = (entry[k] - sum[k]) / diagonal[k];
                }
            }
            let sum = dot(&row[..i - begin], &row[..i - begin]);
            let diagonal = &mut row[i - begin];
            for k in 0..N {
                let pivot = diagonal[k] - sum[k];
                diagonal[k] = if pivot > 0.0 { pivot.sqrt() } else { f64::NAN };
            }
        }
    }

    /// Replaces the coordinates of the right-hand sides of all matrices by the solutions, given the
    /// factors.
    pub fn solve_in_place<const N: usize, const D: usize>(
        &self,
        factors: &[[f64; N]],
        rhs: &mut [[[f64; N]; D]],
    ) {
        pulp::Arch::new().dispatch(
            #[inline(always)]
            || self.solve_here(factors, rhs),
        );
    }

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled once per instruction set")]
    fn solve_here<const N: usize, const D: usize>(
        &self,
        factors: &[[f64; N]],
        rhs: &mut [[[f64; N]; D]],
    ) {
        let row = |i: usize| factors[self.start[i]..self.start[i + 1]].split_last();
        // value −= factor · other, or value /= factor
        let subtract = |value: &mut [[f64; N]; D], factor: &[f64; N], other: &[[f64; N]; D]| {
            for d in 0..D {
                for k in 0..N {
                    value[d][k] -= factor[k] * other[d][k];
                }
            }
        };
        let divide = |value: &mut [[f64; N]; D], factor: &[f64; N]| {
            for d in 0..D {
                for k in 0..N {
                    value[d][k] /= factor[k];
                }
            }
        };
        for (i, &begin) in self.first.iter().enumerate() {
            let Some((diagonal, row)) = row(i) else {
                return;
            };
            let mut own = rhs[i];
            for (l, x) in row.iter().zip(&rhs[begin..i]) {
                subtract(&mut own, l, x);
            }
            divide(&mut own, diagonal);
            rhs[i] = own;
        }
        for (i, &begin) in self.first.iter().enumerate().rev() {
            let Some((diagonal, row)) = row(i) else {
                return;
            };
            divide(&mut rhs[i], diagonal);
            let own = rhs[i];
            for (l, x) in row.iter().zip(&mut rhs[begin..i]) {
                subtract(x, l, &own);
            }
        }
    }
}

/// Scalar products of the first `a.len()` entries, in two partial sums, which the processor adds in
/// parallel.
#[inline(always)]
#[expect(clippy::inline_always, reason = "compiled once per instruction set")]
fn dot<const N: usize>(a: &[[f64; N]], b: &[[f64; N]]) -> [f64; N] {
    let b = &b[..a.len()];
    let (pairs, rest) = a.as_chunks::<2>();
    let (other_pairs, other_rest) = b.as_chunks::<2>();
    let mut sums = [[0.0; N]; 2];
    for (a, b) in pairs.iter().zip(other_pairs) {
        for part in 0..2 {
            for k in 0..N {
                sums[part][k] += a[part][k] * b[part][k];
            }
        }
    }
    for (a, b) in rest.iter().zip(other_rest) {
        for k in 0..N {
            sums[0][k] += a[k] * b[k];
        }
    }
    let [mut sum, other] = sums;
    for k in 0..N {
        sum[k] += other[k];
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix;

    /// Factors of a matrix: itself, its half and its negative.
    const SCALES: [f64; 3] = [1.0, 0.5, -1.0];

    #[test]
    fn random_envelopes_are_solved() {
        let mut rng = SplitMix::new(3);
        for n in [1, 2, 7, 40] {
            let first = (0..n).map(|i| i - rng.below(i + 1).min(9)).collect();
            let envelope = Envelope::new(first);
            let mut values = envelope.zeros();
            let mut dense = vec![vec![0.0; n]; n];
            for i in 0..n {
                let entry = |j| (j, if i == j { 20.0 } else { rng.unit() - 0.5 });
                let row: Vec<(usize, f64)> = (envelope.first[i]..=i).map(entry).collect();
                for &(j, value) in &row {
                    (dense[i][j], dense[j][i]) = (2.0 * value, 2.0 * value);
                }
                // an entry beyond the diagonal is not one of the envelope
                let beyond = [(n, f64::NAN)];
                envelope.add_to_row(&mut values, i, 2.0, row.into_iter().chain(beyond));
            }
            let mut factors: Vec<[f64; 3]> = values.iter().map(|a| SCALES.map(|s| s * a)).collect();
            let x: Vec<f64> = (0..n).map(|_| rng.unit()).collect();
            let product = |row: &Vec<f64>| row.iter().zip(&x).map(|(a, x)| a * x).sum();
            let right: Vec<f64> = dense.iter().map(product).collect();
            let mut solution: Vec<[[f64; 3]; 1]> = right.iter().map(|b| [[*b; 3]]).collect();
            envelope.factorize(&mut factors);
            envelope.solve_in_place(&factors, &mut solution);
            for ([[whole, half, negative]], x) in solution.iter().zip(&x) {
                assert!((whole - x).abs() < 1e-14 && (half - 2.0 * x).abs() < 1e-14);
                assert!(negative.is_nan());
            }
        }
    }

    #[test]
    fn pivots_that_are_not_positive_are_found() {
        let envelope = Envelope::new(vec![0, 1, 0]);
        for bad in [0.0, -1.0, f64::NAN] {
            let mut values = [1.0, bad, 0.0, 0.0, 1.0].map(|a| [a, 1.0]);
            values[3][1] = 0.5;
            values[2][1] = 0.5;
            envelope.factorize(&mut values);
            let diagonal = [values[0], values[1], values[4]];
            assert!(diagonal.iter().any(|d| d[0].is_nan()));
            assert!(diagonal.iter().all(|d| d[1] > 0.0));
        }
    }
}
