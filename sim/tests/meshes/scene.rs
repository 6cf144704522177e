//! Scenes that name meshes.

use crate::files::{FACES, load_all, obj_faces, obj_vertices, spec, write};
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use rapier3d::prelude::{ColliderBuilder, PhysicsWorld, RigidBodyBuilder, Vector};
use serde::Deserialize;
use std::collections::BTreeSet;
use std::path::Path;
use tempfile::TempDir;
use vantage_dataset::{Pose, Seed, Split, Symmetry};
use vantage_sim::checked::{CheckedScene, Part, SceneError, SceneSpec};
use vantage_sim::error::SimError;
use vantage_sim::object::{Catalog, Draw, Fixture, MeshLibrary};
use vantage_sim::render::reference::ReferenceRenderer;
use vantage_sim::rollout::roll_out;
use vantage_sim::scene::Family;
use vantage_sim::scene::UpAxis;
use vantage_sim::scene::rule::Interval;
use vantage_sim::scene::{
    FixtureSpec, MeshSpec, PathSpec, RobotSpec, SensorSpec, SymmetrySpec, ViewsSpec, WorldSpec,
};
use vantage_sim::views::training_views;
use vantage_sim::world::{World, check_room};

#[derive(Deserialize)]
struct SceneFile {
    world: WorldSpec,
    robot: RobotSpec,
    sensors: SensorSpec,
    views: ViewsSpec,
}

/// The tabletop with meshes in place of families.
pub fn tabletop(meshes: Vec<MeshSpec>, objects: u32) -> SceneSpec {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/tabletop.yaml");
    let SceneFile { mut world, mut robot, sensors, mut views } =
        serde_saphyr::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    world.families.clear();
    world.meshes = meshes;
    world.objects = objects;
    robot.path = PathSpec::Circle { radius: 1.2 };
    views.views_per_instance = 4;
    views.sessions = 2;
    SceneSpec { world, robot, sensors, views }
}

/// Five cubes of different size, by name.
fn cubes() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for i in 0..5 {
        let side = format!("{}", 0.6 + 0.1 * f64::from(i));
        let vertices = obj_vertices().replace("v 1 ", &format!("v {side} "));
        write(folder.path(), &format!("meshes/cube_{i}/textured.obj"), &(vertices + &obj_faces(&FACES)));
    }
    folder
}

fn of_split(split: Split) -> MeshSpec {
    MeshSpec { split: Some(split), category: Some("cube".to_owned()), ..spec("meshes") }
}

#[test]
fn a_world_of_meshes_settles_and_tells_their_categories() {
    let folder = cubes();
    let symmetry = SymmetrySpec::Cyclic(2);
    let scene = tabletop(vec![MeshSpec { symmetry, ..of_split(Split::Test) }], 5);
    let scene = CheckedScene::new(scene, folder.path(), None, &mut |_| ()).unwrap();
    let world = World::settled(&scene, Split::Test, Seed(1), &mut |_| ()).unwrap();
    let truth = world.truth();
    assert!(truth.iter().all(|object| object.family == "cube"));
    assert!(truth.iter().all(|object| object.symmetry == Symmetry::Cyclic { order: 2 }));
    assert_eq!(truth.iter().map(|object| object.instance).collect::<BTreeSet<_>>().len(), 5);
    for (object, pose) in world.objects.iter().zip(&world.world_from_object) {
        let gap = pose.translation.z - object.half_extents.z - world.furnishing.stands[0].height;
        assert!(gap.abs() < 0.003, "{gap} m above the table");
    }
    let order = |seed| {
        let world = World::settled(&scene, Split::Test, Seed(seed), &mut |_| ()).unwrap();
        world.objects.iter().map(|object| object.id).collect::<Vec<_>>()
    };
    assert_eq!(order(1), order(1));
    assert!((2..6).any(|seed| order(seed) != order(1)), "the order is random");
}

#[test]
fn more_objects_than_the_table_holds_of_the_smallest_mesh_are_refused() {
    let folder = cubes();
    let load = |objects| {
        CheckedScene::new(tabletop(vec![of_split(Split::Test)], objects), folder.path(), None, &mut |_| ())
    };
    // Half the diagonal of 6 x 10 cm and 1 cm of spacing, on a table of 65 cm with as much: (66 / 6.83)^2 = 93.4.
    load(93).unwrap();
    let Err(SceneError::Placement(misplaced)) = load(94) else { panic!("94 objects were not refused") };
    assert!(misplaced.iter().map(|one| one.part).eq([Part::Objects]), "{misplaced:?}");
}

