//! The shader texts, put together from their files.

use std::fmt::Write as _;

use crate::render::colormap::{MAP, STOPS};

const FRAME: &str = include_str!("../../../shaders/frame.wgsl");
const GROUND: &str = include_str!("../../../shaders/ground.wgsl");
const SURFACE: &str = include_str!("../../../shaders/surface.wgsl");
const LINE: &str = include_str!("../../../shaders/line.wgsl");
const COMPOSITE: &str = include_str!("../../../shaders/composite.wgsl");

/// The passes that draw a scene: one module, sharing the frame's uniforms.
pub fn scene() -> String {
    let surface = SURFACE.replace("//MAP", &map());
    [FRAME, GROUND, &surface, LINE].join("\n")
}

/// The pass that puts a picture into the window.
pub fn composite() -> &'static str {
    COMPOSITE
}

/// The colour map as constants, so that the legend and the surface cannot disagree.
fn map() -> String {
    let mut text = format!("const MAP_STOPS = {STOPS}u;\nconst MAP = array<vec3<f32>, {STOPS}>(\n");
    for [r, g, b] in MAP {
        let _ = writeln!(text, "    vec3<f32>({r:?}, {g:?}, {b:?}),");
    }
    text.push_str(");\n");
    text
}
