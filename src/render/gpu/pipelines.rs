//! The pipelines: shaders with their depth tests.

use super::cache::{Segment, WireSegment};
use super::images::Images;
use super::materials::Materials;
use super::shaders;
use super::target::{COLOR, DEPTH};
use super::uniforms::Frame;
use crate::render::Vertex;

pub const VERTEX: [wgpu::VertexAttribute; 8] = wgpu::vertex_attr_array![
    0 => Float32x3, 1 => Float32x3, 2 => Float32, 3 => Float32, 4 => Float32, 5 => Uint32,
    6 => Unorm8x4, 7 => Float32x2
];
pub const SEGMENT: [wgpu::VertexAttribute; 4] =
    wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x4, 3 => Float32];
const WIRE: [wgpu::VertexAttribute; 2] = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3];

/// Blending of premultiplied colours.
const OVER: wgpu::BlendState = wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING;

/// All pipelines of a scene.
pub struct Pipelines {
    pub frame_layout: wgpu::BindGroupLayout,
    pub images: Images,
    pub materials: Materials,
    pub ground: wgpu::RenderPipeline,
    pub surface: wgpu::RenderPipeline,
    pub wire: wgpu::RenderPipeline,
    pub seam: wgpu::RenderPipeline,
    pub casing: wgpu::RenderPipeline,
    pub core: wgpu::RenderPipeline,
    pub casing_on_top: wgpu::RenderPipeline,
    pub core_on_top: wgpu::RenderPipeline,
    pub hidden: wgpu::RenderPipeline,
}

/// Depth test and depth writes. Nearer points have larger depth.
#[derive(Clone, Copy)]
enum Depth {
    Ignored,
    Solid,
    InFront,
    Behind,
}

struct Maker<'a> {
    device: &'a wgpu::Device,
    module: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
    samples: u32,
}

impl Maker<'_> {
    fn make(
        &self,
        entries: [&str; 2],
        buffers: &[Option<wgpu::VertexBufferLayout<'_>>],
        topology: wgpu::PrimitiveTopology,
        depth: Depth,
    ) -> wgpu::RenderPipeline {
        let (compare, write) = match depth {
            Depth::Ignored => (wgpu::CompareFunction::Always, false),
            Depth::Solid => (wgpu::CompareFunction::GreaterEqual, true),
            Depth::InFront => (wgpu::CompareFunction::GreaterEqual, false),
            Depth::Behind => (wgpu::CompareFunction::Less, false),
        };
        self.device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(entries[1]),
                layout: Some(&self.layout),
                vertex: wgpu::VertexState {
                    module: &self.module,
                    entry_point: Some(entries[0]),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers,
                },
                primitive: wgpu::PrimitiveState {
                    topology,
                    ..wgpu::PrimitiveState::default()
                },
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: DEPTH,
                    depth_write_enabled: Some(write),
                    depth_compare: Some(compare),
                    stencil: wgpu::StencilState::default(),
                    bias: wgpu::DepthBiasState::default(),
                }),
                multisample: wgpu::MultisampleState {
                    count: self.samples,
                    ..wgpu::MultisampleState::default()
                },
                fragment: Some(wgpu::FragmentState {
                    module: &self.module,
                    entry_point: Some(entries[1]),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &[Some(wgpu::ColorTargetState {
                        format: COLOR,
                        blend: Some(OVER),
                        write_mask: wgpu::ColorWrites::ALL,
                    })],
                }),
                multiview_mask: None,
                cache: None,
            })
    }
}

impl Pipelines {
    /// The pipelines for targets with `samples` samples per pixel.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, samples: u32) -> Self {
        let frame_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("meniscus frame"),
            entries: &Materials::layout_after(wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: std::num::NonZeroU64::new(size_of::<Frame>() as u64),
                },
                count: None,
            }),
        });
        let images = Images::new(device);
        let maker = Maker {
            device,
            module: device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("meniscus scene"),
                source: wgpu::ShaderSource::Wgsl(shaders::scene().into()),
            }),
            layout: device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("meniscus scene"),
                bind_group_layouts: &[Some(&frame_layout), Some(&images.layout)],
                immediate_size: 0,
            }),
            samples,
        };
        let layout = |stride, step_mode, attributes| {
            [Some(wgpu::VertexBufferLayout {
                array_stride: stride as u64,
                step_mode,
                attributes,
            })]
        };
        let vertices = layout(
            size_of::<Vertex>(),
            wgpu::VertexStepMode::Vertex,
            &VERTEX[..],
        );
        let segments = layout(
            size_of::<Segment>(),
            wgpu::VertexStepMode::Instance,
            &SEGMENT[..],
        );
        let wire = layout(
            size_of::<WireSegment>(),
            wgpu::VertexStepMode::Instance,
            &WIRE[..],
        );
        let list = wgpu::PrimitiveTopology::TriangleList;
        let strip = wgpu::PrimitiveTopology::TriangleStrip;
        let line = |fragment, depth| maker.make(["vs_line", fragment], &segments, strip, depth);
        Self {
            ground: maker.make(["vs_ground", "fs_ground"], &[], list, Depth::Ignored),
            surface: maker.make(["vs_surface", "fs_surface"], &vertices, list, Depth::Solid),
            wire: maker.make(["vs_wire", "fs_core"], &wire, strip, Depth::InFront),
            seam: maker.make(["vs_seam", "fs_core"], &wire, strip, Depth::InFront),
            casing: line("fs_casing", Depth::InFront),
            core: line("fs_core", Depth::InFront),
            casing_on_top: line("fs_casing", Depth::Ignored),
            core_on_top: line("fs_core", Depth::Ignored),
            hidden: line("fs_hidden", Depth::Behind),
            frame_layout,
            images,
            materials: Materials::new(device, queue),
        }
    }
}
