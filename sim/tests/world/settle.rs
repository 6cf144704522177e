use crate::scene::{checked, shipped, small};
use nalgebra::{Point3, Vector2, Vector3};
use vantage_dataset::{Pose, Seed, Split};
use vantage_sim::error::SimError;
use vantage_sim::object::Object;
use vantage_sim::physics::Physics;
use vantage_sim::plan::furnishing::Furnishing;
use vantage_sim::plan::stand::{Outline, Stand};
use vantage_sim::scene::Family;
use vantage_sim::scene::SurfaceSpec;
use vantage_sim::world::layout::Place;
use vantage_sim::world::settle::settle;
use vantage_sim::world::{World, check_room};

const TABLE: Stand = Stand {
    center: Vector2::new(0.5, -0.5),
    height: 0.7,
    outline: Outline::Disc { radius: 0.4 },
    headroom: f64::INFINITY,
    solid: true,
};

fn drop_one(object: Object, position: Vector2<f64>, seconds: u32) -> Result<Pose, SimError> {
    let places = [Place { stand: 0, position, yaw: 0.3 }];
    let mut physics = Physics::new(&Furnishing { stands: vec![TABLE], ..Furnishing::default() }, &[]);
    settle(&mut physics, &[TABLE], &[object], &places, seconds, &mut |_| ()).map(|poses| poses[0])
}

fn mug() -> Object {
    Object::generate(Family::Mug, Split::Test, Seed(3), 0)
}

fn lowest_vertex(object: &Object, world_from_object: &Pose) -> f64 {
    let vertices = object.model.mesh.positions.iter();
    vertices
        .map(|p| (world_from_object * Point3::from(Vector3::from(*p).map(f64::from))).z)
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn a_dropped_object_stands_on_the_table() {
    let object = mug();
    let place = TABLE.center + Vector2::new(0.1, 0.05);
    let pose = drop_one(object.clone(), place, 10).unwrap();
    let gap = lowest_vertex(&object, &pose) - TABLE.height;
    assert!(gap.abs() < 0.003, "{gap} m above the table");
    let moved = (pose.translation.vector.xy() - place).norm();
    assert!(moved < 0.01, "moved {moved} m");
    let upright = (pose.rotation * Vector3::z()).z;
    assert!(upright > 0.999, "cosine of the tilt {upright}");
}

#[test]
fn an_object_dropped_beside_the_table_leaves_the_world() {
    let beside = TABLE.center + Vector2::new(0.6, 0.0);
    let got = drop_one(mug(), beside, 10);
    assert!(
        matches!(&got, Err(SimError::LeftTheWorld { object: 0, family, .. }) if family == "mug"),
        "{got:?}"
    );
}

#[test]
fn an_object_that_still_moves_has_not_settled() {
    let got = drop_one(mug(), TABLE.center, 0);
    assert!(
        matches!(&got, Err(SimError::DidNotSettle { object: 0, family, .. }) if family == "mug"),
        "{got:?}"
    );
}

#[test]
fn a_mass_that_is_no_number_is_an_error() {
    let got = drop_one(Object { mass: f64::NAN, ..mug() }, TABLE.center, 10);
    assert!(matches!(&got, Err(SimError::NonFinite { body }) if body == "object 0"), "{got:?}");
}

#[test]
fn a_table_too_small_holds_nothing() {
    let mut spec = small();
    spec.world.surface = SurfaceSpec::RoundTable { radius: 0.09, height: 0.7 };
    let scene = checked(spec);
    let got = World::settled(&scene, Split::Test, Seed(0), &mut |_| ());
    assert!(matches!(got, Err(SimError::NothingFits { wanted: 4, .. })));
    let got = check_room(&scene, Split::Test, Seed(0));
    assert!(matches!(got, Err(SimError::NothingFits { wanted: 4, .. })));
    check_room(&checked(small()), Split::Test, Seed(0)).unwrap();
}

#[test]
fn shipped_scenes_settle_upright_under_twenty_seeds() {
    for name in ["tabletop", "sparse_loop"] {
        let scene = checked(shipped(name));
        let height = scene.world().surface.furnish(scene.robot(), 1).stands[0].height;
        let mut toppled = 0;
        for seed in 0..20 {
            let world = World::settled(&scene, Split::Test, Seed(seed), &mut |_| ()).unwrap();
            for (object, pose) in world.objects.iter().zip(&world.world_from_object) {
                if (pose.rotation * Vector3::z()).z < 0.9 {
                    toppled += 1;
                    continue;
                }
                let gap = lowest_vertex(object, pose) - height;
                assert!(gap.abs() < 0.006, "{name} {seed}: {} stands {gap} m too high", object.family);
            }
        }
        assert!(toppled <= 2, "{name}: {toppled} of 240 objects fell over");
    }
}
