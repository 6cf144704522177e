//! Where in a scene file a part of the world is written, and in a study a variant.

use super::SceneFileError;
use super::read::{options, text};
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_saphyr::Spanned;
use std::path::Path;
use vantage_sim::error::SimError;
use vantage_sim::scene::{Misplaced, Part};

#[derive(Deserialize)]
struct Places {
    world: World,
}

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
    let at = at.map(|at| format!(":{}:{}", at.line(), at.column())).unwrap_or_default();
    format!("{}{at}", path.display())
}

/// One line for each, with line and column as far as the file can still be read.
pub(super) fn locate(misplaced: &[Misplaced], path: &Path) -> String {
    let places =
        text(path).ok().and_then(|text| serde_saphyr::from_str_with_options::<Places>(&text, options()).ok());
    let line = |misplaced: &Misplaced| {
        let at = places.as_ref().and_then(|Places { world }| match misplaced.part {
            Part::Surface => Some(world.surface.referenced),
            Part::Piece(index) => Some(world.surface.value.furniture.get(index)?.referenced),
            Part::Fixture(index) => Some(world.fixtures.get(index)?.referenced),
            Part::Objects => Some(world.objects.referenced),
        });
        let at = at.map(|at| format!(":{}:{}", at.line(), at.column())).unwrap_or_default();
        format!("{}{at}: {misplaced}", path.display())
    };
    misplaced.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Objects that find no room, as a fault of the scene file; `None` of other errors.
pub fn misfit(error: &SimError, path: &Path) -> Option<SceneFileError> {
    if !matches!(error, SimError::NothingFits { .. }) {
        return None;
    }
    let message = locate(&[Misplaced { part: Part::Objects, reason: error.to_string() }], path);
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
}
