//! What a detector gets wrong: boxes off, objects missed, objects that are none.

use crate::scene::DetectorFaultsSpec;
use nalgebra::Vector2;
use vantage_dataset::window::{Labelled, Window, cut};
use vantage_dataset::{BoundingBox, Detection, Seed};

/// Sides of the boxes of false detections, pixels.
const FALSE_SIDES: [f64; 2] = [24.0, 120.0];
/// Of pixels in the mask of a detection of nothing.
const INSIDE: u32 = 1;
/// An object's number in the streams of a step.
const TRACKS: u64 = 1 << 20;

/// Whether the detector misses an object at a step. Stream: `missed`.
pub fn is_missed(spec: &DetectorFaultsSpec, step: usize, track: usize, seed: Seed) -> bool {
    seed.stream("missed", number(step, track)).chance(spec.miss_probability)
}

/// The box as the detector has it: centre and sides off by normal errors in units of its sides. Stream: `box jitter`.
pub fn jittered(spec: &DetectorFaultsSpec, exact: &BoundingBox, number: u64, seed: Seed) -> BoundingBox {
    let mut stream = seed.stream("box jitter", number);
    let size = exact.max - exact.min;
    let mut off = || Vector2::new(stream.normal(), stream.normal()) * spec.box_jitter;
    let center = exact.center() + size.component_mul(&off());
    let half = size.component_mul(&off().map(libm::exp)) / 2.0;
    BoundingBox { min: center - half, max: center + half }
}

/// An object's number in the streams of an episode.
pub fn number(step: usize, track: usize) -> u64 {
    step as u64 * TRACKS + track as u64
}

/// Detections of nothing in an image, their tracks counted from `first_track`. Stream: `false detections`, by step.
pub fn false_detections(
    spec: &DetectorFaultsSpec,
    image: &Labelled<'_>,
    step: usize,
    first_track: usize,
    seed: Seed,
) -> Vec<Detection> {
    let mut stream = seed.stream("false detections", step as u64);
    let size = Vector2::new(image.width as f64, (image.ids.len() / image.width) as f64);
    // Poisson, by Knuth's product of uniforms.
    let (limit, mut product, mut count) = (libm::exp(-spec.false_per_image), stream.unit(), 0);
    while product > limit {
        count += 1;
        product *= stream.unit();
    }
    (0..count)
        .map(|i| {
            let mut side = || stream.uniform(FALSE_SIDES[0], FALSE_SIDES[1]).min(size.min() / 2.0);
            let sides = Vector2::new(side(), side());
            let min = Vector2::new(stream.unit(), stream.unit()).component_mul(&(size - sides));
            let bounding_box = BoundingBox { min, max: min + sides };
            let (ids, mask_pixels) = ellipse(image, &bounding_box);
            let window = Window::around(&bounding_box);
            Detection {
                step,
                track: first_track + i,
                bounding_box,
                mask_pixels,
                center_depth: None,
                masked_crop: cut(&Labelled { ids: &ids, ..*image }, &window, Some(INSIDE)),
                boxed_crop: cut(image, &window, None),
            }
        })
        .collect()
}

/// Gives each false detection, with the probability that the spec says, the track of one of the objects that were `lost`: seen before, and
/// not detected now. The others keep tracks of their own, counted from `first_track`; returns how many. Stream: `misassigned`, by
/// detection.
pub fn misassign(
    spec: &DetectorFaultsSpec,
    found: &mut [Detection],
    mut lost: Vec<usize>,
    first_track: usize,
    seed: Seed,
) -> usize {
    let mut own = 0;
    for (i, detection) in found.iter_mut().enumerate() {
        let mut stream = seed.stream("misassigned", number(detection.step, i));
        detection.track = if stream.chance(spec.misassigned) && !lost.is_empty() {
            lost.remove((stream.unit() * lost.len() as f64) as usize)
        } else {
            own += 1;
            first_track + own - 1
        };
    }
    own
}

