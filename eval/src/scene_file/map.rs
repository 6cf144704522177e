//! The map file: one scene in many cells, the estimators that are compared in each, and what is expected of them.

use super::hypothesis::Hypothesis;
use super::panel::{Estimates, Panel, Summary};
use super::seeds::Seeds;
use super::vary::{Axis, Fields, told};
use super::{SceneFile, is_file_name};
use crate::result::metric::Metric;
use garde::Validate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::PathBuf;

/// Version of the map format.
pub const VERSION: u32 = 1;

/// A whole map: every panel at every value of one field.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, Validate)]
#[serde(deny_unknown_fields)]
pub struct MapFile {
    /// Version of the map format: 1.
    #[garde(range(min = VERSION, max = VERSION))]
    pub version: u32,
    /// Name of the map and of its folder of results.
    #[garde(custom(is_file_name))]
    pub name: String,
    /// What the map is to show, in a sentence.
    #[garde(length(min = 1, max = 1000))]
    pub purpose: String,
    /// The scene, relative to the map.
    #[garde(skip)]
    pub scene: PathBuf,
    /// The seeds of every cell; without them, those of the scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(skip)]
    pub seeds: Option<Seeds>,
    /// The field along each panel.
    #[garde(dive)]
    pub across: Axis,
    /// What runs in each cell.
    #[garde(length(min = 1, max = 10), dive)]
    pub estimates: Vec<Estimates>,
    /// The panels.
    #[garde(length(min = 1, max = 100), dive, custom(panels_differ))]
    pub panels: Vec<Panel>,
    /// What a figure of few panels shows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[garde(dive, custom(of_its_panels(&self.panels)))]
    pub summary: Option<Summary>,
    /// What is expected, written down before the map is made.
    #[serde(default)]
    #[garde(length(max = 100), dive, custom(of_the_map(&self.panels, &self.across)))]
    pub hypotheses: Vec<Hypothesis>,
}

/// The scores of each cell.
const COLUMNS: [Metric; 5] =
    [Metric::Ate, Metric::AteUmeyama, Metric::Heading, Metric::NeesPose, Metric::PositionInside95];
/// Likewise, of drives of lives.
const COLUMNS_OF_DRIVES: [Metric; 8] = [
    Metric::Ate,
    Metric::AteUmeyama,
    Metric::Heading,
    Metric::NeesPose,
    Metric::PositionInside95,
    Metric::Azimuth,
    Metric::PrequentialGain,
    Metric::Ari,
];

impl MapFile {
    /// The map of a scene that varies one or two of its own fields; `None` where it varies none.
    ///
    /// The first field is that along the panels, the second that which tells panels apart.
    pub fn of_scene(scene: &SceneFile) -> Option<Self> {
        let across = scene.vary.first()?.clone();
        let panels = match scene.vary.get(1) {
            None => vec![Panel {
                name: scene.name.clone(),
                title: scene.name.clone(),
                set: Fields::new(),
                life: Vec::new(),
                alone: false,
                estimates: None,
            }],
            Some(down) => {
                let panel = |(i, value): (usize, &Value)| Panel {
                    name: format!("panel_{i}"),
                    title: format!("{} {}", down.label(), told(value)),
                    set: down.at(value),
                    life: Vec::new(),
                    alone: false,
                    estimates: None,
                };
                down.over.iter().enumerate().map(panel).collect()
            }
        };
        let rows = scene.estimator.rows.clone();
        Some(Self {
            version: VERSION,
            name: scene.name.clone(),
            purpose: scene.purpose.clone(),
            scene: PathBuf::new(),
            seeds: None,
            across,
            estimates: vec![Estimates { rows, model: None, association: None, set: Fields::new() }],
            panels,
            summary: None,
            hypotheses: Vec::new(),
        })
    }

    /// Hash of the map as read, on a scene of this hash: see [`super::hash`]. Where the scene's file lies does not enter it.
    pub fn hash(&self, scene_hash: &str) -> Result<String, serde_json::Error> {
        let anywhere = Self { scene: PathBuf::new(), ..self.clone() };
        super::hash(&(&anywhere, scene_hash))
    }

    /// The scores of its cells.
    pub fn columns(&self) -> &'static [Metric] {
        if self.across.is_of_drives() { &COLUMNS_OF_DRIVES } else { &COLUMNS }
    }

    /// What runs in a panel's cells.
    pub fn estimates_of<'a>(&'a self, panel: &'a Panel) -> &'a [Estimates] {
        panel.estimates.as_deref().unwrap_or(&self.estimates)
    }

    /// The name of the table of a cell.
    pub fn cell_name(&self, panel: &Panel, value: &Value) -> String {
        format!("{}, {} {}", panel.name, self.across.label(), told(value))
    }
}

