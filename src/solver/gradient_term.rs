//! The term `c ∫|∇H|² dA` of an energy: value, exact gradient, and matrix of scheme B.
//!
//! The value is `E = c Hᵀ K H` with the projected mean curvatures `H_v = A_v / m_v`,
//! `A_v = ∫ψ_v H`, `m_v = ∫ψ_v`, and the stiffness matrix K of the hat functions on the limit
//! surface ([`MeanVariation`]). With `y = 2c K H` its derivative is
//!
//! ```text
//! δE = Σ_v y_v/m_v δA_v − y_v H_v/m_v δm_v  +  c Hᵀ δK H.
//! ```
//!
//! The sum is the first variation (12) of `∫ Y H − Z` with the functions `Y = Σ ψ_v y_v/m_v`,
//! `Z = Σ ψ_v H_v y_v/m_v` held fixed on the parameter domain. The matrix is `2c Jᵀ K J` with the
//! derivatives `J_vj = (1/m_v) ∫ψ_v δH_j` of the mean curvatures along the normals.

use std::sync::Arc;

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::energy::{Energy, Jet2};
use crate::mesh::{DVec3, FaceId};
use crate::solver::FlowProblem;
use crate::solver::assembly::EnergySum;
use crate::solver::forms::{mean_variation, variation};
use crate::solver::sparsity::{IndexLists, SymmetricScatter, packed};
use crate::solver::unknowns::Unknowns;
use crate::subdivision::Rule;
use crate::surface::{MeanVariation, PointGeometry};

/// Elements of one task.
const TASK: usize = 64;

/// The first ring whose projected mean curvatures do not depend on moving vertices.
const FIXED_RING: u8 = 3;

/// The term over the faces of a problem with a vertex inside the [`FIXED_RING`], without those beyond a
/// rim with free curvature.
pub struct GradientTerm {
    surface: MeanVariation,
    /// c.
    weight: f64,
    /// `y_v/m_v` and `H_v y_v/m_v` by vertex.
    dual: Vec<[f64; 2]>,
    /// Factor of the membrane term of the matrix.
    stiffening: f64,
    matrix: Option<MatrixPart>,
}

/// What the matrix needs beside the surface.
struct MatrixPart {
    rows: Rows,
    unknowns: Arc<Unknowns>,
    scatter: Arc<SymmetricScatter>,
    /// The first of the scatter's lists that belongs to the edges.
    first_list: usize,
}

/// Which unknowns each mean curvature depends on.
struct Rows {
    /// The vertices that move on which each row depends, row by row.
    vertices: IndexLists,
    /// For each corner of each element and each of its control vertices, the place in the items of
    /// `vertices`; [`NOWHERE`] for fixed vertices and corners without a row.
    places: Vec<u32>,
    /// The edges between vertices with rows.
    edges: Vec<[u32; 2]>,
    /// For each element the edges opposite its corners; [`NOWHERE`] outside the integral.
    edge_of: Vec<[u32; 3]>,
    /// For each edge, for each item of its two rows, the place in the list of the edge.
    merged: IndexLists,
    /// For each edge, the places of its ends in its list; [`NOWHERE`] for fixed ends.
    ends: Vec<[u32; 2]>,
}

const NOWHERE: u32 = u32::MAX;

impl GradientTerm {
    /// The term of an energy, by `rule`; `None` if the energy has no such term.
    pub fn of(problem: &FlowProblem, energy: &Energy, rule: Rule) -> Option<Self> {
        if energy.gradient() == 0.0 {
            return None;
        }
        let (topology, ring) = (problem.topology(), problem.ring());
        let rings = |f: FaceId| topology.face_vertices(f).map(|v| ring[v.index()]);
        let is_free = problem.free_curvature_marks();
        // farther out the region ends
        let is_excluded = |f: FaceId| {
            rings(f).iter().any(|&r| r > FIXED_RING)
                || problem.is_beyond_free_curvature(&is_free, f)
        };
        let is_moved = |f: &FaceId| rings(*f).iter().any(|&r| r < FIXED_RING);
        let faces = topology.faces().filter(|f| is_moved(f) && !is_excluded(*f));
        let faces: Vec<FaceId> = faces.collect();
        Some(Self {
            surface: MeanVariation::new(topology, &faces, is_excluded, rule),
            weight: energy.gradient(),
            dual: vec![[0.0; 2]; problem.positions().len()],
            stiffening: 0.0,
            matrix: None,
        })
    }

