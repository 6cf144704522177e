//! The reference renderer against geometry, itself, and a golden picture.

mod render_furnished;
mod render_scenes;

use nalgebra::{Point3, Vector3};
use render_scenes::{ball, block, checks, cluttered, light, look_at, placed, scene_of};
use std::sync::Arc;
use vantage_dataset::Camera;
use vantage_sim::mesh::Mesh;
use vantage_sim::model::Model;
use vantage_sim::render::reference::ReferenceRenderer;
use vantage_sim::render::{Frame, NEAR, NO_OBJECT, RenderError, RenderScene, Renderer, Shot, Tile, TileShot};
use vantage_sim::texture::{TEXTURE_SIDE, Texture};

fn frame(scene: &RenderScene, shot: &Shot) -> Frame {
    ReferenceRenderer::new().frame(scene, shot).expect("the shot is possible")
}

fn tile(shot: TileShot<'_>, side: u32) -> Tile {
    ReferenceRenderer::new().tiles(&[shot], side).expect("the shot is possible").remove(0)
}

fn overview() -> Shot {
    look_at([1.3, -0.7, 0.8], [0.0, 0.0, 0.05])
}

fn count(ids: &[u32], id: u32) -> u32 {
    ids.iter().filter(|&&other| other == id).count() as u32
}

/// The point of pixel `index`'s ray at which `z = height` in the world, and its depth.
fn ground_hit(shot: &Shot, index: usize, height: f64) -> Option<(Point3<f64>, f64)> {
    let width = shot.camera.width as usize;
    let pixel = nalgebra::Vector2::new((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
    let ray_in_world = shot.world_from_camera * shot.camera.ray_in_camera(&pixel);
    let eye = Point3::from(shot.world_from_camera.translation.vector);
    let depth = (height - eye.z) / ray_in_world.z;
    (depth > 0.0).then(|| (eye + ray_in_world * depth, depth))
}

#[test]
fn pictures_are_the_same_bits_on_any_machine() {
    let scene = cluttered();
    let frame = frame(&scene, &overview());
    let tile =
        tile(TileShot { scene: &scene, shot: overview(), center: [150.0, 130.0], side: 70.0, target: 2 }, 32);
    let mut hasher = blake3::Hasher::new();
    hasher.update(&frame.rgb);
    hasher.update(bytemuck::cast_slice(&frame.depth));
    hasher.update(bytemuck::cast_slice(&frame.ids));
    hasher.update(&tile.rgb);
    hasher.update(bytemuck::cast_slice(&tile.ids));
    hasher.update(&tile.amodal_pixels.to_le_bytes());
    // Re-mint only with a line in the changelog that says why pictures changed.
    assert_eq!(
        hasher.finalize().to_hex().as_str(),
        "2004808d6a6e164b149d5bdcfa4dad1a819d4dd461fee9ba8a82bf568219585f"
    );
}

#[test]
fn objects_are_the_same_bits_on_any_machine() {
    let (scene, shots) = (render_furnished::scene(), render_furnished::shots(6));
    let mut hasher = blake3::Hasher::new();
    for (i, shot) in shots.iter().enumerate() {
        let frame = frame(&scene, shot);
        hasher.update(&frame.rgb);
        hasher.update(bytemuck::cast_slice(&frame.depth));
        hasher.update(bytemuck::cast_slice(&frame.ids));
        for window in render_furnished::windows(i, &frame) {
            let tile = tile(window.tile(&scene, &shots), 32);
            hasher.update(&tile.rgb);
            hasher.update(bytemuck::cast_slice(&tile.ids));
            hasher.update(&tile.amodal_pixels.to_le_bytes());
        }
    }
    // Re-mint only with a line in the changelog that says why pictures changed.
    assert_eq!(
        hasher.finalize().to_hex().as_str(),
        "dc17034d864159d838127f42a4c0c3f20b14e76d6ca7325756f2d1b9e651f73c"
    );
}

#[test]
fn threads_do_not_change_pictures() {
    let scene = cluttered();
    let shots: Vec<_> = (0..40)
        .map(|i| TileShot {
            scene: &scene,
            shot: overview(),
            center: [60.0 + 5.0 * f64::from(i), 130.0],
            side: 50.0,
            target: 1 + i as u32 % 5,
        })
        .collect();
    let with_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut renderer = ReferenceRenderer::new();
            (renderer.tiles(&shots, 32).unwrap(), renderer.frame(&scene, &overview()).unwrap())
        })
    };
    let alone = with_threads(1);
    assert!(alone == with_threads(3), "three threads drew other pictures than one");
    let (alone, _) = alone;
    for (shot, drawn) in shots.iter().zip(&alone) {
        assert!(*drawn == tile(*shot, 32), "a tile depends on its neighbours");
    }
}

