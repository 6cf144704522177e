//! Objects as ellipsoids: which of their boxes enter by all four edges.

use crate::factor::{BoxEdgesFactor, ExtentsPrior, Factor};
use crate::graph::Graph;
use crate::problem::Problem;
use crate::settings::ExtentsSettings;
use crate::sighting::Sighting;
use crate::variable::{Key, Value, Values};
use nalgebra::DVector;
use std::f64::consts::SQRT_2;

/// Adds to `graph` the geometric measurements of a placed object as an ellipsoid: the edges of its boxes in place of bearings, and the
/// prior of its extents; and to `values` a ball of the object's size.
///
/// Where the first values have the ellipsoid around the camera or behind it, a box enters as a bearing. Of an object that no view tells
/// the size of, all do, and it has no extents.
pub fn add_ellipsoid(
    problem: &Problem<'_>,
    settings: &ExtentsSettings,
    graph: &mut Graph<'_>,
    values: &mut Values,
    track: usize,
    sightings: &[Sighting],
) {
    let Some(size) = problem.object_size(values, track, sightings) else {
        return problem.add_bearings(graph, track, sightings);
    };
    let extents = Key::Extents(track);
    let mut with_ball = values.clone();
    with_ball.insert(extents, Value::Vector(DVector::from_element(3, libm::log(size / 2.0))));
    let mut edged = false;
    for sighting in sightings {
        let factor = edges(problem, track, sighting);
        if factor.residual(&with_ball).is_some() {
            graph.push(factor);
            problem.add_depth(graph, track, sighting);
            edged = true;
        } else {
            problem.add_bearings(graph, track, &[*sighting]);
        }
    }
    if edged {
        graph.push(ExtentsPrior::new(extents, settings.half_axis, settings.log_sigma));
        *values = with_ball;
    }
}

/// The factor of a box's edges. The middle of two edges is as sure as a bearing.
pub(crate) fn edges(problem: &Problem<'_>, track: usize, sighting: &Sighting) -> BoxEdgesFactor {
    BoxEdgesFactor::new(
        [Key::Robot(sighting.step), Key::Object(track), Key::Extents(track)],
        problem.observations.robot_from_camera,
        sighting.edges,
        SQRT_2 * problem.settings.bearing_noise.sigma(sighting.angular_size),
        problem.settings.bearing_kernel,
    )
}
