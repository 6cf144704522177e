use crate::scene::{checked, shipped, small};
use garde::Validate;
use std::path::Path;
use vantage_dataset::{Seed, Split};
use vantage_sim::checked::{CheckedScene, Misplaced, SceneError, SceneSpec};
use vantage_sim::error::SimError;
use vantage_sim::render::reference::ReferenceRenderer;
use vantage_sim::rollout::roll_out;
use vantage_sim::scene::{
    Direction, HandheldSpec, InsideAndOutsideSpec, PathSpec, PieceSpec, RandomLoopSpec, RevisitSpec,
    SurfaceSpec, WorldSpec,
};
use vantage_sim::views::training_views;

const SHARING: [&str; 7] = ["sparse_loop", "shelves", "room", "corridor", "aliased", "revisit", "ring"];

/// Every violation, one a line.
fn refusal(spec: SceneSpec) -> String {
    CheckedScene::new(spec, Path::new(""), None, &mut |_| ())
        .expect_err("the scene breaks a rule")
        .to_string()
}

#[test]
fn shipped_scenes_pass_and_share_their_views() {
    let tabletop = checked(shipped("tabletop")).view_conditions();
    for name in SHARING {
        assert_eq!(checked(shipped(name)).view_conditions(), tabletop, "{name}");
    }
    let predictive = checked(shipped("sparse_loop_predictive"));
    assert_eq!(checked(shipped("apartment")).view_conditions(), predictive.view_conditions());
    checked(shipped("turntable"));
}

#[test]
fn two_passes_and_the_way_between_fit_each_other_and_the_room() {
    let with = |change: &dyn Fn(&mut RevisitSpec)| {
        let mut spec = shipped("revisit");
        let mut path = RevisitSpec { distance: 2.2, pass: 3.0, angle_deg: 90.0, detour: 30.0 };
        change(&mut path);
        spec.robot.path = PathSpec::Revisit(path);
        refusal(spec)
    };
    assert!(with(&|path| path.detour = 15.0).contains("too short to come round"));
    assert!(with(&|path| path.detour = 60.0).contains("needs a room of"));
    assert!(with(&|path| path.pass = 9.0).contains("expected 1.1 to 8.8"));
    assert!(with(&|path| path.pass = f64::NAN).contains("pass"));
    assert!(with(&|path| path.angle_deg = 270.0).contains("angle_deg"));
    let close = |path: &mut RevisitSpec| *path = RevisitSpec { distance: 0.5, pass: 1.0, ..*path };
    let mut wide = shipped("revisit");
    let PathSpec::Revisit(path) = &mut wide.robot.path else { panic!("a revisit") };
    close(path);
    wide.world.surface = SurfaceSpec::RoundTable { radius: 0.4, height: 0.85 };
    assert!(refusal(wide).contains("bump into world.surface"));
    let mut pedestals = shipped("revisit");
    pedestals.world.surface = shipped("corridor").world.surface;
    assert!(refusal(pedestals).contains("the same for every seed; choose another path"));
}

