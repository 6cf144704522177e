//! Where a camera's axis meets its image.

use vantage_dataset::Camera;

/// Whether it does so inside. Elsewhere the intrinsics are likely of another image, or of one of another size.
pub(crate) fn is_inside(camera: &Camera) -> bool {
    (0.0..=f64::from(camera.width)).contains(&camera.cx)
        && (0.0..=f64::from(camera.height)).contains(&camera.cy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_edges_of_the_image_are_inside() {
        let with = |cx, cy| is_inside(&Camera { width: 64, height: 48, fx: 50.0, fy: 50.0, cx, cy });
        for (cx, cy) in [(32.0, 24.0), (0.0, 0.0), (64.0, 48.0)] {
            assert!(with(cx, cy), "{cx} {cy}");
        }
        for (cx, cy) in [(-0.1, 24.0), (64.1, 24.0), (32.0, -0.1), (32.0, 48.1)] {
            assert!(!with(cx, cy), "{cx} {cy}");
        }
    }
}
