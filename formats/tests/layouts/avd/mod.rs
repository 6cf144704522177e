mod import;

use crate::balls::{Ball, capture};
use crate::{files, truncate};
use nalgebra::{Point3, Translation3, UnitQuaternion, Vector3};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use vantage_dataset::store::{Provenance, StoreError, read_episode, write_episode};
use vantage_dataset::{Camera, Capture, InstanceId, ObjectTruth, Pose, Split};
use vantage_formats::avd::{AvdScan, AvdWriter, GRID, Movement, read_scan};
use vantage_formats::mat5::{self, Value};
use vantage_formats::{ImportError, Problem};

const SCAN: &str = "Home_101_1";

fn camera() -> Camera {
    Camera { width: 192, height: 108, fx: 105.0, fy: 106.0, cx: 95.0, cy: 55.0 }
}

/// Ahead, and five degrees down.
fn robot_from_camera() -> Pose {
    Pose::face_towards(
        &Point3::origin(),
        &Point3::new((PI / 36.0).cos(), 0.0, -(PI / 36.0).sin()),
        &-Vector3::z(),
    )
}

fn balls() -> Vec<Ball> {
    let ball = |x, y, z, radius| Ball { center: Point3::new(x, y, z), radius };
    vec![
        ball(1.6, 0.3, 0.7, 0.15),
        ball(0.2, -1.5, 0.9, 0.2),
        ball(-1.4, 0.0, 0.6, 0.12),
        ball(0.0, 0.0, 9.0, 0.1),
    ]
}

fn truths() -> Vec<ObjectTruth> {
    balls().iter().zip(1..).map(|(ball, number)| ball.truth(number)).collect()
}

/// Four points of a grid, in a square.
fn shot(cluster: u32, heading: u32) -> Capture {
    let position = Vector3::new(f64::from(cluster % 2) * GRID, f64::from(cluster / 2) * GRID, 0.8);
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), f64::from(heading) * PI / 6.0);
    let world_from_robot = Pose::from_parts(Translation3::from(position), turn);
    capture(&balls(), camera(), world_from_robot * robot_from_camera())
}

fn export(root: &Path) -> PathBuf {
    let mut writer = AvdWriter::create(root, SCAN.parse().unwrap(), camera(), &truths()).unwrap();
    for heading in 0..12 {
        for cluster in 0..4 {
            writer.push(cluster, heading, &shot(cluster, heading)).unwrap();
        }
    }
    writer.finish().unwrap();
    root.join(SCAN)
}

fn step(cluster: usize, heading: usize) -> usize {
    cluster * 12 + heading
}

fn problem(folder: &Path) -> Box<Problem> {
    match read_scan(folder) {
        Err(ImportError::Invalid(problem)) => problem,
        other => panic!("{other:?}"),
    }
}

/// Changes the annotations as text.
fn annotate(folder: &Path, change: impl FnOnce(&mut serde_json::Value)) {
    let path = folder.join("annotations.json");
    let mut json = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    change(&mut json);
    std::fs::write(path, serde_json::to_vec(&json).unwrap()).unwrap();
}

/// Changes a field of the struct of one image.
fn restructure(folder: &Path, image: usize, field: &str, value: Value) {
    let path = folder.join("image_structs.mat");
    let mut variables = mat5::read(&path).unwrap();
    let Some(Value::Structs(structs)) = variables.get_mut("image_structs") else { panic!() };
    let field = structs.field(field).unwrap();
    structs.elements[image][field] = value;
    let variables: Vec<(&str, &Value)> =
        variables.iter().map(|(name, value)| (name.as_str(), value)).collect();
    std::fs::write(path, mat5::encode(&variables)).unwrap();
}

fn told(scan: &AvdScan, reason: &str) -> Vec<String> {
    let told = scan.report.skipped.iter().filter(|skipped| skipped.reason.contains(reason));
    told.map(|skipped| skipped.file.file_name().unwrap().to_str().unwrap().to_owned()).collect()
}

