//! Scenes in BOP's layout.

use super::like::Like;
use super::{Imported, all_are_there, split};
use crate::command::cli::ImportArgs;
use crate::command::error::BenchError;
use crate::progress::Progress;
use std::sync::Arc;
use vantage_dataset::{Camera, Episode, ObjectTruth, Pose, Seed, episodes_views};
use vantage_formats::{BopScenes, DetectionLimits, ImportReport, MeshGeometry, Silhouettes};
use vantage_sim::mesh::Mesh;
use vantage_sim::model::Model;
use vantage_sim::render::reference::ReferenceRenderer;
use vantage_sim::render::{Light, Placement, RenderScene, Renderer, Shot};
use vantage_sim::texture::Texture;

/// Those of BOP's own detection scores, without a scene to be like.
const LIMITS: DetectionLimits = DetectionLimits { min_visible_fraction: 0.1, min_mask_pixels: 1 };

/// Reads the arrangements of all scenes.
pub(super) fn bop(
    args: &ImportArgs,
    like: Option<&Like>,
    progress: &Progress,
) -> Result<(Imported, ImportReport), BenchError> {
    let mut report = ImportReport::default();
    let mut bop = BopScenes::open(&args.source, &mut report)?;
    bop.lone_object_stands = args.views;
    let limits = like.map_or(LIMITS, Like::limits);
    let mut drawing = Drawing { renderer: ReferenceRenderer::new(), models: Vec::new() };
    let stage = progress.stage("scenes", bop.scenes.len() as u64);
    let mut episodes: Vec<(String, Episode)> = Vec::new();
    for scene in &bop.scenes {
        let read = bop.read(scene, &limits, &mut drawing, &mut report)?;
        episodes.extend(read.into_iter().map(|arrangement| (arrangement.name, arrangement.episode)));
        stage.advance(1);
    }
    let driven = match like {
        Some(like) => like.drawn(&episodes, args.draws),
        None => episodes
            .into_iter()
            .zip(0..)
            .map(|((name, episode), seed)| (name, Episode { seed: Seed(seed), ..episode }))
            .collect(),
    };
    report.views = driven.iter().map(|(_, episode)| episode.observations.detections.len()).sum();
    if !args.views {
        return Ok((Imported::Episodes(driven), report));
    }
    let named =
        |name: &str| driven.iter().any(|(_, episode)| episode.truth.objects.iter().any(|o| o.family == name));
    all_are_there(args, named)?;
    let takes = |object: &ObjectTruth| args.objects.is_empty() || args.objects.contains(&object.family);
    let set = episodes_views(driven.iter().map(|(_, episode)| episode), split(args), &takes);
    report.views = set.views.len();
    Ok((Imported::Views(set), report))
}

/// Draws with the renderer that gives the same bits on any processor.
struct Drawing {
    renderer: ReferenceRenderer,
    /// Of the meshes drawn so far, by where they lie.
    models: Vec<(*const MeshGeometry, Arc<Model>)>,
}

impl Drawing {
    fn model(&mut self, mesh: &MeshGeometry) -> Arc<Model> {
        let place = std::ptr::from_ref(mesh);
        if let Some((_, model)) = self.models.iter().find(|(known, _)| *known == place) {
            return model.clone();
        }
        let vertices = mesh.positions.len();
        let plain = Mesh {
            positions: mesh.positions.clone(),
            normals: vec![[0.0, 0.0, 1.0]; vertices],
            uvs: vec![[0.0, 0.0]; vertices],
            triangles: mesh.triangles.clone(),
        };
        let model = Arc::new(Model::new(plain, Texture::plain([255; 3])));
        self.models.push((place, model.clone()));
        model
    }
}

impl Silhouettes for Drawing {
    fn ids(&mut self, camera: &Camera, meshes: &[(&MeshGeometry, Pose)]) -> Result<Vec<u32>, String> {
        let placements = meshes
            .iter()
            .zip(1..)
            .map(|((mesh, pose), id)| Placement { model: self.model(mesh), world_from_model: *pose, id })
            .collect();
        let light = Light { direction: nalgebra::Vector3::z(), ambient: [1.0; 3], diffuse: [0.0; 3] };
        let scene = RenderScene { placements, light, background: [0; 3] };
        let shot = Shot { camera: *camera, world_from_camera: Pose::identity() };
        let frame = self.renderer.frame(&scene, &shot).map_err(|error| error.to_string())?;
        Ok(frame.ids)
    }
}
