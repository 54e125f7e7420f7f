//! Limited-memory BFGS: the two-loop recursion (Nocedal 1980; Nocedal and Wright, algorithm 7.4).

use std::collections::VecDeque;

/// Number of stored pairs.
const MEMORY: usize = 5;

/// A pair is dropped when its curvature sᵀy is below this fraction of |s||y|.
const CURVATURE: f64 = 1e-10;

/// History of steps and gradient changes that corrects an approximate inverse Hessian.
#[derive(Debug, Clone, Default)]
pub struct Lbfgs {
    pairs: VecDeque<Pair>,
}

#[derive(Debug, Clone)]
struct Pair {
    s: Vec<f64>,
    y: Vec<f64>,
    inverse_curvature: f64,
}

impl Lbfgs {
    /// An empty history: [`Lbfgs::direction`] is then the plain preconditioned descent direction.
    pub fn new() -> Self {
        Self::default()
    }

    /// Removes all pairs, for instance after a new factorization.
    pub fn clear(&mut self) {
        self.pairs.clear();
    }

    /// Adds the step `s` and the change `y` of the gradient over it. Without positive curvature
    /// (sᵀy > 1e-10 |s||y|) the approximation would not be definite; the pair is then ignored and
    /// `false` returned. The oldest of more than 5 pairs is dropped and its memory reused.
    ///
    /// # Panics
    /// If the lengths differ from each other or from those of the stored pairs.
    pub fn push(&mut self, s: &[f64], y: &[f64]) -> bool {
        assert_eq!(s.len(), y.len(), "step and gradient change of one length");
        if let Some(pair) = self.pairs.front() {
            assert_eq!(
                pair.s.len(),
                s.len(),
                "pairs of one length; clear() before another problem"
            );
        }
        let sy = dot(s, y);
        let floor = CURVATURE * (dot(s, s) * dot(y, y)).sqrt();
        // Also rejects values that are not numbers.
        if !(sy > floor && sy.is_finite()) {
            return false;
        }
        let mut pair = if self.pairs.len() == MEMORY {
            self.pairs.pop_front()
        } else {
            None
        }
        .unwrap_or_else(|| Pair {
            s: vec![0.0; s.len()],
            y: vec![0.0; s.len()],
            inverse_curvature: 0.0,
        });
        pair.s.copy_from_slice(s);
        pair.y.copy_from_slice(y);
        pair.inverse_curvature = 1.0 / sy;
        self.pairs.push_back(pair);
        true
    }

    /// Replaces the gradient `g` by the descent direction -H g, where H is the inverse Hessian
    /// `apply_h0` (in place, symmetric positive definite) corrected by the stored pairs.
    ///
    /// # Panics
    /// If the length of `g` differs from that of the stored pairs.
    pub fn direction(&self, g: &mut [f64], apply_h0: impl FnOnce(&mut [f64])) {
        let mut alphas = [0.0; MEMORY];
        for (pair, alpha) in self.pairs.iter().zip(&mut alphas).rev() {
            *alpha = pair.inverse_curvature * dot(&pair.s, g);
            axpy(-*alpha, &pair.y, g);
        }
        apply_h0(g);
        for (pair, alpha) in self.pairs.iter().zip(&alphas) {
            let beta = pair.inverse_curvature * dot(&pair.y, g);
            axpy(alpha - beta, &pair.s, g);
        }
        for v in g {
            *v = -*v;
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len(), "vectors of one length");
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn axpy(factor: f64, x: &[f64], y: &mut [f64]) {
    for (yi, xi) in y.iter_mut().zip(x) {
        *yi += factor * xi;
    }
}

#[cfg(test)]
#[path = "lbfgs_tests.rs"]
mod tests;
