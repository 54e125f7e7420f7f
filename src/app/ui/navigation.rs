//! Mouse and trackpad control of the camera.

use eframe::egui::{Modifiers, PointerButton, Pos2, Rect, Response};

use crate::app::view_state::Navigation;
use crate::mesh::DVec3;
use crate::render::Camera;

/// A press that moves farther than this, in points, is a drag.
pub(crate) const CLICK: f32 = 5.0;
/// Rotation in radians per point of movement.
const TURN: f64 = 0.008;

/// The effect of a drag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Motion {
    /// Rotates around the pivot.
    Orbit,
    /// Moves parallel to the picture.
    Pan,
    /// Zooms.
    Zoom,
}

/// A pressed button.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Drag {
    /// The point where the primary button was pressed, and the movement since then.
    pub(crate) press: Option<(Pos2, f32)>,
}

/// The effect of a button in a preset.
pub(crate) fn motion(
    navigation: Navigation,
    button: PointerButton,
    keys: Modifiers,
) -> Option<Motion> {
    use Motion::{Orbit, Pan, Zoom};
    use PointerButton::{Middle, Primary, Secondary};
    match (navigation, button) {
        (Navigation::MeshLab, Primary) if keys.command => Some(Pan),
        (Navigation::MeshLab, Primary) if keys.shift => Some(Zoom),
        (Navigation::MeshLab | Navigation::Trackpad, Primary) => {
            Some(if keys.command || keys.shift {
                Pan
            } else {
                Orbit
            })
        }
        (Navigation::MeshLab | Navigation::Trackpad, Middle | Secondary)
        | (Navigation::Cad, Secondary) => Some(Pan),
        (Navigation::Blender, Middle) if keys.shift => Some(Pan),
        (Navigation::Blender | Navigation::Cad, Middle) if keys.command => Some(match navigation {
            Navigation::Blender => Zoom,
            _ => Pan,
        }),
        (Navigation::Cad, Middle) if keys.shift => Some(Zoom),
        (Navigation::Blender | Navigation::Cad, Middle) => Some(Orbit),
        _ => None,
    }
}

/// Moves the camera according to the input over the viewport. `tool` is whether an active tool uses
/// the primary button; with a tool the secondary button rotates. A zoom leads towards the point of the surface
/// that `under` finds, no nearer than `nearest`. Returns whether the camera moved.
pub(crate) fn navigate(
    camera: &mut Camera,
    navigation: Navigation,
    response: &Response,
    rect: Rect,
    tool: Option<bool>,
    under: impl Fn(&Camera, Pos2) -> Option<DVec3>,
    nearest: f64,
) -> bool {
    let before = *camera;
    let keys = response.ctx.input(|i| i.modifiers);
    let aspect = f64::from(rect.width() / rect.height().max(1.0));
    let ndc = |p: Pos2| {
        [
            f64::from(2.0 * (p.x - rect.left()) / rect.width() - 1.0),
            f64::from(1.0 - 2.0 * (p.y - rect.top()) / rect.height()),
        ]
    };
    let zoom = |camera: &mut Camera, factor: f64, at: Pos2| {
        let point = under(camera, at);
        camera.zoom_towards(point, factor, nearest, ndc(at), aspect);
    };
    for button in [
        PointerButton::Primary,
        PointerButton::Middle,
        PointerButton::Secondary,
    ] {
        if !response.dragged_by(button) {
            continue;
        }
        let moved = response.drag_delta();
        let (dx, dy) = (f64::from(moved.x), f64::from(moved.y));
        let motion = match (tool, button) {
            (Some(true), PointerButton::Primary) => None,
            (Some(_), PointerButton::Primary | PointerButton::Secondary) => Some(Motion::Orbit),
            _ => motion(navigation, button, keys),
        };
        match motion {
            Some(Motion::Orbit) => camera.orbit(dx * TURN, dy * TURN, true),
            Some(Motion::Pan) => camera.pan(dx, dy, f64::from(rect.height())),
            Some(Motion::Zoom) => zoom(camera, (-dy * 0.01).exp(), rect.center()),
            None => {}
        }
    }
    if let Some(at) = response.hover_pos() {
        let (scroll, pinch) = response
            .ctx
            .input(|i| (i.smooth_scroll_delta(), i.zoom_delta()));
        if (pinch - 1.0).abs() > 1e-6 {
            zoom(camera, f64::from(pinch), at);
        } else if navigation == Navigation::Trackpad {
            let (dx, dy) = (f64::from(scroll.x), f64::from(scroll.y));
            if keys.shift {
                camera.pan(dx, dy, f64::from(rect.height()));
            } else if dx != 0.0 || dy != 0.0 {
                camera.orbit(dx * TURN, dy * TURN, true);
            }
        } else if scroll.y != 0.0 {
            zoom(camera, (f64::from(scroll.y) * 0.004).exp(), at);
        }
    }
    *camera != before
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_turns_and_moves() {
        let sets = [Modifiers::NONE, Modifiers::SHIFT, Modifiers::COMMAND];
        let buttons = [
            PointerButton::Primary,
            PointerButton::Middle,
            PointerButton::Secondary,
        ];
        for navigation in Navigation::ALL {
            for wanted in [Motion::Orbit, Motion::Pan] {
                let found = buttons.iter().any(|&b| {
                    sets.iter()
                        .any(|&k| motion(navigation, b, k) == Some(wanted))
                });
                assert!(found, "{navigation:?} has no {wanted:?}");
            }
        }
        // without a middle button
        assert_eq!(
            motion(
                Navigation::Trackpad,
                PointerButton::Primary,
                Modifiers::NONE
            ),
            Some(Motion::Orbit)
        );
        // Blender uses the left button only for picking
        assert_eq!(
            motion(Navigation::Blender, PointerButton::Primary, Modifiers::NONE),
            None
        );
    }
}