#[test]
fn paths_and_their_parameters_are_checked_together() {
    let with = |change: &dyn Fn(&mut SceneSpec)| {
        let mut spec = shipped("room");
        change(&mut spec);
        refusal(spec)
    };
    let open = |spec: &mut SceneSpec| {
        let points = vec![[-2.0, -1.6], [2.0, -1.6]];
        spec.robot.path = PathSpec::Waypoints { points, closed: false, corner_radius: 0.5 };
    };
    assert!(with(&|spec| open(spec)).contains("at most 1: the path does not end where it begins"));
    assert!(with(&|spec| spec.robot.steps = None).contains("number of images along the path"));
    let through_the_table = |spec: &mut SceneSpec| {
        let points = vec![[-2.0, 0.0], [2.0, 0.0]];
        spec.robot.laps = 1.0;
        spec.robot.path = PathSpec::Waypoints { points, closed: false, corner_radius: 0.5 };
    };
    assert!(with(&through_the_table).contains("bump into"));
    let waypoints = |points: &[[f64; 2]], closed: bool| {
        let points = points.to_vec();
        move |spec: &mut SceneSpec| {
            spec.robot.laps = 1.0;
            spec.robot.path = PathSpec::Waypoints { points: points.clone(), closed, corner_radius: 0.5 };
        }
    };
    assert!(with(&waypoints(&[], false)).contains("robot.path"));
    assert!(with(&waypoints(&[[0.0, 0.0]], true)).contains("robot.path"));
    let square = [[-2.2, -1.6], [2.2, -1.6], [2.2, 1.2], [-2.2, -1.6]];
    assert!(with(&waypoints(&square, true)).contains("leave one out"));
    let back = [[-2.2, -1.6], [2.2, -1.6], [-2.2, -1.55]];
    assert!(with(&waypoints(&back, false)).contains("turns by 179 degrees"));
    let lanes = |spec: &mut SceneSpec| {
        spec.robot.laps = 1.0;
        spec.robot.path = PathSpec::Lawnmower { length: 4.0, width: 3.0, lanes: 0 };
    };
    assert!(with(&lanes).contains("lanes"));
    assert!(with(&|spec| spec.robot.path = PathSpec::Circle { radius: 1e9 }).contains("radius"));
    let grid = PathSpec::Grid { spacing: 0.3, headings: 12, clearance: 0.1 };
    assert!(with(&|spec| spec.robot.path = grid.clone()).contains("leave `steps` out"));
    let pedestals = |spec: &mut SceneSpec| {
        spec.robot.path = grid.clone();
        spec.robot.steps = None;
        spec.world.surface = shipped("corridor").world.surface;
    };
    assert!(with(&pedestals).contains("choose another path"));
    let swaying = |spec: &mut SceneSpec| {
        *spec = shipped("apartment");
        spec.robot.handheld = Some(HandheldSpec { sway: 0.05, tilt_deg: 1.0, period: 2.0 });
    };
    assert!(with(&swaying).contains("leave `handheld` out"));
    let relit = |spec: &mut SceneSpec| {
        *spec = shipped("apartment");
        spec.world.relit_at = Some(0.5);
    };
    assert!(with(&relit).contains("nothing drives from station to station"));
    let below = |spec: &mut SceneSpec| {
        *spec = shipped("turntable");
        spec.robot.camera.height = 0.5;
    };
    assert!(with(&below).contains("below the table's top"));
    let two = |spec: &mut SceneSpec| {
        *spec = shipped("turntable");
        spec.world.objects = 2;
    };
    assert!(with(&two).contains("world.objects must be 1"));
}

#[test]
fn loops_and_rings_fit_the_room_and_what_stands_in_it() {
    let looping = |change: &dyn Fn(&mut RandomLoopSpec)| {
        let mut spec = shipped("tabletop");
        let direction = Direction::CounterClockwise;
        let mut path = RandomLoopSpec { radius: 1.6, amplitude: 0.2, direction, clearance: 0.1 };
        change(&mut path);
        spec.robot.path = PathSpec::RandomLoop(path);
        refusal(spec)
    };
    assert!(looping(&|path| path.radius = 2.2).contains("lower path.random_loop.radius or its amplitude"));
    assert!(looping(&|path| path.radius = 1.0).contains("raise path.random_loop.radius"));
    assert!(looping(&|path| path.amplitude = 0.6).contains("amplitude"));
    assert!(looping(&|path| path.clearance = f64::NAN).contains("clearance"));
    let mut pedestals = shipped("sparse_loop");
    let path = RandomLoopSpec { radius: 3.0, amplitude: 0.2, direction: Direction::Either, clearance: 0.1 };
    pedestals.robot.path = PathSpec::RandomLoop(path);
    assert!(refusal(pedestals).contains("the same for every seed; choose another path"));

    let ring = |change: &dyn Fn(&mut SceneSpec, &mut InsideAndOutsideSpec)| {
        let mut spec = shipped("ring");
        let mut path = InsideAndOutsideSpec { inner_radius: 1.6, outer_radius: 4.8, clearance: 0.2 };
        change(&mut spec, &mut path);
        spec.robot.path = PathSpec::InsideAndOutside(path);
        refusal(spec)
    };
    assert!(ring(&|_, path| path.inner_radius = 4.0).contains("expected at least 5.20: 1.2 m more"));
    assert!(ring(&|_, path| path.outer_radius = 7.4).contains("needs a room of at least 15.60"));
    assert!(ring(&|_, path| path.inner_radius = 2.7).contains("bump into world.surface"));
    assert!(ring(&|spec, _| spec.robot.laps = 2.0).contains("expected at most 1"));
    assert!(ring(&|spec, _| spec.world.objects = 19).contains("wide enough to cross"));
    assert!(ring(&|spec, _| spec.robot.reverse_after = Some(0.5)).contains("leave `reverse_after` out"));
}

