//! How the surface goes across rims, chosen edges and sharp edges.

use eframe::egui::collapsing_header::CollapsingState;
use eframe::egui::{Grid, RichText, Ui};

use super::place;
use crate::analysis::ChainReport;
use crate::app::action::Action;
use crate::app::model::Model;
use crate::app::report::{Measured, ReportAction};
use crate::app::ui::format::format_number;
use crate::app::ui::widgets::{Asks, angle_limit, pick_edges};

/// Chains that are shown with all their figures at first.
const FEW: usize = 3;

/// All chains, and the choice of more.
pub(crate) fn chains_ui(
    ui: &mut Ui,
    model: &Model,
    measured: &Measured,
    actions: &mut Vec<Action>,
) {
    let view = &model.view.report;
    ui.horizontal_wrapped(|ui| {
        let tip = "a click on an edge of the mesh takes the sharp edge it is part of, or the edges \
                   that go straight on from it; another click lets it go (Esc ends)";
        pick_edges(ui, view.pick, tip, actions);
        let mut sharp = view.sharp;
        let tip = "measure along all edges at which the triangles differ by more";
        angle_limit(ui, "sharp edges from", tip, &mut sharp);
        if sharp != view.sharp {
            actions.push(ReportAction::Sharp(sharp).into());
        }
    });
    let chains = &measured.analysis.chains;
    if chains.is_empty() {
        ui.weak("no patch, no chosen edges: nothing to look across");
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

/// What and where a chain is, and its worst figure.
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
            .asks(ReportAction::DropChain(n), actions);
    }
}

fn chain_ui(ui: &mut Ui, i: usize, chain: &ChainReport, actions: &mut Vec<Action>) {
    if chain.edges == 0 {
        ui.weak("its edges are not there any more");
        return;
    }
    if chain.smooth_by_construction {
        ui.label(format!(
            "length {}; G0 gap 0, G1 angle 0 by construction",
            format_number(chain.length)
        ))
        .on_hover_text("one limit surface runs through, whatever the mesh");
    } else {
        ui.label(format!("length {}", format_number(chain.length)));
    }
    let one_sided = "the limits from either side, each a surface of its own";
    let rows = [
        ("G0 gap", one_sided, &chain.gap),
        ("G1 angle °", one_sided, &chain.normal_angle),
        (
            "dihedral °",
            "angle between the triangles of the control mesh: edge length times curvature on a \
             smooth surface, not a kink",
            &chain.dihedral,
        ),
        (
            "G2 jump of H",
            "difference of the limit surface's mean curvatures at the edge, 1 / length; a Loop \
             surface has none away from irregular vertices",
            &chain.curvature_jump,
        ),
        (
            "ΔH, faces",
            "difference of the mean curvatures averaged over the faces of either side: what the eye \
             sees within a row of triangles",
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
