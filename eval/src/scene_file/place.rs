//! Where in a scene file a part of the world is written.

use super::read::{options, text};
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_saphyr::Spanned;
use std::path::Path;
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
