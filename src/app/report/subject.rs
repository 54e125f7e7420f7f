//! The measured surface: the mesh of the document or a state of the run, with rims and chosen
//! chains.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use crate::analysis::{EdgeChain, patch_rims, sharp_edges};
use crate::app::chains::{Chain, Places};
use crate::app::document::{Document, left_of};
use crate::app::run::{Run, RunState, state_key};
use crate::fill::{Continuity, Controls};
use crate::mesh::{BoundaryLoop, LoopId, Mesh, VertexId, boundary_loops};
use crate::ops::Operation;

/// Maximum number of listed chains of sharp edges. The longest come first.
const MAX_SHARP: usize = 24;

/// A mesh, or a mesh with the patch of a run at one state.
#[derive(Clone)]
pub struct Subject {
    mesh: Arc<Mesh>,
    state: Option<RunState>,
    /// Number of accepted operations.
    changes: usize,
    /// Whether two flows are compared.
    compared: bool,
}

impl Subject {
    /// The shown surface; side A of a comparison.
    pub fn of(document: &Document, run: Option<&Run>) -> Self {
        let state = run.and_then(|r| r.sides.first()?.state());
        let base = run.filter(|_| state.is_some()).map(|r| &r.base);
        Self {
            mesh: Arc::clone(base.unwrap_or(&document.mesh)),
            state,
            changes: document.accepted.len(),
            compared: run.is_some_and(|r| r.sides.len() > 1),
        }
    }

    /// Whether both have the same mesh, regardless of the state of a run.
    pub fn same_but_state(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.mesh, &other.mesh) && self.state.is_some() == other.state.is_some()
    }

    /// Whether both are equal.
    pub fn same(&self, other: &Self) -> bool {
        let same_state = state_key(self.state.as_ref()) == state_key(other.state.as_ref());
        same_state && self.same_but_state(other)
    }

    /// A description.
    pub fn words(&self) -> String {
        match (&self.state, self.changes) {
            (Some(state), _) => {
                let side = if self.compared { "side A, " } else { "" };
                format!("{side}the flow after {} attempts", state.attempt())
            }
            (None, 0) => "the mesh as it was opened".into(),
            (None, 1) => "the mesh after one change".into(),
            (None, n) => format!("the mesh after {n} changes"),
        }
    }

    /// The whole mesh. A refinement has two: with `on_surface` the one whose vertices are on the
    /// limit surface, otherwise the control mesh, which is open along creases.
    pub fn mesh(&self, on_surface: bool) -> Arc<Mesh> {
        let Some(state) = &self.state else {
            return Arc::clone(&self.mesh);
        };
        if on_surface && state.patch_faces().is_none() {
            return Arc::new(state.mesh());
        }
        let topology = (**state.topology()).clone();
        let mut mesh = Mesh::new(state.positions(on_surface), topology);
        mesh.non_orientable.clone_from(&self.mesh.non_orientable);
        Arc::new(mesh)
    }
}

/// Faces that were added or moved, and their continuity with the others.
struct Patch {
    faces: Range<usize>,
    /// The faired faces.
    faired: Arc<Vec<u32>>,
    controls: Controls,
    loops: Loops,
}

/// The filled loops of the mesh. Each has its continuity.
enum Loops {
    /// All boundary loops of the faces before the patch.
    Before,
    /// These loops.
    Known(BTreeMap<VertexId, LoopId>),
}

/// All patches of a [`Subject`].
pub struct Patches(Vec<Patch>);

impl Patches {
    /// The patches of the document and of the run.
    pub fn of(document: &Document, run: Option<&Run>) -> Self {
        let accepted = &document.accepted;
        let run = run.and_then(|run| {
            let side = run.sides.first()?;
            side.state().map(|state| (run, side, state))
        });
        let run_faces = run.as_ref().map(|(.., state)| state.patch_faces());
        if run_faces == Some(None) {
            // a refinement replaces all faces
            return Self(Vec::new());
        }
        let kept = run.as_ref().and_then(|(run, ..)| run.kept.as_deref());
        let renumbers = |o: &Operation| match o {
            Operation::Fill(spec) => !spec.bridges.is_empty(),
            Operation::Refill(_)
            | Operation::Erase(_)
            | Operation::Refine(_)
            | Operation::Clean(_)
            | Operation::Stitch(_) => true,
            _ => false,
        };
        let mut patches: Vec<Patch> = accepted
            .iter()
            .enumerate()
            .map(|(i, one)| {
                let later =
                    accepted[i + 1..].iter().any(|l| renumbers(&l.operation)) || kept.is_some();
                let faces = match kept {
                    Some(kept) => left_of(kept, one.faces.start)..left_of(kept, one.faces.end),
                    None => one.faces.clone(),
                };
                let faired = match &one.operation {
                    Operation::Fair(spec) if !later => Arc::clone(&spec.faces),
                    _ => Arc::default(),
                };
                Patch {
                    faces,
                    faired,
                    controls: one.operation.last_controls(),
                    // erasing faces has changed the loop numbers
                    loops: if later {
                        Loops::Known(BTreeMap::new())
                    } else {
                        Loops::Before
                    },
                }
            })
            .collect();
        if let (Some((run, side, _)), Some(Some(faces))) = (run, run_faces) {
            let numbered = |l: &BoundaryLoop| {
                let id = l.id;
                l.vertices.clone().into_iter().map(move |v| (v, id))
            };
            patches.push(Patch {
                faces,
                faired: run.faired(),
                controls: side.controls.clone(),
                loops: Loops::Known(run.loops.iter().flat_map(numbered).collect()),
            });
        }
        Self(patches)
    }

