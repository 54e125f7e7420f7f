//! A rim as a smooth closed curve, with the directions in which a surface leaves it.

use super::spine::Cubic;
use crate::mesh::{DVec3, rms_distance, vector_area};
use crate::patch::data::Rim;

/// Rims are smoothed over this part of their vertices.
const SMOOTHED: f64 = 1.0 / 24.0;
/// Length of the mean conormal above which the faces at a rim form a tube with an axis; it is 1 for
/// a cylinder and 0 for a hole in a plane.
const TUBE: f64 = 0.4;

/// A rim parametrised by arc length relative to its length, `u` in 0..1, in its own direction.
#[derive(Clone, Debug)]
pub(super) struct RimCurve {
    /// `u` of each vertex, ascending from 0.
    pub place: Vec<f64>,
    /// Without the raggedness of the mesh.
    smooth: Vec<DVec3>,
    /// What was smoothed away.
    rest: Vec<DVec3>,
    /// Unit directions into the gap, in the tangent planes.
    conormal: Vec<DVec3>,
    pub centre: DVec3,
    /// RMS distance from the centre.
    pub radius: f64,
    /// Unit normal of the plane the rim goes around in, counter-clockwise.
    pub normal: DVec3,
    /// Unit mean direction into the gap, if the faces at the rim make a tube.
    axis: Option<DVec3>,
}

/// A point of a [`RimCurve`].
#[derive(Clone, Copy, Debug)]
pub(super) struct RimPoint {
    pub smooth: DVec3,
    pub rest: DVec3,
    pub conormal: DVec3,
}

impl RimCurve {
    pub fn new(rim: &Rim) -> Self {
        let points = &rim.points;
        let n = points.len();
        let into_gap = |i: usize| {
            let (a, b) = (points[i], points[(i + 1) % n]);
            let across = (a - rim.opposite[i]).reject_from(b - a);
            across.normalize_or_zero()
        };
        let conormal: Vec<DVec3> = (0..n)
            .map(|i| into_gap((i + n - 1) % n) + into_gap(i))
            .collect();
        Self::with_conormals(points, &conormal)
    }

    /// A circle that goes around `normal` counter-clockwise and is left along `axis`.
    pub fn circle(centre: DVec3, normal: DVec3, axis: DVec3, radius: f64, edges: usize) -> Self {
        let (u, v) = normal.any_orthonormal_pair();
        let points = (0..edges).map(|i| {
            let (sin, cos) = (std::f64::consts::TAU * i as f64 / edges as f64).sin_cos();
            centre + radius * (cos * u + sin * v)
        });
        Self::with_conormals(&points.collect::<Vec<_>>(), &vec![axis; edges])
    }

    fn with_conormals(points: &[DVec3], conormal: &[DVec3]) -> Self {
        let n = points.len();
        let mut place = Vec::with_capacity(n);
        let (mut length, mut moment) = (0.0, DVec3::ZERO);
        for i in 0..n {
            place.push(length);
            let next = points[(i + 1) % n];
            length += points[i].distance(next);
            moment += points[i].distance(next) * points[i].midpoint(next);
        }
        for u in &mut place {
            *u /= length;
        }
        let centre = moment / length;
        let passes = (2.0 * (SMOOTHED * n as f64).powi(2)).ceil() as usize;
        // twice over, so that circles hardly shrink
        let once = smoothed(points, passes);
        let twice = smoothed(&once, passes);
        let smooth: Vec<DVec3> = (0..n).map(|i| 2.0 * once[i] - twice[i]).collect();
        let mut conormal = smoothed(conormal, passes);
        for c in &mut conormal {
            *c = c.normalize_or_zero();
        }
        let mean = conormal.iter().sum::<DVec3>() / n as f64;
        Self {
            rest: (0..n).map(|i| points[i] - smooth[i]).collect(),
            centre,
            radius: rms_distance(points.iter().copied(), centre),
            normal: vector_area(points).normalize_or_zero(),
            axis: (mean.length() > TUBE).then(|| mean.normalize()),
            place,
            smooth,
            conormal,
        }
    }

    pub fn edges(&self) -> usize {
        self.place.len()
    }

    /// The point at `u`, any number, modulo 1. Between vertices the curve is a cubic with the
    /// slopes of its neighbours' chords (Catmull and Rom).
    pub fn at(&self, u: f64) -> RimPoint {
        let u = u - u.floor();
        let n = self.edges();
        let i = self.place.partition_point(|&p| p <= u) - 1;
        let j = (i + 1) % n;
        let span = self.span(i);
        let f = (u - self.place[i]) / span;
        let slope = |k: usize| {
            let (before, after) = ((k + n - 1) % n, (k + 1) % n);
            let chord = self.smooth[after] - self.smooth[before];
            chord * (span / (self.span(before) + self.span(k)))
        };
        let cubic = Cubic {
            ends: [self.smooth[i], self.smooth[j]],
            slopes: [slope(i), slope(j)],
        };
        RimPoint {
            smooth: cubic.at(f),
            rest: self.rest[i].lerp(self.rest[j], f),
            conormal: self.conormal[i]
                .lerp(self.conormal[j], f)
                .normalize_or_zero(),
        }
    }

    /// The part of the rim from vertex `i` to the next.
    fn span(&self, i: usize) -> f64 {
        let end = self.place.get(i + 1).copied().unwrap_or(1.0);
        end - self.place[i]
    }

    /// The side of the rim's plane to which the tube continues: 1 along the normal, -1 against it,
    /// 0 if the faces lie in the plane.
    pub fn side(&self) -> f64 {
        self.axis.map_or(0.0, |axis| axis.dot(self.normal).signum())
    }

    /// The direction in which a surface leaves the rim; for a rim that is no tube, on the given
    /// side.
    pub fn axis(&self, side: f64) -> DVec3 {
        self.axis.unwrap_or(side * self.normal)
    }

    /// The same with fewer vertices, evenly spaced, and without raggedness.
    pub fn thinned(&self, edges: usize) -> Self {
        let n = edges.min(self.edges());
        let at: Vec<RimPoint> = (0..n).map(|i| self.at(i as f64 / n as f64)).collect();
        Self {
            place: (0..n).map(|i| i as f64 / n as f64).collect(),
            smooth: at.iter().map(|p| p.smooth).collect(),
            rest: vec![DVec3::ZERO; n],
            conormal: at.iter().map(|p| p.conormal).collect(),
            ..*self
        }
    }

    /// The vertices themselves.
    pub fn points(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.smooth.iter().zip(&self.rest).map(|(s, r)| *s + *r)
    }
}

/// `passes` of (1, 2, 1)/4 around a closed list.
fn smoothed(list: &[DVec3], passes: usize) -> Vec<DVec3> {
    let n = list.len();
    let mut now = list.to_vec();
    let mut next = now.clone();
    for _ in 0..passes {
        for i in 0..n {
            next[i] = 0.25 * now[(i + n - 1) % n] + 0.5 * now[i] + 0.25 * now[(i + 1) % n];
        }
        std::mem::swap(&mut now, &mut next);
    }
    now
}
