//! A plain-Rust rasterizer: the same bits on any CPU.
//!
//! Coverage is decided in integers (1/256 pixel, top-left rule), texels are filtered in integers, and what is left is
//! IEEE addition, multiplication, division and square root in a fixed order; transfer curves come from tables that the
//! portable `libm` fills. Triangles write only their depth and number; each pixel is then shaded once.

mod canvas;
mod clip;
mod raster;
mod shade;
mod tables;
mod view;

use super::bounds::Bounds;
use super::{Frame, RenderError, RenderScene, Renderer, RendererInfo, Shot, Tile, TileShot};
use canvas::Canvas;
use rayon::prelude::*;
use shade::Shader;
use view::View;

/// The reference renderer.
#[derive(Debug, Default)]
pub struct ReferenceRenderer {
    bounds: Bounds,
    canvas: Canvas,
}

impl ReferenceRenderer {
    /// A renderer; it needs nothing of the machine.
    pub fn new() -> Self {
        Self::default()
    }
}

impl Renderer for ReferenceRenderer {
    fn info(&self) -> RendererInfo {
        RendererInfo { renderer: "reference".into(), adapter: "cpu".into(), driver: String::new() }
    }

    fn frame(&mut self, scene: &RenderScene, shot: &Shot) -> Result<Frame, RenderError> {
        shot.check()?;
        self.bounds.learn(&scene.placements);
        self.canvas.clear(shot.camera.width, shot.camera.height);
        draw(&mut self.canvas, &self.bounds, scene, shot, |_| true);
        let (rgb, ids) = Shader::new(scene).shade(&self.canvas);
        Ok(Frame {
            width: shot.camera.width,
            height: shot.camera.height,
            rgb,
            depth: self.canvas.inverse_depth.iter().map(|inverse| 1.0 / inverse).collect(),
            ids,
        })
    }

    fn tiles(&mut self, shots: &[TileShot<'_>], side: u32) -> Result<Vec<Tile>, RenderError> {
        for shot in shots {
            shot.window(side).check()?;
            self.bounds.learn(&shot.scene.placements);
        }
        let bounds = &self.bounds;
        Ok(shots
            .par_iter()
            .map_init(Canvas::default, |canvas, shot| tile(canvas, bounds, shot, side))
            .collect())
    }
}

fn tile(canvas: &mut Canvas, bounds: &Bounds, shot: &TileShot<'_>, side: u32) -> Tile {
    let window = shot.window(side);
    canvas.clear(side, side);
    draw(canvas, bounds, shot.scene, &window, |id| id == shot.target);
    let amodal_pixels = canvas.covered();
    draw(canvas, bounds, shot.scene, &window, |id| id != shot.target);
    let (rgb, ids) = Shader::new(shot.scene).shade(canvas);
    Tile { side, rgb, ids, amodal_pixels }
}

fn draw(
    canvas: &mut Canvas,
    bounds: &Bounds,
    scene: &RenderScene,
    shot: &Shot,
    wanted: impl Fn(u32) -> bool,
) {
    for (index, placement) in scene.placements.iter().enumerate() {
        if wanted(placement.id) && bounds.meets(placement, shot) {
            let view = View::new(shot, placement, &scene.light);
            canvas.draw(&view, &placement.model.mesh, index as u32);
        }
    }
}
