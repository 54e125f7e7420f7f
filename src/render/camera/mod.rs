//! The camera and its movement by the mouse.
//!
//! World coordinates are those of the file; `y` or `z` points up in the standard views. All values
//! are `f64`. The graphics card gets coordinates relative to a centre near the surface.

mod cut;
mod standard;
#[cfg(test)]
mod tests;
mod text;

use glam::{DMat4, DQuat, DVec2, DVec4};

use super::Bounds;
use crate::mesh::DVec3;
pub use cut::CutPlane;
pub use standard::StandardView;
pub use text::CameraError;

/// Relative margin around a fitted object.
const MARGIN: f64 = 1.08;
/// Minimum distance of the near plane, as a fraction of that of the far plane.
const NEAR_OVER_FAR: f64 = 1e-5;

/// A view of the world.
///
/// The camera looks along `forward` at the plane through `pivot`. It rotates around the pivot,
/// which may be anywhere in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The centre of rotation.
    pub pivot: DVec3,
    /// The rotation from camera axes (right `x`, up `y`, backward `z`) to world axes.
    pub orientation: DQuat,
    /// Depth of the pivot in front of the eye in units of the file.
    pub distance: f64,
    /// Offset of the pivot from the centre of the picture, to the right and up, in units of the
    /// file.
    pub offset: DVec2,
    /// Vertical field of view in radians. A parallel projection shows the same height at the depth
    /// of the pivot.
    pub fov_y: f64,
    /// Whether the projection is parallel instead of perspective.
    pub orthographic: bool,
    /// Whether `z` instead of `y` is the vertical axis of standard views and the turntable.
    pub z_up: bool,
    /// A plane whose side towards the eye is hidden.
    pub cut: Option<CutPlane>,
}

impl Camera {
    /// A view of all of `bounds` from the front, slightly from the right and above.
    pub fn fit(bounds: &Bounds) -> Self {
        let mut camera = Self {
            pivot: DVec3::ZERO,
            orientation: DQuat::IDENTITY,
            distance: 1.0,
            offset: DVec2::ZERO,
            fov_y: 35f64.to_radians(),
            orthographic: false,
            z_up: false,
            cut: None,
        };
        camera.home();
        camera.fit_to(bounds);
        camera
    }

    /// Rotates to a view from the front, slightly from the right and above.
    pub fn home(&mut self) {
        let turn = DQuat::from_rotation_y(0.5) * DQuat::from_rotation_x(-0.35);
        self.orientation = self.upright() * turn;
    }

