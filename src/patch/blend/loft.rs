//! Surfaces lofted from one rim to another.

use super::bending::bending;
use super::curve::{RimCurve, RimPoint};
use super::spine::{Cubic, Spine};
use crate::mesh::{DVec3, perimeter, self_intersections};
use crate::patch::data::Patch;

/// How the points of two rims are joined by curves.
#[derive(Clone, Debug)]
enum Path {
    /// Every point has its own cubic.
    Rails { pull: f64 },
    /// The cross-section moves along a spine and turns with it, while it changes from one rim to
    /// the other.
    Swept(Box<Spine>),
}

/// The kinds of [`Path`].
#[derive(Clone, Copy, Debug)]
enum LoftKind {
    Rails,
    Swept,
}

impl LoftKind {
    /// Factor on the bending, so that of two similar candidates the one with untwisted
    /// cross-sections is taken.
    fn handicap(self) -> f64 {
        match self {
            Self::Rails => 1.05,
            Self::Swept => 1.0,
        }
    }
}

/// A lofted surface: which points of the rims are joined, and by which curves.
#[derive(Clone, Debug)]
pub(super) struct LoftParameters {
    /// The point at `u` of the first rim is joined to that at `shift - u` of the second.
    shift: f64,
    path: Path,
}

/// Number of shifts that are tried.
const SHIFTS: usize = 24;
/// Number of times the step between shifts is halved around the best one.
const HALVINGS: usize = 8;
/// Lengths of the end derivatives that are tried, relative to those of circular arcs; 1 first.
const PULLS: [f64; 5] = [1.0, 0.6, 1.5, 2.2, 3.2];
/// Maximum number of edges of the rims while surfaces are compared.
const COARSE: usize = 24;
/// Number of candidates of each kind that are checked for self-intersections.
const MAX_CHECKED: usize = 6;

/// Lofts from rim `a` to rim `b` without self-intersections, at most one of each kind, sorted by
/// bending. `side` is the side to which a rim that is no tube is left (see [`RimCurve::side`]).
pub(super) fn loft_candidates(a: &RimCurve, b: &RimCurve, side: f64) -> Vec<LoftParameters> {
    let ends = [&a.thinned(COARSE), &b.thinned(COARSE)];
    let mut kinds = vec![LoftKind::Rails];
    if leads_apart(ends) {
        kinds.push(LoftKind::Swept);
    }
    let mut found: Vec<(f64, LoftParameters)> = Vec::new();
    for kind in kinds {
        let all = candidates(ends, kind, side).into_iter();
        let best = all.map(|found| refined(ends, found)).find(|(_, loft)| {
            let surface = loft_surface(ends, loft, mean_edges(ends));
            self_intersections(&surface.points, &surface.triangles, None, 1).is_empty()
        });
        found.extend(best.map(|(amount, loft)| (kind.handicap() * amount, loft)));
    }
    found.sort_by(|x, y| x.0.total_cmp(&y.0));
    found.into_iter().map(|f| f.1).collect()
}

/// The lofts of one kind with the lowest bending, and their bending.
fn candidates(ends: [&RimCurve; 2], kind: LoftKind, side: f64) -> Vec<(f64, LoftParameters)> {
    let mut found = Vec::new();
    // the best twist hardly depends on the length of the end derivatives
    let mut twists = 0..SHIFTS;
    for pull in PULLS {
        let path = Path::new(ends, kind, side, pull);
        let tried = twists.clone().map(|k| {
            let loft = LoftParameters {
                shift: k as f64 / SHIFTS as f64,
                path: path.clone(),
            };
            (bending_of(ends, &loft), k, loft)
        });
        let tried: Vec<(f64, usize, LoftParameters)> = tried.collect();
        let best = tried.iter().min_by(|x, y| x.0.total_cmp(&y.0));
        if let Some(&(least, k, _)) = best
            && pull == PULLS[0]
            && least.is_finite()
        {
            twists = k + SHIFTS - 1..k + SHIFTS + 2;
        }
        let finite = tried.into_iter().filter(|(amount, ..)| amount.is_finite());
        found.extend(finite.map(|(amount, _, loft)| (amount, loft)));
    }
    found.sort_by(|x, y| x.0.total_cmp(&y.0));
    found.truncate(MAX_CHECKED);
    found
}

