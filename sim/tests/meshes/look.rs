//! Shape, orientation and colours.

use crate::files::{
    CORNERS, FACES, cube_folder, flag, glb, gltf_cube, load, obj_cube, obj_faces, obj_vertices, spec, write,
};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use image::{Rgb, RgbImage};
use nalgebra::Vector3;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use vantage_sim::mesh::Mesh;
use vantage_sim::model::Model;
use vantage_sim::object::{MeshLibrary, Object};
use vantage_sim::scene::UpAxis;

fn point(p: [f32; 3]) -> Vector3<f64> {
    Vector3::from(p).map(f64::from)
}

fn volume(mesh: &Mesh) -> f64 {
    let six = mesh.triangles.iter().map(|corners| {
        let [a, b, c] = corners.map(|i| point(mesh.positions[i as usize]));
        a.dot(&b.cross(&c))
    });
    six.sum::<f64>() / 6.0
}

/// The finest texel at texture coordinates.
fn texel(model: &Model, uv: [f64; 2]) -> [u8; 3] {
    let side = model.texture.side() as f64;
    let [x, y] = uv.map(|t| (t * side) as usize);
    let [r, g, b, _] = model.texture.level(0)[y * side as usize + x];
    [r, g, b]
}

/// The colour at a point of a triangle, given by its weights.
fn color_at(model: &Model, triangle: usize, weights: [f64; 3]) -> [u8; 3] {
    let uvs = model.mesh.triangles[triangle].map(|i| model.mesh.uvs[i as usize].map(f64::from));
    texel(model, [0, 1].map(|axis| (0..3).map(|i| weights[i] * uvs[i][axis]).sum()))
}

/// The colour in the middle of a triangle.
fn color(model: &Model, triangle: usize) -> [u8; 3] {
    color_at(model, triangle, [1.0 / 3.0; 3])
}

fn assert_sound(object: &Object) {
    let mesh = &object.model.mesh;
    for (vertex, normal) in mesh.normals.iter().enumerate() {
        assert!((point(*normal).norm() - 1.0).abs() < 1e-6, "normal {vertex}");
        assert!(mesh.uvs[vertex].iter().all(|t| (0.0..=1.0).contains(t)), "uv {vertex}");
    }
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|i| point(mesh.positions[i as usize]));
        let shading: Vector3<f64> = corners.iter().map(|&i| point(mesh.normals[i as usize])).sum();
        assert!((b - a).cross(&(c - a)).dot(&shading) > 0.0, "a triangle faces away from its normals");
    }
}

/// A cube of a tenth of a metre, right side out.
fn assert_cube(object: &Object) {
    assert_sound(object);
    assert!((object.half_extents - Vector3::repeat(0.05)).norm() < 1e-7);
    assert!((volume(&object.model.mesh) - 1e-3).abs() < 1e-9);
    assert!((object.size - 0.1 * 3f64.sqrt()).abs() < 1e-6);
    assert!((object.mass - 0.4).abs() < 1e-3, "{} kg", object.mass);
    assert_eq!((object.model.mesh.triangles.len(), object.hull.len()), (12, 8));
    // Flat shading: three normals at each corner.
    assert_eq!(
        object.model.mesh.normals.iter().filter(|n| n.iter().filter(|x| x.abs() > 0.99).count() == 1).count(),
        object.model.mesh.normals.len()
    );
}

/// The flag stands upright on the four sides: the corners of triangles that are higher are redder.
fn assert_upright_flag(object: &Object) {
    let model = &object.model;
    let mut seen = 0;
    for (i, corners) in model.mesh.triangles.iter().enumerate() {
        let heights = corners.map(|corner| model.mesh.positions[corner as usize][2]);
        if model.mesh.normals[corners[0] as usize][2].abs() < 0.5 {
            for (corner, height) in heights.into_iter().enumerate() {
                let mut weights = [0.1; 3];
                weights[corner] = 0.8;
                let [r, _, b] = color_at(model, i, weights);
                let expected = if height > 0.0 { (200, 0) } else { (0, 200) };
                assert_eq!((r, b), expected, "triangle {i}, corner {corner}");
                seen += 1;
            }
        }
    }
    assert_eq!(seen, 24);
}

#[test]
fn an_obj_cube_is_centred_scaled_and_shows_its_image_upright() {
    let folder = cube_folder();
    let mesh = load(folder.path().join("cube.obj"));
    assert_eq!((mesh.name.as_str(), mesh.category.as_str()), ("cube", "cube"));
    assert_cube(&mesh.object().unwrap());
    assert_upright_flag(&mesh.object().unwrap());
}

