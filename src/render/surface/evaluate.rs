//! Positions, normals and curvatures at the samples.

use rayon::prelude::*;

use super::samples::Inner;
use super::{DynamicSurface, Evaluation};
use crate::mesh::{DVec3, VertexId};
use crate::render::{Geometry, Vertex};
use crate::subdivision::{Elements, Rule, limit_normal, limit_position};
use crate::surface::{project_to_vertices, surface_point};

/// Mean and Gaussian curvature.
type Curvature = [f64; 2];

/// A sample of the surface.
#[derive(Clone, Copy)]
struct Sample {
    position: DVec3,
    normal: DVec3,
    curvature: Curvature,
    color: [u8; 4],
}

impl DynamicSurface {
    /// The surface at `positions` (one per vertex of the mesh), with all quantities of an
    /// evaluation.
    pub fn evaluate_with(&self, positions: &[DVec3], what: &Evaluation<'_>) -> Geometry {
        let local = self.cut.positions(positions, what.centre);
        let curvature = self.vertex_curvatures(&local);
        let mut samples: Vec<Sample> = self
            .samples
            .corners
            .par_iter()
            .map(|&v| self.corner_sample(v, &local, curvature[v as usize], what))
            .collect();
        samples.par_extend(
            self.samples
                .inner
                .par_iter()
                .map(|&at| self.inner_sample(at, &local, &curvature, what)),
        );
        let deviation = what.start.map(|start| {
            let start = self.cut.positions(start, what.centre);
            self.positions_at_samples(&start, what.limit)
        });
        let of = &self.samples;
        let vertex = |k: usize| {
            let s = of.sample_of[k] as usize;
            let from = deviation.as_ref().map(|d| d[s]);
            let mut vertex = Vertex {
                uv: of.places[k],
                ..as_vertex(&samples[s], from, of.flags_of[k], what)
            };
            if of.colors_of[k][3] > 0 {
                vertex.color = of.colors_of[k];
            }
            vertex
        };
        let vertices = (0..of.sample_of.len())
            .into_par_iter()
            .map(vertex)
            .collect();
        let mut geometry = Geometry::new(vertices, of.triangles.clone(), of.edges.clone());
        geometry.seam.clone_from(&of.seam);
        geometry.textures.clone_from(&of.textures);
        geometry
    }

    /// Lumped L2 projection of the curvatures at quadrature points, per vertex of the cut mesh; NaN
    /// at vertices without faces.
    fn vertex_curvatures(&self, positions: &[DVec3]) -> Vec<Curvature> {
        let at_points: Vec<[[f64; 3]; 3]> = (0..self.elements.len())
            .into_par_iter()
            .map(|e| {
                [0, 1, 2].map(|q| {
                    weighted_curvature(&self.elements, e, self.lattice.inner + q, positions)
                })
            })
            .collect();
        let mut sums = vec![[0.0; 3]; positions.len()];
        // the samples are weighted by area
        let sample = |e: usize, q: usize| Some((1.0, at_points[e][q]));
        project_to_vertices(&self.elements, Rule::Three, sample, |v, weight, point| {
            for (sum, x) in sums[v as usize].iter_mut().zip(point) {
                *sum += weight * x;
            }
        });
        sums.into_iter()
            .map(|[area, h, k]| [h / area, k / area])
            .collect()
    }

    fn corner_sample(
        &self,
        v: u32,
        at: &[DVec3],
        curvature: Curvature,
        what: &Evaluation<'_>,
    ) -> Sample {
        Sample {
            position: self.corner_position(v, at, what.limit),
            normal: self.corner_normal(v, at),
            curvature,
            color: self.color(&[v], &[1.0], what.colors),
        }
    }

    /// A weighted mean of the colours of some vertices; zero if one is unknown.
    fn color(&self, vertices: &[u32], weights: &[f64], colors: &[[f32; 4]]) -> [u8; 4] {
        let mut sum = [0.0; 3];
        for (&v, &weight) in vertices.iter().zip(weights) {
            let Some([r, g, b, _]) = colors.get(self.cut.whole(v) as usize) else {
                return [0; 4];
            };
            for (sum, channel) in sum.iter_mut().zip([r, g, b]) {
                *sum += weight * f64::from(*channel);
            }
        }
        let [r, g, b] = sum.map(|channel| (255.0 * channel).round() as u8);
        [r, g, b, u8::MAX]
    }

    fn corner_position(&self, v: u32, at: &[DVec3], limit: bool) -> DVec3 {
        if limit {
            limit_position(&self.cut.topology, at, VertexId(v))
        } else {
            at[v as usize]
        }
    }

