//! `∫|∇H|² dA` of a Loop limit surface.
//!
//! The limit surface has no third derivatives across edges and no curvature at irregular vertices,
//! so its mean curvature is first projected to a continuous piecewise linear function `H_h`: its
//! value at a vertex v is the average of H around v, weighted with the hat function `ψ_v` (L2
//! projection with lumped mass). The integral is that of `|∇H_h|²` in the metric of the limit
//! surface.

use rayon::prelude::*;

use crate::mesh::{DVec3, FaceId, Topology};
use crate::subdivision::{Elements, Rule, elements};
use crate::surface::{PointGeometry, project_to_vertices, surface_point};

/// Fewest points that a task evaluates.
const TASK: usize = 256;

/// Evaluates `∫|∇H_h|² dA` over some faces.
pub struct MeanVariation {
    elements: Elements,
    rule: Rule,
    /// For each element whether it belongs to the faces of the integral; the others surround them.
    counts: Vec<bool>,
    /// The geometry at each point of each element.
    points: Vec<PointGeometry>,
    /// `∫ψ_v` by vertex.
    mass: Vec<f64>,
    /// `H_h` by vertex; 0 at the vertices of no element.
    mean: Vec<f64>,
    stiffness: Vec<Stiffness>,
}

/// The integral over a triangle as a quadratic form in `(H_1 − H_0, H_2 − H_0)`, the differences of
/// the values at its corners: `∫ g^11, ∫ g^12, ∫ g^22`.
pub type Stiffness = [f64; 3];

impl MeanVariation {
    /// For the integral over `faces`. The projection uses the faces at their corners that are not
    /// `excluded`.
    pub fn new(
        topology: &Topology,
        faces: &[FaceId],
        excluded: impl Fn(FaceId) -> bool,
        rule: Rule,
    ) -> Self {
        let mut is_corner = vec![false; topology.vertex_count()];
        for v in faces.iter().flat_map(|&f| topology.face_vertices(f)) {
            is_corner[v.index()] = true;
        }
        let touches = |f: &FaceId| {
            let corners = topology.face_vertices(*f);
            corners.iter().any(|v| is_corner[v.index()])
        };
        let around = topology.faces().filter(touches);
        let around: Vec<FaceId> = around.filter(|&f| !excluded(f)).collect();
        let mut wanted = vec![false; topology.face_count()];
        for f in faces {
            wanted[f.index()] = true;
        }
        let elements = elements(topology, &around, rule);
        Self {
            counts: elements
                .faces()
                .iter()
                .map(|&f| wanted[f as usize])
                .collect(),
            stiffness: vec![[0.0; 3]; elements.len()],
            points: Vec::new(),
            mass: vec![0.0; topology.vertex_count()],
            mean: vec![0.0; topology.vertex_count()],
            elements,
            rule,
        }
    }

    /// The integral over the surface of these control points. Points without area or curvature are
    /// left out; the flag is false if there are any.
    pub fn evaluate(&mut self, positions: &[DVec3]) -> (f64, bool) {
        let (elements, per_element) = (&self.elements, self.rule.points().len());
        (0..elements.len() * per_element)
            .into_par_iter()
            .with_min_len(TASK)
            .map(|i| surface_point(elements, i / per_element, i % per_element, positions).1)
            .collect_into_vec(&mut self.points);
        let is_regular = |p: &PointGeometry| p.sqrt_g > 0.0 && p.mean.is_finite();
        let are_regular = self.points.iter().all(is_regular);

        let (mass, mean) = (&mut self.mass, &mut self.mean);
        mass.fill(0.0);
        mean.fill(0.0);
        let unit = 0.5 * self.rule.weight();
        let sample = |e: usize, q: usize| {
            let p = &self.points[e * per_element + q];
            is_regular(p).then_some((unit * p.sqrt_g, p.mean))
        };
        project_to_vertices(elements, self.rule, sample, |v, weight, h| {
            mass[v as usize] += weight;
            mean[v as usize] += weight * h;
        });
        for (h, m) in mean.iter_mut().zip(&*mass).filter(|(_, m)| **m > 0.0) {
            *h /= m;
        }

        let mut value = 0.0;
        for e in (0..elements.len()).filter(|&e| self.counts[e]) {
            let own = &self.points[e * per_element..(e + 1) * per_element];
            let mut form = [0.0; 3];
            for p in own.iter().filter(|p| is_regular(p)) {
                for (sum, g) in form.iter_mut().zip(p.g_inv) {
                    *sum += unit * p.sqrt_g * g;
                }
            }
            self.stiffness[e] = form;
            let [a, b] = self.differences(e);
            value += form[0] * a * a + 2.0 * form[1] * a * b + form[2] * b * b;
        }
        (value, are_regular)
    }

    /// `H_1 − H_0, H_2 − H_0` at the corners of an element.
    pub fn differences(&self, element: usize) -> [f64; 2] {
        let [h0, h1, h2] = self.corners(element).map(|v| self.mean[v as usize]);
        [h1 - h0, h2 - h0]
    }

    /// The corners of an element.
    pub fn corners(&self, element: usize) -> [u32; 3] {
        let vertices = self.elements.vertices_of(element);
        [vertices[0], vertices[1], vertices[2]]
    }

    /// The elements at whose points the surface is evaluated.
    pub fn elements(&self) -> &Elements {
        &self.elements
    }

