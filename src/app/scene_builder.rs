//! Builds the drawn scene from the model.

mod report;

use std::sync::Arc;

use super::cached::{Cached, SharedKey};
use super::model::Model;
use super::run::Run;
use crate::app::view_state::Task;
use crate::fill::{Features, creases_through, with_islands};
use crate::mesh::{BoundaryLoop, DVec3, LoopId, Mesh, boundary_loops};
use crate::ops::Operation;
use crate::render::{Grid, LineStyle, Marker, Overlay, Polyline, Scene, rim_points};
pub(crate) use report::{ReportOverlays, natural_length};

/// Rims of holes. They also differ in lightness, for users who cannot distinguish the hues.
const HOLE: [f32; 4] = [0.16, 0.71, 0.95, 1.0];
/// Outer boundaries.
const OUTER: [f32; 4] = [0.62, 0.64, 0.67, 1.0];
/// Selected rims.
const SELECTED: [f32; 4] = [1.0, 0.66, 0.10, 1.0];
/// The rim under the cursor.
const HOVER: [f32; 4] = [1.0, 1.0, 0.62, 1.0];

/// Chosen edges, and edges that continue as creases.
const CHOSEN: [f32; 4] = [0.95, 0.35, 0.85, 1.0];

/// Points of self-intersection.
const CROSSING: [f32; 4] = [0.95, 0.15, 0.15, 1.0];
/// Vertices that a refinement interpolates.
const GIVEN: [f32; 4] = [1.0, 0.78, 0.25, 1.0];
/// Maximum number of marked vertices.
const MAX_MARKERS: usize = 3000;

/// Loops with the density of their patches and whether these join islands: what creases depend on.
type Creases = (Vec<LoopId>, f64, bool);

/// Overlays of one view, rebuilt only when their content changes.
#[derive(Default)]
pub(crate) struct OverlayCache {
    rims: Cached<RimKey<bool>, Arc<Overlay>>,
    selection: Cached<RimKey<Vec<LoopId>>, Arc<Overlay>>,
    hover: Cached<RimKey<Vec<LoopId>>, Arc<Overlay>>,
    creases: Cached<RimKey<Creases>, Arc<Overlay>>,
    crossing: Cached<DVec3, Arc<Overlay>>,
    given: Cached<SharedKey<Mesh>, Arc<Overlay>>,
    grid: Cached<Grid, Arc<Overlay>>,
    report: ReportOverlays,
}

/// The key of the drawn rims.
#[derive(PartialEq)]
struct RimKey<T> {
    mesh: SharedKey<Mesh>,
    /// Whether they are drawn on the limit surface.
    limit: bool,
    /// The kind of rims.
    rims: T,
}

/// The scene of the document or of one side of the run.
pub(crate) fn scene(model: &Model, side: usize) -> Scene {
    scene_with(model, side, &mut OverlayCache::default())
}

/// [`scene`] that reuses unchanged overlays.
pub(crate) fn scene_with(model: &Model, side: usize, cache: &mut OverlayCache) -> Scene {
    let display = model.displays[side].latest();
    let mut surfaces = display.map_or_else(Vec::new, |d| d.surfaces.clone());
    surfaces.extend(display.into_iter().flat_map(|d| d.highlights.clone()));
    let mut bounds = display.map_or(model.document.origin.bounds, |d| d.bounds);
    let mut overlays: Vec<Arc<Overlay>> = Vec::new();
    if let Some(grid) = ground_grid(model) {
        bounds = grid.around(bounds);
        let centre = model.centre();
        overlays.push(cache.grid.get(grid, || Arc::new(grid.overlay(centre))));
    }
    overlays.extend(rims(model, cache));
    overlays.extend(given_vertices(model, cache));
    overlays.extend(crossing(model, side, cache));
    overlays.extend(selected_rims(model, cache));
    overlays.extend(hovered_rims(model, cache));
    overlays.extend(continued_edges(model, cache));
    if side == 0 {
        overlays.extend(cache.report.of(model));
        bounds = cache.report.around(bounds);
    }
    Scene {
        centre: model.centre(),
        bounds,
        surfaces,
        overlays,
    }
}