/// The id of pixels in an ellipse that fills a box, and how many there are: nothing has a mask as other things have.
fn ellipse(image: &Labelled<'_>, bounds: &BoundingBox) -> (Vec<u32>, u32) {
    let (center, half) = (bounds.center(), (bounds.max - bounds.min) / 2.0);
    let mut ids = vec![0; image.ids.len()];
    let mut pixels = 0;
    for (i, id) in ids.iter_mut().enumerate() {
        let at = Vector2::new((i % image.width) as f64 + 0.5, (i / image.width) as f64 + 0.5);
        if (at - center).component_div(&half).norm() <= 1.0 {
            *id = INSIDE;
            pixels += 1;
        }
    }
    (ids, pixels.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec() -> DetectorFaultsSpec {
        DetectorFaultsSpec { box_jitter: 0.1, miss_probability: 0.2, false_per_image: 0.7, misassigned: 0.3 }
    }

    #[test]
    fn rates_are_those_asked_for() {
        let missed = (0..5000).filter(|&step| is_missed(&spec(), step, 3, Seed(1))).count();
        assert!((850..1150).contains(&missed), "{missed} of 5000");
        let (rgb, ids) = (vec![9; 200 * 100 * 3], vec![0; 200 * 100]);
        let image = Labelled { width: 200, rgb: &rgb, ids: &ids };
        let mut count = 0;
        for step in 0..2000 {
            let found = false_detections(&spec(), &image, step, 10, Seed(1));
            for (i, detection) in found.iter().enumerate() {
                let BoundingBox { min, max } = detection.bounding_box;
                assert!(min.min() >= 0.0 && max.x <= 200.0 && max.y <= 100.0);
                assert_eq!(detection.track, 10 + i);
            }
            count += found.len();
        }
        assert!((1280..1520).contains(&count), "{count} in 2000 images");
    }

    #[test]
    fn lost_objects_get_their_share_evenly_and_no_two_in_an_image() {
        let (rgb, ids) = (vec![9; 40 * 40 * 3], vec![0; 40 * 40]);
        let image = Labelled { width: 40, rgb: &rgb, ids: &ids };
        let (mut counts, mut own, mut all) = ([0; 3], 0, 0);
        for step in 0..3000 {
            let mut found = false_detections(&spec(), &image, step, 10, Seed(1));
            all += found.len();
            let before = own;
            own += misassign(&spec(), &mut found, vec![1, 4, 7], 10 + own, Seed(1));
            let tracks = || found.iter().map(|detection| detection.track);
            assert!(tracks().filter(|track| *track >= 10).eq(10 + before..10 + own));
            for (count, track) in counts.iter_mut().zip([1, 4, 7]) {
                let given = tracks().filter(|found| *found == track).count();
                assert!(given <= 1);
                *count += given;
            }
        }
        let given: usize = counts.iter().sum();
        assert_eq!(given + own, all);
        assert!((given as f64 / all as f64 - 0.3).abs() < 0.03, "{given} of {all}");
        assert!(
            counts.iter().all(|count| (*count as f64 / given as f64 - 1.0 / 3.0).abs() < 0.05),
            "{counts:?}"
        );
        let mut found = false_detections(&spec(), &image, 2, 10, Seed(1));
        assert_eq!(misassign(&spec(), &mut found, Vec::new(), 10, Seed(1)), found.len());
    }

    #[test]
    fn a_box_is_off_by_its_own_size() {
        let exact = BoundingBox { min: Vector2::new(10.0, 20.0), max: Vector2::new(50.0, 40.0) };
        let centers: Vec<Vector2<f64>> =
            (0..4000).map(|i| jittered(&spec(), &exact, i, Seed(1)).center() - exact.center()).collect();
        let spread = |axis: usize| (centers.iter().map(|c| c[axis] * c[axis]).sum::<f64>() / 4000.0).sqrt();
        assert!((spread(0) - 4.0).abs() < 0.2 && (spread(1) - 2.0).abs() < 0.1);
    }
}
