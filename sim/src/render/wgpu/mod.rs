//! A renderer on any Vulkan driver, a GPU's or lavapipe.
//!
//! Mip levels and transfer curves are computed in the shader as the [reference](super::reference) computes them, so that only
//! rounding and pixels on edges may differ.

mod albedo;
mod culling;
mod device;
mod painter;
mod pipeline;
mod residency;
mod target;

use super::bounds::Frustum;
use super::{Frame, NEAR, NO_OBJECT, RenderError, RenderScene, Renderer, RendererInfo, Shot, Tile, TileShot};
use device::Gpu;
use painter::{Painter, Viewport};
use pipeline::Pipelines;
use residency::Residency;
use std::collections::BTreeMap;
use std::sync::Arc;
use target::{NOTHING, Pixels, Plane, Target};
use vantage_dataset::widest::widest;

/// Side of the image that tiles are drawn into together, pixels: what a CPU keeps in its cache.
const ATLAS_SIDE: u32 = 256;

/// Sizes of targets that are kept.
const TARGETS: usize = 8;

/// The wgpu renderer.
#[derive(Debug)]
pub struct WgpuRenderer {
    gpu: Gpu,
    pipelines: Pipelines,
    residency: Residency,
    targets: BTreeMap<(u32, u32), Arc<Target>>,
}

impl WgpuRenderer {
    /// Opens a device (the one that `WGPU_ADAPTER_NAME` names, if set) and compiles the shaders.
    ///
    /// Where that is the CPU, the whole process keeps more of the memory that it frees: some tens of megabytes.
    pub fn new() -> Result<Self, RenderError> {
        let gpu = Gpu::open()?;
        let pipelines = Pipelines::new(&gpu);
        let residency = Residency::new(&gpu, &pipelines);
        gpu.check()?;
        Ok(Self { gpu, pipelines, residency, targets: BTreeMap::new() })
    }

    /// The target of a size, kept for later pictures.
    fn target(&mut self, size: (u32, u32)) -> Arc<Target> {
        if !self.targets.contains_key(&size) && self.targets.len() == TARGETS {
            self.targets.clear();
        }
        let target = || Arc::new(Target::new(&self.gpu, &self.pipelines, size.0, size.1));
        Arc::clone(self.targets.entry(size).or_insert_with(target))
    }

    /// What draws the next picture.
    fn painter<'a>(&'a mut self, target: &'a Target) -> Painter<'a> {
        Painter::new(&self.gpu, &self.pipelines, &mut self.residency, target)
    }
}

impl Renderer for WgpuRenderer {
    fn info(&self) -> RendererInfo {
        self.gpu.info()
    }

    fn frame(&mut self, scene: &RenderScene, shot: &Shot) -> Result<Frame, RenderError> {
        shot.check()?;
        self.persist(|renderer| renderer.draw_frame(scene, shot))
    }

    fn tiles(&mut self, shots: &[TileShot<'_>], side: u32) -> Result<Vec<Tile>, RenderError> {
        shots.iter().try_for_each(|shot| shot.window(side).check())?;
        self.persist(|renderer| renderer.draw_tiles(shots, side))
    }
}

/// Tiles that are being drawn.
#[derive(Debug)]
struct Atlas<'a> {
    shots: &'a [TileShot<'a>],
    side: u32,
    target: Arc<Target>,
    slot: usize,
    submission: wgpu::SubmissionIndex,
}

impl WgpuRenderer {
    /// Does some work, and if the device failed, once more on a fresh one.
    fn persist<T>(
        &mut self,
        mut work: impl FnMut(&mut Self) -> Result<T, RenderError>,
    ) -> Result<T, RenderError> {
        let done = self.gpu.check().and_then(|()| work(self));
        if !matches!(done, Err(RenderError::Device { .. })) {
            return done;
        }
        *self = Self::new()?;
        work(self)
    }

