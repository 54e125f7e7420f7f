//! Starting a refinement.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::divergence::Limits;
use super::refine_handle::with_controls;
use super::{Run, RunVariant, settings};
use crate::analysis::patch_rims;
use crate::app::chains::{Chain, Places};
use crate::app::document::Document;
use crate::app::jobs::Wake;
use crate::app::view_state::Refining;
use crate::fill::Controls;
use crate::mesh::face_flags;
use crate::ops::{Operation, RefineSpec};
use crate::refine::{LiveRefine, Method, RefineControls};
use crate::runner::Schedule;

impl Run {
    /// Starts a refinement and those of the methods to compare with. `chains` are the chosen edges.
    ///
    /// # Errors
    /// A message for the user.
    pub fn start_refinement(
        refining: &Refining,
        chains: &[Chain],
        document: &Document,
        controls: &Controls,
        pace: f64,
        wake: &Wake,
    ) -> Result<Self, String> {
        let base = Arc::clone(&document.mesh);
        let faces = if refining.selected_only {
            Arc::clone(&document.faces)
        } else {
            Arc::default()
        };
        let region = (!faces.is_empty()).then(|| face_flags(&faces, base.face_count()));
        let creases = crease_ends(refining, chains, document);
        let others = refining.beside.iter().flatten().copied();
        let methods = [refining.controls.method].into_iter().chain(others);
        let sides = methods
            .map(|method| {
                let own = RefineControls {
                    method,
                    ..with_controls(&refining.controls, controls)
                };
                let operation = Operation::Refine(RefineSpec {
                    controls: own.clone(),
                    creases: paths(&creases),
                    faces: Arc::clone(&faces),
                    schedule: Schedule::default(),
                });
                let (mesh, wake) = (Arc::clone(&base), Arc::clone(wake));
                let (creases, region) = (creases.clone(), region.clone());
                let run = LiveRefine::spawn(mesh, own, creases, region, settings(pace), wake);
                let run = Box::new(run.map_err(|error| error.to_string())?);
                let name = method_name(method);
                Ok(RunVariant::new(run, name, operation, controls.clone()))
            })
            .collect::<Result<Vec<RunVariant>, String>>()?;
        Ok(Self {
            operation: sides[0].operation.clone(),
            limits: Limits::new(&base, &[]),
            first_patch_face: base.face_count(),
            base,
            kept: None,
            loops: Vec::new(),
            sides,
            playing: true,
            stopped: false,
            accepting: None,
            summarised: false,
            next_frame: None,
        })
    }
}

/// The name of a method in headings.
pub fn method_name(method: Method) -> &'static str {
    match method {
        Method::Pde => "PDE",
        Method::Butterfly => "Butterfly",
        Method::Loop => "Loop",
    }
}

/// The sharp edges in addition to those above the angle.
fn crease_ends(refining: &Refining, chains: &[Chain], document: &Document) -> Vec<[u32; 2]> {
    let mesh = &document.mesh;
    let ends = |h| [mesh.topology.origin(h).0, mesh.topology.target(h).0];
    let mut edges = Vec::new();
    if refining.chosen_edges {
        let places = Places::new(mesh, chains);
        let chosen = chains.iter().flat_map(|c| &c.edges);
        edges.extend(chosen.filter_map(|e| places.edge(mesh, e)).map(ends));
    }
    if refining.selection_rim {
        let flags = face_flags(&document.faces, mesh.face_count());
        let rims = patch_rims(mesh, &flags, true);
        edges.extend(rims.iter().flat_map(|rim| &rim.edges).map(|&h| ends(h)));
    }
    edges
}

/// Joins directed edges to paths of vertices.
fn paths(edges: &[[u32; 2]]) -> Vec<Vec<u32>> {
    let mut onwards: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for &[a, b] in edges.iter().rev() {
        onwards.entry(a).or_default().push(b);
    }
    let mut paths = Vec::new();
    for &[first, _] in edges {
        let mut path = vec![first];
        let mut at = first;
        while let Some(next) = onwards.get_mut(&at).and_then(Vec::pop) {
            path.push(next);
            at = next;
        }
        if path.len() > 1 {
            paths.push(path);
        }
    }
    paths
}

#[cfg(test)]
mod tests {
    use super::paths;

    #[test]
    fn edges_join_to_paths() {
        let edges = [[1, 2], [5, 6], [2, 3], [3, 1], [6, 7], [9, 5]];
        assert_eq!(paths(&edges), [vec![1, 2, 3, 1], vec![5, 6, 7], vec![9, 5]]);
        assert!(paths(&[]).is_empty());
    }
}