    /// The quadrature rule.
    pub fn rule(&self) -> Rule {
        self.rule
    }

    /// Whether an element belongs to the faces of the integral.
    pub fn counts(&self, element: usize) -> bool {
        self.counts[element]
    }

    /// The form of an element at the last evaluation.
    pub fn stiffness(&self, element: usize) -> Stiffness {
        self.stiffness[element]
    }

    /// The geometry at the points of an element at the last evaluation.
    pub fn points(&self, element: usize) -> &[PointGeometry] {
        let n = self.rule.points().len();
        &self.points[element * n..(element + 1) * n]
    }

    /// `∫ψ_v` and `H_h` at a vertex at the last evaluation.
    pub fn at(&self, vertex: u32) -> (f64, f64) {
        (self.mass[vertex as usize], self.mean[vertex as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A torus with radii 3 and 1 whose vertices all have valence 6.
    fn torus(around: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let (major, minor) = (2 * around, around);
        let at = |i: u32, j: u32| (i % major) * minor + j % minor;
        let (mut points, mut triangles) = (Vec::new(), Vec::new());
        for i in 0..major {
            for j in 0..minor {
                let u = TAU * f64::from(i) / f64::from(major);
                let v = TAU * f64::from(j) / f64::from(minor);
                let r = 3.0 + v.cos();
                points.push(DVec3::new(r * u.cos(), r * u.sin(), v.sin()));
                triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        (points, triangles)
    }

    fn value(points: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
        let topology = Topology::from_triangles(points.len(), triangles).expect("a surface");
        let faces: Vec<FaceId> = topology.faces().collect();
        let mut variation = MeanVariation::new(&topology, &faces, |_| false, Rule::Twelve);
        let (value, regular) = variation.evaluate(points);
        assert!(regular);
        value
    }

    /// With `R = 3`, `r = 1`: `H = −½ (1 + cos v / (3 + cos v))`, `|∇H| = ½ · 3 |sin v| / (3 + cos v)²`,
    /// so the integral is `2π ∫ ¼ 9 sin² v / (3 + cos v)³ dv`.
    #[test]
    fn the_value_of_a_torus_converges() {
        let n = 10_000;
        let step = TAU / f64::from(n);
        let density = |v: f64| 2.25 * v.sin().powi(2) / (3.0 + v.cos()).powi(3);
        let sum: f64 = (0..n).map(|i| density(step * f64::from(i))).sum();
        let exact = TAU * step * sum;
        let errors = [16, 32, 64].map(|around| {
            let (points, triangles) = torus(around);
            (value(&points, &triangles) / exact - 1.0).abs()
        });
        assert!(errors[2] < 0.01, "{errors:?}");
        for pair in errors.windows(2) {
            assert!(pair[1] < 0.3 * pair[0], "{errors:?}");
        }
    }

    /// Motions change nothing; `∫|∇H|²` has the unit 1 / length².
    #[test]
    fn the_value_is_invariant_and_scales() {
        let (points, triangles) = torus(12);
        let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0);
        let moved: Vec<DVec3> = points
            .iter()
            .map(|&p| 5.0 * (turn * p) + DVec3::new(1.0, -2.0, 3.0))
            .collect();
        let [a, b] = [&points, &moved].map(|p| value(p, &triangles));
        assert!((25.0 * b / a - 1.0).abs() < 1e-9, "{a} {b}");
        let flipped: Vec<[u32; 3]> = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
        assert!((value(&points, &flipped) / a - 1.0).abs() < 1e-9);
    }

    /// Cylinders and planes over regular lattices have a constant mean curvature.
    #[test]
    fn surfaces_of_constant_mean_curvature_have_none() {
        for radius in [f64::INFINITY, 2.0] {
            let (across, along) = (24, 9);
            let (mut points, mut triangles) = (Vec::new(), Vec::new());
            for i in 0..along {
                for j in 0..across {
                    let (x, y) = (f64::from(j) + 0.5 * f64::from(i % 2), 0.8 * f64::from(i));
                    points.push(if radius.is_finite() {
                        let angle = TAU * x / f64::from(across);
                        DVec3::new(radius * angle.cos(), radius * angle.sin(), 0.5 * y)
                    } else {
                        DVec3::new(x, y, 0.0)
                    });
                    let is_last = j + 1 == across;
                    if i + 1 < along && (radius.is_finite() || !is_last) {
                        let next = (j + 1) % across;
                        let [a, b] = [i * across + j, i * across + next];
                        let [c, d] = [a + across, b + across];
                        if i % 2 == 0 {
                            triangles.extend([[a, b, c], [b, d, c]]);
                        } else {
                            triangles.extend([[a, b, d], [a, d, c]]);
                        }
                    }
                }
            }
            let topology = Topology::from_triangles(points.len(), &triangles).expect("a surface");
            let is_inside = |f: &FaceId| {
                let corners = topology.face_vertices(*f).map(|v| v.0 / across);
                corners.iter().all(|i| (3..6).contains(i))
            };
            let faces: Vec<FaceId> = topology.faces().filter(is_inside).collect();
            assert!(faces.len() > 60);
            let mut variation = MeanVariation::new(&topology, &faces, |_| false, Rule::Three);
            let (value, _) = variation.evaluate(&points);
            assert!(value < 1e-12, "{radius}: {value:e}");
        }
    }
}
