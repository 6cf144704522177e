//! Whole images in the layouts of the BOP benchmark: a folder a scene, or shards.

mod annotation;
mod image_shard;
mod import;
mod model;
mod scene_folder;

use super::shard::{LayoutManifest, Opened, ShardedFolder, keys_of_tar};
use annotation::{Annotation, camera_file};
use image_shard::ImageShard;
pub use import::{BopArrangement, BopScenes, DetectionLimits, MeshGeometry, ReadModel, Silhouettes};
pub use model::{ObjectModel, Texture};
use scene_folder::SceneFolder;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use vantage_dataset::store::{Fault, Provenance, StoreError};
use vantage_dataset::{Camera, Capture, InstanceId, ObjectTruth, Split};

/// BOP's unit of length, of which a metre has so many.
const MILLIMETRES: f64 = 1000.0;
/// Millimetres of one unit of depth: 16 bits reach 65 m.
const DEPTH_SCALE: f64 = 1.0;
/// The most images that BOP puts in a shard.
const LARGEST_SHARD: u64 = 1000;
/// Numbers of six digits: scenes, images and objects.
const LARGEST_NUMBER: u32 = 999_999;

/// In which files images are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BopLayout {
    /// `<split>/<scene>/` with a file an image and mask.
    Scenes,
    /// `<split>_web/shard-<n>.tar`, BOP's own WebDataset; colours as JPEG.
    WebDataset {
        /// The most images in one shard, 1 to 1000.
        images_per_shard: u64,
    },
}

/// What shapes a dataset of images.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BopOptions {
    /// The files.
    pub layout: BopLayout,
    /// The dataset's name, one line.
    pub name: String,
    /// The camera of `camera.json`; images may have others.
    pub camera: Camera,
}

/// The scene that an image belongs to: one episode.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// Its number in the split.
    pub id: u32,
    /// Its split.
    pub split: Split,
    /// The episode's objects, by track.
    pub objects: &'a [ObjectTruth],
    /// `obj_id` of each instance, at least 1.
    pub ids: &'a BTreeMap<InstanceId, u32>,
}

/// Writes images, in the order in which they come.
///
/// Images of one scene come together, and scenes of one split. Before an image the models of all objects in it have
/// been added.
#[derive(Debug)]
pub struct BopWriter {
    folder: ShardedFolder,
    options: BopOptions,
    shard: Option<Shard>,
    obj_ids: BTreeMap<u32, InstanceId>,
}

/// What is under way: a scene's folder, or an archive of images.
#[derive(Debug)]
struct Shard {
    name: String,
    split: Split,
    images: u64,
    files: Files,
}

#[derive(Debug)]
enum Files {
    Scene(SceneFolder),
    Archive(ImageShard),
}

impl BopWriter {
    /// Opens a folder, which is made if need be. One that holds anything else is refused, as is a dataset that was
    /// begun with other options or provenance.
    pub fn open(
        root: &Path,
        options: BopOptions,
        provenance: Provenance,
    ) -> Result<Opened<Self>, StoreError> {
        let name = match options.layout {
            BopLayout::Scenes => "bop",
            BopLayout::WebDataset { images_per_shard } => {
                let holds = (1..=LARGEST_SHARD).contains(&images_per_shard);
                require(holds, "options.images_per_shard", images_per_shard, "1 to 1000", root)?;
                "bop-webdataset"
            }
        };
        let named = !options.name.is_empty() && !options.name.contains(char::is_control);
        require(named, "options.name", json!(options.name), "a name of one line", root)?;
        let opened = ShardedFolder::open(root, name, json!(options), provenance)?;
        Ok(opened.map(|folder| {
            let mut writer = Self { folder, options, shard: None, obj_ids: BTreeMap::new() };
            writer.obj_ids = writer.ids().into_iter().map(|(instance, id)| (id, instance)).collect();
            writer
        }))
    }

    /// `obj_id` of each instance whose model is there: what an interrupted run had given out.
    pub fn ids(&self) -> BTreeMap<InstanceId, u32> {
        let objects = self.folder.manifest.objects.iter();
        objects
            .filter_map(|(instance, object)| Some((InstanceId::parse(instance)?, object.obj_id?)))
            .collect()
    }

