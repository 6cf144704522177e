//! What every stored episode and view set must satisfy, checked before writing and after reading.

use super::error::Fault;
use super::table::Table;
use super::tables;
use crate::{BoundingBox, Camera, Episode, Observations, Odometry, Pose, Symmetry, Truth, ViewSet};
use std::collections::BTreeSet;
use std::fmt::Display;

/// Room for rounding in the length of a unit vector or quaternion.
const UNIT_TOLERANCE: f64 = 1e-6;
/// Tracks and lighting sessions are counted from 0, so that larger numbers are a mistake.
const LARGEST_INDEX: usize = 1 << 20;

/// The place a fault is told at.
#[derive(Clone, Copy)]
struct Place<'a> {
    file: &'a str,
    line: Option<u64>,
}

impl<'a> Place<'a> {
    fn file(file: &'a str) -> Self {
        Self { file, line: None }
    }

    /// Row `index` of a table, below the line that names the columns.
    fn row(table: &Table, index: usize) -> Self {
        Self { file: table.file, line: Some(index as u64 + 2) }
    }

    fn require(self, holds: bool, field: &str, got: impl Display, expected: &str) -> Result<(), Fault> {
        if holds { Ok(()) } else { Err(Fault::new(self.file, self.line, field, got, expected)) }
    }

    fn require_finite(self, values: &[f64], field: &str) -> Result<(), Fault> {
        let stray = values.iter().find(|value| !value.is_finite());
        stray.map_or(Ok(()), |value| self.require(false, field, value, "finite"))
    }

    fn require_pose(self, pose: &Pose) -> Result<(), Fault> {
        self.require_finite(pose.translation.vector.as_slice(), "tx ty tz")?;
        let q = &pose.rotation.coords;
        let unit = (q.norm() - 1.0).abs() <= UNIT_TOLERANCE;
        self.require(unit, "qx qy qz qw", format!("{:?}", q.as_slice()), "a unit quaternion")
    }

    fn require_share(self, share: f64, field: &str) -> Result<(), Fault> {
        self.require((0.0..=1.0).contains(&share), field, share, "in [0, 1]")
    }

    fn require_family(self, family: &str) -> Result<(), Fault> {
        let named = !family.is_empty() && !family.contains(char::is_control);
        self.require(named, "family", format!("{family:?}"), "a name of one line")
    }

    fn require_symmetry(self, symmetry: Symmetry) -> Result<(), Fault> {
        let real = !matches!(symmetry, Symmetry::Cyclic { order: 0 | 1 });
        self.require(real, "symmetry", format!("{symmetry:?}"), "an order of at least 2")
    }
}

/// What the robot has, apart from truth.
pub(super) fn observations(o: &Observations) -> Result<(), Fault> {
    timestamps(&tables::TIMESTAMPS, &o.timestamps)?;
    camera(&o.camera)?;
    Place::file(tables::CAMERA).require_pose(&o.robot_from_camera)?;
    let pairs = o.steps().saturating_sub(1);
    Place::file(tables::ODOMETRY.file).require(
        o.odometry.len() == pairs,
        "rows",
        o.odometry.len(),
        &format!("{pairs}: one between consecutive steps"),
    )?;
    for (i, measured) in o.odometry.iter().enumerate() {
        odometry(Place::row(&tables::ODOMETRY, i), i, measured)?;
    }
    for (i, d) in o.detections.iter().enumerate() {
        let place = Place::row(&tables::DETECTIONS, i);
        place.require(d.step < o.steps(), "step", d.step, &format!("less than the {} steps", o.steps()))?;
        place.require(d.track <= LARGEST_INDEX, "track", d.track, &format!("at most {LARGEST_INDEX}"))?;
        bounding_box(place, &d.bounding_box)?;
        place.require(d.mask_pixels > 0, "mask_pixels", d.mask_pixels, "at least 1")?;
    }
    for (i, sighting) in o.landmarks.iter().enumerate() {
        let place = Place::row(&tables::LANDMARK_SIGHTINGS, i);
        let steps = format!("less than the {} steps", o.steps());
        place.require(sighting.step < o.steps(), "step", sighting.step, &steps)?;
        let known = sighting.landmark <= LARGEST_INDEX;
        place.require(known, "landmark", sighting.landmark, &format!("at most {LARGEST_INDEX}"))?;
        place.require_finite(sighting.pixel.as_slice(), "x, y")?;
        let spread = sighting.sigma.is_finite() && sighting.sigma > 0.0;
        place.require(spread, "sigma", sighting.sigma, "positive and finite")?;
    }
    for (i, pair) in o.detections.windows(2).enumerate() {
        let [before, after] = [&pair[0], &pair[1]].map(|d| (d.step, d.track));
        let got = format!("{after:?} after {before:?}");
        Place::row(&tables::DETECTIONS, i + 1).require(
            before < after,
            "step, track",
            got,
            "rows ordered by step, then track, and a track at most once a step",
        )?;
    }
    Ok(())
}

