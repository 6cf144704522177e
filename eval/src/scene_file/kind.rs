//! Scene, study or map: what a YAML file is, by its fields.

use super::read::{options, text};
use serde::de::IgnoredAny;
use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

/// What a YAML file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// A scene.
    Scene,
    /// A study.
    Study,
    /// A map.
    Map,
}

impl FileKind {
    /// By its text; `None` where it is none of them, or is no YAML.
    pub fn of(text: &str) -> Option<Self> {
        type Fields = BTreeMap<String, IgnoredAny>;
        let fields: Fields = serde_saphyr::from_str_with_options(text, options()).ok()?;
        match ["world", "variants", "panels"].map(|field| fields.contains_key(field)) {
            [true, false, false] => Some(Self::Scene),
            [false, true, false] => Some(Self::Study),
            [false, false, true] => Some(Self::Map),
            _ => None,
        }
    }

    /// Likewise, of a file; `None` where it cannot be read, too.
    pub fn of_file(path: &Path) -> Option<Self> {
        Self::of(&text(path).ok()?)
    }

    /// The folder that files of this kind lie in.
    pub fn folder(self) -> &'static str {
        match self {
            Self::Scene => "scenes",
            Self::Study => "studies",
            Self::Map => "maps",
        }
    }

    /// What runs it.
    pub fn command(self) -> &'static str {
        match self {
            Self::Scene => "bench",
            Self::Study => "bench study",
            Self::Map => "bench map",
        }
    }
}

impl fmt::Display for FileKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Scene => "scene",
            Self::Study => "study",
            Self::Map => "map",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_told_by_its_fields_however_wrong_they_are() {
        let cases = [
            ("world: 1\nrobot: 2\n", Some(FileKind::Scene)),
            ("variants: []\nscene: x\n", Some(FileKind::Study)),
            ("panels: []\nscene: x\n", Some(FileKind::Map)),
            ("world: 1\nvariants: []\n", None),
            ("name: x\n", None),
            ("world: [", None),
            ("- world\n", None),
        ];
        for (text, kind) in cases {
            assert_eq!(FileKind::of(text), kind, "{text}");
        }
    }
}
