//! What is refused, of glTF files.

use crate::files::{data_uri, glb, gltf_cube, load, load_all, write};
use serde_json::{Value, json};
use std::fs;
use std::time::{Duration, Instant};
use vantage_sim::mesh_file::MeshFault;

type Change = fn(&mut Value);

/// The fault of a changed cube, after a check that the message names the file and all of `words`.
fn refused(change: impl FnOnce(&mut Value), words: &[&str]) -> MeshFault {
    let mut gltf = gltf_cube();
    change(&mut gltf);
    let folder = tempfile::tempdir().unwrap();
    refused_bytes(folder.path(), "bad.gltf", gltf.to_string().as_bytes(), words)
}

fn refused_bytes(folder: &std::path::Path, name: &str, bytes: &[u8], words: &[&str]) -> MeshFault {
    let path = folder.join(name);
    fs::write(&path, bytes).unwrap();
    let error = load_all(&path).unwrap_err();
    let message = error.to_string();
    for word in [name].iter().chain(words) {
        assert!(message.contains(word), "{word:?} is not in: {message}");
    }
    error.fault
}

#[test]
fn the_cube_itself_is_sound() {
    let folder = tempfile::tempdir().unwrap();
    load(write(folder.path(), "cube.gltf", &gltf_cube().to_string()));
}

#[test]
fn extras_are_any_json() {
    let folder = tempfile::tempdir().unwrap();
    for extras in [json!([1, "two"]), json!("words"), json!(3), json!({ "a": [] }), json!(null)] {
        let mut gltf = gltf_cube();
        for part in ["asset", "nodes", "meshes", "accessors", "buffers"] {
            let part = if part == "asset" { &mut gltf[part] } else { &mut gltf[part][0] };
            part["extras"] = extras.clone();
        }
        gltf["extras"] = extras;
        load(write(folder.path(), "cube.gltf", &gltf.to_string()));
    }
}

#[test]
fn extensions_are_named() {
    for extension in ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_mesh_quantization"] {
        let fault = refused(|gltf| gltf["extensionsRequired"] = json!([extension]), &[extension]);
        assert!(matches!(fault, MeshFault::Extension(_)));
    }
    let fault = refused(
        |gltf| gltf["extensionsUsed"] = json!(["KHR_lights_punctual", "KHR_texture_transform"]),
        &["KHR_texture_transform"],
    );
    assert!(matches!(fault, MeshFault::Extension(_)));
}

