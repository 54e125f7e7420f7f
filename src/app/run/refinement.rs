//! Starting a refinement.

use std::sync::Arc;

use super::{Run, Side, settings};
use crate::app::document::{Document, RefineWork, Work};
use crate::app::jobs::Wake;
use crate::app::live::{Live, refining_flow};
use crate::app::view_state::Refining;
use crate::fill::{Choice, Controls, TauChoice};
use crate::mesh::face_flags;
use crate::refine::{BoundaryRule, Hold, LiveRefine, Method, RefineOptions};
use crate::solver::FlowOptions;

impl Run {
    /// Starts a refinement, with the other methods asked for beside it.
    ///
    /// # Errors
    /// A message for the person.
    pub fn start_refinement(
        refining: &Refining,
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
        let others = refining.beside.iter().flatten().copied();
        let methods = [refining.method].into_iter().chain(others);
        let sides = methods
            .map(|method| {
                let options = RefineOptions {
                    levels: refining.levels,
                    method,
                    hold: refining.hold,
                    boundary: refining.boundary,
                    region: region.clone(),
                    flow: flow.clone(),
                    ..RefineOptions::new(flow.energy.clone())
                };
                let mesh = Arc::clone(&base);
                let live = LiveRefine::spawn(mesh, options, settings(pace), Arc::clone(wake));
                let live = Live::Refine(Box::new(live.map_err(|error| error.to_string())?));
                let mut side = Side::new(live, method_name(method), controls);
                side.words = refine_words(refining, method, &flow, controls);
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
        words.extend(["--steps".into(), controls.max_steps.to_string()]);
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