fn panels_differ(panels: &[Panel], _: &()) -> garde::Result {
    let mut names = BTreeSet::new();
    match panels.iter().find(|panel| !names.insert(&panel.name)) {
        Some(twice) => Err(garde::Error::new(format!("{:?} is there twice", twice.name))),
        None => Ok(()),
    }
}

fn of_its_panels(panels: &[Panel]) -> impl FnOnce(&Option<Summary>, &()) -> garde::Result {
    move |summary, ()| {
        let unknown = |name: &&String| panels.iter().all(|panel| panel.name != **name);
        match summary.iter().flat_map(|summary| &summary.panels).find(unknown) {
            Some(name) => Err(garde::Error::new(format!("{name:?} is the name of no panel"))),
            None => Ok(()),
        }
    }
}

fn of_the_map(panels: &[Panel], across: &Axis) -> impl FnOnce(&Vec<Hypothesis>, &()) -> garde::Result {
    move |hypotheses, ()| {
        for Hypothesis { panel, than_in, at, .. } in hypotheses {
            let unknown = |name: &&String| panels.iter().all(|panel| panel.name != **name);
            if let Some(name) = [Some(panel), than_in.as_ref()].into_iter().flatten().find(unknown) {
                return Err(garde::Error::new(format!("{name:?} is the name of no panel")));
            }
            if let Some(value) = at.iter().find(|value| !across.over.contains(value)) {
                let (value, field) = (told(value), &across.field);
                return Err(garde::Error::new(format!(
                    "{value} is none of the values of {field} in `across`"
                )));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::parse;
    use super::*;
    use std::path::Path;

    const GOOD: &str = "\
version: 1
name: mine
purpose: To show it.
scene: s.yaml
across: { field: robot.laps, over: [1, 1.5] }
estimates:
  - { rows: [odometry, geometric] }
  - { rows: [viewpoint_dependent], model: m, set: { estimator.semantic_noise_scale: 2 } }
panels:
  - { name: a, title: As it is }
  - { name: b, title: Brighter, set: { world.lighting.tint: 0.1 }, estimates: [{ rows: [geometric] }] }
summary: { panels: [b], rows: [geometric] }
hypotheses:
  - { says: It helps., panel: a, at: [1.5], row: viewpoint_dependent, than: geometric, expects: less }
  - { says: It does not matter., panel: a, at: [1], row: geometric, than: geometric, than_in: b, expects: { within: 0.01 } }
";

    fn read(text: &str) -> Result<MapFile, String> {
        parse(text, Path::new("m.yaml")).map_err(|error| error.to_string())
    }

    #[test]
    fn a_map_is_read_and_its_hash_is_of_the_scene_and_not_of_its_place() {
        let map = read(GOOD).unwrap();
        assert_eq!(map.estimates_of(&map.panels[0]).len(), 2);
        assert_eq!(map.estimates_of(&map.panels[1]).len(), 1);
        assert_eq!(map.cell_name(&map.panels[1], &map.across.over[1]), "b, laps 1.5");
        let elsewhere = read(&GOOD.replace("s.yaml", "x/s.yaml")).unwrap();
        assert_eq!(map.hash("abc").unwrap(), elsewhere.hash("abc").unwrap());
        assert_ne!(map.hash("abc").unwrap(), map.hash("abd").unwrap());
    }

    #[test]
    fn what_does_not_fit_together_is_refused() {
        for (from, to, said) in [
            ("name: b", "name: a", "twice"),
            ("panel: a, at: [1.5]", "panel: c, at: [1.5]", "no panel"),
            ("than_in: b", "than_in: c", "no panel"),
            ("panels: [b]", "panels: [c]", "no panel"),
            ("at: [1.5]", "at: [3]", "none of the values"),
            ("estimator.semantic_noise_scale", "world.objects", "fields of estimator"),
            ("within: 0.01", "within: -1", "lower than 0"),
            ("rows: [odometry, geometric]", "rows: [odometer]", "odometer"),
            ("estimates: [{ rows: [geometric] }]", "estimates: []", "at least one"),
        ] {
            let error = read(&GOOD.replacen(from, to, 1)).unwrap_err();
            assert!(error.contains(said) && error.contains("m.yaml:"), "{said} not in: {error}");
        }
    }

    #[test]
    fn a_scene_that_varies_two_fields_is_a_map_of_panels() {
        let text = include_str!("../../../scenes/tabletop.yaml");
        let vary =
            "vary:\n  - { field: robot.laps, over: [1, 2] }\n  - { field: world.objects, over: [3, 6, 9] }\n";
        let scene: SceneFile = parse(&format!("{text}{vary}"), Path::new("s.yaml")).unwrap();
        let map = MapFile::of_scene(&scene).unwrap();
        assert_eq!((map.across.over.len(), map.panels.len()), (2, 3));
        assert_eq!(map.panels[2].title, "objects 9");
        let plain: SceneFile = parse(text, Path::new("s.yaml")).unwrap();
        assert_eq!(MapFile::of_scene(&plain), None);
    }
}
