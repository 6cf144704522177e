//! The models that are on the device.

use super::device::Gpu;
use super::pipeline::Vertex;
use crate::model::Model;
use crate::texture::TEXTURE_SIDE;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

/// Models that fit at once: the number of texture layers that every device has.
const LAYERS: u32 = 256;
const VERTICES: u32 = 1 << 18;
const INDICES: u32 = 1 << 20;

/// Where a model lies on the device.
#[derive(Clone, Debug)]
pub(super) struct Resident {
    pub layer: u32,
    pub first_vertex: u32,
    pub indices: Range<u32>,
}

/// Meshes in two buffers and textures in an array, filled up and then emptied as a whole.
#[derive(Debug)]
pub(super) struct Residency {
    pub vertices: wgpu::Buffer,
    pub indices: wgpu::Buffer,
    pub textures: wgpu::Texture,
    used_vertices: u32,
    used_indices: u32,
    /// By address, which the kept handle reserves.
    models: HashMap<usize, (Arc<Model>, Resident)>,
}

impl Residency {
    pub fn new(gpu: &Gpu) -> Self {
        let side = TEXTURE_SIDE as u32;
        let textures = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("albedo"),
            size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: LAYERS },
            mip_level_count: side.ilog2() + 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        Self {
            vertices: vertex_buffer(gpu, VERTICES),
            indices: index_buffer(gpu, INDICES),
            textures,
            used_vertices: 0,
            used_indices: 0,
            models: HashMap::new(),
        }
    }

    /// Where a model is, after uploading it where needed; `None` if it does not fit beside the others.
    pub fn place(&mut self, gpu: &Gpu, model: &Arc<Model>) -> Option<Resident> {
        let address = Arc::as_ptr(model).addr();
        if let Some((_, resident)) = self.models.get(&address) {
            return Some(resident.clone());
        }
        let vertices = model.mesh.positions.len() as u32;
        let indices = 3 * model.mesh.triangles.len() as u32;
        if self.models.is_empty() {
            self.grow(gpu, vertices, indices);
        }
        let fits = self.models.len() < LAYERS as usize
            && u64::from(self.used_vertices) + u64::from(vertices)
                <= capacity(&self.vertices, size_of::<Vertex>())
            && u64::from(self.used_indices) + u64::from(indices) <= capacity(&self.indices, size_of::<u32>());
        if !fits {
            return None;
        }
        let resident = Resident {
            layer: self.models.len() as u32,
            first_vertex: self.used_vertices,
            indices: self.used_indices..self.used_indices + indices,
        };
        self.upload(gpu, model, &resident);
        self.used_vertices += vertices;
        self.used_indices += indices;
        self.models.insert(address, (Arc::clone(model), resident.clone()));
        Some(resident)
    }

    /// Forgets all models.
    pub fn clear(&mut self) {
        self.models.clear();
        self.used_vertices = 0;
        self.used_indices = 0;
    }

    fn grow(&mut self, gpu: &Gpu, vertices: u32, indices: u32) {
        if u64::from(vertices) > capacity(&self.vertices, size_of::<Vertex>()) {
            self.vertices = vertex_buffer(gpu, vertices);
        }
        if u64::from(indices) > capacity(&self.indices, size_of::<u32>()) {
            self.indices = index_buffer(gpu, indices);
        }
    }

    fn upload(&self, gpu: &Gpu, model: &Model, resident: &Resident) {
        let mesh = &model.mesh;
        let vertices: Vec<Vertex> = (0..mesh.positions.len())
            .map(|i| Vertex { position: mesh.positions[i], normal: mesh.normals[i], uv: mesh.uvs[i] })
            .collect();
        let vertex_offset = u64::from(resident.first_vertex) * size_of::<Vertex>() as u64;
        let index_offset = u64::from(resident.indices.start) * size_of::<u32>() as u64;
        gpu.queue.write_buffer(&self.vertices, vertex_offset, bytemuck::cast_slice(&vertices));
        gpu.queue.write_buffer(&self.indices, index_offset, bytemuck::cast_slice(&mesh.triangles));
        for (level, texels) in model.texture.levels.iter().enumerate() {
            let side = (TEXTURE_SIDE >> level) as u32;
            gpu.queue.write_texture(
                wgpu::TexelCopyTextureInfo {
                    texture: &self.textures,
                    mip_level: level as u32,
                    origin: wgpu::Origin3d { x: 0, y: 0, z: resident.layer },
                    aspect: wgpu::TextureAspect::All,
                },
                bytemuck::cast_slice(texels),
                wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(4 * side),
                    rows_per_image: Some(side),
                },
                wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 },
            );
        }
    }
}

fn capacity(buffer: &wgpu::Buffer, element: usize) -> u64 {
    buffer.size() / element as u64
}

fn vertex_buffer(gpu: &Gpu, vertices: u32) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("vertices"),
        size: u64::from(vertices) * size_of::<Vertex>() as u64,
        usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

fn index_buffer(gpu: &Gpu, indices: u32) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("indices"),
        size: u64::from(indices) * size_of::<u32>() as u64,
        usage: wgpu::BufferUsages::INDEX | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}
