//! Textures of one size on the device.

use super::device::Gpu;
use super::pipeline::Pipelines;
use crate::texture::{TEXTURE_SIDE, Texture};

/// Layers that every device has.
const MOST_LAYERS: u32 = 256;

/// An array of textures of one size.
#[derive(Debug)]
pub(super) struct Albedo {
    pub bind_group: wgpu::BindGroup,
    array: wgpu::Texture,
    used: u32,
}

impl Albedo {
    /// An array that takes as much memory as one of [`MOST_LAYERS`] of the smallest textures.
    pub fn new(gpu: &Gpu, pipelines: &Pipelines, side: usize) -> Self {
        let relative_side = (side / TEXTURE_SIDE) as u32;
        Self::with_layers(gpu, pipelines, side as u32, MOST_LAYERS / (relative_side * relative_side))
    }

    fn with_layers(gpu: &Gpu, pipelines: &Pipelines, side: u32, layers: u32) -> Self {
        let array = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("albedo"),
            size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: layers },
            mip_level_count: side.ilog2() + 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        Self { bind_group: pipelines.bind_textures(gpu, &array), array, used: 0 }
    }

    /// The layer of a texture just uploaded; `None` if there is no room.
    pub fn place(&mut self, gpu: &Gpu, texture: &Texture) -> Option<u32> {
        let layer = self.used;
        if layer == self.array.depth_or_array_layers() {
            return None;
        }
        for (level, texels) in texture.levels().enumerate() {
            let side = self.array.width() >> level;
            gpu.queue.write_texture(
                wgpu::TexelCopyTextureInfo {
                    texture: &self.array,
                    mip_level: level as u32,
                    origin: wgpu::Origin3d { x: 0, y: 0, z: layer },
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
        self.used += 1;
        Some(layer)
    }

    /// Forgets all textures; if there is to be room for more, there is where the device has it.
    pub fn clear(&mut self, gpu: &Gpu, pipelines: &Pipelines, more: bool) {
        let layers = self.array.depth_or_array_layers();
        if more && self.used == layers && layers < MOST_LAYERS {
            *self = Self::with_layers(gpu, pipelines, self.array.width(), 2 * layers);
        }
        self.used = 0;
    }
}