    fn draw_frame(&mut self, scene: &RenderScene, shot: &Shot) -> Result<Frame, RenderError> {
        let (width, height) = (shot.camera.width, shot.camera.height);
        let target = self.target((width, height));
        let mut painter = self.painter(&target);
        let frustum = Frustum::of(shot);
        for placement in &scene.placements {
            if let Some(level) = frustum.level(placement) {
                painter.draw([0, 0, width, height], shot, &scene.light, (placement, level), false)?;
            }
        }
        let submission = painter.finish(0, Plane::Depth);
        target.read(&self.gpu, 0, submission, |pixels| frame(pixels, scene, width, height))
    }

    fn draw_tiles(&mut self, shots: &[TileShot<'_>], side: u32) -> Result<Vec<Tile>, RenderError> {
        let columns = (ATLAS_SIDE / side.max(1)).max(1);
        let mut tiles = Vec::with_capacity(shots.len());
        let mut drawn: Option<Atlas<'_>> = None;
        for (index, shots) in shots.chunks((columns * columns) as usize).enumerate() {
            let rows = (shots.len() as u32).div_ceil(columns).next_power_of_two().min(columns);
            let target = self.target((columns * side, rows * side));
            let atlas = self.draw_atlas(shots, side, target, index % 2)?;
            if let Some(previous) = drawn.replace(atlas) {
                self.read_atlas(previous, &mut tiles)?;
            }
        }
        if let Some(last) = drawn {
            self.read_atlas(last, &mut tiles)?;
        }
        Ok(tiles)
    }

    fn draw_atlas<'a>(
        &mut self,
        shots: &'a [TileShot<'a>],
        side: u32,
        target: Arc<Target>,
        slot: usize,
    ) -> Result<Atlas<'a>, RenderError> {
        let mut painter = self.painter(&target);
        for target_first in [true, false] {
            for (shot, viewport) in shots.iter().zip(viewports(target.width, side)) {
                let window = shot.window(side);
                let frustum = Frustum::of(&window);
                for placement in &shot.scene.placements {
                    if (placement.id == shot.target) != target_first {
                        continue;
                    }
                    if let Some(level) = frustum.level(placement) {
                        let drawn = (placement, level);
                        painter.draw(viewport, &window, &shot.scene.light, drawn, target_first)?;
                    }
                }
            }
        }
        let submission = painter.finish(slot, Plane::Marks);
        Ok(Atlas { shots, side, target, slot, submission })
    }

    fn read_atlas(&self, atlas: Atlas<'_>, tiles: &mut Vec<Tile>) -> Result<(), RenderError> {
        let Atlas { shots, side, target, slot, submission } = atlas;
        target.read(&self.gpu, slot, submission, |pixels| {
            for (shot, viewport) in shots.iter().zip(viewports(target.width, side)) {
                tiles.push(tile(pixels, shot.scene, viewport));
            }
        })
    }
}

/// The places of tiles in an atlas, row by row.
fn viewports(width: u32, side: u32) -> impl Iterator<Item = Viewport> {
    let columns = width / side;
    (0..).map(move |index: u32| [index % columns * side, index / columns * side, side, side])
}

fn frame(pixels: &Pixels<'_>, scene: &RenderScene, width: u32, height: u32) -> Frame {
    let (rgb, ids) = picture(pixels, scene, [0, 0, width, height]);
    let mut depth = Vec::with_capacity(ids.len());
    for row in 0..height {
        depth.extend(pixels.nearness(0, row, width).map(|nearness| NEAR as f32 / nearness));
    }
    Frame { width, height, rgb, depth, ids }
}

fn tile(pixels: &Pixels<'_>, scene: &RenderScene, viewport: Viewport) -> Tile {
    let [column, row, side, _] = viewport;
    let (rgb, ids) = picture(pixels, scene, viewport);
    let amodal_pixels =
        (row..row + side).flat_map(|row| pixels.marks(column, row, side)).map(|&mark| u32::from(mark)).sum();
    Tile { side, rgb, ids, amodal_pixels }
}

