//! The models that are on the device.

use super::albedo::Albedo;
use super::device::Gpu;
use super::pipeline::{Pipelines, Vertex};
use crate::mesh::Mesh;
use crate::model::Model;
use crate::texture::TEXTURE_SIDE;
use std::collections::HashMap;
use std::sync::{Arc, Weak};

/// At first.
const VERTICES: u64 = 1 << 18;
const VERTEX_BYTES: u64 = size_of::<Vertex>() as u64;

/// Where a model lies on the device.
#[derive(Clone, Debug)]
pub(super) struct Resident {
    /// Which of [`Residency::albedos`], and which of its layers.
    pub albedo: usize,
    pub layer: u32,
    pub first_vertex: u32,
}

/// Vertices in one buffer and textures in an array a size, filled up and then emptied as a whole.
#[derive(Debug)]
pub(super) struct Residency {
    pub vertices: wgpu::Buffer,
    /// Of [`TEXTURE_SIDE`], of twice and of four times as much.
    pub albedos: [Albedo; 3],
    used_vertices: u32,
    /// Layers by address, which the kept handle reserves, and no more.
    textures: HashMap<usize, (Weak<Model>, u32)>,
    /// By address and level of detail.
    meshes: HashMap<(usize, usize), Resident>,
}

impl Residency {
    pub fn new(gpu: &Gpu, pipelines: &Pipelines) -> Self {
        Self {
            vertices: vertex_buffer(gpu, VERTICES),
            albedos: [0, 1, 2].map(|doublings| Albedo::new(gpu, pipelines, TEXTURE_SIDE << doublings)),
            used_vertices: 0,
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
        let end = self.used_vertices.checked_add(mesh.positions.len() as u32)?;
        if u64::from(end) > capacity(&self.vertices) {
            return None;
        }
        let albedo = albedo_of(model);
        let layer = match self.textures.get(&address) {
            Some(&(_, layer)) => layer,
            None => {
                let layer = self.albedos[albedo].place(gpu, &model.texture)?;
                self.textures.insert(address, (Arc::downgrade(model), layer));
                layer
            }
        };
        let resident = Resident { albedo, layer, first_vertex: self.used_vertices };
        self.upload(gpu, mesh, &resident);
        self.used_vertices = end;
        self.meshes.insert((address, level), resident.clone());
        Some(resident)
    }

    /// Forgets all models, after one did not fit, and makes more room for as many and that one.
    pub fn clear(&mut self, gpu: &Gpu, pipelines: &Pipelines, misfit: &Model) {
        let needed = u64::from(self.used_vertices) + misfit.mesh.positions.len() as u64;
        let room = capacity(&self.vertices);
        let most = (gpu.device.limits().max_buffer_size / VERTEX_BYTES).min(u64::from(u32::MAX));
        if needed > room && room < most {
            self.vertices = vertex_buffer(gpu, needed.next_power_of_two().min(most));
        }
        for (index, albedo) in self.albedos.iter_mut().enumerate() {
            albedo.clear(gpu, pipelines, index == albedo_of(misfit));
        }
        self.textures.clear();
        self.meshes.clear();
        self.used_vertices = 0;
    }

    fn upload(&self, gpu: &Gpu, mesh: &Mesh, resident: &Resident) {
        let vertices: Vec<Vertex> = (0..mesh.positions.len())
            .map(|i| Vertex { position: mesh.positions[i], normal: mesh.normals[i], uv: mesh.uvs[i] })
            .collect();
        let offset = u64::from(resident.first_vertex) * VERTEX_BYTES;
        gpu.queue.write_buffer(&self.vertices, offset, bytemuck::cast_slice(&vertices));
    }
}

fn albedo_of(model: &Model) -> usize {
    (model.texture.side() / TEXTURE_SIDE).ilog2() as usize
}

/// Of a buffer of vertices.
fn capacity(buffer: &wgpu::Buffer) -> u64 {
    buffer.size() / VERTEX_BYTES
}

fn vertex_buffer(gpu: &Gpu, vertices: u64) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("vertices"),
        size: vertices * VERTEX_BYTES,
        usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}
