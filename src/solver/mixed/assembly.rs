//! The linear system (23) of scheme A.

use glam::DMat3;
use nalgebra_sparse::{CooMatrix, CscMatrix, CsrMatrix};
use rayon::prelude::*;

use crate::energy::Energy;
use crate::linear::SymmetricPattern;
use crate::mesh::DVec3;
use crate::solver::mixed::kernel::{self, Layout, Scratch};

use crate::solver::sparsity::{IndexLists, ListGraph, ScatterMap, SymmetricScatter, packed};
use crate::solver::{FlowProblem, Unknowns};
use crate::subdivision::{BasisTable, Elements};

/// Elements computed together before their results are added.
const BATCH: usize = 256;
/// Elements one task computes.
const TASK: usize = 16;

/// Makes the system independent of the units. It is solved for `x / r`, `h r` and `k r²`; its rows
/// are divided by the unit of force, by `r` and by 1.
#[derive(Clone, Copy, Debug)]
pub struct Units {
    /// Hole radius.
    pub length: f64,
    /// `r³ / τ_ref`: the force of the reference flow.
    pub force: f64,
}

/// The vertices of the three kinds of unknowns.
#[derive(Clone, Debug)]
pub struct Numbering {
    /// Positions: the interior.
    pub x: Unknowns,
    /// Curvature normals h and k: rings 0 and 1 without creases.
    pub h: Unknowns,
}

/// The matrices of one state, in [`Units`].
///
/// ```text
///   ⎡ M/τ + l^p   l^m   l^g ⎤ ⎡ δx ⎤
///   ⎢    l¹        m     0  ⎥ ⎢ δh ⎥
///   ⎣    l²        0     m  ⎦ ⎣ δk ⎦
/// ```
///
/// Vectors hold all x components, then y, then z, of δx, then of δh, then of δk.
pub struct System {
    /// Numbering of the unknowns.
    pub numbering: Numbering,
    /// Sparsity of `M` and `l^p`.
    pub positions: SymmetricScatter,
    /// Sparsity of `m`.
    pub curvatures: SymmetricScatter,
    /// `M`, lower triangle.
    pub mass: Vec<f64>,
    /// `l^p`, lower triangle.
    pub stiffness: Vec<f64>,
    /// `m`, lower triangle.
    pub m: Vec<f64>,
    /// Row sums of `m`, fixed vertices included.
    pub lumped: Vec<f64>,
    /// `l^m` and `l^g`: 3 × 3 blocks.
    pub curvature_blocks: CsrMatrix<[DMat3; 2]>,
    /// `l¹` and `l²`, transposed (times the unit matrix each).
    pub gradients: CsrMatrix<[f64; 2]>,
    /// `(½α, ½(½β + γ), δ)` averaged around each vertex of rings 0 and 1.
    pub weights: Vec<[f64; 3]>,
    /// `−l¹ x − m h` over the fixed h, by component (not in [`Units`]).
    pub rhs_h: Vec<f64>,
    /// `−l² x − m k` over the fixed k, by component (not in [`Units`]).
    pub rhs_k: Vec<f64>,
    /// The units of the matrices.
    pub units: Units,
    elements: Elements,
    pub(super) couplings: ScatterMap,
    buffer: Vec<f64>,
}

fn matrix_of<T: Copy>(couplings: &ScatterMap, columns: usize, value: T) -> CsrMatrix<T> {
    let wide = |items: &[u32]| items.iter().map(|&i| i as usize).collect::<Vec<_>>();
    CsrMatrix::try_from_csr_data(
        couplings.columns.len(),
        columns,
        wide(&couplings.columns.start),
        wide(&couplings.columns.items),
        vec![value; couplings.nnz()],
    )
    .expect("rows built in order with ascending columns")
}

/// Orders unknowns by nested dissection of the graph in which the members of each list are
/// neighbours.
fn dissected(first: &Unknowns, lists: &IndexLists, positions: &[DVec3]) -> Unknowns {
    let order = ListGraph::new(lists, first.len()).dissect(&first.points(positions));
    first.reordered(&order)
}

