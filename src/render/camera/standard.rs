//! Views along the axes.

use glam::DQuat;

use crate::options::choices;

/// Views along the axes, named for `y` up. With `z` up the front view is from −y.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StandardView {
    /// From +z.
    Front,
    /// From −z.
    Back,
    /// From −x.
    Left,
    /// From +x.
    Right,
    /// From +y, with −z up.
    Top,
    /// From −y, with +z up.
    Bottom,
    /// From (1, 1, 1).
    Isometric,
}

choices!(
    StandardView: Front "front", Back "back", Left "left", Right "right", Top "top",
    Bottom "bottom", Isometric "iso"
);

impl StandardView {
    pub(super) fn orientation(self) -> DQuat {
        use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
        match self {
            Self::Front => DQuat::IDENTITY,
            Self::Back => DQuat::from_rotation_y(PI),
            Self::Left => DQuat::from_rotation_y(-FRAC_PI_2),
            Self::Right => DQuat::from_rotation_y(FRAC_PI_2),
            Self::Top => DQuat::from_rotation_x(-FRAC_PI_2),
            Self::Bottom => DQuat::from_rotation_x(FRAC_PI_2),
            Self::Isometric => {
                let down = 0.5f64.sqrt().atan();
                DQuat::from_rotation_y(FRAC_PI_4) * DQuat::from_rotation_x(-down)
            }
        }
    }
}
