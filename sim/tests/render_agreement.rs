//! The wgpu renderer draws what the reference draws.
//!
//! Where no Vulkan adapter is found these tests say so and pass, unless `VANTAGE_REQUIRE_WGPU=1`.

mod render_furnished;
mod render_scenes;

use render_scenes::{ball, block, checks, cluttered, look_at, placed, scene_of};
use std::io::Write;
use vantage_dataset::Camera;
use vantage_sim::render::choice::{RendererChoice, open};
use vantage_sim::render::reference::ReferenceRenderer;
use vantage_sim::render::wgpu::WgpuRenderer;
use vantage_sim::render::{Light, RenderError, RenderScene, Renderer, Shot, TileShot};
use vantage_sim::texture::Texture;

/// Share of pixels whose ids may differ; all of them must lie on edges.
const EDGE_SHARE: f64 = 0.001;
/// Mean absolute difference of colours away from edges, levels.
const MEAN_LEVELS: f64 = 0.5;
/// A difference that few pixels may exceed, levels.
const FAR_LEVELS: u8 = 4;
/// Share of pixels away from edges that may exceed it.
const FAR_SHARE: f64 = 0.001;
/// Relative difference of inverse depths away from edges, beside [`DEPTH_STEP`].
const DEPTH: f32 = 1e-4;
/// Part of the change of inverse depth over a pixel: corners snap to 1/256 pixel.
const DEPTH_STEP: f32 = 0.01;

