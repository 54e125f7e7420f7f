//! Restarted GMRES with right preconditioning (Saad and Schultz 1986; Saad, Iterative Methods,
//! algorithm 9.5).

use crate::cancel::is_cancelled;

/// Stopping criteria and memory limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GmresOptions {
    /// Target |b - A x| / |b|.
    pub tolerance: f64,
    /// Basis vectors kept before a restart (m in GMRES(m)).
    pub restart: usize,
    /// Maximum number of applications of the operator, including restarts.
    pub max_iterations: usize,
}

impl Default for GmresOptions {
    /// Relative residual 1e-10, restart 60, at most 1000 iterations.
    fn default() -> Self {
        Self {
            tolerance: 1e-10,
            restart: 60,
            max_iterations: 1000,
        }
    }
}

/// Result of a solve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GmresReport {
    /// Steps of the Arnoldi process, one operator and one preconditioner application each.
    pub iterations: usize,
    /// |b - A x| / |b| of the returned x, evaluated, not estimated (0 for b = 0).
    pub relative_residual: f64,
    /// Whether the tolerance was reached.
    pub converged: bool,
}

/// A linear map: reads the first vector, overwrites the second.
type Apply<'a> = &'a mut dyn FnMut(&[f64], &mut [f64]);

/// Solves A x = b from the initial guess in `x`.
///
/// `operator(v, out)` computes A v. `preconditioner(v, out)` approximates A⁻¹ v and must be the
/// same linear map at each call. With right preconditioning, the residual of the iteration is that
/// of the given system. Before convergence is reported, the residual is evaluated once more from x.
/// The iteration ends with `converged: false` if it stagnates over a whole restart cycle or values
/// are not finite; x is then the best iterate.
///
/// # Panics
/// If b and x differ in length or `restart` is 0.
pub fn gmres(
    operator: Apply,
    preconditioner: Apply,
    b: &[f64],
    x: &mut [f64],
    options: &GmresOptions,
) -> GmresReport {
    let n = b.len();
    assert_eq!(x.len(), n, "solution and right-hand side of one length");
    assert!(options.restart > 0, "at least one basis vector");
    let b_norm = norm(b);
    if b_norm == 0.0 {
        x.fill(0.0);
        return GmresReport {
            iterations: 0,
            relative_residual: 0.0,
            converged: true,
        };
    }
    let target = options.tolerance * b_norm;
    let mut cycle = Cycle::new(n, options.restart.min(n));
    let mut iterations = 0;
    let mut residual = cycle.start(operator, b, x);
    while residual > target && iterations < options.max_iterations && !is_cancelled() {
        let steps = options.max_iterations - iterations;
        iterations += cycle.arnoldi(operator, preconditioner, residual, target, steps);
        cycle.correct(preconditioner, x);
        let after = cycle.start(operator, b, x);
        // A cycle never raises the residual in exact arithmetic. If rounding raises it, or nothing
        // is gained, further cycles would repeat the same.
        if after >= residual || after.is_nan() {
            x.copy_from_slice(&cycle.before);
            break;
        }
        residual = after;
    }
    GmresReport {
        iterations,
        relative_residual: residual / b_norm,
        converged: residual <= target,
    }
}

/// Fraction of a new Krylov vector below which only rounding remains: the space is invariant.
const INVARIANT: f64 = 1e-14;

/// Memory of one restart cycle, reused by the next.
struct Cycle {
    n: usize,
    restart: usize,
    /// Orthonormal Krylov vectors one after another; grows as far as a cycle needs.
    basis: Vec<f64>,
    /// Columns of the triangular factor of the Hessenberg matrix, `restart + 1` apart.
    r: Vec<f64>,
    /// Givens rotations (cosine, sine) that made it triangular.
    rotations: Vec<(f64, f64)>,
    /// Rotated right-hand side of the least-squares problem.
    g: Vec<f64>,
    /// Number of steps in the current cycle.
    len: usize,
    z: Vec<f64>,
    w: Vec<f64>,
    /// The iterate before the last correction.
    before: Vec<f64>,
}

impl Cycle {
    fn new(n: usize, restart: usize) -> Self {
        Self {
            n,
            restart,
            basis: Vec::new(),
            r: vec![0.0; restart * (restart + 1)],
            rotations: Vec::with_capacity(restart),
            g: vec![0.0; restart + 1],
            len: 0,
            z: vec![0.0; n],
            w: vec![0.0; n],
            before: vec![0.0; n],
        }
    }

