//! Pictures of meshes for the commands.

use std::sync::Arc;

use anyhow::Result;

use crate::cli::UsageError;
use crate::cli::picture_args::{PictureArguments, Up};
use crate::cli::print::say;
use crate::io::materials;
use crate::mesh::{BoundaryLoop, DVec3, FaceId, Material, Mesh, VertexId, boundary_loops, grow};
use crate::options::Choice;
use crate::render::{
    self, Background, Bounds, Camera, CutPlane, DynamicSurface, Evaluation, Geometry, Gpu, Grid,
    LineStyle, Overlay, Polyline, Scene, Sheet, SheetView, StandardView, SurfaceOptions, Textures,
    Vertex, ViewMode, ViewStyle, bar_length, rim_points,
};

/// Default size of a picture.
const SIZE: [u32; 2] = [1280, 960];
/// Picture height at which line widths are in pixels.
const LINE_HEIGHT: f32 = 960.0;
/// Rings of faces around patches that are drawn as finely as the patches.
const FINE_RINGS: usize = 4;
/// Meshes with at most this many faces are drawn finely everywhere.
const SMALL: usize = 20_000;
/// Colour of the lines along rims. Their dark casing makes them visible on any background.
const RIM_COLOR: [f32; 4] = [1.0, 0.78, 0.10, 1.0];

/// The scene and settings of a picture, without the graphics device.
pub struct Shot {
    scene: Scene,
    style: ViewStyle,
    /// The camera.
    pub camera: Camera,
    sheet: Sheet,
}

impl Shot {
    /// Prepares pictures of a mesh whose faces from `first_patch_face` on are patches; `creases` are
    /// the edges where patches were joined without continuous normals.
    pub fn new(
        mesh: &Mesh,
        first_patch_face: usize,
        creases: Vec<[VertexId; 2]>,
        look: &PictureArguments,
    ) -> Result<Self> {
        let bounds = Bounds::of(mesh.positions.iter().copied()).unwrap_or_default();
        let sheet = Sheet {
            size: look.size.unwrap_or(SIZE),
            transparent: look.transparent,
            legend: look.legend,
            caption: look.caption.clone().unwrap_or_default(),
        };
        let all = &mesh.attributes;
        let materials = if look.view.is_none_or(|view| view == ViewMode::Color) {
            materials(all)
        } else {
            Vec::new()
        };
        let has_images = materials.iter().any(|material| material.image.is_some());
        let style = style(look, all.has_colors() || has_images, sheet.size);
        let centre = bounds.centre();
        let limit = !look.control_mesh;
        let surfaces = surfaces(
            mesh,
            materials,
            first_patch_face,
            creases,
            centre,
            limit,
            &style,
        );
        let rims = look.rims.then(|| Arc::new(rims(mesh, centre, limit)));
        let size = sheet.view_size(&surfaces, &style, 1);
        let mut camera = camera(look, &bounds, size)?;
        camera.cut = look.cut.map(|plane| CutPlane {
            point: plane.point,
            normal: plane.normal,
        });
        let step = bar_length(&camera, size.map(f64::from), f64::from(style.line_scale));
        let grid = step
            .filter(|_| look.grid)
            .and_then(|step| Grid::new(&bounds, &camera, step));
        let lines = grid.map(|grid| Arc::new(grid.overlay(centre)));
        Ok(Self {
            camera,
            scene: Scene {
                centre,
                bounds: grid.map_or(bounds, |grid| grid.around(bounds)),
                surfaces,
                overlays: lines.into_iter().chain(rims).collect(),
            },
            style,
            sheet,
        })
    }

    /// Draws the picture from a camera.
    pub fn take(
        &self,
        gpu: &Gpu,
        camera: &Camera,
    ) -> Result<image::RgbaImage, render::RenderError> {
        let view = SheetView {
            scene: &self.scene,
            title: "",
        };
        render::sheet_picture(gpu, &self.sheet, &[view], camera, &self.style)
    }
}