fn wgpu() -> Option<WgpuRenderer> {
    match WgpuRenderer::new() {
        Ok(renderer) => Some(renderer),
        Err(error @ RenderError::NoAdapter { .. }) => {
            let required = std::env::var("VANTAGE_REQUIRE_WGPU").is_ok_and(|value| value == "1");
            assert!(!required, "VANTAGE_REQUIRE_WGPU=1, but: {error}");
            let _ = writeln!(std::io::stderr(), "SKIPPED: no Vulkan adapter");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

/// Pixels all of whose eight neighbours have their id.
fn inner(ids: &[u32], width: usize) -> Vec<bool> {
    let height = ids.len() / width;
    let near = |i: usize, end: usize| i.saturating_sub(1)..(i + 2).min(end);
    (0..ids.len())
        .map(|i| {
            let (row, column) = (i / width, i % width);
            near(row, height).all(|y| near(column, width).all(|x| ids[y * width + x] == ids[i]))
        })
        .collect()
}

/// How two pictures differ.
#[derive(Debug, Default)]
struct Difference {
    pixels: usize,
    inner: usize,
    ids: usize,
    levels: u64,
    far: usize,
    depths: usize,
}

impl Difference {
    fn add(&mut self, expected: (&[u8], &[u32]), got: (&[u8], &[u32]), width: usize) {
        let inner = inner(expected.1, width);
        self.pixels += inner.len();
        for (i, inner) in inner.into_iter().enumerate() {
            let same = expected.1[i] == got.1[i];
            assert!(same || !inner, "pixel {i} has id {}, expected {}", got.1[i], expected.1[i]);
            self.ids += usize::from(!same);
            if inner {
                let pixel = 3 * i..3 * i + 3;
                let levels = expected.0[pixel.clone()].iter().zip(&got.0[pixel]).map(|(a, b)| a.abs_diff(*b));
                self.inner += 1;
                self.levels += levels.clone().map(u64::from).sum::<u64>();
                self.far += usize::from(levels.max() > Some(FAR_LEVELS));
            }
        }
    }

    fn check(&self) {
        let mean = self.levels as f64 / (3 * self.inner) as f64;
        println!("{self:?}: {mean:.3} levels");
        assert!(self.ids as f64 <= EDGE_SHARE * self.pixels as f64, "ids: {self:?}");
        assert!(mean <= MEAN_LEVELS, "{mean} levels");
        assert!(self.far as f64 <= FAR_SHARE * self.inner as f64, "far: {self:?}");
    }
}

fn compare_frames(wgpu: &mut WgpuRenderer, scene: &RenderScene, shots: &[Shot]) {
    let difference = difference(wgpu, scene, shots);
    assert_eq!(difference.depths, 0, "depths: {difference:?}");
    difference.check();
}

fn difference(wgpu: &mut WgpuRenderer, scene: &RenderScene, shots: &[Shot]) -> Difference {
    let mut difference = Difference::default();
    for shot in shots {
        let expected = ReferenceRenderer::new().frame(scene, shot).expect("the reference renders");
        let got = wgpu.frame(scene, shot).expect("wgpu renders");
        let width = shot.camera.width as usize;
        difference.add((&expected.rgb, &expected.ids), (&got.rgb, &got.ids), width);
        let inner = inner(&expected.ids, width);
        for i in (0..inner.len()).filter(|&i| inner[i]) {
            let nearness = |i: usize| 1.0 / expected.depth[i];
            let neighbours = [i.saturating_sub(1), i + 1, i.saturating_sub(width), i + width];
            let step = neighbours
                .into_iter()
                .filter(|&j| j < inner.len())
                .map(|j| (nearness(j) - nearness(i)).abs())
                .fold(0.0, f32::max);
            let off = (1.0 / got.depth[i] - nearness(i)).abs();
            difference.depths += usize::from(off > DEPTH * nearness(i) + DEPTH_STEP * step);
        }
    }
    difference
}

fn compare_tiles(wgpu: &mut WgpuRenderer, shots: &[TileShot<'_>], side: u32) {
    let expected = ReferenceRenderer::new().tiles(shots, side).expect("the reference renders");
    let got = wgpu.tiles(shots, side).expect("wgpu renders");
    assert_eq!(got.len(), shots.len());
    let mut difference = Difference::default();
    let (mut amodal, mut off) = (0, 0);
    for (expected, got) in expected.iter().zip(&got) {
        difference.add((&expected.rgb, &expected.ids), (&got.rgb, &got.ids), side as usize);
        amodal += u64::from(expected.amodal_pixels);
        off += u64::from(expected.amodal_pixels.abs_diff(got.amodal_pixels));
    }
    difference.check();
    assert!(amodal > 0 && off * 1000 <= amodal, "amodal pixels: {off} of {amodal} off");
}

fn viewpoints() -> Vec<Shot> {
    (0..8)
        .map(|i| {
            let (sin, cos) = libm::sincos(0.8 * f64::from(i));
            let distance = 0.5 + 0.3 * f64::from(i % 4);
            look_at([distance * cos, distance * sin, 0.3 + 0.1 * f64::from(i % 3)], [0.05, 0.0, 0.1])
        })
        .collect()
}

#[test]
fn frames_agree() {
    let Some(mut wgpu) = wgpu() else { return };
    compare_frames(&mut wgpu, &cluttered(), &viewpoints());
}

#[test]
fn frames_of_many_sizes_agree() {
    let Some(mut wgpu) = wgpu() else { return };
    let scene = cluttered();
    let shots: Vec<_> = (0..12)
        .map(|i| {
            let camera =
                Camera { fy: 90.0, cy: 40.5, ..Camera::with_horizontal_fov(63 + 40 * i, 91 + i, 1.2) };
            Shot { camera, ..viewpoints()[i as usize % 8] }
        })
        .collect();
    compare_frames(&mut wgpu, &scene, &shots);
}

#[test]
fn frames_agree_across_the_near_plane() {
    let Some(mut wgpu) = wgpu() else { return };
    let tower = block([0.3, 0.3, 1.0], checks(16, [20, 40, 60], [240, 220, 200]));
    let floor = block([50.0, 50.0, 0.1], checks(32, [90, 90, 80], [120, 140, 110]));
    let scene =
        scene_of(vec![placed(&floor, [0.0, 0.0, -0.1], 0.0, 5), placed(&tower, [0.0, 0.0, 0.5], 0.3, 6)]);
    let shots = [
        look_at([0.5, 0.0, 0.3], [0.0, 1.5, 0.4]),
        look_at([0.42, 0.0, 0.3], [0.2, 1.0, 0.4]),
        look_at([0.0, 0.5, 0.02], [0.6, 0.0, 0.1]),
    ];
    compare_frames(&mut wgpu, &scene, &shots);
}

#[test]
fn objects_agree() {
    let Some(mut wgpu) = wgpu() else { return };
    let (scene, shots) = (render_furnished::scene(), render_furnished::shots(12));
    let difference = difference(&mut wgpu, &scene, &shots);
    difference.check();
    // Slivers on the objects' bevels turn with the snapping of their corners.
    assert!(difference.depths as f64 <= FAR_SHARE * difference.inner as f64, "depths: {difference:?}");
    let mut reference = ReferenceRenderer::new();
    let windows: Vec<_> = (0..shots.len())
        .flat_map(|i| render_furnished::windows(i, &reference.frame(&scene, &shots[i]).unwrap()))
        .collect();
    let tiles: Vec<_> = windows.iter().map(|window| window.tile(&scene, &shots)).collect();
    compare_tiles(&mut wgpu, &tiles, 32);
}

#[test]
fn tiles_agree_over_several_atlases() {
    let Some(mut wgpu) = wgpu() else { return };
    let scene = cluttered();
    let few = scene_of(scene.placements[..3].to_vec());
    // A third of the tiles in another light, by which they are shaded apart.
    let dim = Light { ambient: [0.2, 0.15, 0.1], diffuse: [0.3; 3], ..few.light };
    let dim = RenderScene { background: [3, 2, 1], light: dim, ..few };
    let viewpoints = viewpoints();
    for (side, count) in [(32, 1500), (200, 60), (1100, 3)] {
        let shots: Vec<_> = (0..count)
            .map(|i| TileShot {
                scene: if i % 3 == 0 { &dim } else { &scene },
                shot: viewpoints[i % 8],
                center: [125.0 + (i % 25) as f64 * 3.0, 95.0 + (i % 17) as f64 * 3.0],
                side: 20.0 + (i % 90) as f64,
                target: 1 + (i % 5) as u32,
            })
            .collect();
        compare_tiles(&mut wgpu, &shots, side);
    }
}

/// Tiles of nearly whole images, each with another target.
fn wide_tiles<'a>(scene: &'a RenderScene, shots: &[Shot], count: usize) -> Vec<TileShot<'a>> {
    let tile = |i: usize| TileShot {
        scene,
        shot: shots[i % shots.len()],
        center: [160.0, 120.0],
        side: 220.0,
        target: scene.placements[(i * 37 + 190) % scene.placements.len()].id,
    };
    (0..count).map(tile).collect()
}

#[test]
fn more_placements_than_a_pass_draws_agree() {
    let Some(mut wgpu) = wgpu() else { return };
    let model = block([0.02, 0.02, 0.05], checks(64, [200, 40, 30], [30, 220, 250]));
    let place = |i: u16| {
        let (row, column) = (f64::from(i / 20), f64::from(i % 20));
        placed(&model, [0.06 * row - 0.6, 0.06 * column - 0.6, 0.05], 0.2, u32::from(i) + 1)
    };
    let scene = scene_of((0..400).map(place).collect());
    let tiles = wide_tiles(&scene, &viewpoints(), 64);
    compare_tiles(&mut wgpu, &tiles, 32);
}

#[test]
fn more_models_than_the_device_holds_agree() {
    let Some(mut wgpu) = wgpu() else { return };
    let place = |i: u16| {
        let (row, column) = (f64::from(i / 20), f64::from(i % 20));
        let plain = Texture::plain([(i % 20 * 12) as u8, (i / 20 * 12) as u8, 128]);
        placed(
            &block([0.02, 0.02, 0.05], plain),
            [0.06 * row - 0.6, 0.06 * column - 0.6, 0.05],
            0.2,
            u32::from(i),
        )
    };
    let scene = scene_of((0..400).map(place).collect());
    let shots = viewpoints();
    compare_frames(&mut wgpu, &scene, &shots[..3]);
    compare_tiles(&mut wgpu, &wide_tiles(&scene, &shots, 16), 48);
    let again = wgpu.frame(&scene, &shots[0]).unwrap();
    assert!(again == wgpu.frame(&scene, &shots[0]).unwrap(), "the same frame came out differently");
}

/// A gradient along u and stripes of four texels along v.
fn striped(side: usize, red: u8) -> Texture {
    let texel = |i: usize| {
        let stripe = if (i / side / 4).is_multiple_of(2) { 40 } else { 220 };
        [red, stripe, (i % side * 255 / side) as u8, 255]
    };
    Texture::new((0..side * side).map(texel).collect())
}

#[test]
fn textures_of_all_sides_agree() {
    let Some(mut wgpu) = wgpu() else { return };
    let place = |i: u32| {
        let (row, column) = (f64::from(i / 8), f64::from(i % 8));
        let texture = striped([128, 256, 512][i as usize % 3], (i * 5) as u8);
        placed(&block([0.05, 0.05, 0.1], texture), [0.15 * row - 0.5, 0.15 * column - 0.5, 0.1], 0.3, i + 1)
    };
    let few = scene_of((0..6).map(place).collect());
    compare_frames(&mut wgpu, &few, &viewpoints()[..2]);
    let many = scene_of((0..60).map(place).collect());
    compare_frames(&mut wgpu, &many, &viewpoints()[..3]);
}

#[test]
fn large_models_agree() {
    let Some(mut wgpu) = wgpu() else { return };
    let balls: Vec<_> = (0..5).map(|i| ball(0.2, 230 + i, striped(512, 40 * i as u8))).collect();
    assert!(balls.iter().all(|ball| ball.mesh.triangles.len() > 100_000));
    let place = |i: usize| placed(&balls[i], [0.3 * i as f64 - 0.6, 0.0, 0.2], 0.4, i as u32 + 1);
    let scene = scene_of((0..balls.len()).map(place).collect());
    let difference = difference(&mut wgpu, &scene, &viewpoints()[..2]);
    difference.check();
    // Triangles smaller than the grid that corners snap to.
    assert!(difference.depths as f64 <= FAR_SHARE * difference.inner as f64, "depths: {difference:?}");
}

#[test]
fn a_new_model_is_never_taken_for_a_dropped_one() {
    let Some(mut wgpu) = wgpu() else { return };
    let shot = look_at([2.0, 0.0, 0.0], [0.0; 3]);
    for round in 1..=20 {
        let cube = block([0.02 * round as f32; 3], Texture::plain([10 * round; 3]));
        let scene = scene_of(vec![placed(&cube, [0.0, 0.3, 0.0], 0.0, 1)]);
        compare_frames(&mut wgpu, &scene, &[shot]);
    }
}

#[test]
fn auto_is_wgpu_where_there_is_an_adapter() {
    let Some(wgpu) = wgpu() else { return };
    let opened = open(RendererChoice::Auto).unwrap();
    assert_eq!((opened.renderer.info(), opened.notice), (wgpu.info(), None));
    assert!(!wgpu.info().adapter.is_empty() && !wgpu.info().driver.is_empty(), "{:?}", wgpu.info());
}
