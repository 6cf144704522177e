//! The shader and its inputs.

use super::device::Gpu;
use bytemuck::{Pod, Zeroable};

/// What the shader knows of a drawn placement; see `Item` in `shade.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Item {
    /// Columns.
    pub clip_from_model: [[f32; 4]; 4],
    pub light_in_model: [f32; 3],
    /// Of the texture, texels.
    pub side: f32,
    /// Layer and batch, as bits of a surface.
    pub texture: u32,
    pub id: u32,
}

const _: () = assert!(size_of::<Item>() == 5 * 16 + 8, "as the attributes");

/// A part of a target that is shaded: the pixels of one batch.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Sheet {
    /// Lower and upper corner, clip coordinates.
    pub corners: [f32; 4],
    pub ambient: [f32; 3],
    pub diffuse: [f32; 3],
    pub batch: u32,
}

/// A vertex as the shader reads it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Vertex {
    pub position: [f32; 3],
    pub normal: [f32; 3],
    pub uv: [f32; 2],
}

/// sRGB that the shader encodes.
pub(super) const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Ids.
pub(super) const ID: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
/// What a pixel's surface is; see `Described` in `shade.wgsl`.
pub(super) const SURFACE: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Uint;
/// 1 where a tile's target is, seen or not.
pub(super) const MARK: wgpu::TextureFormat = wgpu::TextureFormat::R8Uint;
/// `NEAR / depth`.
pub(super) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// The compiled pipelines.
#[derive(Debug)]
pub(super) struct Pipelines {
    /// Marks the pixels it draws.
    pub marking: wgpu::RenderPipeline,
    /// Leaves marks alone.
    pub plain: wgpu::RenderPipeline,
    /// Turns surfaces into colours.
    pub shading: wgpu::RenderPipeline,
    surface_layout: wgpu::BindGroupLayout,
    texture_layout: wgpu::BindGroupLayout,
    sampler: wgpu::Sampler,
}

impl Pipelines {
    pub fn new(gpu: &Gpu) -> Self {
        let device = &gpu.device;
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("bilinear"),
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let [surface_layout, texture_layout] = layouts(device);
        let shader = device.create_shader_module(wgpu::include_wgsl!("shade.wgsl"));
        Self {
            marking: describing(device, &shader, wgpu::ColorWrites::ALL),
            plain: describing(device, &shader, wgpu::ColorWrites::empty()),
            shading: shading(device, &[Some(&surface_layout), Some(&texture_layout)], &shader),
            surface_layout,
            texture_layout,
            sampler,
        }
    }

    /// A group for [`shading`](Self::shading) to read surfaces.
    pub fn bind_surfaces(&self, gpu: &Gpu, surfaces: &wgpu::Texture) -> wgpu::BindGroup {
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("surfaces"),
            layout: &self.surface_layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(&surfaces.create_view(&Default::default())),
            }],
        })
    }

    /// A group for [`shading`](Self::shading) to sample an array of textures.
    pub fn bind_textures(&self, gpu: &Gpu, array: &wgpu::Texture) -> wgpu::BindGroup {
        let array = array.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("textures"),
            layout: &self.texture_layout,
            entries: &[
                entry(0, wgpu::BindingResource::TextureView(&array)),
                entry(1, wgpu::BindingResource::Sampler(&self.sampler)),
            ],
        })
    }
}

/// Of the surfaces' group and the textures'.
fn layouts(device: &wgpu::Device) -> [wgpu::BindGroupLayout; 2] {
    let entry = |binding, visibility, ty| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
    let texture = |sample_type, view_dimension| wgpu::BindingType::Texture {
        sample_type,
        view_dimension,
        multisampled: false,
    };
    let colors =
        texture(wgpu::TextureSampleType::Float { filterable: true }, wgpu::TextureViewDimension::D2Array);
    let surfaces = texture(wgpu::TextureSampleType::Uint, wgpu::TextureViewDimension::D2);
    let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
    let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
    };
    let fragment = wgpu::ShaderStages::FRAGMENT;
    [
        layout("surfaces", &[entry(0, fragment, surfaces)]),
        layout("textures", &[entry(0, fragment, colors), entry(1, fragment, sampler)]),
    ]
}

fn describing(
    device: &wgpu::Device,
    shader: &wgpu::ShaderModule,
    marks: wgpu::ColorWrites,
) -> wgpu::RenderPipeline {
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("describing"),
        bind_group_layouts: &[],
        immediate_size: 0,
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("describing"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: shader,
            entry_point: Some("project"),
            compilation_options: Default::default(),
            buffers: &[
                Some(wgpu::VertexBufferLayout {
                    array_stride: size_of::<Vertex>() as u64,
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x2],
                }),
                Some(wgpu::VertexBufferLayout {
                    array_stride: size_of::<Item>() as u64,
                    step_mode: wgpu::VertexStepMode::Instance,
                    attributes: &wgpu::vertex_attr_array![
                        3 => Float32x4, 4 => Float32x4, 5 => Float32x4, 6 => Float32x4, 7 => Float32x4, 8 => Uint32x2
                    ],
                }),
            ],
        },
        primitive: wgpu::PrimitiveState {
            front_face: wgpu::FrontFace::Ccw,
            cull_mode: Some(wgpu::Face::Back),
            ..Default::default()
        },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: shader,
            entry_point: Some("describe"),
            compilation_options: Default::default(),
            targets: &[
                Some(SURFACE.into()),
                Some(ID.into()),
                Some(wgpu::ColorTargetState { format: MARK, blend: None, write_mask: marks }),
            ],
        }),
        multiview_mask: None,
        cache: None,
    })
}

fn shading(
    device: &wgpu::Device,
    layouts: &[Option<&wgpu::BindGroupLayout>],
    shader: &wgpu::ShaderModule,
) -> wgpu::RenderPipeline {
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("shading"),
        bind_group_layouts: layouts,
        immediate_size: 0,
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("shading"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: shader,
            entry_point: Some("cover"),
            compilation_options: Default::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: size_of::<Sheet>() as u64,
                step_mode: wgpu::VertexStepMode::Instance,
                attributes: &wgpu::vertex_attr_array![0 => Float32x4, 1 => Float32x3, 2 => Float32x3, 3 => Uint32],
            })],
        },
        primitive: Default::default(),
        // Only where something was drawn.
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(false),
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: shader,
            entry_point: Some("shade"),
            compilation_options: Default::default(),
            targets: &[Some(COLOR.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
