//! The files of a folder by name, and the columns of its tables.

use super::table::{Style, Table};

pub(super) const CAMERA: &str = "camera.json";
pub(super) const MASKED_CROPS: &str = "crops_masked.npy";
pub(super) const BOXED_CROPS: &str = "crops_boxed.npy";
/// Of a view set.
pub(super) const CROPS: &str = "crops.npy";

/// The robot's true trajectory in an episode's folder.
pub(super) const ROBOT: Table = Table {
    file: "truth/robot.tum",
    columns: &["timestamp", "tx", "ty", "tz", "qx", "qy", "qz", "qw"],
    style: Style::Tum,
};

pub(super) const TIMESTAMPS: Table =
    Table { file: "timestamps.csv", columns: &["step", "timestamp"], style: Style::Csv };

pub(super) const DETECTIONS: Table = Table {
    file: "detections.csv",
    columns: &["step", "track", "min_x", "min_y", "max_x", "max_y", "mask_pixels"],
    style: Style::Csv,
};

/// Rows only for the detections that have a depth; the file only where there are any.
pub(super) const DEPTHS: Table =
    Table { file: "depths.csv", columns: &["detection", "depth", "sigma"], style: Style::Csv };

pub(super) const ODOMETRY: Table = Table {
    file: "odometry.csv",
    columns: &[
        "from", "to", "tx", "ty", "tz", "qx", "qy", "qz", "qw", "c00", "c01", "c02", "c03", "c04", "c05",
        "c11", "c12", "c13", "c14", "c15", "c22", "c23", "c24", "c25", "c33", "c34", "c35", "c44", "c45",
        "c55",
    ],
    style: Style::Csv,
};

pub(super) const OBJECTS: Table = Table {
    file: "truth/objects.csv",
    columns: &["track", "instance", "family", "symmetry", "size", "tx", "ty", "tz", "qx", "qy", "qz", "qw"],
    style: Style::Csv,
};

/// Where the extents of every object are known.
pub(super) const EXTENTS: Table = Table {
    file: "truth/extents.csv",
    columns: &["track", "half_x", "half_y", "half_z", "semi_x", "semi_y", "semi_z"],
    style: Style::Csv,
};

/// Where the world has landmarks.
pub(super) const LANDMARK_SIGHTINGS: Table =
    Table { file: "landmarks.csv", columns: &["step", "landmark", "x", "y", "sigma"], style: Style::Csv };

/// Where the world has landmarks.
pub(super) const LANDMARKS: Table =
    Table { file: "truth/landmarks.csv", columns: &["landmark", "x", "y", "z"], style: Style::Csv };

pub(super) const DETECTION_TRUTHS: Table =
    Table { file: "truth/detections.csv", columns: &["detection", "visible_fraction"], style: Style::Csv };

pub(super) const INSTANCES: Table =
    Table { file: "instances.csv", columns: &["instance", "id", "family", "symmetry"], style: Style::Csv };

pub(super) const VIEWS: Table = Table {
    file: "views.csv",
    columns: &[
        "instance",
        "session",
        "direction_x",
        "direction_y",
        "direction_z",
        "roll",
        "log_distance",
        "visible_fraction",
        "box_center_error_x",
        "box_center_error_y",
    ],
    style: Style::Csv,
};

/// Rows only for the views that have a sighting; the file only where there are any.
pub(super) const VIEW_SIGHTINGS: Table = Table {
    file: "sightings.csv",
    columns: &["view", "step", "tx", "ty", "tz", "qx", "qy", "qz", "qw", "ray_x", "ray_y", "angular_size"],
    style: Style::Csv,
};
