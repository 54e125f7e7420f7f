//! Drawing with wgpu: buffers on the graphics card, and the passes of a frame.
//!
//! Each view is drawn into its own textures, with reversed depth (1 near, 0 far) and four samples
//! per pixel if the device supports it. The result is kept, so that repainting an unchanged view
//! costs one copy.

mod cache;
mod composite;
mod images;
mod materials;
mod pipelines;
mod shaders;
mod target;
#[cfg(test)]
mod tests;
mod uniforms;

use std::collections::BTreeMap;
use std::sync::Arc;

use wgpu::util::DeviceExt as _;

use super::{Camera, Image, RenderError, Scene, ViewStyle};
use cache::Cache;
use composite::Composite;
use pipelines::Pipelines;
use target::Target;
use uniforms::Frame;
pub use uniforms::Tile;

/// Views that were not drawn during this many draws of other views are removed.
const IDLE: u64 = 32;

/// Draws scenes into textures and copies those into a window.
pub struct Renderer {
    pipelines: Pipelines,
    composite: Composite,
    samples: u32,
    cache: Cache,
    views: BTreeMap<u32, View>,
    draws: u64,
}

/// One of several views of the same window.
struct View {
    target: Target,
    uniforms: wgpu::Buffer,
    bind: wgpu::BindGroup,
    shown: wgpu::BindGroup,
    /// The key of the picture.
    drawn: Option<Drawn>,
    last_draw: u64,
}

/// The key of a picture: all data that it depends on.
#[derive(PartialEq)]
struct Drawn {
    frame: Frame,
    wireframe: bool,
    overlays: bool,
    ids: Vec<u64>,
}

impl Renderer {
    /// The renderer of a window of format `target_format`, with one sample per pixel and no depth.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        target_format: wgpu::TextureFormat,
    ) -> Self {
        let samples = target::supported_samples(device);
        Self {
            pipelines: Pipelines::new(device, queue, samples),
            composite: Composite::new(device, target_format),
            samples,
            cache: Cache::default(),
            views: BTreeMap::new(),
            draws: 0,
        }
    }

    /// Draws view `slot` of `size_px` pixels unless its picture is current. Returns whether it was
    /// drawn.
    ///
    /// # Errors
    /// The scene does not fit on the graphics card. The view then keeps its last picture.
    pub fn prepare(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        slot: u32,
        size_px: [u32; 2],
        scene: &Scene,
        camera: &Camera,
        style: &ViewStyle,
    ) -> Result<bool, RenderError> {
        let most = device.limits().max_texture_dimension_2d;
        let size = size_px.map(|s| s.clamp(1, most));
        let tile = Tile {
            corner: [0, 0],
            size,
        };
        self.draw(device, queue, slot, size, tile, scene, camera, style)
    }

    /// [`Self::prepare`] for a part of a picture of `size_px` pixels.
    ///
    /// # Errors
    /// As [`Self::prepare`].
    pub fn draw(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        slot: u32,
        size_px: [u32; 2],
        tile: Tile,
        scene: &Scene,
        camera: &Camera,
        style: &ViewStyle,
    ) -> Result<bool, RenderError> {
        self.draws += 1;
        let frame = Frame::new(scene, camera, style, size_px, tile);
        let ids = scene.surfaces.iter().map(|s| s.id);
        let drawn = Drawn {
            frame,
            wireframe: style.wireframe,
            overlays: style.show_overlays,
            ids: ids
                .chain(scene.overlays.iter().map(|o| o.id))
                .chain(images(scene).map(|image| image.id))
                .collect(),
        };
        self.view(device, slot, tile.size);
        if let Some(view) = self.views.get_mut(&slot) {
            view.last_draw = self.draws;
            if view.drawn.as_ref() == Some(&drawn) {
                return Ok(false);
            }
        }
        self.load(device, queue, scene, style)?;
        let Some(view) = self.views.get_mut(&slot) else {
            return Ok(false);
        };
        queue.write_buffer(&view.uniforms, 0, bytemuck::bytes_of(&frame));
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor {
            label: Some("meniscus view"),
        });
        {
            let mut pass = view.target.begin(&mut encoder);
            pass.set_bind_group(0, &view.bind, &[]);
            passes(&self.pipelines, &self.cache, &mut pass, scene, style);
        }
        queue.submit([encoder.finish()]);
        view.drawn = Some(drawn);
        self.forget();
        Ok(true)
    }

    /// Copies the picture of a view into the viewport of a pass.
    pub fn paint(&self, pass: &mut wgpu::RenderPass<'_>, slot: u32) {
        if let Some(view) = self.views.get(&slot)
            && view.drawn.is_some()
        {
            pass.set_pipeline(&self.composite.pipeline);
            pass.set_bind_group(0, &view.shown, &[]);
            pass.draw(0..3, 0..1);
        }
    }

    /// The last picture of a view: encoded sRGB, premultiplied alpha.
    pub fn picture(&self, slot: u32) -> Option<&wgpu::Texture> {
        self.views.get(&slot).map(|view| &view.target.picture)
    }

    /// Creates the textures of a view if they are missing or have another size.
    fn view(&mut self, device: &wgpu::Device, slot: u32, size: [u32; 2]) {
        if self.views.get(&slot).is_some_and(|v| v.target.size == size) {
            return;
        }
        let target = Target::new(device, size, self.samples);
        let uniforms = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("meniscus frame"),
            contents: bytemuck::bytes_of(&Frame::default()),
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        });
        let bind = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("meniscus frame"),
            layout: &self.pipelines.frame_layout,
            entries: &self.pipelines.materials.bound_after(wgpu::BindGroupEntry {
                binding: 0,
                resource: uniforms.as_entire_binding(),
            }),
        });
        let view = View {
            shown: self.composite.bind(device, &target.picture_view),
            target,
            uniforms,
            bind,
            drawn: None,
            last_draw: self.draws,
        };
        self.views.insert(slot, view);
    }

    fn load(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        scene: &Scene,
        style: &ViewStyle,
    ) -> Result<(), RenderError> {
        for image in images(scene) {
            let images = &self.pipelines.images;
            self.cache.load_image(device, queue, images, image);
        }
        for geometry in &scene.surfaces {
            self.cache.load_surface(device, geometry, style.wireframe)?;
        }
        if style.show_overlays {
            for overlay in &scene.overlays {
                self.cache.load_lines(device, overlay)?;
            }
        }
        Ok(())
    }

    /// Removes views that are no longer drawn, and content that no view shows.
    fn forget(&mut self) {
        let now = self.draws;
        self.views.retain(|_, v| now - v.last_draw < IDLE);
        let shown = self.views.values().filter_map(|v| v.drawn.as_ref());
        let used: Vec<u64> = shown.flat_map(|d| d.ids.iter().copied()).collect();
        self.cache.retain(&used);
    }
}