    /// Makes the membrane term of the matrix stronger after a step that does not lower the energy.
    pub fn stiffen(&mut self) {
        self.stiffening = (4.0 * self.stiffening).clamp(1.0, 256.0);
    }

    /// Makes it weaker again after one that does.
    pub fn soften(&mut self) {
        self.stiffening = if self.stiffening > 1.0 {
            0.5 * self.stiffening
        } else {
            0.0
        };
    }

    /// The unknowns and the sparsity of a matrix with this term and the elements of the problem by
    /// `rule`; prepares the term for [`Self::add_matrix`].
    pub fn dissected(
        &mut self,
        problem: &FlowProblem,
        rule: Rule,
    ) -> (Arc<Unknowns>, Arc<SymmetricScatter>) {
        let elements = problem.discretization().elements(rule);
        let mut rows = None;
        let (unknowns, scatter) = Unknowns::dissected_by(
            |unknowns| {
                let mut lists = unknowns.lists(elements);
                rows = Some(Rows::new(&self.surface, unknowns, &mut lists));
                lists
            },
            problem.positions(),
            problem.moving(),
        );
        let (unknowns, scatter) = (Arc::new(unknowns), Arc::new(scatter));
        self.matrix = rows.map(|rows| MatrixPart {
            rows,
            unknowns: Arc::clone(&unknowns),
            scatter: Arc::clone(&scatter),
            first_list: elements.len(),
        });
        (unknowns, scatter)
    }

    /// The value of the term; not a number where the surface degenerates.
    pub fn evaluate(&mut self, positions: &[DVec3]) -> EnergySum {
        let (value, is_regular) = self.surface.evaluate(positions);
        if !is_regular {
            return EnergySum {
                value: f64::NAN,
                scale: f64::NAN,
            };
        }
        let value = self.weight * value;
        EnergySum {
            value,
            scale: value.abs(),
        }
    }

    /// The value of the term. Adds its derivatives to `gradient`, one vector for each unknown.
    pub fn add_gradient(
        &mut self,
        positions: &[DVec3],
        unknowns: &Unknowns,
        gradient: &mut [DVec3],
    ) -> EnergySum {
        let sum = self.evaluate(positions);
        if sum.value.is_nan() {
            return sum;
        }
        self.evaluate_dual();
        let surface = &self.surface;
        let elements = surface.elements();
        let tasks = elements.len().div_ceil(TASK);
        let range = |t: usize| t * TASK..((t + 1) * TASK).min(elements.len());
        let parts: Vec<Vec<DVec3>> = (0..tasks)
            .into_par_iter()
            .map(|t| {
                let mut part = Vec::new();
                range(t).for_each(|e| self.element_gradient(e, &mut part));
                part
            })
            .collect();
        for (t, part) in parts.iter().enumerate() {
            let vertices = range(t).flat_map(|e| elements.vertices_of(e));
            for (&v, g) in vertices.zip(part) {
                let unknown = unknowns.of_vertex[v as usize] as usize;
                if let Some(sum) = gradient.get_mut(unknown) {
                    *sum += *g;
                }
            }
        }
        sum
    }

