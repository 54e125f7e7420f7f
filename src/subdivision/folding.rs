//! Triangles whose unrolled control vertices are not distinct vertices of the mesh.

use std::collections::BTreeMap;

use super::basis::{BasisTable, DERIVATIVES};
use super::masks::{BAND, EXACT_VALENCE, sample};
use super::ring::{Neighbour, extended_ring};
use crate::mesh::{FaceId, Topology, VertexId};

/// How real control vertices determine the unrolled ones of a triangle.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Folding {
    /// Corner valences, including ghosts.
    pub(super) valences: [usize; 3],
    /// Number of distinct real control vertices.
    columns: usize,
    /// The unrolled control vertices in standard order, by columns of real ones.
    sources: Vec<Source>,
}

#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Source {
    Real(u32),
    /// `p + q - r`.
    Ghost([u32; 3]),
    /// The mean of others.
    Mean(Box<[Source]>),
}

impl Source {
    /// Adds the value of the unrolled vertex to those of the real ones.
    fn distribute(&self, value: f64, to: &mut [f64]) {
        match self {
            Self::Real(c) => to[*c as usize] += value,
            Self::Ghost(columns) => {
                let [p, q, r] = columns.map(|c| c as usize);
                to[p] += value;
                to[q] += value;
                to[r] -= value;
            }
            Self::Mean(sources) => {
                let share = value / sources.len() as f64;
                for source in sources {
                    source.distribute(share, to);
                }
            }
        }
    }
}

impl Folding {
    /// Whether a corner has only two neighbours. The triangle is then one of two glued along all
    /// their edges, for which Loop's scheme has no limit surface.
    pub(super) fn is_flat(&self) -> bool {
        self.valences.iter().any(|&n| n < 3)
    }

    /// The table over the real vertices: `N' = N T`, with `T` from real to unrolled vertices.
    pub(super) fn apply(&self, unrolled: &BasisTable) -> BasisTable {
        debug_assert_eq!(unrolled.n, self.sources.len());
        let mut data = vec![0.0; unrolled.points * DERIVATIVES * self.columns];
        let rows = unrolled.data.chunks_exact(unrolled.n);
        for (from, to) in rows.zip(data.chunks_exact_mut(self.columns)) {
            for (&value, source) in from.iter().zip(&self.sources) {
                source.distribute(value, to);
            }
        }
        BasisTable {
            n: self.columns,
            points: unrolled.points,
            data,
        }
    }
}

/// Finds the foldings of the faces of a mesh.
pub(super) struct Folder<'a> {
    topology: &'a Topology,
    /// Rings of more than [`EXACT_VALENCE`] neighbours; each is computed once.
    large: BTreeMap<VertexId, LargeRing>,
}

struct LargeRing {
    ring: Vec<Neighbour>,
    /// Places of the real neighbours in the ring, by vertex.
    place: BTreeMap<VertexId, usize>,
}

/// The neighbours of a corner that its face needs.
struct Corner {
    valence: usize,
    /// Those next to the face counter-clockwise, from the following corner on.
    ring: Vec<Neighbour>,
    /// Those whose mean stands for the others; empty if there are no others.
    sample: Vec<Neighbour>,
}

impl<'a> Folder<'a> {
    pub(super) fn new(topology: &'a Topology) -> Self {
        Self {
            topology,
            large: BTreeMap::new(),
        }
    }

    /// The ring of `v`, from its neighbour `following` on.
    fn corner(&mut self, v: VertexId, following: VertexId) -> Corner {
        let is_large = self.topology.outgoing(v).nth(EXACT_VALENCE).is_some();
        if !is_large {
            let mut ring = Vec::new();
            extended_ring(self.topology, v, &mut ring);
            if ring.len() <= EXACT_VALENCE {
                let first = Neighbour::Real(following);
                let turn = ring.iter().position(|&r| r == first).unwrap_or(0);
                ring.rotate_left(turn);
                let (valence, sample) = (ring.len(), Vec::new());
                return Corner {
                    valence,
                    ring,
                    sample,
                };
            }
        }
        let topology = self.topology;
        let LargeRing { ring, place } = self.large.entry(v).or_insert_with(|| {
            let mut ring = Vec::new();
            extended_ring(topology, v, &mut ring);
            let real = ring.iter().enumerate().filter_map(|(i, r)| match r {
                Neighbour::Real(w) => Some((*w, i)),
                Neighbour::Ghost(_) => None,
            });
            let place = real.collect();
            LargeRing { ring, place }
        });
        let n = ring.len();
        let turn = place.get(&following).copied().unwrap_or(0);
        let half = BAND / 2;
        let band = (0..=half).chain(n + half + 1 - BAND..n);
        let mut places: Vec<usize> = sample(n).collect();
        let next = places.partition_point(|&i| i < turn) % places.len();
        places.rotate_left(next);
        Corner {
            valence: n,
            ring: band.map(|j| ring[(turn + j) % n]).collect(),
            sample: places.into_iter().map(|i| ring[i]).collect(),
        }
    }

    /// The folding of a face and its real control vertices: the corners in the face's order, then the
    /// others in the order of their first occurrence in the outer ring and in the samples.
    pub(super) fn fold(&mut self, f: FaceId) -> (Folding, Vec<u32>) {
        let corners = self.topology.face_vertices(f);
        let around = [0, 1, 2].map(|c| self.corner(corners[c], corners[(c + 1) % 3]));
        let valences = [0, 1, 2].map(|c| around[c].valence);
        if valences.iter().any(|&n| n < 3) {
            let folding = Folding {
                valences,
                columns: 3,
                sources: [0, 1, 2].map(Source::Real).to_vec(),
            };
            return (folding, corners.map(|v| v.0).to_vec());
        }

        // Each ring starts with the two other corners, and its last vertex is the first of the next
        // one.
        let mut unrolled: Vec<Neighbour> = corners.map(Neighbour::Real).to_vec();
        for c in [1, 2, 0] {
            let ring = &around[c].ring;
            unrolled.extend(&ring[2..ring.len() - 1]);
        }
        if valences == [3, 3, 3] {
            unrolled.push(around[0].ring[2]);
        }

        let mut vertices: Vec<u32> = Vec::with_capacity(unrolled.len());
        let mut column = |v: VertexId| {
            let found = vertices.iter().position(|&u| u == v.0);
            found.unwrap_or_else(|| {
                vertices.push(v.0);
                vertices.len() - 1
            }) as u32
        };
        // real ones first: a ghost may precede its defining vertices
        let samples = around.iter().map(|corner| &corner.sample);
        for u in unrolled.iter().chain(samples.clone().flatten()) {
            if let Neighbour::Real(v) = *u {
                column(v);
            }
        }
        let mut source = |u: &Neighbour| match *u {
            Neighbour::Real(v) => Source::Real(column(v)),
            Neighbour::Ghost(g) => Source::Ghost(g.map(&mut column)),
        };
        let mut sources: Vec<Source> = unrolled.iter().map(&mut source).collect();
        for sample in samples.filter(|sample| !sample.is_empty()) {
            sources.push(Source::Mean(sample.iter().map(&mut source).collect()));
        }
        let columns = vertices.len();
        let folding = Folding {
            valences,
            columns,
            sources,
        };
        (folding, vertices)
    }
}
