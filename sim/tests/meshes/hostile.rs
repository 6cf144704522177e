//! What is refused, of OBJ files and of files in general: each with a message that names file and cause.

use crate::files::{
    FACES, cube_folder, glb, gltf_cube, load, load_all, obj_cube, obj_faces, obj_vertices, write,
};
use image::RgbImage;
use std::fs::{self, File};
use std::io::Write;
use std::path::Path;
use std::time::{Duration, Instant};
use vantage_dataset::Seed;
use vantage_sim::mesh_file::{MAX_TRIANGLES, MeshFault};

/// The fault, after a check that the message names the file and all of `words`.
fn refused(path: &Path, words: &[&str]) -> MeshFault {
    let error = load_all(path).unwrap_err();
    let message = error.to_string();
    for word in [path.file_name().unwrap().to_str().unwrap()].iter().chain(words) {
        assert!(message.contains(word), "{word:?} is not in: {message}");
    }
    error.fault
}

/// The fault of an OBJ file without materials.
fn refused_obj(text: &str, words: &[&str]) -> MeshFault {
    let folder = tempfile::tempdir().unwrap();
    refused(&write(folder.path(), "bad.obj", text), words)
}

/// The fault of the cube after a change of its MTL file.
fn refused_mtl(text: &str, words: &[&str]) -> MeshFault {
    let folder = cube_folder();
    write(folder.path(), "cube.mtl", text);
    refused(&folder.path().join("cube.obj"), words)
}

#[test]
fn words_end_at_any_white_space_as_they_do_for_the_parser() {
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\n";
    for space in ['\u{b}', '\u{85}', '\u{a0}', '\u{2003}'] {
        let face = format!("{vertices}f{space}1//6148914691236517206 2//1 3//1\n");
        assert!(matches!(refused_obj(&face, &["an index is too long"]), MeshFault::Syntax { .. }));
        let line = format!("{vertices}l{space}1 2 3\n");
        assert!(matches!(refused_obj(&line, &["triangle"]), MeshFault::NoTriangle));
        refused_mtl(&format!("newmtl paint\nKd{space}1 1\n"), &["`Kd` needs three numbers"]);
    }
}

#[test]
fn broken_geometry() {
    let cube = obj_vertices() + &obj_faces(&FACES);
    let fault = refused_obj(&cube.replace("f 1/1", "f 9/1"), &["out of bounds"]);
    assert!(matches!(fault, MeshFault::Syntax { .. }));
    for index in ["9223372036854775807", "6148914691236517206", "-9223372036854775808"] {
        for face in [format!("f {index}/1"), format!("f 1/{index}"), format!("f 1/1/{index}")] {
            refused_obj(&cube.replacen("f 1/1", &face, 1), &["index"]);
        }
    }
    for face in ["f 0/1", "f 1/0/0/0", "f a/1", "f -9/1", "f 1/7"] {
        let fault = refused_obj(&cube.replacen("f 1/1", face, 1), &["face"]);
        assert!(matches!(fault, MeshFault::Syntax { .. }), "{face}: {fault:?}");
    }
    for number in ["nan", "inf", "-inf", "1e999"] {
        let fault = refused_obj(&cube.replacen("v 1", &format!("v {number}"), 1), &["vertex", "finite"]);
        assert!(matches!(fault, MeshFault::NotFinite(_)), "{number}: {fault:?}");
    }
    assert!(matches!(refused_obj("", &["triangle"]), MeshFault::NoTriangle));
    assert!(matches!(refused_obj(&obj_vertices(), &["triangle"]), MeshFault::NoTriangle));
    assert!(matches!(refused_obj("v 0 0 0\nv 1 1 1\nl 1 2\n", &["triangle"]), MeshFault::NoTriangle));
    let line = "v 0.1 0.2 0.3\nv 0.2 0.3 0.4\nv 0.3 0.4 0.5\nf 1 2 3\nf 1 1 2\n";
    assert!(matches!(refused_obj(line, &["2 triangles", "area"]), MeshFault::NoArea(2)));
    let sheet = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
    assert!(matches!(refused_obj(sheet, &["volume"]), MeshFault::NoVolume));
    for far in ["1e2", "1e6", "1e20", "1e38"] {
        let fault = refused_obj(&cube.replacen("v 1 1 1", &format!("v 1 1 {far}"), 1), &["largest extent"]);
        assert!(matches!(fault, MeshFault::Size { .. }), "{far}: {fault:?}");
    }
    let slanted = "v 0 0 0\nv 1 0 1\nv 1 1 1\nv 0 1 0\nf 1 2 3 4\n";
    assert!(matches!(refused_obj(slanted, &["volume"]), MeshFault::NoVolume));
}

