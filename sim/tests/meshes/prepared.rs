//! Meshes that were prepared before: found again, made anew where they are damaged, and held no longer than they are used.

use crate::files::{FACES, assert_same, cube_folder, flag, load, obj_faces, obj_vertices, spec, write};
use crate::scene::tabletop;
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Weak};
use std::thread;
use std::time::SystemTime;
use tempfile::TempDir;
use vantage_dataset::{Seed, Split};
use vantage_sim::budget::{MESHES_LIMIT, check_meshes};
use vantage_sim::checked::CheckedScene;
use vantage_sim::error::SimError;
use vantage_sim::mesh_file::{MeshFault, MeshFileError};
use vantage_sim::model::Model;
use vantage_sim::object::{Draw, MeshEntry, MeshLibrary, Object};
use vantage_sim::render::reference::ReferenceRenderer;
use vantage_sim::render::{Frame, RenderError, RenderScene, Renderer, RendererInfo, Shot, Tile, TileShot};
use vantage_sim::scene::MeshSpec;
use vantage_sim::views::training_views;

/// The cube of a folder, with a shelf.
fn cube(folder: &TempDir, shelf: &Path) -> MeshEntry {
    try_cube(folder, shelf).unwrap()
}

fn try_cube(folder: &TempDir, shelf: &Path) -> Result<MeshEntry, MeshFileError> {
    let specs = [spec(folder.path().join("cube.obj"))];
    let library = MeshLibrary::load(&specs, Path::new(""), Some(shelf), &mut |_| ())?;
    Ok(library.iter().next().unwrap().clone())
}

/// As the files make it.
fn fresh(folder: &TempDir) -> Object {
    load(folder.path().join("cube.obj")).object().unwrap()
}

/// Prepared files with what tells whether they were written again.
fn shelved(shelf: &Path) -> BTreeMap<PathBuf, (u64, SystemTime)> {
    let folders = fs::read_dir(shelf).unwrap().map(|entry| entry.unwrap().path());
    let files = folders.flat_map(|folder| fs::read_dir(folder).unwrap()).map(|entry| entry.unwrap().path());
    let prepared = files.filter(|file| file.extension().is_some_and(|ending| ending == "mesh"));
    let facts = |file: &PathBuf| {
        let metadata = fs::metadata(file).unwrap();
        (metadata.ino(), metadata.modified().unwrap())
    };
    prepared.map(|file| (file.clone(), facts(&file))).collect()
}

/// The only one.
fn only(shelf: &Path) -> PathBuf {
    let files = shelved(shelf);
    assert_eq!(files.len(), 1);
    files.into_keys().next().unwrap()
}

#[test]
fn a_prepared_mesh_is_found_again_and_asks_for_its_files_no_more() {
    let (folder, shelf) = (cube_folder(), tempfile::tempdir().unwrap());
    let expected = fresh(&folder);
    let first = cube(&folder, shelf.path());
    let files = shelved(shelf.path());
    let second = cube(&folder, shelf.path());
    assert_eq!(first, second);
    assert_eq!((first.id, first.half_extents, first.bytes), (second.id, second.half_extents, second.bytes));
    assert_eq!((expected.id, expected.footprint()), (second.id, second.footprint()));
    assert_eq!(files, shelved(shelf.path()), "it was made once");
    folder.close().unwrap();
    assert_same(&second.object().unwrap(), &expected);
}

#[test]
fn what_was_changed_is_noticed_whatever_its_size_and_time() {
    let (folder, shelf) = (cube_folder(), tempfile::tempdir().unwrap());
    let image = folder.path().join("flag.png");
    let (bytes, time) = (fs::read(&image).unwrap(), fs::metadata(&image).unwrap().modified().unwrap());
    let before = cube(&folder, shelf.path());
    // Another colour in as many bytes: the text of the MTL file.
    write(folder.path(), "cube.mtl", "newmtl skin\nKd 0.1 0.2 0.3 \n");
    assert_eq!("newmtl skin\nmap_Kd flag.png\n".len(), "newmtl skin\nKd 0.1 0.2 0.3 \n".len());
    let plain = cube(&folder, shelf.path());
    assert_ne!(before.hash, plain.hash);
    assert_same(&plain.object().unwrap(), &fresh(&folder));
    write(folder.path(), "cube.mtl", "newmtl skin\nmap_Kd flag.png\n");
    flag(32).save(&image).unwrap();
    let smaller = cube(&folder, shelf.path());
    assert_ne!(before.hash, smaller.hash);
    assert_same(&smaller.object().unwrap(), &fresh(&folder));
    assert_eq!(shelved(shelf.path()).len(), 3);
    let files = shelved(shelf.path());
    fs::write(&image, bytes).unwrap();
    fs::File::options().write(true).open(&image).unwrap().set_modified(time).unwrap();
    assert_eq!(cube(&folder, shelf.path()), before);
    assert_eq!(files, shelved(shelf.path()), "each is found by its contents");
}

