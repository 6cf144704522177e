use super::*;
use image::Rgb;

const TURNTABLE: Turntable = Turntable { elevation: 0.4, distance: 5.0, clockwise: false };

/// A white box on black, at the left of the image.
fn write(path: &Path) {
    let pixel = |x: u32, y: u32| if x < 8 && (4..20).contains(&y) { Rgb([200; 3]) } else { Rgb([3; 3]) };
    RgbImage::from_fn(24, 24, pixel).save(path).unwrap();
}

fn read(folder: &Path) -> Result<(ViewSet, ImportReport), ImportError> {
    read_turned_photos(folder, Split::Test, &TURNTABLE, &|name| name != "left_out")
}

#[test]
fn objects_sessions_and_azimuths_are_read_from_names() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("evening")).unwrap();
    for name in ["cup__90.png", "cup__5.5.png", "a__b__0.png", "left_out__0.png", "evening/cup__90.png"] {
        write(&at(name));
    }
    std::fs::write(at("notes.txt"), "none").unwrap();
    std::fs::write(at("cup__7.png"), "no image").unwrap();
    RgbImage::new(8, 8).save(at("cup__8.png")).unwrap();
    let (set, report) = read(folder.path()).unwrap();
    let names: Vec<&str> = set.instances.iter().map(|instance| instance.family.as_str()).collect();
    assert_eq!(names, ["a__b", "cup"]);
    let seen: Vec<(usize, usize, i64)> = set
        .views
        .iter()
        .map(|view| {
            (view.instance, view.session, (10.0 * view.viewpoint.azimuth().to_degrees()).round() as i64)
        })
        .collect();
    assert_eq!(seen, [(0, 0, 0), (1, 0, 55), (1, 0, 900), (1, 1, 900)]);
    assert!((set.views[0].viewpoint.elevation() - 0.4).abs() < 1e-12);
    assert_eq!((report.views, report.skipped.len()), (4, 2));
}

#[test]
fn photographs_by_other_names_are_told_and_endings_may_be_capital() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for name in
        ["cup__10.PNG", "cup_20.png", "cup__x.png", ".cup__30.png", "cup__10_MASK.png", "pot__1_mask.png"]
    {
        write(&at("saved.png"));
        std::fs::rename(at("saved.png"), at(name)).unwrap();
    }
    let (set, report) = read(folder.path()).unwrap();
    assert_eq!((set.views.len(), set.instances.len()), (1, 1));
    let told: Vec<String> = report.skipped.iter().map(|skipped| skipped.to_string()).collect();
    assert_eq!(told.len(), 3, "{told:?}");
    assert!(told[0].contains("cup_20.png") && told[0].contains("OBJECT__AZIMUTH"), "{told:?}");
    assert!(told[2].contains("pot__1_mask.png"), "{told:?}");
}

#[cfg(target_os = "linux")]
#[test]
fn names_that_are_no_line_of_text_are_left_out_and_told() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &[u8]| folder.path().join(OsStr::from_bytes(name));
    let names: [&[u8]; 6] = [
        b"a\tb__0.png",
        b"a\nb__0.png",
        b"a\rb__0_mask.png",
        b"a\xc2\x85b__0.png",
        b"a\xfeb__0.png",
        b"a\xffb__0.png",
    ];
    write(&at(b"cup__0.png"));
    for name in names {
        std::fs::copy(at(b"cup__0.png"), at(name)).unwrap();
    }
    let (set, report) = read(folder.path()).unwrap();
    assert_eq!((set.instances.len(), set.instances[0].family.as_str()), (1, "cup"));
    let told: Vec<String> = report.skipped.iter().map(|skipped| skipped.to_string()).collect();
    assert_eq!(told.len(), names.len(), "{told:?}");
    assert!(told[0].contains(r#""a\tb__0.png""#) && told[5].contains(r#""a\xFFb__0.png""#), "{told:?}");
    assert!(!told.concat().contains(char::is_control), "{told:?}");
}

#[test]
fn folders_inside_a_sessions_folder_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir_all(at("day/x")).unwrap();
    std::fs::create_dir_all(at("day/y")).unwrap();
    write(&at("day/cup__0.png"));
    write(&at("day/x/cup__90.png"));
    let (set, report) = read(folder.path()).unwrap();
    assert_eq!((set.views.len(), report.skipped.len()), (1, 1));
    assert_eq!(report.skipped[0].file, at("day/x"));
    assert!(report.skipped[0].reason.contains("2 here"), "{report:?}");
}

#[test]
fn a_mask_that_is_no_png_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    write(&at("cup__0.png"));
    std::fs::copy(at("cup__0.png"), at("cup__0_mask.jpg")).unwrap();
    let (set, report) = read(folder.path()).unwrap();
    assert_eq!((set.views.len(), report.skipped.len()), (1, 1));
    assert!(report.skipped[0].reason.contains("no PNG"), "{report:?}");
}