#[test]
fn units_that_cannot_be_right() {
    for (size, extent) in [("100", "10.000000 m"), ("0.04", "0.004000 m")] {
        let scaled = obj_vertices().replace("1 ", &format!("{size} ")).replace(" 1\n", &format!(" {size}\n"));
        let fault = refused_obj(&(scaled + &obj_faces(&FACES)), &[extent, "metres_per_unit"]);
        assert!(matches!(fault, MeshFault::Size { .. }), "{fault:?}");
    }
}

#[test]
fn too_much() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("many.obj");
    let mut file = File::create(&path).unwrap();
    file.write_all(b"v 0 0 0\nv 1 0 0\nv 0 1 0\n").unwrap();
    file.write_all("f 1 2 3\n".repeat(MAX_TRIANGLES + 1).as_bytes()).unwrap();
    let fault = refused(&path, &["500001 triangles", "500000"]);
    assert!(matches!(fault, MeshFault::TooMany { got: 500_001, .. }));
    let polygon = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nf{}\n", " 1 2 3".repeat(MAX_TRIANGLES));
    assert!(matches!(refused_obj(&polygon, &["triangles"]), MeshFault::TooMany { .. }));
    let points = "v 0 0 0\n".repeat(2_000_001);
    assert!(matches!(refused_obj(&points, &["2000001 vertices"]), MeshFault::TooMany { .. }));

    // Three hundred million bytes that no disk holds.
    let huge = folder.path().join("huge.obj");
    File::create(&huge).unwrap().set_len(300 << 20).unwrap();
    assert!(matches!(refused(&huge, &["314572800 bytes"]), MeshFault::FileTooLarge { .. }));

    // Five images of which each is small enough.
    let folder = cube_folder();
    let names = ["a", "b", "c", "d", "e"];
    let mtl: String = names.iter().map(|name| format!("newmtl {name}\nmap_Kd {name}.png\n")).collect();
    write(folder.path(), "cube.mtl", &mtl);
    RgbImage::new(4096, 4096).save(folder.path().join("a.png")).unwrap();
    for name in &names[1..] {
        fs::copy(folder.path().join("a.png"), folder.path().join(format!("{name}.png"))).unwrap();
    }
    let fault = refused(&folder.path().join("cube.obj"), &["83886080 pixels"]);
    assert!(matches!(fault, MeshFault::TooMany { .. }));
}

