//! From the model to what is drawn.

use std::sync::Arc;

use super::document::Work;
use super::model::Model;
use super::report::ReportOverlays;
use crate::mesh::{BoundaryLoop, DVec3, LoopId, Mesh};
use crate::render::{LineStyle, Marker, Overlay, Polyline, Scene, rim_points};

/// Rim of a hole; told from the others by lightness too, for eyes that see no hues.
const HOLE: [f32; 4] = [0.16, 0.71, 0.95, 1.0];
/// Rim that looks like the border of an open surface.
const OUTER: [f32; 4] = [0.62, 0.64, 0.67, 1.0];
/// Selected.
const SELECTED: [f32; 4] = [1.0, 0.66, 0.10, 1.0];
/// Under the cursor.
const HOVER: [f32; 4] = [1.0, 1.0, 0.62, 1.0];

/// Where the surface passes through itself.
const CROSSING: [f32; 4] = [0.95, 0.15, 0.15, 1.0];
/// A vertex that a refinement passes.
const GIVEN: [f32; 4] = [1.0, 0.78, 0.25, 1.0];
/// Such vertices are marked up to this many.
const MOST_MARKERS: usize = 3000;

/// What overlays were made of, to make them again only when that changes.
#[derive(Default)]
pub struct OverlayCache {
    limit: bool,
    rims: Option<(Arc<Mesh>, bool, Arc<Overlay>)>,
    selection: Option<(Arc<Mesh>, Vec<LoopId>, Arc<Overlay>)>,
    hover: Option<(Arc<Mesh>, LoopId, Arc<Overlay>)>,
    report: ReportOverlays,
    crossing: Option<(DVec3, Arc<Overlay>)>,
    given: Option<(Arc<Mesh>, Arc<Overlay>)>,
}

/// The scene of the document or of one side of the run.
pub fn scene(model: &Model, side: usize) -> Scene {
    scene_with(model, side, &mut OverlayCache::default())
}

/// [`scene`], keeping overlays that have not changed.
pub fn scene_with(model: &Model, side: usize, cache: &mut OverlayCache) -> Scene {
    let display = model.displays[side].latest();
    let mut surfaces = display.map_or_else(Vec::new, |d| d.surfaces.clone());
    surfaces.extend(display.into_iter().flat_map(|d| d.highlights.clone()));
    let mut bounds = display.map_or(model.document.origin.bounds, |d| d.bounds);
    let mut overlays = Vec::new();
    let document = &model.document;
    let mesh = &document.mesh;
    let centre = model.centre();
    let limit = model.draws_limit_of_mesh();
    if cache.limit != limit {
        *cache = OverlayCache {
            limit,
            ..OverlayCache::default()
        };
    }
    let line = |l: &BoundaryLoop, color, width_px, style| Polyline {
        points: rim_points(&mesh.topology, &mesh.positions, l, centre, limit),
        closed: true,
        color,
        width_px,
        style,
    };
    let running = model.run.is_some();
    if model.view.show_rims {
        let fits =
            |(m, r, _): &(Arc<Mesh>, bool, Arc<Overlay>)| Arc::ptr_eq(m, mesh) && *r == running;
        if !cache.rims.as_ref().is_some_and(fits) {
            let lines = document
                .loops
                .iter()
                // the rims of a fill under way would hide how it joins
                .filter(|l| !(running && document.selection.contains(&l.id)))
                .map(|l| {
                    let color = if l.outer_rim { OUTER } else { HOLE };
                    line(l, color, 2.0, LineStyle::OnTopFaintWhenHidden)
                })
                .collect();
            let overlay = Arc::new(Overlay::new(lines, Vec::new()));
            cache.rims = Some((Arc::clone(mesh), running, overlay));
        }
        overlays.extend(cache.rims.as_ref().map(|(_, _, o)| Arc::clone(o)));
    }
    if let Some(run) = model
        .run
        .as_ref()
        .filter(|r| matches!(r.work, Work::Refine(_)))
    {
        let given = &run.base;
        if given.vertex_count() <= MOST_MARKERS && model.view.show_rims {
            if !cache
                .given
                .as_ref()
                .is_some_and(|(m, _)| Arc::ptr_eq(m, given))
            {
                let marker = |p: &DVec3| Marker {
                    position: (*p - centre).to_array().map(|x| x as f32),
                    color: GIVEN,
                    radius_px: 2.5,
                    style: LineStyle::Depth,
                };
                let markers = given.positions.iter().map(marker).collect();
                let overlay = Arc::new(Overlay::new(Vec::new(), markers));
                cache.given = Some((Arc::clone(given), overlay));
            }
            overlays.extend(cache.given.as_ref().map(|(_, o)| Arc::clone(o)));
        }
    }
    let crossing = model.run.as_ref().and_then(|r| r.sides.get(side)?.crossing);
    if let Some(place) = crossing {
        if cache.crossing.as_ref().is_none_or(|(p, _)| *p != place) {
            let marker = Marker {
                position: (place - centre).to_array().map(|x| x as f32),
                color: CROSSING,
                radius_px: 7.0,
                style: LineStyle::OnTop,
            };
            cache.crossing = Some((place, Arc::new(Overlay::new(Vec::new(), vec![marker]))));
        }
        overlays.extend(cache.crossing.as_ref().map(|(_, o)| Arc::clone(o)));
    }
    if !running {
        let selected: Vec<LoopId> = document.selection.iter().copied().collect();
        let fits = |(m, s, _): &(Arc<Mesh>, Vec<LoopId>, Arc<Overlay>)| {
            Arc::ptr_eq(m, mesh) && *s == selected
        };
        if !cache.selection.as_ref().is_some_and(fits) {
            let lines = document
                .selected()
                .into_iter()
                .map(|l| line(l, SELECTED, 3.5, LineStyle::OnTop))
                .collect();
            let overlay = Arc::new(Overlay::new(lines, Vec::new()));
            cache.selection = Some((Arc::clone(mesh), selected, overlay));
        }
        overlays.extend(cache.selection.as_ref().map(|(_, _, o)| Arc::clone(o)));
    }
    let hovered = model.view.hover.and_then(|id| document.loop_of(id));
    if let Some(l) = hovered {
        let fits =
            |(m, id, _): &(Arc<Mesh>, LoopId, Arc<Overlay>)| Arc::ptr_eq(m, mesh) && *id == l.id;
        if !cache.hover.as_ref().is_some_and(fits) {
            let lines = vec![line(l, HOVER, 5.0, LineStyle::OnTop)];
            let overlay = Arc::new(Overlay::new(lines, Vec::new()));
            cache.hover = Some((Arc::clone(mesh), l.id, overlay));
        }
        overlays.extend(cache.hover.as_ref().map(|(_, _, o)| Arc::clone(o)));
    }
    if side == 0 {
        overlays.extend(cache.report.of(model));
        bounds = cache.report.around(bounds);
    }
    Scene {
        centre,
        bounds,
        surfaces,
        overlays,
    }
}
