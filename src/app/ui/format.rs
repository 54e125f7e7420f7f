//! View modes and numbers in words.

use crate::render::ViewMode;
pub(crate) use crate::render::{
    field_number, format_number, grouped, long_number, short_number, trimmed,
};

/// Title and tooltip of a mode.
pub(crate) fn mode_words(mode: ViewMode) -> (&'static str, &'static str) {
    match mode {
        ViewMode::Shaded => ("Shaded", "plain material"),
        ViewMode::Color => ("Colour", "the colours of the file"),
        ViewMode::Isophotes => (
            "Isophotes",
            "bands of equal angle to the light; they have no kinks where normals are continuous",
        ),
        ViewMode::Zebra => ("Zebra", "reflected stripes that move with the view"),
        ViewMode::Mean => (
            "H",
            "mean curvature, negative on a sphere seen from outside",
        ),
        ViewMode::Gauss => ("K", "Gaussian curvature"),
        ViewMode::K1 => ("k1", "larger principal curvature"),
        ViewMode::K2 => ("k2", "smaller principal curvature"),
        ViewMode::Deviation => ("Deviation", "distance from the start surface of the flow"),
        ViewMode::Distance => (
            "Distance",
            "distance of the drawn surface to the reference mesh, positive on its outer side",
        ),
    }
}
