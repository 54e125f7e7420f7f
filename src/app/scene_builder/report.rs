//! Overlays of the report: chosen edges, the section with its comb, and a marked point.

use std::sync::Arc;

use super::{CHOSEN, markers, narrow};
use crate::analysis::{Section, SectionCurve, SectionPoint};
use crate::app::cached::{Cached, SharedKey};
use crate::app::chains::{Chain, Places};
use crate::app::model::Model;
use crate::app::report::Comb;
use crate::app::view_state::Task;
use crate::mesh::{DVec3, Mesh, VertexId};
use crate::render::{Bounds, LineStyle, Marker, Overlay, Polyline};
use crate::subdivision::limit_position;

/// The section.
const SECTION: [f32; 4] = [1.0, 1.0, 1.0, 1.0];
/// Teeth at negative and at positive curvature.
const CONVEX: [f32; 4] = [0.25, 0.75, 0.95, 1.0];
const CONCAVE: [f32; 4] = [1.0, 0.55, 0.25, 1.0];
/// The curve through the ends of the teeth.
const ENDS: [f32; 4] = [0.98, 0.85, 0.35, 1.0];
/// The marked point.
const MARK: [f32; 4] = [1.0, 0.25, 0.2, 1.0];

/// Length of the adapted comb at the 95 % quantile of the section's curvature, as a fraction of the
/// model's radius.
const NATURAL: f64 = 0.25;
/// Maximum number of teeth. A denser comb would look like a filled area.
const MAX_TEETH: usize = 6000;

/// Overlays of the report, rebuilt only when their content changes.
#[derive(Default)]
pub(crate) struct ReportOverlays {
    chains: Cached<ChainKey, Arc<Overlay>>,
    comb: Cached<CombKey, DrawnComb>,
    mark: Cached<DVec3, Arc<Overlay>>,
    /// Bounding box of the last comb.
    reach: Option<Bounds>,
}

#[derive(PartialEq)]
struct ChainKey {
    mesh: SharedKey<Mesh>,
    limit: bool,
    chains: Vec<Chain>,
}

#[derive(PartialEq)]
struct CombKey {
    section: SharedKey<Section>,
    comb: Comb,
    centre: DVec3,
}

#[derive(Clone)]
struct DrawnComb {
    overlay: Arc<Overlay>,
    reach: Option<Bounds>,
}

impl ReportOverlays {
    /// The current overlays.
    pub(crate) fn of(&mut self, model: &Model) -> Vec<Arc<Overlay>> {
        let mut all = Vec::new();
        self.reach = None;
        let view = &model.view.report;
        let shown = model.view.windows.analysis;
        let refining = model.view.task == Task::Refine && model.view.refining.chosen_edges;
        if (shown || refining) && !view.chains.is_empty() {
            let key = ChainKey {
                mesh: SharedKey::of(&model.document.mesh),
                limit: model.draws_limit_of_mesh(),
                chains: view.chains.clone(),
            };
            all.push(self.chains.get(key, || Arc::new(chosen_edges(model))));
        }
        if let (Some(cut), Some(_)) = (&model.report.cut, view.cut) {
            let centre = model.centre();
            let key = CombKey {
                section: SharedKey::of(&cut.section),
                comb: view.comb,
                centre,
            };
            let drawn = self.comb.get(key, || {
                let radius = model.document.origin.bounds.radius();
                let overlay = comb_overlay(&cut.section, &view.comb, radius, centre);
                let points = overlay.lines.iter().flat_map(|l| &l.points);
                let points = points.map(|p| DVec3::from_array(p.map(f64::from)) + centre);
                DrawnComb {
                    reach: Bounds::of(points),
                    overlay: Arc::new(overlay),
                }
            });
            self.reach = drawn.reach;
            all.push(drawn.overlay);
        }
        if let Some(mark) = view.mark.filter(|_| shown || model.view.windows.report) {
            all.push(self.mark.get(mark, || {
                markers([Marker {
                    position: narrow(mark - model.centre()),
                    color: MARK,
                    radius_px: 6.0,
                    style: LineStyle::OnTopFaintWhenHidden,
                }])
            }));
        }
        all
    }

    /// The box around `bounds` and the last comb.
    pub(crate) fn around(&self, bounds: Bounds) -> Bounds {
        self.reach.map_or(bounds, |r| {
            Bounds::new(bounds.low.min(r.low), bounds.high.max(r.high))
        })
    }
}

/// The chosen edges, on the limit surface if that is drawn.
fn chosen_edges(model: &Model) -> Overlay {
    let mesh = &model.document.mesh;
    let (topology, limit) = (&mesh.topology, model.draws_limit_of_mesh());
    let point = |v: VertexId| {
        let p = if limit {
            limit_position(topology, &mesh.positions, v)
        } else {
            mesh.position(v)
        };
        narrow(p - model.centre())
    };
    let chains = &model.view.report.chains;
    let places = Places::new(mesh, chains);
    let edges = chains.iter().flat_map(|c| &c.edges);
    let lines = edges
        .filter_map(|e| places.edge(mesh, e))
        .map(|h| [topology.origin(h), topology.target(h)].map(point))
        .map(|ends| line(ends.to_vec(), CHOSEN, 4.0))
        .collect();
    Overlay::new(lines, Vec::new())
}

