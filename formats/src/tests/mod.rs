//! What is written can be read by hand, and does not depend on threads, interruptions or damage in between.

mod bop;
mod bop_damage;
mod bop_faults;
mod bop_import;
mod crops;
mod faults;
mod resume;

use super::*;
use nalgebra::{Matrix3, Point3, Rotation3, UnitQuaternion, Vector2, Vector3};
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;
use vantage_dataset::crop::CROP_BYTES;
use vantage_dataset::store::Provenance;
use vantage_dataset::*;

/// A crop like those of a renderer: a shaded, noisy disc.
fn crop(stream: &mut Stream, masked: bool) -> Crop {
    let mut bytes = [0; CROP_BYTES];
    let radius = 6.0 + 9.0 * stream.unit();
    let colour: [f64; 3] = std::array::from_fn(|_| 255.0 * stream.unit());
    for (i, pixel) in bytes.chunks_exact_mut(3).enumerate() {
        let (x, y) = (i as f64 % 32.0 - 15.5, (i / 32) as f64 - 15.5);
        let inside = x * x + y * y < radius * radius;
        if inside || !masked {
            let shade = if inside { 0.7 + x / 60.0 } else { 0.3 + y / 100.0 };
            let noise = 4.0 * stream.normal();
            pixel.iter_mut().zip(colour).for_each(|(value, c)| *value = (shade * c + noise) as u8);
        }
    }
    Crop(Box::new(bytes))
}

fn sample(index: u64, split: Split) -> Sample {
    let mut s = Seed(1).stream("sample", index);
    let object_from_camera = Pose::face_towards(
        &Point3::new(1.0 + s.unit(), s.normal(), s.normal()),
        &Point3::origin(),
        &-Vector3::z(),
    );
    let world_from_object = Pose::translation(s.normal(), s.normal(), s.normal());
    let min = Vector2::new(100.0 * s.unit(), 100.0 * s.unit());
    Sample {
        episode: u64::MAX - index / 7,
        step: (index % 7) as usize,
        timestamp: (index % 7) as f64 / 3.0,
        track: s.below(5),
        instance: InstanceId(s.below(usize::MAX) as u64),
        family: ["mug", "a \"toy\", of sorts", "Tasse grün"][s.below(3)].to_owned(),
        split,
        bounding_box: BoundingBox { min, max: min + Vector2::new(10.0, 20.0) },
        visible_fraction: s.unit(),
        camera: Camera { width: 320, height: 240, fx: 277.1, fy: 280.5, cx: 161.25, cy: 118.0 },
        world_from_camera: world_from_object * object_from_camera,
        object_from_camera,
        viewpoint: if index % 3 == 2 { None } else { Viewpoint::new(&object_from_camera, 0.2) },
        masked_crop: crop(&mut s, true),
        boxed_crop: crop(&mut s, false),
    }
}

/// `n` samples of training, then as many of the test.
fn samples(n: u64) -> Vec<Sample> {
    let of = |split, range: std::ops::Range<u64>| range.map(move |i| sample(i, split));
    of(Split::Train, 0..n).chain(of(Split::Test, n..2 * n)).collect()
}

/// The camera's axes in a world in which it looks along y: x, -z, y.
fn looking_along_y() -> UnitQuaternion<f64> {
    let axes = Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes))
}

fn camera() -> Camera {
    let square = Camera::with_horizontal_fov(64, 48, 1.0);
    Camera { cx: 30.25, fy: 1.1 * square.fx, ..square }
}

/// An upright rectangle, `width` and `height` in metres, that faces the camera.
fn rectangle(width: f32, height: f32, symmetry: Symmetry) -> ObjectModel {
    let (x, z) = (width / 2.0, height / 2.0);
    ObjectModel {
        positions: vec![[-x, 0.0, -z], [x, 0.0, -z], [x, 0.0, z], [-x, 0.0, z]],
        normals: vec![[0.0, -1.0, 0.0]; 4],
        uvs: vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        texture: Some(Texture { width: 2, height: 1, rgba: vec![200, 10, 10, 255, 10, 10, 200, 255] }),
        symmetry,
        licence: (width > 0.3).then(|| "CC-BY-4.0".to_owned()),
    }
}

