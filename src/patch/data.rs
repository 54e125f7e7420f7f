//! Rims, and the patches over them.

use crate::mesh::DVec3;

/// The rim of a hole, in the direction in which the patch runs through it: patch triangles contain
/// the directed edges `points[i] → points[i+1]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rim {
    /// The rim's vertices; the last is joined to the first.
    pub points: Vec<DVec3>,
    /// Third vertex of the existing face at rim edge `i → i+1`.
    pub opposite: Vec<DVec3>,
    /// Pairs (i < j) of rim indices already joined by an edge of the mesh that is not a rim edge:
    /// a patch edge there would be non-manifold.
    pub forbidden: Vec<[u32; 2]>,
}

impl Rim {
    /// The forbidden pairs that are not rim edges.
    pub(super) fn chords(&self) -> impl Iterator<Item = [u32; 2]> {
        let last = self.points.len() as u32 - 1;
        let is_chord = move |&[i, j]: &[u32; 2]| j != i + 1 && (i != 0 || j != last);
        self.forbidden.iter().copied().filter(is_chord)
    }
}

/// The rims that one patch joins.
///
/// Rim vertices are numbered rim after rim.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RimGeometry {
    /// The rims, at least one.
    pub rims: Vec<Rim>,
    /// Pairs (i < j) of vertices of different rims that are joined by an edge of the mesh already.
    pub forbidden: Vec<[u32; 2]>,
    /// For each rim the component of the mesh it belongs to. Rims of one component can only be
    /// flipped together.
    pub pieces: Vec<u32>,
}

impl RimGeometry {
    /// A single rim.
    pub fn single(rim: Rim) -> Self {
        Self {
            rims: vec![rim],
            ..Self::default()
        }
    }

    /// The vertices of all rims.
    pub fn points(&self) -> impl Iterator<Item = DVec3> + Clone + '_ {
        self.rims.iter().flat_map(|r| r.points.iter().copied())
    }

    /// Number of rim vertices.
    pub fn vertex_count(&self) -> usize {
        self.rims.iter().map(|r| r.points.len()).sum()
    }

    /// All forbidden pairs that are not rim edges.
    pub(super) fn chords(&self) -> Vec<[u32; 2]> {
        let mut chords = self.forbidden.clone();
        let mut first = 0;
        for rim in &self.rims {
            chords.extend(rim.chords().map(|pair| pair.map(|v| v + first)));
            first += rim.points.len() as u32;
        }
        chords
    }
}

/// How to make the first patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchOptions {
    /// Vertices per length along the patch, relative to the rim: 1 makes equilateral triangles of
    /// the rim's edge length, 2 of half of it.
    pub density: f64,
}

impl Default for PatchOptions {
    fn default() -> Self {
        Self { density: 1.0 }
    }
}

/// A triangulated surface over one or several rims, with its own vertex numbers: first the rim
/// vertices, rim after rim, then the new ones.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Patch {
    /// Number of rim vertices.
    pub rim: usize,
    /// The rims' points first (bit-identical), then the new ones.
    pub points: Vec<DVec3>,
    /// Corners, oriented as the rims run.
    pub triangles: Vec<[u32; 3]>,
}

impl Patch {
    /// The points that are not on a rim.
    pub fn new_points(&self) -> &[DVec3] {
        &self.points[self.rim..]
    }

    /// The smallest angle of each triangle, in degrees.
    fn angles(&self) -> impl Iterator<Item = f64> {
        self.triangles.iter().map(|t| {
            let p = t.map(|v| self.points[v as usize]);
            let angle = |k: usize| {
                let (u, v) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
                u.angle_between(v).to_degrees()
            };
            (0..3).map(angle).fold(f64::INFINITY, f64::min)
        })
    }

    /// The smallest angle of a triangle, in degrees.
    pub fn sharpest_angle(&self) -> f64 {
        self.angles().fold(f64::INFINITY, f64::min)
    }

    /// The share of triangles with an angle below `degrees`.
    pub fn share_below(&self, degrees: f64) -> f64 {
        let below = self.angles().filter(|&angle| angle < degrees).count();
        below as f64 / self.triangles.len() as f64
    }
}