#[test]
fn objects_appear_where_the_camera_projects_them() {
    let camera = Camera { width: 300, height: 200, fx: 260.0, fy: 330.0, cx: 130.0, cy: 110.0 };
    let speck = block([0.004; 3], Texture::plain([255; 3]));
    for (x, y, z) in [(0.1, 0.05, 0.1), (-0.2, 0.2, 0.05), (0.05, -0.25, 0.3), (0.0, 0.0, 0.0)] {
        let shot = Shot { camera, ..look_at([1.0, 0.2, 0.6], [0.0, 0.0, 0.1]) };
        let picture = frame(&scene_of(vec![placed(&speck, [x, y, z], 0.5, 7)]), &shot);
        let pixel =
            camera.project(&shot.world_from_camera.inverse_transform_point(&Point3::new(x, y, z))).unwrap();
        let seen: Vec<_> = (0..picture.ids.len()).filter(|&i| picture.ids[i] == 7).collect();
        assert!(seen.len() >= 4, "{} pixels", seen.len());
        let mean = |coordinate: fn(usize) -> usize| {
            seen.iter().map(|&i| coordinate(i) as f64 + 0.5).sum::<f64>() / seen.len() as f64
        };
        let (column, row) = (mean(|i| i % 300), mean(|i| i / 300));
        assert!(
            (column - pixel.x).abs() < 0.5 && (row - pixel.y).abs() < 0.5,
            "({column}, {row}) for {pixel}"
        );
    }
}