/// An episode of rectangles, turned by a right angle each: its objects, their meshes, and images in which nearer ones hide others.
struct Rectangles {
    id: u32,
    split: Split,
    objects: Vec<ObjectTruth>,
    models: Vec<ObjectModel>,
    captures: Vec<Capture>,
}

impl Rectangles {
    fn new(id: u32, split: Split, images: usize, camera: Camera) -> Self {
        let mut s = Seed(9).stream("scene", u64::from(id));
        let sizes = [(0.31, 0.22), (0.2, 0.4), (0.12, 0.11)];
        let symmetries = [Symmetry::Cyclic { order: 2 }, Symmetry::None, Symmetry::Revolution];
        let models: Vec<_> =
            sizes.iter().zip(symmetries).map(|(&(w, h), symmetry)| rectangle(w, h, symmetry)).collect();
        let objects: Vec<_> = (0..3)
            .map(|k| ObjectTruth {
                instance: InstanceId(1000 + u64::from(id) % 2 * 10 + k as u64),
                family: "rectangle".to_owned(),
                world_from_object: Pose::new(
                    Vector3::new(0.3 * s.normal(), 2.0 + 0.5 * k as f64, 0.5 + 0.1 * s.normal()),
                    Vector3::y() * (FRAC_PI_2 * k as f64),
                ),
                size: 0.5,
                symmetry: symmetries[k],
                extents: None,
            })
            .collect();
        let captures = (0..images)
            .map(|image| {
                let eye = Vector3::new(0.2 * s.normal(), 0.1 * s.normal(), 0.5 + 0.05 * s.normal());
                let world_from_camera = Pose::from_parts(eye.into(), looking_along_y());
                capture(image as f64, camera, world_from_camera, &objects, &models)
            })
            .collect();
        Self { id, split, objects, models, captures }
    }
}

/// Of each object the box of its silhouette in the image plane: left, right, top, bottom.
fn outline(camera: &Camera, camera_from_object: &Pose, model: &ObjectModel) -> [f64; 4] {
    let corners = model.positions.iter().map(|p| {
        let p = Point3::from(p.map(f64::from));
        camera.project(&(camera_from_object * p)).unwrap()
    });
    corners.fold([f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY], |b, p| {
        [b[0].min(p.x), b[1].max(p.x), b[2].min(p.y), b[3].max(p.y)]
    })
}

fn capture(
    timestamp: f64,
    camera: Camera,
    world_from_camera: Pose,
    truths: &[ObjectTruth],
    models: &[ObjectModel],
) -> Capture {
    let (width, height) = (camera.width as usize, camera.height as usize);
    let mut capture = Capture {
        timestamp,
        camera,
        world_from_camera,
        rgb: (0..3 * width * height).map(|i| (i / 7 % 256) as u8).collect(),
        depth: vec![f32::INFINITY; width * height],
        ids: vec![0; width * height],
        objects: Vec::new(),
    };
    let mut silhouettes = Vec::new();
    for (track, (truth, model)) in truths.iter().zip(models).enumerate() {
        let camera_from_object = world_from_camera.inverse() * truth.world_from_object;
        let [left, right, top, bottom] = outline(&camera, &camera_from_object, model);
        let depth = camera_from_object.translation.z as f32;
        let mut silhouette = vec![false; width * height];
        for (i, in_it) in silhouette.iter_mut().enumerate() {
            let (x, y) = ((i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
            *in_it = (left..right).contains(&x) && (top..bottom).contains(&y);
            if *in_it && depth < capture.depth[i] {
                capture.depth[i] = depth;
                capture.ids[i] = track as u32 + 1;
                capture.rgb[3 * i..3 * i + 3].copy_from_slice(&[60 * track as u8 + 60, 20, 200]);
            }
        }
        silhouettes.push((silhouette, [left, right, top, bottom]));
    }
    for (track, (silhouette, [left, right, top, bottom])) in silhouettes.into_iter().enumerate() {
        let visible: Vec<_> = (0..width * height).filter(|&i| capture.ids[i] == track as u32 + 1).collect();
        let columns = || visible.iter().map(|i| (i % width) as f64);
        let rows = || visible.iter().map(|i| (i / width) as f64);
        if visible.is_empty() {
            continue;
        }
        let low = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::INFINITY, f64::min);
        let high = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max) + 1.0;
        capture.objects.push(CapturedObject {
            track,
            visible_box: BoundingBox {
                min: Vector2::new(low(&mut columns()), low(&mut rows())),
                max: Vector2::new(high(&mut columns()), high(&mut rows())),
            },
            visible_pixels: visible.len() as u32,
            silhouette_box: BoundingBox { min: Vector2::new(left, top), max: Vector2::new(right, bottom) },
            silhouette_pixels: (right - left) * (bottom - top),
            silhouette,
        });
    }
    capture
}