#[test]
fn an_export_reads_back_as_the_episode_it_was() {
    let root = tempfile::tempdir().unwrap();
    let folder = export(root.path());
    let scan = read_scan(&folder).unwrap();
    let episode = &scan.episode;
    assert_eq!(episode.observations.steps(), 48);
    assert_eq!(scan.images[0], "010110000010101.jpg");
    assert_eq!(
        scan.report.skipped,
        [],
        "the fourth ball is nowhere seen, and so not among the present names"
    );
    assert_eq!(episode.truth.objects.len(), 3);

    let mut detection = episode.observations.detections.iter();
    for cluster in 0..4 {
        for heading in 0..12 {
            let truth = shot(cluster, heading);
            let robot = episode.truth.world_from_robot[step(cluster as usize, heading as usize)];
            let error = (robot * episode.observations.robot_from_camera).inv_mul(&truth.world_from_camera);
            assert!(error.translation.vector.norm() < 1e-9 && error.rotation.angle() < 1e-7);
            for object in &truth.objects {
                let read = detection.next().unwrap();
                assert_eq!((read.step, read.track), (step(cluster as usize, heading as usize), object.track));
                assert_eq!(read.bounding_box, object.visible_box);
            }
        }
    }
    assert!(detection.next().is_none());
    let up = episode.truth.world_from_robot[0].rotation * Vector3::z();
    assert!((up - Vector3::z()).norm() < 1e-7, "the robot is level though its camera is not: {up}");
    assert_eq!(scan.report.views, episode.observations.detections.len());
    for (read, truth) in episode.truth.objects.iter().zip(truths()) {
        let off =
            (read.world_from_object.translation.vector - truth.world_from_object.translation.vector).norm();
        assert!(off < 1.1 * truth.size / 2.0, "depth is that of the surface: {off} {}", truth.size);
        assert!((read.size / truth.size - 1.0).abs() < 0.15, "{} {}", read.size, truth.size);
        assert_eq!(read.family, format!("ball_{:016x}", truth.instance.0));
        assert_eq!(read.instance, InstanceId::of_name(&read.family));
    }
    for odometry in &episode.observations.odometry {
        let [from, to] = [odometry.from, odometry.to].map(|step| episode.truth.world_from_robot[step]);
        assert_eq!(odometry.robot_from_robot, from.inv_mul(&to));
    }
    let stored = tempfile::tempdir().unwrap();
    write_episode(stored.path(), episode, Provenance::default()).unwrap();
    assert_eq!(read_episode(stored.path()).unwrap().observations.steps(), 48);
}

#[test]
fn movements_lead_where_the_robot_would_go() {
    let root = tempfile::tempdir().unwrap();
    let scan = read_scan(&export(root.path())).unwrap();
    let after = |cluster, heading, movement| scan.movements.after(step(cluster, heading), movement);
    assert_eq!(after(0, 0, Movement::Forward), Some(step(1, 0)));
    assert_eq!(after(0, 1, Movement::Forward), Some(step(1, 1)));
    assert_eq!(after(0, 2, Movement::Forward), Some(step(2, 2)));
    assert_eq!(after(0, 0, Movement::Left), Some(step(2, 0)));
    assert_eq!(after(0, 0, Movement::Right), None);
    assert_eq!(after(0, 0, Movement::Backward), None);
    assert_eq!(after(3, 0, Movement::Backward), Some(step(2, 0)));
    assert_eq!(after(3, 6, Movement::Forward), Some(step(2, 6)));
    assert_eq!(after(1, 11, Movement::RotateCcw), Some(step(1, 0)));
    assert_eq!(after(1, 0, Movement::RotateCw), Some(step(1, 11)));
    assert_eq!(scan.movements.after(1000, Movement::Forward), None);

    let robots = &scan.episode.truth.world_from_robot;
    let mut linked = 0;
    for (before, movement) in (0..48).flat_map(|step| Movement::ALL.map(|movement| (step, movement))) {
        let Some(after) = scan.movements.after(before, movement) else { continue };
        let motion = robots[before].inv_mul(&robots[after]);
        let turned = (motion.rotation.angle().to_degrees() - 30.0).abs() < 1e-6;
        let moved = (motion.translation.vector.norm() - GRID).abs() < 1e-9;
        let turns = matches!(movement, Movement::RotateCcw | Movement::RotateCw);
        assert_eq!((turned, moved), (turns, !turns), "{before} {movement:?}");
        linked += 1;
    }
    assert!(linked > 60, "{linked}");
}

#[test]
fn equal_captures_make_equal_bytes_in_any_order() {
    let (one, two) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    export(one.path());
    let mut writer = AvdWriter::create(two.path(), SCAN.parse().unwrap(), camera(), &truths()).unwrap();
    for cluster in (0..4).rev() {
        for heading in 0..12 {
            writer.push(cluster, heading, &shot(cluster, heading)).unwrap();
        }
    }
    writer.finish().unwrap();
    let (one, two) = (files(one.path()), files(two.path()));
    assert_eq!(one.len(), 2 * 48 + 6);
    assert!(one == two);
}

#[test]
fn scans_share_the_numbers_of_instances() {
    let root = tempfile::tempdir().unwrap();
    export(root.path());
    let mut objects = truths();
    objects.reverse();
    objects.insert(0, balls()[0].truth(99));
    AvdWriter::create(root.path(), "Home_101_2".parse().unwrap(), camera(), &objects).unwrap();
    let map = std::fs::read_to_string(root.path().join("instance_id_map.txt")).unwrap();
    let expected = "background 0\nball_0000000000000001 1\nball_0000000000000002 2\nball_0000000000000003 3\n\
                    ball_0000000000000004 4\nball_0000000000000063 5\n";
    assert_eq!(map, expected);
    let twice = AvdWriter::create(
        root.path(),
        "Gen_001_1".parse().unwrap(),
        camera(),
        &[objects[0].clone(), objects[0].clone()],
    );
    assert!(matches!(twice, Err(StoreError::Unfit { .. })));
}
