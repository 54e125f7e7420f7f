//! What is measured: the document's mesh or a state of the run, with its rims and chosen chains.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use super::view::Chain;
use crate::analysis::{EdgeChain, patch_rims, sharp_edges};
use crate::app::document::AcceptedFill;
use crate::app::model::Model;
use crate::fill::{Choice, Continuity, Controls, State};
use crate::mesh::{HalfedgeId, Mesh, Topology, VertexId, boundary_loops};

/// Sharp edges listed at most, the longest chains first.
const MOST_SHARP: usize = 24;

/// A mesh, or a mesh and the patch of a run at a moment.
#[derive(Clone)]
pub struct Subject {
    mesh: Arc<Mesh>,
    state: Option<Arc<State>>,
    fills: Vec<Arc<AcceptedFill>>,
    /// Controls of the run that are in force.
    controls: Option<Controls>,
}

impl Subject {
    /// What the window shows (of a comparison, side A).
    pub fn of(model: &Model) -> Self {
        let side = model.run.as_ref().and_then(|r| r.sides.first());
        let state = side.and_then(crate::app::run::Side::state);
        Self {
            mesh: Arc::clone(&model.document.mesh),
            controls: side.filter(|_| state.is_some()).map(|s| s.controls.clone()),
            state,
            fills: model.document.fills.clone(),
        }
    }

    /// Whether both are of the same mesh, at the same or at different moments of a run.
    pub fn same_but_state(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.mesh, &other.mesh) && self.state.is_some() == other.state.is_some()
    }

    /// Whether both are the same.
    pub fn same(&self, other: &Self) -> bool {
        let states = match (&self.state, &other.state) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (None, None) => true,
            _ => false,
        };
        states && self.same_but_state(other)
    }

    /// What it is, in words.
    pub fn words(&self) -> String {
        match &self.state {
            Some(state) => format!("the flow after {} attempts", state.attempt),
            None if self.fills.is_empty() => "the mesh as it was opened".into(),
            None if self.fills.len() == 1 => "the mesh with an accepted fill".into(),
            None => format!("the mesh with {} accepted fills", self.fills.len()),
        }
    }

    /// The whole mesh.
    pub fn mesh(&self) -> Arc<Mesh> {
        let Some(state) = &self.state else {
            return Arc::clone(&self.mesh);
        };
        let mut positions = self.mesh.positions.clone();
        positions.extend(state.new_positions());
        let mut mesh = Mesh::new(positions, (*state.topology).clone());
        mesh.one_sided.clone_from(&self.mesh.one_sided);
        Arc::new(mesh)
    }

    /// The rims of all patches in the whole `mesh`, those of G0 as creases.
    pub fn rims(&self, mesh: &Mesh) -> Vec<EdgeChain> {
        let mut rims = Vec::new();
        let mut add = |faces: Range<usize>, continuity: &dyn Fn(VertexId) -> Continuity| {
            let is_patch: Vec<bool> = (0..mesh.face_count()).map(|f| faces.contains(&f)).collect();
            for rim in patch_rims(mesh, &is_patch, false) {
                let at = rim.edges.first().map(|&h| mesh.topology.origin(h));
                let is_crease = at.is_some_and(|v| continuity(v) == Continuity::G0);
                rims.push(EdgeChain {
                    name: format!("rim {}", rims.len() + 1),
                    is_crease,
                    ..rim
                });
            }
        };
        for fill in &self.fills {
            let controls = last_continuity(fill);
            let numbers = Numbers::new(mesh, &controls, fill.faces.start);
            add(fill.faces.clone(), &|v| numbers.continuity(&controls, v));
        }
        if let (Some(state), Some(controls)) = (&self.state, &self.controls) {
            let numbers = Numbers::new(&self.mesh, controls, self.mesh.face_count());
            add(state.patch_faces(), &|v| numbers.continuity(controls, v));
        }
        rims
    }

    /// Rims, chosen chains as far as their edges are there, and the sharp edges above an angle in
    /// degrees, with how many were left out.
    pub fn chains(&self, mesh: &Mesh, chosen: &[Chain], sharp: Option<f64>) -> Chains {
        let rims = self.rims(mesh);
        let mut all = rims;
        let rims = all.len();
        for (n, chain) in chosen.iter().enumerate() {
            let edges = chain.edges.iter();
            let edges: Vec<HalfedgeId> = edges
                .filter_map(|&[a, b]| halfedge(&mesh.topology, a, b))
                .collect();
            all.push(EdgeChain {
                name: format!("edges {}", n + 1),
                is_crease: chain.is_crease,
                edges,
            });
        }
        let mut sharp = sharp.map_or_else(Vec::new, |angle| sharp_edges(mesh, angle.to_radians()));
        sharp.sort_by_key(|c| std::cmp::Reverse(c.edges.len()));
        let left_out = sharp.len().saturating_sub(MOST_SHARP);
        sharp.truncate(MOST_SHARP);
        all.extend(sharp.into_iter().enumerate().map(|(n, c)| EdgeChain {
            name: format!("sharp edges {}", n + 1),
            ..c
        }));
        Chains {
            all,
            rims,
            chosen: chosen.len(),
            left_out,
        }
    }
}

