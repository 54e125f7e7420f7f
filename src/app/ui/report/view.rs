//! Clicks in the view while the report chooses edges or a section.

use crate::app::action::Action;
use crate::app::model::Model;
use crate::app::report::{Across, Cut, Pick, ReportAction};
use crate::mesh::{DVec3, HalfedgeId, TriangleBvh, closest_point_on_segment};
use crate::render::Picker;

/// Maximum distance of the cursor from a picked edge, in points.
const REACH: f64 = 14.0;

/// Handles a click of the report at `at` (from the upper left of a view of `size`). Returns whether
/// the click was used.
pub(crate) fn click(
    model: &Model,
    picker: &Picker,
    size: [f64; 2],
    at: [f64; 2],
    actions: &mut Vec<Action>,
) -> bool {
    match model.view.report.pick {
        Pick::Holes => return false,
        Pick::Edges => {
            if let Some(edge) = edge_at(model, picker, size, at) {
                actions.push(ReportAction::Edge(edge).into());
            }
        }
        Pick::Section(across) => {
            if let Some(point) = point_at(model, picker, size, at) {
                let normal = match across {
                    Across::Axis(k) => DVec3::AXES[k.min(2)],
                    Across::View => model.view.camera.right(),
                };
                let cut = Cut {
                    point: point.to_array(),
                    normal: normal.to_array(),
                };
                actions.push(ReportAction::Cut(cut).into());
                actions.push(ReportAction::Pick(Pick::Holes).into());
            }
        }
    }
    true
}

/// The edge of the document's mesh nearest to the cursor, of the triangle under it.
fn edge_at(model: &Model, picker: &Picker, size: [f64; 2], at: [f64; 2]) -> Option<HalfedgeId> {
    let camera = &model.view.camera;
    let mesh = &model.document.mesh;
    let hit = picker.surface(camera, size, at)?;
    let aspect = size[0] / size[1].max(1.0);
    let on_screen = |p: DVec3| {
        let [x, y] = camera.project(p, aspect)?;
        let (right, down) = (0.5 * (x + 1.0) * size[0], 0.5 * (1.0 - y) * size[1]);
        Some(DVec3::new(right, down, 0.0))
    };
    let cursor = DVec3::new(at[0], at[1], 0.0);
    let mut best: Option<(f64, HalfedgeId)> = None;
    for h in mesh.topology.face_halfedges(hit.face) {
        let ends = [mesh.topology.origin(h), mesh.topology.target(h)];
        let [a, b] = ends.map(|v| on_screen(mesh.position(v)));
        let distance = cursor.distance(closest_point_on_segment(cursor, a?, b?));
        if best.is_none_or(|(least, _)| distance < least) {
            best = Some((distance, h));
        }
    }
    best.filter(|&(distance, _)| distance <= REACH).map(|b| b.1)
}

/// The point of the mesh, or of the patch of the run, under the cursor.
fn point_at(model: &Model, picker: &Picker, size: [f64; 2], at: [f64; 2]) -> Option<DVec3> {
    let camera = &model.view.camera;
    let hit = picker.surface(camera, size, at);
    let ndc = [2.0 * at[0] / size[0] - 1.0, 1.0 - 2.0 * at[1] / size[1]];
    let (origin, direction) = camera.ray(ndc, size[0] / size[1].max(1.0));
    let end = hit.map_or(f64::INFINITY, |h| h.distance);
    let start = camera.first_visible(origin, direction);
    let on_patch = || {
        let run = model.run.as_ref()?;
        let state = run.sides.first()?.state()?;
        let faces = state.patch_faces()?;
        let positions = state.positions(false);
        let triangles: Vec<[u32; 3]> = state
            .topology()
            .triangles()
            .skip(faces.start)
            .take(faces.len())
            .collect();
        let patch = TriangleBvh::new(&positions, &triangles);
        let hit = patch.first_hit(origin, direction, [start, end])?;
        Some(origin + direction * hit.t)
    };
    on_patch().or_else(|| hit.map(|h| h.point))
}

/// The effect of a click, shown at the bottom of the view.
pub(crate) fn hint_words(pick: Pick) -> Option<&'static str> {
    match pick {
        Pick::Holes => None,
        Pick::Edges => Some("Click edges of the mesh to measure across them. Esc ends the mode."),
        Pick::Section(_) => Some("Click a point of the section. Esc ends the mode."),
    }
}
