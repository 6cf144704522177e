//! Placements become draw calls.

use super::super::projection::{light_in_model, pixels_from_model};
use super::super::{Light, NEAR, Placement, RenderError, Shot};
use super::device::Gpu;
use super::pipeline::{ITEM_STRIDE, ITEMS, Item, Pipelines};
use super::residency::{Residency, Resident};
use super::target::Target;

/// Where a shot's image lies in a target: column, row, width, height.
pub(super) type Viewport = [u32; 4];

#[derive(Debug)]
struct Call {
    viewport: Viewport,
    marking: bool,
    resident: Resident,
}

/// Draws into one target, in as many passes as memory takes.
#[derive(Debug)]
pub(super) struct Painter<'a> {
    gpu: &'a Gpu,
    pipelines: &'a Pipelines,
    residency: &'a mut Residency,
    target: &'a Target,
    calls: Vec<Call>,
    /// One for each call.
    items: Vec<Item>,
    fresh: bool,
}

impl<'a> Painter<'a> {
    pub fn new(
        gpu: &'a Gpu,
        pipelines: &'a Pipelines,
        residency: &'a mut Residency,
        target: &'a Target,
    ) -> Self {
        Self { gpu, pipelines, residency, target, calls: Vec::new(), items: Vec::new(), fresh: true }
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
            self.flush();
        }
        let resident = match self.residency.place(self.gpu, &placement.model, level) {
            Some(resident) => resident,
            None => {
                self.flush();
                self.residency.clear(self.gpu, self.pipelines, &placement.model);
                let placed = self.residency.place(self.gpu, &placement.model, level);
                placed.ok_or_else(|| self.gpu.failed("a mesh is too large for it"))?
            }
        };
        self.items.push(Item {
            clip_from_model: clip_from_model(shot, placement),
            light_in_model: light_in_model(light, placement),
            layer: resident.layer,
            ambient: light.ambient,
            id: placement.id,
            diffuse: light.diffuse,
            padding: [0; 37],
        });
        self.calls.push(Call { viewport, marking, resident });
        Ok(())
    }

    /// Ends the picture with its copy to a buffer of the target.
    pub fn finish(mut self, slot: usize, with_depth: bool) -> wgpu::SubmissionIndex {
        let mut encoder = self.encode();
        self.target.copy(&mut encoder, slot, with_depth);
        self.gpu.queue.submit([encoder.finish()])
    }

    fn flush(&mut self) {
        let encoder = self.encode();
        self.gpu.queue.submit([encoder.finish()]);
    }

    fn encode(&mut self) -> wgpu::CommandEncoder {
        self.gpu.queue.write_buffer(&self.pipelines.items, 0, bytemuck::cast_slice(&self.items));
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let mut pass = self.target.pass(&mut encoder, self.fresh);
        pass.set_vertex_buffer(0, self.residency.vertices.slice(..));
        pass.set_index_buffer(self.residency.indices.slice(..), wgpu::IndexFormat::Uint32);
        let mut viewport = None;
        let mut marking = None;
        let mut albedo = None;
        for (index, call) in (0..).zip(&self.calls) {
            pass.set_bind_group(1, &self.pipelines.item, &[index * ITEM_STRIDE]);
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
            if albedo != Some(resident.albedo) {
                albedo = Some(resident.albedo);
                pass.set_bind_group(0, &self.residency.albedos[resident.albedo].bind_group, &[]);
            }
            pass.draw_indexed(resident.indices.clone(), resident.first_vertex as i32, 0..1);
        }
        drop(pass);
        self.calls.clear();
        self.items.clear();
        self.fresh = false;
        encoder
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
