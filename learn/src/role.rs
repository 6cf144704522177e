//! What kinds of model there are, and which graphs each is made of.

use crate::onnx::{Signature, TensorSpec};
use serde::{Deserialize, Serialize};
use std::fmt;
use vantage_dataset::crop::CROP_SIDE;
use vantage_dataset::viewpoint::CONDITIONING;

/// Numbers of [`Convention::ObjectCentredChange`].
pub const OBJECT_CENTRED_CHANGE: usize = CONDITIONING + 4;
/// Numbers of [`Convention::CameraMotion`].
pub const CAMERA_MOTION: usize = 9;

/// What a model is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// `p(z | e, x_rel)` of Eq. 10: what a crop looks like, given the object and the viewpoint.
    ViewpointDependent,
    /// `p(z' | z, e, Delta X)` of Eq. 15-20: what a second crop looks like, given the first and the change of viewpoint.
    ViewpointPredictive,
    /// A vector of numbers for a crop, to be clustered and retrieved; an estimator has no use for it.
    Embedding,
}

/// What the numbers are that a network is told of the viewpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Convention {
    /// [`Viewpoint::conditioning`](vantage_dataset::Viewpoint::conditioning):
    /// `[cos ma, sin ma for m = 1..=5, sin elevation, cos roll, sin roll, log(distance / size)]` with azimuth `a`.
    AzimuthHarmonics,
    /// [`object_centred_change`](crate::object_centred_change): the harmonics of the change of azimuth, then elevation,
    /// roll and distance of the first view, then of the second.
    ObjectCentredChange,
    /// [`camera_motion`](crate::camera_motion): two columns of the rotation, and the translation, of
    /// `first_camera_from_second_camera`.
    CameraMotion,
}

/// A graph of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// `q(e | z, x_rel)`, or `q(e | z)`: crop, and conditioning, to mean and log variance of a view's factor on the
    /// latent. Of an embedding: crop to mean.
    Encoder,
    /// `m(z)`: crop to reduced measurement.
    Measurement,
    /// `p(m | e, x_rel)`: latent and conditioning to reduced measurement.
    Decoder,
    /// The decoder with its derivatives to the latent and to the conditioning.
    DecoderJacobian,
    /// `p(m' | m, e, Delta X)`: latent, measurement and change of viewpoint to the other view's measurement.
    Predictor,
    /// The predictor with its derivatives to all three.
    PredictorJacobian,
    /// The decoder, or the predictor, but to a whole crop.
    Image,
}

/// The sizes that decide the shapes of a model's tensors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sizes {
    /// Numbers in a latent.
    pub latent: usize,
    /// Numbers in the reduced measurement; 0 where there is none.
    pub measurement: usize,
    /// Numbers of the convention; 0 where there is none.
    pub conditioning: usize,
}

impl Kind {
    /// The graphs such a model has, and whether it must have them.
    pub fn roles(self) -> &'static [(Role, bool)] {
        match self {
            Kind::ViewpointDependent => &[
                (Role::Encoder, true),
                (Role::Measurement, true),
                (Role::Decoder, true),
                (Role::DecoderJacobian, false),
                (Role::Image, false),
            ],
            Kind::ViewpointPredictive => &[
                (Role::Encoder, true),
                (Role::Measurement, true),
                (Role::Predictor, true),
                (Role::PredictorJacobian, false),
                (Role::Image, false),
            ],
            Kind::Embedding => &[(Role::Encoder, true)],
        }
    }

    /// The conventions such a model may follow; none where it is told nothing.
    pub fn conventions(self) -> &'static [Convention] {
        match self {
            Kind::ViewpointDependent => &[Convention::AzimuthHarmonics],
            Kind::ViewpointPredictive => &[Convention::ObjectCentredChange, Convention::CameraMotion],
            Kind::Embedding => &[],
        }
    }

    /// The tensors of a role: `f32`, batch of 1, crops `[1, 3, 32, 32]` in `[0, 1]` (channel, row, column).
    ///
    /// `None` for a role that such a model has not.
    pub fn signature(self, role: Role, sizes: Sizes) -> Option<Signature> {
        self.roles().iter().find(|(own, _)| *own == role)?;
        let Sizes { latent, measurement, conditioning } = sizes;
        let row = |name, size| TensorSpec::new(name, &[1, size]);
        let derivative = |name, size| TensorSpec::new(name, &[measurement, size]);
        let crop = || TensorSpec::new("crop", &[1, 3, CROP_SIDE, CROP_SIDE]);
        let predictive = self == Kind::ViewpointPredictive;
        let known = || match predictive {
            false => vec![row("latent", latent), row("conditioning", conditioning)],
            true => {
                vec![row("latent", latent), row("measurement", measurement), row("change", conditioning)]
            }
        };
        let (inputs, outputs) = match role {
            Role::Encoder => {
                let viewpoint = (self == Kind::ViewpointDependent).then(|| row("conditioning", conditioning));
                let spread = (self != Kind::Embedding).then(|| row("log_variance", latent));
                (
                    [crop()].into_iter().chain(viewpoint).collect(),
                    [row("mean", latent)].into_iter().chain(spread).collect(),
                )
            }
            Role::Measurement => (vec![crop()], vec![row("measurement", measurement)]),
            Role::Decoder => (known(), vec![row("measurement", measurement)]),
            Role::DecoderJacobian => (
                known(),
                vec![
                    row("measurement", measurement),
                    derivative("d_latent", latent),
                    derivative("d_conditioning", conditioning),
                ],
            ),
            Role::Predictor => (known(), vec![row("other_measurement", measurement)]),
            Role::PredictorJacobian => (
                known(),
                vec![
                    row("other_measurement", measurement),
                    derivative("d_latent", latent),
                    derivative("d_measurement", measurement),
                    derivative("d_change", conditioning),
                ],
            ),
            Role::Image => (known(), vec![crop()]),
        };
        Some(Signature { inputs, outputs })
    }
}

impl Convention {
    /// Whether its first numbers are the harmonics of an angle by which a latent can turn.
    pub fn turns(self) -> bool {
        matches!(self, Convention::AzimuthHarmonics | Convention::ObjectCentredChange)
    }

    /// Numbers of the conditioning, or of the change.
    pub fn numbers(self) -> usize {
        match self {
            Convention::AzimuthHarmonics => CONDITIONING,
            Convention::ObjectCentredChange => OBJECT_CENTRED_CHANGE,
            Convention::CameraMotion => CAMERA_MOTION,
        }
    }
}

impl Role {
    /// Its name in a manifest.
    pub fn name(self) -> &'static str {
        match self {
            Role::Encoder => "encoder",
            Role::Measurement => "measurement",
            Role::Decoder => "decoder",
            Role::DecoderJacobian => "decoder_jacobian",
            Role::Predictor => "predictor",
            Role::PredictorJacobian => "predictor_jacobian",
            Role::Image => "image",
        }
    }

    /// The file that the trainer writes it to.
    pub fn file(self) -> String {
        format!("{}.onnx", self.name())
    }
}

impl fmt::Display for Role {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Kind::ViewpointDependent => "viewpoint_dependent",
            Kind::ViewpointPredictive => "viewpoint_predictive",
            Kind::Embedding => "embedding",
        })
    }
}

impl fmt::Display for Convention {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Convention::AzimuthHarmonics => "azimuth_harmonics",
            Convention::ObjectCentredChange => "object_centred_change",
            Convention::CameraMotion => "camera_motion",
        })
    }
}
