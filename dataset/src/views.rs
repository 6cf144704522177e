//! Views of instances with known viewpoints: what the viewpoint-dependent model is trained on (III-A).

use crate::crop::Crop;
use crate::instance::{InstanceId, Split, Symmetry};
use crate::se3::Pose;
use crate::sighting::Sighting;
use crate::viewpoint::Viewpoint;
use nalgebra::{Point3, Vector2};

/// A set of crops of many instances of one split, grouped by instance.
#[derive(Clone, Debug)]
pub struct ViewSet {
    /// The split all instances belong to.
    pub split: Split,
    /// The instances.
    pub instances: Vec<InstanceRecord>,
    /// The views, ordered by instance.
    pub views: Vec<View>,
}

/// What is known of an instance.
#[derive(Clone, Debug, PartialEq)]
pub struct InstanceRecord {
    /// Its identity.
    pub id: InstanceId,
    /// Name of its family. For tables; the models of the paper do not read it.
    pub family: String,
    /// Its symmetry about z.
    pub symmetry: Symmetry,
}

/// One crop of one instance.
#[derive(Clone, Debug)]
pub struct View {
    /// `beta`: index into [`ViewSet::instances`].
    pub instance: usize,
    /// Which lighting session it was taken in; sessions of one instance are numbered from 0.
    pub session: usize,
    /// `x_rel`.
    pub viewpoint: Viewpoint,
    /// Masked crop.
    pub crop: Crop,
    /// Visible share of the object's silhouette, in `[0, 1]`.
    pub visible_fraction: f64,
    /// Error of the box centre as a bearing to the object's centre: the two tangents of the measured ray less
    /// those of the true one, over the object's angular size. Fits the noise of the geometric measurement.
    pub box_center_error: [f64; 2],
    /// What odometry and the box say of it, where there was a robot's way: all that the viewpoint-predictive model's
    /// training reads of a view beside its crop.
    pub sighting: Option<Sighting>,
}

impl ViewSet {
    /// Instances that also occur in `other`: empty for properly split sets.
    pub fn shared_instances(&self, other: &ViewSet) -> Vec<InstanceId> {
        let known: std::collections::BTreeSet<_> = other.instances.iter().map(|i| i.id).collect();
        self.instances.iter().map(|i| i.id).filter(|id| known.contains(id)).collect()
    }
}

/// [`View::box_center_error`] of a measured ray `(x / z, y / z)`, camera frame.
pub fn box_center_error(measured: &Vector2<f64>, object_from_camera: &Pose, size: f64) -> [f64; 2] {
    let center = object_from_camera.inverse() * Point3::origin();
    let error = measured - center.coords.xy() / center.z;
    (error * center.coords.norm() / size).into()
}