#[test]
fn an_azimuth_is_given_once_modulo_a_turn() {
    let folder = tempfile::tempdir().unwrap();
    write(&folder.path().join("cup__-90.png"));
    write(&folder.path().join("cup__270.png"));
    let error = read(folder.path()).unwrap_err().to_string();
    assert!(error.contains("cup at 270 degrees twice"), "{error}");
}

#[test]
fn without_a_mask_the_background_is_dark() {
    let folder = tempfile::tempdir().unwrap();
    RgbImage::from_pixel(24, 24, Rgb([140; 3])).save(folder.path().join("cup__0.png")).unwrap();
    let shaded = |x: u32, y: u32| Rgb([if x + y < 6 { 10 } else { 50 }; 3]);
    RgbImage::from_fn(24, 24, shaded).save(folder.path().join("cup__10.png")).unwrap();
    let (set, report) = read(folder.path()).unwrap();
    assert!(set.views.is_empty() && report.skipped.len() == 2, "{report:?}");
    assert!(report.skipped.iter().all(|skipped| skipped.reason.contains("put a mask beside")), "{report:?}");
}

#[test]
fn without_a_mask_the_background_becomes_black() {
    let folder = tempfile::tempdir().unwrap();
    let pixel = |x: u32, y: u32| if x < 8 && (4..20).contains(&y) { Rgb([90; 3]) } else { Rgb([40; 3]) };
    RgbImage::from_fn(24, 24, pixel).save(folder.path().join("cup__0.png")).unwrap();
    let crop = read(folder.path()).unwrap().0.views.remove(0).crop;
    let of = |value: u8| crop.0.iter().filter(|&&channel| channel == value).count();
    assert!(of(0) > 100 && of(90) > 100, "{} and {}", of(0), of(90));
    assert_eq!(of(40), 0);
}

#[test]
fn an_object_that_looks_the_same_from_all_round_is_a_surface_of_revolution() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for degrees in (0..360).step_by(10) {
        write(&at(&format!("ball__{degrees}.png")));
        let dark = degrees * 200 / 360;
        let pixel = |x: u32, _| Rgb([if x < 12 { 255 } else { 255 - dark as u8 }; 3]);
        let mut photo = RgbImage::new(24, 24);
        (4..20).for_each(|x| (4..20).for_each(|y| photo.put_pixel(x, y, pixel(x, y))));
        photo.save(at(&format!("box__{degrees}.png"))).unwrap();
    }
    let symmetries: Vec<Symmetry> =
        read(folder.path()).unwrap().0.instances.iter().map(|instance| instance.symmetry).collect();
    assert_eq!(symmetries, [Symmetry::Revolution, Symmetry::None]);
}

#[test]
fn azimuths_may_grow_the_other_way_round() {
    let clockwise = Turntable { clockwise: true, ..TURNTABLE };
    assert!((clockwise.viewpoint(1.0).azimuth() + 1.0).abs() < 1e-12);
}

#[test]
fn a_mask_says_what_is_the_object_and_has_to_fit() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    write(&at("cup__0.png"));
    let whole = read(folder.path()).unwrap().0.views.remove(0).crop;
    RgbImage::from_fn(24, 24, |x, y| Rgb([u8::from(x < 4 && y < 12); 3]))
        .save(at("cup__0_mask.png"))
        .unwrap();
    let masked = read(folder.path()).unwrap().0.views.remove(0).crop;
    let bright = |crop: &Crop| crop.0.iter().filter(|&&value| value > 100).count();
    assert!(bright(&masked) > 0 && bright(&masked) < bright(&whole));
    RgbImage::new(5, 5).save(at("cup__0_mask.png")).unwrap();
    let (set, report) = read(folder.path()).unwrap();
    assert!(set.instances.is_empty() && report.skipped[0].reason.contains("as large as its image"));
}

#[test]
fn a_huge_image_is_left_out_and_told() {
    let folder = tempfile::tempdir().unwrap();
    let huge = folder.path().join("cup__10.png");
    RgbImage::new(1, 20_000).save(&huge).unwrap();
    write(&folder.path().join("cup__0.png"));
    let (set, report) = read(folder.path()).unwrap();
    assert_eq!((set.views.len(), &report.skipped[0].file), (1, &huge));
    assert!(report.skipped[0].reason.contains("make the image smaller"), "{}", report.skipped[0]);
}

#[cfg(unix)]
#[test]
fn what_is_no_regular_file_is_left_out_and_told() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("cup__10.png");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    write(&folder.path().join("cup__0.png"));
    let (set, report) = read(folder.path()).unwrap();
    assert_eq!((set.views.len(), &report.skipped[0].file), (1, &pipe));
}

#[test]
fn an_azimuth_that_is_there_twice_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    write(&folder.path().join("cup__0.png"));
    write(&folder.path().join("cup__0.0.png"));
    assert!(read(folder.path()).unwrap_err().to_string().contains("cup at 0 degrees twice"));
}