/// Refines the twist of a swept loft: the one that turns the cross-section least. (The bending of a
/// coarse surface is too rough for such small differences.)
fn refined(
    ends: [&RimCurve; 2],
    (amount, mut loft): (f64, LoftParameters),
) -> (f64, LoftParameters) {
    if matches!(loft.path, Path::Rails { .. }) {
        return (amount, loft);
    }
    let turned = |loft: &LoftParameters| -> f64 {
        let rails = (0..RAILS).map(|i| Rail::new(ends, loft, i as f64 / RAILS as f64).curve);
        rails.map(|c| c.ends[0].distance_squared(c.ends[1])).sum()
    };
    let mut least = turned(&loft);
    let mut step = 1.0 / SHIFTS as f64;
    for _ in 0..HALVINGS {
        for shift in [loft.shift - step, loft.shift + step] {
            let path = loft.path.clone();
            let other = LoftParameters { shift, path };
            let found = turned(&other);
            if found < least {
                (least, loft) = (found, other);
                break;
            }
        }
        step *= 0.5;
    }
    (amount, loft)
}

fn bending_of(ends: [&RimCurve; 2], loft: &LoftParameters) -> f64 {
    let surface = loft_surface(ends, loft, mean_edges(ends));
    bending(&surface.points, &surface.triangles)
}

fn mean_edges(ends: [&RimCurve; 2]) -> [f64; 2] {
    ends.map(|rim| {
        let points: Vec<DVec3> = rim.points().collect();
        perimeter(&points) / points.len() as f64
    })
}

/// Whether the rims can be the two ends of one tube: neither around one another nor leading to
/// opposite sides.
fn leads_apart([a, b]: [&RimCurve; 2]) -> bool {
    let apart = a.centre.distance(b.centre);
    a.side() * b.side() >= 0.0 && apart > 0.1 * a.radius.max(b.radius)
}

impl Path {
    fn new([a, b]: [&RimCurve; 2], kind: LoftKind, side: f64, pull: f64) -> Self {
        match kind {
            LoftKind::Rails => Self::Rails { pull },
            LoftKind::Swept => {
                let axes = [a, b].map(|rim| rim.axis(side));
                let curve = Cubic::turning(a.centre, axes[0], b.centre, -axes[1], pull);
                Self::Swept(Box::new(Spine::new(curve)))
            }
        }
    }
}

/// Number of edges over which the raggedness of a rim fades out.
const RAGGED: f64 = 4.0;

/// The points of one rail.
struct Rail<'a> {
    ends: [RimPoint; 2],
    loft: &'a LoftParameters,
    /// The rail itself, or its cross-section's point relative to the spine in the frame at its
    /// start.
    curve: Cubic,
}

impl<'a> Rail<'a> {
    fn new(ends: [&RimCurve; 2], loft: &'a LoftParameters, u: f64) -> Self {
        let [a, b] = [ends[0].at(u), ends[1].at(loft.shift - u)];
        let curve = match &loft.path {
            Path::Rails { pull } => {
                Cubic::turning(a.smooth, a.conormal, b.smooth, -b.conormal, *pull)
            }
            Path::Swept(spine) => {
                let offsets = [a.smooth - ends[0].centre, b.smooth - ends[1].centre];
                let directions = [a.conormal, -b.conormal];
                let mut slopes = [DVec3::ZERO; 2];
                for (k, t) in [0.0, 1.0].into_iter().enumerate() {
                    // the derivative of the sweep alone; the rest makes the surface leave along the
                    // conormal at the same speed
                    let carried =
                        spine.curve.slope(t) + spine.curve.turning_rate(t).cross(offsets[k]);
                    slopes[k] = carried.length() * directions[k] - carried;
                }
                let back = spine.frame(1.0).transpose();
                Cubic {
                    ends: [offsets[0], back * offsets[1]],
                    slopes: [slopes[0], back * slopes[1]],
                }
            }
        };
        Self {
            ends: [a, b],
            loft,
            curve,
        }
    }

    /// At `t` in 0..=1; `fades` are the parts of the curve over which the raggedness of the ends
    /// fades.
    fn at(&self, t: f64, fades: [f64; 2]) -> DVec3 {
        let smooth = match &self.loft.path {
            Path::Rails { .. } => self.curve.at(t),
            Path::Swept(spine) => spine.curve.at(t) + spine.frame(t) * self.curve.at(t),
        };
        let left = |far: f64, fade: f64| (1.0 - far / fade).max(0.0).powi(2);
        smooth + left(t, fades[0]) * self.ends[0].rest + left(1.0 - t, fades[1]) * self.ends[1].rest
    }
}

/// Number of rails along which lengths are measured, and of their pieces.
const RAILS: usize = 16;
const PIECES: usize = 32;
/// Maximum number of rows of triangles; a row has at most four times as many vertices.
const MAX_ROWS: usize = 4000;
/// Height of an equilateral triangle.
const ROW: f64 = 0.866;