    /// `y/m` and `H y/m` at the vertices.
    fn evaluate_dual(&mut self) {
        let surface = &self.surface;
        self.dual.fill([0.0; 2]);
        for e in (0..surface.elements().len()).filter(|&e| surface.counts(e)) {
            let [a, b] = surface.differences(e);
            let [aa, ab, bb] = surface.stiffness(e);
            let (y1, y2) = (aa * a + ab * b, ab * a + bb * b);
            let corners = surface.corners(e).into_iter();
            for (v, y) in corners.zip([-y1 - y2, y1, y2]) {
                self.dual[v as usize][0] += 2.0 * self.weight * y;
            }
        }
        for (v, dual) in (0..).zip(&mut self.dual) {
            if dual[0] != 0.0 {
                let (mass, mean) = surface.at(v);
                let y = dual[0] / mass;
                *dual = [y, mean * y];
            }
        }
    }

    /// Appends the derivatives by the control vertices of an element.
    fn element_gradient(&self, e: usize, out: &mut Vec<DVec3>) {
        let surface = &self.surface;
        let table = surface.elements().table(e);
        let begin = out.len();
        out.resize(begin + surface.elements().vertices_of(e).len(), DVec3::ZERO);
        let duals = surface.corners(e).map(|v| self.dual[v as usize]);
        let counts = surface.counts(e);
        if !counts && duals.iter().all(|d| d[0] == 0.0) {
            return;
        }
        let unit = 0.5 * surface.rule().weight();
        let [a, b] = surface.differences(e);
        for (q, (p, &[v, w])) in (surface.points(e).iter().zip(surface.rule().points())).enumerate()
        {
            let at = |k: usize| (1.0 - v - w) * duals[0][k] + v * duals[1][k] + w * duals[2][k];
            let (y, z) = (at(0), at(1));
            let jet = Jet2 {
                f: y * p.mean - z,
                h: y,
                ..Jet2::default()
            };
            let mut form = variation(p, &jet, unit * p.sqrt_g);
            if counts {
                let [m_u, m_v] = metric_variation(p, a, b);
                form.a_u += self.weight * unit * m_u;
                form.a_v += self.weight * unit * m_v;
            }
            let row = |d| table.row(q, d);
            let (n_u, n_v) = (row(1), row(2));
            let (n_uu, n_uv, n_vv) = (row(3), row(4), row(5));
            for (i, g) in out[begin..].iter_mut().enumerate() {
                let second = form.q[0] * n_uu[i] + form.q[1] * n_uv[i] + form.q[2] * n_vv[i];
                *g += n_u[i] * form.a_u + n_v[i] * form.a_v + second * p.normal;
            }
        }
    }

    /// Adds the matrix at the point of the last gradient, for displacements along `normals`, one
    /// for each unknown. Adds nothing if the coefficient is negative.
    ///
    /// # Panics
    /// If the term was not [`dissected`](Self::dissected).
    pub fn add_matrix(&self, normals: &[DVec3], values: &mut [f64]) {
        if self.weight <= 0.0 {
            return;
        }
        let part = self.matrix.as_ref().expect("made with a matrix");
        let (rows, surface) = (&part.rows, &self.surface);
        let mut derivatives = vec![0.0; rows.vertices.items.len()];
        let mut stiffness = vec![0.0; rows.edges.len()];
        let mut bend = vec![0.0; self.dual.len()];
        let mut along = Vec::new();
        let mut at_place = 0;
        let unit = 0.5 * surface.rule().weight();
        for e in 0..surface.elements().len() {
            let vertices = surface.elements().vertices_of(e);
            let places = &rows.places[at_place..at_place + 3 * vertices.len()];
            at_place += places.len();
            if rows.edge_of[e][0] != NOWHERE {
                let [aa, ab, bb] = surface.stiffness(e);
                // −K of the pairs of corners opposite each corner
                for (edge, k) in rows.edge_of[e].iter().zip([-ab, bb + ab, aa + ab]) {
                    stiffness[*edge as usize] += k;
                }
            }
            if places.iter().all(|&p| p == NOWHERE) {
                continue;
            }
            let table = surface.elements().table(e);
            for (q, (p, &[v, w])) in
                (surface.points(e).iter().zip(surface.rule().points())).enumerate()
            {
                let form = mean_variation(p);
                along.clear();
                along.extend(vertices.iter().enumerate().map(|(i, &vertex)| {
                    let unknown = part.unknowns.of_vertex[vertex as usize] as usize;
                    let Some(normal) = normals.get(unknown) else {
                        return 0.0;
                    };
                    let value: f64 = (0..6).map(|d| form[d] * table.row(q, d)[i]).sum();
                    unit * p.sqrt_g * value * normal.dot(p.normal)
                }));
                let hats = [1.0 - v - w, v, w];
                let square = 4.0 * p.mean * p.mean - 2.0 * p.gauss;
                for (corner, hat) in surface.corners(e).into_iter().zip(hats) {
                    bend[corner as usize] += hat * unit * p.sqrt_g * square.max(0.0).sqrt();
                }
                for (own, hat) in places.chunks_exact(vertices.len()).zip(hats) {
                    for (&place, value) in own.iter().zip(&along) {
                        if place != NOWHERE {
                            derivatives[place as usize] += hat * value;
                        }
                    }
                }
            }
        }
        part.add_edges(surface, &derivatives, &stiffness, 2.0 * self.weight, values);
        if self.stiffening > 0.0 {
            let of = |v: u32| {
                let (mass, _) = surface.at(v);
                self.stiffening * self.dual[v as usize][0].abs() * bend[v as usize] / mass
            };
            part.add_membrane(of, values);
        }
    }
}

