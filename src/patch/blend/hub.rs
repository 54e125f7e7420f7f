//! Hub surfaces for three or more rims: a tube (leg) from each rim ends near a common point, the
//! hub, and a core joins the ends (mouths) of the legs.

use std::f64::consts::{PI, TAU};

use super::curve::RimCurve;
use super::layout;
use super::loft::{loft_candidates, loft_surface};
use crate::mesh::{DVec3, Topology, VertexId};
use crate::patch::data::{Patch, PatchOptions, Rim};
use crate::patch::fair::warm_start;
use crate::patch::remesh::{refit, rim_valences};
use crate::patch::surface::Surface;

/// Distances, relative to that from the middle, by which the rims are extended along their axes to
/// find the hub.
const FOLLOWED: [f64; 5] = [0.0, 0.3, 0.7, 1.3, 2.2];
/// A leg may take up this part of the angle to the nearest other leg.
const FREE: f64 = 0.38;
/// Maximum radius of the ball around which legs end, relative to the distance of the nearest rim.
const BALL: f64 = 0.6;
/// Number of rounds in which legs rotate away from each other.
const ROUNDS: usize = 40;

/// The hub surfaces of all positions of the hub that can be reached.
pub(super) fn hubs(rims: &[RimCurve], side: f64, sizes: &[f64]) -> Vec<Patch> {
    let axes: Vec<DVec3> = rims.iter().map(|rim| rim.axis(side)).collect();
    let middle = rims.iter().map(|r| r.centre).sum::<DVec3>() / rims.len() as f64;
    FOLLOWED
        .iter()
        .filter_map(|&part| {
            let reach = |rim: &RimCurve| part * rim.centre.distance(middle).max(rim.radius);
            let targets = rims.iter().zip(&axes);
            let targets: Vec<DVec3> = targets.map(|(r, &a)| r.centre + reach(r) * a).collect();
            let hub = targets.iter().sum::<DVec3>() / rims.len() as f64;
            Hub::at(hub, rims, &axes)?.surface(rims, side, sizes)
        })
        .collect()
}

struct Hub {
    centre: DVec3,
    /// Unit direction in which each leg leaves.
    legs: Vec<DVec3>,
    radius: f64,
    /// Radius of each leg where it leaves.
    leg_radius: Vec<f64>,
}

impl Hub {
    fn at(centre: DVec3, rims: &[RimCurve], axes: &[DVec3]) -> Option<Self> {
        let n = rims.len();
        let mut legs: Vec<DVec3> = rims
            .iter()
            .zip(axes)
            .map(|(rim, &axis)| {
                // half way between the rim and the point it comes from
                let to = (rim.centre - centre).normalize_or_zero();
                (to - 0.4 * axis).normalize_or_zero()
            })
            .collect();
        // the angle between tubes of these widths, seen from the hub
        let narrow = (2.0 / n as f64).min(0.7);
        for _ in 0..ROUNDS {
            for i in 0..n {
                for j in 0..i {
                    let angle = legs[i].angle_between(legs[j]);
                    if angle < narrow {
                        let apart = (legs[i] - legs[j]).normalize_or_zero();
                        legs[i] = (legs[i] + 0.1 * apart).normalize_or_zero();
                        legs[j] = (legs[j] - 0.1 * apart).normalize_or_zero();
                    }
                }
            }
        }
        let mut least = PI;
        let mut wanted: f64 = 0.0;
        for i in 0..n {
            for j in 0..i {
                let angle = legs[i].angle_between(legs[j]);
                if !angle.is_finite() || angle < 0.05 {
                    return None;
                }
                least = least.min(angle);
                let mean = 0.5 * (rims[i].radius + rims[j].radius);
                wanted = wanted.max(mean / (FREE * angle).tan());
            }
        }
        let near = rims.iter().map(|r| r.centre.distance(centre));
        let near = near.fold(f64::INFINITY, f64::min);
        let radius = wanted.min(BALL * near);
        if radius <= 0.0 {
            return None;
        }
        let most = radius * (FREE * least).tan();
        Some(Self {
            centre,
            legs,
            radius,
            leg_radius: rims.iter().map(|r| r.radius.min(most)).collect(),
        })
    }