/// Every file below a folder with its bytes.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        if path.is_dir() {
            found.extend(files(&path).into_iter().map(|(below, bytes)| (format!("{name}/{below}"), bytes)));
        } else {
            found.insert(name, fs::read(&path).unwrap());
        }
    }
    found
}

/// The members of an archive, with the rest of what their headers hold.
fn members(path: &Path) -> Vec<(String, Vec<u8>, tar::Header)> {
    let mut archive = tar::Archive::new(File::open(path).unwrap());
    let entries = archive.entries().unwrap().map(|entry| {
        let mut entry = entry.unwrap();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).unwrap();
        (entry.path().unwrap().to_str().unwrap().to_owned(), bytes, entry.header().clone())
    });
    entries.collect()
}

fn provenance() -> Provenance {
    BTreeMap::from([("scene".to_owned(), "a test".into())])
}

fn crop_options(layout: CropLayout, samples_per_shard: u64) -> CropOptions {
    let (name, licence) = ("Crops: \"a test\"".to_owned(), "cc0-1.0".to_owned());
    CropOptions { layout, name, licence, samples_per_shard }
}

fn open_crops(folder: &Path, options: CropOptions) -> (CropWriter, u64) {
    match CropWriter::open(folder, options, provenance()).unwrap() {
        Opened::Unfinished { writer, skip, damage: None } => (writer, skip),
        other => panic!("{other:?}"),
    }
}

fn write_crops(folder: &Path, options: CropOptions, samples: Vec<Sample>) -> LayoutManifest {
    let (mut writer, skip) = open_crops(folder, options);
    assert_eq!(skip, 0);
    push_crops(&mut writer, samples);
    writer.finish().unwrap()
}

fn push_crops(writer: &mut CropWriter, samples: Vec<Sample>) {
    for sample in samples {
        if sample.step == 0 {
            writer.add_licence(sample.instance, "CC-BY-4.0");
        }
        writer.push(sample).unwrap();
    }
}

fn bop_options(layout: BopLayout) -> BopOptions {
    BopOptions { layout, name: "rectangles".to_owned(), camera: camera() }
}

fn open_bop(folder: &Path, options: BopOptions) -> (BopWriter, u64) {
    match BopWriter::open(folder, options, provenance()).unwrap() {
        Opened::Unfinished { writer, skip, damage: None } => (writer, skip),
        other => panic!("{other:?}"),
    }
}

/// Pushes all images but the first `skip`, up to the `end`-th.
fn push_scenes(writer: &mut BopWriter, scenes: &[Rectangles], skip: u64, end: u64) {
    let mut ids = writer.ids();
    let mut at = 0;
    for scene in scenes {
        for (image, capture) in scene.captures.iter().enumerate() {
            if (skip..end).contains(&at) {
                for (truth, model) in scene.objects.iter().zip(&scene.models) {
                    let next = ids.len() as u32 + 1;
                    let id = *ids.entry(truth.instance).or_insert(next);
                    writer.add_model(truth.instance, id, model).unwrap();
                }
                let header = Scene { id: scene.id, split: scene.split, objects: &scene.objects, ids: &ids };
                writer.push(&header, image as u32, capture).unwrap();
            }
            at += 1;
        }
    }
}

fn scenes() -> Vec<Rectangles> {
    let split = |id| if id < 2 { Split::Train } else { Split::Validation };
    (0..4).map(|id| Rectangles::new(id, split(id), 5, camera())).collect()
}

fn write_scenes(folder: &Path, layout: BopLayout, scenes: &[Rectangles]) -> LayoutManifest {
    let (mut writer, skip) = open_bop(folder, bop_options(layout));
    assert_eq!(skip, 0);
    push_scenes(&mut writer, scenes, 0, u64::MAX);
    let (manifest, set_aside) = writer.finish().unwrap();
    assert!(set_aside.is_empty());
    manifest
}

const WEB: BopLayout = BopLayout::WebDataset { images_per_shard: 3 };
