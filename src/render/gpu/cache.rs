//! Copies of geometry and lines on the graphics card, kept while a view shows them.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use wgpu::util::DeviceExt as _;

use super::images::Images;
use crate::render::{Geometry, Image, LineStyle, Overlay, RenderError};

/// A segment of a line in the layout of the graphics card.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Segment {
    pub start: [f32; 3],
    pub end: [f32; 3],
    pub color: [f32; 4],
    pub width: f32,
}

/// The two ends of a segment of a wireframe.
pub type WireSegment = [[f32; 3]; 2];

/// Buffers of a [`Geometry`].
pub struct Surface {
    pub vertices: wgpu::Buffer,
    pub triangles: wgpu::Buffer,
    pub corners: u32,
    wire: Option<Segments>,
    seam: Option<Segments>,
}

/// Segments and their number.
type Segments = (wgpu::Buffer, u32);

/// Segments of an [`Overlay`], by style.
pub struct Lines {
    pub segments: wgpu::Buffer,
    /// Ends of the ranges drawn with depth test without and with casing, faintly when hidden, and
    /// always.
    pub ends: [u32; 4],
}

/// The buffers on the graphics card, by content number.
#[derive(Default)]
pub struct Cache {
    surfaces: BTreeMap<u64, Option<Surface>>,
    lines: BTreeMap<u64, Option<Lines>>,
    images: BTreeMap<u64, wgpu::BindGroup>,
}

impl Cache {
    /// The buffers of a surface, if it has any triangles; they must have been loaded.
    pub fn surface(&self, id: u64) -> Option<&Surface> {
        self.surfaces.get(&id)?.as_ref()
    }

    /// The buffers of an overlay, if it has any segments; they must have been loaded.
    pub fn lines(&self, id: u64) -> Option<&Lines> {
        self.lines.get(&id)?.as_ref()
    }

    /// The bind group of an image; it must have been loaded.
    pub fn image(&self, id: u64) -> Option<&wgpu::BindGroup> {
        self.images.get(&id)
    }

    /// Loads a texture image.
    pub fn load_image(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        images: &Images,
        image: &Image,
    ) {
        let load = || images.bind(device, queue, image);
        self.images.entry(image.id).or_insert_with(load);
    }

    /// Loads a surface with its seams, and with its wireframe if requested.
    pub fn load_surface(
        &mut self,
        device: &wgpu::Device,
        geometry: &Geometry,
        wire: bool,
    ) -> Result<(), RenderError> {
        if let Entry::Vacant(place) = self.surfaces.entry(geometry.id) {
            let surface = if geometry.triangles.is_empty() {
                None
            } else {
                Some(Surface {
                    vertices: buffer(device, &geometry.vertices, wgpu::BufferUsages::VERTEX)?,
                    triangles: buffer(device, &geometry.triangles, wgpu::BufferUsages::INDEX)?,
                    corners: 3 * geometry.triangles.len() as u32,
                    wire: None,
                    seam: wire_segments(device, geometry, &geometry.seam)?,
                })
            };
            place.insert(surface);
        }
        if let Some(Some(surface)) = self.surfaces.get_mut(&geometry.id)
            && wire
            && surface.wire.is_none()
        {
            surface.wire = wire_segments(device, geometry, &geometry.edges)?;
        }
        Ok(())
    }

    /// Loads the lines of an overlay.
    pub fn load_lines(
        &mut self,
        device: &wgpu::Device,
        overlay: &Overlay,
    ) -> Result<(), RenderError> {
        if let Entry::Vacant(place) = self.lines.entry(overlay.id) {
            let (segments, ends) = segments(overlay);
            let lines = if segments.is_empty() {
                None
            } else {
                Some(Lines {
                    segments: buffer(device, &segments, wgpu::BufferUsages::VERTEX)?,
                    ends,
                })
            };
            place.insert(lines);
        }
        Ok(())
    }

    /// Removes all content whose number is not listed.
    pub fn retain(&mut self, used: &[u64]) {
        self.surfaces.retain(|id, _| used.contains(id));
        self.lines.retain(|id, _| used.contains(id));
        self.images.retain(|id, _| used.contains(id));
    }
}

impl Surface {
    /// The wireframe, once loaded.
    pub fn wire(&self) -> Option<&Segments> {
        self.wire.as_ref()
    }

    /// The seams of patches.
    pub fn seam(&self) -> Option<&Segments> {
        self.seam.as_ref()
    }
}

/// The segments between some vertices of a geometry, if there are any.
fn wire_segments(
    device: &wgpu::Device,
    geometry: &Geometry,
    ends: &[[u32; 2]],
) -> Result<Option<Segments>, RenderError> {
    if ends.is_empty() {
        return Ok(None);
    }
    let at = |v: u32| geometry.vertices[v as usize].position;
    let segments: Vec<WireSegment> = ends.iter().map(|e| e.map(at)).collect();
    let copy = buffer(device, &segments, wgpu::BufferUsages::VERTEX)?;
    Ok(Some((copy, segments.len() as u32)))
}

/// All segments of an overlay, sorted by style, and the end of each style.
fn segments(overlay: &Overlay) -> (Vec<Segment>, [u32; 4]) {
    let mut out = Vec::new();
    let styles = [
        LineStyle::Thin,
        LineStyle::Depth,
        LineStyle::OnTopFaintWhenHidden,
        LineStyle::OnTop,
    ];
    let ends = styles.map(|style| {
        for line in overlay.lines.iter().filter(|l| l.style == style) {
            let segment = |start: [f32; 3], end: [f32; 3]| Segment {
                start,
                end,
                color: line.color,
                width: line.width_px,
            };
            out.extend(line.points.windows(2).map(|w| segment(w[0], w[1])));
            if let [first, .., last] = line.points[..]
                && line.closed
            {
                out.push(segment(last, first));
            }
        }
        for marker in overlay.markers.iter().filter(|m| m.style == style) {
            out.push(Segment {
                start: marker.position,
                end: marker.position,
                color: marker.color,
                width: 2.0 * marker.radius_px,
            });
        }
        out.len() as u32
    });
    (out, ends)
}

fn buffer<T: bytemuck::Pod>(
    device: &wgpu::Device,
    data: &[T],
    usage: wgpu::BufferUsages,
) -> Result<wgpu::Buffer, RenderError> {
    let needed = size_of_val(data) as u64;
    let allowed = device.limits().max_buffer_size;
    if needed > allowed {
        return Err(RenderError::TooLarge { needed, allowed });
    }
    let contents = bytemuck::cast_slice(data);
    Ok(
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("meniscus geometry"),
            contents,
            usage,
        }),
    )
}
