//! Placements become draw calls.

use super::super::projection::{light_in_model, pixels_from_model};
use super::super::{Light, NEAR, Placement, RenderError, Shot};
use super::culling::Culling;
use super::device::Gpu;
use super::pipeline::{Item, Pipelines, Sheet};
use super::residency::Residency;
use super::target::{Plane, Target};
use crate::model::Model;
use crate::texture::TEXTURE_SIDE;
use bytemuck::Pod;
use std::collections::BTreeMap;
use std::ops::Range;
use wgpu::util::DeviceExt;

/// Where a shot's image lies in a target: column, row, width, height.
pub(super) type Viewport = [u32; 4];

/// Where the batch, and the layer, begin in the bits of a surface.
const BATCH_SHIFT: u32 = 23;
const LAYER_SHIFT: u32 = 15;
/// How often the device can be filled with models for one picture.
const FILLINGS: u32 = 128;

/// Triangles that a pass begins no further call after: their corners are 48 MiB.
const TRIANGLES: usize = 1 << 22;
/// Calls of a pass: their items are 6 MiB.
const CALLS: usize = 1 << 16;

#[derive(Debug)]
struct Call {
    viewport: Viewport,
    marking: bool,
    first_vertex: u32,
    /// Among the corners that culling left.
    corners: Range<u32>,
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
    culling: Culling,
    calls: Vec<Call>,
    /// One for each call.
    items: Vec<Item>,
    /// Of what is to be shaded of this filling, by array and viewport.
    lights: [BTreeMap<Viewport, Light>; 3],
    filling: u32,
    described: bool,
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
            culling: Culling::default(),
            calls: Vec::new(),
            items: Vec::new(),
            lights: Default::default(),
            filling: 0,
            described: false,
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
        if self.calls.len() == CALLS || self.culling.triangles.len() >= TRIANGLES {
            let mut encoder = self.encoder();
            self.describe(&mut encoder);
            self.gpu.queue.submit([encoder.finish()]);
        }
        let mut corners = self.culling.add(shot, light, (placement, level));
        if corners.is_empty() {
            return Ok(());
        }
        let resident = match self.residency.place(self.gpu, &placement.model, level) {
            Some(resident) => resident,
            None => {
                self.refill(&placement.model)?;
                corners = self.culling.add(shot, light, (placement, level));
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
        });
        self.lights[resident.albedo].insert(viewport, *light);
        self.calls.push(Call { viewport, marking, first_vertex: resident.first_vertex, corners });
        Ok(())
    }

    /// Ends the picture with its copy to a buffer of the target.
    pub fn finish(mut self, slot: usize, plane: Plane) -> wgpu::SubmissionIndex {
        let mut encoder = self.encoder();
        self.describe(&mut encoder);
        self.shade(&mut encoder);
        self.target.copy(&mut encoder, slot, plane);
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
        let mut pass = self.target.describing(encoder, !self.described);
        self.described = true;
        if self.calls.is_empty() {
            return;
        }
        let items = self.buffer("items", wgpu::BufferUsages::VERTEX, &self.items);
        let indices = self.buffer("indices", wgpu::BufferUsages::INDEX, &self.culling.triangles);
        pass.set_vertex_buffer(0, self.residency.vertices.slice(..));
        pass.set_vertex_buffer(1, items.slice(..));
        pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
        let mut viewport = None;
        let mut marking = None;
        for (index, call) in (0..).zip(&self.calls) {
            if marking != Some(call.marking) {
                marking = Some(call.marking);
                let pipelines = self.pipelines;
                pass.set_pipeline(if call.marking { &pipelines.marking } else { &pipelines.plain });
            }
            if viewport != Some(call.viewport) {
                viewport = Some(call.viewport);
                let [column, row, width, height] = call.viewport;
                // Triangles are clipped to the viewport. A scissor beside it would have lavapipe copy all its state, 33 kB.
                pass.set_viewport(column as f32, row as f32, width as f32, height as f32, 0.0, 1.0);
            }
            pass.draw_indexed(call.corners.clone(), call.first_vertex as i32, index..index + 1);
        }
        drop(pass);
        self.calls.clear();
        self.items.clear();
        self.culling.triangles.clear();
    }

    fn shade(&mut self, encoder: &mut wgpu::CommandEncoder) {
        let mut pass = self.target.shading(encoder);
        let mut sheets = Vec::new();
        let instances = [0, 1, 2].map(|albedo| {
            let first = sheets.len() as u32;
            sheets.extend(self.sheets(albedo));
            first..sheets.len() as u32
        });
        if sheets.is_empty() {
            return;
        }
        let buffer = self.buffer("sheets", wgpu::BufferUsages::VERTEX, &sheets);
        pass.set_pipeline(&self.pipelines.shading);
        pass.set_vertex_buffer(0, buffer.slice(..));
        pass.set_bind_group(0, &self.target.bind_group, &[]);
        for (albedo, instances) in self.residency.albedos.iter().zip(instances) {
            if !instances.is_empty() {
                pass.set_bind_group(1, &albedo.bind_group, &[]);
                pass.draw(0..6, instances);
            }
        }
        drop(pass);
        self.lights = Default::default();
    }

    /// What is to be shaded with the textures of an array: the target as a whole where there is one light.
    fn sheets(&self, albedo: usize) -> Vec<Sheet> {
        let sheet = |viewport, light: &Light| Sheet {
            corners: self.corners(viewport),
            ambient: light.ambient,
            diffuse: light.diffuse,
            batch: self.batch(albedo),
        };
        let same = |a: &Light, b: &Light| (a.ambient, a.diffuse) == (b.ambient, b.diffuse);
        let lights = &self.lights[albedo];
        match lights.values().next() {
            Some(first) if lights.values().all(|light| same(light, first)) => {
                vec![sheet([0, 0, self.target.width, self.target.height], first)]
            }
            _ => lights.iter().map(|(&viewport, light)| sheet(viewport, light)).collect(),
        }
    }

    fn buffer<T: Pod>(&self, label: &str, usage: wgpu::BufferUsages, contents: &[T]) -> wgpu::Buffer {
        let contents = bytemuck::cast_slice(contents);
        self.gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some(label),
            contents,
            usage,
        })
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
