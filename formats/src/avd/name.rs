//! Names of scans and images.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// The kind of place that a scan is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneType {
    /// A home.
    Home,
    /// An office.
    Office,
    /// Any other.
    Gen,
}

impl SceneType {
    const ALL: [(Self, &str); 3] = [(Self::Home, "Home"), (Self::Office, "Office"), (Self::Gen, "Gen")];
}

/// A scan: `Home_001_1` is the first scan of the first home.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScanName {
    /// Its kind.
    pub scene_type: SceneType,
    /// Number of the place, below 1000.
    pub scene: u16,
    /// Number of the scan of that place, below 10.
    pub scan: u8,
}

/// Not a name of a scan.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("scan name: got {got:?}, expected one like Home_001_1; rename the folder")]
pub struct NotAScan {
    got: String,
}

impl FromStr for ScanName {
    type Err = NotAScan;

    fn from_str(text: &str) -> Result<Self, NotAScan> {
        let parse = || {
            let mut parts = text.split('_');
            let kind = parts.next()?;
            let scene_type = SceneType::ALL.iter().find(|(_, name)| *name == kind)?.0;
            let scene = parts.next()?.parse().ok().filter(|scene| *scene < 1000)?;
            let scan = parts.next()?.parse().ok().filter(|scan| *scan < 10)?;
            parts.next().is_none().then_some(Self { scene_type, scene, scan })
        };
        parse().ok_or_else(|| NotAScan { got: text.to_owned() })
    }
}

impl fmt::Display for ScanName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = SceneType::ALL[self.scene_type as usize].1;
        write!(f, "{name}_{:03}_{}", self.scene, self.scan)
    }
}

/// The name of the image with this index, below a million, of the colour camera.
pub(super) fn image(scan: &ScanName, index: u32) -> String {
    format!("{}{:03}{}{index:06}0101.jpg", scan.scene_type as u32, scan.scene, scan.scan)
}

/// The file of an image.
pub(super) fn image_file(scan: &Path, image: &str) -> PathBuf {
    scan.join("jpg_rgb").join(image)
}

/// The file name of the depth that is registered to an image.
pub(super) fn depth_of(image: &str) -> Option<String> {
    Some(format!("{}03.png", image.strip_suffix("01.jpg")?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_example_is_named_so() {
        let scan: ScanName = "Home_001_2".parse().unwrap();
        assert_eq!(image(&scan, 162), "000120001620101.jpg");
        assert_eq!(depth_of("000120001620101.jpg").as_deref(), Some("000120001620103.png"));
        assert_eq!(scan.to_string(), "Home_001_2");
    }

    #[test]
    fn other_names_are_no_scans() {
        assert!("Office_014_1".parse::<ScanName>().is_ok());
        for other in ["Home_001", "Attic_001_1", "Home_1000_1", "Home_001_1_2", "Home_x_1", ""] {
            assert!(other.parse::<ScanName>().is_err(), "{other}");
        }
    }
}
