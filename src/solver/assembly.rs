//! Energy, gradient and matrix over all active elements.
//!
//! The sparsity pattern and every scatter position are computed once per topology. Elements are
//! worked on in batches of equal stencil size: the elements of a batch in parallel, its results
//! added in element order, so that the sums do not depend on the number of threads. While one batch
//! is added the next is computed.

use crate::linear::{SymmetricPattern, nested_dissection};
use crate::mesh::DVec3;
use crate::solver::energy::Energy;
use crate::solver::kernel::{
    ElementInput, ElementOutput, KernelInput, Lane, TERMS_PER_POINT, element,
};
use crate::subdivision::{Elements, Rule};

/// Elements computed together; their local results stay in the second-level cache.
const BATCH: usize = 512;
/// Elements one task computes.
const TASK: usize = 64;

/// Vertices of a mesh that move, numbered for the factorization.
#[derive(Clone, Debug)]
pub struct Unknowns {
    /// The vertex of each unknown.
    pub vertex: Vec<u32>,
    /// The unknown of each vertex; [`Self::len`] where the vertex is fixed.
    pub of_vertex: Vec<u32>,
    /// Who meets whom where, until the assembly has taken it.
    structure: Option<Structure>,
}

/// What numbering the unknowns found out about the matrix.
#[derive(Clone, Debug)]
struct Structure {
    pattern: SymmetricPattern,
    /// In the order of `moving`.
    incidence: Incidence,
    /// Place in `moving` of each unknown.
    order: Vec<u32>,
}

impl Unknowns {
    /// How many vertices move.
    pub fn len(&self) -> usize {
        self.vertex.len()
    }

    /// Whether nothing moves.
    pub fn is_empty(&self) -> bool {
        self.vertex.is_empty()
    }

    /// Numbers the `moving` vertices by nested dissection of the graph of vertices that share an
    /// element.
    pub fn new(elements: &Elements, positions: &[DVec3], moving: &[u32]) -> Self {
        let unknowns = Self::numbered(positions.len(), moving.to_vec());
        let incidence = Incidence::new(elements, &unknowns);
        let n = moving.len();
        let mut offsets = Vec::with_capacity(n + 1);
        let mut adjacency = Vec::with_capacity(36 * n);
        let mut stamp = vec![u32::MAX; n + 1];
        stamp[n] = n as u32;
        offsets.push(0);
        for j in 0..n {
            stamp[j] = j as u32;
            for &[e, _] in incidence.of(j) {
                for &v in element_vertices(elements, e as usize) {
                    let i = unknowns.of_vertex[v as usize] as usize;
                    if i < n && stamp[i] != j as u32 {
                        stamp[i] = j as u32;
                        adjacency.push(i as u32);
                    }
                }
            }
            offsets.push(adjacency.len() as u32);
        }
        let points: Vec<DVec3> = moving.iter().map(|&v| positions[v as usize]).collect();
        let order = nested_dissection(&points, &offsets, &adjacency);
        let mut unknowns = Self::numbered(
            positions.len(),
            order.iter().map(|&i| moving[i as usize]).collect(),
        );
        unknowns.structure = Some(Structure {
            pattern: SymmetricPattern::of_permuted_graph(&offsets, &adjacency, &order),
            incidence,
            order,
        });
        unknowns
    }

    /// All vertices fixed: only energies can be computed.
    pub fn none(vertex_count: usize) -> Self {
        Self::numbered(vertex_count, Vec::new())
    }

    fn numbered(vertex_count: usize, vertex: Vec<u32>) -> Self {
        let mut of_vertex = vec![vertex.len() as u32; vertex_count];
        for (i, &v) in vertex.iter().enumerate() {
            of_vertex[v as usize] = i as u32;
        }
        Self {
            vertex,
            of_vertex,
            structure: None,
        }
    }
}

fn element_vertices(elements: &Elements, e: usize) -> &[u32] {
    &elements.vertices[elements.offset[e] as usize..elements.offset[e + 1] as usize]
}

/// For each unknown the elements that contain it, with its place in the element.
#[derive(Clone, Debug)]
struct Incidence {
    start: Vec<u32>,
    entries: Vec<[u32; 2]>,
}

impl Incidence {
    fn new(elements: &Elements, unknowns: &Unknowns) -> Self {
        let n = unknowns.len();
        let mut start = vec![0u32; n + 2];
        for &v in &elements.vertices {
            start[unknowns.of_vertex[v as usize] as usize + 1] += 1;
        }
        for i in 0..=n {
            start[i + 1] += start[i];
        }
        let mut fill = start.clone();
        let mut entries = vec![[0; 2]; start[n] as usize];
        for e in 0..elements.faces.len() {
            for (k, &v) in element_vertices(elements, e).iter().enumerate() {
                let i = unknowns.of_vertex[v as usize] as usize;
                if i < n {
                    entries[fill[i] as usize] = [e as u32, k as u32];
                    fill[i] += 1;
                }
            }
        }
        Self { start, entries }
    }

    fn of(&self, unknown: usize) -> &[[u32; 2]] {
        &self.entries[self.start[unknown] as usize..self.start[unknown + 1] as usize]
    }
}

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

/// Assembles over a fixed set of elements and unknowns.
pub struct Assembler {
    unknowns: Unknowns,
    points: usize,
    weight: f64,
    tables: Vec<Vec<Lane>>,
    batches: Vec<Batch>,
    /// Elements in batch order.
    order: Vec<u32>,
    // per element
    table_of: Vec<u32>,
    offset: Vec<u32>,
    vertices: Vec<u32>,
    slots: Option<Slots>,
    membrane: bool,
    buffers: [Buffer; 2],
}