#[test]
fn materials_that_are_not_there_or_cannot_be_read() {
    let folder = cube_folder();
    fs::remove_file(folder.path().join("cube.mtl")).unwrap();
    let fault = refused(&folder.path().join("cube.obj"), &["`cube.mtl`", "put it beside"]);
    assert!(matches!(fault, MeshFault::MissingFile { .. }));
    let fault = refused_mtl("newmtl skin\nmap_Kd other.png\n", &["`other.png`", "put it beside"]);
    assert!(matches!(fault, MeshFault::MissingFile { .. }));
    // The parser would panic.
    for line in ["Kd 0.5", "Kd", "Ks 1 1", "Ka\t1"] {
        let fault = refused_mtl(&format!("newmtl skin\n{line}\n"), &["`cube.mtl`", "three numbers"]);
        assert!(matches!(fault, MeshFault::Syntax { .. }), "{line}: {fault:?}");
    }
    assert!(matches!(refused_mtl("newmtl skin\nKd a b c\n", &["`cube.mtl`"]), MeshFault::Syntax { .. }));
    assert!(matches!(refused_mtl("newmtl skin\nKd nan 0 0\n", &["Kd"]), MeshFault::NotFinite(_)));
    let fault = refused_mtl("newmtl other\nKd 1 0 0\n", &["`other`"]);
    assert!(matches!(fault, MeshFault::UnknownMaterial(_)));
    let fault = refused_mtl("newmtl skin\nmap_Kd -s 2 2 2 flag.png\n", &["map_Kd"]);
    assert!(matches!(fault, MeshFault::Unsupported(..)));
    let plain = obj_cube().replace("/1", "").replace("/2", "").replace("/3", "").replace("/4", "");
    write(folder.path(), "cube.mtl", "newmtl skin\nmap_Kd flag.png\n");
    write(folder.path(), "cube.obj", &plain);
    let fault = refused(&folder.path().join("cube.obj"), &["`skin`", "texture coordinates"]);
    assert!(matches!(fault, MeshFault::NoTextureCoordinates(_)));
    let colored =
        obj_vertices().replace("v 1 0 0\n", "v 1 0 0 1 0 0\n").replace("v 0 0 0\n", "v 0 0 0 1 1 1\n");
    refused_obj(&(colored + &obj_faces(&FACES)), &[]);
}

#[test]
fn normals_that_are_none_are_made_anew() {
    let folder = cube_folder();
    for number in ["nan", "inf", "0"] {
        let faces = obj_faces(&FACES);
        let faces =
            ["/1", "/2", "/3", "/4"].iter().fold(faces, |text, uv| text.replace(uv, &format!("{uv}/1")));
        let normal = format!("vn {number} {number} {number}\n");
        let mesh = load(write(folder.path(), "bad.obj", &(obj_vertices() + &normal + &faces)));
        let normals = &mesh.object().unwrap().model.mesh.normals;
        assert_eq!(normals.len(), 24, "{number}");
        assert!(
            normals.iter().all(|n| n.iter().filter(|x| x.abs() == 1.0).count() == 1),
            "{number}: {normals:?}"
        );
    }
}

#[test]
fn lines_are_not_drawn_and_long_names_refused() {
    let folder = tempfile::tempdir().unwrap();
    let cube = obj_vertices() + &obj_faces(&FACES);
    let load = |text: &str| load(write(folder.path(), "cube.obj", text)).object().unwrap().model;
    let plain = load(&cube);
    let comment = format!("l 1 2 7\n  l 1 2 3 5\n#{}\n", "x".repeat(10_000));
    let lined = load(&(cube.clone() + &comment));
    assert_eq!(plain, lined);
    let fault = refused_obj(&format!("o {}\n{cube}", "x".repeat(5000)), &["characters", "5002"]);
    assert!(matches!(fault, MeshFault::TooMany { .. }));
}

#[test]
fn points_at_which_very_many_triangles_meet_take_no_longer() {
    /// A cone whose base is one face.
    fn cone(sides: usize) -> String {
        let mut text = "v 0 0 1\n".to_owned();
        for side in 0..sides {
            let (y, x) = (std::f64::consts::TAU * side as f64 / sides as f64).sin_cos();
            text += &format!("v {x} {y} 0\n");
        }
        let base: String = (0..sides).rev().map(|side| format!(" {}", side + 2)).collect();
        let slope = |side| format!("f 1 {} {}\n", side + 2, (side + 1) % sides + 2);
        text + &format!("f{base}\n") + &(0..sides).map(slope).collect::<String>()
    }
    let folder = tempfile::tempdir().unwrap();
    let load = |sides| load(write(folder.path(), "cone.obj", &cone(sides))).object().unwrap().model;
    let start = Instant::now();
    for (sides, is_simplified) in [(400, true), (2000, false), (200_000, false)] {
        let model = load(sides);
        model.simplify();
        assert_eq!(model.simpler_levels() > 0, is_simplified, "{sides}");
    }
    assert!(start.elapsed() < Duration::from_secs(60), "{:?}", start.elapsed());
}

