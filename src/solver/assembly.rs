//! Energy, gradient and matrix over all active elements.
//!
//! The sparsity pattern and every scatter position are computed once per topology. Elements are
//! processed in batches of equal stencil size. The elements of a batch are computed in parallel,
//! and its results are added in element order. The sums therefore do not depend on the number of
//! threads. While one batch is added, the next is computed.

use std::sync::Arc;

use crate::energy::Energy;
use crate::linear::SymmetricPattern;
use crate::mesh::DVec3;
use crate::solver::kernel::{
    ElementInput, ElementOutput, KernelInput, Lane, TERMS_PER_POINT, element,
};
use crate::solver::sparsity::SymmetricScatter;
use crate::solver::unknowns::Unknowns;
use crate::subdivision::{Elements, Rule};

/// Elements computed together; their local results stay in the second-level cache.
const BATCH: usize = 512;
/// Elements one task computes.
const TASK: usize = 64;

/// A run of elements with the same number of lanes.
#[derive(Clone, Copy, Debug)]
struct Batch {
    chunks: usize,
    start: usize,
    end: usize,
}

/// `Σ E_e` over the elements, and `Σ |E_e|`, the scale of its rounding error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergySum {
    /// The energy.
    pub value: f64,
    /// Sum of absolute element energies.
    pub scale: f64,
}

impl std::ops::AddAssign for EnergySum {
    fn add_assign(&mut self, other: Self) {
        self.value += other.value;
        self.scale += other.scale;
    }
}

/// The displacements for which the matrix of scheme B is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MatrixForm {
    /// Along the normals: the linearisation of the flow.
    Flow,
    /// Along the normals, without the membrane term where the Hessian part alone is strictly
    /// elliptic. This converges faster to the stationary shape.
    Stationary,
    /// One matrix for each component of the displacements. `<N_i, n>` counts as 1, so the stiffness
    /// along the surface equals that across it, even where the normal turns far within an element.
    Isotropic,
}

/// Assembles over a fixed set of elements and unknowns.
pub struct Assembler {
    unknowns: Arc<Unknowns>,
    elements: Elements,
    points: usize,
    weight: f64,
    /// The tables of the elements in lanes.
    tables: Vec<Vec<Lane>>,
    batches: Vec<Batch>,
    /// Elements in batch order.
    order: Vec<u32>,
    scatter: Option<Arc<SymmetricScatter>>,
    form: MatrixForm,
    buffers: [Buffer; 2],
}

#[derive(Default)]
struct Buffer {
    local: Vec<Lane>,
    energy: Vec<f64>,
}

impl Assembler {
    /// Prepares the assembly over `elements`, whose tables are for `rule`; the vertices in
    /// `unknowns` move. It computes energies and gradients only; see [`Self::with_matrix`] for
    /// matrices.
    pub fn new(elements: &Elements, rule: Rule, unknowns: impl Into<Arc<Unknowns>>) -> Self {
        let count = elements.len();
        let chunks_of = |e: usize| elements.table(e).n.div_ceil(4);
        let most = (0..count).map(chunks_of).max().unwrap_or(0);
        let mut start = vec![0usize; most + 2];
        for e in 0..count {
            start[chunks_of(e) + 1] += 1;
        }
        for c in 0..=most {
            start[c + 1] += start[c];
        }
        let mut batches = Vec::new();
        for chunks in 0..=most {
            let mut at = start[chunks];
            while at < start[chunks + 1] {
                let end = (at + BATCH).min(start[chunks + 1]);
                batches.push(Batch {
                    chunks,
                    start: at,
                    end,
                });
                at = end;
            }
        }
        let mut order = vec![0u32; count];
        for e in 0..count {
            let slot = &mut start[chunks_of(e)];
            order[*slot] = e as u32;
            *slot += 1;
        }
        let tables = elements
            .tables()
            .iter()
            .map(|t| {
                let chunks = t.n.div_ceil(4);
                let mut lanes = vec![[0.0; 4]; t.points * 6 * chunks];
                for p in 0..t.points {
                    for d in 0..6 {
                        for (k, &value) in t.row(p, d).iter().enumerate() {
                            lanes[(p * 6 + d) * chunks + k / 4][k % 4] = value;
                        }
                    }
                }
                lanes
            })
            .collect();
        Self {
            unknowns: unknowns.into(),
            elements: elements.clone(),
            points: rule.points().len(),
            weight: rule.weight(),
            tables,
            batches,
            order,
            scatter: None,
            form: MatrixForm::Flow,
            buffers: Default::default(),
        }
    }