fn style(look: &PictureArguments, has_colors: bool, [_, height]: [u32; 2]) -> ViewStyle {
    let default = ViewStyle::default();
    ViewStyle {
        mode: look.view.unwrap_or(if has_colors {
            ViewMode::Color
        } else {
            ViewMode::Shaded
        }),
        material: look.material.unwrap_or_default(),
        stripes: look.stripes.unwrap_or(default.stripes),
        light: look.light.unwrap_or(default.light),
        wireframe: look.wireframe,
        tint_patch: !look.no_tint,
        background: Background::of_theme(look.dark),
        range: look.range,
        line_scale: (height as f32 / LINE_HEIGHT).max(1.0),
        ..default
    }
}

fn camera(look: &PictureArguments, bounds: &Bounds, [w, h]: [u32; 2]) -> Result<Camera> {
    let mut camera = Camera::fit(bounds);
    camera.orthographic = look.orthographic;
    camera.z_up = look.up == Some(Up::Z);
    camera.home();
    if let Some(text) = &look.camera {
        if let Some(view) = StandardView::named(text.trim()) {
            camera.standard_view(view);
        } else {
            let exact = Camera::parse(text, bounds);
            let mut exact = exact.map_err(|e| UsageError(format!("--camera: {e}")))?;
            exact.orthographic |= look.orthographic;
            exact.z_up = camera.z_up;
            return Ok(exact);
        }
    }
    camera.fit_aspect(bounds, f64::from(w) / f64::from(h));
    Ok(camera)
}

/// The geometry: patches and the faces around them finely, the rest with one vertex per mesh
/// vertex.
fn surfaces(
    mesh: &Mesh,
    materials: Vec<Material>,
    first_patch_face: usize,
    creases: Vec<[VertexId; 2]>,
    centre: DVec3,
    limit: bool,
    style: &ViewStyle,
) -> Vec<Arc<Geometry>> {
    let fine = around_patches(mesh, first_patch_face);
    let faces = |wanted: bool| -> Vec<FaceId> {
        let chosen = (0..fine.len()).filter(|&f| fine[f] == wanted);
        chosen.map(FaceId::from).collect()
    };
    let (moving, rest) = (faces(true), faces(false));
    let (materials, colors, face_colors) = if style.shows_colors() {
        (materials, mesh.colors(), mesh.attributes.face_colors())
    } else {
        Default::default()
    };
    let face_colors = Arc::new(face_colors);
    let (textures, notes) = Textures::read(&materials);
    for note in notes {
        say(&note);
    }
    let textures = (!textures.is_empty()).then(|| Arc::new(textures.of_faces(mesh)));
    let flag = |f: &FaceId| {
        if f.index() >= first_patch_face {
            Vertex::PATCH
        } else {
            0
        }
    };
    let options = SurfaceOptions {
        creases,
        flags: moving.iter().map(flag).collect(),
        textures: textures.clone(),
        face_colors: Arc::clone(&face_colors),
        ..SurfaceOptions::default()
    };
    let near = DynamicSurface::new(&mesh.topology, &moving, &options);
    let coarse = SurfaceOptions {
        samples_per_edge: Some(1),
        textures,
        face_colors,
        ..SurfaceOptions::default()
    };
    let far = DynamicSurface::new(&mesh.topology, &rest, &coarse);
    let evaluation = Evaluation {
        centre,
        limit,
        colors: &colors,
        ..Evaluation::default()
    };
    [near, far]
        .map(|surface| Arc::new(surface.evaluate_with(&mesh.positions, &evaluation)))
        .into()
}

/// Flags the faces of patches and of the rings around them. All faces are flagged if the mesh is
/// small or has no patch.
fn around_patches(mesh: &Mesh, first_patch_face: usize) -> Vec<bool> {
    let faces = mesh.face_count();
    if faces <= SMALL || first_patch_face >= faces {
        return vec![true; faces];
    }
    let mut fine: Vec<bool> = (0..faces).map(|f| f >= first_patch_face).collect();
    for _ in 0..FINE_RINGS {
        grow(&mesh.topology, &mut fine);
    }
    fine
}

fn rims(mesh: &Mesh, centre: DVec3, limit: bool) -> Overlay {
    let line = |one: &BoundaryLoop| Polyline {
        points: rim_points(&mesh.topology, &mesh.positions, one, centre, limit),
        closed: true,
        color: RIM_COLOR,
        width_px: 2.5,
        style: LineStyle::OnTopFaintWhenHidden,
    };
    Overlay::new(boundary_loops(mesh).iter().map(line).collect(), Vec::new())
}