/// The glTF cube with a texture: 24 vertices, of which each four of a face have the corners of the image.
fn textured_gltf(image: &RgbImage) -> Value {
    let mut gltf = gltf_cube();
    let positions: Vec<u8> =
        FACES.iter().flatten().flat_map(|&i| CORNERS[i]).flat_map(f32::to_le_bytes).collect();
    let uvs: Vec<u8> = (0..6)
        .flat_map(|_| [[0f32, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]])
        .flatten()
        .flat_map(f32::to_le_bytes)
        .collect();
    let indices: Vec<u8> = (0..6u8).flat_map(|f| [0, 1, 2, 0, 2, 3].map(|i| 4 * f + i)).collect();
    let mut png = Vec::new();
    image.write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png).unwrap();
    let parts = [indices, positions, uvs, png];
    let mut offset = 0;
    gltf["bufferViews"] = parts
        .iter()
        .map(|part| {
            let view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": part.len() });
            offset += part.len();
            view
        })
        .collect();
    gltf["buffers"] = json!([{ "byteLength": offset, "uri": crate::files::data_uri(&parts.concat()) }]);
    gltf["accessors"] = json!([
        { "bufferView": 0, "componentType": 5121, "count": 36, "type": "SCALAR" },
        { "bufferView": 1, "componentType": 5126, "count": 24, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1] },
        { "bufferView": 2, "componentType": 5126, "count": 24, "type": "VEC2" },
    ]);
    gltf["meshes"][0]["primitives"][0] =
        json!({ "attributes": { "POSITION": 1, "TEXCOORD_0": 2 }, "indices": 0, "material": 0 });
    gltf["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
    gltf["textures"] = json!([{ "source": 0 }]);
    gltf["images"] = json!([{ "bufferView": 3, "mimeType": "image/png" }]);
    gltf
}

#[test]
fn marks_and_names_of_old_exporters_are_read() {
    let folder = cube_folder();
    let plain = load(write(folder.path(), "plain.obj", &obj_cube()));
    let text = [b"\xef\xbb\xbf# of M\xfcller\n".as_slice(), obj_cube().as_bytes()].concat();
    let path = folder.path().join("marked.obj");
    fs::write(&path, text).unwrap();
    assert_eq!(
        load(path).object().unwrap().model.mesh.positions,
        plain.object().unwrap().model.mesh.positions
    );
}

#[test]
fn gltf_and_glb_give_the_same_cube_as_obj() {
    let folder = cube_folder();
    let gltf = textured_gltf(&flag(64));
    let text = load(write(folder.path(), "text.gltf", &gltf.to_string()));
    let path = folder.path().join("binary.glb");
    fs::write(&path, glb(gltf)).unwrap();
    let (binary, obj) = (load(path), load(folder.path().join("cube.obj")));
    for mesh in [&text, &binary] {
        assert_cube(&mesh.object().unwrap());
        assert_upright_flag(&mesh.object().unwrap());
        assert_eq!(mesh.object().unwrap().model.texture, obj.object().unwrap().model.texture);
    }
    assert_eq!(text.object().unwrap().model, binary.object().unwrap().model);
}

#[test]
fn y_up_becomes_z_up_and_the_front_of_gltf_becomes_plus_x() {
    let folder = tempfile::tempdir().unwrap();
    // 1 wide (x), 2 high (y), 4 deep (z), with a nose in front (+z).
    let mut vertices: String =
        CORNERS.iter().map(|[x, y, z]| format!("v {x} {} {}\n", 2.0 * y, 4.0 * z)).collect();
    vertices += "v 0.5 1 6\n";
    let quads: String =
        FACES.iter().map(|f| format!("f {} {} {} {}\n", f[0] + 1, f[1] + 1, f[2] + 1, f[3] + 1)).collect();
    let path =
        write(folder.path(), "nose.obj", &format!("{vertices}{quads}f 5 6 9\nf 6 7 9\nf 7 8 9\nf 8 5 9\n"));
    let standing = vantage_sim::scene::MeshSpec { up: UpAxis::Y, ..spec(path) };
    let library = MeshLibrary::load(&[standing], Path::new(""), None, &mut |_| ()).unwrap();
    let object = &library.iter().next().unwrap().object().unwrap();
    assert!((object.half_extents - Vector3::new(0.3, 0.05, 0.1)).norm() < 1e-7, "{}", object.half_extents);
    let front = object.model.mesh.positions.iter().filter(|p| p[0] > 0.299).count();
    assert!((1..=8).contains(&front), "the nose is not in front");
    assert_sound(object);
}