/// sRGB bytes and ids of a viewport, row-major.
fn picture(pixels: &Pixels<'_>, scene: &RenderScene, viewport: Viewport) -> (Vec<u8>, Vec<u32>) {
    let [column, row, width, height] = viewport;
    let count = width as usize * height as usize;
    let mut rgb = vec![0; 3 * count];
    let mut ids = vec![NO_OBJECT; count];
    let [r, g, b] = scene.background;
    let background = u32::from_le_bytes([r, g, b, 0]);
    widest(
        #[inline(always)]
        || {
            let outputs = rgb.chunks_exact_mut(3 * width as usize).zip(ids.chunks_exact_mut(width as usize));
            for (row, (rgb, ids)) in (row..).zip(outputs) {
                let drawn = pixels.colors(column, row, width).iter().zip(pixels.ids(column, row, width));
                for ((pixel, id), (&color, &drawn)) in rgb.as_chunks_mut().0.iter_mut().zip(ids).zip(drawn) {
                    let drawn = u32::from_le_bytes(drawn);
                    let color = if drawn == NOTHING { background } else { u32::from_le_bytes(color) };
                    let [r, g, b, _] = color.to_le_bytes();
                    *pixel = [r, g, b];
                    *id = if drawn == NOTHING { NO_OBJECT } else { drawn };
                }
            }
        },
    );
    (rgb, ids)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use vantage_dataset::{Camera, Pose};

    fn opened() -> Option<WgpuRenderer> {
        match WgpuRenderer::new() {
            Err(RenderError::NoAdapter { .. }) => {
                println!("skipped: no Vulkan adapter");
                None
            }
            opened => Some(opened.unwrap()),
        }
    }

    fn nothing() -> RenderScene {
        let light = super::super::Light { direction: Vector3::z(), ambient: [1.0; 3], diffuse: [0.0; 3] };
        RenderScene { placements: Vec::new(), light, background: [1, 2, 3] }
    }

    fn shot(width: u32, height: u32) -> Shot {
        let camera = Camera::with_horizontal_fov(width, height, 1.0);
        Shot { camera, world_from_camera: Pose::identity() }
    }

    #[test]
    fn targets_of_many_sizes_make_room_for_each_other() {
        let Some(mut renderer) = opened() else { return };
        let scene = nothing();
        for width in 1..TARGETS as u32 {
            renderer.frame(&scene, &shot(width, 1)).unwrap();
        }
        let tile = TileShot { scene: &scene, shot: shot(16, 8), center: [8.0, 4.0], side: 4.0, target: 1 };
        let side = ATLAS_SIDE / 2;
        assert_eq!(renderer.tiles(&[tile; 5], side).unwrap().len(), 5);
    }

    #[test]
    fn a_lost_device_is_replaced_once() {
        let Some(mut renderer) = opened() else { return };
        let (scene, shot) = (nothing(), shot(16, 8));
        let before = renderer.frame(&scene, &shot).unwrap();
        assert_eq!(before.rgb[..3], [1, 2, 3]);
        renderer.gpu.device.destroy();
        assert_eq!(renderer.frame(&scene, &shot).unwrap(), before);
        let tile = TileShot { scene: &scene, shot, center: [8.0, 4.0], side: 4.0, target: 1 };
        renderer.gpu.device.destroy();
        assert_eq!(renderer.tiles(&[tile], 4).unwrap()[0].rgb[..3], [1, 2, 3]);

        let mut attempts = 0;
        let doomed = renderer.persist(|renderer| {
            attempts += 1;
            renderer.gpu.device.destroy();
            renderer.draw_frame(&scene, &shot)
        });
        let error = doomed.unwrap_err();
        assert!(matches!(error, RenderError::Device { .. }), "{error}");
        assert_eq!(attempts, 2);
        assert_eq!(renderer.frame(&scene, &shot).unwrap(), before);
    }
}