impl MatrixPart {
    /// Adds `factor Σ −K_vw (J_v − J_w)(J_v − J_w)ᵀ` over the edges `vw`; `derivatives` are `m J`.
    fn add_edges(
        &self,
        surface: &MeanVariation,
        derivatives: &[f64],
        stiffness: &[f64],
        factor: f64,
        values: &mut [f64],
    ) {
        let rows = &self.rows;
        let mut difference = Vec::new();
        for (k, (edge, &stiff)) in rows.edges.iter().zip(stiffness).enumerate() {
            difference.clear();
            let mut merged = rows.merged.of(k).iter();
            for (&v, sign) in edge.iter().zip([1.0, -1.0]) {
                let row = rows.vertices.start[v as usize]..rows.vertices.start[v as usize + 1];
                let per_mass = sign / surface.at(v).0;
                for (at, &place) in row.zip(&mut merged) {
                    let place = place as usize;
                    if place >= difference.len() {
                        difference.resize(place + 1, 0.0);
                    }
                    difference[place] += per_mass * derivatives[at as usize];
                }
            }
            let mut slots = self.scatter.slots(self.first_list + k).iter();
            for (i, a) in difference.iter().enumerate() {
                for (b, &slot) in difference[..=i].iter().zip(&mut slots) {
                    values[slot as usize] += factor * stiff * a * b;
                }
            }
        }
    }

    /// Adds `Σ k (d_v − d_w)²` over the edges `vw` for displacements d, k the larger of `weight` at
    /// both ends.
    fn add_membrane(&self, weight: impl Fn(u32) -> f64, values: &mut [f64]) {
        let rows = &self.rows;
        for (k, (edge, places)) in rows.edges.iter().zip(&rows.ends).enumerate() {
            let [a, b] = edge.map(&weight);
            let stiff = a.max(b);
            let slots = self.scatter.slots(self.first_list + k);
            let mut add = |i: u32, j: u32, value: f64| {
                if i != NOWHERE && j != NOWHERE {
                    values[slots[packed(i as usize, j as usize)] as usize] += value;
                }
            };
            let [i, j] = *places;
            add(i, i, stiff);
            add(j, j, stiff);
            add(i, j, -stiff);
        }
    }
}