/// As many rows as there are things.
pub(super) fn one_each(table: &Table, got: usize, expected: usize, of: &str) -> Result<(), Fault> {
    Place::file(table.file).require(got == expected, "rows", got, &format!("{expected}, one a {of}"))
}

/// The clock of a trajectory.
pub(super) fn timestamps(table: &Table, timestamps: &[f64]) -> Result<(), Fault> {
    Place::file(table.file).require(!timestamps.is_empty(), "rows", 0, "at least 1 step")?;
    let mut last = f64::NEG_INFINITY;
    for (i, &seconds) in timestamps.iter().enumerate() {
        let place = Place::row(table, i);
        place.require_finite(&[seconds], "timestamp")?;
        place.require(seconds > last, "timestamp", seconds, &format!("more than {last}, the step before"))?;
        last = seconds;
    }
    Ok(())
}

fn camera(camera: &Camera) -> Result<(), Fault> {
    let place = Place::file(tables::CAMERA);
    let Camera { width, height, fx, fy, cx, cy } = *camera;
    let size = format!("{width} x {height}");
    place.require(width > 0 && height > 0, "width, height", size, "at least 1 pixel")?;
    place.require_finite(&[fx, fy, cx, cy], "fx, fy, cx, cy")?;
    place.require(fx > 0.0 && fy > 0.0, "fx, fy", format!("{fx}, {fy}"), "positive")
}

fn odometry(place: Place<'_>, index: usize, measured: &Odometry) -> Result<(), Fault> {
    let Odometry { from, to, robot_from_robot, covariance } = measured;
    let consecutive = (*from, *to) == (index, index + 1);
    let expected = format!("{index}, {}", index + 1);
    place.require(consecutive, "from, to", format!("{from}, {to}"), &expected)?;
    place.require_pose(robot_from_robot)?;
    place.require_finite(covariance.as_slice(), "covariance")?;
    place.require(*covariance == covariance.transpose(), "covariance", "not symmetric", "symmetric")?;
    let definite = covariance.cholesky().is_some();
    place.require(definite, "covariance", "not positive definite", "positive definite")
}

fn bounding_box(place: Place<'_>, b: &BoundingBox) -> Result<(), Fault> {
    let edges = [b.min.x, b.min.y, b.max.x, b.max.y];
    let field = "min_x, min_y, max_x, max_y";
    place.require_finite(&edges, field)?;
    let inside_out = !(b.min.x < b.max.x && b.min.y < b.max.y);
    place.require(!inside_out, field, format!("{edges:?}"), "min less than max")
}

