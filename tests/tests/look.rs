//! `bench look`: one picture of a scene.

use vantage_tests::{Finished, SmallScene};

#[test]
fn a_scene_becomes_one_picture() {
    let scene = SmallScene::new(&[]);
    let picture = scene.path("pictures/look.png");
    let look = |out: &std::path::Path| Finished::of(scene.on(&["look"], "scene.yaml").arg("--out").arg(out));
    look(&picture).expect(0, &[]);
    let sheet = image::open(&picture).unwrap().to_rgb8();
    assert_eq!(sheet.dimensions(), (1280, 2056));
    let count = |left: u32, top: u32, color: [u8; 3]| {
        let pixels = (top..top + 480).flat_map(|y| (left..left + 640).map(move |x| (x, y)));
        pixels.filter(|&(x, y)| sheet.get_pixel(x, y).0 == color).count()
    };
    assert!(count(0, 24, [255, 0, 0]) > 200, "no path");
    assert!(count(640, 24, [255, 255, 0]) > 50, "no box");
    assert!(count(0, 1032, [0, 0, 0]) > 10_000, "no crops");
    for (left, top) in [(0, 0), (640, 0), (0, 504), (640, 504), (0, 1008)] {
        let caption = (top..top + 24).flat_map(|y| (left..left + 640).map(move |x| (x, y)));
        let inked = caption.filter(|&(x, y)| sheet.get_pixel(x, y).0[0] < 128).count();
        assert!(inked > 100, "no caption at {left}, {top}: {inked}");
    }
    look(&scene.path("scene.yaml/look.png")).expect(6, &["scene.yaml"]);
}

#[test]
fn the_symmetries_of_meshes_are_measured() {
    let meshes = "  meshes: [{ path: box.obj, metres_per_unit: 0.1, up: z }]\n  objects: 3";
    let scene = SmallScene::new(&[("  objects: 3", meshes)]);
    scene.write_box();
    let mut look = scene.on(&["look"], "scene.yaml");
    let found = Finished::of(look.arg("--out").arg(scene.path("look.png")));
    found.expect(0, &[]);
    let row = found.stdout.lines().find(|line| line.contains("box")).expect("a row of the mesh");
    let cells: Vec<&str> = row.split(['│', '┆']).map(str::trim).filter(|cell| !cell.is_empty()).collect();
    assert_eq!(cells[..3], ["box", "none", "cyclic: 4"], "{row}");
    let plain = SmallScene::new(&[]);
    let mut look = plain.on(&["look"], "scene.yaml");
    let found = Finished::of(look.arg("--out").arg(plain.path("look.png")));
    assert_eq!(found.stdout.lines().count(), 1, "without meshes there is no table: {}", found.stdout);
}

#[test]
fn objects_that_find_no_room_are_told_with_their_line() {
    let scene = SmallScene::new(&[("objects: 3", "objects: 60")]);
    let text = std::fs::read_to_string(scene.path("scene.yaml")).unwrap();
    let line = 1 + text.lines().position(|line| line.contains("objects: 60")).unwrap();
    let mut commands = [scene.on(&["look"], "scene.yaml"), scene.dataset("d", &["--seeds", "1"])];
    commands[0].arg("--out").arg(scene.path("look.png"));
    for command in &mut commands {
        Finished::of(command).expect(2, &[&format!("scene.yaml:{line}:"), "of 60 objects fit"]);
    }
}
