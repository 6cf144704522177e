use super::*;
use crate::rle::Rle;
use serde_json::Value;

pub(super) fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    serde_json::from_value(value.clone()).unwrap()
}

fn grey(path: &Path) -> Vec<u16> {
    image::open(path).unwrap().into_luma16().into_raw()
}

/// Pixels of a mesh file's vertices by the annotations alone, pixel centres at whole numbers.
fn projected(ply: &str, camera: &Value, gt: &Value) -> Vec<[f64; 2]> {
    let (header, body) = ply.split_once("end_header\n").unwrap();
    let count = header.lines().find_map(|line| line.strip_prefix("element vertex ")).unwrap();
    let (k, r, t) = (numbers(&camera["cam_K"]), numbers(&gt["cam_R_m2c"]), numbers(&gt["cam_t_m2c"]));
    let project = |line: &str| {
        let p: Vec<f64> = line.split(' ').map(|number| number.parse().unwrap()).collect();
        let q: [f64; 3] = std::array::from_fn(|i| (0..3).map(|j| r[3 * i + j] * p[j]).sum::<f64>() + t[i]);
        let w: [f64; 3] = std::array::from_fn(|i| (0..3).map(|j| k[3 * i + j] * q[j]).sum::<f64>());
        [w[0] / w[2], w[1] / w[2]]
    };
    body.lines().take(count.parse().unwrap()).map(project).collect()
}

#[test]
fn meshes_project_onto_their_masks() {
    let folder = tempfile::tempdir().unwrap();
    let scenes = scenes();
    let manifest = write_scenes(folder.path(), BopLayout::Scenes, &scenes);
    let names: Vec<_> = manifest.shards.iter().map(|shard| shard.name.as_str()).collect();
    assert_eq!(names, ["train/000000", "train/000001", "val/000002", "val/000003"]);
    let (mut checked, mut cut) = (0, 0);
    for (name, scene) in names.iter().zip(&scenes) {
        let folder = folder.path().join(name);
        let cameras = json(&folder.join("scene_camera.json"));
        let gt = json(&folder.join("scene_gt.json"));
        let info = json(&folder.join("scene_gt_info.json"));
        for (image, capture) in scene.captures.iter().enumerate() {
            let key = image.to_string();
            let depth = grey(&folder.join(format!("depth/{image:06}.png")));
            let expected =
                capture.depth.iter().map(|d| if d.is_finite() { (d * 1000.0).round() } else { 0.0 });
            assert!(depth.iter().zip(expected).all(|(&found, d)| (f32::from(found) - d).abs() <= 1.0));
            let rgb = image::open(folder.join(format!("rgb/{image:06}.png"))).unwrap().into_rgb8();
            assert_eq!(rgb.into_raw(), capture.rgb);
            for (i, object) in capture.objects.iter().enumerate() {
                let (gt, info) = (&gt[&key][i], &info[&key][i]);
                let id = gt["obj_id"].as_u64().unwrap();
                let models = folder.join("../../models");
                let ply = fs::read_to_string(models.join(format!("obj_{id:06}.ply"))).unwrap();
                let points = projected(&ply, &cameras[&key], gt);
                let bound = |axis: usize, pick: fn(f64, f64) -> f64| {
                    points.iter().map(|p| p[axis]).reduce(pick).unwrap()
                };
                let (left, right) = (bound(0, f64::min), bound(0, f64::max));
                let (top, bottom) = (bound(1, f64::min), bound(1, f64::max));
                let mask = grey(&folder.join(format!("mask/{image:06}_{i:06}.png")));
                for (pixel, &value) in mask.iter().enumerate() {
                    let (x, y) = ((pixel % 64) as f64, (pixel / 64) as f64);
                    let inside = (left..right).contains(&x) && (top..bottom).contains(&y);
                    assert_eq!(
                        value != 0,
                        inside,
                        "{name} {image} {i} ({x}, {y}) {left} {right} {top} {bottom}"
                    );
                }
                let visible = grey(&folder.join(format!("mask_visib/{image:06}_{i:06}.png")));
                let seen: Vec<_> = visible.iter().map(|&value| value != 0).collect();
                let id = object.track as u32 + 1;
                assert_eq!(seen, capture.ids.iter().map(|&pixel| pixel == id).collect::<Vec<_>>());
                checked += 1;

                assert_eq!(info["px_count_visib"], object.visible_pixels);
                let drawn = object.silhouette.iter().filter(|&&inside| inside).count();
                assert_eq!(info["px_count_valid"], drawn, "every pixel of the silhouette has a depth");
                let share = f64::from(object.visible_pixels) / info["px_count_all"].as_f64().unwrap();
                assert_eq!(info["visib_fract"], share);
                let b = object.visible_box;
                let (w, h) = (b.max.x - 1.0 - b.min.x, b.max.y - 1.0 - b.min.y);
                assert_eq!(numbers(&info["bbox_visib"]), [b.min.x, b.min.y, w, h]);
                let whole = numbers(&info["bbox_obj"]);
                assert!((whole[0] - (left + 0.5).floor()).abs() < 1e-9, "{whole:?} {left}");
                assert!((whole[0] + whole[2] - ((right + 0.5).ceil() - 1.0)).abs() < 1e-9);
                cut += usize::from(drawn < object.silhouette_pixels as usize * 9 / 10);
            }
        }
    }
    assert!(checked > 30 && cut > 0, "{checked} objects, {cut} of them cut off by the image's border");
}

