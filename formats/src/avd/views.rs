//! A scan's detections as views.

use super::import::AvdScan;
use crate::import::ImportReport;
use vantage_dataset::{ObjectTruth, Split, View, ViewSet, episode_views};

impl AvdScan {
    /// The views of the objects that `takes` says, by [`episode_views()`], and what was left out: those without a viewpoint, too.
    pub fn views(&self, split: Split, takes: &dyn Fn(&ObjectTruth) -> bool) -> (ViewSet, ImportReport) {
        let set = episode_views(&self.episode, split, takes);
        let mut report = ImportReport { views: set.views.len(), ..self.report.clone() };
        let objects = self.episode.truth.objects.iter().enumerate();
        for (track, object) in objects.filter(|(_, object)| takes(object)) {
            let detections = self.episode.observations.detections.iter();
            let seen = detections.filter(|detection| detection.track == track).count();
            let is_of = |view: &&View| set.instances[view.instance].id == object.instance;
            let without = seen - set.views.iter().filter(is_of).count();
            if without > 0 {
                let why = "from the object's axis, or with the object behind the camera";
                let told = format!("{}: {without} of {seen} views have no viewpoint: {why}", object.family);
                report.skip(&self.folder, told);
            }
        }
        (set, report)
    }
}