/// The grid on the ground, if it is switched on.
fn ground_grid(model: &Model) -> Option<Grid> {
    let view = &model.view;
    let step = view.bar_length().filter(|_| model.settings.grid)?;
    Grid::new(&model.document.origin.bounds, &view.camera, step)
}

/// All rims except those that the run fills, which would hide the join of the patch.
fn rims(model: &Model, cache: &mut OverlayCache) -> Option<Arc<Overlay>> {
    let running = model.run.is_some();
    model.view.show_rims.then(|| {
        cache.rims.get(rim_key(model, running), || {
            let document = &model.document;
            let shown = |l: &&BoundaryLoop| !(running && document.selection.contains(&l.id));
            rim_lines(
                model,
                &document.mesh,
                document.loops.iter().filter(shown),
                |l| LineLook {
                    color: if l.is_outer_boundary { OUTER } else { HOLE },
                    width_px: 2.0,
                    style: LineStyle::OnTopFaintWhenHidden,
                },
            )
        })
    })
}

fn selected_rims(model: &Model, cache: &mut OverlayCache) -> Option<Arc<Overlay>> {
    let selected: Vec<LoopId> = model.document.selection.iter().copied().collect();
    model.run.is_none().then(|| {
        cache.selection.get(rim_key(model, selected), || {
            let document = &model.document;
            rim_lines(model, &document.mesh, document.selected(), |_| LineLook {
                color: SELECTED,
                width_px: 3.5,
                style: LineStyle::OnTopFaintWhenHidden,
            })
        })
    })
}

fn hovered_rims(model: &Model, cache: &mut OverlayCache) -> Option<Arc<Overlay>> {
    let hover = &model.view.hover;
    if hover.is_empty() {
        return None;
    }
    let mesh = model.looped_mesh();
    let key = RimKey {
        mesh: SharedKey::of(mesh),
        limit: model.draws_limit_of_mesh(),
        rims: hover.clone(),
    };
    Some(cache.hover.get(key, || {
        let hovered = hover.iter().filter_map(|&id| model.shown_loop(id));
        rim_lines(model, mesh, hovered, |_| LineLook {
            color: HOVER,
            width_px: 5.0,
            style: LineStyle::OnTopFaintWhenHidden,
        })
    }))
}