    /// Puts b - A x into `w` and returns its norm.
    fn start(&mut self, operator: Apply, b: &[f64], x: &[f64]) -> f64 {
        operator(x, &mut self.w);
        for (wi, bi) in self.w.iter_mut().zip(b) {
            *wi = bi - *wi;
        }
        norm(&self.w)
    }

    /// Builds the Krylov basis from the residual in `w` until the estimated residual reaches the
    /// target, the cycle or `max_steps` is full, or the space is invariant. Returns the steps taken.
    fn arnoldi(
        &mut self,
        operator: Apply,
        preconditioner: Apply,
        residual: f64,
        target: f64,
        max_steps: usize,
    ) -> usize {
        self.rotations.clear();
        self.g.fill(0.0);
        self.g[0] = residual;
        self.len = 0;
        self.append_basis_vector(1.0 / residual);
        let mut applied = 0;
        while applied < self.restart.min(max_steps) {
            let j = self.len;
            preconditioner(&self.basis[j * self.n..][..self.n], &mut self.z);
            operator(&self.z, &mut self.w);
            applied += 1;
            let before = norm(&self.w);
            let next = self.orthogonalize(before);
            // A pivot of rounding size is a direction that the operator maps into the existing
            // space (it is singular): omit it. Values that are not finite also take this branch.
            let pivot = self.rotate(next);
            if !(pivot > INVARIANT * before && pivot.is_finite()) {
                break;
            }
            self.len += 1;
            if next <= INVARIANT * before || self.g[self.len].abs() <= target {
                break;
            }
            self.append_basis_vector(1.0 / next);
        }
        applied
    }

    /// Stores `w` times a factor as basis vector number `len`.
    fn append_basis_vector(&mut self, factor: f64) {
        let begin = self.len * self.n;
        if self.basis.len() < begin + self.n {
            self.basis.resize(begin + self.n, 0.0);
        }
        for (v, w) in self.basis[begin..begin + self.n].iter_mut().zip(&self.w) {
            *v = factor * w;
        }
    }

    /// Modified Gram-Schmidt of `w` against the basis, repeated where the first pass cancelled
    /// digits. The coefficients go to column `len` of `r`. Returns the norm of the remainder.
    fn orthogonalize(&mut self, norm_before: f64) -> f64 {
        let j = self.len;
        let column = &mut self.r[j * (self.restart + 1)..][..=j];
        column.fill(0.0);
        let mut before = norm_before;
        let mut after = before;
        for _ in 0..2 {
            for (h, v) in column.iter_mut().zip(self.basis.chunks_exact(self.n)) {
                let projection = dot(v, &self.w);
                *h += projection;
                for (wi, vi) in self.w.iter_mut().zip(v) {
                    *wi -= projection * vi;
                }
            }
            after = norm(&self.w);
            if after > 0.7 * before {
                break;
            }
            before = after;
        }
        after
    }

    /// Makes the new column of the Hessenberg matrix triangular, updates the residual and returns
    /// the new pivot.
    fn rotate(&mut self, next: f64) -> f64 {
        let j = self.len;
        let column = &mut self.r[j * (self.restart + 1)..][..=j];
        for (i, &(c, s)) in self.rotations.iter().enumerate() {
            let (above, below) = (column[i], column[i + 1]);
            column[i] = c * above + s * below;
            column[i + 1] = c * below - s * above;
        }
        let length = column[j].hypot(next);
        let (c, s) = if length == 0.0 {
            (1.0, 0.0)
        } else {
            (column[j] / length, next / length)
        };
        column[j] = length;
        self.rotations.push((c, s));
        self.g[j + 1] = -s * self.g[j];
        self.g[j] *= c;
        length
    }

    /// Adds M V y to x, y the minimiser of the projected residual.
    fn correct(&mut self, preconditioner: Apply, x: &mut [f64]) {
        self.before.copy_from_slice(x);
        let stride = self.restart + 1;
        for j in (0..self.len).rev() {
            self.g[j] /= self.r[j * stride + j];
            for i in 0..j {
                self.g[i] -= self.r[j * stride + i] * self.g[j];
            }
        }
        self.w.fill(0.0);
        for (y, v) in self.g[..self.len]
            .iter()
            .zip(self.basis.chunks_exact(self.n))
        {
            for (wi, vi) in self.w.iter_mut().zip(v) {
                *wi += y * vi;
            }
        }
        preconditioner(&self.w, &mut self.z);
        for (xi, zi) in x.iter_mut().zip(&self.z) {
            *xi += zi;
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
#[path = "gmres_tests.rs"]
mod tests;
