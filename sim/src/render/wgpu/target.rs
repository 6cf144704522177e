//! What is drawn into, and the way back from the device.

use super::super::RenderError;
use super::device::Gpu;
use super::pipeline::{COLOR, DEPTH, ID, MARK, Pipelines, SURFACE};
use std::sync::mpsc;

/// Id of a pixel on which nothing was drawn, on the device.
pub(super) const NOTHING: u32 = u32::MAX;

/// What is read beside colours and ids.
#[derive(Clone, Copy, Debug)]
pub(super) enum Plane {
    /// `NEAR / depth`.
    Depth,
    /// Where the target of a tile is, seen or not.
    Marks,
}

/// A colour, an id, a mark, a depth and a surface image of one size, and two buffers to read all but the last through.
#[derive(Debug)]
pub(super) struct Target {
    pub width: u32,
    pub height: u32,
    color: wgpu::Texture,
    ids: wgpu::Texture,
    marks: wgpu::Texture,
    depth: wgpu::Texture,
    surfaces: wgpu::Texture,
    /// Of the surfaces.
    pub bind_group: wgpu::BindGroup,
    buffers: [wgpu::Buffer; 2],
}

impl Target {
    pub fn new(gpu: &Gpu, pipelines: &Pipelines, width: u32, height: u32) -> Self {
        let texture = |label, format, use_afterwards| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | use_afterwards,
                view_formats: &[],
            })
        };
        let buffer = || {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("readback"),
                size: 3 * plane_bytes(width, height),
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let copied = wgpu::TextureUsages::COPY_SRC;
        let surfaces = texture("surfaces", SURFACE, wgpu::TextureUsages::TEXTURE_BINDING);
        Self {
            width,
            height,
            color: texture("color", COLOR, copied),
            ids: texture("ids", ID, copied),
            marks: texture("marks", MARK, copied),
            depth: texture("depth", DEPTH, copied),
            bind_group: pipelines.bind_surfaces(gpu, &surfaces),
            surfaces,
            buffers: [buffer(), buffer()],
        }
    }

    /// A pass that writes surfaces, ids, marks and depths; `fresh` forgets what was drawn.
    pub fn describing<'e>(&self, encoder: &'e mut wgpu::CommandEncoder, fresh: bool) -> wgpu::RenderPass<'e> {
        let nothing = wgpu::Color { r: f64::from(NOTHING), ..wgpu::Color::TRANSPARENT };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("describing"),
            // What surfaces are where nothing is drawn does not matter.
            color_attachments: &[
                attachment(&view(&self.surfaces), wgpu::LoadOp::Load),
                attachment(&view(&self.ids), load(nothing, fresh)),
                attachment(&view(&self.marks), load(wgpu::Color::TRANSPARENT, fresh)),
            ],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &view(&self.depth),
                depth_ops: Some(wgpu::Operations { load: load(0.0, fresh), store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            ..Default::default()
        })
    }

    /// A pass that writes colours where something was drawn; what they are elsewhere does not matter.
    pub fn shading<'e>(&self, encoder: &'e mut wgpu::CommandEncoder) -> wgpu::RenderPass<'e> {
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("shading"),
            color_attachments: &[attachment(&view(&self.color), wgpu::LoadOp::Load)],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &view(&self.depth),
                depth_ops: None,
                stencil_ops: None,
            }),
            ..Default::default()
        })
    }

    /// Copies colours, ids and another plane to a buffer.
    pub fn copy(&self, encoder: &mut wgpu::CommandEncoder, slot: usize, plane: Plane) {
        let last = match plane {
            Plane::Depth => &self.depth,
            Plane::Marks => &self.marks,
        };
        for (index, texture) in [&self.color, &self.ids, last].into_iter().enumerate() {
            encoder.copy_texture_to_buffer(
                texture.as_image_copy(),
                wgpu::TexelCopyBufferInfo {
                    buffer: &self.buffers[slot],
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: index as u64 * plane_bytes(self.width, self.height),
                        bytes_per_row: Some(row_bytes(self.width, bytes(texture))),
                        rows_per_image: Some(self.height),
                    },
                },
                texture.size(),
            );
        }
    }

    /// Waits for a submission that ended with [`copy`](Self::copy) and hands its pixels to `read`.
    pub fn read<T>(
        &self,
        gpu: &Gpu,
        slot: usize,
        submission: wgpu::SubmissionIndex,
        read: impl FnOnce(&Pixels<'_>) -> T,
    ) -> Result<T, RenderError> {
        let buffer = &self.buffers[slot];
        let (sender, receiver) = mpsc::channel();
        buffer.map_async(wgpu::MapMode::Read, .., move |mapped| {
            // The receiver is gone only when waiting failed, which is reported.
            let _ = sender.send(mapped);
        });
        gpu.wait(submission)?;
        let mapped = receiver.try_recv();
        if !matches!(mapped, Ok(Ok(()))) {
            return Err(gpu.failed("the picture could not be mapped into memory"));
        }
        let view = buffer.get_mapped_range(..).map_err(|error| gpu.failed(error.to_string()))?;
        let result = read(&Pixels { bytes: &view, width: self.width, height: self.height });
        drop(view);
        buffer.unmap();
        Ok(result)
    }
}

fn view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&Default::default())
}

fn load<T>(clear: T, fresh: bool) -> wgpu::LoadOp<T> {
    if fresh { wgpu::LoadOp::Clear(clear) } else { wgpu::LoadOp::Load }
}

fn attachment(
    view: &wgpu::TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
) -> Option<wgpu::RenderPassColorAttachment<'_>> {
    Some(wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
    })
}

/// A target's pixels in memory.
#[derive(Debug)]
pub(super) struct Pixels<'a> {
    bytes: &'a [u8],
    width: u32,
    height: u32,
}

impl Pixels<'_> {
    /// RGB of `width` pixels from `(column, row)`.
    pub fn colors(&self, column: u32, row: u32, width: u32) -> &[[u8; 4]] {
        self.pixels(0, [column, row, width], 4).as_chunks().0
    }

    /// Ids likewise, little-endian; [`NOTHING`] where nothing was drawn.
    pub fn ids(&self, column: u32, row: u32, width: u32) -> &[[u8; 4]] {
        self.pixels(1, [column, row, width], 4).as_chunks().0
    }

    /// Marks likewise, where they were copied.
    pub fn marks(&self, column: u32, row: u32, width: u32) -> &[u8] {
        self.pixels(2, [column, row, width], 1)
    }

    /// `NEAR / depth` likewise, where it was copied.
    pub fn nearness(&self, column: u32, row: u32, width: u32) -> impl Iterator<Item = f32> + '_ {
        self.pixels(2, [column, row, width], 4).as_chunks().0.iter().map(|&bytes| f32::from_le_bytes(bytes))
    }

    fn pixels(&self, plane: u64, [column, row, width]: [u32; 3], bytes: u32) -> &[u8] {
        let start = plane * plane_bytes(self.width, self.height)
            + u64::from(row) * u64::from(row_bytes(self.width, bytes))
            + u64::from(bytes * column);
        &self.bytes[start as usize..][..(bytes * width) as usize]
    }
}

/// Of a pixel in a plane that is read.
fn bytes(texture: &wgpu::Texture) -> u32 {
    if texture.format() == MARK { 1 } else { 4 }
}

fn row_bytes(width: u32, bytes: u32) -> u32 {
    (bytes * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
}

fn plane_bytes(width: u32, height: u32) -> u64 {
    u64::from(row_bytes(width, 4)) * u64::from(height)
}