#[test]
fn a_split_without_enough_meshes_is_named() {
    let folder = cubes();
    let scene = |objects| {
        CheckedScene::new(tabletop(vec![of_split(Split::Test)], objects), folder.path(), None, &mut |_| ())
            .unwrap()
    };
    let got = World::settled(&scene(6), Split::Test, Seed(1), &mut |_| ()).err().unwrap();
    let message = got.to_string();
    assert!(matches!(got, SimError::TooFewMeshes { wanted: 6, got: 5, split: Split::Test, .. }));
    assert!(message.contains("world.objects") && message.contains("5 meshes in the test split"), "{message}");
    let refused = check_room(&scene(6), Split::Test, Seed(1)).unwrap_err();
    assert_eq!(refused.to_string(), message);
    check_room(&scene(5), Split::Test, Seed(1)).unwrap();
    let conditions = scene(5).view_conditions();
    let mut renderer = ReferenceRenderer::default();
    let got = training_views(&conditions, Split::Train, 1, Seed(1), &mut renderer, &mut |_| ()).unwrap_err();
    assert!(got.to_string().contains("views.train_instances"), "{got}");
    assert!(matches!(got, SimError::TooFewMeshes { wanted: 1, got: 0, split: Split::Train, .. }));
}

#[test]
fn views_are_of_each_mesh_once_and_then_of_families() {
    let folder = cubes();
    let mut scene = tabletop(vec![of_split(Split::Train)], 5);
    let views = |scene: &SceneSpec, instances| {
        let conditions =
            CheckedScene::new(scene.clone(), folder.path(), None, &mut |_| ()).unwrap().view_conditions();
        let mut renderer = ReferenceRenderer::default();
        training_views(&conditions, Split::Train, instances, Seed(1), &mut renderer, &mut |_| ()).unwrap()
    };
    let (all, some) = (views(&scene, 5), views(&scene, 2));
    assert_eq!(all.instances.iter().map(|instance| instance.id).collect::<BTreeSet<_>>().len(), 5);
    assert_eq!(all.instances[..2], some.instances);
    let of_both: Vec<_> = all.views.iter().filter(|view| view.instance < 2).collect();
    assert_eq!(some.views.len(), of_both.len());
    for (a, b) in some.views.iter().zip(of_both) {
        assert_eq!((a.instance, a.viewpoint, &a.crop.0), (b.instance, b.viewpoint, &b.crop.0));
    }
    assert!(all.views.len() > 10, "{} views", all.views.len());
    scene.world.families = vec![Family::Mug];
    let mixed: Vec<String> =
        views(&scene, 12).instances.into_iter().map(|instance| instance.family).collect();
    assert_eq!(mixed[..10], ["mug", "cube"].repeat(5));
    assert_eq!(mixed[10..], ["mug", "mug"]);
}

#[test]
fn one_mesh_alone_has_views_without_neighbours() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "meshes/textured.obj", &(obj_vertices() + &obj_faces(&FACES)));
    let scene = tabletop(vec![of_split(Split::Train)], 1);
    let mut conditions =
        CheckedScene::new(scene, folder.path(), None, &mut |_| ()).unwrap().view_conditions();
    conditions.views.occluder_probability = 1.0;
    let mut renderer = ReferenceRenderer::default();
    let set = training_views(&conditions, Split::Train, 1, Seed(1), &mut renderer, &mut |_| ()).unwrap();
    assert_eq!((set.instances.len(), set.views.len()), (1, 4));
}

#[test]
fn draws_take_turns_and_end_with_the_meshes() {
    let folder = cubes();
    let specs = [of_split(Split::Test)];
    let library = MeshLibrary::load(&specs, folder.path(), None, &mut |_| ()).unwrap();
    let names = |draws: Vec<Draw<'_>>| -> Vec<String> {
        let name = |draw: &Draw<'_>| match draw {
            Draw::Family(family) => family.name().to_owned(),
            Draw::Mesh(mesh) => mesh.name.clone(),
        };
        draws.iter().map(name).collect()
    };
    let families = [Family::Can, Family::Duck];
    let mixed = Catalog::new(&families, &library, Split::Test);
    assert_eq!(names(mixed.in_turn(7)), ["can", "duck", "cube_0", "can", "duck", "cube_1", "can"]);
    let mut shuffled = names(mixed.shuffled(9, Seed(3)));
    assert_ne!(shuffled, names(mixed.in_turn(9)));
    shuffled.sort();
    shuffled.dedup();
    assert_eq!(shuffled.len(), 5, "three different cubes among {shuffled:?}");
    let alone = Catalog::new(&[], &library, Split::Test);
    assert_eq!((alone.in_turn(9).len(), alone.shuffled(9, Seed(3)).len()), (5, 5));
    let none = Catalog::new(&[], &library, Split::Train);
    assert_eq!((none.in_turn(9).len(), none.shuffled(9, Seed(3)).len()), (0, 0));
}