/// The texture images of a scene.
fn images(scene: &Scene) -> impl Iterator<Item = &Arc<Image>> {
    let runs = scene.surfaces.iter().flat_map(|s| &s.textures);
    runs.map(|(_, image)| image)
}

/// Draws background, surfaces, wireframe, seams and lines.
fn passes(
    pipelines: &Pipelines,
    cache: &Cache,
    pass: &mut wgpu::RenderPass<'_>,
    scene: &Scene,
    style: &ViewStyle,
) {
    pass.set_bind_group(1, &pipelines.images.none, &[]);
    pass.set_pipeline(&pipelines.ground);
    pass.draw(0..3, 0..1);
    let surfaces = || scene.surfaces.iter().filter_map(|s| cache.surface(s.id));
    pass.set_pipeline(&pipelines.surface);
    for geometry in &scene.surfaces {
        let Some(surface) = cache.surface(geometry.id) else {
            continue;
        };
        pass.set_vertex_buffer(0, surface.vertices.slice(..));
        pass.set_index_buffer(surface.triangles.slice(..), wgpu::IndexFormat::Uint32);
        let mut drawn = 0;
        for (run, image) in &geometry.textures {
            pass.draw_indexed(3 * drawn..3 * run.start, 0, 0..1);
            if let Some(image) = cache.image(image.id) {
                pass.set_bind_group(1, image, &[]);
            }
            pass.draw_indexed(3 * run.start..3 * run.end, 0, 0..1);
            pass.set_bind_group(1, &pipelines.images.none, &[]);
            drawn = run.end;
        }
        pass.draw_indexed(3 * drawn..surface.corners, 0, 0..1);
    }
    if style.wireframe {
        pass.set_pipeline(&pipelines.wire);
        for (wire, count) in surfaces().filter_map(cache::Surface::wire) {
            pass.set_vertex_buffer(0, wire.slice(..));
            pass.draw(0..4, 0..*count);
        }
    }
    if style.tint_patch {
        pass.set_pipeline(&pipelines.seam);
        for (seam, count) in surfaces().filter_map(cache::Surface::seam) {
            pass.set_vertex_buffer(0, seam.slice(..));
            pass.draw(0..4, 0..*count);
        }
    }
    if !style.show_overlays {
        return;
    }
    for lines in scene.overlays.iter().filter_map(|o| cache.lines(o.id)) {
        let [thin, depth, faint, top] = lines.ends;
        pass.set_vertex_buffer(0, lines.segments.slice(..));
        for (pipeline, range) in [
            (&pipelines.hidden, depth..faint),
            (&pipelines.casing, thin..faint),
            (&pipelines.core, 0..faint),
            (&pipelines.casing_on_top, faint..top),
            (&pipelines.core_on_top, faint..top),
        ] {
            if !range.is_empty() {
                pass.set_pipeline(pipeline);
                pass.draw(0..4, range);
            }
        }
    }
}
