//! Plane sections of a limit surface, with their curvature as plane curves.

mod cutter;
#[cfg(test)]
mod tests;

use serde::Serialize;

use crate::mesh::{DVec3, Topology};
use cutter::Cutter;

/// A plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// A point of it.
    pub point: DVec3,
    /// Perpendicular to it, of any length but zero.
    pub normal: DVec3,
}

/// The curves in which a plane cuts a surface.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Section {
    /// A point of the plane.
    pub point: [f64; 3],
    /// Its unit normal.
    pub normal: [f64; 3],
    /// The connected curves, open ones first.
    pub curves: Vec<SectionCurve>,
}

/// A connected curve of a section.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SectionCurve {
    /// Whether its end is its beginning, which is not repeated.
    pub closed: bool,
    /// Length of the chords.
    pub length: f64,
    /// Its points. Seen from where the plane's normal points to, they run counter-clockwise around
    /// what a surface with outward normals encloses.
    pub points: Vec<SectionPoint>,
}

/// A point of a section.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SectionPoint {
    /// The position.
    pub at: [f64; 3],
    /// Unit normal of the curve within the plane, on the side of the surface's normal.
    pub normal: [f64; 3],
    /// Curvature of the plane curve, 1 / length: negative where it bends away from `normal`, as on
    /// a sphere with outward normals (−1/r with r the radius of the section circle); NaN (null in
    /// JSON) where the plane touches the surface. At an irregular vertex the limit surface has no
    /// bounded curvature, and this shows it.
    pub curvature: f64,
    /// The same with the second fundamental form averaged around the vertices and interpolated
    /// between them, as curvatures are drawn: the shape without the spikes of irregular vertices.
    pub averaged: f64,
    /// Length of the chords from the beginning of the curve.
    pub arc: f64,
}

/// Cuts the limit surface of the `control` points by a plane. Points lie on both to rounding. The
/// section's curvature is the surface's normal curvature `II(t, t)` along its unit tangent `t`,
/// over the cosine of the angle between surface normal and curve normal (Meusnier). No curve for a
/// normal of length zero.
pub fn section(topology: &Topology, control: &[DVec3], plane: &Plane) -> Section {
    let normal = plane.normal.try_normalize();
    let curves = normal.map_or_else(Vec::new, |normal| {
        Cutter::new(topology, control, plane.point, normal).run()
    });
    Section {
        point: plane.point.to_array(),
        normal: normal.unwrap_or_default().to_array(),
        curves,
    }
}
