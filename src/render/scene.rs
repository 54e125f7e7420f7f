//! The drawn scene as plain data.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::{Bounds, Image};
use crate::mesh::DVec3;
use crate::options::{Choice as _, choices};

/// A new unique number for content that is copied to the graphics card.
static NEXT_ID: AtomicU64 = AtomicU64::new(1);

pub(super) fn next_id() -> u64 {
    NEXT_ID.fetch_add(1, Ordering::Relaxed)
}

/// A vertex in the layout of the graphics card and the shaders.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Vertex {
    /// Position relative to [`Scene::centre`] in units of the file.
    pub position: [f32; 3],
    /// Unit normal of the limit surface, on the side from which faces run counter-clockwise.
    pub normal: [f32; 3],
    /// Mean curvature, negative on a sphere with outward normal.
    pub mean: f32,
    /// Gaussian curvature.
    pub gauss: f32,
    /// Signed distance along the normal from the start of the flow, or signed distance to a
    /// reference surface, depending on the flags, in units of the file.
    pub deviation: f32,
    /// Sum of the constants of [`Vertex`].
    pub flags: u32,
    /// Red, green and blue of the file (sRGB), and 255; all 0 if they are unknown.
    pub color: [u8; 4],
    /// Place in the texture image, from 0 to 1 rightwards and downwards.
    pub uv: [f32; 2],
}

impl Vertex {
    /// The vertex belongs to a face of a patch.
    pub const PATCH: u32 = 1;
    /// The flow is ill-posed here.
    pub const ILL_POSED: u32 = 2;
    /// The vertex belongs to a selected face.
    pub const SELECTED: u32 = 4;
    /// `mean` and `gauss` are known.
    pub const CURVATURE: u32 = 8;
    /// `deviation` is known, from the start of the flow.
    pub const DEVIATION: u32 = 16;
    /// `deviation` is the distance to a reference.
    pub const DISTANCE: u32 = 32;
    /// The vertex belongs to a face with a texture image.
    pub const TEXTURED: u32 = 64;
    /// The vertex belongs to a face of the newest patch.
    pub const NEWEST: u32 = 128;
}

/// Triangles to draw.
#[derive(Clone, Debug, PartialEq)]
pub struct Geometry {
    /// Unique number of the content, by which a renderer finds its copy.
    pub id: u64,
    /// Vertices.
    pub vertices: Vec<Vertex>,
    /// Corners of the triangles, counter-clockwise from the side of the normal.
    pub triangles: Vec<[u32; 3]>,
    /// Segments of the wireframe: edges of the control mesh on the drawn surface.
    pub edges: Vec<[u32; 2]>,
    /// Segments of the lines where patches join the mesh.
    pub seam: Vec<[u32; 2]>,
    /// Runs of triangles with one texture image.
    pub textures: Vec<(Range<u32>, Arc<Image>)>,
    /// Whether a vertex belongs to a patch.
    has_patch: bool,
}

impl Geometry {
    /// Geometry with a new unique number.
    pub fn new(vertices: Vec<Vertex>, triangles: Vec<[u32; 3]>, edges: Vec<[u32; 2]>) -> Self {
        Self {
            id: next_id(),
            has_patch: vertices.iter().any(|v| v.flags & Vertex::PATCH != 0),
            vertices,
            triangles,
            edges,
            seam: Vec::new(),
            textures: Vec::new(),
        }
    }

    /// Some of `faces` equal runs of triangles, with `flags` added. If drawn after the whole
    /// geometry it covers those triangles, because the corners are bit-identical.
    #[must_use]
    pub fn part(&self, places: &[usize], faces: usize, flags: u32) -> Self {
        let each = self.triangles.len() / faces.max(1);
        let mut index = std::collections::BTreeMap::new();
        let mut vertices = Vec::new();
        let triangles = places
            .iter()
            .flat_map(|&at| &self.triangles[at * each..(at + 1) * each])
            .map(|t| {
                t.map(|v| {
                    *index.entry(v).or_insert_with(|| {
                        let mut vertex = self.vertices[v as usize];
                        vertex.flags = vertex.flags & !Vertex::TEXTURED | flags;
                        vertices.push(vertex);
                        vertices.len() as u32 - 1
                    })
                })
            })
            .collect();
        Self::new(vertices, triangles, Vec::new())
    }

