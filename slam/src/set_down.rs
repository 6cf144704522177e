//! First poses of a robot that was carried somewhere: where the objects that it sees before and after agree.

use crate::mapping::place_object;
use crate::problem::Problem;
use crate::sighting::Sighting;
use crate::variable::{Key, Value, Values};
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use std::collections::BTreeMap;
use vantage_dataset::Pose;

/// Puts the poses from each motion that is unknown on where that has two known objects or more, by the turn about the world's z axis and the shift that
/// fit best (least squares). Poses that see fewer stay where they are.
pub fn set_down(problem: &Problem<'_>, values: &mut Values, sightings: &BTreeMap<usize, Vec<Sighting>>) {
    let steps = problem.observations.steps();
    let mut cuts: Vec<usize> = problem.observations.set_down().collect();
    cuts.sort_unstable();
    cuts.push(steps);
    for pair in cuts.windows(2) {
        let (since, until) = (pair[0], pair[1]);
        let place = |track: usize, seen: &[Sighting], from: usize, to: usize| {
            let seen: Vec<Sighting> =
                seen.iter().filter(|sighting| (from..to).contains(&sighting.step)).copied().collect();
            place_object(problem, values, track, &seen).ok()
        };
        let both = sightings.iter().filter_map(|(&track, seen)| {
            Some((place(track, seen, since, until)?, place(track, seen, 0, since)?))
        });
        let Some(motion) = level_motion(&both.collect::<Vec<_>>()) else { continue };
        for key in (since..steps).map(Key::Robot) {
            if let Some(pose) = values.pose(key).copied() {
                values.insert(key, Value::Pose(motion * pose));
            }
        }
    }
}

/// The motion on the floor that takes the first of each pair nearest to the second; none of fewer than two pairs.
fn level_motion(pairs: &[(Vector3<f64>, Vector3<f64>)]) -> Option<Pose> {
    if pairs.len() < 2 {
        return None;
    }
    let count = pairs.len() as f64;
    let from = pairs.iter().map(|(from, _)| from).sum::<Vector3<f64>>() / count;
    let to = pairs.iter().map(|(_, to)| to).sum::<Vector3<f64>>() / count;
    let (mut sine, mut cosine) = (0.0, 0.0);
    for (a, b) in pairs {
        let (a, b) = ((a - from).xy(), (b - to).xy());
        sine += a.perp(&b);
        cosine += a.dot(&b);
    }
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), libm::atan2(sine, cosine));
    let mut shift = to - turn * from;
    shift.z = 0.0;
    Some(Pose::from_parts(Translation3::from(shift), turn))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_motion_between_two_pieces_is_found_on_the_floor() {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 2.5);
        let motion = Pose::from_parts(Translation3::new(3.0, -2.0, 0.0), turn);
        let places =
            [Vector3::new(1.0, 2.0, 0.9), Vector3::new(-1.0, 0.5, 1.1), Vector3::new(2.0, -3.0, 0.9)];
        let moved = |place: &Vector3<f64>| (motion * nalgebra::Point3::from(*place)).coords;
        let pairs: Vec<_> = places.iter().map(|place| (*place, moved(place))).collect();
        let found = level_motion(&pairs).unwrap();
        assert!((found.to_homogeneous() - motion.to_homogeneous()).norm() < 1e-12);
        assert!(level_motion(&pairs[..1]).is_none());
    }
}