    /// The rotation from a world with `y` up into this one.
    fn upright(&self) -> DQuat {
        if self.z_up {
            DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2)
        } else {
            DQuat::IDENTITY
        }
    }

    /// Moves the camera so that a square picture shows all of `bounds`, with the pivot at its
    /// centre. The orientation does not change.
    pub fn fit_to(&mut self, bounds: &Bounds) {
        self.fit_aspect(bounds, 1.0);
    }

    /// [`Self::fit_to`] for a picture `aspect` times as wide as high.
    pub fn fit_aspect(&mut self, bounds: &Bounds, aspect: f64) {
        self.pivot = bounds.centre();
        self.offset = DVec2::ZERO;
        let t = self.tan_half();
        // the smaller side limits the visible angle of the sphere
        let smaller = t * aspect.min(1.0);
        let sphere = if self.orthographic {
            bounds.radius() / smaller
        } else {
            bounds.radius() / smaller.atan().sin()
        };
        // each corner must be inside both pairs of sides
        let box_distance = (0..8)
            .map(|i| {
                let end = |k: usize| {
                    if i >> k & 1 == 0 {
                        bounds.low[k]
                    } else {
                        bounds.high[k]
                    }
                };
                let p = DVec3::new(end(0), end(1), end(2)) - self.pivot;
                let towards_eye = if self.orthographic {
                    0.0
                } else {
                    -p.dot(self.forward())
                };
                let [x, y] = [p.dot(self.right()).abs(), p.dot(self.up()).abs()];
                towards_eye + (x / aspect).max(y) / t
            })
            .fold(0.0, f64::max);
        let distance = if box_distance > 0.0 {
            sphere.min(box_distance)
        } else {
            sphere
        };
        self.distance = MARGIN * distance;
    }

    /// Rotates around the pivot as if the mouse dragged the surface: `dx` to the right and `dy`
    /// downwards, in radians. On a turntable the vertical axis of the world stays vertical in the
    /// picture.
    pub fn orbit(&mut self, dx: f64, dy: f64, turntable: bool) {
        let about_right = DQuat::from_rotation_x(-dy);
        let turned = if turntable {
            // upside down the rotation is reversed, so that the surface follows the mouse
            let vertical = self.vertical();
            let side = if self.up().dot(vertical) < 0.0 {
                -1.0
            } else {
                1.0
            };
            DQuat::from_axis_angle(vertical, -side * dx) * self.orientation * about_right
        } else {
            self.orientation * DQuat::from_rotation_y(-dx) * about_right
        };
        self.orientation = turned.normalize();
    }

    /// Pans by pixels to the right and down in a viewport of height `height_px`. Points at the
    /// depth of the pivot follow the mouse exactly.
    pub fn pan(&mut self, dx_px: f64, dy_px: f64, height_px: f64) {
        let unit = 2.0 * self.half_height() / height_px.max(1.0);
        let to = self.right() * (dx_px * unit) - self.up() * (dy_px * unit);
        self.pivot -= to;
    }

    /// Zooms by `factor` (above 1: closer). The point of the pivot's plane under the cursor does
    /// not move in the picture.
    pub fn zoom_to(&mut self, factor: f64, cursor_ndc: [f64; 2], aspect: f64) {
        if !(factor.is_finite() && factor > 0.0) {
            return;
        }
        let cursor = DVec2::new(cursor_ndc[0] * aspect, cursor_ndc[1]) * self.half_height();
        // The eye moves along the ray of the cursor. The pivot moves with it, so that its position
        // in the picture does not change.
        let middle = self.middle();
        let fixed = middle + self.right() * cursor.x + self.up() * cursor.y;
        self.offset /= factor;
        self.distance /= factor;
        let middle = fixed + (middle - fixed) / factor;
        self.pivot = middle + self.right() * self.offset.x + self.up() * self.offset.y;
    }

    /// Zooms by `factor` like [`Self::zoom_to`], towards the point of the surface under the cursor, which becomes
    /// the pivot. The pivot comes no nearer to the eye than `nearest`, so the eye stays in front of the surface.
    pub fn zoom_towards(
        &mut self,
        point: Option<DVec3>,
        factor: f64,
        nearest: f64,
        cursor_ndc: [f64; 2],
        aspect: f64,
    ) {
        if let Some(point) = point {
            self.set_pivot(point);
        }
        let most = (self.distance / nearest).max(1.0);
        self.zoom_to(factor.clamp(0.0, most), cursor_ndc, aspect);
    }

    /// Sets the pivot without changing the picture. Ignores a point behind the eye.
    pub fn set_pivot(&mut self, point: DVec3) {
        let seen = point - self.eye();
        let depth = seen.dot(self.forward());
        if !point.is_finite() || (!self.orthographic && depth <= 0.0) {
            return;
        }
        self.offset = DVec2::new(seen.dot(self.right()), seen.dot(self.up()));
        self.pivot = point;
        if !self.orthographic {
            self.distance = depth;
        }
    }

    /// Shows everything of a picture `aspect` times as wide as high in a picture with another ratio,
    /// from the same eye.
    pub fn keep_width(&mut self, aspect: f64, other: f64) {
        let factor = (aspect / other).max(1.0);
        self.fov_y = 2.0 * (factor * self.tan_half()).atan();
    }

    /// Rotates around the pivot to a standard view.
    pub fn standard_view(&mut self, view: StandardView) {
        self.orientation = (self.upright() * view.orientation()).normalize();
    }

    /// The vertical axis of the world.
    pub fn vertical(&self) -> DVec3 {
        if self.z_up { DVec3::Z } else { DVec3::Y }
    }

    /// The position of the eye.
    pub fn eye(&self) -> DVec3 {
        self.middle() - self.forward() * self.distance
    }

    /// The point at the centre of the picture and the depth of the pivot.
    fn middle(&self) -> DVec3 {
        self.pivot - self.right() * self.offset.x - self.up() * self.offset.y
    }

    /// Unit vector to the right in the picture.
    pub fn right(&self) -> DVec3 {
        self.orientation * DVec3::X
    }

    /// Unit vector upwards in the picture.
    pub fn up(&self) -> DVec3 {
        self.orientation * DVec3::Y
    }

    /// Unit vector into the picture.
    pub fn forward(&self) -> DVec3 {
        self.orientation * DVec3::NEG_Z
    }

    fn tan_half(&self) -> f64 {
        (0.5 * self.fov_y).tan()
    }

    /// Half the visible height at the depth of the pivot in units of the file.
    pub fn half_height(&self) -> f64 {
        self.distance * self.tan_half()
    }

    /// Depths of the near and far plane, which enclose a sphere around `bounds`. The near depth is
    /// positive in perspective.
    pub fn near_far(&self, bounds: &Bounds) -> [f64; 2] {
        let depth = (bounds.centre() - self.eye()).dot(self.forward());
        let reach = 1.01 * bounds.radius();
        let (near, far) = (depth - reach, depth + reach);
        if self.orthographic {
            return [near, far];
        }
        // nothing is in front of the eye, so any depths are valid
        let far = if far > 0.0 { far } else { self.distance };
        [near.max(NEAR_OVER_FAR * far), far]
    }

    /// The matrix from positions relative to `centre` to the clip space of wgpu. Depth is reversed:
    /// 1 at the near plane, 0 at the far plane, both determined by `bounds`.
    pub fn view_projection(&self, aspect: f64, bounds: &Bounds, centre: DVec3) -> DMat4 {
        let [near, far] = self.near_far(bounds);
        let view = DMat4::from_quat(self.orientation.inverse())
            * DMat4::from_translation(centre - self.eye());
        let projection = if self.orthographic {
            let h = self.half_height();
            let scale = DVec4::new(1.0 / (h * aspect), 1.0 / h, 1.0 / (far - near), 1.0);
            let mut m = DMat4::from_diagonal(scale);
            // depth d = -z: 1 at near, 0 at far
            m.w_axis.z = far / (far - near);
            m
        } else {
            let t = self.tan_half();
            DMat4::from_cols(
                DVec4::X / (t * aspect),
                DVec4::Y / t,
                DVec4::new(0.0, 0.0, near / (far - near), -1.0),
                DVec4::new(0.0, 0.0, near * far / (far - near), 0.0),
            )
        };
        projection * view
    }

    /// The line of sight through a point of the picture (`ndc` from −1 at the left and bottom to
    /// 1): origin in the plane of the eye, and unit direction. In a parallel projection the line
    /// continues behind its origin.
    pub fn ray(&self, ndc: [f64; 2], aspect: f64) -> (DVec3, DVec3) {
        let at = DVec2::new(ndc[0] * aspect, ndc[1]) * self.tan_half();
        let sideways = self.right() * at.x + self.up() * at.y;
        if self.orthographic {
            (self.eye() + sideways * self.distance, self.forward())
        } else {
            (self.eye(), (self.forward() + sideways).normalize())
        }
    }

    /// The position of a point in the picture, −1 to 1 inside it; `None` behind the eye.
    pub fn project(&self, point: DVec3, aspect: f64) -> Option<[f64; 2]> {
        let seen = point - self.eye();
        let depth = seen.dot(self.forward());
        let half = if self.orthographic {
            self.half_height()
        } else if depth > 0.0 {
            depth * self.tan_half()
        } else {
            return None;
        };
        let [x, y] = [seen.dot(self.right()), seen.dot(self.up())];
        Some([x / (half * aspect), y / half])
    }
}
