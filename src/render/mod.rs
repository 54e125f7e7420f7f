//! Drawing of surfaces, picking, and pictures. This module uses plain data and does not depend on a
//! document.
//!
//! A [`Scene`] contains [`Geometry`] and overlays of lines. [`DynamicSurface`] builds the geometry
//! of surfaces. A scene is drawn with a [`Camera`] and a [`ViewStyle`]: `ViewportCallback` draws it in a window (feature `window`),
//! [`picture`] without one, and [`sheet_picture`] draws several side by side with a legend and a caption.

mod bounds;
#[cfg(feature = "window")]
mod callback;
mod camera;
mod colormap;
mod error;
mod export;
mod gpu;
mod grid;
mod headless;
mod lettering;
mod number;
mod picking;
mod probe;
mod rims;
mod scene;
mod sheet;
mod surface;
mod textures;

pub use bounds::Bounds;
#[cfg(feature = "window")]
pub use callback::ViewportCallback;
pub use camera::{Camera, CameraError, CutPlane, StandardView};
pub use colormap::{colormap, legend_labels, robust_range};
pub use error::RenderError;
pub use export::{SequenceEnd, SequenceFormat, save_png, turntable, write_sequence};
pub use gpu::{Renderer, Tile};
pub use grid::{Grid, bar_length};
pub use headless::{Gpu, MAX_SIDE, picture};
pub use number::{field_number, format_number, grouped, long_number, short_number, trimmed};
pub use picking::{Hit, Picker, Projector};
pub use probe::{point_on_line, value_on_line};
pub use rims::rim_points;
pub use scene::{
    Background, Geometry, LineStyle, Marker, Material, Overlay, Polyline, Scene, Vertex, ViewMode,
    ViewStyle,
};
pub use sheet::{Sheet, SheetView, sheet_picture};
pub use surface::{DynamicSurface, Evaluation, SurfaceOptions};
pub use textures::{FaceTextures, Image, Textures};