#[test]
fn texture_coordinates_that_are_none() {
    let folder = cube_folder();
    for number in ["nan", "inf", "1e30"] {
        let text = obj_cube().replace("vt 1 0", &format!("vt {number} 0"));
        let fault = refused(&write(folder.path(), "cube.obj", &text), &["texture coordinate"]);
        assert!(matches!(fault, MeshFault::NotFinite(_)), "{number}: {fault:?}");
    }
    // Large but sound.
    load(write(folder.path(), "cube.obj", &obj_cube().replace("vt 1 0", "vt 9999 0")));
}

#[test]
fn images_that_are_none_or_bombs() {
    let folder = cube_folder();
    let image = folder.path().join("flag.png");
    let refused = || refused(&folder.path().join("cube.obj"), &["`flag.png`"]);
    RgbImage::new(9000, 1).save(&image).unwrap();
    assert!(matches!(refused(), MeshFault::Image { .. }));
    let whole = {
        crate::files::flag(64).save(&image).unwrap();
        fs::read(&image).unwrap()
    };
    for bytes in [&b""[..], b"GIF89a\x01\x00\x01\x00", b"no image at all", &whole[..whole.len() / 2]] {
        fs::write(&image, bytes).unwrap();
        assert!(matches!(refused(), MeshFault::Image { .. }));
    }
    // Half a JPEG, of which the decoder would make up the rest, and one without its last bytes.
    write(folder.path(), "cube.mtl", "newmtl skin\nmap_Kd flag.jpg\n");
    let jpeg = folder.path().join("flag.jpg");
    crate::files::flag(64).save(&jpeg).unwrap();
    load(folder.path().join("cube.obj"));
    let whole_jpeg = fs::read(&jpeg).unwrap();
    for length in [whole_jpeg.len() / 2, whole_jpeg.len() - 10, whole_jpeg.len() - 2] {
        fs::write(&jpeg, &whole_jpeg[..length]).unwrap();
        let fault = self::refused(&folder.path().join("cube.obj"), &["`flag.jpg`", "cut short"]);
        assert!(matches!(fault, MeshFault::Image { .. }), "{length}: {fault:?}");
    }
    write(folder.path(), "cube.mtl", "newmtl skin\nmap_Kd flag.png\n");
    // A header that promises four thousand million pixels.
    let mut bomb = whole;
    bomb[16..24].copy_from_slice(&[0, 1, 0, 0, 0, 1, 0, 0]);
    fs::write(&image, bomb).unwrap();
    let start = Instant::now();
    assert!(matches!(refused(), MeshFault::Image { .. }));
    assert!(start.elapsed() < Duration::from_secs(1), "{:?}", start.elapsed());
}

#[cfg(unix)]
#[test]
fn what_is_no_regular_file_is_not_opened() {
    let pipe = |path: &Path| {
        let _ = fs::remove_file(path);
        assert!(std::process::Command::new("mkfifo").arg(path).status().unwrap().success());
    };
    let folder = cube_folder();
    let cube = folder.path().join("cube.obj");
    pipe(&folder.path().join("flag.png"));
    assert!(matches!(refused(&cube, &["`flag.png`", "regular file"]), MeshFault::MissingFile { .. }));
    pipe(&folder.path().join("cube.mtl"));
    assert!(matches!(refused(&cube, &["`cube.mtl`", "regular file"]), MeshFault::MissingFile { .. }));
    pipe(&cube);
    assert!(matches!(load_all(&cube).unwrap_err().fault, MeshFault::Unreadable(_)));
    assert!(matches!(load_all(folder.path()).unwrap_err().fault, MeshFault::NoMeshInFolder));
    let buffer =
        gltf_cube().to_string().replace(gltf_cube()["buffers"][0]["uri"].as_str().unwrap(), "flag.png");
    let gltf = write(folder.path(), "cube.gltf", &buffer);
    assert!(matches!(refused(&gltf, &["`flag.png`", "regular file"]), MeshFault::MissingFile { .. }));
    pipe(&folder.path().join("LICENCE"));
    assert!(
        load(write(folder.path(), "plain.obj", &(obj_vertices() + &obj_faces(&FACES)))).licence().is_none()
    );
}

