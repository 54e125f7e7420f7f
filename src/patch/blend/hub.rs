//! Legs from many rims to a hub, where they are joined.

use super::curve::RimCurve;
use super::loft::{Sheet, sheet, ways};
use super::{Gap, layout};
use crate::mesh::{DVec3, Topology, VertexId};
use crate::patch::remesh::{refit, rim_valences};
use crate::patch::surface::Surface;
use crate::patch::{Rim, warm_start};

/// How far along their axes, in distances from the middle, the rims are followed to find the hub.
const FOLLOWED: [f64; 5] = [0.0, 0.3, 0.7, 1.3, 2.2];
/// Legs keep this part of the angle between them free of one another.
const FREE: f64 = 0.38;
/// The ball around which legs end reaches at most this part of the way to the nearest rim.
const BALL: f64 = 0.6;
/// Rounds in which legs turn away from one another.
const ROUNDS: usize = 40;

/// Points and triangles between the rims, rims first, for each hub that is tried and can be reached.
pub(super) fn hubs(rims: &[RimCurve], side: f64, sizes: &[f64]) -> Vec<Sheet> {
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
                // half way between where the rim is and where it comes from
                let to = (rim.centre - centre).normalize_or_zero();
                (to - 0.4 * axis).normalize_or_zero()
            })
            .collect();
        // as far apart as tubes of these widths seen from here want to be
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
        let mut least = std::f64::consts::PI;
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

    fn surface(&self, rims: &[RimCurve], side: f64, sizes: &[f64]) -> Option<Sheet> {
        let sign = if side < 0.0 { -1.0 } else { 1.0 };
        let mut first = 0;
        let count: usize = rims.iter().map(RimCurve::edges).sum();
        let mut points: Vec<DVec3> = rims.iter().flat_map(RimCurve::points).collect();
        let mut triangles = Vec::new();
        let mut mouths = Vec::new();
        let mut numbers: Vec<u32> = Vec::new();
        for (k, rim) in rims.iter().enumerate() {
            let (leg, radius) = (self.legs[k], self.leg_radius[k]);
            let at = self.centre + self.radius * leg;
            // a narrow leg keeps enough edges to go around
            let size = sizes[k].min(std::f64::consts::TAU * radius / 8.0);
            let edges = (std::f64::consts::TAU * radius / size).round() as usize;
            let end = RimCurve::circle(at, sign * leg, leg, radius, edges);
            let way = ways(rim, &end, side).into_iter().next()?;
            let leg_sheet = sheet([rim, &end], &way, [sizes[k], size]);
            let n = rim.edges();
            let new = points.len();
            let global = |v: u32| {
                let v = v as usize;
                (if v < n { first + v } else { new + v - n }) as u32
            };
            points.extend_from_slice(&leg_sheet.points[n..]);
            triangles.extend(leg_sheet.triangles.iter().map(|t| t.map(global)));
            // seen from the hub, the circle goes the other way round
            let mut own: Vec<u32> = (0..edges).map(|e| (new + e) as u32).collect();
            own.reverse();
            let mouth: Vec<DVec3> = own.iter().map(|&v| points[v as usize]).collect();
            let outer = |p: DVec3| p + size * leg;
            mouths.push(Rim {
                opposite: (0..edges)
                    .map(|i| outer(mouth[i].midpoint(mouth[(i + 1) % edges])))
                    .collect(),
                points: mouth,
                forbidden: Vec::new(),
            });
            numbers.extend(own);
            first += n;
        }
        let core = core(&mouths)?;
        let new = points.len() - numbers.len();
        let global = |v: u32| match numbers.get(v as usize) {
            Some(&v) => v,
            None => new as u32 + v,
        };
        points.extend_from_slice(&core.points[numbers.len()..]);
        triangles.extend(core.triangles.iter().map(|t| t.map(global)));
        let topology = Topology::from_triangles(points.len(), &triangles).ok()?;
        let mut loose: Vec<u32> = numbers.clone();
        loose.extend((new + numbers.len()) as u32..points.len() as u32);
        for _ in 0..LOOSE_RINGS {
            let mut wider = loose.clone();
            for &v in &loose {
                wider.extend(topology.neighbours(VertexId(v)).map(|w| w.0));
            }
            wider.retain(|&v| v as usize >= count);
            wider.sort_unstable();
            wider.dedup();
            loose = wider;
        }
        let loose: Vec<VertexId> = loose.into_iter().map(VertexId).collect();
        warm_start(&topology, &mut points, &loose).ok()?;
        Some(Sheet { points, triangles })
    }
}

/// Rings of the legs that give way to the core.
const LOOSE_RINGS: usize = 2;

/// A surface between the mouths of the legs.
fn core(mouths: &[Rim]) -> Option<Sheet> {
    let triangles = layout::triangulate(mouths)?;
    let gap = Gap {
        rims: mouths.to_vec(),
        ..Gap::default()
    };
    let points: Vec<DVec3> = mouths.iter().flat_map(|r| r.points.clone()).collect();
    let size = super::sizes(&gap.rims, crate::patch::PatchOptions::default());
    let mut surface = Surface::new(points, size, gap.len(), &triangles);
    let wanted = rim_valences(&surface, &vec![0.0; gap.len()]);
    super::split_double_edges(&mut surface);
    refit(&mut surface, &wanted);
    let (points, triangles) = surface.compact();
    Some(Sheet { points, triangles })
}