/// Sparsity pattern and where each local entry goes.
struct Slots {
    pattern: SymmetricPattern,
    offset: Vec<u32>,
    slot: Vec<u32>,
}

#[derive(Default)]
struct Buffer {
    local: Vec<Lane>,
    energy: Vec<f64>,
}

impl Assembler {
    /// Prepares the assembly over `elements`, whose tables are for `rule`, with `unknowns` moving.
    pub fn new(elements: &Elements, rule: Rule, unknowns: Unknowns) -> Self {
        let count = elements.faces.len();
        let chunks_of = |e: usize| elements.tables[elements.table_of[e] as usize].n.div_ceil(4);
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
            .tables
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
            unknowns,
            points: rule.points().len(),
            weight: rule.weight(),
            tables,
            batches,
            order,
            table_of: elements.table_of.clone(),
            offset: elements.offset.clone(),
            vertices: elements.vertices.clone(),
            slots: None,
            membrane: true,
            buffers: Default::default(),
        }
    }

    /// Leaves the membrane term out of the matrix where the Hessian part alone is strictly
    /// elliptic: faster towards the stationary shape, and not quite the flow's linearisation.
    pub fn drop_membrane(&mut self) {
        self.membrane = false;
    }

    /// The vertices that move.
    pub fn unknowns(&self) -> &Unknowns {
        &self.unknowns
    }

    /// The sparsity of the matrix, lower triangle in the order of the unknowns; computed once.
    pub fn pattern(&mut self) -> &SymmetricPattern {
        if self.slots.is_none() {
            self.slots = Some(self.build_slots());
        }
        &self.slots.as_ref().expect("built just above").pattern
    }

    fn build_slots(&mut self) -> Slots {
        let n = self.unknowns.len();
        let count = self.table_of.len();
        let mut offset = Vec::with_capacity(count + 1);
        let mut total = 0usize;
        offset.push(0);
        for e in 0..count {
            let k = (self.offset[e + 1] - self.offset[e]) as usize;
            total += k * (k + 1) / 2;
            offset.push(total as u32);
        }
        let Some(Structure {
            pattern,
            incidence,
            order,
        }) = self.unknowns.structure.take()
        else {
            return Slots {
                pattern: SymmetricPattern::new(0, vec![0], Vec::new()),
                offset,
                slot: vec![0; total],
            };
        };
        // entries of fixed vertices go to one place behind the matrix
        let waste = pattern.row_idx.len() as u32;
        let dof: Vec<u32> = self
            .vertices
            .iter()
            .map(|&v| self.unknowns.of_vertex[v as usize])
            .collect();
        let mut slot = vec![waste; total];
        let mut place = vec![0u32; n + 1];
        for j in 0..n {
            let column = pattern.col_ptr[j]..pattern.col_ptr[j + 1];
            for at in column {
                place[pattern.row_idx[at]] = at as u32;
            }
            for &[e, lj] in incidence.of(order[j] as usize) {
                let (a, b) = (self.offset[e as usize], self.offset[e as usize + 1]);
                let base = offset[e as usize] as usize;
                for (li, &d) in dof[a as usize..b as usize].iter().enumerate() {
                    if d as usize >= j && (d as usize) < n {
                        slot[base + triangular(li, lj as usize)] = place[d as usize];
                    }
                }
            }
        }
        Slots {
            pattern,
            offset,
            slot,
        }
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
    /// (one per unknown). `values` is resized to the pattern's length.
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
        self.pattern();
        self.run::<true>(
            positions,
            normals,
            energy,
            radius,
            1.0 / tau,
            gradient,
            values,
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
            let nnz = self.slots.as_ref().map_or(0, |s| s.pattern.row_idx.len());
            values.clear();
            values.resize(nnz + 1, 0.0);
        }
        let input = KernelInput {
            energy,
            radius,
            inv_tau,
            membrane: self.membrane,
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
            if batch.is_some() && pending.is_some() {
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

    /// Lanes of an element's local result; nothing but the energy is kept where nothing moves.
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
            let vertices = &self.vertices[self.offset[e] as usize..self.offset[e + 1] as usize];
            for (i, &v) in vertices.iter().enumerate() {
                let p = positions[v as usize];
                let (c, l) = (i / 4, i % 4);
                x[c][l] = p.x;
                x[chunks + c][l] = p.y;
                x[2 * chunks + c][l] = p.z;
                if MATRIX {
                    let u = self.unknowns.of_vertex[v as usize] as usize;
                    let d = if u < n { normals[u] } else { DVec3::ZERO };
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
                    table: &self.tables[self.table_of[e] as usize],
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
            let vertices = &self.vertices[self.offset[e] as usize..self.offset[e + 1] as usize];
            for (i, &v) in vertices.iter().enumerate() {
                gradient[self.unknowns.of_vertex[v as usize] as usize] +=
                    DVec3::new(g[i], g[4 * chunks + i], g[8 * chunks + i]);
            }
            if MATRIX && let Some(slots) = &self.slots {
                let own = &slots.slot[slots.offset[e] as usize..slots.offset[e + 1] as usize];
                let mut own = own.iter();
                for i in 0..vertices.len() {
                    let row = &matrix[i * 4 * chunks..i * 4 * chunks + i + 1];
                    for (value, &s) in row.iter().zip(&mut own) {
                        values[s as usize] += value;
                    }
                }
            }
        }
    }
}

/// Index of the pair `{i, j}` in a packed lower triangle.
fn triangular(i: usize, j: usize) -> usize {
    let (a, b) = if i >= j { (i, j) } else { (j, i) };
    a * (a + 1) / 2 + b
}
