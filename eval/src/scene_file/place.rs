//! Where in a scene file a part of the world is written, and in a study a variant.

use super::SceneFileError;
use super::read::{options, text};
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_saphyr::{Location, Spanned};
use std::collections::BTreeMap;
use std::path::Path;
use vantage_sim::checked::{Misplaced, Part};
use vantage_sim::error::SimError;

#[derive(Deserialize)]
struct Places {
    world: World,
    robot: Spanned<Section>,
    views: Spanned<Section>,
}

/// Settings by name.
type Section = BTreeMap<String, Spanned<IgnoredAny>>;

#[derive(Deserialize)]
struct World {
    surface: Spanned<Surface>,
    objects: Spanned<IgnoredAny>,
    #[serde(default)]
    fixtures: Vec<Spanned<IgnoredAny>>,
}

#[derive(Deserialize)]
struct Surface {
    #[serde(default)]
    furniture: Vec<Spanned<IgnoredAny>>,
}

/// The settings of variants.
#[derive(Deserialize)]
struct Variants {
    variants: Vec<Spanned<IgnoredAny>>,
}

/// `<file>:<line>:<column>` of a variant of a study, as far as the file can still be read.
pub fn place_of_variant(number: usize, path: &Path) -> String {
    let study = text(path)
        .ok()
        .and_then(|text| serde_saphyr::from_str_with_options::<Variants>(&text, options()).ok());
    let at = study.and_then(|study| Some(study.variants.get(number)?.referenced));
    told(path, at)
}

impl Places {
    /// Those of a scene file, as far as it can still be read.
    fn of(path: &Path) -> Option<Self> {
        serde_saphyr::from_str_with_options(&text(path).ok()?, options()).ok()
    }

    fn part(&self, part: Part) -> Option<Location> {
        let world = &self.world;
        match part {
            Part::Surface => Some(world.surface.referenced),
            Part::Piece(index) => Some(world.surface.value.furniture.get(index)?.referenced),
            Part::Fixture(index) => Some(world.fixtures.get(index)?.referenced),
            Part::Objects => Some(world.objects.referenced),
        }
    }

    /// A setting of `robot` or `views`; the section where it is left to its default.
    fn setting(&self, field: &str) -> Option<Location> {
        let (section, name) = field.split_once('.')?;
        let section = match section {
            "robot" => &self.robot,
            "views" => &self.views,
            _ => return (field == "world.objects").then_some(self.world.objects.referenced),
        };
        Some(section.value.get(name).map_or(section.referenced, |setting| setting.referenced))
    }
}

/// `<file>:<line>:<column>`, or the file alone.
fn told(path: &Path, at: Option<Location>) -> String {
    let at = at.map(|at| format!(":{}:{}", at.line(), at.column())).unwrap_or_default();
    format!("{}{at}", path.display())
}

/// One line for each, with line and column as far as the file can still be read.
pub(super) fn locate(misplaced: &[Misplaced], path: &Path) -> String {
    let places = Places::of(path);
    let line = |misplaced: &Misplaced| {
        let at = places.as_ref().and_then(|places| places.part(misplaced.part));
        format!("{}: {misplaced}", told(path, at))
    };
    misplaced.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// What a scene asks for and no world can have, as a fault of the scene file; `None` of other errors.
pub fn misfit(error: &SimError, path: &Path) -> Option<SceneFileError> {
    let field = match error {
        SimError::NothingFits { .. } => "world.objects",
        SimError::TooFewMeshes { field, .. } | SimError::TooLarge { field, .. } => field,
        SimError::TooLong { .. } => "robot.path",
        _ => return None,
    };
    let at = Places::of(path).and_then(|places| places.setting(field));
    let message = format!("{}: {field}: {error}", told(path, at));
    Some(SceneFileError::Invalid { path: path.to_owned(), message })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_variant_is_told_with_line_and_column_and_a_file_that_is_gone_by_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("study.yaml");
        assert_eq!(place_of_variant(0, &path), path.display().to_string());
        std::fs::write(&path, "name: x\nvariants:\n  - name: a\n  - name: b\n    note: c\n").unwrap();
        assert_eq!(place_of_variant(1, &path), format!("{}:4:5", path.display()));
        assert_eq!(place_of_variant(2, &path), path.display().to_string());
    }

    #[test]
    fn what_no_world_can_have_is_told_with_line_and_column() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.yaml");
        let scene = "world:\n  surface: {}\n  objects: 9\nrobot:\n  steps: 5\nviews:\n  test_instances: 3\n";
        std::fs::write(&path, scene).unwrap();
        let few =
            |field| SimError::TooFewMeshes { field, wanted: 9, got: 2, split: vantage_dataset::Split::Test };
        let large = |field| SimError::TooLarge { what: "it", bytes: 9, limit: 8, field, remedy: "it" };
        for (error, place) in [
            (
                SimError::NothingFits { fitting: 2, wanted: 9, surface: "table" },
                ":3:12: world.objects: only 2",
            ),
            (few("world.objects"), ":3:12: world.objects: "),
            (few("views.test_instances"), ":7:19: views.test_instances: "),
            (large("robot.steps"), ":5:10: robot.steps: "),
            (SimError::TooLong { seconds: 9.0, limit: 8.0 }, ":5:3: robot.path: "),
        ] {
            let message = misfit(&error, &path).unwrap().to_string();
            assert!(message.contains(&format!("scene.yaml{place}")), "{place:?} not in: {message}");
        }
        assert!(misfit(&SimError::NoTrack, &path).is_none());
    }
}