fn line(points: Vec<[f32; 3]>, color: [f32; 4], width_px: f32) -> Polyline {
    Polyline {
        points,
        closed: false,
        color,
        width_px,
        style: LineStyle::OnTopFaintWhenHidden,
    }
}

fn curvature(comb: &Comb, p: &SectionPoint) -> f64 {
    if comb.own { p.curvature } else { p.averaged }
}

/// A suitable length ([`Comb::length`]) of the teeth of a section, for a model of a given radius.
pub(crate) fn natural_length(section: &Section, comb: &Comb, radius: f64) -> f64 {
    let points = section.curves.iter().flat_map(|c| &c.points);
    let mut sizes: Vec<f64> = points
        .map(|p| curvature(comb, p).abs())
        .filter(|k| k.is_finite())
        .collect();
    sizes.sort_unstable_by(f64::total_cmp);
    let high = sizes.get(sizes.len().saturating_sub(1) * 19 / 20);
    match high {
        Some(&k) if k * radius > 1e-9 => NATURAL / (k * radius),
        _ => NATURAL,
    }
}

fn comb_overlay(section: &Section, comb: &Comb, radius: f64, centre: DVec3) -> Overlay {
    let length = comb
        .length
        .unwrap_or_else(|| natural_length(section, comb, radius));
    let whole: f64 = section.curves.iter().map(|c| c.length).sum();
    let spacing = (radius / comb.density).max(whole / MAX_TEETH as f64);
    let mut lines = Vec::new();
    for curve in &section.curves {
        let mut ends: Vec<[f32; 3]> = Vec::new();
        let flush = |ends: &mut Vec<[f32; 3]>, lines: &mut Vec<Polyline>| {
            if ends.len() > 1 {
                lines.push(line(std::mem::take(ends), ENDS, 1.5));
            }
            ends.clear();
        };
        for p in teeth(curve, spacing) {
            let k = curvature(comb, p);
            if !k.is_finite() {
                flush(&mut ends, &mut lines);
                continue;
            }
            let foot = DVec3::from_array(p.at) - centre;
            // away from the centre of curvature; spikes are limited to stay in the picture
            let size = (-k * length * radius * radius).clamp(-radius, radius);
            let end = narrow(foot + size * DVec3::from_array(p.normal));
            let color = if k < 0.0 { CONVEX } else { CONCAVE };
            lines.push(Polyline {
                style: LineStyle::Depth,
                ..line(vec![narrow(foot), end], color, 1.0)
            });
            ends.push(end);
        }
        if curve.closed && ends.len() > 2 {
            ends.push(ends[0]);
        }
        flush(&mut ends, &mut lines);
        lines.push(Polyline {
            closed: curve.closed,
            ..line(
                curve
                    .points
                    .iter()
                    .map(|p| narrow(DVec3::from_array(p.at) - centre))
                    .collect(),
                SECTION,
                2.0,
            )
        });
    }
    Overlay::new(lines, Vec::new())
}

/// Points of a curve about `spacing` apart, including the first.
fn teeth(curve: &SectionCurve, spacing: f64) -> impl Iterator<Item = &SectionPoint> {
    let mut due = 0.0;
    curve.points.iter().filter(move |p| {
        let take = p.arc >= due;
        if take {
            due = (p.arc / spacing).floor() * spacing + spacing;
        }
        take
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circle(radius: f64, n: usize) -> Section {
        let step = std::f64::consts::TAU / n as f64;
        let points = (0..n)
            .map(|i| {
                let (sin, cos) = (step * i as f64).sin_cos();
                SectionPoint {
                    at: [radius * cos, radius * sin, 0.0],
                    normal: [cos, sin, 0.0],
                    curvature: -1.0 / radius,
                    averaged: -1.0 / radius,
                    arc: radius * step * i as f64,
                }
            })
            .collect();
        Section {
            point: [0.0; 3],
            normal: [0.0, 0.0, 1.0],
            curves: vec![SectionCurve {
                closed: true,
                length: radius * std::f64::consts::TAU,
                points,
            }],
        }
    }

    #[test]
    fn the_comb_of_a_circle_is_a_circle_around_it() {
        let section = circle(2.0, 300);
        let comb = Comb {
            length: Some(0.5),
            density: 10.0,
            own: false,
        };
        let drawn = comb_overlay(&section, &comb, 2.0, DVec3::ZERO);
        let teeth: Vec<&Polyline> = drawn.lines.iter().filter(|l| l.color == CONVEX).collect();
        // ten per radius
        assert!((60..=64).contains(&teeth.len()), "{}", teeth.len());
        for tooth in teeth {
            let [x, y, _] = tooth.points[1];
            // teeth of 0.5 * 2 outside the circle of radius 2
            assert!((x.hypot(y) - 3.0).abs() < 1e-5);
        }
        let natural = natural_length(&section, &comb, 2.0);
        assert!((natural - 0.25).abs() < 1e-12);
    }
}