#[test]
fn a_robot_is_carried_on_the_floor_before_it_arrives() {
    let with = |change: &dyn Fn(&mut SceneSpec)| {
        let mut spec = shipped("aliased");
        (spec.robot.laps, spec.robot.carried_after) = (2.0, Some(1.0));
        checked(spec.clone());
        change(&mut spec);
        refusal(spec)
    };
    assert!(with(&|spec| spec.robot.laps = 1.0).contains("expected less than robot.laps, 1"));
    assert!(with(&|spec| spec.robot.carried_after = Some(f64::NAN)).contains("carried_after"));
    assert!(with(&|spec| spec.robot.reverse_after = Some(0.5)).contains("leave `reverse_after` out"));
}

#[test]
fn a_robot_turns_round_within_its_laps_and_the_room() {
    let with = |change: &dyn Fn(&mut SceneSpec)| {
        let mut spec = shipped("sparse_loop");
        (spec.robot.laps, spec.robot.reverse_after) = (2.0, Some(1.0));
        checked(spec.clone());
        change(&mut spec);
        refusal(spec)
    };
    assert!(with(&|spec| spec.robot.laps = 1.0).contains("expected less than robot.laps, 1"));
    assert!(with(&|spec| spec.robot.reverse_after = Some(f64::NAN)).contains("reverse_after"));
    assert!(with(&|spec| spec.robot.reverse_after = Some(0.0)).contains("reverse_after"));
    // There is room for the lap, which is 6 m wide, but not for the turn beside it.
    let narrow = |spec: &mut SceneSpec| spec.world.room.width = 6.9;
    assert!(with(&narrow).contains("needs a room of"));
    let mut onwards = shipped("sparse_loop");
    narrow(&mut onwards);
    checked(onwards);
}

#[test]
fn furniture_stands_within_the_room_and_not_in_one_another() {
    let with = |piece: PieceSpec| -> Vec<String> {
        let mut spec = shipped("room");
        let SurfaceSpec::Furniture(pieces) = &mut spec.world.surface else { return Vec::new() };
        pieces.push(piece);
        match CheckedScene::new(spec, Path::new(""), None, &mut |_| ()) {
            Ok(_) => Vec::new(),
            Err(SceneError::Placement(misplaced)) => misplaced.iter().map(Misplaced::to_string).collect(),
            Err(other) => panic!("{other}"),
        }
    };
    let block = |at, size| PieceSpec::Block { at, size };
    let refused = |piece: PieceSpec, words: &str| {
        let said = with(piece.clone());
        assert!(said.len() == 1 && said[0].starts_with("world.surface.furniture[6]"), "{piece:?}: {said:?}");
        assert!(said[0].contains(words), "{said:?}");
    };
    refused(block([3.9, 1.0], [1.0, 1.0, 1.0]), "reaches beyond world.room");
    refused(block([3.5, 1.0], [1.0, 1.0, 2.7]), "reaches beyond world.room");
    refused(block([0.5, 0.3], [0.3, 0.3, 0.8]), "stands in world.surface.furniture[0]");
    refused(block([-3.6, 0.0], [0.3, 0.3, 0.5]), "stands in world.surface.furniture[3]");
    // The dining table is 1.4 m by 0.8 m and 0.74 m high, its top 3 cm thick, its legs 6 cm by 6 cm.
    refused(block([0.65, 0.0], [0.2, 0.75, 0.5]), "stands in world.surface.furniture[0]");
    for fits in [
        block([0.0, 0.0], [1.2, 0.6, 0.7]),
        block([0.8, 0.0], [0.2, 0.4, 0.74]),
        block([3.5, 1.0], [1.0, 1.0, 2.6]),
        PieceSpec::Table { at: [-3.1, -2.4], size: [0.8, 0.4, 0.4] },
    ] {
        assert_eq!(with(fits.clone()), Vec::<String>::new(), "{fits:?}");
    }
}

#[test]
fn pedestals_stand_within_the_room() {
    let mut spec = shipped("corridor");
    let SurfaceSpec::Pedestals { offset, .. } = &mut spec.world.surface else { panic!("no pedestals") };
    *offset = 1.8;
    let said = refusal(spec);
    assert!(said.starts_with("world.surface: from") && said.contains("reaches beyond world.room"), "{said}");
}

