//! Starting a refinement.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::{Run, Side, settings};
use crate::analysis::patch_rims;
use crate::app::chains::{Chain, Places};
use crate::app::document::{CREASE, Document, RefineWork, Work};
use crate::app::jobs::Wake;
use crate::app::live::{Live, refining_flow};
use crate::app::view_state::Refining;
use crate::fill::Controls;
use crate::mesh::face_flags;
use crate::options::{Choice, TauChoice};
use crate::refine::{BoundaryRule, Hold, LiveRefine, Method, RefineOptions};
use crate::solver::FlowOptions;

impl Run {
    /// Starts a refinement, with the other methods asked for beside it; `chains` are the chosen edges.
    ///
    /// # Errors
    /// A message for the person.
    pub fn start_refinement(
        refining: &Refining,
        chains: &[Chain],
        document: &Document,
        controls: &Controls,
        pace: f64,
        wake: &Wake,
    ) -> Result<Self, String> {
        let base = Arc::clone(&document.mesh);
        let flow = refining_flow(controls, &base, refining.own_energy)?;
        let faces = if refining.selected_only {
            Arc::clone(&document.faces)
        } else {
            Arc::default()
        };
        let region = (!faces.is_empty()).then(|| face_flags(&faces, base.face_count()));
        let creases = crease_ends(refining, chains, document);
        let others = refining.beside.iter().flatten().copied();
        let methods = [refining.method].into_iter().chain(others);
        let sides = methods
            .map(|method| {
                let options = RefineOptions {
                    levels: refining.levels,
                    method,
                    hold: refining.hold,
                    boundary: refining.boundary,
                    crease_angle: refining.sharp.then(|| refining.sharp_angle.to_radians()),
                    creases: creases.clone(),
                    region: region.clone(),
                    flow: flow.clone(),
                    ..RefineOptions::new(flow.energy.clone())
                };
                let mesh = Arc::clone(&base);
                let live = LiveRefine::spawn(mesh, options, settings(pace), Arc::clone(wake));
                let live = Live::Refine(Box::new(live.map_err(|error| error.to_string())?));
                let mut side = Side::new(live, method_name(method), controls);
                side.words = refine_words(refining, method, &flow, controls);
                side.words.extend(crease_words(refining, &creases));
                Ok(side)
            })
            .collect::<Result<Vec<Side>, String>>()?;
        Ok(Self {
            work: Work::Refine(RefineWork {
                words: sides.first().map_or_else(Vec::new, |s| s.words.clone()),
                faces,
                changed: false,
            }),
            first_patch_face: base.face_count(),
            base,
            kept: None,
            loops: Vec::new(),
            own_energy: refining.own_energy,
            sides,
            playing: true,
            next_frame: None,
        })
    }
}

/// For headings.
pub fn method_name(method: Method) -> &'static str {
    match method {
        Method::Pde => "PDE",
        Method::Butterfly => "Butterfly",
        Method::Loop => "Loop",
    }
}

/// The arguments of `meniscus refine` for it.
fn refine_words(
    refining: &Refining,
    method: Method,
    flow: &FlowOptions,
    controls: &Controls,
) -> Vec<String> {
    let mut words = vec!["--levels".into(), refining.levels.to_string()];
    if method == Method::Pde {
        words.extend(["--energy".into(), flow.energy.text().to_owned()]);
        for (name, value) in flow.energy.params() {
            words.extend(["--param".into(), format!("{name}={value}")]);
        }
        words.extend(["--tension".into(), flow.tension.to_string()]);
        words.extend(["--mode".into(), controls.mode.name().into()]);
        if let TauChoice::Fixed(tau) = controls.tau {
            words.extend(["--tau".into(), tau.to_string()]);
        }
        words.extend(["--steps".into(), controls.steps.to_string()]);
    } else {
        words.extend(["--method".into(), method_name(method).to_lowercase()]);
    }
    if refining.hold == Hold::Given {
        words.extend(["--hold".into(), "given".into()]);
    }
    if refining.boundary == BoundaryRule::Straight {
        words.extend(["--boundary".into(), "straight".into()]);
    }
    words
}

/// The edges that are to stay sharp beside those above the angle.
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

/// The arguments for them.
fn crease_words(refining: &Refining, creases: &[[u32; 2]]) -> Vec<String> {
    let mut words = Vec::new();
    if refining.sharp {
        words.extend(["--crease-angle".into(), refining.sharp_angle.to_string()]);
    }
    for path in paths(creases) {
        let numbers: Vec<String> = path.iter().map(|v| (v + 1).to_string()).collect();
        words.extend([CREASE.into(), numbers.join(",")]);
    }
    words
}

/// Directed edges joined to paths, each as its vertices.
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
