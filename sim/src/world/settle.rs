//! Objects are dropped and come to rest.

use crate::error::{Progress, SimError, Stage};
use crate::object::Object;
use crate::physics::{Body, Physics, RATE};
use crate::plan::stand::Stand;
use crate::world::layout::Place;
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use vantage_dataset::Pose;

/// Height from which objects are dropped, metres.
const DROP: f64 = 0.005;

/// Drops every object upright at its place and returns where they come to rest, `world_from_object`, for which they
/// get so many simulated seconds.
pub fn settle(
    physics: &mut Physics,
    stands: &[Stand],
    objects: &[Object],
    places: &[Place],
    seconds: u32,
    progress: &mut dyn FnMut(Progress),
) -> Result<Vec<Pose>, SimError> {
    let mut bodies = Vec::with_capacity(objects.len());
    for (i, (object, place)) in objects.iter().zip(places).enumerate() {
        let height = stands[place.stand].height + object.half_extents[2] + DROP;
        let pose = Pose::from_parts(
            Translation3::new(place.position.x, place.position.y, height),
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), place.yaw),
        );
        let body = physics
            .add_object(object, &pose, i as u32 + 1)
            .ok_or_else(|| SimError::NonFinite { body: format!("object {i}") })?;
        bodies.push(body);
    }
    let total = seconds * RATE;
    for step in 0..total {
        if bodies.iter().all(|body| physics.at_rest(*body)) {
            break;
        }
        physics.step()?;
        refuse_fallen(physics, stands, objects, places, &bodies)?;
        if step % RATE == 0 {
            progress(Progress { stage: Stage::Settle, done: step.into(), total: total.into() });
        }
    }
    if let Some(object) = bodies.iter().position(|body| !physics.at_rest(*body)) {
        let family = objects[object].family.clone();
        return Err(SimError::DidNotSettle { object, family, seconds: seconds.into() });
    }
    Ok(bodies.iter().map(|body| physics.pose(*body)).collect())
}

/// An object stays on its stand if its centre is above it.
fn refuse_fallen(
    physics: &Physics,
    stands: &[Stand],
    objects: &[Object],
    places: &[Place],
    bodies: &[Body],
) -> Result<(), SimError> {
    for (object, (body, place)) in bodies.iter().zip(places).enumerate() {
        let position = physics.pose(*body).translation.vector;
        let stand = &stands[place.stand];
        if position.z < stand.height || !stand.spans(&position.xy()) {
            let family = objects[object].family.clone();
            return Err(SimError::LeftTheWorld { object, family, position: position.into() });
        }
    }
    Ok(())
}
