//! The models that are on the device.

use super::albedo::Albedo;
use super::device::Gpu;
use super::pipeline::{Pipelines, Vertex};
use crate::mesh::Mesh;
use crate::model::Model;
use crate::texture::TEXTURE_SIDE;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

/// At first.
const VERTICES: u32 = 1 << 18;
/// At first.
const INDICES: u32 = 1 << 20;

/// Where a model lies on the device.
#[derive(Clone, Debug)]
pub(super) struct Resident {
    /// Which of [`Residency::albedos`], and which of its layers.
    pub albedo: usize,
    pub layer: u32,
    pub first_vertex: u32,
    pub indices: Range<u32>,
}

/// Meshes in two buffers and textures in an array a size, filled up and then emptied as a whole.
#[derive(Debug)]
pub(super) struct Residency {
    pub vertices: wgpu::Buffer,
    pub indices: wgpu::Buffer,
    /// Of [`TEXTURE_SIDE`], of twice and of four times as much.
    pub albedos: [Albedo; 3],
    used_vertices: u32,
    used_indices: u32,
    /// Layers by address, which the kept handle reserves.
    textures: HashMap<usize, (Arc<Model>, u32)>,
    /// By address and level of detail.
    meshes: HashMap<(usize, usize), Resident>,
}

impl Residency {
    pub fn new(gpu: &Gpu, pipelines: &Pipelines) -> Self {
        Self {
            vertices: vertex_buffer(gpu, VERTICES),
            indices: index_buffer(gpu, INDICES),
            albedos: [0, 1, 2].map(|doublings| Albedo::new(gpu, pipelines, TEXTURE_SIDE << doublings)),
            used_vertices: 0,
            used_indices: 0,
            textures: HashMap::new(),
            meshes: HashMap::new(),
        }
    }

    /// Where a model's level of detail is, after uploading it where needed; `None` if it does not fit beside the others.
    pub fn place(&mut self, gpu: &Gpu, model: &Arc<Model>, level: usize) -> Option<Resident> {
        let address = Arc::as_ptr(model).addr();
        if let Some(resident) = self.meshes.get(&(address, level)) {
            return Some(resident.clone());
        }
        let mesh = model.mesh_at(level);
        let (vertices, indices) = sizes(mesh);
        let end_of_vertices = self.used_vertices.checked_add(vertices)?;
        let end_of_indices = self.used_indices.checked_add(indices)?;
        if u64::from(end_of_vertices) > capacity(&self.vertices, size_of::<Vertex>())
            || u64::from(end_of_indices) > capacity(&self.indices, size_of::<u32>())
        {
            return None;
        }
        let albedo = albedo_of(model);
        let layer = match self.textures.get(&address) {
            Some(&(_, layer)) => layer,
            None => {
                let layer = self.albedos[albedo].place(gpu, &model.texture)?;
                self.textures.insert(address, (Arc::clone(model), layer));
                layer
            }
        };
        let resident = Resident {
            albedo,
            layer,
            first_vertex: self.used_vertices,
            indices: self.used_indices..end_of_indices,
        };
        self.upload(gpu, mesh, &resident);
        self.used_vertices = end_of_vertices;
        self.used_indices = end_of_indices;
        self.meshes.insert((address, level), resident.clone());
        Some(resident)
    }

    /// Forgets all models, after one did not fit, and makes more room for as many and that one.
    pub fn clear(&mut self, gpu: &Gpu, pipelines: &Pipelines, misfit: &Model) {
        let (vertices, indices) = sizes(&misfit.mesh);
        let limit = gpu.device.limits().max_buffer_size;
        let grown = |buffer: &wgpu::Buffer, element: usize, used: u32, wanted: u32| {
            let needed = u64::from(used) + u64::from(wanted);
            let room = capacity(buffer, element);
            let most = (limit / element as u64).min(u64::from(u32::MAX));
            (needed > room && room < most).then(|| needed.next_power_of_two().min(most) as u32)
        };
        if let Some(count) = grown(&self.vertices, size_of::<Vertex>(), self.used_vertices, vertices) {
            self.vertices = vertex_buffer(gpu, count);
        }
        if let Some(count) = grown(&self.indices, size_of::<u32>(), self.used_indices, indices) {
            self.indices = index_buffer(gpu, count);
        }
        for (index, albedo) in self.albedos.iter_mut().enumerate() {
            albedo.clear(gpu, pipelines, index == albedo_of(misfit));
        }
        self.textures.clear();
        self.meshes.clear();
        self.used_vertices = 0;
        self.used_indices = 0;
    }

    fn upload(&self, gpu: &Gpu, mesh: &Mesh, resident: &Resident) {
        let vertices: Vec<Vertex> = (0..mesh.positions.len())
            .map(|i| Vertex { position: mesh.positions[i], normal: mesh.normals[i], uv: mesh.uvs[i] })
            .collect();
        let vertex_offset = u64::from(resident.first_vertex) * size_of::<Vertex>() as u64;
        let index_offset = u64::from(resident.indices.start) * size_of::<u32>() as u64;
        gpu.queue.write_buffer(&self.vertices, vertex_offset, bytemuck::cast_slice(&vertices));
        gpu.queue.write_buffer(&self.indices, index_offset, bytemuck::cast_slice(&mesh.triangles));
    }
}

/// Vertices and indices.
fn sizes(mesh: &Mesh) -> (u32, u32) {
    (mesh.positions.len() as u32, 3 * mesh.triangles.len() as u32)
}

fn albedo_of(model: &Model) -> usize {
    (model.texture.side() / TEXTURE_SIDE).ilog2() as usize
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
