//! Real files: YCB, Google Scanned Objects, Poly Haven, KayKit and others.

use crate::files::{assert_same, spec};
use nalgebra::{Point3, Vector2, Vector3};
use serde_json::Value;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::Instant;
use vantage_dataset::{Camera, Pose};
use vantage_sim::object::{MeshEntry, MeshLibrary, Object};
use vantage_sim::physics::Physics;
use vantage_sim::plan::furnishing::Furnishing;
use vantage_sim::plan::stand::{Outline, Stand};
use vantage_sim::render::reference::ReferenceRenderer;
use vantage_sim::render::{Light, Placement, RenderScene, Renderer, Shot};
use vantage_sim::scene::MeshSpec;
use vantage_sim::scene::UpAxis;
use vantage_sim::world::layout::Place;
use vantage_sim::world::settle::settle;

/// Past the harness, which swallows what tests print.
fn tell(what: &str) {
    std::io::stderr().write_all(format!("{what}\n").as_bytes()).unwrap();
}

fn folder() -> Option<PathBuf> {
    let root = std::env::var_os("VANTAGE_SHARED").map(PathBuf::from);
    let root = root.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"));
    let folder = root.join("data/meshes");
    if !folder.is_dir() {
        tell(&format!("SKIPPED: there are no meshes in {}", folder.display()));
        return None;
    }
    Some(folder)
}

/// The entries of the list of files, good or bad.
fn listed(folder: &Path, negative: bool) -> Vec<Value> {
    let text = std::fs::read_to_string(folder.join("MANIFEST.json")).unwrap();
    let all: Vec<Value> = serde_json::from_str(&text).unwrap();
    all.into_iter().filter(|entry| entry["negative"] == negative).collect()
}

/// Units that give each thing its size.
fn units(name: &str) -> (f64, UpAxis) {
    match name {
        "armchair_obj" => (0.01, UpAxis::Y),
        "spot_cow_obj" | "spot_cow_glb" => (0.1, UpAxis::Y),
        "kaykit_chest" | "kaykit_barrel_large" | "kaykit_banner_shield_red" => (0.3, UpAxis::Y),
        "polyhaven_painted_wooden_stool" => (1.0, UpAxis::Y),
        _ => (1.0, UpAxis::Z),
    }
}

fn text<'a>(entry: &'a Value, key: &str) -> &'a str {
    entry[key].as_str().unwrap()
}

/// A good mesh with its entry in the list.
type Listed = (Value, MeshEntry, Object);

/// All good meshes, read once.
fn library(folder: &Path) -> &'static [Listed] {
    static LIBRARY: OnceLock<Vec<Listed>> = OnceLock::new();
    LIBRARY.get_or_init(|| read(folder))
}

fn specs(entries: &[Value]) -> Vec<MeshSpec> {
    entries
        .iter()
        .map(|entry| {
            let (metres_per_unit, up) = units(text(entry, "name"));
            let path = Path::new(text(entry, "dir")).join(text(entry, "main"));
            MeshSpec { metres_per_unit, up, category: Some(text(entry, "category").to_owned()), ..spec(path) }
        })
        .collect()
}

fn read(folder: &Path) -> Vec<Listed> {
    let entries = listed(folder, false);
    let shelf = tempfile::tempdir().unwrap();
    let load = |what: &str| {
        let start = Instant::now();
        let library = MeshLibrary::load(&specs(&entries), folder, Some(shelf.path()), &mut |_| ()).unwrap();
        tell(&format!("{} meshes {what} in {:.2} s", entries.len(), start.elapsed().as_secs_f64()));
        library
    };
    let prepared = load("prepared");
    let library = load("found");
    assert_eq!(prepared, library);
    let start = Instant::now();
    let objects: Vec<Object> = library.iter().map(|mesh| mesh.object().unwrap()).collect();
    tell(&format!("{} meshes read in {:.2} s", entries.len(), start.elapsed().as_secs_f64()));
    entries.into_iter().zip(library.iter().cloned()).zip(objects).map(|((a, b), c)| (a, b, c)).collect()
}

#[test]
fn prepared_ones_are_those_that_the_files_make() {
    let Some(folder) = folder() else { return };
    let fresh = MeshLibrary::load(&specs(&listed(&folder, false)), &folder, None, &mut |_| ()).unwrap();
    for (mesh, (_, prepared, object)) in fresh.iter().zip(library(&folder)) {
        assert_eq!(mesh, prepared);
        assert_same(&mesh.object().unwrap(), object);
        assert_eq!(mesh.bytes, prepared.bytes);
    }
}

#[test]
fn all_have_the_size_and_about_the_faces_that_their_list_says() {
    let Some(folder) = folder() else { return };
    let library = library(&folder);
    assert_eq!(library.len(), 20);
    for (entry, mesh, object) in library {
        let name = text(entry, "name");
        let (scale, up) = units(name);
        let [x, y, z] = [0, 1, 2].map(|axis| scale * entry["extent"][axis].as_f64().unwrap());
        let expected = if up == UpAxis::Z { Vector3::new(x, y, z) } else { Vector3::new(z, x, y) };
        let got = 2.0 * object.half_extents;
        assert!((got - expected).amax() < 1e-4 * scale.max(1.0) + 1e-4, "{name}: {got} for {expected}");
        let (faces, listed) = (object.model.mesh.triangles.len() as f64, entry["faces"].as_f64().unwrap());
        let share = faces / listed;
        assert!((0.99..=1.0).contains(&share) || share == 2.0, "{name}: {faces} of {listed} faces");
        assert!(mesh.licence().unwrap().ends_with("LICENCE.txt"), "{name}");
        assert!(object.hull.len() <= 64, "{name}");
        let normals = &object.model.mesh.normals;
        let norms = normals.iter().map(|n| n.iter().map(|x| x * x).sum::<f32>().sqrt());
        assert!(norms.into_iter().all(|norm| (norm - 1.0).abs() < 1e-3), "{name}");
    }
}

