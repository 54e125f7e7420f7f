//! Test meshes: closed and open, regular and irregular, tiny and pinched.

use crate::mesh::{DVec3, Topology};

pub(super) struct Shape {
    pub(super) name: &'static str,
    pub(super) topology: Topology,
    pub(super) positions: Vec<DVec3>,
}

/// Deterministic numbers in -1..1.
pub(super) struct Noise(u64);

impl Noise {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub(super) fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }
}

fn shape(name: &'static str, positions: Vec<DVec3>, triangles: &[[u32; 3]]) -> Shape {
    let topology = Topology::from_triangles(positions.len(), triangles).expect("a manifold");
    let mut noise = Noise::new(7);
    // avoids agreement by symmetry
    let positions = positions
        .into_iter()
        .map(|p| p + 0.05 * noise.vector())
        .collect();
    Shape {
        name,
        topology,
        positions,
    }
}

/// A regular lattice of `m` by `n` unit quads. Each is cut along the diagonal from its lower right
/// to its upper left, or along the other diagonal where `flip` is true.
pub(super) fn grid(m: u32, n: u32, mut flip: impl FnMut() -> bool) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut positions = Vec::new();
    for j in 0..=n {
        for i in 0..=m {
            positions.push(DVec3::new(f64::from(i), f64::from(j), 0.0));
        }
    }
    let at = |i: u32, j: u32| j * (m + 1) + i;
    let mut triangles = Vec::new();
    for j in 0..n {
        for i in 0..m {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            if flip() {
                triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    (positions, triangles)
}

/// A regular torus of `m` by `n` quads; with 3 by 3, stencils contain a vertex more than once.
fn torus(m: u32, n: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    let at = |i: u32, j: u32| (j % n) * m + i % m;
    for j in 0..n {
        for i in 0..m {
            let (s, t) = (
                std::f64::consts::TAU * f64::from(i) / f64::from(m),
                std::f64::consts::TAU * f64::from(j) / f64::from(n),
            );
            let r = 2.0 + t.cos();
            positions.push(DVec3::new(r * s.cos(), r * s.sin(), t.sin()));
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.extend([[a, b, d], [b, c, d]]);
        }
    }
    (positions, triangles)
}

const TETRAHEDRON: [[u32; 3]; 4] = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]];

const OCTAHEDRON: [[u32; 3]; 8] = [
    [0, 1, 2],
    [0, 2, 3],
    [0, 3, 4],
    [0, 4, 1],
    [5, 2, 1],
    [5, 3, 2],
    [5, 4, 3],
    [5, 1, 4],
];

/// A pole, two rings of `n`, a pole: the icosahedron for 5.
pub(super) fn antiprism(n: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut positions = vec![DVec3::Z];
    for (z, turn) in [(0.45, 0.0), (-0.45, 0.5)] {
        for i in 0..n {
            let s = std::f64::consts::TAU * (f64::from(i) + turn) / f64::from(n);
            positions.push(DVec3::new(0.9 * s.cos(), 0.9 * s.sin(), z));
        }
    }
    positions.push(-DVec3::Z);
    let mut triangles = Vec::new();
    for i in 0..n {
        let [a, b] = [1 + i, 1 + (i + 1) % n];
        let [c, d] = [a + n, b + n];
        triangles.extend([[0, a, b], [a, c, b], [b, c, d], [2 * n + 1, d, c]]);
    }
    (positions, triangles)
}

/// An annulus whose hole touches itself at vertex 0: a figure of eight.
pub(super) const PINCHED: [[u32; 3]; 12] = [
    [0, 2, 5],
    [2, 6, 5],
    [2, 1, 6],
    [1, 7, 6],
    [1, 0, 7],
    [0, 8, 7],
    [0, 4, 8],
    [4, 9, 8],
    [4, 3, 9],
    [3, 10, 9],
    [3, 0, 10],
    [0, 5, 10],
];

fn pinched() -> Vec<DVec3> {
    [
        [0.0, 0.0],
        [1.0, -1.0],
        [1.0, 1.0],
        [-1.0, 1.0],
        [-1.0, -1.0],
        [0.7, 2.0],
        [3.0, 0.0],
        [0.7, -2.0],
        [-0.7, -2.0],
        [-3.0, 0.0],
        [-0.7, 2.0],
    ]
    .map(|[x, y]| DVec3::new(x, y, 0.0))
    .to_vec()
}

/// One shape for each type of stencil.
pub(super) fn shapes() -> Vec<Shape> {
    let tetrahedron = vec![
        DVec3::ONE,
        DVec3::new(-1.0, 1.0, -1.0),
        DVec3::new(1.0, -1.0, -1.0),
        DVec3::new(-1.0, -1.0, 1.0),
    ];
    let octahedron = vec![
        DVec3::Z,
        DVec3::X,
        DVec3::Y,
        -DVec3::X,
        -DVec3::Y,
        -DVec3::Z,
    ];
    // a vertex in the middle of one face of the octahedron has valence 3
    let mut spiked = octahedron.clone();
    spiked.push(DVec3::splat(0.5));
    let mut spiked_faces = OCTAHEDRON[1..].to_vec();
    spiked_faces.extend([[0, 1, 6], [1, 2, 6], [2, 0, 6]]);
    let mut noise = Noise::new(3);
    let (open, open_faces) = grid(7, 6, || noise.next() > 0.0);
    let (small, small_faces) = torus(3, 3);
    let (large, large_faces) = torus(7, 5);
    let (icosahedron, icosahedron_faces) = antiprism(5);
    let (spindle, spindle_faces) = antiprism(11);
    let (large_spindle, large_spindle_faces) = antiprism(70);
    let cap: Vec<[u32; 3]> = large_spindle_faces.iter().step_by(4).copied().collect();
    vec![
        shape("tetrahedron", tetrahedron.clone(), &TETRAHEDRON),
        shape("octahedron", octahedron.clone(), &OCTAHEDRON),
        shape("icosahedron", icosahedron, &icosahedron_faces),
        shape("spindle", spindle, &spindle_faces),
        shape("large fan", large_spindle[..71].to_vec(), &cap),
        shape("large open fan", large_spindle[..71].to_vec(), &cap[..66]),
        shape("large spindle", large_spindle, &large_spindle_faces),
        shape("spiked octahedron", spiked, &spiked_faces),
        shape("3 by 3 torus", small, &small_faces),
        shape("torus", large, &large_faces),
        shape("grid", open, &open_faces),
        shape("triangle", tetrahedron[..3].to_vec(), &TETRAHEDRON[..1]),
        shape("two triangles", tetrahedron.clone(), &TETRAHEDRON[..2]),
        shape("open tetrahedron", tetrahedron, &TETRAHEDRON[..3]),
        shape("open octahedron", octahedron.clone(), &OCTAHEDRON[..7]),
        shape("fan", octahedron[..5].to_vec(), &OCTAHEDRON[..4]),
        shape("pinched", pinched(), &PINCHED),
    ]
}