#[test]
fn models_of_one_mesh_file_have_each_their_own_look() {
    let (red, blue, shelf) = (cube_folder(), cube_folder(), tempfile::tempdir().unwrap());
    flag(16).save(blue.path().join("flag.png")).unwrap();
    let entries = [&red, &blue, &red, &blue].map(|folder| cube(folder, shelf.path()));
    assert_eq!(shelved(shelf.path()).len(), 2);
    assert_eq!(entries[..2], entries[2..]);
    assert_same(&entries[2].object().unwrap(), &fresh(&red));
    assert_same(&entries[3].object().unwrap(), &fresh(&blue));
    fs::remove_file(blue.path().join("flag.png")).unwrap();
    let fault = try_cube(&blue, shelf.path()).unwrap_err().fault;
    assert!(matches!(fault, MeshFault::MissingFile { .. }), "{fault:?}");
}

#[test]
fn other_units_make_another_mesh() {
    let (folder, shelf) = (cube_folder(), tempfile::tempdir().unwrap());
    let small = cube(&folder, shelf.path()).object().unwrap();
    let specs = [MeshSpec { metres_per_unit: 0.2, ..spec(folder.path().join("cube.obj")) }];
    let library = MeshLibrary::load(&specs, Path::new(""), Some(shelf.path()), &mut |_| ()).unwrap();
    let large = library.iter().next().unwrap().object().unwrap();
    assert!((large.size - 2.0 * small.size).abs() < 1e-6);
    assert_eq!(shelved(shelf.path()).len(), 2);
}

#[test]
fn what_is_damaged_is_made_anew() {
    let (folder, shelf) = (cube_folder(), tempfile::tempdir().unwrap());
    let expected = fresh(&folder);
    let entry = cube(&folder, shelf.path());
    let file = only(shelf.path());
    let whole = fs::read(&file).unwrap();
    let flipped = |at: usize| {
        let mut bytes = whole.clone();
        bytes[at] ^= 1;
        bytes
    };
    let last = whole.len() - 1;
    let mut damages = vec![Vec::new(), b"vantage mesh 2 \n\n".to_vec(), vec![0xff; 9]];
    damages.extend([1, 40, 200, whole.len() / 2, last].map(|length| whole[..length].to_vec()));
    damages.extend([0, 20, 100, 160, 400, whole.len() / 2, last].map(flipped));
    damages.push([whole.as_slice(), b"more"].concat());
    for (number, damage) in damages.iter().enumerate() {
        fs::write(&file, damage).unwrap();
        assert_same(&entry.object().unwrap(), &expected);
        assert!(fs::read(&file).unwrap() == whole, "damage {number} is still there");
        fs::write(&file, damage).unwrap();
        let again = cube(&folder, shelf.path());
        assert_eq!(again, entry);
        assert_same(&again.object().unwrap(), &expected);
        assert!(fs::read(&file).unwrap() == whole, "damage {number} is still there");
    }
    fs::remove_dir_all(shelf.path()).unwrap();
    assert_same(&entry.object().unwrap(), &expected);
    assert!(fs::read(&file).unwrap() == whole, "it is there again");
}

#[test]
fn what_is_gone_and_changed_is_an_error() {
    let (folder, shelf) = (cube_folder(), tempfile::tempdir().unwrap());
    let entry = cube(&folder, shelf.path());
    let other = load(folder.path().join("cube.obj"));
    fs::remove_file(only(shelf.path())).unwrap();
    flag(32).save(folder.path().join("flag.png")).unwrap();
    for entry in [entry, other] {
        let error = entry.object().unwrap_err();
        assert!(matches!(error.fault, MeshFault::Changed));
        assert!(error.to_string().contains("cube.obj: has changed"), "{error}");
    }
}

#[test]
fn a_shelf_that_cannot_be_written_is_told_of() {
    let folder = cube_folder();
    let shelf = write(folder.path(), "a file", "");
    let error = try_cube(&folder, &shelf).unwrap_err();
    assert!(matches!(error.fault, MeshFault::NotKept(_)));
    assert!(error.to_string().contains("a file"), "{error}");
}

