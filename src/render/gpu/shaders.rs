//! The shader texts, assembled from files.

use std::fmt::Write as _;

use crate::render::colormap::{MAP, STOPS};

const FRAME: &str = include_str!("../../../shaders/frame.wgsl");
const GROUND: &str = include_str!("../../../shaders/ground.wgsl");
const SURFACE: &str = include_str!("../../../shaders/surface.wgsl");
const LINE: &str = include_str!("../../../shaders/line.wgsl");
const COMPOSITE: &str = include_str!("../../../shaders/composite.wgsl");

/// The module of all passes of a scene, which share the uniforms of the frame.
pub fn scene() -> String {
    let surface = SURFACE.replace("//MAP", &map());
    [FRAME, GROUND, &surface, LINE].join("\n")
}

/// The module of the pass that copies a picture into the window.
pub fn composite() -> &'static str {
    COMPOSITE
}

/// The colour map as constants, so that legend and surface have the same colours.
fn map() -> String {
    let mut text = format!("const MAP_STOPS = {STOPS}u;\nconst MAP = array<vec3<f32>, {STOPS}>(\n");
    for [r, g, b] in MAP {
        let _ = writeln!(text, "    vec3<f32>({r:?}, {g:?}, {b:?}),");
    }
    text.push_str(");\n");
    text
}
