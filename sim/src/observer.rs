//! What a robot observes at each step of a rollout.

use crate::checked::CheckedScene;
use crate::error::SimError;
use crate::render::{Frame, Light, RenderScene, Renderer, Shot};
use crate::rollout::Rollout;
use crate::scene::SensorSpec;
use crate::sensor::close_up::Setting;
use crate::sensor::detector::{Target, detect};
use crate::sensor::{fault, image, landmark};
use nalgebra::Point3;
use vantage_dataset::window::Labelled;
use vantage_dataset::{Detection, DetectionTruth, LandmarkSighting, Seed};

/// The camera, the detector and what they look at, from step to step.
pub struct Observer<'a> {
    rollout: &'a Rollout,
    sensors: &'a SensorSpec,
    scene: RenderScene,
    light_at_start: Light,
    targets: Vec<Target>,
    landmarks: Vec<Point3<f64>>,
    /// Whether each object was detected before.
    seen: Vec<bool>,
    /// How many tracks of nothing there were.
    false_tracks: usize,
}

/// One look.
pub struct Look {
    /// Where from.
    pub shot: Shot,
    /// The image as the camera gives it.
    pub frame: Frame,
    /// Detections by track; those of nothing last, but for misassigned ones.
    pub detections: Vec<(Detection, DetectionTruth)>,
    /// Landmarks, in their order.
    pub landmarks: Vec<LandmarkSighting>,
}

impl<'a> Observer<'a> {
    /// At the beginning of a rollout.
    pub fn new(scene: &'a CheckedScene, rollout: &'a Rollout) -> Self {
        let drawn = rollout.render_scene(scene);
        let sensors = scene.sensors();
        let landmarks = match &sensors.landmarks {
            Some(spec) => landmark::draw(spec, &drawn.placements, rollout.seed),
            None => Vec::new(),
        };
        Self {
            rollout,
            sensors,
            light_at_start: drawn.light,
            seen: vec![false; rollout.world.objects.len()],
            targets: rollout.targets(&drawn),
            scene: drawn,
            landmarks,
            false_tracks: 0,
        }
    }

    /// The point landmarks of the room, world frame, metres.
    pub fn landmarks(&self) -> &[Point3<f64>] {
        &self.landmarks
    }

    /// What can be detected.
    pub fn targets(&self) -> &[Target] {
        &self.targets
    }

    /// Everything that is drawn at a step, and where from.
    pub fn setting(&self, step: usize) -> Setting {
        let scene =
            RenderScene { light: self.rollout.light(step, &self.light_at_start), ..self.scene.clone() };
        Setting { scene, shot: self.rollout.shot(step) }
    }

    /// Looks. Steps are to be looked at in order, since detections of nothing are counted through, and those that are misassigned follow others.
    pub fn look(&mut self, step: usize, renderer: &mut dyn Renderer) -> Result<Look, SimError> {
        let seed: Seed = self.rollout.seed;
        let shot = self.rollout.shot(step);
        self.scene.light = self.rollout.light(step, &self.light_at_start);
        let mut frame = renderer.frame(&self.scene, &shot)?;
        let landmarks = match &self.sensors.landmarks {
            Some(spec) => landmark::sight(spec, &self.landmarks, step, &shot, &frame, seed),
            None => Vec::new(),
        };
        if let Some(spec) = &self.sensors.camera.image {
            image::degrade(spec, &mut frame.rgb, frame.width as usize, 1.0, seed, step as u64);
        }
        let mut detections =
            detect(&self.sensors.detector, &self.targets, step, &shot, &frame, renderer, seed)?;
        if let Some(faults) = &self.sensors.detector.faults {
            let image = Labelled { width: frame.width as usize, rgb: &frame.rgb, ids: &frame.ids };
            let first = self.targets.len() + self.false_tracks;
            let mut nothing = fault::false_detections(faults, &image, step, first, seed);
            let now = |track: &usize| detections.iter().any(|(detection, _)| detection.track == *track);
            let lost = (0..self.seen.len()).filter(|track| self.seen[*track] && !now(track)).collect();
            self.false_tracks += fault::misassign(faults, &mut nothing, lost, first, seed);
            detections.iter().for_each(|(detection, _)| self.seen[detection.track] = true);
            let unseen = DetectionTruth { visible_fraction: 0.0 };
            detections.extend(nothing.into_iter().map(|detection| (detection, unseen)));
            detections.sort_by_key(|(detection, _)| detection.track);
        }
        Ok(Look { shot, frame, detections, landmarks })
    }
}
