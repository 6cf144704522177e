//! Worlds: what stands where, and in which light.

pub mod layout;
pub mod lighting;
pub mod settle;
pub mod surroundings;
pub mod wallpaper;

use crate::budget;
use crate::checked::CheckedScene;
use crate::error::{Progress, SimError};
use crate::object::{Catalog, Draw, Fixture, Object};
use crate::physics::Physics;
use crate::plan::furnishing::Furnishing;
use crate::plan::ground::Ground;
use crate::scene::{PathSpec, RoomSpec};
use layout::{Footprint, Place};
use rayon::prelude::*;
use vantage_dataset::{ObjectTruth, Pose, Seed, Split};

/// Simulated time that objects get to come to rest, seconds.
const PATIENCE: u32 = 20;

/// Whether the objects of a seed find room: what else costs a renderer's time to find out.
///
/// # Errors
/// [`SimError::TooFewMeshes`] and [`SimError::NothingFits`], and what [`budget`] refuses.
pub fn check_room(scene: &CheckedScene, split: Split, seed: Seed) -> Result<(), SimError> {
    budget::check_episode(scene)?;
    put_down(scene, split, seed).map(drop)
}

/// A world in which every object has come to rest.
pub struct World {
    /// What the objects stand on, and what stands beside it.
    pub furnishing: Furnishing,
    /// Furniture from files.
    pub fixtures: Vec<Fixture>,
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
        let (objects, furnishing, mut places) = put_down(scene, split, seed)?;
        objects.par_iter().for_each(|object| object.model.simplify());
        let fixtures = scene.fixtures().to_vec();
        let stands = &furnishing.stands;
        if matches!(scene.robot().path, PathSpec::Turntable { .. }) {
            places.iter_mut().for_each(|place| place.position = stands[place.stand].center);
        }
        let mut physics = Physics::new(&furnishing, &fixtures);
        let world_from_object = settle::settle(&mut physics, stands, &objects, &places, PATIENCE, progress)?;
        Ok(Self { furnishing, fixtures, objects, world_from_object, physics })
    }

    /// The plan of the room, furniture from files included.
    pub fn ground(&self, room: &RoomSpec) -> Ground {
        let mut obstacles = self.furnishing.obstacles();
        obstacles.extend(self.fixtures.iter().map(Fixture::obstacle));
        Ground::new(room, obstacles)
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

/// Objects, what they stand on, and where on it each is put down.
fn put_down(
    scene: &CheckedScene,
    split: Split,
    seed: Seed,
) -> Result<(Vec<Object>, Furnishing, Vec<Place>), SimError> {
    let spec = scene.world();
    let objects = draw_objects(scene, split, seed)?;
    let furnishing = spec.surface.furnish(scene.robot(), objects.len());
    let footprints: Vec<Footprint> = objects.iter().map(Footprint::of).collect();
    let mut stream = seed.stream("layout", 0);
    let places =
        layout::draw(&furnishing.stands, spec.surface.name(), &footprints, spec.spacing, &mut stream)?;
    Ok((objects, furnishing, places))
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
    budget::check_meshes(&drawn)?;
    let object_seed = seed.child("objects", 0);
    let objects = drawn.into_par_iter().enumerate();
    let objects: Vec<Object> =
        objects.map(|(i, draw)| draw.object(split, object_seed, i as u64)).collect::<Result<_, _>>()?;
    let Some(tint) = spec.look_alike else { return Ok(objects) };
    let copies = (0..wanted)
        .flat_map(|i| objects.first().map(|one| one.tinted(tint, &mut seed.stream("look alike", i as u64))));
    Ok(copies.collect())
}
