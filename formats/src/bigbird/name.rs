//! Names of files.

/// One image of an object; ordered by angle, then camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct ImageName {
    /// Degrees that the table has turned.
    pub(super) angle: u32,
    /// 1 to 5.
    pub(super) camera: usize,
}

impl ImageName {
    /// The image that `NP{c}_{a}.jpg` is.
    pub(super) fn parse(file: &str) -> Option<Self> {
        let (camera, angle) = file.strip_prefix("NP")?.strip_suffix(".jpg")?.split_once('_')?;
        let camera = camera.parse().ok().filter(|camera| (1..=super::CAMERAS).contains(camera))?;
        Some(Self { angle: parse_angle(angle)?, camera })
    }

    pub(super) fn image(self) -> String {
        format!("NP{}_{}.jpg", self.camera, self.angle)
    }

    pub(super) fn depth(self) -> String {
        format!("NP{}_{}.h5", self.camera, self.angle)
    }

    pub(super) fn mask(self) -> String {
        format!("masks/NP{}_{}_mask.pbm", self.camera, self.angle)
    }
}

/// The pose file of an angle.
pub(super) fn pose(angle: u32) -> String {
    format!("poses/NP5_{angle}_pose.h5")
}

/// The angle of `NP5_{a}_pose.h5`.
pub(super) fn parse_pose(file: &str) -> Option<u32> {
    parse_angle(file.strip_prefix("NP5_")?.strip_suffix("_pose.h5")?)
}

fn parse_angle(digits: &str) -> Option<u32> {
    digits.parse().ok().filter(|angle: &u32| angle.to_string() == digits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_read_back() {
        let name = ImageName { angle: 33, camera: 4 };
        assert_eq!(ImageName::parse(&name.image()), Some(name));
        assert_eq!(name.image(), "NP4_33.jpg");
        assert_eq!(name.mask(), "masks/NP4_33_mask.pbm");
        for other in ["N4_33.jpg", "NP6_0.jpg", "NP1_03.jpg", "NP1_0.h5", "NP1.jpg"] {
            assert_eq!(ImageName::parse(other), None, "{other}");
        }
        assert_eq!(parse_pose("NP5_0_pose.h5"), Some(0));
    }
}
