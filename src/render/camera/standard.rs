//! Views along the axes.

use glam::DQuat;

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

impl StandardView {
    /// All views.
    pub const ALL: [Self; 7] = [
        Self::Front,
        Self::Back,
        Self::Left,
        Self::Right,
        Self::Top,
        Self::Bottom,
        Self::Isometric,
    ];

    /// The name, as in [`Camera::parse`](super::Camera::parse).
    pub fn name(self) -> &'static str {
        match self {
            Self::Front => "front",
            Self::Back => "back",
            Self::Left => "left",
            Self::Right => "right",
            Self::Top => "top",
            Self::Bottom => "bottom",
            Self::Isometric => "iso",
        }
    }

    /// The view with a [`Self::name`].
    pub fn from_name(name: &str) -> Option<Self> {
        let named = |view: &Self| view.name().eq_ignore_ascii_case(name.trim());
        Self::ALL.into_iter().find(named)
    }

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
