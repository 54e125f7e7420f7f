//! Camera, style and appearance.

use crate::app::action::{Switch, ViewAction};
use crate::app::document::Source;
use crate::app::model::{Effect, Model};
use crate::app::settings::Layout;
use crate::mesh::{DVec3, LoopId};
use crate::render::{Background, Bounds, ViewMode};

pub(crate) fn update(model: &mut Model, action: ViewAction) {
    let style = &mut model.view.style;
    match action {
        ViewAction::Hover(hover) => model.view.hover = hover,
        ViewAction::Camera(camera) => model.view.camera = camera,
        ViewAction::Standard(view) => model.view.camera.standard_view(view),
        ViewAction::FitAll => fit(model, &model.bounds()),
        ViewAction::FlyToLoop(id) => fly_to_loop(model, id),
        ViewAction::Style(other) => {
            *style = other;
            if model.settings.material != other.material {
                model.settings.material = other.material;
                model.settings.save();
            }
        }
        ViewAction::Mode(mode) => choose_mode(model, mode),
        ViewAction::NextMode => choose_mode(model, other_mode(model, 1)),
        ViewAction::PreviousMode => choose_mode(model, other_mode(model, -1)),
        ViewAction::MoreStripes => style.stripes = (style.stripes + 2).min(60),
        ViewAction::FewerStripes => style.stripes = style.stripes.saturating_sub(2).max(2),
        ViewAction::Toggle(switch) => toggle(model, switch),
        ViewAction::Navigation(navigation) => {
            model.settings.navigation = navigation;
            model.settings.save();
        }
        ViewAction::Dark(dark) => {
            model.settings.dark = dark;
            model.settings.save();
            model.view.style.background = Background::of_theme(dark);
            model.effects.push(Effect::Appearance);
        }
        ViewAction::UiScale(scale) => {
            model.settings.ui_scale = scale.clamp(0.5, 3.0);
            model.settings.save();
            model.effects.push(Effect::Appearance);
        }
    }
}

/// The view mode some places after the current one.
fn other_mode(model: &Model, places: isize) -> ViewMode {
    let all: Vec<ViewMode> = model.view_modes().collect();
    let at = all.iter().position(|m| *m == model.view.style.mode);
    let next = (at.unwrap_or(0) + all.len()).saturating_add_signed(places);
    all[next % all.len()]
}

/// Changes the view mode and remembers it, unless it needs data that the next document lacks.
fn choose_mode(model: &mut Model, mode: ViewMode) {
    if !model.view_modes().any(|available| available == mode) {
        return;
    }
    set_mode(model, mode);
    if !matches!(
        mode,
        ViewMode::Color | ViewMode::Deviation | ViewMode::Distance
    ) {
        model.settings.view_mode = Some(mode);
        model.settings.save();
    }
}

/// The view mode of an opened document: its colours if it has colours of vertices or faces or texture images,
/// otherwise the last mode that was chosen. At first, samples are smooth and show isophotes; scans have
/// noise, which isophotes would exaggerate.
pub(super) fn first_mode(model: &mut Model) {
    if model.document.mesh.attributes.has_colors() || model.textures.has_pictures() {
        return set_mode(model, ViewMode::Color);
    }
    let first = if matches!(model.document.origin.source, Source::Sample(_)) {
        ViewMode::Isophotes
    } else {
        ViewMode::Shaded
    };
    set_mode(model, model.settings.view_mode.unwrap_or(first));
}

/// Changes the view mode, which also resets the range.
fn set_mode(model: &mut Model, mode: ViewMode) {
    let style = &mut model.view.style;
    style.range = style.range.filter(|_| style.mode == mode);
    style.mode = mode;
}

pub(super) fn fit(model: &mut Model, bounds: &Bounds) {
    let [width, height] = model.view.viewport_px;
    model
        .view
        .camera
        .fit_aspect(bounds, width / height.max(1.0));
}

/// Fits the surroundings of a point into the view.
pub(super) fn fly_to(model: &mut Model, place: DVec3) {
    let reach = 0.08 * model.document.origin.bounds.radius();
    let reach = DVec3::splat(reach.max(f64::MIN_POSITIVE));
    fit(model, &Bounds::new(place - reach, place + reach));
}

/// Moves the camera in front of a loop and fits its surroundings into the view.
fn fly_to_loop(model: &mut Model, id: LoopId) {
    let Some(l) = model.shown_loop(id) else {
        return;
    };
    let reach = DVec3::splat(1.6 * l.radius);
    let around = Bounds::new(l.centroid - reach, l.centroid + reach);
    let mesh = model.looped_mesh();
    // the loop is oriented like its patch, so its vector area points outwards
    let points: Vec<_> = l.vertices.iter().map(|&v| mesh.position(v)).collect();
    if let Some(out) = crate::mesh::vector_area(&points).try_normalize() {
        look_against(model, out);
    }
    fit(model, &around);
}

/// Rotates the camera to look against a unit vector.
pub(super) fn look_against(model: &mut Model, out: DVec3) {
    let camera = &mut model.view.camera;
    let turn = glam::DQuat::from_rotation_arc(-camera.forward(), out);
    camera.orientation = (turn * camera.orientation).normalize();
}

/// Changes the vertical axis.
fn turn_up(model: &mut Model) {
    model.settings.z_up = !model.settings.z_up;
    model.settings.save();
    model.view.camera.z_up = model.settings.z_up;
    model.view.camera.home();
}

/// Opens or closes a panel.
fn switch_panel(model: &mut Model, switch: impl Fn(&mut Layout)) {
    switch(&mut model.settings.layout);
    model.settings.save();
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
        Switch::Grid => {
            model.settings.grid = !model.settings.grid;
            return model.settings.save();
        }
        Switch::Projection => &mut view.camera.orthographic,
        Switch::Report => &mut view.windows.report,
        Switch::Log => &mut view.windows.log,
        Switch::Help => &mut view.windows.help,
        Switch::Diagnostics => &mut view.windows.diagnostics,
        Switch::Settings => &mut view.windows.settings,
        // its panel may be closed
        Switch::Analysis => {
            let shown = view.windows.analysis && model.settings.layout.right;
            model.settings.layout.right = true;
            view.windows.analysis = !shown;
            return;
        }
        Switch::LeftPanel => return switch_panel(model, |layout| layout.left = !layout.left),
        Switch::RightPanel => return switch_panel(model, |layout| layout.right = !layout.right),
        Switch::Details => {
            let shown = model.settings.layout.shows_details(model.view.window[1]);
            return switch_panel(model, |layout| layout.details = Some(!shown));
        }
    };
    *flag = !*flag;
}
