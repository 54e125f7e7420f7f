//! Cameras as text, for the command line and files.

use glam::{DQuat, DVec2};

use super::{Camera, StandardView};
use crate::mesh::DVec3;
use crate::options::Choice;
use crate::render::Bounds;

/// The error of a text that is not a camera.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "invalid camera `{text}`: {what}. Use front, back, left, right, top, bottom or iso, or \
     px,py,pz,qx,qy,qz,qw,distance,fov,persp (or ortho): the centre of the view, a rotation, the \
     distance in units of the file, and the vertical field of view in degrees"
)]
pub struct CameraError {
    /// The text.
    pub text: String,
    /// What is wrong with it.
    pub what: String,
}

impl Camera {
    /// A text that [`Self::parse`] parses to the same picture. The centre of the view becomes the
    /// pivot.
    pub fn to_text(&self) -> String {
        let p = self.middle();
        let q = self.orientation;
        let kind = if self.orthographic { "ortho" } else { "persp" };
        format!(
            "{},{},{},{},{},{},{},{},{},{kind}",
            p.x,
            p.y,
            p.z,
            q.x,
            q.y,
            q.z,
            q.w,
            self.distance,
            // avoid the rounding of the conversion, which would change the value at every round
            // trip
            (self.fov_y.to_degrees() * 1e9).round() / 1e9
        )
    }

    /// Parses [`Self::to_text`], or the name of a standard view, which is fitted to `bounds`.
    ///
    /// # Errors
    /// The text is not a camera. The message contains the allowed forms.
    pub fn parse(text: &str, bounds: &Bounds) -> Result<Self, CameraError> {
        let error = |what: &str| CameraError {
            text: text.to_owned(),
            what: what.to_owned(),
        };
        if let Some(view) = StandardView::named(text.trim()) {
            let mut camera = Self::fit(bounds);
            camera.standard_view(view);
            return Ok(camera);
        }
        let parts: Vec<&str> = text.split(',').map(str::trim).collect();
        let [numbers @ .., kind] = &parts[..] else {
            return Err(error("it is empty"));
        };
        if numbers.is_empty() {
            return Err(error("no such view"));
        }
        let mut values = [0.0; 9];
        if numbers.len() != values.len() {
            return Err(error("it needs nine numbers and `persp` or `ortho`"));
        }
        for (value, number) in values.iter_mut().zip(numbers) {
            match number.parse::<f64>() {
                Ok(x) if x.is_finite() => *value = x,
                _ => return Err(error(&format!("`{number}` is not a number"))),
            }
        }
        let orthographic = match *kind {
            "persp" => false,
            "ortho" => true,
            _ => return Err(error("the last part is neither `persp` nor `ortho`")),
        };
        let [px, py, pz, qx, qy, qz, qw, distance, fov] = values;
        let rotation = DQuat::from_xyzw(qx, qy, qz, qw);
        if !(1e-6..1e6).contains(&rotation.length()) {
            return Err(error("the rotation is zero or too large"));
        }
        if distance <= 0.0 {
            return Err(error("the distance is not positive"));
        }
        if !(1.0..=170.0).contains(&fov) {
            return Err(error("the field of view is not from 1 to 170 degrees"));
        }
        Ok(Self {
            pivot: DVec3::new(px, py, pz),
            // do not round a normalized rotation again
            orientation: if (rotation.length() - 1.0).abs() < 1e-12 {
                rotation
            } else {
                rotation.normalize()
            },
            distance,
            offset: DVec2::ZERO,
            fov_y: fov.to_radians(),
            orthographic,
            z_up: false,
            cut: None,
        })
    }
}