/// The creases along which sharp edges will continue, or do so in the current run, through the holes that
/// are selected, filled or under the cursor.
fn continued_edges(model: &Model, cache: &mut OverlayCache) -> Option<Arc<Overlay>> {
    let controls = &model.document.controls;
    let fills = match &model.run {
        Some(run) => matches!(run.operation, Operation::Fill(_) | Operation::Refill(_)),
        None => matches!(model.view.task, Task::Fill | Task::Repair),
    };
    // holes beside a released bridge are filled smoothly
    let is_bridged = |run: &Run| run.kept.is_some() && matches!(run.operation, Operation::Fill(_));
    if controls.features == Features::Off || !fills || model.run.as_ref().is_some_and(is_bridged) {
        return None;
    }
    let mesh = model.looped_mesh();
    let mut ids: Vec<LoopId> = match &model.run {
        Some(run) => run.loops.iter().map(|l| l.id).collect(),
        None => model.document.selection.iter().copied().collect(),
    };
    let hovered = model.view.hover.iter().filter(|id| !ids.contains(id));
    ids.extend(hovered.copied().collect::<Vec<_>>());
    let density = controls.density;
    let islands = match model.run.as_ref().map(|run| &run.operation) {
        Some(Operation::Fill(spec)) => spec.islands,
        None if model.view.task == Task::Fill => model.view.islands,
        _ => true,
    };
    let key = RimKey {
        mesh: SharedKey::of(mesh),
        limit: false,
        rims: (ids.clone(), density, islands),
    };
    Some(cache.creases.get(key, || {
        let holes = ids.iter().filter_map(|&id| model.shown_loop(id));
        let curves_of = |hole: &BoundaryLoop| {
            let curves = creases_through(mesh, hole, density).into_iter();
            let id = hole.id;
            curves.map(move |curve| (id, curve))
        };
        let mut curves: Vec<(LoopId, Vec<DVec3>)> = holes.flat_map(curves_of).collect();
        if islands && !curves.is_empty() {
            // a hole with islands gets one patch without a crease
            let loops = boundary_loops(mesh);
            let rim_sets = with_islands(mesh, &loops, &ids);
            let is_alone = |id| rim_sets.iter().any(|set| set.len() == 1 && set[0].id == id);
            curves.retain(|&(id, _)| is_alone(id));
        }
        let lines = curves.iter().map(|(_, points)| Polyline {
            points: points.iter().map(|&p| narrow(p - model.centre())).collect(),
            closed: false,
            color: CHOSEN,
            width_px: 4.0,
            style: LineStyle::OnTopFaintWhenHidden,
        });
        Arc::new(Overlay::new(lines.collect(), Vec::new()))
    }))
}

fn rim_key<T>(model: &Model, rims: T) -> RimKey<T> {
    RimKey {
        mesh: SharedKey::of(&model.document.mesh),
        limit: model.draws_limit_of_mesh(),
        rims,
    }
}

/// The look of a line.
struct LineLook {
    color: [f32; 4],
    width_px: f32,
    style: LineStyle,
}

fn rim_lines<'a>(
    model: &Model,
    mesh: &Mesh,
    rims: impl IntoIterator<Item = &'a BoundaryLoop>,
    look: impl Fn(&BoundaryLoop) -> LineLook,
) -> Arc<Overlay> {
    let (centre, limit) = (model.centre(), model.draws_limit_of_mesh());
    let lines = rims.into_iter().map(|l| {
        let look = look(l);
        Polyline {
            points: rim_points(&mesh.topology, &mesh.positions, l, centre, limit),
            closed: true,
            color: look.color,
            width_px: look.width_px,
            style: look.style,
        }
    });
    Arc::new(Overlay::new(lines.collect(), Vec::new()))
}

/// The vertices that a refinement interpolates.
fn given_vertices(model: &Model, cache: &mut OverlayCache) -> Option<Arc<Overlay>> {
    let run = model.run.as_ref()?;
    let given = &run.base;
    let shown = matches!(run.operation, Operation::Refine(_))
        && given.vertex_count() <= MAX_MARKERS
        && model.view.show_rims;
    shown.then(|| {
        cache.given.get(SharedKey::of(given), || {
            let marker = |p: &DVec3| Marker {
                position: narrow(*p - model.centre()),
                color: GIVEN,
                radius_px: 2.5,
                style: LineStyle::Depth,
            };
            markers(given.positions.iter().map(marker))
        })
    })
}

/// The point of self-intersection of a side.
fn crossing(model: &Model, side: usize, cache: &mut OverlayCache) -> Option<Arc<Overlay>> {
    let place = model.run.as_ref()?.sides.get(side)?.shown_crossing()?.place;
    Some(cache.crossing.get(place, || {
        markers([Marker {
            position: narrow(place - model.centre()),
            color: CROSSING,
            radius_px: 7.0,
            style: LineStyle::OnTop,
        }])
    }))
}

fn markers(markers: impl IntoIterator<Item = Marker>) -> Arc<Overlay> {
    Arc::new(Overlay::new(Vec::new(), markers.into_iter().collect()))
}

fn narrow(p: DVec3) -> [f32; 3] {
    p.to_array().map(|x| x as f32)
}
