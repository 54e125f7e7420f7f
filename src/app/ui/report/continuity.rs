//! Continuity of the surface across rims, chosen edges and sharp edges.

use eframe::egui::collapsing_header::CollapsingState;
use eframe::egui::{Grid, RichText, Ui};

use super::place;
use crate::analysis::ChainReport;
use crate::app::action::Action;
use crate::app::model::Model;
use crate::app::report::{Measured, ReportAction};
use crate::app::ui::format::format_number;
use crate::app::ui::widgets::{ClickActions, angle_limit, pick_edges};

/// Number of chains whose details are open by default.
const FEW: usize = 3;

/// All chains, and the choice of further ones.
pub(crate) fn chains_ui(
    ui: &mut Ui,
    model: &Model,
    measured: &Measured,
    actions: &mut Vec<Action>,
) {
    let view = &model.view.report;
    ui.horizontal_wrapped(|ui| {
        let tip = "a click on an edge of the mesh adds its sharp edge, or the edges that go \
                   straight on from it; another click lets it go (Esc ends)";
        pick_edges(ui, view.pick, tip, actions);
        let mut sharp = view.sharp;
        let tip = "measure along all edges with a larger dihedral angle";
        angle_limit(ui, "sharp edges from", tip, &mut sharp);
        if sharp != view.sharp {
            actions.push(ReportAction::Sharp(sharp).into());
        }
    });
    let chains = &measured.analysis.chains;
    if chains.is_empty() {
        ui.weak("there is no patch and no chosen edge to measure across");
    }
    for (i, chain) in chains.iter().enumerate() {
        let chosen = i < measured.chosen;
        let id = ui.scope_id().with(&chain.name);
        let open = chosen || chains.len() <= FEW;
        CollapsingState::load_with_default_open(ui.ctx(), id, open)
            .show_header(ui, |ui| {
                head_ui(ui, chain, chosen.then_some(i), actions);
            })
            .body_unindented(|ui| chain_ui(ui, i, chain, actions));
    }
    if measured.left_out > 0 {
        ui.weak(format!(
            "and {} shorter chains of sharp edges",
            measured.left_out
        ));
    }
}

/// The name of a chain and its maximum jump.
fn head_ui(ui: &mut Ui, chain: &ChainReport, chosen: Option<usize>, actions: &mut Vec<Action>) {
    ui.strong(&chain.name);
    let worst = if chain.is_crease {
        format!("crease, {}°", format_number(chain.normal_angle.max))
    } else {
        format!("smooth, ΔH {}", format_number(chain.curvature_step.max))
    };
    ui.label(format!("{} edges, {worst}", chain.edges));
    if let Some(n) = chosen {
        ui.small_button("Remove")
            .on_click(ReportAction::DropChain(n), actions);
    }
}

fn chain_ui(ui: &mut Ui, i: usize, chain: &ChainReport, actions: &mut Vec<Action>) {
    if chain.edges == 0 {
        ui.weak("its edges do not exist any more");
        return;
    }
    if chain.smooth_by_construction {
        ui.label(format!(
            "length {}; G0 gap 0, G1 angle 0 by construction",
            format_number(chain.length)
        ))
        .on_hover_text("the chain lies inside one limit surface");
    } else {
        ui.label(format!("length {}", format_number(chain.length)));
    }
    let one_sided = "one-sided limits: both sides are separate surfaces";
    let rows = [
        ("G0 gap", one_sided, &chain.gap),
        ("G1 angle °", one_sided, &chain.normal_angle),
        (
            "dihedral °",
            "angle between the triangles of the control mesh; on a smooth surface it is edge \
             length times curvature, not a kink",
            &chain.dihedral,
        ),
        (
            "G2 jump of H",
            "difference of the limit surface's mean curvatures at the edge, 1 / length; it is zero \
             for a Loop surface except at irregular vertices",
            &chain.curvature_jump,
        ),
        (
            "ΔH, faces",
            "difference of the mean curvatures averaged over the faces of the two sides: the \
             visible jump within one row of triangles",
            &chain.curvature_step,
        ),
    ];
    let shown = &rows[if chain.smooth_by_construction { 2 } else { 0 }..];
    Grid::new(("chain", i))
        .striped(true)
        .num_columns(4)
        .spacing([10.0, 2.0])
        .show(ui, |ui| {
            for title in ["", "min", "mean", "max"] {
                ui.label(RichText::new(title).small());
            }
            ui.end_row();
            for (name, tip, s) in shown {
                ui.label(*name).on_hover_text(*tip);
                ui.label(format_number(s.min));
                ui.label(format_number(s.mean));
                place(ui, s.max, s.max_at, actions);
                ui.end_row();
            }
        });
}