    /// The same with the sparsity of a matrix over its unknowns, found by [`Unknowns::dissected`]; the
    /// first lists of `scatter` are those of the elements.
    #[must_use]
    pub fn with_matrix(
        mut self,
        scatter: impl Into<Arc<SymmetricScatter>>,
        form: MatrixForm,
    ) -> Self {
        self.scatter = Some(scatter.into());
        self.form = form;
        self
    }

    /// The elements.
    pub fn elements(&self) -> &Elements {
        &self.elements
    }

    /// The vertices that move.
    pub fn unknowns(&self) -> &Arc<Unknowns> {
        &self.unknowns
    }

    /// The sparsity of the matrix, lower triangle in the order of the unknowns.
    ///
    /// # Panics
    /// If it was made without a matrix.
    pub fn pattern(&self) -> &SymmetricPattern {
        &self.scatter.as_ref().expect("made with a matrix").pattern
    }

    /// Energy alone.
    pub fn energy(&mut self, positions: &[DVec3], energy: &Energy) -> EnergySum {
        self.gradient(positions, energy, &mut Vec::new())
    }

    /// Energy and its exact gradient (12) at the unknowns, one vector each.
    pub fn gradient(
        &mut self,
        positions: &[DVec3],
        energy: &Energy,
        gradient: &mut Vec<DVec3>,
    ) -> EnergySum {
        self.run::<false>(positions, &[], energy, 1.0, 0.0, gradient, &mut Vec::new())
    }

    /// Energy, gradient and the matrix `M/τ + S` of scheme B for displacements along `normals`
    /// (one for each unknown; irrelevant for [`MatrixForm::Isotropic`]). `values` is resized to
    /// the pattern's length.
    ///
    /// # Panics
    /// If it was made without a matrix.
    pub fn matrix(
        &mut self,
        positions: &[DVec3],
        normals: &[DVec3],
        energy: &Energy,
        radius: f64,
        tau: f64,
        gradient: &mut Vec<DVec3>,
        values: &mut Vec<f64>,
    ) -> EnergySum {
        let inv_tau = 1.0 / tau;
        self.run::<true>(
            positions, normals, energy, radius, inv_tau, gradient, values,
        )
    }

    fn run<const MATRIX: bool>(
        &mut self,
        positions: &[DVec3],
        normals: &[DVec3],
        energy: &Energy,
        radius: f64,
        inv_tau: f64,
        gradient: &mut Vec<DVec3>,
        values: &mut Vec<f64>,
    ) -> EnergySum {
        let n = self.unknowns.len();
        gradient.clear();
        gradient.resize(n + 1, DVec3::ZERO);
        if MATRIX {
            values.clear();
            values.resize(self.pattern().nnz() + 1, 0.0);
        }
        let input = KernelInput {
            energy,
            radius,
            inv_tau,
            membrane: self.form != MatrixForm::Stationary,
            isotropic: self.form == MatrixForm::Isotropic,
            weight: self.weight,
            points: self.points,
        };
        let mut sum = EnergySum::default();
        let mut buffers = std::mem::take(&mut self.buffers);
        let [ready, next] = &mut buffers;
        let mut pending: Option<Batch> = None;
        for k in 0..=self.batches.len() {
            let batch = self.batches.get(k).copied();
            let mut compute = || {
                if let Some(batch) = batch {
                    self.compute::<MATRIX>(batch, &input, positions, normals, next);
                }
            };
            let mut scatter = || {
                if let Some(batch) = pending {
                    self.scatter::<MATRIX>(batch, ready, gradient, values, &mut sum);
                }
            };
            if batch.is_some() && pending.is_some() && self.is_large() {
                rayon::join(compute, scatter);
            } else {
                compute();
                scatter();
            }
            pending = batch;
            std::mem::swap(ready, next);
        }
        self.buffers = buffers;
        gradient.truncate(n);
        if MATRIX {
            values.pop();
        }
        sum
    }

    /// Whether threads pay off: below a thousand points they cost more than they save.
    fn is_large(&self) -> bool {
        self.order.len() * self.points >= 2 * BATCH
    }

    /// Number of lanes of an element's local result. Where nothing moves, only the energy is
    /// stored.
    fn lanes_per_element<const MATRIX: bool>(&self, chunks: usize) -> usize {
        if self.unknowns.is_empty() {
            return 0;
        }
        3 * chunks + if MATRIX { 4 * chunks * chunks } else { 0 }
    }

