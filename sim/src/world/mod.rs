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
use crate::object::{Family, Object};
use crate::scene::CheckedScene;
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
        let families = draw_families(&spec.families, spec.objects as usize, seed);
        let object_seed = seed.child("objects", 0);
        let objects: Vec<Object> = match spec.look_alike {
            None => families
                .par_iter()
                .enumerate()
                .map(|(i, family)| Object::generate(*family, split, object_seed, i as u64))
                .collect(),
            Some(tint) => {
                let one = Object::generate(families[0], split, object_seed, 0);
                (0..families.len())
                    .map(|i| one.tinted(tint, &mut seed.stream("look alike", i as u64)))
                    .collect()
            }
        };
        let furnishing = spec.surface.furnish(scene.robot(), objects.len());
        let stands = &furnishing.stands;
        let footprints: Vec<Footprint> = objects.iter().map(Footprint::of).collect();
        let places = layout::draw(
            stands,
            spec.surface.name(),
            &footprints,
            spec.spacing,
            &mut seed.stream("layout", 0),
        )?;
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
                family: object.family.name().to_owned(),
                world_from_object: *world_from_object,
                size: object.size,
                symmetry: object.symmetry,
                extents: Some(object.extents()),
            })
            .collect()
    }
}

/// Families in random order, each as often as any other, to within one.
fn draw_families(families: &[Family], objects: usize, seed: Seed) -> Vec<Family> {
    let mut stream = seed.stream("families", 0);
    let first = stream.below(families.len());
    let mut drawn: Vec<Family> = (0..objects).map(|i| families[(first + i) % families.len()]).collect();
    stream.shuffle(&mut drawn);
    drawn
}