/// All chains to be measured: rims, chosen ones, sharp edges.
pub struct Chains {
    /// In this order.
    pub all: Vec<EdgeChain>,
    /// How many are rims.
    pub rims: usize,
    /// How many were chosen.
    pub chosen: usize,
    /// Chains of sharp edges that are not among them.
    pub left_out: usize,
}

/// The half-edge between two vertices.
fn halfedge(topology: &Topology, a: u32, b: u32) -> Option<HalfedgeId> {
    let inside = |v: u32| (v as usize) < topology.vertex_count();
    if !(inside(a) && inside(b)) {
        return None;
    }
    let mut out = topology.outgoing(VertexId(a));
    out.find(|&h| topology.target(h) == VertexId(b))
}

/// The controls of a fill with the continuity it ended with.
fn last_continuity(fill: &AcceptedFill) -> Controls {
    let mut controls = fill.controls.clone();
    for row in &fill.schedule.rows {
        if row.control == "continuity" {
            controls.continuity = Continuity::named(&row.value).unwrap_or(controls.continuity);
        } else if row.control == "loop-continuity"
            && let Some((number, value)) = row.value.split_once('=')
            && let Ok(number) = number.trim().parse()
        {
            match Continuity::named(value.trim()) {
                Some(own) => controls.loop_continuity.insert(number, own),
                None => controls.loop_continuity.remove(&number),
            };
        }
    }
    controls
}

/// The loops of the mesh before a fill, by their vertices; empty where all loops are alike.
struct Numbers(BTreeMap<VertexId, usize>);

impl Numbers {
    /// Of the first `faces` faces.
    fn new(mesh: &Mesh, controls: &Controls, faces: usize) -> Self {
        if controls.loop_continuity.is_empty() {
            return Self(BTreeMap::new());
        }
        let triangles: Vec<[u32; 3]> = mesh.topology.triangles().take(faces).collect();
        let before = Topology::from_triangles(mesh.vertex_count(), &triangles).ok();
        let loops = before.map_or_else(Vec::new, |topology| {
            boundary_loops(&Mesh::new(mesh.positions.clone(), topology))
        });
        let numbered = |l: &crate::mesh::BoundaryLoop| {
            let number = l.number;
            l.vertices.clone().into_iter().map(move |v| (v, number))
        };
        Self(loops.iter().flat_map(numbered).collect())
    }

    fn continuity(&self, controls: &Controls, v: VertexId) -> Continuity {
        match self.0.get(&v) {
            Some(&number) => controls.continuity_at(number),
            None => controls.continuity,
        }
    }
}
