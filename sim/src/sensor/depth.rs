//! The detector's depth of an object's centre, part of `Z^g`.

use crate::scene::DetectorSpec;
use vantage_dataset::{CenterDepth, Pose, Seed};

/// The depth of an object's centre along the optical axis, with noise; `number` is that of the detection in the episode's streams.
/// `None` where the detector has no depth, or where noise puts the object behind the camera.
///
/// Stream: `depth`.
pub fn measured(
    spec: &DetectorSpec,
    camera_from_object: &Pose,
    number: u64,
    seed: Seed,
) -> Option<CenterDepth> {
    let sigma = spec.depth_sigma?;
    let meters = camera_from_object.translation.vector.z + sigma * seed.stream("depth", number).normal();
    (meters > 0.0).then_some(CenterDepth { meters, sigma })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_depth_is_off_by_its_sigma_and_never_behind_the_camera() {
        let spec =
            DetectorSpec { min_visible_fraction: 0.1, min_mask_pixels: 10, faults: None, depth_sigma: None };
        let far = Pose::translation(5.0, -4.0, 2.0);
        assert_eq!(measured(&spec, &far, 0, Seed(1)), None);
        let spec = DetectorSpec { depth_sigma: Some(0.03), ..spec };
        let errors: Vec<f64> =
            (0..4000).map(|i| measured(&spec, &far, i, Seed(1)).unwrap().meters - 2.0).collect();
        let mean = errors.iter().sum::<f64>() / 4000.0;
        let spread = (errors.iter().map(|e| e * e).sum::<f64>() / 4000.0).sqrt();
        assert!(mean.abs() < 0.002 && (spread - 0.03).abs() < 0.001, "{mean} {spread}");
        let near = Pose::translation(0.0, 0.0, 0.01);
        let seen: Vec<_> = (0..100).map(|i| measured(&spec, &near, i, Seed(1))).collect();
        assert!(seen.iter().any(Option::is_none) && seen.iter().flatten().all(|d| d.meters > 0.0));
    }
}