    /// The rims of all patches in the whole `mesh`. G0 rims are creases.
    fn rims(&self, mesh: &Mesh) -> Vec<EdgeChain> {
        let mut rims = Vec::new();
        let made = |p: &&Patch| !p.faces.is_empty() || !p.faired.is_empty();
        for patch in self.0.iter().filter(made) {
            let is_patch: Vec<bool> = (0..mesh.face_count())
                .map(|f| {
                    patch.faces.contains(&f) || patch.faired.binary_search(&(f as u32)).is_ok()
                })
                .collect();
            let numbers = patch.numbers(mesh);
            for rim in patch_rims(mesh, &is_patch, false) {
                let at = rim.edges.first().map(|&h| mesh.topology.origin(h));
                let continuity = match at.and_then(|v| numbers.get(&v)) {
                    Some(&number) => patch.controls.continuity_at(number),
                    None => patch.controls.continuity,
                };
                rims.push(EdgeChain {
                    name: format!("rim {}", rims.len() + 1),
                    is_crease: patch.faired.is_empty() && continuity == Continuity::G0,
                    ..rim
                });
            }
        }
        rims
    }

    /// Chosen chains as far as their edges exist, rims, the sharp edges above an angle in degrees,
    /// and the number of omitted chains.
    pub fn chains(&self, mesh: &Mesh, chosen: &[Chain], sharp: Option<f64>) -> Chains {
        let places = Places::new(mesh, chosen);
        let mut all: Vec<EdgeChain> = chosen
            .iter()
            .enumerate()
            .map(|(n, chain)| {
                let edges = chain.edges.iter();
                EdgeChain {
                    name: format!("edges {}", n + 1),
                    is_crease: chain.is_crease,
                    edges: edges.filter_map(|e| places.edge(mesh, e)).collect(),
                }
            })
            .collect();
        let rims = self.rims(mesh);
        let rim_count = rims.len();
        all.extend(rims);
        let mut sharp = sharp.map_or_else(Vec::new, |angle| sharp_edges(mesh, angle.to_radians()));
        sharp.sort_by_key(|c| std::cmp::Reverse(c.edges.len()));
        let left_out = sharp.len().saturating_sub(MAX_SHARP);
        sharp.truncate(MAX_SHARP);
        all.extend(sharp.into_iter().enumerate().map(|(n, c)| EdgeChain {
            name: format!("sharp edges {}", n + 1),
            ..c
        }));
        Chains {
            all,
            chosen: chosen.len(),
            rims: rim_count,
            left_out,
        }
    }
}

/// All chains to measure.
pub struct Chains {
    /// Chosen chains, rims, sharp edges, in this order.
    pub all: Vec<EdgeChain>,
    /// Number of chosen chains.
    pub chosen: usize,
    /// Number of rims.
    pub rims: usize,
    /// Number of omitted chains of sharp edges.
    pub left_out: usize,
}

impl Patch {
    /// Loops as lists of vertices; empty if all have the same continuity.
    fn numbers(&self, mesh: &Mesh) -> BTreeMap<VertexId, LoopId> {
        if self.controls.loop_continuity.is_empty() {
            return BTreeMap::new();
        }
        match &self.loops {
            Loops::Known(numbers) => numbers.clone(),
            Loops::Before => {
                let old = mesh.topology.triangles().take(self.faces.start);
                let old: Vec<[u32; 3]> = old.collect();
                let before = Mesh::from_triangles(mesh.positions.clone(), &old);
                let loops = before.map_or_else(|_| Vec::new(), |before| boundary_loops(&before));
                let numbered = |l: BoundaryLoop| {
                    let id = l.id;
                    l.vertices.into_iter().map(move |v| (v, id))
                };
                loops.into_iter().flat_map(numbered).collect()
            }
        }
    }
}
