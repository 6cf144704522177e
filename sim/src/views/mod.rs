//! Training views: pictures of single objects from known viewpoints, `z` with its `x_rel` (Eq. 10).
//!
//! A view is made the way a detection is: the object stands among others, the camera is anywhere a robot might
//! hold it, the box is that of the visible mask, and the same filter cuts the crop. The tile has the camera's own
//! pixel size unless the object is larger than the tile. As only the masked crop is kept, nothing but objects is
//! drawn. Unlike detections, views are never cut off by the image's border.

mod camera;
mod session;
mod tour;

use crate::budget;
use crate::checked::ViewConditions;
use crate::error::{Progress, SimError, Stage};
use crate::mesh_file::MeshFileError;
use crate::object::{Catalog, Draw, Object};
use crate::render::{Renderer, Shot, Tile, TileShot};
use crate::scene::ViewsSpec;
use crate::sensor::{bounds, fault, image};
use nalgebra::Vector2;
use rayon::prelude::*;
use session::{Session, TARGET};
use vantage_dataset::views::{InstanceRecord, box_center_error};
use vantage_dataset::window::{Labelled, MARGIN, Window, cut};
use vantage_dataset::{BoundingBox, Camera, Mask, Seed, Sighting, Split, View, ViewSet, Viewpoint};

/// Side of a tile, pixels.
const TILE_SIDE: u32 = 64;
/// Tiles a renderer gets in one call.
const BATCH: usize = 256;
/// Instances made together, which are also each other's neighbours.
const CHUNK: usize = 32;
/// How often a view is drawn anew while too little of the object is visible.
const ATTEMPTS: u64 = 8;

/// Makes the views of the first `instances` instances of a split.
///
/// The views of an instance do not depend on how many instances are asked for, nor on the number of threads. An
/// instance has fewer views than asked for where too little of it was visible in every attempt.
pub fn training_views(
    conditions: &ViewConditions,
    split: Split,
    instances: usize,
    seed: Seed,
    renderer: &mut dyn Renderer,
    progress: &mut dyn FnMut(Progress),
) -> Result<ViewSet, SimError> {
    budget::check_views(conditions, instances)?;
    let chunks = instances.div_ceil(CHUNK);
    let draws = Catalog::new(&conditions.families, &conditions.meshes, split)
        .in_turn_beside_composites(chunks * CHUNK, |index| conditions.views.is_composite(split, index));
    if draws.len() < instances {
        let (field, got) = (ViewsSpec::field(split), draws.len());
        return Err(SimError::TooFewMeshes { field, wanted: instances, got, split });
    }
    let seed = seed.child(split.name(), 0);
    let mut set = ViewSet { split, instances: Vec::with_capacity(instances), views: Vec::new() };
    for (start, draws) in (0..instances).step_by(CHUNK).zip(draws.chunks(CHUNK)) {
        budget::check_meshes(draws)?;
        let chunk = Chunk::new(conditions, split, draws, start, seed)?;
        let wanted = CHUNK.min(instances - start);
        set.instances.extend(chunk.objects[..wanted].iter().map(|object| InstanceRecord {
            id: object.id,
            family: object.family.clone(),
            symmetry: object.symmetry,
        }));
        set.views.extend(chunk.views(wanted, renderer)?);
        progress(Progress { stage: Stage::Views, done: (start + wanted) as u64, total: instances as u64 });
    }
    Ok(set)
}

/// The instances `start..start + CHUNK` of a split, fewer at the end of its meshes.
struct Chunk<'a> {
    conditions: &'a ViewConditions,
    camera: Camera,
    start: usize,
    seed: Seed,
    objects: Vec<Object>,
}

/// A view still to be made.
#[derive(Clone, Copy)]
struct Slot {
    /// Index within the chunk.
    instance: usize,
    session: usize,
    /// Index among the views of the instance.
    view: usize,
}

/// What is drawn of a slot.
struct Sitting {
    shot: Shot,
    /// Centre and side of the tile, pixels of the shot.
    center: [f64; 2],
    side: f64,
}

