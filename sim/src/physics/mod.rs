//! The physics engine, z up, in fixed steps.

mod shape;

use crate::convert::{pose_from_physics, pose_to_physics, vector_to_physics};
use crate::error::SimError;
use crate::object::{Fixture, Object};
use crate::plan::body;
use crate::plan::furnishing::Furnishing;
use nalgebra::{Translation3, Unit, UnitQuaternion, Vector2, Vector3};
use rapier3d::prelude::{
    CoefficientCombineRule, ColliderBuilder, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle, Vector,
};
use shape::standing_cylinder;
use vantage_dataset::Pose;

/// Physics steps a second.
pub const RATE: u32 = 120;

const GRAVITY: f32 = 9.81;
/// Slows objects that rock or roll, as felt and friction do, so that they come to rest.
const ANGULAR_DAMPING: f32 = 1.0;
const FRICTION: f32 = 0.8;
/// Points up to this far above an object's lowest belong to its underside, metres.
const UNDERSIDE: f32 = 0.002;

/// The engine with a floor at z = 0.
pub struct Physics {
    world: PhysicsWorld,
}

/// A body in the engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Body(RigidBodyHandle);

impl Physics {
    /// A furnished world.
    pub fn new(furnishing: &Furnishing, fixtures: &[Fixture]) -> Self {
        let mut world = PhysicsWorld::new();
        world.gravity = Vector::new(0.0, 0.0, -GRAVITY);
        world.integration_parameters.dt = 1.0 / RATE as f32;
        world.insert_collider(
            ColliderBuilder::halfspace(Unit::new_unchecked(Vector::Z)).friction(FRICTION),
            None,
        );
        for stand in furnishing.stands.iter().filter(|stand| stand.solid) {
            let [x, y] = stand.outline.half_extents();
            let half_height = stand.height / 2.0;
            let center = stand.center.push(half_height);
            // Square even where the stand is round: the engine would touch a cylinder's cap or a polygon's face in
            // four corners only, and let objects near its rim sink in.
            let collider = ColliderBuilder::cuboid(x as f32, y as f32, half_height as f32)
                .translation(vector_to_physics(&center))
                .friction(FRICTION);
            world.insert_collider(collider, None);
        }
        for block in furnishing.pieces.iter().flatten() {
            let (position, shape) = block.shape(0.0);
            let collider = ColliderBuilder::new(shape).position(position).friction(FRICTION);
            world.insert_collider(collider, None);
        }
        for fixture in fixtures {
            world.insert_collider(fixture.collider().friction(FRICTION), None);
        }
        Self { world }
    }

    /// Adds an object as the convex hull of its points, or `None` where they have no volume.
    pub fn add_object(&mut self, object: &Object, world_from_object: &Pose, label: u32) -> Option<Body> {
        let collider = ColliderBuilder::convex_hull(&on_four_feet(&object.hull))?
            .mass(object.mass as f32)
            .friction(FRICTION);
        let body = RigidBodyBuilder::dynamic()
            .pose(pose_to_physics(world_from_object))
            .angular_damping(ANGULAR_DAMPING)
            .user_data(u128::from(label));
        Some(Body(self.world.insert(body, collider).0))
    }

    /// Adds the robot's body: it slides on the floor without friction and cannot tip over.
    pub fn add_robot(&mut self, position: &Vector2<f64>, heading: f64) -> Body {
        let half_height = body::HEIGHT / 2.0;
        let upright = Pose::from_parts(Translation3::identity(), standing_cylinder());
        let collider = ColliderBuilder::cylinder(half_height as f32, body::RADIUS as f32)
            .position(pose_to_physics(&upright))
            .mass(body::MASS as f32)
            .friction(0.0)
            .friction_combine_rule(CoefficientCombineRule::Min);
        let robot = RigidBodyBuilder::dynamic()
            .pose(pose_to_physics(&standing(position, heading)))
            .enabled_rotations(false, false, true)
            .can_sleep(false);
        Body(self.world.insert(robot, collider).0)
    }

    /// Puts a robot elsewhere, at rest.
    pub fn set_down(&mut self, body: Body, position: &Vector2<f64>, heading: f64) {
        let robot = &mut self.world.bodies[body.0];
        robot.set_position(pose_to_physics(&standing(position, heading)), true);
        robot.set_linvel(Default::default(), true);
        robot.set_angvel(Default::default(), true);
    }

    /// Advances the world by one step of `1 / RATE` seconds.
    pub fn step(&mut self) -> Result<(), SimError> {
        self.world.step();
        let quarantine = self.world.quarantine();
        if quarantine.is_empty() {
            return Ok(());
        }
        let body = match quarantine.bodies().first() {
            Some(handle) => match self.world.bodies[*handle].user_data {
                0 => "the robot".to_owned(),
                label => format!("object {}", label - 1),
            },
            None => "a collider".to_owned(),
        };
        Err(SimError::NonFinite { body })
    }

    /// Where a body is.
    pub fn pose(&self, body: Body) -> Pose {
        pose_from_physics(self.world.bodies[body.0].position())
    }

    /// Whether a body has come to rest.
    pub fn at_rest(&self, body: Body) -> bool {
        self.world.bodies[body.0].is_sleeping()
    }

    /// Sets a body's horizontal velocity, metres a second, and yaw rate, radians a second; it falls as it does.
    pub fn push(&mut self, body: Body, velocity: &Vector2<f64>, yaw_rate: f64) {
        let body = &mut self.world.bodies[body.0];
        let mut linear = vector_to_physics(&Vector3::new(velocity.x, velocity.y, 0.0));
        linear.z = body.linvel().z;
        body.set_linvel(linear, true);
        body.set_angvel(vector_to_physics(&Vector3::new(0.0, 0.0, yaw_rate)), true);
    }
}

/// The pose of a robot's body on the floor.
fn standing(position: &Vector2<f64>, heading: f64) -> Pose {
    Pose::from_parts(
        Translation3::new(position.x, position.y, body::HEIGHT / 2.0),
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), heading),
    )
}

/// The points of a hull, of its underside only the four that span it most widely: the engine touches with four
/// corners of a face at most, and of a round underside would take four neighbours, on which nothing stands.
fn on_four_feet(hull: &[[f32; 3]]) -> Vec<Vector> {
    let lowest = hull.iter().map(|p| p[2]).fold(f32::INFINITY, f32::min);
    let (under, over): (Vec<_>, Vec<_>) =
        hull.iter().map(|&[x, y, z]| Vector::new(x, y, z)).partition(|p| p.z <= lowest + UNDERSIDE);
    let diagonals = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
    let feet = diagonals.into_iter().filter_map(|(along_x, along_y)| {
        let reach = |p: &Vector| along_x * p.x + along_y * p.y;
        under.iter().copied().max_by(|a, b| reach(a).total_cmp(&reach(b)))
    });
    over.into_iter().chain(feet).collect()
}