    /// Whether a vertex belonged to a patch when this was built.
    pub fn has_patch(&self) -> bool {
        self.has_patch
    }
}

/// The visibility of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineStyle {
    /// As [`Self::Depth`], without the dark casing.
    Thin,
    /// Visible where no surface is in front.
    Depth,
    /// Always visible.
    OnTop,
    /// Fully visible where no surface is in front, faint elsewhere.
    OnTopFaintWhenHidden,
}

/// A line through points, with a dark casing that makes it visible on any background.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyline {
    /// Position relative to [`Scene::centre`].
    pub points: Vec<[f32; 3]>,
    /// Whether the last point is joined to the first.
    pub closed: bool,
    /// Red, green, blue (sRGB) and opacity, 0 to 1.
    pub color: [f32; 4],
    /// Width of the core in pixels, without the casing on both sides.
    pub width_px: f32,
    /// The visibility.
    pub style: LineStyle,
}

/// A round marker with the casing of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Marker {
    /// Position relative to [`Scene::centre`].
    pub position: [f32; 3],
    /// Colour as in [`Polyline::color`].
    pub color: [f32; 4],
    /// Radius in pixels.
    pub radius_px: f32,
    /// The visibility.
    pub style: LineStyle,
}

/// Lines and markers, with the number of their copy on the graphics card.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlay {
    /// Unique number of the content.
    pub id: u64,
    /// Lines. Later lines cover earlier ones.
    pub lines: Vec<Polyline>,
    /// Markers. They cover the lines.
    pub markers: Vec<Marker>,
}

impl Overlay {
    /// An overlay with a new unique number.
    pub fn new(lines: Vec<Polyline>, markers: Vec<Marker>) -> Self {
        Self {
            id: next_id(),
            lines,
            markers,
        }
    }
}

/// The content of one view.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The origin of positions. It is near the surface, so that `f32` loses no digits.
    pub centre: DVec3,
    /// Bounding box of all surfaces and lines. It determines the near and far planes.
    pub bounds: Bounds,
    /// Surfaces.
    pub surfaces: Vec<Arc<Geometry>>,
    /// Groups of lines and markers in drawing order: rims, selection, hover. Separate groups make
    /// hovering cheap.
    pub overlays: Vec<Arc<Overlay>>,
}

/// The quantity shown by the colour of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ViewMode {
    /// A plain material.
    Shaded,
    /// The colours of the file.
    Color,
    /// Bands of equal `n·l`, fixed on the surface unless the light moves with the view.
    Isophotes,
    /// Reflected stripes of the environment, which move with the view.
    Zebra,
    /// Mean curvature `H`.
    Mean,
    /// Gaussian curvature `K`.
    Gauss,
    /// Larger principal curvature `H + √(H² − K)`.
    K1,
    /// Smaller principal curvature.
    K2,
    /// Distance from the start of the flow.
    Deviation,
    /// Distance to a reference surface, positive on the side of its normals.
    Distance,
}

choices!(
    ViewMode: Shaded "shaded", Color "colour", Isophotes "isophotes", Zebra "zebra", Mean "H", Gauss "K", K1 "k1",
    K2 "k2", Deviation "deviation", Distance "distance"
);

impl ViewMode {
    /// Whether the colour represents a number, which needs a legend and a range.
    pub fn is_map(self) -> bool {
        !matches!(
            self,
            Self::Shaded | Self::Color | Self::Isophotes | Self::Zebra
        )
    }

    /// The quantity of a map and its unit, for its legend.
    pub fn legend_title(self) -> String {
        let unit = match self {
            Self::Gauss => "1/unit²",
            Self::Deviation | Self::Distance => "units",
            _ => "1/unit",
        };
        format!("{}, {unit}", self.name())
    }

