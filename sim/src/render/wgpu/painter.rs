//! Placements become draw calls.

use super::super::projection::{light_in_model, pixels_from_model};
use super::super::{Light, NEAR, Placement, RenderError, Shot};
use super::device::Gpu;
use super::pipeline::{ITEM_STRIDE, ITEMS, Item, Pipelines, Sheet};
use super::residency::{Residency, Resident};
use super::target::Target;
use crate::model::Model;
use crate::texture::TEXTURE_SIDE;
use std::collections::BTreeMap;

/// Where a shot's image lies in a target: column, row, width, height.
pub(super) type Viewport = [u32; 4];

/// Where the batch, and the layer, begin in the bits of a surface.
const BATCH_SHIFT: u32 = 23;
const LAYER_SHIFT: u32 = 15;
/// How often the device can be filled with models for one picture.
const FILLINGS: u32 = 128;

#[derive(Debug)]
struct Call {
    viewport: Viewport,
    marking: bool,
    resident: Resident,
}

/// Draws into one target, in as many passes as memory takes.
///
/// A batch is what is shaded together: pixels whose textures are in one array, in one filling of the device.
#[derive(Debug)]
pub(super) struct Painter<'a> {
    gpu: &'a Gpu,
    pipelines: &'a Pipelines,
    residency: &'a mut Residency,
    target: &'a Target,
    calls: Vec<Call>,
    /// One for each call.
    items: Vec<Item>,
    /// What is to be shaded of this filling, by array and viewport.
    sheets: BTreeMap<(usize, Viewport), Light>,
    filling: u32,
    described: bool,
    shaded: bool,
}

impl<'a> Painter<'a> {
    pub fn new(
        gpu: &'a Gpu,
        pipelines: &'a Pipelines,
        residency: &'a mut Residency,
        target: &'a Target,
    ) -> Self {
        Self {
            gpu,
            pipelines,
            residency,
            target,
            calls: Vec::new(),
            items: Vec::new(),
            sheets: BTreeMap::new(),
            filling: 0,
            described: false,
            shaded: false,
        }
    }

    /// Draws a placement at a level of detail; `marking` marks its pixels, for good.
    pub fn draw(
        &mut self,
        viewport: Viewport,
        shot: &Shot,
        light: &Light,
        (placement, level): (&Placement, usize),
        marking: bool,
    ) -> Result<(), RenderError> {
        if placement.model.mesh.triangles.is_empty() {
            return Ok(());
        }
        if self.calls.len() == ITEMS {
            let mut encoder = self.encoder();
            self.describe(&mut encoder);
            self.gpu.queue.submit([encoder.finish()]);
        }
        let resident = match self.residency.place(self.gpu, &placement.model, level) {
            Some(resident) => resident,
            None => {
                self.refill(&placement.model)?;
                let placed = self.residency.place(self.gpu, &placement.model, level);
                placed.ok_or_else(|| self.gpu.failed("a mesh is too large for it"))?
            }
        };
        self.items.push(Item {
            clip_from_model: clip_from_model(shot, placement),
            light_in_model: light_in_model(light, placement),
            side: (TEXTURE_SIDE << resident.albedo) as f32,
            texture: resident.layer << LAYER_SHIFT | self.batch(resident.albedo) << BATCH_SHIFT,
            id: placement.id,
            padding: [0; 42],
        });
        self.sheets.insert((resident.albedo, viewport), *light);
        self.calls.push(Call { viewport, marking, resident });
        Ok(())
    }

    /// Ends the picture with its copy to a buffer of the target.
    pub fn finish(mut self, slot: usize, with_depth: bool) -> wgpu::SubmissionIndex {
        let mut encoder = self.encoder();
        self.describe(&mut encoder);
        self.shade(&mut encoder);
        self.target.copy(&mut encoder, slot, with_depth);
        self.gpu.queue.submit([encoder.finish()])
    }

    /// Makes room on the device for a model.
    fn refill(&mut self, misfit: &Model) -> Result<(), RenderError> {
        let mut encoder = self.encoder();
        self.describe(&mut encoder);
        self.shade(&mut encoder);
        self.gpu.queue.submit([encoder.finish()]);
        self.residency.clear(self.gpu, self.pipelines, misfit);
        self.filling += 1;
        if self.filling < FILLINGS {
            Ok(())
        } else {
            Err(self.gpu.failed("a picture has too many models for it"))
        }
    }

