//! Camera, style and appearance.

use crate::app::action::{Action, Switch};
use crate::app::model::{Effect, Model};
use crate::mesh::LoopId;
use crate::render::{Background, Bounds};

/// Carries out the actions of this kind.
pub fn update(model: &mut Model, action: &Action) {
    match action {
        Action::Camera(camera) => model.view.camera = *camera,
        Action::FitAll => fit(model, &model.bounds()),
        Action::FlyToLoop(id) => {
            if let Some(l) = model.document.loop_of(*id) {
                let reach = crate::mesh::DVec3::splat(1.6 * l.radius);
                let around = Bounds::new(l.centroid - reach, l.centroid + reach);
                face_loop(model, *id);
                fit(model, &around);
            }
        }
        Action::FlyTo(place) => fly_to(model, *place),
        Action::Style(style) => model.view.style = *style,
        Action::Toggle(switch) => toggle(model, *switch),
        Action::Navigation(navigation) => {
            model.settings.navigation = *navigation;
            model.settings.save();
        }
        Action::Dark(dark) => {
            model.settings.dark = *dark;
            model.settings.save();
            model.view.style.background = Background::of_theme(*dark);
            model.effects.push(Effect::Appearance);
        }
        Action::UiScale(scale) => {
            model.settings.ui_scale = scale.clamp(0.5, 3.0);
            model.settings.save();
            model.effects.push(Effect::Appearance);
        }
        _ => {}
    }
}

pub(super) fn fit(model: &mut Model, bounds: &Bounds) {
    let [width, height] = model.view.viewport_px;
    model
        .view
        .camera
        .fit_aspect(bounds, width / height.max(1.0));
}

/// Fits the surroundings of a place into the view.
pub(super) fn fly_to(model: &mut Model, place: crate::mesh::DVec3) {
    let reach = 0.08 * model.document.origin.bounds.radius();
    let reach = crate::mesh::DVec3::splat(reach.max(f64::MIN_POSITIVE));
    fit(model, &Bounds::new(place - reach, place + reach));
}

/// Turns the camera so that it looks onto a loop from outside.
fn face_loop(model: &mut Model, id: LoopId) {
    let l = &model.document.loops[id.index()];
    let mesh = &model.document.mesh;
    // the loop runs as a patch would: its vector area points outwards
    let n = l.vertices.len();
    let at = |j: usize| mesh.position(l.vertices[j % n]) - l.centroid;
    let area: crate::mesh::DVec3 = (0..n).map(|j| at(j).cross(at(j + 1))).sum();
    if let Some(out) = area.try_normalize() {
        look_against(model, out);
    }
}

/// Turns the camera so that it looks against a unit vector.
pub(super) fn look_against(model: &mut Model, out: crate::mesh::DVec3) {
    let camera = &mut model.view.camera;
    let turn = glam::DQuat::from_rotation_arc(-camera.forward(), out);
    camera.orientation = (turn * camera.orientation).normalize();
}

/// The other axis points up from now on.
fn turn_up(model: &mut Model) {
    model.settings.z_up = !model.settings.z_up;
    model.settings.save();
    model.view.camera.z_up = model.settings.z_up;
    model.view.camera.home();
}

fn toggle(model: &mut Model, switch: Switch) {
    let view = &mut model.view;
    let flag = match switch {
        Switch::LimitSurface => &mut view.limit_surface,
        Switch::Original => &mut view.show_original,
        Switch::Rims => &mut view.show_rims,
        Switch::Wireframe => &mut view.style.wireframe,
        Switch::Tint => &mut view.style.tint_patch,
        Switch::ZUp => return turn_up(model),
        Switch::Projection => &mut view.camera.orthographic,
        Switch::Report => &mut view.windows.report,
        Switch::Log => &mut view.windows.log,
        Switch::Help => &mut view.windows.help,
        Switch::Diagnostics => &mut view.windows.diagnostics,
        Switch::Settings => &mut view.windows.settings,
        Switch::Analysis => &mut view.windows.analysis,
    };
    *flag = !*flag;
}
