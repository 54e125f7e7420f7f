//! Cholesky factorization of a fourth-order finite element matrix on a triangulated disc: the
//! nested dissection of this package compared with the approximate minimum degree ordering of faer.
//!
//! The disc has a jittered hexagonal lattice. Loop basis functions of vertices at graph distance up
//! to 3 overlap, so the matrix has 37 entries per row. It is the cube of the graph Laplacian plus a
//! multiple of the identity, which makes it positive definite.

use std::collections::HashMap;
use std::hint::black_box;
use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;
use glam::DVec3;
use meniscus::linear::{Cholesky, CholeskySymbolic, SymmetricPattern, nested_dissection};

/// Interior vertices of the discs, similar to those of the measured holes.
const SIZES: [usize; 5] = [200, 1_100, 5_000, 20_000, 50_000];

struct Disc {
    points: Vec<DVec3>,
    offsets: Vec<u32>,
    adjacency: Vec<u32>,
}

/// About `n` vertices of a hexagonal lattice in a circle, numbered row by row, each with the
/// vertices at most three edges away as neighbours.
fn disc(n: usize) -> Disc {
    let radius = (n as f64 * 0.75_f64.sqrt() / std::f64::consts::PI).sqrt();
    let reach = radius.ceil() as i32 * 2;
    let mut sites = Vec::new();
    let mut points = Vec::new();
    for j in -reach..=reach {
        for i in -reach..=reach {
            let p = DVec3::new(
                f64::from(i) + 0.5 * f64::from(j),
                0.75_f64.sqrt() * f64::from(j),
                0.0,
            );
            if p.length() <= radius {
                let jitter = f64::from((i * 7919 + j * 104_729).rem_euclid(101)) / 101.0 - 0.5;
                sites.push((i, j));
                points.push(p + 0.3 * jitter * DVec3::new(1.0, -0.7, 0.1));
            }
        }
    }
    let number: HashMap<_, _> = sites.iter().zip(0_u32..).collect();
    let mut offsets = vec![0];
    let mut adjacency = Vec::new();
    for &(i, j) in &sites {
        for dj in -3_i32..=3 {
            for di in -3_i32..=3 {
                // Distance in the lattice with the edges (1, 0), (0, 1), (1, -1).
                let distance = di.abs().max(dj.abs()).max((di + dj).abs());
                if distance > 0 && distance <= 3 {
                    adjacency.extend(number.get(&(i + di, j + dj)));
                }
            }
        }
        offsets.push(adjacency.len() as u32);
    }
    Disc {
        points,
        offsets,
        adjacency,
    }
}

/// Values of (-Δ)³ + 1 on an infinite lattice, truncated at the rim, which keeps it definite.
fn values(disc: &Disc, pattern: &SymmetricPattern, perm: &[u32]) -> Vec<f64> {
    let mut values = Vec::with_capacity(pattern.nnz());
    for j in 0..pattern.n {
        for &i in &pattern.row_idx[pattern.col_ptr[j]..pattern.col_ptr[j + 1]] {
            let d = disc.points[perm[i] as usize].distance(disc.points[perm[j] as usize]);
            values.push(if i == j { 500.0 } else { -12.0 / (1.0 + d) });
        }
    }
    values
}

/// Approximate minimum degree ordering, `perm[new] = old`.
fn minimum_degree(disc: &Disc) -> Vec<u32> {
    let n = disc.points.len();
    let nnz = disc.adjacency.len();
    // faer reads the upper triangle of a matrix with sorted columns.
    let pattern = SymmetricPattern::of_permuted_graph(
        &disc.offsets,
        &disc.adjacency,
        &(0..n as u32).collect::<Vec<_>>(),
    );
    let ptr: Vec<u32> = pattern.col_ptr.iter().map(|&p| p as u32).collect();
    let idx: Vec<u32> = pattern.row_idx.iter().map(|&i| i as u32).collect();
    let matrix = SymbolicSparseColMatRef::new_checked(n, n, &ptr, None, &idx);
    let mut perm = vec![0_u32; n];
    let mut inverse = vec![0_u32; n];
    let mut memory = MemBuffer::new(amd::order_maybe_unsorted_scratch::<u32>(n, nnz));
    amd::order_maybe_unsorted(
        &mut perm,
        &mut inverse,
        matrix,
        amd::Control::default(),
        MemStack::new(&mut memory),
    )
    .expect("the sizes fit in memory");
    perm
}

fn factorizations(c: &mut Criterion) {
    for n in SIZES {
        let disc = disc(n);
        let orders = [
            (
                "nested dissection",
                nested_dissection(&disc.points, &disc.offsets, &disc.adjacency),
            ),
            ("minimum degree", minimum_degree(&disc)),
        ];
        for (name, perm) in &orders {
            let pattern = SymmetricPattern::of_permuted_graph(&disc.offsets, &disc.adjacency, perm);
            let values = values(&disc, &pattern, perm);
            let symbolic = Arc::new(CholeskySymbolic::new(&pattern).expect("fits in memory"));
            let mut cholesky = Cholesky::new(symbolic);
            c.bench_function(&format!("factorize/{name}/{n}"), |b| {
                b.iter(|| cholesky.factorize(black_box(&values)).expect("definite"));
            });
        }
    }
}

fn criterion_config() -> Criterion {
    Criterion::default()
}

criterion_group! { name = benches; config = criterion_config(); targets = factorizations }
criterion_main!(benches);