#[test]
fn indices_and_ranges() {
    let fault =
        refused(|gltf| gltf["accessors"][1]["count"] = json!(7), &["vertex", "got 7, expected less than 7"]);
    assert!(matches!(fault, MeshFault::Index { got: 7, len: 7, .. }));
    let attribute =
        |gltf: &mut Value| gltf["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(9);
    assert!(matches!(refused(attribute, &["an accessor", "got 9"]), MeshFault::Index { got: 9, len: 2, .. }));
    let huge: [Change; 8] = [
        |gltf| gltf["bufferViews"][1]["byteLength"] = json!(97),
        |gltf| gltf["accessors"][1]["count"] = json!(9),
        |gltf| gltf["accessors"][1]["byteOffset"] = json!(u64::MAX / 2),
        |gltf| gltf["bufferViews"][1]["byteOffset"] = json!(u64::MAX),
        |gltf| gltf["bufferViews"][1]["byteLength"] = json!(95),
        |gltf| gltf["bufferViews"][1]["byteStride"] = json!(252),
        |gltf| gltf["buffers"][0]["byteLength"] = json!(169),
        |gltf| gltf["buffers"][0]["uri"] = json!(data_uri(&[])),
    ];
    for (i, change) in huge.into_iter().enumerate() {
        let fault = refused(change, &["out of range"]);
        assert!(matches!(fault, MeshFault::Index { .. }), "{i}: {fault:?}");
    }
    let broken: [(Change, &str); 11] = [
        (|gltf| gltf["accessors"][1]["componentType"] = json!(5121), "another type"),
        (|gltf| gltf["asset"]["version"] = json!("3.0"), "expected 2.0"),
        (
            |gltf| gltf["nodes"] = json!([{ "children": [1, 2] }, { "children": [2] }, { "mesh": 0 }]),
            "node 2 has more than one parent",
        ),
        (|gltf| gltf["nodes"][0]["mesh"] = json!(5), "bad.gltf"),
        (|gltf| gltf["scene"] = json!(5), "bad.gltf"),
        (|gltf| gltf["accessors"][1]["bufferView"] = json!(5), "bad.gltf"),
        (|gltf| gltf["bufferViews"][0]["byteLength"] = json!(1e300), "1e+300"),
        (|gltf| gltf["accessors"][1]["type"] = json!("VEC2"), "type"),
        (|gltf| gltf["meshes"][0]["primitives"][0]["attributes"] = json!({ "POSITION": 0 }), ""),
        (|gltf| gltf["buffers"][0]["uri"] = json!("data:text/plain,cube"), "base64"),
        (|gltf| gltf["asset"] = json!({ "version": "2.0", "minVersion": 3 }), "bad.gltf"),
    ];
    for (i, (change, word)) in broken.into_iter().enumerate() {
        let fault = refused(change, &[word]);
        assert!(matches!(fault, MeshFault::Syntax { .. }), "{i}: {fault:?}");
    }
    // As many bytes of indices as before: three times as many as are counted, and numbers that are not whole.
    for (key, value, count) in [("type", json!("VEC3"), 12), ("componentType", json!(5126), 18)] {
        let other = |gltf: &mut Value| {
            gltf["accessors"][0][key] = value;
            gltf["accessors"][0]["count"] = json!(count);
        };
        assert!(matches!(refused(other, &["another type"]), MeshFault::Syntax { .. }), "{key}");
    }
    let not_finite = |gltf: &mut Value| gltf["nodes"][0]["scale"] = json!([1e39, 1e39, 1e39]);
    let fault = refused(not_finite, &[]);
    assert!(matches!(fault, MeshFault::NotFinite(_) | MeshFault::Syntax { .. }), "{fault:?}");
}

#[test]
fn nothing_to_see() {
    let empty: [Change; 5] = [
        |gltf| gltf["scenes"] = json!([{ "nodes": [] }]),
        |gltf| gltf["nodes"] = json!([{ "name": "empty" }]),
        |gltf| gltf["meshes"][0]["primitives"][0]["mode"] = json!(1),
        |gltf| gltf["accessors"][0]["count"] = json!(2),
        |gltf| {
            drop((
                gltf["scenes"].take(),
                gltf["scene"].take(),
                gltf["scenes"] = json!([]),
                gltf.as_object_mut().unwrap().remove("scene"),
            ))
        },
    ];
    for (i, change) in empty.into_iter().enumerate() {
        let fault = refused(change, &["no triangle"]);
        assert!(matches!(fault, MeshFault::NoTriangle), "{i}: {fault:?}");
    }
}

#[test]
fn more_than_a_renderer_takes_is_refused_before_it_is_read() {
    let start = Instant::now();
    let fault = refused(|gltf| gltf["accessors"][0]["count"] = json!(30_000_000), &["10000000 triangles"]);
    assert!(matches!(fault, MeshFault::TooMany { .. }));
    let fault = refused(|gltf| gltf["accessors"][1]["count"] = json!(u32::MAX), &["vertices"]);
    assert!(matches!(fault, MeshFault::TooMany { .. }));
    // Each node holds the next one twice: 2^40 cubes in forty lines.
    let doubled = |gltf: &mut Value| {
        let mut nodes: Vec<Value> = (1..41).map(|i| json!({ "children": [i, i] })).collect();
        nodes.push(json!({ "mesh": 0 }));
        gltf["nodes"] = json!(nodes);
    };
    assert!(matches!(refused(doubled, &["nodes"]), MeshFault::TooMany { .. } | MeshFault::Syntax { .. }));
    let primitive = gltf_cube()["meshes"][0]["primitives"][0].clone();
    let many = |gltf: &mut Value| gltf["meshes"][0]["primitives"] = json!(vec![primitive.clone(); 10_001]);
    assert!(matches!(refused(many, &["10001 primitives"]), MeshFault::TooMany { .. }));
    let looped = |gltf: &mut Value| gltf["nodes"] = json!([{ "children": [1] }, { "children": [0] }]);
    assert!(matches!(refused(looped, &["nodes"]), MeshFault::TooMany { .. } | MeshFault::Syntax { .. }));
    assert!(start.elapsed() < Duration::from_secs(5));
}

#[test]
fn features_that_would_look_wrong() {
    let colors = |gltf: &mut Value| gltf["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(1);
    assert!(matches!(refused(colors, &["colours at its vertices"]), MeshFault::Unsupported(..)));
    let sparse = |gltf: &mut Value| {
        gltf["accessors"][1]["sparse"] = json!({ "count": 1,
            "indices": { "bufferView": 0, "componentType": 5123 }, "values": { "bufferView": 1 } });
    };
    assert!(matches!(refused(sparse, &["sparse"]), MeshFault::Unsupported(..)));
    let skinned = |gltf: &mut Value| {
        gltf["skins"] = json!([{ "joints": [0] }]);
        gltf["nodes"][0]["skin"] = json!(0);
    };
    assert!(matches!(refused(skinned, &["skin"]), MeshFault::Unsupported(..)));
    let morphed = |weight: f64| {
        move |gltf: &mut Value| {
            gltf["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": 1 }]);
            gltf["meshes"][0]["weights"] = json!([weight]);
        }
    };
    assert!(matches!(refused(morphed(0.5), &["morph targets"]), MeshFault::Unsupported(..)));
    let mut at_rest = gltf_cube();
    morphed(0.0)(&mut at_rest);
    let folder = tempfile::tempdir().unwrap();
    load(write(folder.path(), "cube.gltf", &at_rest.to_string()));
    let textured = |gltf: &mut Value| {
        gltf["materials"] =
            json!([{ "name": "bark", "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
        gltf["textures"] = json!([{ "source": 0 }]);
        let mut png = Vec::new();
        crate::files::flag(4).write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png).unwrap();
        gltf["images"] = json!([{ "uri": data_uri(&png) }]);
        gltf["meshes"][0]["primitives"][0]["material"] = json!(0);
    };
    assert!(matches!(refused(textured, &["`bark`"]), MeshFault::NoTextureCoordinates(_)));
}

#[test]
fn files_it_names() {
    for name in ["../cube.bin", "%2e%2e/cube.bin", "/etc/hostname", "..%5Ccube.bin"] {
        let outer = tempfile::tempdir().unwrap();
        let inner = outer.path().join("inner");
        fs::create_dir(&inner).unwrap();
        fs::write(outer.path().join("cube.bin"), [0; 168]).unwrap();
        let mut gltf = gltf_cube();
        gltf["buffers"][0]["uri"] = json!(name);
        let fault =
            refused_bytes(&inner, "bad.gltf", gltf.to_string().as_bytes(), &["not in the mesh's folder"]);
        assert!(matches!(fault, MeshFault::OutsideFolder { .. }), "{name}: {fault:?}");
    }
    let fault = refused(|gltf| gltf["buffers"][0]["uri"] = json!("gone%20away.bin"), &["`gone away.bin`"]);
    assert!(matches!(fault, MeshFault::MissingFile { .. }));
    let missing = |gltf: &mut Value| {
        gltf["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
        gltf["textures"] = json!([{ "source": 0 }]);
        gltf["images"] = json!([{ "uri": "bark.jpg" }]);
        gltf["meshes"][0]["primitives"][0]["material"] = json!(0);
    };
    assert!(matches!(refused(missing, &["`bark.jpg`"]), MeshFault::MissingFile { .. }));
}

#[test]
fn binaries_cut_short_or_lying_about_their_length() {
    let folder = tempfile::tempdir().unwrap();
    let whole = glb(gltf_cube());
    for length in 0..whole.len() {
        let fault = refused_bytes(folder.path(), "bad.glb", &whole[..length], &[]);
        assert!(matches!(fault, MeshFault::Syntax { .. } | MeshFault::Index { .. }), "{length}: {fault:?}");
    }
    for length in [0, 11, 12, 13, whole.len() as u32 - 4, whole.len() as u32 + 4, u32::MAX] {
        let mut lying = whole.clone();
        lying[8..12].copy_from_slice(&length.to_le_bytes());
        refused_bytes(folder.path(), "bad.glb", &lying, &["the header says"]);
    }
}