impl<'a> Chunk<'a> {
    fn new(
        conditions: &'a ViewConditions,
        split: Split,
        draws: &[Draw<'_>],
        start: usize,
        seed: Seed,
    ) -> Result<Self, SimError> {
        let objects: Result<Vec<Object>, MeshFileError> = draws
            .par_iter()
            .enumerate()
            .map(|(i, draw)| draw.object(split, seed, (start + i) as u64))
            .collect();
        Ok(Self { conditions, camera: conditions.camera.intrinsics(), start, seed, objects: objects? })
    }

    /// The views of the first `wanted` instances, ordered by instance, then number of the view.
    fn views(&self, wanted: usize, renderer: &mut dyn Renderer) -> Result<Vec<View>, SimError> {
        let spec = &self.conditions.views;
        let (sessions, views) = (spec.sessions as usize, spec.views_per_instance as usize);
        let stages: Vec<Session> = (0..wanted * sessions)
            .into_par_iter()
            .map(|i| self.session(i / sessions, i % sessions))
            .collect();
        let mut open: Vec<Slot> = (0..wanted * views)
            .map(|i| Slot { instance: i / views, session: i % views % sessions, view: i % views })
            .collect();
        let mut made: Vec<Option<View>> = vec![None; open.len()];

        for attempt in 0..ATTEMPTS {
            let mut failed = Vec::new();
            for batch in open.chunks(BATCH) {
                let sittings: Vec<Sitting> =
                    batch.par_iter().map(|slot| self.sitting(*slot, attempt)).collect();
                let shots: Vec<TileShot<'_>> = batch
                    .iter()
                    .zip(&sittings)
                    .map(|(slot, sitting)| TileShot {
                        scene: &stages[slot.instance * sessions + slot.session].scene,
                        shot: sitting.shot,
                        center: sitting.center,
                        side: sitting.side,
                        target: TARGET,
                    })
                    .collect();
                let tiles = renderer.tiles(&shots, TILE_SIDE)?;
                let done: Vec<Option<View>> = batch
                    .par_iter()
                    .zip(&sittings)
                    .zip(tiles)
                    .map(|((slot, sitting), tile)| self.view(*slot, sitting, tile))
                    .collect();
                for (slot, view) in batch.iter().zip(done) {
                    match view {
                        Some(view) => made[slot.instance * views + slot.view] = Some(view),
                        None => failed.push(*slot),
                    }
                }
            }
            open = failed;
        }
        if let Some(odometry) = &spec.odometry {
            for (instance, own) in made.chunks_mut(views).enumerate() {
                for session in 0..sessions {
                    let number = ((self.start + instance) * sessions + session) as u64;
                    let seen = own.iter_mut().flatten().filter(|view| view.session == session);
                    let mut stops: Vec<_> =
                        seen.filter_map(|view| Some((&view.viewpoint, view.sighting.as_mut()?))).collect();
                    tour::dead_reckon(odometry, &mut stops, self.seed.child("tour", number));
                }
            }
        }
        Ok(made.into_iter().flatten().collect())
    }

    fn session(&self, instance: usize, session: usize) -> Session {
        let number = (self.start + instance) * self.conditions.views.sessions as usize + session;
        Session::draw(self.conditions, &self.objects, instance, self.seed, number as u64)
    }

    /// A view's number among all of the split.
    fn number(&self, slot: Slot) -> u64 {
        let views = u64::from(self.conditions.views.views_per_instance);
        (self.start + slot.instance) as u64 * views + slot.view as u64
    }

    fn sitting(&self, slot: Slot, attempt: u64) -> Sitting {
        let mut stream = self.seed.stream("viewpoint", self.number(slot) * ATTEMPTS + attempt);
        let object = &self.objects[slot.instance];
        let world_from_camera = camera::draw(&self.conditions.views, &self.camera, object.size, &mut stream);
        let bounds = bounds::projected(&self.camera, &world_from_camera.inverse(), &object.half_extents);
        Sitting {
            shot: Shot { camera: self.camera, world_from_camera },
            center: bounds.center().into(),
            side: (MARGIN * bounds.side() + 2.0).max(f64::from(TILE_SIDE)),
        }
    }

    /// The view, or `None` where a detector would not report it.
    fn view(&self, slot: Slot, sitting: &Sitting, mut tile: Tile) -> Option<View> {
        let object = &self.objects[slot.instance];
        let detector = &self.conditions.detector;
        let mask = Mask::of(&tile.ids, TILE_SIDE as usize, TARGET)?;
        let scale = sitting.side / f64::from(tile.side);
        let visible_fraction = f64::from(mask.pixels) / f64::from(tile.amodal_pixels);
        let pixels_in_frame = f64::from(mask.pixels) * scale * scale;
        let viewpoint = Viewpoint::new(&sitting.shot.world_from_camera, object.size)?;
        if visible_fraction < detector.min_visible_fraction
            || pixels_in_frame < f64::from(detector.min_mask_pixels)
        {
            return None;
        }
        let number = self.number(slot);
        if let Some(spec) = &self.conditions.camera.image {
            image::degrade(spec, &mut tile.rgb, TILE_SIDE as usize, scale, self.seed, number);
        }
        let seen = match &detector.faults {
            Some(faults) => fault::jittered(faults, &mask.bounding_box, number, self.seed),
            None => mask.bounding_box,
        };
        let ray = self.box_ray(sitting, &seen);
        let sighting = self.conditions.views.odometry.as_ref().map(|_| Sighting {
            step: slot.view,
            session_from_camera: sitting.shot.world_from_camera,
            ray: ray.into(),
            angular_size: seen.side() * sitting.side / f64::from(TILE_SIDE) / self.camera.focal_length(),
        });
        let image = Labelled { width: TILE_SIDE as usize, rgb: &tile.rgb, ids: &tile.ids };
        Some(View {
            instance: self.start + slot.instance,
            session: slot.session,
            viewpoint,
            crop: cut(&image, &Window::around(&seen), Some(TARGET)),
            visible_fraction,
            box_center_error: box_center_error(&ray, &sitting.shot.world_from_camera, object.size),
            sighting,
        })
    }

    /// The centre of a box of the tile as a ray `(x / z, y / z)`, camera frame.
    fn box_ray(&self, sitting: &Sitting, visible: &BoundingBox) -> Vector2<f64> {
        let scale = sitting.side / f64::from(TILE_SIDE);
        let corner = Vector2::new(sitting.center[0], sitting.center[1]).add_scalar(-sitting.side / 2.0);
        self.camera.ray_in_camera(&(corner + visible.center() * scale)).xy()
    }
}