#[test]
fn more_objects_than_any_layout_holds_are_refused() {
    let with = |name: &str, objects: u32, spacing: f64| {
        let mut spec = shipped(name);
        (spec.world.objects, spec.world.spacing) = (objects, spacing);
        CheckedScene::new(spec, Path::new(""), None, &mut |_| ())
            .map(|_| ())
            .map_err(|error| error.to_string())
    };
    // Discs of 3 cm about the middles of the smallest, and a table of 65 cm with a margin of 1 cm: (66 / 3)^2 = 484.
    with("tabletop", 484, 0.02).unwrap();
    let said = with("tabletop", 485, 0.02).unwrap_err();
    assert!(said.starts_with("world.objects: 485 objects do not fit on the round table"), "{said}");
    assert!(
        said.contains("more than 484 even of the smallest") && said.contains("use fewer objects"),
        "{said}"
    );
    with("tabletop", 485, 0.01).unwrap();
    assert!(with("room", 5000, 0.02).unwrap_err().contains("on the furniture"));
    with("corridor", 80, 0.02).unwrap();
}

#[test]
fn numbers_that_are_none_are_refused() {
    let mut spec = small();
    spec.world.spacing = f64::NAN;
    spec.robot.speed = f64::INFINITY;
    spec.robot.camera.height = -f64::NAN;
    spec.world.lighting.ambient.0[1] = f64::NAN;
    let said = refusal(spec);
    for field in ["world.spacing", "robot.speed", "robot.camera.height", "world.lighting.ambient"] {
        assert!(said.contains(field), "{field} is missing in:\n{said}");
    }
}

#[test]
fn parts_that_do_not_fit_together_are_refused() {
    let mut bumping = small();
    bumping.world.surface = SurfaceSpec::RectangularTable { length: 2.5, width: 0.4, height: 0.7 };
    assert!(refusal(bumping).contains("bump into"));
    let mut outside = small();
    outside.robot.path = PathSpec::Circle { radius: 4.0 };
    assert!(refusal(outside).contains("room"));
    let mut corners = small();
    corners.robot.path = PathSpec::RoundedRectangle { length: 4.0, width: 3.0, corner_radius: 1.6 };
    assert!(refusal(corners).contains("half the shorter"));
}

#[test]
fn zero_objects_and_families_listed_twice_are_refused() {
    let mut spec = small();
    spec.world.objects = 0;
    spec.world.families.push(spec.world.families[0]);
    let said = refusal(spec);
    assert!(said.contains("world.objects") && said.contains("more than once"), "{said}");
}

#[test]
fn unknown_and_duplicate_keys_are_refused_by_name_and_line() {
    let room = "{ length: 6, width: 5, height: 2.6 }";
    let world = |extra: &str| {
        format!(
            "surface:\n  round_table: {{ radius: 0.6, height: 0.7 }}\nfamilies: [mug]\nobjects: 3\nspacing: 0.1\n\
             room: {room}\nlighting: {{ ambient: [0.1, 0.2], directional: [1, 1], elevation_deg: [20, 30], tint: 0 }}\n\
             {extra}"
        )
    };
    serde_saphyr::from_str::<WorldSpec>(&world("")).unwrap().validate().unwrap();
    for extra in ["objecs: 4\n", "objects: 4\n", &format!("room: {room}\n")] {
        let said = serde_saphyr::from_str::<WorldSpec>(&world(extra)).expect_err(extra).to_string();
        assert!(said.contains("line 8"), "{said}");
    }
}

#[test]
fn every_violation_is_reported_with_its_line() {
    let text = "length: 0.1\nwidth: .nan\nheight: 99\n";
    let said =
        serde_saphyr::from_str_valid::<vantage_sim::scene::RoomSpec>(text).expect_err(text).to_string();
    for line in ["line 1", "line 2", "line 3"] {
        assert!(said.contains(line), "{line} is missing in:\n{said}");
    }
}

#[test]
fn a_scene_far_too_large_is_refused_before_it_starts() {
    let mut crowded = small();
    crowded.world.objects = 2_000_000;
    crowded.world.surface = shipped("corridor").world.surface;
    let got = roll_out(&checked(crowded), Seed(0), Split::Test, &mut |_| ()).err().unwrap();
    assert!(matches!(got, SimError::TooLarge { bytes: 100_000_000_000.., .. }), "{got}");

    let mut slow = small();
    slow.robot.laps = 100.0;
    slow.robot.speed = 0.01;
    let got = roll_out(&checked(slow), Seed(0), Split::Test, &mut |_| ()).err().unwrap();
    assert!(matches!(got, SimError::TooLong { .. }), "{got}");

    let conditions = checked(small()).view_conditions();
    let mut renderer = ReferenceRenderer::default();
    let got = training_views(&conditions, Split::Train, 10_000_000, Seed(0), &mut renderer, &mut |_| ());
    assert!(matches!(got, Err(SimError::TooLarge { .. })));
}