#[test]
fn nodes_turn_scale_and_mirror_what_they_hold() {
    let folder = tempfile::tempdir().unwrap();
    let mut gltf = gltf_cube();
    gltf["nodes"] = json!([
        { "children": [1, 2] },
        { "mesh": 0, "scale": [-1.0, 1.0, 1.0] },
        { "mesh": 0, "translation": [1.0, 0.0, 0.0], "scale": [1.0, 1.0, 3.0] },
    ]);
    let mesh = load(write(folder.path(), "two.gltf", &gltf.to_string()));
    assert_sound(&mesh.object().unwrap());
    assert!((mesh.object().unwrap().half_extents - Vector3::new(0.15, 0.05, 0.15)).norm() < 1e-6);
    assert!(
        (volume(&mesh.object().unwrap().model.mesh) - 4e-3).abs() < 1e-8,
        "a mirrored part is inside out"
    );
}

#[test]
fn a_mesh_that_is_inside_out_is_turned() {
    let folder = tempfile::tempdir().unwrap();
    let reversed = FACES.map(|[a, b, c, d]| [d, c, b, a]);
    let mesh = load(write(folder.path(), "reversed.obj", &(obj_vertices() + &obj_faces(&reversed))));
    assert_cube(&mesh.object().unwrap());
}

#[test]
fn an_open_surface_is_seen_from_both_sides_and_a_closed_one_once() {
    let folder = tempfile::tempdir().unwrap();
    let open = load(write(folder.path(), "open.obj", &(obj_vertices() + &obj_faces(&FACES[..5]))));
    assert_eq!(open.object().unwrap().model.mesh.triangles.len(), 20);
    assert_sound(&open.object().unwrap());
}

#[test]
fn several_materials_share_the_texture_and_keep_their_colours() {
    let folder = tempfile::tempdir().unwrap();
    let materials = ["flag", "grey", "white", "green", "flag", "mirror"];
    let faces: String = FACES
        .iter()
        .zip(materials)
        .map(|(face, name)| format!("usemtl {name}\n{}", obj_faces(&[*face])))
        .collect();
    write(
        folder.path(),
        "all.mtl",
        "newmtl flag\nKd 0 0 0\nmap_Kd a flag.png \nnewmtl grey\nKd 0.5 0.5 0.5\nnewmtl white\nnewmtl\tgreen\t\n\
         Kd 0 1 0\nnewmtl mirror\nKd 0.2 0.4 0.6\nillum 3\n",
    );
    flag(300).save(folder.path().join("a flag.png")).unwrap();
    let path = write(folder.path(), "all.obj", &format!("mtllib all.mtl\n{}{faces}", obj_vertices()));
    let object = load(path).object().unwrap();
    assert_sound(&object);
    let seen: Vec<[u8; 3]> = (0..12).map(|triangle| color(&object.model, triangle)).collect();
    let flag = [[0, 0, 200], [200, 0, 0]];
    assert_eq!(&seen[..2], &flag);
    assert_eq!(seen[2..4], [[128; 3]; 2]);
    assert_eq!(seen[4..6], [[255; 3]; 2]);
    assert_eq!(seen[6..8], [[0, 255, 0]; 2]);
    assert_eq!(seen[8..10], flag);
    assert_eq!(seen[10..12], [[51, 102, 153]; 2]);
}

