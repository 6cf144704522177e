//! Objects stand: on a level surface their centre of mass lies well inside what they stand on, which has a least size.

use rapier3d::geometry::SharedShape;
use rapier3d::math::Vector;
use std::f64::consts::PI;
use vantage_dataset::{Seed, Split};
use vantage_sim::object::{LEAST_FOOTPRINT, Object};
use vantage_sim::scene::Family;

const INSTANCES: u64 = 100;
/// The tilt that every object bears without falling over, radians.
const TILT: f64 = 0.15;

/// The tilt at which the object, of even density inside its hull, falls over in its weakest direction.
fn critical_tilt(object: &Object) -> f64 {
    let points: Vec<Vector> = object.hull.iter().map(|&p| Vector::from(p)).collect();
    let center = SharedShape::convex_hull(&points).expect("points of a solid").mass_properties(1.0).local_com;
    let floor = object.hull.iter().map(|p| p[2]).fold(f32::INFINITY, f32::min);
    let support = || object.hull.iter().filter(|p| p[2] < floor + 1e-3 * object.size as f32);
    let reach = (0..180).map(|k| {
        let azimuth = f64::from(k) * PI / 90.0;
        let (sin, cos) = (azimuth.sin() as f32, azimuth.cos() as f32);
        let edge = support().map(|p| p[0] * cos + p[1] * sin).fold(f32::NEG_INFINITY, f32::max);
        f64::from(edge - (center.x * cos + center.y * sin))
    });
    reach.fold(f64::INFINITY, f64::min).atan2(f64::from(center.z - floor))
}

#[test]
fn every_object_bears_a_tilt_and_is_not_smaller_than_is_counted_on() {
    for family in Family::ALL {
        for index in 0..INSTANCES {
            let object = Object::generate(family, Split::Train, Seed(6), index);
            let tilt = critical_tilt(&object);
            assert!(tilt > TILT, "{} {index} falls over at {tilt} rad", family.name());
            let radius = object.footprint();
            assert!(radius > LEAST_FOOTPRINT, "{} {index} fits into {radius} m", family.name());
        }
    }
}
