//! A plain-Rust rasterizer: the same bits on any CPU.
//!
//! Coverage is decided in integers (1/256 pixel, top-left rule), texels are filtered in integers, and what is left is
//! IEEE addition, multiplication, division and square root in a fixed order; the transfer curve comes from a table that the
//! portable `libm` fills. Triangles write only their depth and number; each pixel is then shaded once.

mod canvas;
mod clip;
mod raster;
mod runs;
mod shade;
mod tables;

use super::bounds::Frustum;
use super::view::View;
use super::{Frame, NO_OBJECT, RenderError, RenderScene, Renderer, RendererInfo, Shot, Tile, TileShot};
use canvas::Canvas;
use rayon::prelude::*;
use shade::{Batch, Shader};
use vantage_dataset::widest::widest;

/// Rows of a frame that are shaded together.
const BAND: usize = 16;

/// The reference renderer.
#[derive(Debug)]
pub struct ReferenceRenderer {
    canvas: Canvas,
}

impl ReferenceRenderer {
    /// A renderer; it needs nothing of the machine.
    pub fn new() -> Self {
        Self { canvas: Canvas::default() }
    }
}

impl Default for ReferenceRenderer {
    fn default() -> Self {
        Self::new()
    }
}

impl Renderer for ReferenceRenderer {
    fn info(&self) -> RendererInfo {
        RendererInfo { renderer: "reference".into(), adapter: "cpu".into(), driver: String::new() }
    }

    fn frame(&mut self, scene: &RenderScene, shot: &Shot) -> Result<Frame, RenderError> {
        shot.check()?;
        let (width, height) = (shot.camera.width, shot.camera.height);
        let canvas = &mut self.canvas;
        canvas.clear(width, height);
        widest(
            #[inline(always)]
            || draw(canvas, &Frustum::of(shot), scene, shot, |_| true),
        );
        let pixels = canvas.nearest().len();
        let (mut rgb, mut ids, mut depth) = (vec![0; 3 * pixels], vec![NO_OBJECT; pixels], vec![0.0; pixels]);
        let band = BAND * width as usize;
        let outputs =
            rgb.par_chunks_mut(3 * band).zip(ids.par_chunks_mut(band)).zip(depth.par_chunks_mut(band));
        let inputs = canvas.nearest().par_chunks(band).zip(canvas.inverse_depth().par_chunks(band));
        outputs.zip(inputs).enumerate().for_each(|(number, (((rgb, ids), depth), pixels))| {
            widest(
                #[inline(always)]
                || {
                    shade(canvas, scene, BAND * number, pixels, (rgb, ids));
                    for (depth, inverse) in depth.iter_mut().zip(pixels.1) {
                        *depth = 1.0 / inverse;
                    }
                },
            );
        });
        Ok(Frame { width, height, rgb, depth, ids })
    }

    fn tiles(&mut self, shots: &[TileShot<'_>], side: u32) -> Result<Vec<Tile>, RenderError> {
        for shot in shots {
            shot.window(side).check()?;
        }
        Ok(shots
            .par_iter()
            .map_init(Canvas::default, |canvas, shot| {
                widest(
                    #[inline(always)]
                    || tile(canvas, shot, side),
                )
            })
            .collect())
    }
}

#[inline(always)]
fn tile(canvas: &mut Canvas, shot: &TileShot<'_>, side: u32) -> Tile {
    let window = shot.window(side);
    let frustum = Frustum::of(&window);
    canvas.clear(side, side);
    draw(canvas, &frustum, shot.scene, &window, |id| id == shot.target);
    let amodal_pixels = canvas.covered();
    draw(canvas, &frustum, shot.scene, &window, |id| id != shot.target);
    let pixels = (side * side) as usize;
    let (mut rgb, mut ids) = (vec![0; 3 * pixels], vec![NO_OBJECT; pixels]);
    shade(canvas, shot.scene, 0, (canvas.nearest(), canvas.inverse_depth()), (&mut rgb, &mut ids));
    Tile { side, rgb, ids, amodal_pixels }
}

#[inline(always)]
fn draw(
    canvas: &mut Canvas,
    frustum: &Frustum<'_>,
    scene: &RenderScene,
    shot: &Shot,
    wanted: impl Fn(u32) -> bool,
) {
    for (index, placement) in scene.placements.iter().enumerate() {
        if !wanted(placement.id) {
            continue;
        }
        if let Some(level) = frustum.level(placement) {
            let view = View::new(shot, placement, &scene.light);
            canvas.draw(&view, placement.model.mesh_at(level), index as u32);
        }
    }
}

/// Shades the rows from `top` on.
#[inline(always)]
fn shade(
    canvas: &Canvas,
    scene: &RenderScene,
    top: usize,
    (nearest, inverse_depth): (&[u32], &[f32]),
    (rgb, ids): (&mut [u8], &mut [u32]),
) {
    let width = canvas.width as usize;
    let shader = Shader::new(scene);
    let mut batch = Batch::default();
    let rows = nearest.chunks_exact(width).zip(inverse_depth.chunks_exact(width));
    let outputs = rgb.as_chunks_mut().0.chunks_exact_mut(width).zip(ids.chunks_exact_mut(width));
    for ((row, row_in), row_out) in (top as i32..).zip(rows).zip(outputs) {
        shader.shade_row(&mut batch, &canvas.facets, row, row_in, row_out);
    }
}