    fn corner_normal(&self, v: u32, at: &[DVec3]) -> DVec3 {
        let topology = &self.cut.topology;
        let v = VertexId(v);
        let normal = limit_normal(topology, at, v);
        if normal != DVec3::ZERO {
            return normal;
        }
        // the tangents vanish (a fold, two triangles back to back): use the normal of the faces
        topology
            .outgoing(v)
            .map(|h| topology.face(h))
            .filter(|f| f.is_some())
            .map(|f| {
                let [a, b, c] = topology.face_vertices(f).map(|v| at[v.index()]);
                (b - a).cross(c - a)
            })
            .sum::<DVec3>()
            .normalize_or_zero()
    }

    fn inner_sample(
        &self,
        inner: Inner,
        at: &[DVec3],
        curvature: &[Curvature],
        what: &Evaluation<'_>,
    ) -> Sample {
        let (e, q) = (inner.element as usize, inner.point as usize);
        let weights = self.weights(q);
        let vertices = self.elements.vertices_of(e);
        let between = |f: &dyn Fn(u32) -> f64| (0..3).map(|k| weights[k] * f(vertices[k])).sum();
        let normal: DVec3 = if inner.straight {
            (0..3)
                .map(|k| weights[k] * self.corner_normal(vertices[k], at))
                .sum()
        } else {
            let along = |d| combine(self.elements.table(e).row(q, d), vertices, at);
            along(1).cross(along(2))
        };
        Sample {
            position: self.inner_position(inner, at, what.limit),
            color: self.color(&vertices[..3], &weights, what.colors),
            normal: normal.normalize_or_zero(),
            curvature: [0, 1].map(|k| between(&|c| curvature[c as usize][k])),
        }
    }

    fn inner_position(&self, inner: Inner, at: &[DVec3], limit: bool) -> DVec3 {
        let (e, q) = (inner.element as usize, inner.point as usize);
        let vertices = self.elements.vertices_of(e);
        if inner.straight {
            let weights = self.weights(q);
            let corner = |k: usize| weights[k] * self.corner_position(vertices[k], at, limit);
            (0..3).map(corner).sum()
        } else if limit {
            combine(self.elements.table(e).row(q, 0), vertices, at)
        } else {
            let [a, b, c] = [0, 1, 2].map(|k| at[vertices[k] as usize]);
            let [v, w] = self.lattice.points[q];
            a + v * (b - a) + w * (c - a)
        }
    }

    /// Barycentric coordinates of a point of the lattice.
    fn weights(&self, point: usize) -> [f64; 3] {
        let [v, w] = self.lattice.points[point];
        [1.0 - v - w, v, w]
    }

    fn positions_at_samples(&self, at: &[DVec3], limit: bool) -> Vec<DVec3> {
        let corners = self.samples.corners.par_iter();
        let mut out: Vec<DVec3> = corners
            .map(|&v| self.corner_position(v, at, limit))
            .collect();
        let inner = self.samples.inner.par_iter();
        out.par_extend(inner.map(|&inner| self.inner_position(inner, at, limit)));
        out
    }
}

fn combine(row: &[f64], vertices: &[u32], positions: &[DVec3]) -> DVec3 {
    row.iter()
        .zip(vertices)
        .fold(DVec3::ZERO, |sum, (&b, &v)| sum + b * positions[v as usize])
}

/// Area, and area times `H` and `K`, at a point of an element; zeros where it is degenerate.
fn weighted_curvature(elements: &Elements, e: usize, point: usize, at: &[DVec3]) -> [f64; 3] {
    let (_, p) = surface_point(elements, e, point, at);
    let sums = [p.sqrt_g, p.sqrt_g * p.mean, p.sqrt_g * p.gauss];
    if sums.into_iter().all(f64::is_finite) {
        sums
    } else {
        [0.0; 3]
    }
}

fn as_vertex(sample: &Sample, from: Option<DVec3>, flags: u32, what: &Evaluation<'_>) -> Vertex {
    let [mean, gauss] = sample.curvature;
    let narrow = |x: DVec3| x.to_array().map(|c| c as f32);
    let mut vertex = Vertex {
        position: narrow(sample.position),
        normal: narrow(sample.normal),
        flags,
        color: sample.color,
        ..Vertex::default()
    };
    let [h, k] = [mean as f32, gauss as f32];
    if h.is_finite() && k.is_finite() {
        (vertex.mean, vertex.gauss) = (h, k);
        vertex.flags |= Vertex::CURVATURE;
        if what.ill_posed.is_some_and(|is| is(mean, gauss)) {
            vertex.flags |= Vertex::ILL_POSED;
        }
    }
    if let Some(from) = from {
        vertex.deviation = (sample.position - from).dot(sample.normal) as f32;
        vertex.flags |= Vertex::DEVIATION;
    }
    if let Some(distance) = what.distance {
        vertex.deviation = distance(sample.position + what.centre) as f32;
        vertex.flags = (vertex.flags & !Vertex::DEVIATION) | Vertex::DISTANCE;
    }
    vertex
}