#[test]
fn world_poses_chain_to_object_poses() {
    let folder = tempfile::tempdir().unwrap();
    let scene = &scenes()[..1];
    write_scenes(folder.path(), BopLayout::Scenes, scene);
    let camera = &json(&folder.path().join("train/000000/scene_camera.json"))["0"];
    let gts = &json(&folder.path().join("train/000000/scene_gt.json"))["0"];
    let matrix = |value: &Value| Matrix3::from_row_slice(&numbers(value));
    let vector = |value: &Value| Vector3::from_column_slice(&numbers(value));
    for (object, gt) in scene[0].captures[0].objects.iter().zip(gts.as_array().unwrap()) {
        let world_from_object = scene[0].objects[object.track].world_from_object;
        let in_world = world_from_object.translation.vector * 1000.0;
        let in_camera = matrix(&camera["cam_R_w2c"]) * in_world + vector(&camera["cam_t_w2c"]);
        assert!((in_camera - vector(&gt["cam_t_m2c"])).norm() < 1e-9);
        let turned = matrix(&camera["cam_R_w2c"]) * world_from_object.rotation.to_rotation_matrix().matrix();
        assert!((turned - matrix(&gt["cam_R_m2c"])).norm() < 1e-12);
    }
    assert_eq!(numbers(&camera["cam_K"])[2], 29.75, "half a pixel less than cx = 30.25");
}

#[test]
fn models_are_described() {
    let folder = tempfile::tempdir().unwrap();
    write_scenes(folder.path(), BopLayout::Scenes, &scenes());
    let infos = json(&folder.path().join("models/models_info.json"));
    assert_eq!(infos.as_object().unwrap().len(), 6);
    let first = &infos["1"];
    let expected = [("diameter", 310f64.hypot(220.0)), ("min_x", -155.0), ("size_z", 220.0), ("size_y", 0.0)];
    for (field, value) in expected {
        assert!((first[field].as_f64().unwrap() - value).abs() < 1e-4, "{field} {}", first[field]);
    }
    let half_turn = numbers(&first["symmetries_discrete"][0]);
    assert_eq!(half_turn.len(), 16);
    assert!((half_turn[0] + 1.0).abs() < 1e-15 && half_turn[10] == 1.0);
    assert!(infos["2"].get("symmetries_discrete").is_none());
    assert_eq!(infos["3"]["symmetries_continuous"][0]["axis"], serde_json::json!([0, 0, 1]));
    let ply = fs::read_to_string(folder.path().join("models/obj_000001.ply")).unwrap();
    assert!(ply.contains("comment TextureFile obj_000001.png\nelement vertex 4\n"));
    assert!(ply.contains("\n-155 0 -110 0 -1 0 0 0\n"), "millimetres, and v up: {ply}");
    let texture = image::open(folder.path().join("models/obj_000001.png")).unwrap().into_rgba8();
    assert_eq!(texture.into_raw(), [200, 10, 10, 255, 10, 10, 200, 255]);
    let camera = json(&folder.path().join("camera.json"));
    assert_eq!((camera["cx"].as_f64(), camera["width"].as_u64()), (Some(29.75), Some(64)));
}