    fn compute<const MATRIX: bool>(
        &self,
        batch: Batch,
        input: &KernelInput<'_>,
        positions: &[DVec3],
        normals: &[DVec3],
        buffer: &mut Buffer,
    ) {
        use rayon::prelude::*;
        let count = batch.end - batch.start;
        let stride = self.lanes_per_element::<MATRIX>(batch.chunks);
        if buffer.local.len() < count * stride {
            buffer.local.resize(count * stride, [0.0; 4]);
        }
        buffer.energy.resize(count, 0.0);
        let compute = |t: usize, local: &mut [Lane], energy: &mut [f64]| {
            let first = batch.start + t * TASK;
            pulp::Arch::new().dispatch(
                #[inline(always)]
                || {
                    self.compute_task::<MATRIX>(
                        first,
                        batch.chunks,
                        input,
                        positions,
                        normals,
                        local,
                        energy,
                    );
                },
            );
        };
        if !self.is_large() {
            return compute(0, &mut buffer.local[..count * stride], &mut buffer.energy);
        }
        let energies = buffer.energy.par_chunks_mut(TASK).enumerate();
        if stride == 0 {
            energies.for_each(|(t, energy)| compute(t, &mut [], energy));
        } else {
            energies
                .zip(buffer.local[..count * stride].par_chunks_mut(TASK * stride))
                .for_each(|((t, energy), local)| compute(t, local, energy));
        }
    }

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled once per instruction set")]
    fn compute_task<const MATRIX: bool>(
        &self,
        first: usize,
        chunks: usize,
        input: &KernelInput<'_>,
        positions: &[DVec3],
        normals: &[DVec3],
        local: &mut [Lane],
        energy: &mut [f64],
    ) {
        let n = self.unknowns.len();
        let mut x = vec![[0.0; 4]; 3 * chunks];
        let mut normal = vec![[0.0; 4]; if MATRIX { 3 * chunks } else { 0 }];
        let mut terms = vec![
            [0.0; 4];
            if MATRIX {
                TERMS_PER_POINT * input.points * chunks
            } else {
                0
            }
        ];
        let stride = self.lanes_per_element::<MATRIX>(chunks);
        for (k, e_out) in energy.iter_mut().enumerate() {
            let out = &mut local[k * stride..(k + 1) * stride];
            let e = self.order[first + k] as usize;
            let vertices = self.elements.vertices_of(e);
            for (i, &v) in vertices.iter().enumerate() {
                let p = positions[v as usize];
                let (c, l) = (i / 4, i % 4);
                x[c][l] = p.x;
                x[chunks + c][l] = p.y;
                x[2 * chunks + c][l] = p.z;
                if MATRIX {
                    let u = self.unknowns.of_vertex[v as usize] as usize;
                    let d = match (u < n, input.isotropic) {
                        (false, _) => DVec3::ZERO,
                        (true, true) => DVec3::X,
                        (true, false) => normals[u],
                    };
                    normal[c][l] = d.x;
                    normal[chunks + c][l] = d.y;
                    normal[2 * chunks + c][l] = d.z;
                }
            }
            // the lanes behind a shorter stencil meet zeros in the table
            let (gradient, matrix) = out.split_at_mut(stride.min(3 * chunks));
            *e_out = element::<MATRIX>(
                chunks,
                input,
                &ElementInput {
                    table: &self.tables[self.elements.table_of()[e] as usize],
                    x: &x,
                    normals: &normal,
                },
                &mut ElementOutput {
                    gradient,
                    matrix,
                    terms: &mut terms,
                },
            );
        }
    }

    fn scatter<const MATRIX: bool>(
        &self,
        batch: Batch,
        buffer: &Buffer,
        gradient: &mut [DVec3],
        values: &mut [f64],
        sum: &mut EnergySum,
    ) {
        let chunks = batch.chunks;
        let stride = self.lanes_per_element::<MATRIX>(chunks);
        for (k, &e) in self.order[batch.start..batch.end].iter().enumerate() {
            let e = e as usize;
            sum.value += buffer.energy[k];
            sum.scale += buffer.energy[k].abs();
            if stride == 0 {
                continue;
            }
            let local = buffer.local[k * stride..(k + 1) * stride].as_flattened();
            let (g, matrix) = local.split_at(12 * chunks);
            let vertices = self.elements.vertices_of(e);
            for (i, &v) in vertices.iter().enumerate() {
                gradient[self.unknowns.of_vertex[v as usize] as usize] +=
                    DVec3::new(g[i], g[4 * chunks + i], g[8 * chunks + i]);
            }
            if MATRIX && let Some(scatter) = &self.scatter {
                let mut own = scatter.slots(e).iter();
                for i in 0..vertices.len() {
                    let row = &matrix[i * 4 * chunks..][..=i];
                    for (value, &s) in row.iter().zip(&mut own) {
                        values[s as usize] += value;
                    }
                }
            }
        }
    }
}

#[cfg(test)]
#[path = "assembly_tests.rs"]
mod tests;