impl Rows {
    /// Appends to `lists` the unknowns that each edge between two mean curvatures depends on.
    fn new(surface: &MeanVariation, unknowns: &Unknowns, lists: &mut IndexLists) -> Self {
        let elements = surface.elements();
        let count = unknowns.of_vertex.len();
        let mut has_row = vec![false; count];
        for e in (0..elements.len()).filter(|&e| surface.counts(e)) {
            for v in surface.corners(e) {
                has_row[v as usize] = true;
            }
        }
        let is_moving = |v: u32| (unknowns.of_vertex[v as usize] as usize) < unknowns.len();
        let mut own: Vec<Vec<u32>> = vec![Vec::new(); count];
        for e in 0..elements.len() {
            for corner in surface
                .corners(e)
                .into_iter()
                .filter(|&v| has_row[v as usize])
            {
                let row = &mut own[corner as usize];
                for &v in elements.vertices_of(e) {
                    if is_moving(v) && !row.contains(&v) {
                        row.push(v);
                    }
                }
            }
        }
        let mut vertices = IndexLists {
            start: Vec::with_capacity(count + 1),
            items: Vec::new(),
        };
        vertices.start.push(0);
        for row in &own {
            vertices.items.extend(row);
            vertices.start.push(vertices.items.len() as u32);
        }
        let mut places = Vec::with_capacity(3 * elements.vertices().len());
        let place = |corner: u32, v: u32| {
            let row = vertices.of(corner as usize).iter();
            let place = row.clone().position(|&own| own == v);
            place.map_or(NOWHERE, |i| vertices.start[corner as usize] + i as u32)
        };
        for e in 0..elements.len() {
            for corner in surface.corners(e) {
                places.extend(elements.vertices_of(e).iter().map(|&v| place(corner, v)));
            }
        }
        let mut out = Self {
            places,
            edges: Vec::new(),
            edge_of: vec![[NOWHERE; 3]; elements.len()],
            ends: Vec::new(),
            merged: IndexLists {
                start: vec![0],
                items: Vec::new(),
            },
            vertices,
        };
        let mut known = FxHashMap::default();
        for e in (0..elements.len()).filter(|&e| surface.counts(e)) {
            let [a, b, c] = surface.corners(e);
            let edges = [[b, c], [c, a], [a, b]].map(|[v, w]| {
                *known.entry([v.min(w), v.max(w)]).or_insert_with(|| {
                    out.push_edge([v, w], unknowns, lists);
                    out.edges.len() as u32 - 1
                })
            });
            out.edge_of[e] = edges;
        }
        out
    }

    fn push_edge(&mut self, edge: [u32; 2], unknowns: &Unknowns, lists: &mut IndexLists) {
        let begin = lists.items.len();
        for v in edge {
            for &vertex in self.vertices.of(v as usize) {
                let unknown = unknowns.of_vertex[vertex as usize];
                let list = &lists.items[begin..];
                let place = list.iter().position(|&u| u == unknown);
                let place = place.unwrap_or_else(|| {
                    lists.items.push(unknown);
                    lists.items.len() - 1 - begin
                });
                self.merged.items.push(place as u32);
            }
        }
        let list = &lists.items[begin..];
        self.ends.push(edge.map(|v| {
            let own = unknowns.of_vertex[v as usize];
            let place = list.iter().position(|&u| u == own);
            place.map_or(NOWHERE, |place| place as u32)
        }));
        lists.start.push(lists.items.len() as u32);
        self.merged.start.push(self.merged.items.len() as u32);
        self.edges.push(edge);
    }
}

/// The derivative of `√g |∇h|²` by `x_u` and `x_v`, for a function with the derivatives `a`, `b`:
/// that of `|a x_v − b x_u|² / √g`.
fn metric_variation(p: &PointGeometry, a: f64, b: f64) -> [DVec3; 2] {
    let turned = a * p.x_v - b * p.x_u;
    let per_area = 1.0 / p.sqrt_g;
    let density = turned.length_squared() * per_area * per_area;
    [
        -2.0 * b * per_area * turned - density * p.x_v.cross(p.normal),
        2.0 * a * per_area * turned - density * p.normal.cross(p.x_u),
    ]
}

#[cfg(test)]
#[path = "gradient_term_tests.rs"]
mod tests;