#[test]
fn a_floor_that_crosses_the_near_plane_has_the_depth_and_texture_of_its_rays() {
    // Bright only where u < 1/2, that is where the world's x < 0.
    let halves = (0..TEXTURE_SIDE * TEXTURE_SIDE)
        .map(|i| if i % TEXTURE_SIDE < TEXTURE_SIDE / 2 { [255, 255, 255, 255] } else { [0, 0, 0, 255] })
        .collect();
    let top = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let mesh = Mesh {
        positions: top.map(|[x, y]| [400.0 * x, 400.0 * y, 0.0]).to_vec(),
        normals: vec![[0.0, 0.0, 1.0]; 4],
        uvs: top.map(|[x, y]| [(x + 1.0) / 2.0, (1.0 - y) / 2.0]).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    let floor = Arc::new(Model::new(mesh, Texture::new(halves)));
    let scene = scene_of(vec![placed(&floor, [0.0; 3], 0.0, 3)]);
    let shot = look_at([0.0, -2.0, 5.0], [0.0, 30.0, 3.0]);
    let picture = frame(&scene, &shot);
    let mut checked = [0, 0];
    for (index, &depth) in picture.depth.iter().enumerate() {
        let Some((hit, expected)) = ground_hit(&shot, index, 0.0).filter(|(_, depth)| *depth < 300.0) else {
            continue;
        };
        let got = f64::from(depth);
        // Corners snap to 1/256 pixel, over which 1/depth changes by this.
        let snap = 1.0 / 256.0 / (shot.camera.fy * 5.0);
        assert!((1.0 / got - 1.0 / expected).abs() < snap, "pixel {index}: {got} m, expected {expected} m");
        assert_eq!(picture.ids[index], 3);
        // Up to there the filter is at most 60 m wide.
        if hit.x.abs() > 60.0 && expected < 200.0 {
            assert_eq!(
                picture.rgb[3 * index] > 128,
                hit.x < 0.0,
                "pixel {index} shows ({}, {})",
                hit.x,
                hit.y
            );
            checked[usize::from(hit.x < 0.0)] += 1;
        }
    }
    let sky = (0..picture.ids.len()).filter(|&i| ground_hit(&shot, i, 0.0).is_none());
    for index in sky {
        assert_eq!((picture.ids[index], picture.depth[index]), (NO_OBJECT, f32::INFINITY));
        assert_eq!(picture.rgb[3 * index..3 * index + 3], scene.background);
    }
    assert!(checked[0] > 100 && checked[1] > 100, "{checked:?}");
}

#[test]
fn light_adds_up_in_linear_light() {
    let linear = |level: u8| {
        let c = f64::from(level) / 255.0;
        if c <= 0.04045 { c / 12.92 } else { libm::pow((c + 0.055) / 1.055, 2.4) }
    };
    let level = |l: f64| {
        255.0 * if l <= 0.0031308 { 12.92 * l } else { 1.055 * libm::pow(l.min(1.0), 1.0 / 2.4) - 0.055 }
    };
    for rgb in [[200, 100, 30], [255, 255, 255], [7, 2, 0]] {
        let plain = block([1.0, 1.0, 1.0], Texture::plain(rgb));
        let scene = scene_of(vec![placed(&plain, [0.0; 3], 0.0, 1)]);
        for (eye, normal) in [
            ([0.3, 0.2, 4.0], Vector3::z()),
            ([4.0, 0.2, 0.3], Vector3::x()),
            ([0.2, 4.0, 0.3], Vector3::y()),
        ] {
            let picture = frame(&scene, &look_at(eye, [0.0; 3]));
            let center = 3 * (120 * 320 + 160);
            for channel in 0..3 {
                let light = light();
                let incidence = normal.dot(&light.direction).max(0.0);
                let irradiance =
                    f64::from(light.ambient[channel]) + f64::from(light.diffuse[channel]) * incidence;
                let expected = level(linear(rgb[channel]) * irradiance);
                let got = f64::from(picture.rgb[center + channel]);
                assert!((got - expected).abs() < 1.0, "{rgb:?} from {eye:?}: {got}, expected {expected}");
            }
        }
    }
}

#[test]
fn a_tile_shows_its_window_of_the_frame() {
    let scene = cluttered();
    let whole = frame(&scene, &overview());
    let (left, top, side) = (110, 90, 64);
    let shot = TileShot {
        scene: &scene,
        shot: overview(),
        center: [f64::from(left + side / 2), f64::from(top + side / 2)],
        side: f64::from(side),
        target: 2,
    };
    let same = tile(shot, side as u32);
    let quarter = tile(shot, side as u32 / 2);
    let pixel = |column: i32, row: i32| ((row + top) * 320 + column + left) as usize;
    let mut off = 0.0;
    for row in 0..side {
        for column in 0..side {
            let (there, here) = (pixel(column, row), (row * side + column) as usize);
            assert_eq!(same.ids[here], whole.ids[there], "({column}, {row})");
            for channel in 0..3 {
                let (got, expected) = (same.rgb[3 * here + channel], whole.rgb[3 * there + channel]);
                assert!(got.abs_diff(expected) <= 2, "({column}, {row}): {got}, expected {expected}");
                let coarse = quarter.rgb[3 * ((row / 2) * side / 2 + column / 2) as usize + channel];
                let four = [(0, 0), (0, 1), (1, 0), (1, 1)];
                let mean: f64 = four
                    .iter()
                    .map(|(x, y)| pixel(column / 2 * 2 + x, row / 2 * 2 + y))
                    .map(|i| f64::from(whole.rgb[3 * i + channel]) / 4.0)
                    .sum();
                off += (f64::from(coarse) - mean).abs() / f64::from(3 * side * side);
            }
        }
    }
    assert!(off < 10.0, "a tile at half the resolution is {off} levels off its window's mean");
}

#[test]
fn amodal_pixels_do_not_mind_occluders() {
    let round = ball(0.1, 12, Texture::plain([250, 0, 0]));
    let screen = block([0.01, 0.2, 0.2], Texture::plain([0, 0, 250]));
    let target = placed(&round, [0.0, 0.0, 0.0], 0.0, 4);
    let occluder = placed(&screen, [0.5, 0.2, 0.0], 0.0, 5);
    let free = scene_of(vec![target.clone()]);
    let hidden = scene_of(vec![occluder, target]);
    let shot = look_at([1.5, 0.0, 0.0], [0.0, 0.0, 0.0]);
    let of = |scene, target| tile(TileShot { scene, shot, center: [160.0, 120.0], side: 60.0, target }, 32);
    let (free, hidden, absent) = (of(&free, 4), of(&hidden, 4), of(&hidden, 9));
    let visible = count(&hidden.ids, 4);
    assert_eq!(count(&free.ids, 4), free.amodal_pixels);
    assert_eq!(hidden.amodal_pixels, free.amodal_pixels);
    assert!(visible > free.amodal_pixels / 4 && visible < free.amodal_pixels * 3 / 4, "{visible} visible");
    assert_eq!(absent.amodal_pixels, 0);
    assert!(absent.ids == hidden.ids && absent.rgb == hidden.rgb, "the target changed the picture");
}

#[test]
fn from_within_a_block_its_far_half_is_invisible_and_nothing_panics() {
    let room = block([0.5, 0.5, 0.5], checks(8, [0; 3], [255; 3]));
    let around = scene_of(vec![placed(&room, [0.0; 3], 0.0, 1)]);
    let picture = frame(&around, &look_at([0.1, 0.1, 0.1], [1.0, 0.3, 0.2]));
    assert_eq!(count(&picture.ids, 1), 0, "faces were seen from behind");
    for offset in [0.0, 0.003, 0.0099, 0.01, 0.0101, 0.1, 10.0, 1e5] {
        let shot = look_at([0.5 + offset, 0.02, 0.03], [0.0, 0.45, 0.3]);
        let picture = frame(&around, &shot);
        assert!(picture.depth.iter().all(|&depth| f64::from(depth) > 0.999 * NEAR), "{offset}");
        if (0.0101..1.0).contains(&offset) {
            assert!(count(&picture.ids, 1) > 1000, "{offset}: {}", count(&picture.ids, 1));
        }
    }
}

#[test]
fn a_new_model_is_never_taken_for_a_dropped_one() {
    let mut renderer = ReferenceRenderer::new();
    let shot = look_at([2.0, 0.0, 0.0], [0.0; 3]);
    for round in 1..=20 {
        let cube = block([0.02 * round as f32; 3], Texture::plain([round; 3]));
        let scene = scene_of(vec![placed(&cube, [0.0, 0.6, 0.0], 0.0, 1)]);
        let tile = TileShot { scene: &scene, shot, center: [210.0, 120.0], side: 30.0, target: 1 };
        let reused = renderer.tiles(&[tile], 16).unwrap().remove(0);
        assert!(reused == ReferenceRenderer::new().tiles(&[tile], 16).unwrap().remove(0), "round {round}");
    }
}

#[test]
fn impossible_shots_are_refused() {
    let scene = cluttered();
    let good = overview();
    let with = |change: fn(&mut Shot)| {
        let mut shot = good;
        change(&mut shot);
        shot
    };
    for bad in [
        with(|shot| shot.camera.width = 0),
        with(|shot| shot.camera.height = 5000),
        with(|shot| shot.camera.fx = -1.0),
        with(|shot| shot.camera.cy = f64::NAN),
        with(|shot| shot.world_from_camera.translation.x = f64::INFINITY),
    ] {
        let error = ReferenceRenderer::new().frame(&scene, &bad).unwrap_err();
        assert!(matches!(error, RenderError::Shot { .. }), "{error}");
        assert!(error.to_string().contains("expected sides of 1 to 4096 pixels"), "{error}");
    }
    let tile = TileShot { scene: &scene, shot: good, center: [160.0, 120.0], side: 40.0, target: 1 };
    let sized = |side| TileShot { side, ..tile };
    for (shot, side) in [(tile, 0), (sized(0.0), 32), (sized(-3.0), 32), (sized(f64::NAN), 32)] {
        let error = ReferenceRenderer::new().tiles(&[tile, shot], side).unwrap_err();
        assert!(matches!(error, RenderError::Shot { .. }), "{error}");
    }
    assert_eq!(ReferenceRenderer::new().tiles(&[], 32).unwrap(), []);
}