impl Numbering {
    /// Orders h and k for the factorization of `m`, and x for that of the Schur complement. Two
    /// vertices are neighbours in the Schur complement if they meet the same `ψ`.
    fn new(problem: &FlowProblem, elements: &Elements) -> Self {
        let positions = problem.positions();
        let is_crease = problem.crease_marks();
        let near = (0..positions.len() as u32)
            .filter(|&v| problem.ring()[v as usize] <= 1 && !is_crease[v as usize]);
        let h = Unknowns::new(positions.len(), near.collect());
        let h = dissected(&h, &corner_lists(elements, &h), positions);
        let x = Unknowns::new(positions.len(), problem.interior().to_vec());
        let (controls, corners) = (x.lists(elements), corner_lists(elements, &h));
        let coupling = ScatterMap::new(&controls, &corners, x.len(), h.len());
        let (meets, _) = coupling.by_column(h.len());
        Self {
            x: dissected(&x, &meets, positions),
            h,
        }
    }
}

fn corner_lists(elements: &Elements, unknowns: &Unknowns) -> IndexLists {
    IndexLists {
        start: (0..=elements.len() as u32).map(|e| 3 * e).collect(),
        items: (0..elements.len())
            .flat_map(|e| &elements.vertices_of(e)[..3])
            .map(|&v| unknowns.of_vertex[v as usize])
            .collect(),
    }
}

impl System {
    /// Patterns over the active elements; all values zero. The elements' tables must be for the
    /// 12-point rule.
    pub fn new(problem: &FlowProblem, elements: Elements, units: Units) -> Self {
        let numbering = Numbering::new(problem, &elements);
        let (n, m) = (numbering.x.len(), numbering.h.len());
        let controls = numbering.x.lists(&elements);
        let corners = corner_lists(&elements, &numbering.h);
        let couplings = ScatterMap::new(&controls, &corners, n, m);
        Self {
            positions: SymmetricScatter::new(&controls, n),
            curvatures: SymmetricScatter::new(&corners, m),
            mass: Vec::new(),
            stiffness: Vec::new(),
            m: Vec::new(),
            lumped: Vec::new(),
            curvature_blocks: matrix_of(&couplings, m, [DMat3::ZERO; 2]),
            gradients: matrix_of(&couplings, m, [0.0; 2]),
            weights: Vec::new(),
            rhs_h: Vec::new(),
            rhs_k: Vec::new(),
            units,
            numbering,
            elements,
            couplings,
            buffer: Vec::new(),
        }
    }

    /// Number of scalar unknowns.
    pub fn dimension(&self) -> usize {
        3 * self.numbering.x.len() + 6 * self.numbering.h.len()
    }

    /// Fills all matrices at `positions`. `h` and `k` (per vertex of the region) are read where
    /// they are fixed. `doubled` is as in [`Splitting`](super::splitting::Splitting).
    pub fn assemble(
        &mut self,
        positions: &[DVec3],
        h: &[DVec3],
        k: &[DVec3],
        energy: &Energy,
        doubled: bool,
    ) {
        let m = self.numbering.h.len();
        for (values, scatter) in [
            (&mut self.mass, &self.positions),
            (&mut self.stiffness, &self.positions),
            (&mut self.m, &self.curvatures),
        ] {
            values.clear();
            values.resize(scatter.pattern.nnz() + 1, 0.0);
        }
        self.curvature_blocks.values_mut().fill([DMat3::ZERO; 2]);
        self.gradients.values_mut().fill([0.0; 2]);
        self.lumped.clear();
        self.lumped.resize(m + 1, 0.0);
        self.weights.clear();
        self.weights.resize(m + 1, [0.0; 3]);
        for rhs in [&mut self.rhs_h, &mut self.rhs_k] {
            rhs.clear();
            rhs.resize(3 * m, 0.0);
        }
        let mut buffer = std::mem::take(&mut self.buffer);
        for first in (0..self.elements.len()).step_by(BATCH) {
            let last = (first + BATCH).min(self.elements.len());
            let stride = self.compute(
                [first, last],
                positions,
                |table| Layout::new(table.n).len(),
                #[inline(always)]
                |_, table, scratch, out| kernel::matrices(energy, doubled, table, scratch, out),
                &mut buffer,
            );
            for e in first..last {
                self.scatter(e, &buffer[(e - first) * stride..], h, k);
            }
        }
        self.buffer = buffer;
        self.mass.pop();
        self.stiffness.pop();
        self.m.pop();
        self.lumped.pop();
        self.weights.pop();
        for (w, lumped) in self.weights.iter_mut().zip(&self.lumped) {
            *w = w.map(|w| w / lumped);
        }
    }