#[test]
fn nothing_that_is_serialized_changes_without_meshes_and_contents_count_with_them() {
    let mut scene = tabletop(Vec::new(), 5);
    scene.world.families = vec![Family::Mug];
    let plain = CheckedScene::new(scene.clone(), Path::new(""), None, &mut |_| ()).unwrap();
    assert_eq!(serde_json::to_string(&plain).unwrap(), serde_json::to_string(&scene).unwrap());
    assert!(!serde_json::to_string(&scene).unwrap().contains("meshes"));
    assert!(!serde_json::to_string(&plain.view_conditions()).unwrap().contains("meshes"));

    let folder = cubes();
    let key = || {
        let scene =
            CheckedScene::new(tabletop(vec![of_split(Split::Test)], 5), folder.path(), None, &mut |_| ())
                .unwrap();
        (serde_json::to_string(&scene).unwrap(), serde_json::to_string(&scene.view_conditions()).unwrap())
    };
    let before = key();
    assert_eq!(before, key());
    let unlike = format!("# not like cube_4\n{}{}", obj_vertices(), obj_faces(&FACES));
    write(folder.path(), "meshes/cube_0/textured.obj", &unlike);
    let after = key();
    assert_ne!(before.0, after.0);
    assert_ne!(before.1, after.1);
    assert!(!before.1.contains("textured.obj"), "{}", before.1);
}

#[test]
fn a_scene_states_units_and_what_it_cannot_mean_is_refused() {
    let read = |text: &str| serde_saphyr::from_str::<Vec<MeshSpec>>(text);
    let entry = "- { path: a.obj, metres_per_unit: 0.01, up: y, category: chair, symmetry: {cyclic: 4}, split: test }";
    let [spec]: [MeshSpec; 1] = read(entry).unwrap().try_into().unwrap();
    assert_eq!((spec.up, spec.symmetry), (UpAxis::Y, SymmetrySpec::Cyclic(4)));
    for (missing, name) in [(" metres_per_unit: 0.01,", "metres_per_unit"), (" up: y,", "up")] {
        let error = read(&entry.replace(missing, "")).unwrap_err().to_string();
        assert!(error.contains(name), "{error}");
    }
    let refusal = |change: fn(&mut MeshSpec)| {
        let mut spec = spec.clone();
        change(&mut spec);
        CheckedScene::new(tabletop(vec![spec], 1), Path::new(""), None, &mut |_| ()).unwrap_err()
    };
    type Change = fn(&mut MeshSpec);
    let rules: [(Change, &str); 4] = [
        (|spec| spec.metres_per_unit = 0.0, "metres_per_unit"),
        (|spec| spec.metres_per_unit = f64::NAN, "metres_per_unit"),
        (|spec| spec.category = Some("two\nlines".to_owned()), "category"),
        (|spec| spec.symmetry = SymmetrySpec::Cyclic(1), "symmetry"),
    ];
    for (change, field) in rules {
        let refused = refusal(change);
        assert!(matches!(refused, SceneError::Rules(_)), "{refused}");
        assert!(refused.to_string().contains(&format!("world.meshes[0].{field}")), "{refused}");
    }
    let gone = refusal(|_| ());
    assert!(matches!(gone, SceneError::Mesh(_)) && gone.to_string().contains("a.obj"), "{gone}");
    let nothing =
        CheckedScene::new(tabletop(Vec::new(), 1), Path::new(""), None, &mut |_| ()).unwrap_err().to_string();
    assert!(nothing.contains("world.families") && nothing.contains("world.meshes"), "{nothing}");
}

