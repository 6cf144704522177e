//! Worlds: what stands where, and in which light.

pub mod convert;
pub mod furnishing;
pub mod ground;
pub mod layout;
pub mod lighting;
pub mod physics;
pub mod settle;
pub mod stand;
pub mod surroundings;
pub mod wallpaper;

use crate::error::{Progress, SimError};
use crate::object::{Catalog, Draw, Object};
use crate::scene::{CheckedScene, PathSpec};
use furnishing::Furnishing;
use layout::Footprint;
use physics::Physics;
use rayon::prelude::*;
use vantage_dataset::{ObjectTruth, Pose, Seed, Split};

/// Simulated time that objects get to come to rest, seconds.
const PATIENCE: u32 = 20;

/// A world in which every object has come to rest.
pub struct World {
    /// What the objects stand on, and other furniture.
    pub furnishing: Furnishing,
    /// The objects.
    pub objects: Vec<Object>,
    /// Where each of them came to rest.
    pub world_from_object: Vec<Pose>,
    /// The engine that holds them.
    pub physics: Physics,
}

impl World {
    /// Draws objects and places, drops the objects and lets them settle.
    pub fn settled(
        scene: &CheckedScene,
        split: Split,
        seed: Seed,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<Self, SimError> {
        let spec = scene.world();
        let objects = draw_objects(scene, split, seed)?;
        objects.par_iter().for_each(|object| object.model.simplify());
        let mut furnishing = spec.surface.furnish(scene.robot(), objects.len());
        furnishing.fixtures = scene.fixtures().to_vec();
        let stands = &furnishing.stands;
        let footprints: Vec<Footprint> = objects.iter().map(Footprint::of).collect();
        let mut places = layout::draw(
            stands,
            spec.surface.name(),
            &footprints,
            spec.spacing,
            &mut seed.stream("layout", 0),
        )?;
        if matches!(scene.robot().path, PathSpec::Turntable { .. }) {
            places.iter_mut().for_each(|place| place.position = stands[place.stand].center);
        }
        let mut physics = Physics::new(&furnishing);
        let world_from_object = settle::settle(&mut physics, stands, &objects, &places, PATIENCE, progress)?;
        Ok(Self { furnishing, objects, world_from_object, physics })
    }

    /// What is true of the objects.
    pub fn truth(&self) -> Vec<ObjectTruth> {
        self.objects
            .iter()
            .zip(&self.world_from_object)
            .map(|(object, world_from_object)| ObjectTruth {
                instance: object.id,
                family: object.family.clone(),
                world_from_object: *world_from_object,
                size: object.size,
                symmetry: object.symmetry,
                extents: Some(object.extents()),
            })
            .collect()
    }
}

/// Objects in random order, no two of them the same; or copies of one.
fn draw_objects(scene: &CheckedScene, split: Split, seed: Seed) -> Result<Vec<Object>, SimError> {
    let spec = scene.world();
    let wanted = spec.objects as usize;
    let different = if spec.look_alike.is_some() { 1 } else { wanted };
    let catalog = Catalog::new(&spec.families, scene.meshes(), split);
    let drawn: Vec<Draw<'_>> = catalog.shuffled(different, seed);
    if drawn.len() < different {
        let got = drawn.len();
        return Err(SimError::TooFewMeshes { field: "world.objects", wanted: different, got, split });
    }
    let object_seed = seed.child("objects", 0);
    let objects = drawn.into_par_iter().enumerate();
    let objects: Vec<Object> = objects.map(|(i, draw)| draw.object(split, object_seed, i as u64)).collect();
    let Some(tint) = spec.look_alike else { return Ok(objects) };
    let copies = (0..wanted)
        .flat_map(|i| objects.first().map(|one| one.tinted(tint, &mut seed.stream("look alike", i as u64))));
    Ok(copies.collect())
}