#[test]
fn the_base_colour_of_gltf_is_linear_and_multiplies_the_image() {
    let folder = tempfile::tempdir().unwrap();
    let mut gltf = textured_gltf(&RgbImage::from_pixel(4, 4, Rgb([255, 255, 128])));
    gltf["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([0.5, 1.0, 0.5, 1.0]);
    let object = load(write(folder.path(), "tinted.gltf", &gltf.to_string())).object().unwrap();
    assert_eq!(color(&object.model, 0), [188, 255, 92]);
    let mut plain = gltf_cube();
    plain["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.0, 1.0, 1.0] } }]);
    plain["meshes"][0]["primitives"][0]["material"] = json!(0);
    let object = load(write(folder.path(), "plain.gltf", &plain.to_string())).object().unwrap();
    assert_eq!(color(&object.model, 0), [188, 0, 255]);
}

/// A cube whose faces show the range `low..high` of the image along u.
fn obj_with_u(low: f64, high: f64) -> String {
    let corners = format!("vt {low} 0\nvt {high} 0\nvt {high} 1\nvt {low} 1\n");
    obj_cube().replace("vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n", &corners)
}

#[test]
fn an_image_repeats_outside_of_its_range() {
    let folder = cube_folder();
    let left_red = RgbImage::from_fn(64, 64, |x, _| if x < 32 { Rgb([200, 0, 0]) } else { Rgb([0, 0, 200]) });
    left_red.save(folder.path().join("flag.png")).unwrap();
    let red_at = |u: [f64; 2], share: f64| {
        let object = load(write(folder.path(), "cube.obj", &obj_with_u(u[0], u[1]))).object().unwrap();
        // The first triangle has the corners low, high, high.
        let rest = (share - 0.02) / 0.98;
        color_at(&object.model, 0, [1.0 - rest, rest - 0.02, 0.02])[0] == 200
    };
    for (range, share, red) in [
        ([7.0, 8.0], 0.25, true),
        ([7.0, 8.0], 0.75, false),
        ([-0.5, 0.5], 0.25, false),
        ([-0.5, 0.5], 0.75, true),
        ([0.0, 3.0], 0.10, true),
        ([0.0, 3.0], 0.25, false),
        ([0.0, 3.0], 0.75, true),
        ([0.0, 3.0], 0.95, false),
    ] {
        assert_eq!(red_at(range, share), red, "u in {range:?}, at {share}");
    }
}

#[test]
fn samplers_of_gltf_clamp_and_mirror() {
    let folder = tempfile::tempdir().unwrap();
    let left_red = RgbImage::from_fn(64, 64, |x, _| if x < 32 { Rgb([200, 0, 0]) } else { Rgb([0, 0, 200]) });
    let shifted = |wrap: u32| {
        let mut gltf = textured_gltf(&left_red);
        gltf["samplers"] = json!([{ "wrapS": wrap }]);
        gltf["textures"] = json!([{ "source": 0, "sampler": 0 }]);
        // Move u from 0..1 to 1..2: 24 vertices after 36 bytes of indices and 288 of positions.
        let uri = gltf["buffers"][0]["uri"].as_str().unwrap().to_owned();
        let mut bytes = BASE64_STANDARD.decode(uri.split_once(',').unwrap().1).unwrap();
        for u in bytes[324..324 + 192].chunks_exact_mut(8) {
            let moved = f32::from_le_bytes([u[0], u[1], u[2], u[3]]) + 1.0;
            u[..4].copy_from_slice(&moved.to_le_bytes());
        }
        gltf["buffers"][0]["uri"] = json!(crate::files::data_uri(&bytes));
        let object = load(write(folder.path(), &format!("{wrap}.gltf"), &gltf.to_string())).object().unwrap();
        [[0.8, 0.1, 0.1], [0.1, 0.8, 0.1]].map(|weights| color_at(&object.model, 0, weights)[0])
    };
    assert_eq!(shifted(10497), [200, 0], "repeated");
    assert_eq!(shifted(33648), [0, 200], "mirrored");
    assert_eq!(shifted(33071), [0, 0], "clamped");
}

#[test]
fn fine_images_are_averaged_not_picked_from() {
    let folder = cube_folder();
    let checkers = RgbImage::from_fn(2048, 2048, |x, y| Rgb([if (x + y) % 2 == 0 { 255 } else { 0 }; 3]));
    checkers.save(folder.path().join("flag.png")).unwrap();
    let object = load(folder.path().join("cube.obj")).object().unwrap();
    for (i, [r, _, _, _]) in object.model.texture.level(0).iter().enumerate() {
        assert!((126..=129).contains(r), "texel {i} is {r}");
    }
}

#[test]
fn what_no_triangle_shows_does_not_bleed_into_what_one_does() {
    let folder = cube_folder();
    // The faces show a yellow quarter of a magenta image.
    let image = RgbImage::from_fn(256, 256, |x, y| {
        Rgb(if (64..192).contains(&x) && (64..192).contains(&y) { [250, 250, 0] } else { [255, 0, 255] })
    });
    image.save(folder.path().join("flag.png")).unwrap();
    let corners = "vt 0.26 0.26\nvt 0.74 0.26\nvt 0.74 0.74\n";
    let triangles: String = FACES
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .map(|[a, b, c]| format!("f {}/1 {}/2 {}/3\n", a + 1, b + 1, c + 1))
        .collect();
    let text = obj_cube();
    let vertices = text.split("vt ").next().unwrap();
    let path = write(folder.path(), "cube.obj", &format!("{vertices}{corners}usemtl skin\n{triangles}"));
    let object = load(path).object().unwrap();
    for (level, texels) in object.model.texture.levels().enumerate() {
        for [r, g, b, _] in texels {
            assert_eq!([*r, *g, *b], [250, 250, 0], "level {level}");
        }
    }
}