#[test]
fn files_outside_the_folder() {
    let outer = tempfile::tempdir().unwrap();
    let inner = outer.path().join("inner");
    fs::create_dir(&inner).unwrap();
    crate::files::flag(8).save(outer.path().join("secret.png")).unwrap();
    write(outer.path(), "secret.mtl", "newmtl skin\n");
    let cube = write(&inner, "cube.obj", &obj_cube());
    let absolute = outer.path().join("secret.png").to_str().unwrap().to_owned();
    for name in ["../secret.png", "..\\secret.png", "./a/../../secret.png", &absolute, "C:\\secret.png"] {
        fs::create_dir_all(inner.join("a")).unwrap();
        write(&inner, "cube.mtl", &format!("newmtl skin\nmap_Kd {name}\n"));
        let fault = refused(&cube, &[&format!("`{name}`"), "not in the mesh's folder"]);
        assert!(matches!(fault, MeshFault::OutsideFolder { .. }));
    }
    write(&inner, "cube.obj", &obj_cube().replace("cube.mtl", "../secret.mtl"));
    assert!(matches!(refused(&cube, &["`../secret.mtl`"]), MeshFault::OutsideFolder { .. }));
    write(&inner, "cube.obj", &obj_cube());
    write(&inner, "cube.mtl", "newmtl skin\nmap_Kd .\n");
    assert!(matches!(refused(&cube, &["`.`"]), MeshFault::MissingFile { .. }));

    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("../secret.png", inner.join("link.png")).unwrap();
        write(&inner, "cube.mtl", "newmtl skin\nmap_Kd link.png\n");
        assert!(matches!(refused(&cube, &["`link.png`"]), MeshFault::OutsideFolder { .. }));
        crate::files::flag(8).save(inner.join("own.png")).unwrap();
        std::os::unix::fs::symlink("own.png", inner.join("own link.png")).unwrap();
        write(&inner, "cube.mtl", "newmtl skin\nmap_Kd own link.png\n");
        load(&cube);
    }
}

#[test]
fn no_damage_makes_the_readers_panic() {
    let folder = cube_folder();
    let obj = fs::read(folder.path().join("cube.obj")).unwrap();
    let mtl = fs::read(folder.path().join("cube.mtl")).unwrap();
    let binary = glb(gltf_cube());
    let (mut loaded, mut tried) = (0, 0);
    for (name, whole) in [("cube.obj", &obj), ("cube.mtl", &mtl), ("cube.glb", &binary)] {
        let path = folder.path().join(name);
        let entry = if name == "cube.mtl" { folder.path().join("cube.obj") } else { path.clone() };
        for round in 0..150 {
            let mut stream = Seed(1).stream(name, round);
            let mut bytes = whole.clone();
            for _ in 0..1 + stream.below(4) {
                let at = stream.below(bytes.len());
                match stream.below(if bytes.len() > 1 { 4 } else { 2 }) {
                    0 => bytes[at] = stream.below(256) as u8,
                    1 => bytes[at] = b"0123456789-/. \nef"[stream.below(17)],
                    2 => drop(bytes.remove(at)),
                    _ => bytes.truncate(at.max(1)),
                }
            }
            fs::write(&path, bytes).unwrap();
            loaded += usize::from(load_all(&entry).is_ok());
            tried += 1;
        }
        fs::write(&path, whole).unwrap();
    }
    assert!(loaded > 0 && loaded < tried, "{loaded} of {tried}");
}