/// What was true, apart from what was observed.
pub(super) fn truth(t: &Truth) -> Result<(), Fault> {
    for (i, pose) in t.world_from_robot.iter().enumerate() {
        Place::row(&tables::ROBOT, i).require_pose(pose)?;
    }
    for (i, object) in t.objects.iter().enumerate() {
        let place = Place::row(&tables::OBJECTS, i);
        place.require_family(&object.family)?;
        place.require_pose(&object.world_from_object)?;
        let sized = object.size.is_finite() && object.size > 0.0;
        place.require(sized, "size", object.size, "positive and finite")?;
        place.require_symmetry(object.symmetry)?;
        if let Some(extents) = &object.extents {
            let place = Place::row(&tables::EXTENTS, i);
            for lengths in [&extents.half_sides, &extents.semi_axes] {
                let sized = lengths.iter().all(|length| length.is_finite() && *length > 0.0);
                place.require(sized, "extents", format!("{lengths:?}"), "positive and finite")?;
            }
        }
    }
    for (i, point) in t.landmarks.iter().enumerate() {
        Place::row(&tables::LANDMARKS, i).require_finite(point.coords.as_slice(), "x, y, z")?;
    }
    for (i, detection) in t.detections.iter().enumerate() {
        let place = Place::row(&tables::DETECTION_TRUTHS, i);
        place.require_share(detection.visible_fraction, "visible_fraction")?;
    }
    Ok(())
}

/// Observations and truth, each and together.
pub(super) fn episode(e: &Episode) -> Result<(), Fault> {
    let Episode { observations: o, truth: t, .. } = e;
    observations(o)?;
    truth(t)?;
    one_each(&tables::ROBOT, t.world_from_robot.len(), o.steps(), "step")?;
    one_each(&tables::DETECTION_TRUTHS, t.detections.len(), o.detections.len(), "detection")?;
    for (i, (d, truth)) in o.detections.iter().zip(&t.detections).enumerate() {
        let expected = format!("less than the {} objects where something is visible", t.objects.len());
        let known = d.track < t.objects.len() || truth.visible_fraction <= 0.0;
        Place::row(&tables::DETECTIONS, i).require(known, "track", d.track, &expected)?;
    }
    for (i, sighting) in o.landmarks.iter().enumerate() {
        let expected = format!("less than the {} landmarks", t.landmarks.len());
        let known = sighting.landmark < t.landmarks.len();
        Place::row(&tables::LANDMARK_SIGHTINGS, i).require(
            known,
            "landmark",
            sighting.landmark,
            &expected,
        )?;
    }
    Ok(())
}

/// A view set.
pub(super) fn view_set(set: &ViewSet) -> Result<(), Fault> {
    let mut known = BTreeSet::new();
    for (i, instance) in set.instances.iter().enumerate() {
        let place = Place::row(&tables::INSTANCES, i);
        place.require(known.insert(instance.id), "id", instance.id, "an instance not listed before")?;
        place.require_family(&instance.family)?;
        place.require_symmetry(instance.symmetry)?;
    }
    let mut last = 0;
    for (i, view) in set.views.iter().enumerate() {
        let place = Place::row(&tables::VIEWS, i);
        let expected = format!("from {last}, the row before, to less than the {} instances", known.len());
        let ordered = (last..known.len()).contains(&view.instance);
        place.require(ordered, "instance", view.instance, &expected)?;
        last = view.instance;
        let expected = format!("at most {LARGEST_INDEX}");
        place.require(view.session <= LARGEST_INDEX, "session", view.session, &expected)?;
        let length = view.viewpoint.direction.norm();
        let unit = (length - 1.0).abs() <= UNIT_TOLERANCE;
        place.require(unit, "direction_x, _y, _z", format!("length {length}"), "a unit vector")?;
        place.require_finite(&[view.viewpoint.roll], "roll")?;
        place.require_finite(&[view.viewpoint.log_distance], "log_distance")?;
        place.require_share(view.visible_fraction, "visible_fraction")?;
        place.require_finite(&view.box_center_error, "box_center_error_x, _y")?;
        if let Some(sighting) = &view.sighting {
            let (place, step) = (Place::file(tables::VIEW_SIGHTINGS.file), sighting.step);
            place.require(step <= LARGEST_INDEX, "step", step, &format!("at most {LARGEST_INDEX}"))?;
            place.require_pose(&sighting.session_from_camera)?;
            place.require_finite(&sighting.ray, "ray_x, ray_y")?;
            place.require_finite(&[sighting.angular_size], "angular_size")?;
        }
    }
    Ok(())
}
