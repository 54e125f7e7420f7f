//! Cholesky factorization in envelope form, for matrices of at most some hundred unknowns: no
//! symbolic phase.

use glam::DVec3;

use super::LinearError;

/// Envelope of a symmetric matrix: each row of the lower triangle from its first entry to the
/// diagonal. The factor of the matrix has the same envelope.
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

    /// The values of a matrix of zeros.
    pub fn zeros(&self) -> Vec<f64> {
        vec![0.0; self.start[self.first.len()]]
    }

    /// Adds `factor` times a vector to row `i`: `entries` are columns of the envelope, of which those
    /// beyond the diagonal are ignored.
    pub fn add_to_row(
        &self,
        values: &mut [f64],
        i: usize,
        factor: f64,
        entries: impl Iterator<Item = (usize, f64)>,
    ) {
        let row = &mut values[self.start[i]..self.start[i + 1]];
        for (j, value) in entries.filter(|e| e.0 <= i) {
            row[j - self.first[i]] += factor * value;
        }
    }

    /// Replaces a matrix by its Cholesky factor.
    ///
    /// # Errors
    /// [`LinearError::NotPositiveDefinite`] with the first row whose pivot is not positive.
    pub fn factorize(&self, values: &mut [f64]) -> Result<(), LinearError> {
        for (i, &begin) in self.first.iter().enumerate() {
            let (above, row) = values.split_at_mut(self.start[i]);
            let row = &mut row[..=i - begin];
            for j in begin..i {
                let other = &above[self.start[j]..self.start[j + 1]];
                let common = begin.max(self.first[j]);
                let own = &row[common - begin..j - begin];
                let sum = dot(own, &other[common - self.first[j]..]);
                row[j - begin] = (row[j - begin] - sum) / other[j - self.first[j]];
            }
            let pivot = row[i - begin] - dot(&row[..i - begin], &row[..i - begin]);
            if pivot.is_nan() || pivot <= 0.0 {
                return Err(LinearError::NotPositiveDefinite { index: i });
            }
            row[i - begin] = pivot.sqrt();
        }
        Ok(())
    }

    /// Replaces `rhs` by the solution, given the factor.
    pub fn solve_in_place(&self, factor: &[f64], rhs: &mut [DVec3]) {
        let row = |i: usize| factor[self.start[i]..self.start[i + 1]].split_last();
        for (i, &begin) in self.first.iter().enumerate() {
            let Some((diagonal, row)) = row(i) else {
                return;
            };
            let pairs = row.iter().zip(&rhs[begin..i]);
            let sum: DVec3 = pairs.map(|(l, x)| *l * *x).sum();
            rhs[i] = (rhs[i] - sum) / *diagonal;
        }
        for (i, &begin) in self.first.iter().enumerate().rev() {
            let Some((diagonal, row)) = row(i) else {
                return;
            };
            let own = rhs[i] / *diagonal;
            rhs[i] = own;
            for (l, x) in row.iter().zip(&mut rhs[begin..i]) {
                *x -= *l * own;
            }
        }
    }
}

/// Scalar product of the first `a.len()` numbers, in four partial sums, which the processor adds in
/// parallel.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let b = &b[..a.len()];
    let (fours, rest) = a.as_chunks::<4>();
    let (other_fours, other_rest) = b.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for (a, b) in fours.iter().zip(other_fours) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    let rest = rest.iter().zip(other_rest).map(|(a, b)| a * b);
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest.sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix;

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
            let x: Vec<DVec3> = (0..n)
                .map(|_| DVec3::new(rng.unit(), rng.unit(), rng.unit()))
                .collect();
            let product = |row: &Vec<f64>| row.iter().zip(&x).map(|(a, x)| *a * *x).sum();
            let mut solution: Vec<DVec3> = dense.iter().map(product).collect();
            envelope.factorize(&mut values).expect("positive definite");
            envelope.solve_in_place(&values, &mut solution);
            let error = solution.iter().zip(&x).map(|(a, b)| a.distance(*b));
            assert!(error.fold(0.0, f64::max) < 1e-14);
        }
    }

    #[test]
    fn the_first_pivot_that_is_not_positive_is_named() {
        let envelope = Envelope::new(vec![0, 1, 0]);
        for bad in [0.0, -1.0, f64::NAN] {
            let found = envelope.factorize(&mut [1.0, bad, 0.0, 0.0, 1.0]);
            assert_eq!(found, Err(LinearError::NotPositiveDefinite { index: 1 }));
        }
    }
}