#[test]
fn several_at_once_make_each_mesh_once_and_what_a_killed_one_left_is_no_harm() {
    let (folder, shelf) = (cube_folder(), tempfile::tempdir().unwrap());
    let expected = cube(&folder, shelf.path());
    let file = only(shelf.path());
    fs::rename(&file, file.with_extension("mesh.tmp")).unwrap();
    fs::write(file.with_file_name(".bench.lock"), "12345").unwrap();
    thread::scope(|scope| {
        let all: Vec<_> = (0..6).map(|_| scope.spawn(|| cube(&folder, shelf.path()))).collect();
        for one in all {
            let one = one.join().unwrap();
            assert_eq!(one, expected);
            one.object().unwrap();
        }
    });
    assert_eq!(only(shelf.path()), file);
    assert_eq!(fs::read_dir(file.parent().unwrap()).unwrap().count(), 1, "nothing is left over");
}

#[test]
fn the_first_mesh_that_cannot_be_used_is_named_in_every_run() {
    let (folder, shelf) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    for i in 0..30 {
        let faces = if i % 10 == 7 { String::new() } else { obj_faces(&FACES) };
        write(folder.path(), &format!("{i:02}.obj"), &format!("# {i}\n{}{faces}", obj_vertices()));
    }
    for _ in 0..5 {
        let specs = [spec(folder.path())];
        let error = MeshLibrary::load(&specs, Path::new(""), Some(shelf.path()), &mut |_| ()).unwrap_err();
        assert!(error.path.ends_with("07.obj"), "{error}");
    }
}

#[test]
fn meshes_that_take_too_much_together_are_refused() {
    let folder = cube_folder();
    let mut mesh = load(folder.path().join("cube.obj"));
    mesh.bytes = MESHES_LIMIT / 2;
    check_meshes(&[Draw::Mesh(&mesh); 2]).unwrap();
    let error = check_meshes(&[Draw::Mesh(&mesh); 3]).unwrap_err();
    assert!(matches!(error, SimError::TooLarge { .. }));
    assert!(error.to_string().contains("2250 MB") && error.to_string().contains("world.meshes"), "{error}");
}

/// Counts the models that are held at a time.
#[derive(Default)]
struct Counting {
    renderer: ReferenceRenderer,
    seen: BTreeMap<usize, Weak<Model>>,
    most: usize,
}

impl Renderer for Counting {
    fn info(&self) -> RendererInfo {
        self.renderer.info()
    }

    fn frame(&mut self, scene: &RenderScene, shot: &Shot) -> Result<Frame, RenderError> {
        self.renderer.frame(scene, shot)
    }

    fn tiles(&mut self, shots: &[TileShot<'_>], side: u32) -> Result<Vec<Tile>, RenderError> {
        for placement in shots.iter().flat_map(|shot| &shot.scene.placements) {
            // A handle that is kept keeps the address, too.
            let address = Arc::as_ptr(&placement.model).addr();
            self.seen.entry(address).or_insert_with(|| Arc::downgrade(&placement.model));
        }
        self.most = self.most.max(self.seen.values().filter(|model| model.strong_count() > 0).count());
        self.renderer.tiles(shots, side)
    }
}

#[test]
fn of_many_meshes_few_are_held_at_a_time() {
    let (folder, shelf) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    for i in 0..80 {
        let vertices = obj_vertices().replace("v 1 ", &format!("v {} ", 0.6 + 0.01 * f64::from(i)));
        write(folder.path(), &format!("meshes/{i}/textured.obj"), &(vertices + &obj_faces(&FACES)));
    }
    let scene = tabletop(vec![MeshSpec { split: Some(Split::Train), ..spec("meshes") }], 1);
    let conditions = CheckedScene::new(scene, folder.path(), Some(shelf.path()), &mut |_| ()).unwrap();
    let conditions = conditions.view_conditions();
    let mut renderer = Counting::default();
    let set = training_views(&conditions, Split::Train, 80, Seed(1), &mut renderer, &mut |_| ()).unwrap();
    assert_eq!(set.instances.len(), 80);
    assert_eq!(renderer.seen.len(), 80);
    assert!((1..=32).contains(&renderer.most), "{} models at a time", renderer.most);
    assert!(renderer.seen.values().all(|model| model.strong_count() == 0), "nothing is held after use");
}