#[test]
fn the_same_cow_comes_from_obj_and_from_glb() {
    let Some(folder) = folder() else { return };
    let library = library(&folder);
    let cow = |name| library.iter().find(|(entry, ..)| text(entry, "name") == name).unwrap().2.clone();
    let (obj, glb) = (cow("spot_cow_obj"), cow("spot_cow_glb"));
    assert!((obj.half_extents - glb.half_extents).norm() < 1e-6);
    assert!((obj.mass - glb.mass).abs() < 1e-4 * obj.mass);
    let images = [obj, glb].map(|object| render(&object, 0.7));
    let difference = images[0].0.iter().zip(&images[1].0).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
    assert!(difference <= 12, "pixels differ by {difference}");
}

/// The object from 30 degrees above, and its share of the image.
fn render(object: &Object, azimuth: f64) -> (Vec<u8>, f64) {
    let eye =
        4.0 * object.size * Vector3::new(0.75f64.sqrt() * azimuth.cos(), 0.75f64.sqrt() * azimuth.sin(), 0.5);
    let scene = RenderScene {
        placements: vec![Placement {
            model: object.model.clone(),
            world_from_model: Pose::identity(),
            id: 1,
        }],
        light: Light { direction: Vector3::z(), ambient: [1.0; 3], diffuse: [0.0; 3] },
        background: [0; 3],
    };
    let shot = Shot {
        camera: Camera::with_horizontal_fov(64, 64, 2.0 * (0.55f64 / 4.0).atan()),
        world_from_camera: Pose::face_towards(&Point3::from(eye), &Point3::origin(), &-Vector3::z()),
    };
    let frame = ReferenceRenderer::default().frame(&scene, &shot).unwrap();
    let drawn = frame.ids.iter().filter(|&&id| id == 1).count();
    (frame.rgb, drawn as f64 / 4096.0)
}

#[test]
fn all_are_drawn_whole_and_in_colours_of_their_own() {
    let Some(folder) = folder() else { return };
    for (entry, _, object) in library(&folder) {
        let name = text(entry, "name");
        for azimuth in [0.5, 2.6, 4.7] {
            let (rgb, share) = render(object, azimuth);
            assert!((0.04..0.75).contains(&share), "{name}: {share} of the image");
            let sum: f64 = rgb.iter().map(|&channel| f64::from(channel)).sum();
            let mean = sum / 3.0 / (4096.0 * share);
            assert!((25.0..=250.0).contains(&mean), "{name}: mean colour {mean}");
        }
    }
}

#[test]
fn all_come_to_rest_on_a_table() {
    let Some(folder) = folder() else { return };
    let outline = Outline::Rectangle { half_extents: [2.0, 2.0] };
    let table = Stand::solid(Vector2::zeros(), 0.7, outline);
    for (entry, _, object) in library(&folder) {
        let place = Place { stand: 0, position: Vector2::zeros(), yaw: 0.3 };
        let mut physics = Physics::new(&Furnishing { stands: vec![table], ..Furnishing::default() }, &[]);
        let object = [object.clone()];
        let poses = settle(&mut physics, &[table], &object, &[place], 20, &mut |_| ());
        let pose = poses.unwrap_or_else(|error| panic!("{}: {error}", text(entry, "name")))[0];
        let vertices = object[0].model.mesh.positions.iter();
        let lowest = vertices.map(|p| (pose * Point3::from(Vector3::from(*p).map(f64::from))).z);
        let gap = lowest.fold(f64::INFINITY, f64::min) - table.height;
        assert!(gap.abs() < 0.01, "{} stands {gap} m too high", text(entry, "name"));
    }
}

#[test]
fn broken_files_are_refused_by_name_and_cause() {
    let Some(folder) = folder() else { return };
    let mut bad: Vec<(PathBuf, &str)> =
        vec![(folder.join("_negative/obj_missing_files/model2.obj"), "`model2.mtl`")];
    for entry in listed(&folder, true) {
        let cause = match text(&entry, "name") {
            "obj_missing_files" => "`material_1.png`",
            "obj_mtl_no_image" => "none of its 2 triangles has an area",
            "gltf_integer-out-of-bounds" => "expected u64 at line 34",
            "gltf_invalid-primitive-indices" => "indices",
            "glb_empty_nodes" => "no triangle",
            "gltf_draco" => "KHR_draco_mesh_compression",
            other => panic!("{other} is new"),
        };
        bad.push((folder.join(text(&entry, "dir")).join(text(&entry, "main")), cause));
    }
    assert_eq!(bad.len(), 7);
    for (path, cause) in bad {
        let error =
            MeshLibrary::load(&[spec(&path)], Path::new(""), None, &mut |_| ()).unwrap_err().to_string();
        assert!(error.contains(cause), "{cause:?} is not in: {error}");
        assert!(error.contains(path.file_name().unwrap().to_str().unwrap()), "{error}");
    }
}