    /// Runs an element kernel over the elements `first..last`, in parallel. Each result has `len`
    /// numbers; results start `stride` (returned) numbers apart in `buffer`.
    fn compute(
        &self,
        [first, last]: [usize; 2],
        positions: &[DVec3],
        len: impl Fn(&BasisTable) -> usize + Sync,
        kernel: impl Fn(usize, &BasisTable, &mut Scratch, &mut [f64]) + Sync,
        buffer: &mut Vec<f64>,
    ) -> usize {
        let tables = (first..last).map(|e| self.elements.table(e));
        let stride = tables.map(&len).max().unwrap_or(0);
        if buffer.len() < stride * (last - first) {
            buffer.resize(stride * (last - first), 0.0);
        }
        buffer[..stride * (last - first)]
            .par_chunks_mut(TASK * stride)
            .enumerate()
            .for_each(|(task, out)| {
                let outs = out.chunks_exact_mut(stride);
                pulp::Arch::new().dispatch(
                    #[inline(always)]
                    || self.compute_task(first + task * TASK, positions, outs, &len, &kernel),
                );
            });
        stride
    }

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled once per instruction set")]
    fn compute_task<'a>(
        &self,
        first: usize,
        positions: &[DVec3],
        outs: impl Iterator<Item = &'a mut [f64]>,
        len: &impl Fn(&BasisTable) -> usize,
        kernel: &impl Fn(usize, &BasisTable, &mut Scratch, &mut [f64]),
    ) {
        let mut scratch = Scratch::default();
        for (at, out) in outs.enumerate() {
            let e = first + at;
            for (axis, x) in scratch.x.iter_mut().enumerate() {
                x.clear();
                let vertices = self.elements.vertices_of(e).iter();
                x.extend(vertices.map(|&v| positions[v as usize][axis]));
            }
            let table = self.elements.table(e);
            kernel(e, table, &mut scratch, &mut out[..len(table)]);
        }
    }

    /// Adds the local matrices of one element to the global ones.
    ///
    /// ```text
    ///   local             global
    ///   mass, stiffness   A over pairs of control vertices (i, j)
    ///   b, c, l1, l2      B, C and L¹, L² over pairs (control vertex i, corner)
    ///   m, weight, rhs    m over pairs of corners; sums at each corner
    /// ```
    ///
    /// Only the lower triangle of symmetric matrices is stored. Entries of fixed vertices go to an
    /// extra place after the last value. A fixed corner instead moves its known `h` and `k` to the
    /// right-hand side.
    fn scatter(&mut self, e: usize, local: &[f64], h: &[DVec3], k: &[DVec3]) {
        let r = self.units.length;
        let force = self.units.force;
        let (bs, cs) = (1.0 / (r * force), 1.0 / (r * r * force));
        let vertices = self.elements.vertices_of(e);
        let n = vertices.len();
        let at = Layout::new(n);
        let pairs = (0..n).flat_map(|i| (0..=i).map(move |j| (i, j)));
        for ((i, j), &s) in pairs.zip(self.positions.slots(e)) {
            self.mass[s as usize] += local[at.mass(i, j)] * (r / force);
            self.stiffness[s as usize] += local[at.stiffness(i, j)] * (r / force);
        }
        let slots = self.couplings.slots(e);
        let blocks = self.curvature_blocks.values_mut();
        let gradients = self.gradients.values_mut();
        for i in 0..n {
            for corner in 0..3 {
                let slot = slots[3 * i + corner] as usize;
                let Some(block) = blocks.get_mut(slot) else {
                    continue;
                };
                let gather = |at: &dyn Fn(usize, usize) -> usize, scale: f64| {
                    let entry = |q: usize| local[at(q % 3, q / 3) + i] * scale;
                    DMat3::from_cols_array(&std::array::from_fn(entry))
                };
                block[0] += gather(&|row, column| at.b(corner, row, column), bs);
                block[1] += gather(&|row, column| at.c(corner, row, column), cs);
                gradients[slot][0] += local[at.l1(corner) + i];
                gradients[slot][1] += local[at.l2(corner) + i] * r;
            }
        }
        let slots = self.curvatures.slots(e);
        let count = self.numbering.h.len();
        let unknown = |corner: usize| self.numbering.h.of_vertex[vertices[corner] as usize];
        for corner in 0..3 {
            let own = unknown(corner) as usize;
            let w = at.weight(corner);
            let scale = [bs, cs, cs / r];
            for q in 0..3 {
                self.weights[own][q] += local[w + q] * scale[q] / (r * r);
            }
            for other in 0..3 {
                let m = local[at.m(corner, other)];
                // m(i, j) and m(j, i) differ by rounding: the one with i ≤ j is stored
                if own <= unknown(other) as usize {
                    self.m[slots[packed(corner, other)] as usize] += m / (r * r);
                }
                self.lumped[own] += m / (r * r);
            }
            if own == count {
                continue;
            }
            for axis in 0..3 {
                self.rhs_h[axis * count + own] += local[at.rhs_h(corner) + axis];
                self.rhs_k[axis * count + own] += local[at.rhs_k(corner) + axis];
            }
            for other in 0..3 {
                let v = vertices[other] as usize;
                if self.numbering.h.of_vertex[v] as usize == count {
                    let m = local[at.m(corner, other)];
                    for axis in 0..3 {
                        self.rhs_h[axis * count + own] -= m * h[v][axis];
                        self.rhs_k[axis * count + own] -= m * k[v][axis];
                    }
                }
            }
        }
    }

    /// `Σ_j l^p_ij x_j + l^m_ij h_j + l^g_ij k_j + b_i` for the interior vertices, with h and k at
    /// all vertices (not in [`Units`]).
    pub fn residual(
        &mut self,
        positions: &[DVec3],
        h: &[DVec3],
        k: &[DVec3],
        energy: &Energy,
        out: &mut Vec<DVec3>,
    ) {
        let count = self.numbering.x.len();
        out.clear();
        out.resize(count + 1, DVec3::ZERO);
        let mut buffer = std::mem::take(&mut self.buffer);
        for first in (0..self.elements.len()).step_by(BATCH) {
            let last = (first + BATCH).min(self.elements.len());
            let stride = self.compute(
                [first, last],
                positions,
                |table| 3 * table.n,
                #[inline(always)]
                |e, table, scratch, out| {
                    let vertices = self.elements.vertices_of(e);
                    let corner = |f: &[DVec3]| [0, 1, 2].map(|c| f[vertices[c] as usize]);
                    kernel::residual(energy, table, scratch, &corner(h), &corner(k), out);
                },
                &mut buffer,
            );
            for e in first..last {
                let local = &buffer[(e - first) * stride..];
                let vertices = self.elements.vertices_of(e);
                let n = vertices.len();
                for (i, &v) in vertices.iter().enumerate() {
                    out[self.numbering.x.of_vertex[v as usize] as usize] +=
                        DVec3::new(local[i], local[n + i], local[2 * n + i]);
                }
            }
        }
        out.truncate(count);
        self.buffer = buffer;
    }

    /// Whether all values are finite.
    pub fn is_finite(&self) -> bool {
        let finite = |v: &[f64]| v.iter().all(|x| x.is_finite());
        finite(&self.mass)
            && finite(&self.stiffness)
            && finite(&self.m)
            && finite(self.gradients.values().as_flattened())
            && self
                .curvature_blocks
                .values()
                .iter()
                .all(|[b, c]| b.is_finite() && c.is_finite())
    }

    /// `M/τ + l^p`.
    pub fn position_block(&self, tau: f64, out: &mut Vec<f64>) {
        out.clear();
        out.extend(
            self.mass
                .iter()
                .zip(&self.stiffness)
                .map(|(m, s)| m / tau + s),
        );
    }

    /// `y = A v`, with `position` from [`Self::position_block`].
    pub fn multiply(&self, position: &[f64], v: &[f64], y: &mut [f64]) {
        let (n, m) = (self.numbering.x.len(), self.numbering.h.len());
        let (x, rest) = v.split_at(3 * n);
        let (h, k) = rest.split_at(3 * m);
        let (yx, rest) = y.split_at_mut(3 * n);
        let (yh, yk) = rest.split_at_mut(3 * m);
        for axis in 0..3 {
            let own = |n: usize| axis * n..(axis + 1) * n;
            self.positions
                .pattern
                .multiply(position, &x[own(n)], &mut yx[own(n)]);
            self.curvatures
                .pattern
                .multiply(&self.m, &h[own(m)], &mut yh[own(m)]);
            self.curvatures
                .pattern
                .multiply(&self.m, &k[own(m)], &mut yk[own(m)]);
        }
        let get = |f: &[f64], n: usize, i: usize| DVec3::new(f[i], f[n + i], f[2 * n + i]);
        let (offsets, columns, blocks) = self.curvature_blocks.csr_data();
        for i in 0..n {
            let mut sum = DVec3::ZERO;
            for at in offsets[i]..offsets[i + 1] {
                let j = columns[at];
                sum += blocks[at][0] * get(h, m, j) + blocks[at][1] * get(k, m, j);
            }
            for axis in 0..3 {
                yx[axis * n + i] += sum[axis];
            }
        }
        self.add_gradients(x, 1.0, yh, yk);
    }

    /// `yh += factor l¹ x`, `yk += factor l² x`.
    pub fn add_gradients(&self, x: &[f64], factor: f64, yh: &mut [f64], yk: &mut [f64]) {
        let (n, m) = (self.numbering.x.len(), self.numbering.h.len());
        let (offsets, columns, values) = self.gradients.csr_data();
        for axis in 0..3 {
            let (yh, yk) = (&mut yh[axis * m..][..m], &mut yk[axis * m..][..m]);
            for (i, x) in x[axis * n..][..n].iter().enumerate() {
                let x = factor * x;
                for at in offsets[i]..offsets[i + 1] {
                    let [l1, l2] = values[at];
                    yh[columns[at]] += l1 * x;
                    yk[columns[at]] += l2 * x;
                }
            }
        }
    }

    /// The whole matrix, for the direct solver.
    pub fn to_csc(&self, position: &[f64]) -> CscMatrix<f64> {
        let (n, m) = (self.numbering.x.len(), self.numbering.h.len());
        let size = self.dimension();
        let mut coo = CooMatrix::new(size, size);
        let mut push_symmetric = |pattern: &SymmetricPattern, values: &[f64], begin: usize| {
            for axis in 0..3 {
                let base = begin + axis * pattern.n;
                for j in 0..pattern.n {
                    for at in pattern.col_ptr[j]..pattern.col_ptr[j + 1] {
                        let i = pattern.row_idx[at];
                        coo.push(base + i, base + j, values[at]);
                        if i != j {
                            coo.push(base + j, base + i, values[at]);
                        }
                    }
                }
            }
        };
        push_symmetric(&self.positions.pattern, position, 0);
        push_symmetric(&self.curvatures.pattern, &self.m, 3 * n);
        push_symmetric(&self.curvatures.pattern, &self.m, 3 * n + 3 * m);
        let gradients = self.gradients.values();
        for ((i, j, [b, c]), &[l1, l2]) in self.curvature_blocks.triplet_iter().zip(gradients) {
            for row in 0..3 {
                for column in 0..3 {
                    let to = 3 * n + column * m + j;
                    coo.push(row * n + i, to, b.col(column)[row]);
                    coo.push(row * n + i, to + 3 * m, c.col(column)[row]);
                }
                let to = 3 * n + row * m + j;
                coo.push(to, row * n + i, l1);
                coo.push(to + 3 * m, row * n + i, l2);
            }
        }
        CscMatrix::from(&coo)
    }
}