    fn batch(&self, albedo: usize) -> u32 {
        self.filling << 2 | albedo as u32
    }

    fn encoder(&self) -> wgpu::CommandEncoder {
        self.gpu.device.create_command_encoder(&Default::default())
    }

    fn describe(&mut self, encoder: &mut wgpu::CommandEncoder) {
        self.gpu.queue.write_buffer(&self.pipelines.items, 0, bytemuck::cast_slice(&self.items));
        let mut pass = self.target.describing(encoder, !self.described);
        self.described = true;
        pass.set_vertex_buffer(0, self.residency.vertices.slice(..));
        pass.set_index_buffer(self.residency.indices.slice(..), wgpu::IndexFormat::Uint32);
        let mut viewport = None;
        let mut marking = None;
        for (index, call) in (0..).zip(&self.calls) {
            pass.set_bind_group(0, &self.pipelines.item, &[index * ITEM_STRIDE]);
            if marking != Some(call.marking) {
                marking = Some(call.marking);
                let pipelines = self.pipelines;
                pass.set_pipeline(if call.marking { &pipelines.marking } else { &pipelines.plain });
            }
            if viewport != Some(call.viewport) {
                viewport = Some(call.viewport);
                let [column, row, width, height] = call.viewport;
                pass.set_viewport(column as f32, row as f32, width as f32, height as f32, 0.0, 1.0);
                pass.set_scissor_rect(column, row, width, height);
            }
            let resident = &call.resident;
            pass.draw_indexed(resident.indices.clone(), resident.first_vertex as i32, 0..1);
        }
        drop(pass);
        self.calls.clear();
        self.items.clear();
    }

    fn shade(&mut self, encoder: &mut wgpu::CommandEncoder) {
        let mut pass = self.target.shading(encoder, !self.shaded);
        self.shaded = true;
        if self.sheets.is_empty() {
            return;
        }
        let sheets: Vec<Sheet> = self
            .sheets
            .iter()
            .map(|(&(albedo, viewport), light)| Sheet {
                corners: self.corners(viewport),
                ambient: light.ambient,
                diffuse: light.diffuse,
                batch: self.batch(albedo),
            })
            .collect();
        let buffer = self.gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("sheets"),
            size: size_of_val(&sheets[..]) as u64,
            usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.gpu.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&sheets));
        pass.set_pipeline(&self.pipelines.shading);
        pass.set_vertex_buffer(0, buffer.slice(..));
        pass.set_bind_group(0, &self.target.bind_group, &[]);
        let mut first = 0;
        for (index, albedo) in self.residency.albedos.iter().enumerate() {
            let count =
                self.sheets.range((index, Viewport::default())..(index + 1, Viewport::default())).count();
            let instances = first..first + count as u32;
            first = instances.end;
            if !instances.is_empty() {
                pass.set_bind_group(1, &albedo.bind_group, &[]);
                pass.draw(0..6, instances);
            }
        }
        drop(pass);
        self.sheets.clear();
    }

    /// Lower and upper corner of a viewport in the target's clip coordinates.
    fn corners(&self, [column, row, width, height]: Viewport) -> [f32; 4] {
        let x = |column: u32| 2.0 * column as f32 / self.target.width as f32 - 1.0;
        let y = |row: u32| 1.0 - 2.0 * row as f32 / self.target.height as f32;
        [x(column), y(row + height), x(column + width), y(row)]
    }
}

/// Columns; depth is `NEAR / depth`, so that it is greatest at the near plane and linear in the image.
fn clip_from_model(shot: &Shot, placement: &Placement) -> [[f32; 4]; 4] {
    let pixels_from_model = pixels_from_model(shot, placement);
    let right = 2.0 / f64::from(shot.camera.width);
    let up = -2.0 / f64::from(shot.camera.height);
    std::array::from_fn(|column| {
        let pixel = pixels_from_model.column(column);
        let near = if column == 3 { NEAR } else { 0.0 };
        [right * pixel[0] - pixel[2], up * pixel[1] + pixel[2], near, pixel[2]].map(|entry| entry as f32)
    })
}
