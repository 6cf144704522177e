//! Datasets in BOP's layout: what is read can be stored, whatever the bytes of one of the files.
//!
//! The first byte says which file of a tiny dataset the others take the place of, in the order of their names.

#![no_main]

use libfuzzer_sys::fuzz_target;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::Path;
use std::sync::LazyLock;
use vantage_dataset::store::{Provenance, write_episode};
use vantage_dataset::{Camera, Pose};
use vantage_formats::{
    BopArrangement, BopScenes, DetectionLimits, ImportError, ImportReport, MeshGeometry, Silhouettes,
};

/// As few as make an episode.
const IMAGES: u32 = 3;
/// Of one model; one alone would have moved as well as the camera.
const OBJECTS: u32 = 2;
/// Pixels, of width and of height.
const SIDE: u32 = 16;
const ALL: DetectionLimits = DetectionLimits { min_visible_fraction: 0.0, min_mask_pixels: 1 };

static FILES: LazyLock<BTreeMap<String, Vec<u8>>> = LazyLock::new(|| {
    let files = tiny_dataset();
    let whole = tempfile::tempdir().expect("a temporary folder");
    let read = read(&files, whole.path()).expect("a dataset");
    assert_eq!(read[0].episode.observations.detections.len(), (IMAGES * OBJECTS) as usize);
    files
});

fuzz_target!(init: { LazyLock::force(&FILES); }, |bytes: &[u8]| {
    let Some((&which, bytes)) = bytes.split_first() else { return };
    let mut files = FILES.clone();
    let replaced = files.values_mut().nth(usize::from(which) % FILES.len()).expect("a file");
    *replaced = bytes.to_vec();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let Ok(arrangements) = read(&files, folder.path()) else { return };
    for BopArrangement { name, episode } in arrangements {
        write_episode(&folder.path().join(name), &episode, Provenance::new()).expect("an episode");
    }
});

/// All masks are there, and nothing is drawn.
struct Never;

impl Silhouettes for Never {
    fn ids(&mut self, _: &Camera, _: &[(&MeshGeometry, Pose)]) -> Result<Vec<u32>, String> {
        Err("drawn".to_owned())
    }
}

fn read(files: &BTreeMap<String, Vec<u8>>, folder: &Path) -> Result<Vec<BopArrangement>, ImportError> {
    for (name, bytes) in files {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(path, bytes).expect("a file");
    }
    let mut report = ImportReport::default();
    let bop = BopScenes::open(folder, &mut report)?;
    bop.read(&bop.scenes[0], &ALL, &mut Never, &mut report)
}

/// A camera that passes two triangles of ten centimetres.
fn tiny_dataset() -> BTreeMap<String, Vec<u8>> {
    let of_images = |entry: &dyn Fn(u32) -> Value| {
        let entries: Map<String, Value> =
            (0..IMAGES).map(|image| (image.to_string(), entry(image))).collect();
        Value::Object(entries).to_string().into_bytes()
    };
    let camera = |_| json!({ "cam_K": [SIDE, 0, 7.5, 0, SIDE, 7.5, 0, 0, 1] });
    // The model's z axis points up in the image.
    let upright = [1, 0, 0, 0, 0, -1, 0, 1, 0];
    let placed = |object: u32, image: u32| {
        let millimetres = [20 * image + 150 * object, 0, 500];
        json!({ "obj_id": 1, "cam_R_m2c": upright, "cam_t_m2c": millimetres })
    };
    let gt = |image: u32| (0..OBJECTS).map(|object| placed(object, image)).collect();
    let seen = |object: u32| json!({ "bbox_visib": [left(object), 6, 3, 3], "visib_fract": 1 });
    let info = |_: u32| (0..OBJECTS).map(seen).collect();
    let model = json!({ "1": {
        "diameter": 142, "min_x": -50, "min_y": 0, "min_z": -50, "size_x": 100, "size_y": 0, "size_z": 100,
        "symmetries_discrete": [[-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]],
    } });
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
               element face 1\nproperty list uchar int vertex_indices\nend_header\n\
               -50 0 -50\n50 0 -50\n0 0 50\n3 0 1 2\n";
    let mut files = BTreeMap::from([
        ("models/models_info.json".to_owned(), model.to_string().into_bytes()),
        ("models/obj_000001.ply".to_owned(), ply.into()),
        ("test/000001/scene_camera.json".to_owned(), of_images(&camera)),
        ("test/000001/scene_gt.json".to_owned(), of_images(&gt)),
        ("test/000001/scene_gt_info.json".to_owned(), of_images(&info)),
    ]);
    for image in 0..IMAGES {
        files.insert(
            format!("test/000001/rgb/{image:06}.png"),
            png(|x, y| [x, y, image].map(|v| 16 * v as u8)),
        );
        for object in 0..OBJECTS {
            let columns = left(object)..left(object) + 4;
            let mask = png(|x, y| [u8::from(columns.contains(&x) && (6..10).contains(&y)) * 255; 3]);
            files.insert(format!("test/000001/mask_visib/{image:06}_{object:06}.png"), mask);
        }
    }
    files
}

/// Where an object begins in every image, pixels.
fn left(object: u32) -> u32 {
    6 + 4 * object
}

fn png(color: impl Fn(u32, u32) -> [u8; 3]) -> Vec<u8> {
    let image = image::RgbImage::from_fn(SIDE, SIDE, |x, y| image::Rgb(color(x, y)));
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).expect("a picture");
    bytes.into_inner()
}
