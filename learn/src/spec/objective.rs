//! The objectives of a training, and all that tells them apart.

use super::predictive::{Motion, PredictiveSpec, TrunkTarget};
use crate::role::Convention;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a training minimises.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Objective {
    /// `p(z | e, x_rel)` of III-A, by the bound of Eq. 12.
    #[default]
    ViewpointDependent,
    /// `p(z' | z, e, Delta X)` of III-B, by the bound of Eq. 20: from association and odometry alone.
    ViewpointPredictive,
    /// A rival: `p(z | c, x_rel)` of Eq. 8, a discrete class in place of the latent; reads the classes of all instances.
    DiscreteClass,
    /// A rival: a variational autoencoder of single crops, without viewpoints or association.
    Autoencoder,
    /// A rival: crops of one instance are pulled together and others pushed apart (InfoNCE), without viewpoints.
    Contrastive,
}

/// What tells an objective from the others.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Traits {
    /// What the networks are told of viewpoints, if anything.
    pub(crate) convention: Option<Convention>,
    /// What stage 1 learns: a task that serves the objective and reads no more than that may.
    pub(crate) task: Task,
    /// What stage 2 descends.
    pub(crate) loss: Loss,
}

/// What the head of stage 1 answers from `m(z)`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Task {
    /// The azimuth and the upright part of `x_rel`.
    Viewpoint,
    /// The change of azimuth between any two views of a session, and the upright part of `x_rel`, by odometry.
    Change,
    /// The camera's motion between two views of a session, by odometry: its turn to the left, and all of it.
    Motion,
    /// The crop's own image coefficients.
    Image,
    /// Which of the batch's crops is of the same instance.
    Instance,
}

/// The loss of stage 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Loss {
    /// The bound of Eq. 12 or Eq. 20, over several views of an instance.
    Bound,
    /// The same of single crops, of no known instance.
    BoundOfSingles,
    /// A classifier's, and the likelihood given the class.
    Class,
    /// InfoNCE.
    Contrast,
}

impl Objective {
    /// What tells it from the others, with the predictive model's own settings.
    pub(crate) fn traits(self, told: &PredictiveSpec) -> Traits {
        let (convention, task, loss) = match self {
            Objective::ViewpointDependent => {
                (Some(Convention::AzimuthHarmonics), Task::Viewpoint, Loss::Bound)
            }
            Objective::ViewpointPredictive => {
                let (convention, task) = match told.motion {
                    Motion::ObjectCentred | Motion::TrueObjectCentred => {
                        (Convention::ObjectCentredChange, Task::Change)
                    }
                    Motion::Camera => (Convention::CameraMotion, Task::Motion),
                };
                let knows = told.trunk == TrunkTarget::TrueViewpoints;
                (Some(convention), if knows { Task::Viewpoint } else { task }, Loss::Bound)
            }
            Objective::DiscreteClass => (Some(Convention::AzimuthHarmonics), Task::Viewpoint, Loss::Class),
            Objective::Autoencoder => (None, Task::Image, Loss::BoundOfSingles),
            Objective::Contrastive => (None, Task::Instance, Loss::Contrast),
        };
        Traits { convention, task, loss }
    }
}