/// Triangulates a loft with edges whose lengths go from `sizes[0]` to `sizes[1]`: a patch over the
/// two rims.
pub(super) fn loft_surface(ends: [&RimCurve; 2], loft: &LoftParameters, sizes: [f64; 2]) -> Patch {
    let rows = Rows::new(ends, loft, sizes);
    let mut points: Vec<DVec3> = ends.iter().flat_map(|rim| rim.points()).collect();
    let numbered = |first: usize, n: usize| (0..n).map(move |k| (first + k) as u32);
    let n = ends.map(RimCurve::edges);
    // a row: places around and vertices
    let mut last: Vec<(f64, u32)> = ends[0]
        .place
        .iter()
        .copied()
        .zip(numbered(0, n[0]))
        .collect();
    let mut triangles = Vec::new();
    for (j, &(t, count)) in rows.list.iter().enumerate() {
        let first = points.len();
        let offset = if j % 2 == 0 { 0.5 } else { 0.0 };
        let places = (0..count).map(|k| (k as f64 + offset) / count as f64);
        let row: Vec<(f64, u32)> = places.zip(numbered(first, count)).collect();
        points.extend(
            row.iter()
                .map(|&(u, _)| Rail::new(ends, loft, u).at(t, rows.fades)),
        );
        stitch(&last, &row, &mut triangles);
        last = row;
    }
    let mut end: Vec<(f64, u32)> = ends[1]
        .place
        .iter()
        .map(|&u| loft.shift - u)
        .map(|u| u - u.floor())
        .zip(numbered(n[0], n[1]))
        .collect();
    end.sort_by(|a, b| a.0.total_cmp(&b.0));
    stitch(&last, &end, &mut triangles);
    Patch {
        rim: n[0] + n[1],
        points,
        triangles,
    }
}

/// The rows of vertices of a lofted surface.
struct Rows {
    /// `t` and number of vertices of each inner row.
    list: Vec<(f64, usize)>,
    fades: [f64; 2],
}

impl Rows {
    fn new(ends: [&RimCurve; 2], loft: &LoftParameters, sizes: [f64; 2]) -> Self {
        let rails: Vec<Rail<'_>> = (0..RAILS)
            .map(|i| Rail::new(ends, loft, i as f64 / RAILS as f64))
            .collect();
        let none = [f64::MIN_POSITIVE; 2];
        let time = |p: usize| p as f64 / PIECES as f64;
        let rings: Vec<Vec<DVec3>> = (0..=PIECES)
            .map(|p| rails.iter().map(|rail| rail.at(time(p), none)).collect())
            .collect();
        let mut along = vec![0.0];
        for p in 0..PIECES {
            let loft_candidates = rings[p].iter().zip(&rings[p + 1]);
            let mean = loft_candidates.map(|(a, b)| a.distance(*b)).sum::<f64>() / RAILS as f64;
            along.push(along[p] + mean);
        }
        let length = along[PIECES].max(f64::MIN_POSITIVE);
        let size = |p: usize| sizes[0] * (sizes[1] / sizes[0]).powf(along[p] / length);
        // rows up to each place
        let mut rows = vec![0.0];
        for p in 0..PIECES {
            let here = 0.5 * ROW * (size(p) + size(p + 1));
            rows.push(rows[p] + (along[p + 1] - along[p]) / here);
        }
        let count = (rows[PIECES].round() as usize).clamp(2, MAX_ROWS);
        let list = (1..count).map(|j| {
            let wanted = rows[PIECES] * j as f64 / count as f64;
            let p = rows.partition_point(|&r| r < wanted).clamp(1, PIECES);
            let f = (wanted - rows[p - 1]) / (rows[p] - rows[p - 1]);
            let around = (1.0 - f) * perimeter(&rings[p - 1]) + f * perimeter(&rings[p]);
            let size = (1.0 - f) * size(p - 1) + f * size(p);
            let n = ((around / size).round() as usize).clamp(5, 4 * MAX_ROWS);
            (time(p - 1) + f * (time(p) - time(p - 1)), n)
        });
        Self {
            list: list.collect(),
            fades: sizes.map(|s| (RAGGED * s / length).clamp(1e-3, 0.5)),
        }
    }
}

/// Triangles between two rows of (place around, vertex), places ascending.
fn stitch(low: &[(f64, u32)], high: &[(f64, u32)], triangles: &mut Vec<[u32; 3]>) {
    let place = |row: &[(f64, u32)], i: usize| row[i % row.len()].0 + (i / row.len()) as f64;
    let vertex = |row: &[(f64, u32)], i: usize| row[i % row.len()].1;
    let (mut i, mut j) = (0, 0);
    while i < low.len() || j < high.len() {
        let ahead = i < low.len()
            && (j >= high.len()
                || place(low, i + 1) + place(low, i) <= place(high, j + 1) + place(high, j));
        let (a, b) = (vertex(low, i), vertex(high, j));
        if ahead {
            i += 1;
            triangles.push([a, vertex(low, i), b]);
        } else {
            j += 1;
            triangles.push([a, vertex(high, j), b]);
        }
    }
}