    /// Writes the mesh of an instance, unless it is there.
    ///
    /// # Errors
    /// [`StoreError::Unfit`] where the mesh is none, or the number is taken by another instance or was another, and
    /// [`StoreError::Write`].
    pub fn add_model(
        &mut self,
        instance: InstanceId,
        obj_id: u32,
        model: &ObjectModel,
    ) -> Result<(), StoreError> {
        let stem = format!("models/obj_{obj_id:06}");
        let unfit = |got: String, expected: String| {
            StoreError::unfit(self.folder.root())(Fault::new(&stem, None, "obj_id", got, expected))
        };
        if !(1..=LARGEST_NUMBER).contains(&obj_id) {
            return Err(unfit(obj_id.to_string(), format!("1 to {LARGEST_NUMBER}")));
        }
        if let Some(known) = self.folder.manifest.objects.get(&instance.to_string()).and_then(|o| o.obj_id) {
            return if known == obj_id {
                Ok(())
            } else {
                Err(unfit(obj_id.to_string(), format!("{known}, as before for {instance}")))
            };
        }
        if let Some(holder) = self.obj_ids.get(&obj_id) {
            return Err(unfit(instance.to_string(), format!("{holder}, which has that number")));
        }
        model.check(&stem).map_err(StoreError::unfit(self.folder.root()))?;
        let mut record = super::ObjectRecord {
            obj_id: Some(obj_id),
            licence: model.licence.clone(),
            model: Some(model.info()),
            files: BTreeMap::new(),
        };
        let texture = format!("{stem}.png");
        let encoded = model.texture_png().map_err(StoreError::write(&self.folder.root().join(&texture)))?;
        if let Some(png) = encoded {
            record.files.insert(texture, self.folder.write_file(&format!("{stem}.png"), &png)?);
        }
        let mesh = format!("{stem}.ply");
        let ply = model.ply(&format!("obj_{obj_id:06}.png"));
        record.files.insert(mesh.clone(), self.folder.write_file(&mesh, ply.as_bytes())?);
        self.folder.manifest.objects.insert(instance.to_string(), record);
        self.obj_ids.insert(obj_id, instance);
        Ok(())
    }

    /// Takes the next image, number `image` of its scene.
    ///
    /// # Errors
    /// [`StoreError::Unfit`] where the capture contradicts itself or an object has no model, and [`StoreError::Write`].
    pub fn push(&mut self, scene: &Scene<'_>, image: u32, capture: &Capture) -> Result<(), StoreError> {
        let place = format!("scene {}, image {image}", scene.id);
        let unfit = |fault| StoreError::unfit(self.folder.root())(fault);
        if scene.id.max(image) > LARGEST_NUMBER {
            return Err(unfit(Fault::new(&place, None, "number", scene.id.max(image), "six digits")));
        }
        let annotation = Annotation::new(scene, &place, capture).map_err(unfit)?;
        if let Some(pose) = annotation.poses.iter().find(|pose| !self.obj_ids.contains_key(&pose.obj_id)) {
            let got = format!("obj_id {}", pose.obj_id);
            return Err(unfit(Fault::new(&place, None, "objects", got, "an object whose model was added")));
        }
        if self.shard.as_ref().is_some_and(|shard| !self.goes_on(shard, scene)) {
            self.close_shard()?;
        }
        let mut shard = match self.shard.take() {
            Some(shard) => shard,
            None => self.begin_shard(scene)?,
        };
        let written = match &mut shard.files {
            Files::Scene(folder) => folder.add(image, capture, annotation),
            Files::Archive(archive) => archive.add(scene.id, image, capture, &annotation),
        };
        shard.images += 1;
        self.shard = Some(shard);
        self.folder.written(written)
    }

    /// What was moved to `set_aside/` since this was last asked: folders of scenes that were to be written anew and hold what others
    /// put there.
    pub fn set_aside(&mut self) -> Vec<PathBuf> {
        std::mem::take(&mut self.folder.set_aside)
    }

