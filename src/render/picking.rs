//! Picking: the surface points, loops and rim vertices under the cursor.

use glam::DVec2;

use super::Camera;
use crate::mesh::{BoundaryLoop, DVec3, FaceId, LoopId, Topology, TriangleBvh};

/// Lines of sight to a rim end this far before it, relative to the lengths of the edge and of the
/// line, so that faces at the rim do not hide it.
const SHORTER: [f64; 2] = [0.01, 1e-9];

/// A point of the surface under the cursor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The face.
    pub face: FaceId,
    /// The point.
    pub point: DVec3,
    /// The distance from the eye in units of the file. In a parallel projection it is the distance
    /// from the plane of the eye and may be negative.
    pub distance: f64,
}

/// Picks on a mesh that does not change.
#[derive(Clone, Debug)]
pub struct Picker {
    surface: TriangleBvh,
    rims: Vec<Rim>,
}

/// A boundary loop.
#[derive(Clone, Debug)]
struct Rim {
    points: Vec<DVec3>,
    centroid: DVec3,
    /// Whether a click into the opening picks the loop; false for an outer boundary.
    open: bool,
}

/// Lines of sight of a camera in a view of a given size.
#[derive(Clone, Copy, Debug)]
pub struct Projector<'a> {
    camera: &'a Camera,
    size: DVec2,
    aspect: f64,
}

impl<'a> Projector<'a> {
    /// The lines of sight in a view of this size in pixels.
    pub fn new(camera: &'a Camera, size_px: [f64; 2]) -> Self {
        let size = DVec2::from(size_px).max(DVec2::ONE);
        Self {
            camera,
            size,
            aspect: size.x / size.y,
        }
    }

    /// Whether a point is not hidden by the cut of the camera.
    pub fn shows(&self, point: DVec3) -> bool {
        !self.camera.hides(point)
    }

    /// Position in pixels from the upper left corner; `None` behind the eye.
    pub fn pixel(&self, p: DVec3) -> Option<[f64; 2]> {
        let [x, y] = self.camera.project(p, self.aspect)?;
        Some((DVec2::new(x + 1.0, 1.0 - y) * 0.5 * self.size).to_array())
    }

    /// Origin and unit direction of the line of sight through a pixel.
    pub fn line_through(&self, pixel: [f64; 2]) -> (DVec3, DVec3) {
        let ndc = DVec2::from(pixel) / self.size * 2.0 - 1.0;
        self.camera.ray([ndc.x, -ndc.y], self.aspect)
    }

    /// Origin, unit direction and length of the line of sight to a point.
    pub fn line_to(&self, point: DVec3) -> (DVec3, DVec3, f64) {
        let (origin, direction) = if self.camera.orthographic {
            let forward = self.camera.forward();
            let depth = (point - self.camera.eye()).dot(forward);
            (point - forward * depth, forward)
        } else {
            let eye = self.camera.eye();
            (eye, (point - eye).normalize_or_zero())
        };
        (origin, direction, (point - origin).dot(direction))
    }
}

/// A view with a cursor in it.
struct View<'a> {
    projector: Projector<'a>,
    cursor: DVec2,
    origin: DVec3,
    direction: DVec3,
    /// Distance at which the line of sight begins.
    start: f64,
}

impl<'a> View<'a> {
    fn new(camera: &'a Camera, size_px: [f64; 2], cursor_px: [f64; 2]) -> Self {
        let projector = Projector::new(camera, size_px);
        let (origin, direction) = projector.line_through(cursor_px);
        Self {
            start: camera.first_visible(origin, direction),
            projector,
            cursor: DVec2::from(cursor_px),
            origin,
            direction,
        }
    }

    /// Position in pixels from the upper left corner; `None` behind the eye.
    fn pixel(&self, p: DVec3) -> Option<DVec2> {
        self.projector.pixel(p).map(DVec2::from)
    }
}

/// A point of a rim near the cursor.
struct Near {
    distance_px: f64,
    rim: usize,
    edge: [DVec3; 2],
    /// Position on the edge, 0 to 1.
    at: f64,
}

impl Picker {
    /// Prepares a mesh with its boundary loops in O(n log n) for n faces. Use a background thread
    /// for a large mesh.
    pub fn new(positions: &[DVec3], topology: &Topology, loops: &[BoundaryLoop]) -> Self {
        let triangles: Vec<[u32; 3]> = topology.triangles().collect();
        let rims = loops.iter().map(|one| Rim {
            points: one.vertices.iter().map(|v| positions[v.index()]).collect(),
            centroid: one.centroid,
            open: !one.is_outer_boundary,
        });
        Self {
            surface: TriangleBvh::new(positions, &triangles),
            rims: rims.collect(),
        }
    }

    /// The nearest point of the surface under the cursor (in pixels from the upper left corner).
    pub fn surface(&self, camera: &Camera, size_px: [f64; 2], cursor_px: [f64; 2]) -> Option<Hit> {
        let view = View::new(camera, size_px, cursor_px);
        let within = [view.start, f64::INFINITY];
        let hit = self
            .surface
            .first_hit(view.origin, view.direction, within)?;
        Some(Hit {
            face: FaceId(hit.face),
            point: view.origin + view.direction * hit.t,
            distance: hit.t,
        })
    }

    /// The face nearest to a point.
    pub fn nearest(&self, point: DVec3) -> Option<FaceId> {
        let closest = self.surface.closest_point(point)?;
        Some(FaceId(closest.face))
    }

