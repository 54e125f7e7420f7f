use crate::mesh::*;
use crate::solver::*;
use crate::solver::energy::Energy;
use crate::subdivision::*;

pub struct State { pub topology: Topology, pub control: Vec<DVec3> }

pub fn loop_subdivide(t: &Topology, x: &[DVec3], split: &Split) -> Vec<DVec3> {
    let mut out: Vec<DVec3> = (0..x.len()).map(|v| {
        let id = VertexId::from(v);
        let n = t.valence(id);
        let b = beta(n);
        let s: DVec3 = t.neighbours(id).map(|w| x[w.index()]).sum();
        x[v]*(1.0 - n as f64*b) + s*b
    }).collect();
    for &h in &split.edges {
        let ([a,b],[c,d]) = edge_diamond(t, h);
        let p = |v: VertexId| x[v.index()];
        out.push(EDGE_END*(p(a)+p(b)) + EDGE_OPPOSITE*(p(c.unwrap())+p(d.unwrap())));
    }
    out
}

pub fn quadrature_energy(t: &Topology, x: &[DVec3], energy: &Energy) -> f64 {
    let faces: Vec<FaceId> = (0..t.face_count()).map(FaceId::from).collect();
    let e = elements(t, &faces, Rule::Twelve, &mut TableCache::default());
    Assembler::new(&e, Rule::Twelve, Unknowns::none(x.len())).gradient(x, energy, &mut Vec::new()).value
}

use crate::linear::*;
/// min |L (x0 + Q y)|² with the graph Laplacian (uniform), held rows followed; dense-free: all vertices
/// unknown with penalty rows.
pub fn warm(t: &Topology, x: &[DVec3], held: &[(u32, DVec3)]) -> Vec<DVec3> {
    let n = x.len();
    let inter = Interpolation::new(t, held);
    // assemble K = LᵀL + rho AᵀA as maps
    use std::collections::BTreeMap;
    let mut rows: Vec<BTreeMap<u32, f64>> = vec![BTreeMap::new(); n];
    let mut rhs = vec![DVec3::ZERO; n];
    for v in 0..n {
        let id = VertexId::from(v);
        let ring: Vec<u32> = t.neighbours(id).map(|w| w.0).collect();
        let k = ring.len() as f64;
        let mut r = vec![(v as u32, 1.0)];
        r.extend(ring.iter().map(|&w| (w, -1.0 / k)));
        for &(a, wa) in &r { for &(b, wb) in &r { *rows[a as usize].entry(b).or_default() += wa * wb; } }
    }
    for (i, &v) in inter.held().iter().enumerate() {
        let (own, row) = inter.row(i);
        let mut r = vec![(v, own)];
        r.extend_from_slice(row);
        let rho = 1e6;
        for &(a, wa) in &r {
            rhs[a as usize] += rho * wa * inter.targets()[i];
            for &(b, wb) in &r { *rows[a as usize].entry(b).or_default() += rho * wa * wb; }
        }
    }
    let mut offsets = vec![0u32]; let mut adj = Vec::new(); let mut val = Vec::new();
    for (v, r) in rows.iter().enumerate() {
        for (&w, &c) in r { adj.push(w); val.push(c); let _ = v; }
        offsets.push(adj.len() as u32);
    }
    let perm = nested_dissection(x, &offsets, &adj);
    let pattern = SymmetricPattern::of_permuted_graph(&offsets, &adj, &perm);
    let mut values = Vec::new();
    for j in 0..n { for p in pattern.col_ptr[j]..pattern.col_ptr[j+1] {
        let i = pattern.row_idx[p];
        values.push(rows[perm[i] as usize][&perm[j]]);
    } }
    let mut ch = Cholesky::new(std::sync::Arc::new(CholeskySymbolic::new(&pattern).unwrap()));
    ch.factorize(&values).unwrap();
    let mut b = vec![0.0; 3*n];
    for (i, &o) in perm.iter().enumerate() { let r = rhs[o as usize]; b[i]=r.x; b[n+i]=r.y; b[2*n+i]=r.z; }
    ch.solve_in_place(&mut b, 3);
    let mut out = x.to_vec();
    for (i, &o) in perm.iter().enumerate() { out[o as usize] = DVec3::new(b[i], b[n+i], b[2*n+i]); }
    inter.settle(&mut out);
    out
}