    /// Writes what is left and marks the dataset as finished; beside the manifest, the last of [`set_aside`](Self::set_aside).
    pub fn finish(mut self) -> Result<(LayoutManifest, Vec<PathBuf>), StoreError> {
        self.close_shard()?;
        let set_aside = self.set_aside();
        let manifest = &self.folder.manifest;
        let mut files = vec![("camera.json".to_owned(), camera_file(&self.options.camera))];
        let models = manifest.objects.values().filter_map(|o| Some((o.obj_id?, o.model.clone()?)));
        let models: BTreeMap<u32, Value> = models.collect();
        files.push(("models/models_info.json".to_owned(), json!(models)));
        if matches!(self.options.layout, BopLayout::WebDataset { .. }) {
            files.extend(self.shards_of_keys()?);
        }
        let files: Vec<_> =
            files.into_iter().map(|(name, value)| (name, value.to_string().into_bytes())).collect();
        Ok((self.folder.finish(&files)?, set_aside))
    }

    /// `key_to_shard.json` of each split: the number of the shard that holds an image.
    fn shards_of_keys(&self) -> Result<Vec<(String, Value)>, StoreError> {
        let mut files = Vec::new();
        for split in [Split::Train, Split::Validation, Split::Test] {
            let mut keys = Map::new();
            let shards = self.folder.manifest.shards.iter().filter(|shard| shard.split == split);
            for (index, shard) in shards.enumerate() {
                let found = keys_of_tar(&self.folder.root().join(&shard.name))?;
                keys.extend(found.into_iter().map(|key| (key, json!(index))));
            }
            if !keys.is_empty() {
                files.push((format!("{}_web/key_to_shard.json", split_name(split)), Value::Object(keys)));
            }
        }
        Ok(files)
    }

    /// Whether an image of `scene` belongs to the shard that is under way.
    fn goes_on(&self, shard: &Shard, scene: &Scene<'_>) -> bool {
        let room = match (&shard.files, self.options.layout) {
            (Files::Scene(folder), _) => folder.scene() == scene.id,
            (_, BopLayout::WebDataset { images_per_shard }) => shard.images < images_per_shard,
            _ => false,
        };
        room && shard.split == scene.split
    }

    fn begin_shard(&mut self, scene: &Scene<'_>) -> Result<Shard, StoreError> {
        let (split, work) = (split_name(scene.split), self.folder.work());
        let (name, files) = match self.options.layout {
            BopLayout::Scenes => {
                (format!("{split}/{:06}", scene.id), SceneFolder::create(&work, scene.id).map(Files::Scene))
            }
            BopLayout::WebDataset { .. } => {
                let index = self.folder.shards_of(scene.split);
                (format!("{split}_web/shard-{index:06}.tar"), ImageShard::create(&work).map(Files::Archive))
            }
        };
        if self.folder.manifest.shards.iter().any(|shard| shard.name == name) {
            let fault =
                Fault::new(&name, None, "scene", "a second of this number", "scenes one after another");
            return Err(StoreError::unfit(self.folder.root())(fault));
        }
        let files = self.folder.written(files)?;
        Ok(Shard { name, split: scene.split, images: 0, files })
    }

    fn close_shard(&mut self) -> Result<(), StoreError> {
        let Some(Shard { name, split, images, files }) = self.shard.take() else { return Ok(()) };
        let closed = match files {
            Files::Scene(folder) => folder.close(&self.options.name),
            Files::Archive(archive) => archive.close(),
        };
        self.folder.written(closed)?;
        self.folder.commit(&name, split, images)
    }
}

/// BOP's name of a split.
fn split_name(split: Split) -> &'static str {
    match split {
        Split::Train => "train",
        Split::Validation => "val",
        Split::Test => "test",
    }
}

fn require(
    holds: bool,
    field: &str,
    got: impl ToString,
    expected: &str,
    root: &Path,
) -> Result<(), StoreError> {
    let fault = || Fault::new("manifest.json", None, field, got, expected);
    if holds { Ok(()) } else { Err(StoreError::unfit(root)(fault())) }
}
