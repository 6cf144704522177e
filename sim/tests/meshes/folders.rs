//! Folders of models, as collections have them.

use crate::files::{
    FACES, cube_folder, flag, load, load_all, obj_cube, obj_faces, obj_vertices, spec, write,
};
use std::fs;
use std::path::Path;
use vantage_sim::error::{Progress, Stage};
use vantage_sim::mesh_file::MeshFault;
use vantage_sim::object::MeshLibrary;

/// A cube without a material; the comment makes it one of its own.
fn plain(comment: &str) -> String {
    format!("# {comment}\n{}{}", obj_vertices(), obj_faces(&FACES))
}

fn names(library: &MeshLibrary) -> Vec<&str> {
    library.iter().map(|mesh| mesh.name.as_str()).collect()
}

/// A model as Google Scanned Objects has it: its texture is not where its material says.
fn scanned(folder: &Path) {
    write(folder, "meshes/model.obj", &obj_cube().replace("cube.mtl", "model.mtl"));
    write(folder, "meshes/model.mtl", "newmtl skin\nmap_Kd texture.png\n");
    fs::create_dir_all(folder.join("materials/textures")).unwrap();
    flag(16).save(folder.join("materials/textures/texture.png")).unwrap();
}

#[test]
fn reading_many_meshes_tells_how_far_it_is() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a", "b", "c", "d", "e"] {
        write(folder.path(), &format!("{name}.obj"), &plain(name));
    }
    let mut told = Vec::new();
    MeshLibrary::load(&[spec(folder.path())], Path::new(""), None, &mut |progress| told.push(progress))
        .unwrap();
    let progress = |done| Progress { stage: Stage::Meshes, done, total: 5 };
    assert!(told.into_iter().eq((0..=5).map(progress)));
}

#[test]
fn a_folder_of_models_of_any_layout_gives_each_by_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "011_banana/google_16k/textured.obj", &plain("16k"));
    write(folder, "011_banana/tsdf/textured.obj", &plain("tsdf"));
    write(folder, "025_mug/tsdf/textured.obj", &plain("mug"));
    write(folder, "024_bowl/textured.obj", &plain("bowl"));
    scanned(&folder.join("Frypan"));
    write(folder, "flat/flat_export_7.obj", &plain("flat"));
    write(folder, "parts/a.obj", &plain("a"));
    write(folder, "parts/b.gltf.obj", &plain("b"));
    write(folder, "_left_out/readme.txt", "");
    write(folder, ".hidden/readme.txt", "");
    write(folder, "LICENSE.txt", "CC BY 4.0");
    write(folder, "024_bowl/LICENCE", "CC0");
    let library = load_all(folder).unwrap();
    assert_eq!(names(&library), ["011_banana", "024_bowl", "025_mug", "Frypan", "flat", "a", "b"]);
    let licences: Vec<_> = library.iter().map(|mesh| mesh.licence().unwrap().to_owned()).collect();
    assert_eq!(licences[1], folder.join("024_bowl/LICENCE"));
    assert!(licences.iter().enumerate().all(|(i, licence)| i == 1 || *licence == folder.join("LICENSE.txt")));
    assert!(library.iter().all(|mesh| mesh.category == mesh.name));

    for (path, name) in [
        ("011_banana", "011_banana"),
        ("011_banana/google_16k/textured.obj", "011_banana"),
        ("024_bowl/textured.obj", "024_bowl"),
        ("Frypan/meshes/model.obj", "Frypan"),
        ("flat", "flat"),
        ("flat/flat_export_7.obj", "flat_export_7"),
    ] {
        assert_eq!(names(&load_all(folder.join(path)).unwrap()), [name], "{path}");
    }
}

#[test]
fn a_scanned_object_finds_its_texture() {
    let folder = tempfile::tempdir().unwrap();
    scanned(folder.path());
    let texture = |path: &Path| load(path).object().unwrap().model.texture.clone();
    let cube = cube_folder();
    flag(16).save(cube.path().join("flag.png")).unwrap();
    assert_eq!(texture(folder.path()), texture(&cube.path().join("cube.obj")));
    fs::remove_file(folder.path().join("materials/textures/texture.png")).unwrap();
    let fault = load_all(folder.path()).unwrap_err().fault;
    assert!(matches!(fault, MeshFault::MissingFile { .. }), "{fault:?}");
}

#[test]
fn what_holds_no_mesh_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |path: &Path, word: &str| {
        let error = load_all(path).unwrap_err();
        assert!(error.to_string().contains(path.file_name().unwrap().to_str().unwrap()), "{error}");
        assert!(error.to_string().contains(word), "{error}");
        error.fault
    };
    let gone = folder.path().join("gone.obj");
    assert!(matches!(refused(&gone, "cannot be read"), MeshFault::Unreadable(_)));
    assert!(matches!(refused(folder.path(), "textured.obj"), MeshFault::NoMeshInFolder));
    let text = write(folder.path(), "mesh.stl", "solid");
    assert!(matches!(refused(&text, ".glb"), MeshFault::UnknownFormat));
    write(folder.path(), "good/textured.obj", &plain("good"));
    write(folder.path(), "bad/google_512k/textured.obj", &plain("bad"));
    let error = load_all(folder.path()).unwrap_err();
    assert!(matches!(error.fault, MeshFault::NoMeshInFolder));
    assert_eq!(error.path, folder.path().join("bad"));
}

#[test]
fn the_same_mesh_twice_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "a/textured.obj", &plain("same"));
    write(folder.path(), "b/textured.obj", &plain("same"));
    let error = load_all(folder.path()).unwrap_err();
    assert!(matches!(&error.fault, MeshFault::Twice(other) if other.ends_with("a/textured.obj")), "{error}");
    assert!(error.to_string().contains("b/textured.obj"), "{error}");
}

#[test]
fn the_hash_covers_every_file() {
    let folder = cube_folder();
    let hash = || load(folder.path().join("cube.obj")).hash;
    let whole = hash();
    assert_eq!(whole, hash());
    flag(32).save(folder.path().join("flag.png")).unwrap();
    let other_image = hash();
    assert_ne!(whole, other_image);
    write(folder.path(), "cube.mtl", "newmtl skin\nmap_Kd flag.png\n# a comment\n");
    assert_ne!(other_image, hash());
}