#[test]
fn coco_annotations_are_those_of_the_masks() {
    let folder = tempfile::tempdir().unwrap();
    let scenes = scenes();
    write_scenes(folder.path(), BopLayout::Scenes, &scenes[..1]);
    let coco = json(&folder.path().join("train/000000/scene_gt_coco.json"));
    let objects: Vec<_> = scenes[0]
        .captures
        .iter()
        .enumerate()
        .flat_map(|(image, capture)| capture.objects.iter().map(move |object| (image, capture, object)))
        .collect();
    let annotations = coco["annotations"].as_array().unwrap();
    assert_eq!(annotations.len(), objects.len());
    for (i, (annotation, (image, capture, object))) in annotations.iter().zip(objects).enumerate() {
        assert_eq!((&annotation["id"], &annotation["image_id"]), (&(i + 1).into(), &image.into()));
        let rle: Rle = serde_json::from_value(annotation["segmentation"].clone()).unwrap();
        let id = object.track as u32 + 1;
        assert_eq!(rle.decode().unwrap(), capture.ids.iter().map(|&p| p == id).collect::<Vec<_>>());
        assert_eq!(annotation["area"], object.visible_pixels);
        let drawn = object.silhouette.iter().filter(|&&inside| inside).count();
        let bbox = numbers(&annotation["bbox"]);
        assert_eq!(bbox[2] * bbox[3], drawn as f64, "a rectangle fills its box");
    }
}

#[test]
fn shards_say_the_same_as_scenes() {
    let (folders, shards) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let scenes = scenes();
    write_scenes(folders.path(), BopLayout::Scenes, &scenes);
    let manifest = write_scenes(shards.path(), WEB, &scenes);
    let names: Vec<_> = manifest.shards.iter().map(|shard| (shard.name.as_str(), shard.samples)).collect();
    let train = [3, 3, 3, 1].iter().enumerate().map(|(i, &n)| (format!("train_web/shard-{i:06}.tar"), n));
    let val = [3, 3, 3, 1].iter().enumerate().map(|(i, &n)| (format!("val_web/shard-{i:06}.tar"), n));
    let expected: Vec<_> = train.chain(val).collect();
    assert!(names.iter().zip(&expected).all(|(a, b)| a.0 == b.0 && a.1 == b.1) && names.len() == 8);
    let keys = json(&shards.path().join("train_web/key_to_shard.json"));
    assert_eq!(keys.as_object().unwrap().len(), 10);
    for (name, _) in names {
        let members = members(&shards.path().join(name));
        for parts in members.chunks(7) {
            let (key, _) = parts[0].0.split_once('.').unwrap();
            let endings: Vec<_> = parts.iter().map(|(name, _, _)| name.strip_prefix(key).unwrap()).collect();
            assert_eq!(
                endings,
                [
                    ".rgb.jpg",
                    ".depth.png",
                    ".camera.json",
                    ".gt.json",
                    ".gt_info.json",
                    ".mask.json",
                    ".mask_visib.json"
                ]
            );
            if name.starts_with("train") {
                let shard = keys[key].as_u64().unwrap();
                assert!(name.ends_with(&format!("{shard:06}.tar")), "{key} in {name}");
            }
            let (scene, image) = key.split_once('_').unwrap();
            let folder = folders.path().join(name.split_once('_').unwrap().0).join(scene);
            let image: usize = image.parse().unwrap();
            for (part, file) in [(2, "scene_camera"), (3, "scene_gt"), (4, "scene_gt_info")] {
                let found: Value = serde_json::from_slice(&parts[part].1).unwrap();
                assert_eq!(found, json(&folder.join(format!("{file}.json")))[image.to_string()]);
            }
            for (part, file) in [(5, "mask"), (6, "mask_visib")] {
                let masks: BTreeMap<usize, Rle> = serde_json::from_slice(&parts[part].1).unwrap();
                for (i, rle) in masks {
                    let png = grey(&folder.join(format!("{file}/{image:06}_{i:06}.png")));
                    assert_eq!(rle.decode().unwrap(), png.iter().map(|&v| v != 0).collect::<Vec<_>>());
                }
            }
            assert_eq!(parts[1].1, fs::read(folder.join(format!("depth/{image:06}.png"))).unwrap());
            let jpeg = image::load_from_memory_with_format(&parts[0].1, image::ImageFormat::Jpeg).unwrap();
            let rgb = image::open(folder.join(format!("rgb/{image:06}.png"))).unwrap().into_rgb8();
            let error = |(a, b): (&u8, &u8)| f64::from(a.abs_diff(*b));
            let jpeg = jpeg.into_rgb8();
            let mean = jpeg.iter().zip(rgb.iter()).map(error).sum::<f64>() / rgb.len() as f64;
            assert!(mean < 8.0, "a mean difference of {mean}");
        }
    }
}