#[test]
fn a_mesh_as_furniture_carries_what_falls_on_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(folder.path(), "block.obj", &(obj_vertices() + &obj_faces(&FACES)));
    let spec = |at: [f64; 2]| FixtureSpec {
        path: "block.obj".into(),
        metres_per_unit: 0.5,
        up: UpAxis::Z,
        at,
        yaw_deg: 23.0,
    };
    let block = Fixture::load(&spec([1.0, 2.0]), folder.path()).unwrap();
    assert!((block.half_extents - Vector3::repeat(0.25)).norm() < 1e-9);
    let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 23f64.to_radians());
    let pose = Pose::from_parts(Translation3::new(1.0, 2.0, 0.25), yaw);
    assert!((block.placement().world_from_model.inv_mul(&pose)).translation.vector.norm() < 1e-9);
    let mut world = PhysicsWorld::new();
    world.gravity = Vector::new(0.0, 0.0, -9.81);
    world.insert_collider(block.collider(), None);
    let body = RigidBodyBuilder::dynamic().translation(Vector::new(1.0, 2.0, 0.6));
    let ball = world.insert(body, ColliderBuilder::cuboid(0.05, 0.05, 0.05)).0;
    (0..240).for_each(|_| world.step());
    let height = world.bodies[ball].position().translation.z;
    assert!((height - 0.55).abs() < 0.005, "{height}");
    assert!(load_all(&path).is_ok());

    let furnished = |at: [f64; 2]| {
        let mut scene = tabletop(Vec::new(), 2);
        scene.world.families = vec![Family::Can];
        scene.world.fixtures = vec![spec(at)];
        CheckedScene::new(scene, folder.path(), None, &mut |_| ())
    };
    let scene = furnished([2.6, 2.0]).unwrap();
    let rollout = roll_out(&scene, Seed(0), Split::Test, &mut |_| ()).unwrap();
    assert_eq!(rollout.world.fixtures, scene.fixtures());
    let drawn = rollout.render_scene(&scene).placements;
    assert!(drawn.iter().any(|placement| placement.world_from_model == scene.fixtures()[0].world_from_model));
    let blocked = furnished([1.6, 0.0]).unwrap_err().to_string();
    assert!(blocked.contains("world.fixtures[0]: the path passes at"), "{blocked}");
}

#[test]
fn fixtures_stand_within_the_room_and_not_in_one_another() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "block.obj", &(obj_vertices() + &obj_faces(&FACES)));
    // Cubes, of 0.5 m unless they are stretched, in a room of 6.5 x 5.5 m round a table of radius 0.65 m.
    let fixture = |at: [f64; 2], yaw_deg: f64, metres_per_unit: f64| FixtureSpec {
        path: "block.obj".into(),
        metres_per_unit,
        up: UpAxis::Z,
        at,
        yaw_deg,
    };
    let refused = |fixtures: &[FixtureSpec]| -> Vec<Part> {
        let mut scene = tabletop(Vec::new(), 2);
        scene.world.families = vec![Family::Can];
        scene.robot.path = PathSpec::RandomWalk { legs: 3, leg_length: Interval([0.5, 1.0]), clearance: 0.1 };
        scene.robot.laps = 1.0;
        scene.world.fixtures = fixtures.to_vec();
        match CheckedScene::new(scene, folder.path(), None, &mut |_| ()) {
            Ok(_) => Vec::new(),
            Err(SceneError::Placement(misplaced)) => misplaced.iter().map(|one| one.part).collect(),
            Err(other) => panic!("{other}"),
        }
    };
    assert_eq!(refused(&[fixture([3.0, 0.0], 0.0, 0.5)]), [], "in touch with a wall");
    assert_eq!(refused(&[fixture([3.01, 0.0], 0.0, 0.5)]), [Part::Fixture(0)]);
    assert_eq!(refused(&[fixture([2.95, 0.0], 45.0, 0.5)]), [Part::Fixture(0)], "a corner in the wall");
    let both = [Part::Fixture(0), Part::Fixture(0)];
    assert_eq!(refused(&[fixture([1.9, 0.0], 0.0, 2.7)]), both, "higher than the room, and in the table");
    assert_eq!(refused(&[fixture([2.0, 2.0], 0.0, 0.5), fixture([2.0, 1.5], 0.0, 0.5)]), [], "side by side");
    let pair = [fixture([2.0, 2.0], 0.0, 0.5), fixture([2.0, 1.6], 0.0, 0.5)];
    assert_eq!(refused(&pair), [Part::Fixture(1)]);
    let corners = [fixture([2.0, 2.0], 45.0, 0.5), fixture([2.52, 1.48], 45.0, 0.5)];
    assert_eq!(refused(&corners), [], "boxes around them overlap, they do not");
    assert_eq!(refused(&[fixture([0.8, 0.0], 0.0, 0.5)]), [Part::Fixture(0)], "in the table");
    assert_eq!(refused(&[fixture([0.72, 0.72], 0.0, 0.5)]), [], "beside a round table");
    assert_eq!(refused(&[fixture([0.0, 0.0], 0.0, 0.02)]), [], "lower than a carpet");
}
