//! Follows a plane through the faces of a limit surface.

use std::collections::{BTreeMap, BTreeSet};

use glam::DMat3;

use super::{SectionCurve, SectionPoint};
use crate::analysis::bending::{bending_form, vertex_forms};
use crate::analysis::local::FaceSurface;
use crate::mesh::{DVec3, FaceId, Topology, VertexId};

/// Number of pieces into which each edge of a face is divided to find its intersections with the
/// plane. Two intersections within one piece are missed.
const PIECES: u32 = 4;
/// Distances from the plane below this part of the surface's extent are rounding and count as
/// above it, so that a plane through vertices, or along a flat part, gives one curve.
const LEVEL: f64 = 1e-12;
/// Curvature at an irregular vertex, where the limit surface has none, is taken this far inside
/// the face, in parts of its sides.
const BESIDE: f64 = 1e-3;
/// Sine of the angle between plane and tangent plane below which they touch and the section has no
/// curvature.
const TOUCHING: f64 = 1e-6;
/// Maximum evaluations per root; the bracket shrinks to rounding error long before.
const ROUNDS: usize = 60;

/// A point of the lattices of all faces: kind (vertex, edge, face), which one, and which place.
type Place = (u8, u32, u32);
/// An edge between two of them.
type Crossing = [Place; 2];

/// A root looked for on a lattice edge: the parameters of its ends, their heights.
struct Bracket {
    key: Crossing,
    ends: [[f64; 2]; 2],
    heights: [f64; 2],
    /// Place between the ends, 0 to 1.
    at: f64,
    interval: [f64; 2],
}

/// The state of a cut.
pub(super) struct Cutter<'a> {
    topology: &'a Topology,
    control: &'a [DVec3],
    origin: DVec3,
    normal: DVec3,
    level: f64,
    /// Height above the plane of the lattice points met so far, the same seen from all faces.
    heights: BTreeMap<Place, f64>,
    points: BTreeMap<Crossing, SectionPoint>,
    /// Averaged second fundamental forms at the corners of the candidate faces.
    forms: BTreeMap<u32, DMat3>,
    /// From each crossing to the next along the curve.
    next: BTreeMap<Crossing, Crossing>,
}

impl<'a> Cutter<'a> {
    /// Of the plane through `origin` with a unit normal.
    pub(super) fn new(
        topology: &'a Topology,
        control: &'a [DVec3],
        origin: DVec3,
        normal: DVec3,
    ) -> Self {
        let extent = control
            .iter()
            .map(|p| (*p - origin).length())
            .filter(|l| l.is_finite())
            .fold(0.0, f64::max);
        Self {
            topology,
            control,
            origin,
            normal,
            level: LEVEL * extent,
            heights: BTreeMap::new(),
            points: BTreeMap::new(),
            forms: BTreeMap::new(),
            next: BTreeMap::new(),
        }
    }

    /// The curves, open ones first.
    pub(super) fn run(mut self) -> Vec<SectionCurve> {
        let faces = self.candidates();
        self.forms = vertex_forms(self.topology, self.control, &faces);
        for f in faces {
            self.face(f);
        }
        self.curves()
    }

