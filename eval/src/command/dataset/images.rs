//! `bop` and `bop-webdataset`: whole images with the poses and masks of objects, and their meshes.

use super::{Format, Index, Need, Source, taken_up, tell};
use crate::command::error::BenchError;
use crate::progress::Progress;
use std::collections::BTreeMap;
use std::path::Path;
use vantage_dataset::store::read_regular;
use vantage_dataset::{Capture, InstanceId, ObjectTruth, Seed, Split};
use vantage_formats::{BopLayout, BopOptions, BopWriter, ObjectModel, Scene, Texture};
use vantage_sim::checked::CheckedScene;
use vantage_sim::object::Object;
use vantage_sim::rollout::Rollout;

/// A longer text, bytes, is no licence.
const LARGEST_LICENCE: u64 = 1 << 20;
/// Scenes have numbers of six digits.
const MOST_SCENES: u64 = 1_000_000;

/// A dataset of images.
pub struct Images<'a> {
    progress: &'a Progress,
    /// None where it was finished before.
    writer: Option<BopWriter>,
    split: Split,
    /// Images still to come that are there already.
    skip: u64,
    ids: BTreeMap<InstanceId, u32>,
    licences: BTreeMap<InstanceId, String>,
    /// Number and objects of the episode under way.
    scene: u32,
    objects: Vec<ObjectTruth>,
}

impl<'a> Images<'a> {
    /// Refuses seeds that the layout has no numbers for.
    pub fn check(source: &Source<'_>) -> Result<(), BenchError> {
        source.require_seeds_below(MOST_SCENES, "bop")
    }

    /// Opens the folder, for seeds that were checked.
    pub fn open(root: &Path, layout: BopLayout, source: &Source<'a>) -> Result<Self, BenchError> {
        let camera = source.scene.sensors().camera.intrinsics();
        let options = BopOptions { layout, name: source.name.to_owned(), camera };
        let opened = BopWriter::open(root, options, source.provenance.clone())?;
        let (writer, skip) = taken_up(opened, source.progress);
        let ids = writer.as_ref().map(BopWriter::ids).unwrap_or_default();
        let licences = licences(source.scene);
        let (split, progress) = (source.split, source.progress);
        Ok(Self { progress, writer, split, skip, ids, licences, scene: 0, objects: Vec::new() })
    }
}

impl Format for Images<'_> {
    fn need(&mut self, seed: Seed, index: &Index) -> Result<Need, BenchError> {
        if self.writer.is_none() {
            return Ok(Need::Nothing);
        }
        match index.get(seed) {
            Some(counts) if counts.images <= self.skip => {
                self.skip -= counts.images;
                Ok(Need::Nothing)
            }
            _ => Ok(Need::Captures),
        }
    }

    fn begin(&mut self, rollout: &Rollout) -> Result<(), BenchError> {
        let Some(writer) = &mut self.writer else { return Ok(()) };
        self.scene = rollout.seed.0 as u32;
        self.objects = rollout.world.truth();
        for object in &rollout.world.objects {
            let next = self.ids.len() as u32 + 1;
            let id = *self.ids.entry(object.id).or_insert(next);
            writer.add_model(object.id, id, &model(object, self.licences.get(&object.original)))?;
        }
        Ok(())
    }

    fn image(&mut self, step: usize, capture: &Capture) -> Result<(), BenchError> {
        let Some(writer) = &mut self.writer else { return Ok(()) };
        if self.skip > 0 {
            self.skip -= 1;
            return Ok(());
        }
        let scene = Scene { id: self.scene, split: self.split, objects: &self.objects, ids: &self.ids };
        writer.push(&scene, step as u32, capture)?;
        tell(self.progress, &writer.set_aside());
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), BenchError> {
        let Some(writer) = self.writer else { return Ok(()) };
        let (_, set_aside) = writer.finish()?;
        tell(self.progress, &set_aside);
        Ok(())
    }
}

fn model(object: &Object, licence: Option<&String>) -> ObjectModel {
    let mesh = &object.model.mesh;
    let texels = object.model.texture.level(0);
    let side = texels.len().isqrt() as u32;
    ObjectModel {
        positions: mesh.positions.clone(),
        normals: mesh.normals.clone(),
        uvs: mesh.uvs.clone(),
        triangles: mesh.triangles.clone(),
        texture: Some(Texture {
            width: side,
            height: side,
            rgba: texels.iter().flatten().copied().collect(),
        }),
        symmetry: object.symmetry,
        licence: licence.cloned(),
    }
}

/// Of the licence that lies beside each mesh file the line that begins with `licence:` or `license:`, what follows it, or else
/// the first line.
pub fn licences(scene: &CheckedScene) -> BTreeMap<InstanceId, String> {
    let meshes = scene.meshes().iter();
    let licences = meshes.filter_map(|mesh| {
        let text = read_regular(mesh.licence()?, LARGEST_LICENCE).ok()?;
        let text = String::from_utf8(text).ok()?;
        let lines = || text.lines().map(str::trim).filter(|line| !line.is_empty());
        let named = lines().find_map(|line| {
            let (key, value) = line.split_once(':')?;
            let named = ["licence", "license"].contains(&key.trim().to_lowercase().as_str());
            (named && !value.trim().is_empty()).then_some(value.trim())
        });
        let line = named.or_else(|| lines().next())?;
        Some((mesh.id, line.replace(char::is_control, " ")))
    });
    licences.collect()
}