    fn surface(&self, rims: &[RimCurve], side: f64, sizes: &[f64]) -> Option<Patch> {
        let mut joined = Joined {
            rim_vertices: rims.iter().map(RimCurve::edges).sum(),
            points: rims.iter().flat_map(RimCurve::points).collect(),
            triangles: Vec::new(),
            mouths: Vec::new(),
            mouth_vertices: Vec::new(),
        };
        let mut first = 0;
        for (k, rim) in rims.iter().enumerate() {
            joined.add_leg(self, k, (rim, first), side, sizes[k])?;
            first += rim.edges();
        }
        let first = joined.points.len();
        joined.add_core()?;
        joined.relax(first)?;
        Some(Patch {
            rim: joined.rim_vertices,
            points: joined.points,
            triangles: joined.triangles,
        })
    }
}

/// Number of rings of the legs that are smoothed together with the core.
const LOOSE_RINGS: usize = 2;
/// Minimum number of edges around a leg.
const AROUND: f64 = 8.0;

/// Legs and core under construction, the rims' vertices first.
struct Joined {
    rim_vertices: usize,
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    /// Where the legs end, as rims of the core, and the vertices there.
    mouths: Vec<Rim>,
    mouth_vertices: Vec<u32>,
}

impl Joined {
    /// Adds the leg of rim `k`, whose vertices are those from `first` on.
    fn add_leg(
        &mut self,
        hub: &Hub,
        k: usize,
        (rim, first): (&RimCurve, usize),
        side: f64,
        size: f64,
    ) -> Option<()> {
        let (leg, radius) = (hub.legs[k], hub.leg_radius[k]);
        let at = hub.centre + hub.radius * leg;
        let size_there = size.min(TAU * radius / AROUND);
        let edges = (TAU * radius / size_there).round() as usize;
        let normal = if side < 0.0 { -leg } else { leg };
        let end = RimCurve::circle(at, normal, leg, radius, edges);
        let loft = loft_candidates(rim, &end, side).into_iter().next()?;
        let sheet = loft_surface([rim, &end], &loft, [size, size_there]);
        let (n, new) = (rim.edges(), self.points.len());
        let global = |v: u32| {
            let v = v as usize;
            (if v < n { first + v } else { new + v - n }) as u32
        };
        self.points.extend_from_slice(&sheet.points[n..]);
        let triangles = sheet.triangles.iter();
        self.triangles.extend(triangles.map(|t| t.map(global)));
        // seen from the hub, the circle runs the other way around
        let vertices: Vec<u32> = (0..edges).rev().map(|e| (new + e) as u32).collect();
        let points: Vec<DVec3> = vertices.iter().map(|&v| self.points[v as usize]).collect();
        let outer = |i: usize| points[i].midpoint(points[(i + 1) % edges]) + size_there * leg;
        self.mouths.push(Rim {
            opposite: (0..edges).map(outer).collect(),
            points,
            forbidden: Vec::new(),
        });
        self.mouth_vertices.extend(vertices);
        Some(())
    }

    fn add_core(&mut self) -> Option<()> {
        let core = core(&self.mouths)?;
        let mouths = &self.mouth_vertices;
        let new = (self.points.len() - mouths.len()) as u32;
        let global = |v: u32| mouths.get(v as usize).copied().unwrap_or(new + v);
        self.points.extend_from_slice(&core.points[mouths.len()..]);
        let triangles = core.triangles.iter();
        self.triangles.extend(triangles.map(|t| t.map(global)));
        Some(())
    }

    /// Smooths the core, whose vertices are the mouths' and those from `first` on, into the legs.
    fn relax(&mut self, first: usize) -> Option<()> {
        let topology = Topology::from_triangles(self.points.len(), &self.triangles).ok()?;
        let mut loose = self.mouth_vertices.clone();
        loose.extend(first as u32..self.points.len() as u32);
        for _ in 0..LOOSE_RINGS {
            let around = loose.iter().flat_map(|&v| topology.neighbours(VertexId(v)));
            let around: Vec<u32> = around.map(|w| w.0).collect();
            loose.extend(around);
            loose.retain(|&v| v as usize >= self.rim_vertices);
            loose.sort_unstable();
            loose.dedup();
        }
        let loose: Vec<VertexId> = loose.into_iter().map(VertexId).collect();
        warm_start(&topology, &mut self.points, &loose).ok()
    }
}

/// A surface between the mouths of the legs.
fn core(mouths: &[Rim]) -> Option<Patch> {
    let triangles = layout::triangulate(mouths)?;
    let points: Vec<DVec3> = mouths.iter().flat_map(|r| r.points.clone()).collect();
    let size = super::sizes(mouths, PatchOptions::default());
    let count = points.len();
    let mut surface = Surface::new(points, size, count, &triangles);
    let wanted = rim_valences(&surface, &vec![0.0; count]);
    super::split_double_edges(&mut surface);
    refit(&mut surface, &wanted);
    Some(surface.compact())
}
