//! The shader and its inputs.

use super::device::Gpu;
use bytemuck::{Pod, Zeroable};
use std::num::NonZeroU64;

/// What the shader knows of a drawn placement; laid out as `Item` in `shade.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Item {
    /// Columns.
    pub clip_from_model: [[f32; 4]; 4],
    pub light_in_model: [f32; 3],
    pub layer: u32,
    pub ambient: [f32; 3],
    pub id: u32,
    pub diffuse: [f32; 3],
    /// Of the struct, and up to the alignment that uniforms need.
    pub padding: [u32; 37],
}

/// Distance between items in their buffer, bytes.
pub(super) const ITEM_STRIDE: u32 = size_of::<Item>() as u32;
const _: () = assert!(ITEM_STRIDE == 256, "the greatest alignment that a device may ask for");

/// A vertex as the shader reads it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Vertex {
    pub position: [f32; 3],
    pub normal: [f32; 3],
    pub uv: [f32; 2],
}

/// Items of one pass.
pub(super) const ITEMS: usize = 8192;

/// sRGB that the shader encodes, with the mark in alpha.
pub(super) const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Ids.
pub(super) const ID: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
/// `NEAR / depth`.
pub(super) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// The compiled pipelines.
#[derive(Debug)]
pub(super) struct Pipelines {
    /// Marks the pixels it draws.
    pub marking: wgpu::RenderPipeline,
    /// Leaves marks alone.
    pub plain: wgpu::RenderPipeline,
    texture_layout: wgpu::BindGroupLayout,
    sampler: wgpu::Sampler,
    /// With a dynamic offset in `items`.
    pub item: wgpu::BindGroup,
    pub items: wgpu::Buffer,
}

impl Pipelines {
    pub fn new(gpu: &Gpu) -> Self {
        let device = &gpu.device;
        let items = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("items"),
            size: ITEMS as u64 * u64::from(ITEM_STRIDE),
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("bilinear"),
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let [texture_layout, item_layout] = layouts(device);
        let shader = device.create_shader_module(wgpu::include_wgsl!("shade.wgsl"));
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("placements"),
            bind_group_layouts: &[Some(&texture_layout), Some(&item_layout)],
            immediate_size: 0,
        });
        Self {
            marking: pipeline(device, &layout, &shader, wgpu::ColorWrites::ALL),
            plain: pipeline(device, &layout, &shader, wgpu::ColorWrites::COLOR),
            texture_layout,
            sampler,
            item: device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("item"),
                layout: &item_layout,
                entries: &[wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                        buffer: &items,
                        offset: 0,
                        size: NonZeroU64::new(u64::from(ITEM_STRIDE)),
                    }),
                }],
            }),
            items,
        }
    }

    /// A group for [`Pipelines`] to sample an array of textures.
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

/// Of the textures' group and the item's.
fn layouts(device: &wgpu::Device) -> [wgpu::BindGroupLayout; 2] {
    let entry = |binding, visibility, ty| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
    let texture = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: true },
        view_dimension: wgpu::TextureViewDimension::D2Array,
        multisampled: false,
    };
    let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
    let item = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: true,
        min_binding_size: None,
    };
    [
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("textures"),
            entries: &[
                entry(0, wgpu::ShaderStages::FRAGMENT, texture),
                entry(1, wgpu::ShaderStages::FRAGMENT, sampler),
            ],
        }),
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("item"),
            entries: &[entry(0, wgpu::ShaderStages::VERTEX_FRAGMENT, item)],
        }),
    ]
}

fn pipeline(
    device: &wgpu::Device,
    layout: &wgpu::PipelineLayout,
    shader: &wgpu::ShaderModule,
    color_writes: wgpu::ColorWrites,
) -> wgpu::RenderPipeline {
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("placements"),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module: shader,
            entry_point: Some("project"),
            compilation_options: Default::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: size_of::<Vertex>() as u64,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x2],
            })],
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
            entry_point: Some("shade"),
            compilation_options: Default::default(),
            targets: &[
                Some(wgpu::ColorTargetState { format: COLOR, blend: None, write_mask: color_writes }),
                Some(ID.into()),
            ],
        }),
        multiview_mask: None,
        cache: None,
    })
}