    /// The number shown at a vertex; `None` in modes without numbers, and if it is unknown.
    pub fn value(self, v: &Vertex) -> Option<f32> {
        let needed = match self {
            Self::Shaded | Self::Color | Self::Isophotes | Self::Zebra => return None,
            Self::Deviation => Vertex::DEVIATION,
            Self::Distance => Vertex::DISTANCE,
            _ => Vertex::CURVATURE,
        };
        let spread = (v.mean * v.mean - v.gauss).max(0.0).sqrt();
        let value = match self {
            Self::Mean => v.mean,
            Self::Gauss => v.gauss,
            Self::K1 => v.mean + spread,
            Self::K2 => v.mean - spread,
            _ => v.deviation,
        };
        (v.flags & needed != 0).then_some(value)
    }
}

/// The material of shaded surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Material {
    /// Grey under soft light from above.
    #[default]
    Plain,
    /// Matt red clay.
    Clay,
    /// Glossy white porcelain.
    Porcelain,
    /// Polished steel, whose reflections show small waves.
    Steel,
    /// Green, brighter towards its outline.
    Jade,
}

impl Material {
    /// A description.
    pub fn about(self) -> &'static str {
        match self {
            Self::Plain => "grey under soft light from above",
            Self::Clay => "matt red clay",
            Self::Porcelain => "glossy white porcelain",
            Self::Steel => "polished steel; its reflections show small waves",
            Self::Jade => "green, brighter towards its outline",
        }
    }
}

choices!(Material: Plain "plain", Clay "clay", Porcelain "porcelain", Steel "steel", Jade "jade");

/// The background.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    /// A gradient from top to bottom, sRGB, 0 to 1.
    Gradient {
        /// Colour of the upper edge.
        top: [f32; 3],
        /// Colour of the lower edge.
        bottom: [f32; 3],
    },
    /// Transparent: the picture has an alpha channel.
    Transparent,
}

impl Background {
    /// The background of the dark or light theme.
    pub fn of_theme(dark: bool) -> Self {
        if dark {
            Self::Gradient {
                top: [0.20, 0.22, 0.25],
                bottom: [0.09, 0.10, 0.12],
            }
        } else {
            Self::Gradient {
                top: [0.97, 0.975, 0.985],
                bottom: [0.82, 0.84, 0.87],
            }
        }
    }
}

/// The style of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewStyle {
    /// The quantity shown by colours.
    pub mode: ViewMode,
    /// The material of shaded surfaces.
    pub material: Material,
    /// Number of pairs of dark and light bands between `n·l = −1` and 1, or around the whole zebra
    /// environment; at least 1.
    pub stripes: u32,
    /// Rotation of the zebra lines around the line of sight in degrees; at 0 they are horizontal.
    pub zebra_turn: f64,
    /// Direction to the light of isophotes, in world coordinates or, with `light_follows_view`,
    /// in those of the camera (right, up, towards the eye).
    pub light: DVec3,
    /// Whether the light is fixed in camera coordinates.
    pub light_follows_view: bool,
    /// Whether isophotes and reflected stripes are drawn on the colours of the file.
    pub stripes_on_colors: bool,
    /// Whether the edges of the control mesh are drawn.
    pub wireframe: bool,
    /// Whether patches have a different colour and a line around them.
    pub tint_patch: bool,
    /// Whether the surface is hatched where the flow is ill-posed.
    pub show_ill_posed: bool,
    /// Whether the lines and markers of the scene are drawn.
    pub show_overlays: bool,
    /// The background.
    pub background: Background,
    /// Values at the ends of the colour map; `None` for [`super::robust_range`].
    pub range: Option<[f32; 2]>,
    /// Factor on the widths of all lines: pixels per point of the screen, or the enlargement of a
    /// picture.
    pub line_scale: f32,
}

impl ViewStyle {
    /// Whether colours of the file are drawn.
    pub fn shows_colors(&self) -> bool {
        self.mode == ViewMode::Color || self.stripes_on_colors
    }
}

impl Default for ViewStyle {
    fn default() -> Self {
        Self {
            mode: ViewMode::Shaded,
            material: Material::default(),
            stripes: 12,
            zebra_turn: 0.0,
            light: DVec3::new(0.3, 1.0, 0.5),
            light_follows_view: false,
            stripes_on_colors: false,
            wireframe: false,
            tint_patch: true,
            show_ill_posed: true,
            show_overlays: true,
            background: Background::of_theme(true),
            range: None,
            line_scale: 1.0,
        }
    }
}
