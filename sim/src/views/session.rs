//! One arrangement of an object: its neighbours and its light.

use crate::checked::ViewConditions;
use crate::object::Object;
use crate::render::{Placement, RenderScene};
use crate::world::lighting;
use nalgebra::{Translation3, UnitQuaternion, Vector2, Vector3};
use std::f64::consts::PI;
use std::sync::Arc;
use vantage_dataset::{Pose, Seed};

/// Id of the object that is looked at; neighbours follow.
pub const TARGET: u32 = 1;

/// Most neighbours an object has.
const NEIGHBOURS: usize = 3;
/// Neighbours stand up to this much further away than they must, metres.
const LOOSENESS: f64 = 0.15;

/// The object upright at the origin, perhaps with neighbours on the plane it stands on.
pub struct Session {
    /// What is drawn.
    pub scene: RenderScene,
}

impl Session {
    /// Draws session `number` of the object `target`; neighbours are other ones of `objects`.
    pub fn draw(
        conditions: &ViewConditions,
        objects: &[Object],
        target: usize,
        seed: Seed,
        number: u64,
    ) -> Self {
        let light = lighting::draw(&conditions.lighting, &mut seed.stream("session light", number));
        let mut stream = seed.stream("neighbours", number);
        let placed = |object: &Object, world_from_model: Pose, id: u32| Placement {
            model: Arc::clone(&object.model),
            world_from_model,
            id,
        };
        let mut placements = vec![placed(&objects[target], Pose::identity(), TARGET)];
        let mut taken = vec![(Vector2::zeros(), objects[target].footprint())];
        let neighbours = if stream.chance(conditions.views.occluder_probability) && objects.len() > 1 {
            1 + stream.below(NEIGHBOURS)
        } else {
            0
        };
        for _ in 0..neighbours {
            let other = (target + 1 + stream.below(objects.len() - 1)) % objects.len();
            let neighbour = &objects[other];
            let radius = neighbour.footprint();
            let apart = taken[0].1 + radius + conditions.spacing + stream.uniform(0.0, LOOSENESS);
            let azimuth = stream.uniform(-PI, PI);
            let yaw = stream.uniform(-PI, PI);
            let at = Vector2::new(libm::cos(azimuth), libm::sin(azimuth)) * apart;
            let free = taken.iter().all(|(p, r)| (p - at).norm() >= r + radius + conditions.spacing);
            if free {
                let up = neighbour.half_extents[2] - objects[target].half_extents[2];
                let pose = Pose::from_parts(
                    Translation3::new(at.x, at.y, up),
                    UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw),
                );
                placements.push(placed(neighbour, pose, TARGET + taken.len() as u32));
                taken.push((at, radius));
            }
        }
        Self { scene: RenderScene { placements, light, background: [0, 0, 0] } }
    }
}