    /// The first face along a line of sight, up to `end`.
    pub fn first_face(
        &self,
        projector: &Projector<'_>,
        origin: DVec3,
        direction: DVec3,
        end: f64,
    ) -> Option<FaceId> {
        let hit = self.surface.first_hit(
            origin,
            direction,
            [projector.camera.first_visible(origin, direction), end],
        )?;
        Some(FaceId(hit.face))
    }

    /// The loop under the cursor. This is the visible loop whose rim is nearest to the cursor, at
    /// most `tolerance_px` away. If there is none, it is the hole whose opening contains the
    /// cursor, from either side, with no surface in front. Outer boundaries have no opening.
    pub fn pick_loop(
        &self,
        camera: &Camera,
        size_px: [f64; 2],
        cursor_px: [f64; 2],
        tolerance_px: f64,
    ) -> Option<LoopId> {
        let view = View::new(camera, size_px, cursor_px);
        self.rim_at(&view, tolerance_px)
            .map(|near| near.rim.into())
            .or_else(|| self.opening_at(&view))
    }

    /// The visible rim vertex nearest to the cursor, of the edges that are at most `tolerance_px`
    /// away.
    pub fn pick_rim_vertex(
        &self,
        camera: &Camera,
        size_px: [f64; 2],
        cursor_px: [f64; 2],
        tolerance_px: f64,
    ) -> Option<DVec3> {
        let view = View::new(camera, size_px, cursor_px);
        let near = self.rim_at(&view, tolerance_px)?;
        Some(near.edge[usize::from(near.at > 0.5)])
    }

    fn rim_at(&self, view: &View<'_>, tolerance: f64) -> Option<Near> {
        let mut near: Vec<Near> = Vec::new();
        for (rim, r) in self.rims.iter().enumerate() {
            let Some(&last) = r.points.last() else {
                continue;
            };
            let mut from = (last, view.pixel(last));
            for &p in &r.points {
                let to = (p, view.pixel(p));
                if let (Some(a), Some(b)) = (from.1, to.1) {
                    let (at, distance_px) = nearest_on_segment(view.cursor, a, b);
                    if distance_px <= tolerance {
                        near.push(Near {
                            distance_px,
                            rim,
                            edge: [from.0, to.0],
                            at,
                        });
                    }
                }
                from = to;
            }
        }
        near.sort_by(|a, b| a.distance_px.total_cmp(&b.distance_px));
        near.into_iter().find(|n| self.is_visible(view, n))
    }

    /// Whether no surface hides the point of the rim that is nearest to the cursor.
    fn is_visible(&self, view: &View<'_>, near: &Near) -> bool {
        let [a, b] = near.edge;
        // perspective: equal lengths on an oblique line have different lengths in pixels
        let camera = view.projector.camera;
        let point = if camera.orthographic {
            a + (b - a) * near.at
        } else {
            let depth = |p: DVec3| (p - camera.eye()).dot(camera.forward());
            let (da, db) = (depth(a), depth(b));
            a + (b - a) * (near.at * da / (db + near.at * (da - db)))
        };
        if camera.hides(point) {
            return false;
        }
        let (origin, direction, length) = view.projector.line_to(point);
        let start = camera.first_visible(origin, direction);
        let end = length - SHORTER[0] * a.distance(b) - SHORTER[1] * length.abs();
        let hit = self.surface.first_hit(origin, direction, [start, end]);
        hit.is_none()
    }

    /// The nearest opening in front of any surface.
    fn opening_at(&self, view: &View<'_>) -> Option<LoopId> {
        let within = [view.start, f64::INFINITY];
        let surface = self
            .surface
            .first_hit(view.origin, view.direction, within)
            .map_or(f64::INFINITY, |hit| hit.t);
        self.rims
            .iter()
            .enumerate()
            .filter(|(_, rim)| rim.open)
            .filter_map(|(i, rim)| Some((i, rim.opening(view)?)))
            .filter(|&(_, t)| t < surface)
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(i, _)| i.into())
    }
}

impl Rim {
    /// The intersection of the line of sight with the opening: the cone from the centroid over the
    /// rim, if the rim winds around the line. The signed number of intersections with the cone
    /// equals the winding number of the rim around the line for any shape of the rim.
    fn opening(&self, view: &View<'_>) -> Option<f64> {
        let d = view.direction;
        let centre = self.centroid - view.origin;
        let (mut turns, mut first) = (0, f64::INFINITY);
        let mut a = *self.points.last()? - view.origin;
        for p in &self.points {
            let b = *p - view.origin;
            let (u, v, w) = (
                d.dot(a.cross(b)),
                d.dot(b.cross(centre)),
                d.dot(centre.cross(a)),
            );
            // half-open, so that a spoke between two triangles counts once
            let side = if u >= 0.0 && v >= 0.0 && w > 0.0 {
                1
            } else if u <= 0.0 && v < 0.0 && w <= 0.0 {
                -1
            } else {
                0
            };
            let volume = u + v + w;
            if side != 0 && volume != 0.0 {
                let at = (centre * u + a * v + b * w) / volume;
                let t = at.dot(d);
                if t > view.start {
                    turns += side;
                    first = first.min(t);
                }
            }
            a = b;
        }
        (turns != 0).then_some(first)
    }
}

/// Position on the segment, and distance, of the point nearest to `p`.
fn nearest_on_segment(p: DVec2, a: DVec2, b: DVec2) -> (f64, f64) {
    let d = b - a;
    let length = d.length_squared();
    let at = if length > 0.0 {
        ((p - a).dot(d) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (at, p.distance(a + d * at))
}

#[cfg(test)]
#[path = "picking_tests.rs"]
mod tests;
