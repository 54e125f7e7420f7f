//! Materials on the graphics card: pictures of lit spheres, looked up by the normal ("matcaps").

use wgpu::util::DeviceExt as _;

/// Side of each picture in pixels.
const SIDE: u32 = 128;
/// The pictures, in the order of [`Material`](crate::render::Material) after the plain one.
const PICTURES: [&[u8]; 4] = [
    include_bytes!("../../../assets/matcaps/clay.png"),
    include_bytes!("../../../assets/matcaps/porcelain.png"),
    include_bytes!("../../../assets/matcaps/steel.png"),
    include_bytes!("../../../assets/matcaps/jade.png"),
];

/// All materials in one texture with layers.
pub struct Materials {
    texture: wgpu::TextureView,
    sampler: wgpu::Sampler,
}

/// The layers of the texture: sRGB with opacity, row by row.
fn layers() -> Vec<u8> {
    let decode = |bytes: &&[u8]| {
        let picture = image::load_from_memory(bytes).expect("a picture of the program");
        picture.into_rgba8().into_raw()
    };
    PICTURES.iter().flat_map(decode).collect()
}

impl Materials {
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let texture = device.create_texture_with_data(
            queue,
            &wgpu::TextureDescriptor {
                label: Some("meniscus materials"),
                size: wgpu::Extent3d {
                    width: SIDE,
                    height: SIDE,
                    depth_or_array_layers: PICTURES.len() as u32,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                // the shader converts to linear light
                format: wgpu::TextureFormat::Rgba8Unorm,
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            },
            wgpu::util::TextureDataOrder::LayerMajor,
            &layers(),
        );
        Self {
            texture: texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2Array),
                ..wgpu::TextureViewDescriptor::default()
            }),
            sampler: device.create_sampler(&wgpu::SamplerDescriptor {
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..wgpu::SamplerDescriptor::default()
            }),
        }
    }

    /// The layout of a bind group whose first entry is given.
    pub fn layout_after(first: wgpu::BindGroupLayoutEntry) -> [wgpu::BindGroupLayoutEntry; 3] {
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty,
            count: None,
        };
        let texture = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2Array,
            multisampled: false,
        };
        let filtering = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        [first, entry(1, texture), entry(2, filtering)]
    }

    /// The entries of such a bind group.
    pub fn bound_after<'a>(
        &'a self,
        first: wgpu::BindGroupEntry<'a>,
    ) -> [wgpu::BindGroupEntry<'a>; 3] {
        [
            first,
            wgpu::BindGroupEntry {
                binding: 1,
                resource: wgpu::BindingResource::TextureView(&self.texture),
            },
            wgpu::BindGroupEntry {
                binding: 2,
                resource: wgpu::BindingResource::Sampler(&self.sampler),
            },
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Choice as _;
    use crate::render::Material;

    #[test]
    fn each_material_but_the_plain_one_has_a_picture() {
        assert_eq!(PICTURES.len() + 1, Material::ALL.len());
        assert_eq!(layers().len(), 4 * (SIDE * SIDE) as usize * PICTURES.len());
    }
}
