//! The uniforms that all shaders of a frame share.

use glam::DMat4;

use crate::mesh::DVec3;
use crate::render::{Background, Camera, Scene, ViewMode, ViewStyle, robust_range};

/// Lines are moved towards the eye by this many pixels, so that they are in front of their surface
/// unless it is too steep.
const PULL: f64 = 3.0;
/// Opacity of lines behind a surface.
const FAINT: f32 = 0.32;

/// The layout of `Frame` in `shaders/frame.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Frame {
    pub clip_from_scaled: [[f32; 4]; 4],
    pub right: [f32; 4],
    pub up: [f32; 4],
    pub back: [f32; 4],
    pub eye: [f32; 4],
    pub light: [f32; 4],
    pub range: [f32; 4],
    pub size: [f32; 4],
    pub tile: [f32; 4],
    pub ground_top: [f32; 4],
    pub ground_bottom: [f32; 4],
    pub wire: [f32; 4],
    pub cut: [f32; 4],
    pub choice: [u32; 4],
}

/// A part of a picture: corner and size in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Offset from the upper left corner of the picture in pixels.
    pub corner: [u32; 2],
    /// Width and height in pixels.
    pub size: [u32; 2],
}

impl Frame {
    pub fn new(
        scene: &Scene,
        camera: &Camera,
        style: &ViewStyle,
        size: [u32; 2],
        tile: Tile,
    ) -> Self {
        let [width, height] = size.map(f64::from);
        let aspect = width / height;
        let length = scene.bounds.radius();
        let matrix = camera.view_projection(aspect, &scene.bounds, scene.centre)
            * DMat4::from_scale(DVec3::splat(length));
        let perspective = if camera.orthographic { 0.0 } else { 1.0 };
        let pixel = 2.0 * camera.half_height() / height;
        let pull = if camera.orthographic {
            PULL * pixel / length
        } else {
            PULL * pixel / camera.distance
        };
        let [near, _] = camera.near_far(&scene.bounds);
        let light = if style.mode == ViewMode::Zebra {
            let (sin, cos) = style.zebra_turn.to_radians().sin_cos();
            camera.up() * cos + camera.right() * sin
        } else if style.light_follows_view {
            camera.orientation * style.light
        } else {
            style.light
        };
        let [low, high] = range(scene, style);
        let (top, bottom) = match style.background {
            Background::Gradient { top, bottom } => (opaque(top), opaque(bottom)),
            Background::Transparent => ([0.0; 4], [0.0; 4]),
        };
        Self {
            clip_from_scaled: matrix.to_cols_array_2d().map(|c| c.map(|x| x as f32)),
            right: vector(camera.right(), 0.0),
            up: vector(camera.up(), 0.0),
            back: vector(-camera.forward(), perspective),
            eye: vector((camera.eye() - scene.centre) / length, 1.0 / length),
            light: vector(
                light.try_normalize().unwrap_or(DVec3::Z),
                f64::from(style.stripes.max(1)),
            ),
            range: [low, 1.0 / (high - low), FAINT, 0.0],
            size: [width as f32, height as f32, style.line_scale, pull as f32],
            tile: [tile.corner[0], tile.corner[1], tile.size[0], tile.size[1]].map(|x| x as f32),
            ground_top: top,
            ground_bottom: bottom,
            wire: wire(style.mode),
            // without a cut no point is beyond it
            cut: camera.cut_away().map_or([0.0, 0.0, 0.0, 1.0], |(n, d)| {
                vector(n, (d - n.dot(scene.centre)) / length)
            }),
            choice: [
                style.mode as u32,
                u32::from(style.tint_patch)
                    | u32::from(style.shows_colors()) << 1
                    | (style.material as u32) << 2,
                u32::from(style.show_ill_posed),
                if camera.orthographic {
                    0
                } else {
                    (near as f32).to_bits()
                },
            ],
        }
    }
}

/// The ends of the colour map, which differ.
fn range(scene: &Scene, style: &ViewStyle) -> [f32; 2] {
    if !style.mode.is_map() {
        return [0.0, 1.0];
    }
    let [low, high] = style
        .range
        .unwrap_or_else(|| robust_range(&scene.surfaces, style.mode));
    if low < high && low.is_finite() && high.is_finite() {
        [low, high]
    } else {
        let middle = if low.is_finite() { low } else { 0.0 };
        let half = middle.abs().max(1e-6);
        [middle - half, middle + half]
    }
}

fn wire(mode: ViewMode) -> [f32; 4] {
    // dark on the light colours of maps and materials; stronger on stripes
    let alpha = if matches!(mode, ViewMode::Isophotes | ViewMode::Zebra) {
        0.55
    } else {
        0.38
    };
    [0.05, 0.06, 0.09, alpha]
}

fn vector(v: DVec3, w: f64) -> [f32; 4] {
    [v.x, v.y, v.z, w].map(|x| x as f32)
}

fn opaque([r, g, b]: [f32; 3]) -> [f32; 4] {
    [r, g, b, 1.0]
}