    /// Faces whose control points lie on both sides of the plane; the surface over any other lies
    /// on one side, for it is in their convex hull.
    fn candidates(&self) -> Vec<FaceId> {
        let topology = self.topology;
        let height = |v: VertexId| (self.control[v.index()] - self.origin).dot(self.normal);
        let join = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a.min(c), b.max(d)];
        let ring: Vec<[f64; 2]> = topology
            .vertices()
            .map(|v| {
                topology.neighbours(v).fold([height(v); 2], |r, w| {
                    let h = height(w);
                    join(r, [h, h])
                })
            })
            .collect();
        topology
            .faces()
            .filter(|&f| {
                let corners = topology.face_vertices(f);
                let [a, b, c] = corners.map(|v| ring[v.index()]);
                let [mut low, mut high] = join(join(a, b), c);
                if corners.iter().any(|&v| topology.is_boundary_vertex(v)) {
                    // ghosts p + q - r beyond the boundary
                    (low, high) = (2.0 * low - high, 2.0 * high - low);
                }
                low <= self.level && high >= -self.level
            })
            .collect()
    }

    /// Adds the segments within a face.
    fn face(&mut self, f: FaceId) {
        let lattice: Vec<[u32; 2]> = (0..=PIECES)
            .flat_map(|i| (0..=PIECES - i).map(move |j| [i, j]))
            .collect();
        let Some(surface) = FaceSurface::new(self.topology, self.control, self.origin, f) else {
            return;
        };
        let parameters: Vec<[f64; 2]> = lattice.iter().map(|&ij| parameter(ij)).collect();
        let places: Vec<Place> = lattice.iter().map(|&ij| self.place(f, ij)).collect();
        for (place, (x, _)) in places.iter().zip(surface.at(&parameters)) {
            let mut height = x.dot(self.normal);
            if height.abs() <= self.level {
                height = 0.0;
            }
            self.heights.entry(*place).or_insert(height);
        }
        let heights: Vec<f64> = places.iter().map(|p| self.heights[p]).collect();
        let number = |i: u32, j: u32| (i * (PIECES + 1) - i * i.saturating_sub(1) / 2 + j) as usize;
        let mut brackets = Vec::new();
        for i in 0..PIECES {
            for j in 0..PIECES - i {
                let mut one = |a: usize, b: usize, c: usize| {
                    self.triangle([a, b, c], &places, &heights, &parameters, &mut brackets);
                };
                one(number(i, j), number(i + 1, j), number(i, j + 1));
                if i + j + 1 < PIECES {
                    one(number(i + 1, j), number(i + 1, j + 1), number(i, j + 1));
                }
            }
        }
        self.solve(f, &surface, &mut brackets);
    }

    /// The segment in a lattice triangle: from the edge where its boundary goes down through the
    /// plane to the one where it comes up.
    fn triangle(
        &mut self,
        corners: [usize; 3],
        places: &[Place],
        heights: &[f64],
        parameters: &[[f64; 2]],
        brackets: &mut Vec<Bracket>,
    ) {
        let mut ends: [Option<Crossing>; 2] = [None; 2];
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let comes_up = heights[b] >= 0.0;
            if comes_up == (heights[a] >= 0.0) {
                continue;
            }
            let (lower, upper) = if places[a] < places[b] {
                (a, b)
            } else {
                (b, a)
            };
            let key = [places[lower], places[upper]];
            ends[usize::from(comes_up)] = Some(key);
            if !self.points.contains_key(&key) && brackets.iter().all(|b| b.key != key) {
                brackets.push(Bracket {
                    key,
                    ends: [parameters[lower], parameters[upper]],
                    heights: [heights[lower], heights[upper]],
                    at: 0.5,
                    interval: [0.0, 1.0],
                });
            }
        }
        if let [Some(from), Some(to)] = ends {
            self.next.insert(from, to);
        }
    }

    /// Finds the roots on all brackets of a face at once: regula falsi with the Illinois rule.
    fn solve(&mut self, f: FaceId, surface: &FaceSurface, brackets: &mut [Bracket]) {
        let mut kept = vec![0i8; brackets.len()];
        for _ in 0..ROUNDS {
            let mut done = true;
            for b in brackets.iter_mut() {
                let [low, high] = b.heights;
                let [from, to] = b.interval;
                b.at = (from + (to - from) * low / (low - high)).clamp(from, to);
            }
            let parameters: Vec<[f64; 2]> = brackets.iter().map(Bracket::parameter).collect();
            for ((b, (x, _)), kept) in brackets
                .iter_mut()
                .zip(surface.at(&parameters))
                .zip(&mut kept)
            {
                let height = x.dot(self.normal);
                let [low, high] = b.heights;
                let [from, to] = b.interval;
                if height.abs() <= 1e-2 * self.level || (to - from) <= 4.0 * f64::EPSILON {
                    continue;
                }
                done = false;
                if (height >= 0.0) == (low >= 0.0) {
                    (b.interval[0], b.heights[0]) = (b.at, height);
                    if *kept == 1 {
                        b.heights[1] = 0.5 * high;
                    }
                    *kept = 1;
                } else {
                    (b.interval[1], b.heights[1]) = (b.at, height);
                    if *kept == -1 {
                        b.heights[0] = 0.5 * low;
                    }
                    *kept = -1;
                }
            }
            if done {
                break;
            }
        }
        let parameters: Vec<[f64; 2]> = brackets.iter().map(Bracket::parameter).collect();
        let beside: Vec<[f64; 2]> = parameters.iter().map(|&p| off_corners(p)).collect();
        let at = surface.at(&parameters);
        let forms = self.topology.face_vertices(f).map(|v| self.forms[&v.0]);
        for ((b, (x, _)), (_, geometry)) in brackets.iter().zip(at).zip(surface.at(&beside)) {
            let [v, w] = b.parameter();
            let form = forms[0] * (1.0 - v - w) + forms[1] * v + forms[2] * w;
            let within = geometry.normal - self.normal * geometry.normal.dot(self.normal);
            // cosine of the angle between the normals of the surface and of the curve
            let cosine = within.length();
            let tangent = self.normal.cross(within) / cosine;
            let of = |form: DMat3| {
                if cosine > TOUCHING {
                    tangent.dot(form * tangent) / cosine
                } else {
                    f64::NAN
                }
            };
            let point = SectionPoint {
                at: (x + self.origin).to_array(),
                normal: within.normalize_or_zero().to_array(),
                curvature: of(bending_form(&geometry)),
                averaged: of(form),
                arc: 0.0,
            };
            self.points.insert(b.key, point);
        }
    }

    /// The identifier of a lattice point, the same from every face it lies in.
    fn place(&self, f: FaceId, [i, j]: [u32; 2]) -> Place {
        let corners = self.topology.face_vertices(f);
        // barycentric, in pieces
        let weight = [PIECES - i - j, i, j];
        if let Some(k) = weight.iter().position(|&w| w == PIECES) {
            return (0, corners[k].0, 0);
        }
        let Some(opposite) = weight.iter().position(|&w| w == 0) else {
            return (2, f.0, i * (PIECES + 1) + j);
        };
        let mut h = self.topology.halfedge_of_face(f);
        for _ in 0..(opposite + 1) % 3 {
            h = self.topology.next(h);
        }
        let along = weight[(opposite + 2) % 3];
        let forwards = h.0.is_multiple_of(2);
        let k = if forwards { along } else { PIECES - along };
        (1, h.edge() as u32, k)
    }

    /// Joins the crossings into curves.
    fn curves(&self) -> Vec<SectionCurve> {
        let ends: BTreeSet<&Crossing> = self.next.values().collect();
        let open = self.next.keys().filter(|k| !ends.contains(k));
        let mut used = BTreeSet::new();
        let mut curves = Vec::new();
        for start in open.chain(self.next.keys()) {
            if used.contains(start) {
                continue;
            }
            let mut keys = vec![start];
            used.insert(start);
            let mut closed = false;
            let mut at = start;
            while let Some(next) = self.next.get(at) {
                if !used.insert(next) {
                    closed = next == start;
                    break;
                }
                keys.push(next);
                at = next;
            }
            let points = keys.iter().filter_map(|k| self.points.get(*k).copied());
            curves.extend(self.curve(points, closed));
        }
        curves
    }

    /// Measures a curve and leaves out points that repeat the one before; `None` if one is left.
    fn curve(
        &self,
        points: impl Iterator<Item = SectionPoint>,
        closed: bool,
    ) -> Option<SectionCurve> {
        let gap = |a: &SectionPoint, b: &SectionPoint| {
            DVec3::from_array(a.at).distance(DVec3::from_array(b.at))
        };
        let same = 1e3 * self.level;
        let mut kept: Vec<SectionPoint> = Vec::new();
        let mut length = 0.0;
        for mut point in points {
            if let Some(last) = kept.last() {
                let step = gap(last, &point);
                if step <= same {
                    continue;
                }
                length += step;
            }
            point.arc = length;
            kept.push(point);
        }
        while closed && kept.len() > 1 && gap(&kept[0], &kept[kept.len() - 1]) <= same {
            kept.pop();
            length = kept[kept.len() - 1].arc;
        }
        if closed && kept.len() > 1 {
            length += gap(&kept[0], &kept[kept.len() - 1]);
        }
        (kept.len() > 1).then_some(SectionCurve {
            closed,
            length,
            points: kept,
        })
    }
}

impl Bracket {
    fn parameter(&self) -> [f64; 2] {
        let [a, b] = self.ends;
        [0, 1].map(|k| a[k] + (b[k] - a[k]) * self.at)
    }
}

fn parameter([i, j]: [u32; 2]) -> [f64; 2] {
    [i, j].map(|x| f64::from(x) / f64::from(PIECES))
}

/// The point, moved out of the corners.
fn off_corners([v, w]: [f64; 2]) -> [f64; 2] {
    let third = 1.0 / 3.0;
    if [1.0 - v - w, v, w].iter().any(|&b| b > 1.0 - BESIDE) {
        [v + BESIDE * (third - v), w + BESIDE * (third - w)]
    } else {
        [v, w]
    }
}
